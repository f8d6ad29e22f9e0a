/* What this scene needs, and nothing else: computed once before rendering. */
#ifndef INTEGRATE_PLAN_H
#define INTEGRATE_PLAN_H

#include "camera/camera.h"
#include "camera/filter.h"
#include "film/pixel_sums.h"
#include "integrate/kernels.h"
#include "integrate/parts.h"
#include "integrate/path_kernels.h"
#include "light/emitters.h"
#include "material/textured.h"
#include "sample/sample.h"
#include "scene/light_groups.h"
#include "surface/kernels.h"
#include "trace/watertight/watertight.h"

typedef struct integrator integrator;

/* Materials of volumes, the innermost last. */
enum { EYE_VOLUMES = 8 };
typedef struct eye_volumes {
    uint32_t count, of[EYE_VOLUMES];
} eye_volumes;

typedef struct render_plan {
    const fathom_scene *scene;
    const world *world;
    const trace_tracer *tracer;
    fathom_settings settings;
    const integrator *integrator;
    const camera_kernels *camera_kernels;
    const surface_kernels *surface_kernels;
    const material_kernels *material_kernels;
    const light_kernels *light_kernels;
    const sample_kernels *sample_kernels;
    const shader_kernels *shader_kernels;
    const integrate_kernels *kernels;
    const path_kernels *path_kernels;
    sampler sampler;
    shade_camera camera;
    pixel_filter filter;
    shader *shaders;                   /* by material; path tracing */
    texturing *texturing;              /* NULL: no material varies over a surface */
    bool moves, camera_moves;          /* path tracing, while the shutter is open: something; the camera */
    float pixel_spread;                /* angle of the cone around a camera ray, */
    float pixel_width;                 /* and its radius where it begins */
    emitters *emitters;                /* path tracing */
    struct reference_scene *reference; /* the reference integrator */
    bsdf *bsdfs;                       /* by material; the classic integrator, and all that follows */
    shade_light *lights;
    uint32_t light_count;
    watertight *watertight; /* NULL: no answer of the tracer needs another look */
    /* Closed meshes around the camera and around each light, where it is in use; WATERTIGHT_UNSURE: the light
     * lies in a mesh, and which side its rays end on depends on where they come from. */
    uint8_t eye_depth, *light_depths;
    bool eyes_differ;                 /* each ray of the camera has a depth of its own */
    light_surface *light_surfaces;    /* what lights[].surfaces point to */
    unsigned features;                /* MATERIAL_ bits of the materials in use */
    bool background;                  /* it is not black */
    film_parts parts;                 /* what the AOVs are made of */
    light_groups groups;              /* none unless AOVs ask for them */
    uint32_t *matte_ids[MATTE_KINDS]; /* by object and by material; NULL: not asked for */
    uint8_t *light_group_of;          /* by light; the classic integrator */
    uint32_t max_depth;               /* 0 when nothing mirrors or refracts */
    float t_near;                     /* 0, or the fixed epsilon */
    bool lifts;                       /* shadow rays of smooth meshes begin above their facets */
    bool crosses;                     /* paths may go on behind a surface */
    bool absorbs;                     /* some volume does */
    bool nested;                      /* some volume has a priority */
    eye_volumes eye_volumes;          /* around the camera as the shutter opens, where paths know volumes */
    bool dispersive;                  /* some volume parts the colours */
    bool covered;                     /* path tracing: some surface is there in part */
    bool unshadowed;                  /* path tracing: some shape casts no shadow */
} render_plan;

/* Release with plan_destroy(). */
fathom_status plan_create(fathom_context *context, const world *w, const trace_tracer *tracer,
                          const fathom_settings *settings, render_plan **out);
void plan_destroy(render_plan *plan);

/* Traces a ray from the eye with the plan's tracer; the plan's shaders must exist. All rays of an
 * orthographic camera or of a lens are taken to start in the same volumes. */
void eye_volumes_find(const render_plan *plan, eye_volumes *out);

/* Rays a render with these settings is expected to trace, within a factor of a few: for the build quality. */
uint64_t plan_expected_rays(const fathom_scene *scene, const fathom_settings *settings);

#endif
