#include "integrate/path/path.h"

#include <string.h>

static void fill(float *to, size_t count, float value) {
    for (size_t k = 0; k < count; ++k) to[k] = value;
}

static void begin_keys(path_wave *p, const wave_batch *batch) {
    const render_plan *plan = p->wave.run.plan;
    for (uint32_t s = 0; s < batch->count; ++s) {
        const sample_key first = wave_square_key(&batch->squares[s], 0);
        plan->sample_kernels->square(&plan->sampler, first.x, first.y, &p->pixel[s * LANES]);
        for (uint32_t k = 0; k < LANES; ++k) p->index[s * LANES + k] = first.index;
        for (uint32_t k = 0; p->wave.times && k < LANES; ++k)
            p->wave.times[s * LANES + k] = wave_time_of(plan, wave_square_key(&batch->squares[s], k));
    }
}

void path_begin(path_wave *p, const wave_batch *batch) {
    const render_plan *plan = p->wave.run.plan;
    const size_t count = batch->count * LANES;
    begin_keys(p, batch);
    fill(p->density, count, INFINITY);
    for (int c = 0; c < 3; ++c) fill(p->n[c], count, 0);
    fill(p->width, count, plan->pixel_width);
    fill(p->spread, count, plan->pixel_spread);
    fill(p->passed, count, 0);
    if (plan->caustics) fill(p->chain, count, 0);
    memset(p->passes, 0, count * sizeof *p->passes);
    memset(p->paned, 0, count * sizeof *p->paned);
    for (size_t k = 0; p->wave.run.samples.first && k < count; ++k) {
        p->smooth[k] = true;
        p->tint[0][k] = p->tint[1][k] = p->tint[2][k] = 1;
    }
    if (plan->dispersive) memset(p->channel, 0, sizeof p->channel);
}

/* The distance from the eye at which a ray of a camera far away starts. */
static float skipped(const path_wave *p, uint32_t slot, vec3_f32 org) {
    const render_plan *plan = p->wave.run.plan;
    shade_camera camera = plan->camera;
    if (plan->camera_moves) wave_camera_when(plan, p->wave.times[slot], &camera);
    return (float)length_f64(sub_f64(widen(org), camera.exact_eye));
}

/* Each path starts where its ray does, such as at a point of the lens. Its way begins at the camera's near
 * plane. */
static void begin_at_origins(path_wave *p) {
    const path_queue *now = &p->wave.now;
    for (size_t k = 0; k < now->count; ++k) {
        const uint32_t slot = now->paths[k / LANES].slot[k % LANES];
        const vec3_f32 org = trace_org(&now->rays[k / LANES].rays, k % LANES);
        p->p[0][slot] = org.x, p->p[1][slot] = org.y, p->p[2][slot] = org.z;
        if (p->wave.run.plan->far) p->width[slot] += p->spread[slot] * skipped(p, slot, org);
        if (p->wave.run.plan->camera.clips) p->passed[slot] = now->rays[k / LANES].rays.t_near[k % LANES];
    }
}

static void begin_in_volumes(path_wave *p) {
    const render_plan *plan = p->wave.run.plan;
    const path_queue *now = &p->wave.now;
    eye_volumes around = plan->eye_volumes;
    for (size_t k = 0; k < now->count; ++k) {
        const uint32_t slot = now->paths[k / LANES].slot[k % LANES];
        if (plan->volumes_differ)
            eye_volumes_find(plan, wave_start(&now->rays[k / LANES].rays, k % LANES),
                             p->wave.times ? p->wave.times[slot] : 0, &around);
        media_begin(p->media, slot, around.of, around.count);
    }
}

void path_begin_rays(path_wave *p) {
    begin_at_origins(p);
    if (p->media) begin_in_volumes(p);
}
