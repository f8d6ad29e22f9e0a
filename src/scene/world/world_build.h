/* The two halves of building a world: shapes become geometries (world.c), groups become instances
 * (world_place.c), whose origins world_origin.c chooses. */
#pragma once

#include "scene/graph.h"
#include "scene/world/world.h"

/* Appends the group's spheres and quads, and those of its meshes whose origin is `origin`, with coordinates
 * relative to it. False when out of memory. */
bool world_add_geometries(world *w, const scene_graph *graph, uint32_t group, vec3_f64 origin);
/* Counts primitives beyond WORLD_REACH or without area. Uses the known facts of meshes. */
void world_count(world *w);
/* Appends a single mesh, relative to its own origin. */
bool world_add_lone_mesh(world *w, fathom_id object);

/* The transform of a group at a time of the scene. `user` is the caller's pointer. */
typedef affine_f64 (*world_place_fn)(const void *user, double time);

/* Resamples the motion `place` of an instance to uniform steps: the fewest with an error of at most 2^-14 of
 * the radius of `inside`, the bounds of the moving geometry, plus rounding errors. At Embree's limit of steps
 * a larger error is accepted, and world_check() warns of it. Also sets the instance's maps. id: for messages.
 * FATHOM_BAD_INPUT if it rotates too fast for the steps. */
fathom_status world_add_motion(world *w, world_place_fn place, const void *user, const scene_bounds *inside,
                               const double *times, size_t time_count, fathom_id id,
                               world_instance *instance);
/* Resamples the vertices of a mesh with keys to uniform steps. facts->flat then becomes 0. If the mesh does
 * not move while the shutter is open, it becomes an ordinary mesh, with facts of its own. False when out of
 * memory. */
bool world_add_vertex_motion(world *w, world_geometry *geometry, fathom_mesh *mesh, mesh_facts *facts);
void world_motion_destroy(world *w);

/* True if a mesh of the scene, placed only once and by this map, can be transformed into the world, so that
 * it needs no instance. */
bool world_can_carry(const fathom_scene *scene, uint32_t index, const affine_f64 *to_world);
/* Makes a copy of the mesh, with its facts, in the world's coordinates; to_world maps to these. *fits is
 * false if the map has no inverse or a triangle loses its area. The world owns the arrays in any case. */
fathom_status world_carry_mesh(world *w, uint32_t index, const affine_f64 *to_world, fathom_mesh *mesh,
                               mesh_facts *facts, bool *fits);
/* Allocates `steps` rows of `count` floats each, and the padding that Embree may read. NULL when out of
 * memory. */
float *world_new_rows(size_t steps, size_t count);
/* Appends a mesh of the scene that is already in the world's coordinates. */
bool world_add_mesh(world *w, fathom_id object, const fathom_mesh *mesh, const mesh_facts *facts);

/* Sets the origin of each group's float coordinates, where it is not 0, and makes the bounds of the groups;
 * release these with free(). */
fathom_status world_choose_origins(const fathom_scene *scene, const scene_graph *graph, vec3_f64 *origins,
                                   scene_bounds **bounds);
/* Chooses origins, makes the groups and places them. origin: that of the root, or NULL to choose it too. */
fathom_status world_place(world *w, const scene_graph *graph, const vec3_f64 *origin);
