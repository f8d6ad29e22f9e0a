/* Builds test scenes. `status` keeps the first failure, and all later calls do nothing, so callers need not
 * check each call. */
#pragma once

#include "math/affine.h"

#include <fathom/scene.h>

typedef struct builder {
    fathom_context *context;
    fathom_scene *scene;
    fathom_status status;
    fathom_id group; /* group of the shapes added next; FATHOM_ROOT at first */
    uint32_t flags;  /* flags of these shapes */
} builder;

/* Makes an empty scene. Release it with fathom_scene_destroy(), also after a failure. */
void build_open(fathom_context *context, builder *out);
/* Completes and checks the scene. */
void build_finish(builder *b);

/* ---- materials ---- */

void build_rgb(float out[3], vec3_f64 rgb);
fathom_material build_lambert(vec3_f64 k_d);
fathom_material build_black(void);
/* Black, with emission k_e. */
fathom_material build_emitter(vec3_f64 k_e);
fathom_id build_material(builder *b, fathom_material m);

/* ---- shapes: build_ functions take a material of the scene, paint_ functions add their own ---- */

void build_sphere(builder *b, vec3_f64 center, double radius, fathom_id material);
void build_plane(builder *b, vec3_f64 point, vec3_f64 normal, fathom_id material);
void build_quad(builder *b, vec3_f64 center, vec3_f64 u, vec3_f64 v, fathom_id material);
void build_mesh(builder *b, fathom_mesh mesh, fathom_id material);
/* A mesh without normals. Positions are relative to `origin`. */
void build_triangles(builder *b, vec3_f64 origin, const vec3_f64 *positions, uint32_t vertices,
                     const uint32_t *indices, uint32_t triangles, fathom_id material);
void paint_sphere(builder *b, vec3_f64 center, double radius, fathom_material m);
void paint_plane(builder *b, vec3_f64 point, vec3_f64 normal, fathom_material m);
void paint_quad(builder *b, vec3_f64 center, vec3_f64 u, vec3_f64 v, fathom_material m);

fathom_id build_group(builder *b);
void build_instance(builder *b, const fathom_instance *instance);
void build_place(builder *b, fathom_id group, fathom_id parent, const affine_f64 *map);

/* ---- light and camera ---- */

/* A light with this position and direction; types that have no such thing ignore it. */
fathom_light build_light_of(fathom_light_type type, vec3_f64 at, vec3_f64 direction, vec3_f64 intensity);
void build_light(builder *b, const fathom_light *light);
void build_point_light(builder *b, vec3_f64 at, vec3_f64 intensity, double radius);
/* radius: half of its angle. */
void build_directional_light(builder *b, vec3_f64 direction, vec3_f64 intensity, double radius);
void build_background(builder *b, vec3_f64 rgb);
void build_camera(builder *b, fathom_camera camera);
/* A camera that looks from one point at another, upright along +y. */
fathom_camera build_view(vec3_f64 eye, vec3_f64 target, double fovy);
