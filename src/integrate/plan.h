/* Everything that rendering this scene needs: computed once before rendering. */
#pragma once

#include "camera/camera.h"
#include "camera/filter.h"
#include "film/pixel_sums.h"
#include "integrate/kernels.h"
#include "integrate/parts.h"
#include "integrate/path/path_kernels.h"
#include "light/emitters.h"
#include "material/textured.h"
#include "sample/sample.h"
#include "scene/light_groups.h"
#include "surface/kernels.h"
#include "trace/approach.h"
#include "trace/watertight/watertight.h"

#include <stdatomic.h>

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
    shader *shaders;           /* by material; path tracing */
    texturing *texturing;      /* NULL: no material varies over a surface */
    bool moves, camera_moves;  /* path tracing: something moves while the shutter is open; the camera does */
    trace_approach approach;   /* set if `far`: camera rays start just before the scene, */
    bool far;                  /* because the camera is far away */
    float pixel_spread;        /* angle of the cone around a camera ray, */
    float pixel_width;         /* and its radius at the origin */
    emitters *emitters;        /* path tracing */
    struct caustics *caustics; /* path tracing; NULL: there are none */
    struct reference_scene *reference; /* the reference integrator */
    bsdf *bsdfs;                       /* by material; classic integrator, as are lights and light_count */
    shade_light *lights;
    uint32_t light_count;
    watertight *watertight; /* NULL: no result of the tracer needs repair */
    /* Number of closed meshes around the camera and around each light, if `watertight` is in use;
     * WATERTIGHT_UNSURE: the light lies in a mesh's surface, and the side on which its rays end depends on
     * their origin. */
    uint8_t eye_depth, *light_depths;
    bool depths_differ;               /* camera rays may start at different ones */
    light_surface *light_surfaces;    /* lights[].surfaces point to these */
    unsigned features;                /* MATERIAL_ bits of the materials in use */
    bool background;                  /* it is not black */
    film_parts parts;                 /* the components of the AOVs */
    light_groups groups;              /* none unless AOVs request them */
    uint32_t *matte_ids[MATTE_KINDS]; /* matte_ids(); NULL: not requested */
    uint8_t *light_group_of;          /* by light; the classic integrator */
    uint32_t max_depth;               /* 0 when nothing mirrors or refracts */
    float t_near;                     /* 0, or the fixed epsilon */
    bool lifts;                       /* light reaches smooth meshes from below their facets' horizons */
    bool crosses;                     /* paths may continue behind a surface */
    bool absorbs;                     /* some volume absorbs light */
    bool nested;                      /* some volume has a priority */
    eye_volumes eye_volumes;          /* around the camera, if paths track volumes */
    bool volumes_differ;              /* camera rays may start in different ones */
    bool dispersive;                  /* some volume disperses light */
    bool covered;   /* path tracing: light may pass some surface straight, or volumes have priorities */
    bool one_sided; /* path tracing: the camera looks through the back of some surface */
    bool to_camera; /* for photons: shadow rays lead to the camera, which looks through the backs of one-sided
                       surfaces */
    bool panes;     /* path tracing: some surface may be a clear thin wall */
    double photon_seconds; /* path tracing: that finding caustics took */
    bool unshadowed;       /* path tracing: some shape casts no shadow */
} render_plan;

/* Between the making of a plan and other threads. */
typedef struct plan_watch {
    atomic_bool stop;       /* set by others: the plan must not be used */
    _Atomic double photons; /* the part of all photons that are traced; 0 before the first */
} plan_watch;

/* Release with plan_destroy(). Traces rays, also on further threads. textures: of the scene; the plan owns
 * them, also on failure; NULL: it opens them. watch may be NULL. */
fathom_status plan_create(fathom_context *context, const world *w, const trace_tracer *tracer,
                          const fathom_settings *settings, texture_cache *textures, plan_watch *watch,
                          render_plan **out);
void plan_destroy(render_plan *plan);

/* The camera's position from which rays, depths and motion vectors count. */
static inline vec3_f64 plan_eye(const render_plan *plan, const shade_camera *camera) {
    return plan->far ? camera->exact_eye : widen(camera->eye);
}

/* The volumes around a point. Traces a ray from there with the plan's tracer; the plan's shaders must exist.
 * time: 0 when the shutter opens, 1 when it closes. */
void eye_volumes_find(const render_plan *plan, vec3_f32 eye, float time, eye_volumes *out);
/* Whether some of 256 camera rays over image, lens and time start in others than plan->eye_volumes, or at
 * another depth than plan->eye_depth. Rarer rays, of which none is among these, are treated as starting
 * like the others. */
bool eye_volumes_differ(const render_plan *plan);
bool eye_depths_differ(const render_plan *plan);

/* A plan for paths before the image: no AOVs, and other random numbers, because these paths decide how the
 * image is sampled, or add to it. */
render_plan plan_before(const render_plan *plan, uint64_t other_seed);

/* Samples of a pixel that a render with these settings is expected to take. */
uint32_t plan_expected_spp(const fathom_settings *settings);
/* Rays it is expected to trace, within a factor of a few: for the build quality. */
uint64_t plan_expected_rays(const fathom_scene *scene, const fathom_settings *settings);

/* Traces scout paths, a few paths before the render that find out which light the scene blocks, so that light
 * samples can avoid it, and passes the results to the plan's emitters; everything else in the plan must be
 * set. The paths depend only on the scene, the whole image, its number of samples and the seed. They end
 * early if *stop becomes true. */
fathom_status path_scout_lights(fathom_context *context, render_plan *plan, const atomic_bool *stop);
