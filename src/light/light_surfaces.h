/* Finds the surfaces that hold a light, or nearly do: light/kernels/light.c ends shadow rays clear of
 * them. */
#ifndef LIGHT_LIGHT_SURFACES_H
#define LIGHT_LIGHT_SURFACES_H

#include "light/light.h"
#include "scene/world/world.h"

/* The most of one light: the nearest are kept. Twenty triangles meet in a vertex of a fine mesh at worst. */
#define LIGHT_SURFACES_MOST 32

/* Sets surfaces and surface_count of the lights, which stay valid until *out is freed; NULL when there is
 * none. eye: the camera's place in the world. in_mesh, a flag for each light: whether a mesh holds it. */
fathom_status light_surfaces_find(fathom_context *context, const world *w, vec3_f32 eye, shade_light *lights,
                                  uint32_t count, bool *in_mesh, light_surface **out);

#endif
