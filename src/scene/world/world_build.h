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

/* Where a group is placed at a time of the scene: `user` is the caller's. */
typedef affine_f64 (*world_place_fn)(const void *user, double time);

/* Finds the steps of an instance that moves through the places that the caller tells: as few as are needed to
 * be off by no more than 2^-14 of the size of `inside`, the bounds of what it moves. Sets the instance's
 * maps, too. id: for messages. */
fathom_status world_add_motion(world *w, world_place_fn place, const void *user, const scene_bounds *inside,
                               const double *times, size_t time_count, fathom_id id,
                               world_instance *instance);
/* Resamples the vertices of the mesh of `geometry`, which has keys; its facts stay those of the scene's. */
bool world_add_vertex_motion(world *w, world_geometry *geometry, fathom_mesh *mesh, mesh_facts *facts);
void world_motion_destroy(world *w);

/* True where a mesh of the scene, placed by this map and nowhere else, needs no frame. */
bool world_can_carry(const fathom_scene *scene, uint32_t index, const affine_f64 *to_world);
/* Makes the mesh, and its facts, as it lies in the world; to_world goes to the world's coordinates. *fits is
 * false where a triangle has lost its area by it. The arrays are the world's in any case. */
fathom_status world_carry_mesh(world *w, uint32_t index, const affine_f64 *to_world, fathom_mesh *mesh,
                               mesh_facts *facts, bool *fits);
/* Memory for steps of `count` floats each, and what Embree may read beyond them. */
float *world_new_rows(size_t steps, size_t count);
/* Appends a mesh of the scene as it is in the world. */
bool world_add_mesh(world *w, fathom_id object, const fathom_mesh *mesh, const mesh_facts *facts);

/* Chooses origins, makes the groups and places them. origin: the root's, or NULL to choose it, too. */
fathom_status world_place(world *w, const scene_graph *graph, const vec3_f64 *origin);

#endif
