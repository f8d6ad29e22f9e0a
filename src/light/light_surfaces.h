/* Finds the surfaces that hold a light or are very close to it: light/kernels/light.c ends shadow rays clear
 * of them. */
#pragma once

#include "light/light.h"
#include "scene/world/world.h"

/* Maximum number per light; the nearest are kept. At worst, twenty triangles meet in a vertex of a fine
 * mesh. */
#define LIGHT_SURFACES_MOST 32

/* Sets surfaces and surface_count of the lights; they stay valid until the caller frees *out, which is NULL
 * if there are none. eye: the camera's position in world space. in_mesh, a flag per light: set if a mesh
 * holds the light. */
fathom_status light_surfaces_find(fathom_context *context, const world *w, vec3_f32 eye, shade_light *lights,
                                  uint32_t count, bool *in_mesh, light_surface **out);
