/* The two halves of making a world: shapes into geometries (world.c), groups into instances (world_place.c).
 */
#ifndef SCENE_WORLD_BUILD_H
#define SCENE_WORLD_BUILD_H

#include "scene/graph.h"
#include "scene/world/world.h"

/* Appends the group's spheres, quads, and those of its meshes that lie at `origin`, relative to it. False
 * when out of memory. */
bool world_add_geometries(world *w, const scene_graph *graph, uint32_t group, vec3_f64 origin);
/* Counts what lies beyond reach or has no area, by the facts that are known of meshes. */
void world_count(world *w);
/* Appends a mesh alone, relative to its own origin. */
bool world_add_lone_mesh(world *w, fathom_id object);

/* Chooses origins, makes the groups and places them. origin: the root's, or NULL to choose it, too. */
fathom_status world_place(world *w, const scene_graph *graph, const vec3_f64 *origin);

#endif
