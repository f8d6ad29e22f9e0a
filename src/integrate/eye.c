/* The volumes and closed meshes that contain the camera. A ray from the eye hits the inner sides of their
 * surfaces. */
#include "integrate/wave/wave.h"

#include <math.h>
#include <string.h>

/* A direction that is not parallel to an axis, because many surfaces are, and that hits no edge of a box
 * around the eye. */
static const vec3_f32 direction = {0.36f, 0.80f, 0.48f};

/* Maximum number of surfaces that the ray passes. */
enum { SURFACES = 4096 };

/* The next hit beyond the block's t_near, which moves to the hit. False: none. */
static bool meet_next(const render_plan *plan, trace_block *block, surface_block *s) {
    surface_gather g;
    block->rays.t_far[0] = INFINITY;
    trace_closest(plan->tracer, block, 1, TRACE_INCOHERENT);
    if (block->hits.geometry[0] == FATHOM_NONE) return false;
    surface_gather_begin(&g);
    surface_gather_add(&g, plan->world, block, 0);
    s->material[0] = surface_gather_material(&g, plan->world, 0);
    s->count = 1;
    surface_gather_end(&g, plan->world, plan->surface_kernels, false, true, s);
    block->rays.t_near[0] = nextafterf(block->rays.t_far[0], INFINITY);
    return true;
}

/* A hit on the inner side of a surface leaves a volume. If the ray has not entered this volume, it contains
 * the eye. The first such volume is the innermost. */
static void pass_surface(eye_volumes *v, eye_volumes *entered, uint32_t material, bool entering) {
    uint32_t k = entered->count;
    if (entering) {
        if (entered->count < EYE_VOLUMES) entered->of[entered->count++] = material;
        return;
    }
    while (k && entered->of[k - 1] != material) --k;
    if (k) {
        memmove(entered->of + k - 1, entered->of + k, (entered->count - k) * sizeof *entered->of);
        --entered->count;
    } else if (v->count < EYE_VOLUMES) {
        memmove(v->of + 1, v->of, v->count++ * sizeof *v->of);
        v->of[0] = material;
    }
}

void eye_volumes_find(const render_plan *plan, vec3_f32 eye, float time, eye_volumes *out) {
    eye_volumes entered = {.count = 0};
    trace_block block;
    surface_block s;
    memset(&block, 0, sizeof block), memset(&s, 0, sizeof s);
    block.rays.org_x[0] = eye.x, block.rays.org_y[0] = eye.y, block.rays.org_z[0] = eye.z;
    block.rays.time[0] = time;
    block.rays.dir_x[0] = direction.x, block.rays.dir_y[0] = direction.y, block.rays.dir_z[0] = direction.z;
    *out = entered;
    const unsigned state = trace_thread_begin();
    for (int i = 0; i < SURFACES && meet_next(plan, &block, &s); ++i) {
        if (plan->shaders[s.material[0]].encloses)
            pass_surface(out, &entered, s.material[0], s.entering[0] != 0);
    }
    trace_thread_end(state);
}

/* From the first to the last square along a side, in equal steps. */
static uint32_t corner(uint32_t side, uint32_t step, uint32_t steps) {
    return (side - 1) / 4 * step / (steps - 1) * 4;
}

/* True if `holds` is true for the origin of any of 256 camera rays, spread over the image. */
static bool any_start(const render_plan *plan,
                      bool (*holds)(const render_plan *plan, vec3_f32 eye, float time)) {
    enum { STEPS = 4 };
    for (uint32_t i = 0; i < STEPS * STEPS; ++i) {
        const wave_square square = {corner(plan->settings.width, i % STEPS, STEPS),
                                    corner(plan->settings.height, i / STEPS, STEPS), i, 0};
        trace_rays rays;
        wave_square_rays(plan, &square, &rays);
        for (uint32_t k = 0; k < LANES; ++k)
            if (holds(plan, wave_start(&rays, k), wave_time_of(plan, wave_square_key(&square, k))))
                return true;
    }
    return false;
}

static bool has_other_volumes(const render_plan *plan, vec3_f32 eye, float time) {
    eye_volumes around;
    eye_volumes_find(plan, eye, time, &around);
    return around.count != plan->eye_volumes.count ||
           memcmp(around.of, plan->eye_volumes.of, around.count * sizeof *around.of) != 0;
}

bool eye_volumes_differ(const render_plan *plan) { return any_start(plan, has_other_volumes); }

static bool has_other_depth(const render_plan *plan, vec3_f32 eye, float time) {
    (void)time;
    return watertight_depth(plan->watertight, eye) != plan->eye_depth;
}

bool eye_depths_differ(const render_plan *plan) { return any_start(plan, has_other_depth); }
