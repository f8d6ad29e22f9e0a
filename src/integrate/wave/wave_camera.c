#include "integrate/wave/wave.h"

#include <math.h>

/* Two numbers of each pixel; SAMPLE_PIXEL only for the Sobol pattern. */
static void numbers(const render_plan *plan, const wave_square *s, sample_dimension dimension,
                    double u[LANES], double v[LANES]) {
    const sample_key first = wave_square_key(s, 0);
    uint64_t pixel[LANES];
    plan->sample_kernels->square(&plan->sampler, first.x, first.y, pixel);
    plan->sample_kernels->places(pixel, first.index, dimension, u, v);
}

static void place(const render_plan *plan, const wave_square *s, square_samples *out) {
    out->alike = plan->settings.pattern == FATHOM_PATTERN_GRID;
    const uint32_t count = out->alike ? 1 : LANES;
    const bool sobol = plan->settings.pattern == FATHOM_PATTERN_SOBOL;
    if (sobol) numbers(plan, s, SAMPLE_PIXEL, out->x, out->y);
    for (uint32_t k = 0; !sobol && k < count; ++k)
        sample_2d(&plan->sampler, wave_square_key(s, k), SAMPLE_PIXEL, &out->x[k], &out->y[k]);
    for (uint32_t k = 0; !plan->filter.box && k < count; ++k) {
        out->x[k] = filter_place(&plan->filter, out->x[k]);
        out->y[k] = filter_place(&plan->filter, out->y[k]);
    }
}

float wave_time_of(const render_plan *plan, sample_key key) {
    double u, v;
    if (!plan->settings.motion_blur) return 0.5f;
    sample_2d(&plan->sampler, key, SAMPLE_TIME, &u, &v);
    return (float)(u * (1 - 0x1p-24)); /* the float stays below 1 */
}

void wave_camera_when(const render_plan *plan, float time, shade_camera *out) {
    const fathom_camera *camera = &plan->scene->camera;
    const double *shutter = camera->shutter;
    const fathom_camera at = motion_camera(camera, shutter[0] + (double)time * (shutter[1] - shutter[0]));
    camera_prepare(&at, plan->settings.width, plan->settings.height, plan->world->origin, out);
}

static void set_ray(vec3_f32 org, vec3_f32 dir, float t_near, trace_rays *out, uint32_t k) {
    out->org_x[k] = org.x, out->org_y[k] = org.y, out->org_z[k] = org.z;
    out->dir_x[k] = dir.x, out->dir_y[k] = dir.y, out->dir_z[k] = dir.z;
    out->t_near[k] = t_near, out->t_far[k] = INFINITY;
}

/* A ray of a camera far away starts just before the scene; u, v: the point on the lens. */
static void far_ray(const render_plan *plan, const shade_camera *camera, const double at[2],
                    const double lens[2], trace_rays *out, uint32_t k) {
    vec3_f64 org, dir;
    camera_exact_ray(camera, at[0], at[1], lens[0], lens[1], &org, &dir);
    const double start = trace_approach_start(&plan->approach, org, dir, 0);
    set_ray(narrow(madd_f64(org, start, dir)), narrow(dir), (float)fmax((double)plan->t_near - start, 0), out,
            k);
}

static void near_ray(const render_plan *plan, const shade_camera *camera, const double at[2],
                     const double lens[2], trace_rays *out, uint32_t k) {
    vec3_f32 org, dir;
    camera_ray(camera, at[0], at[1], &org, &dir);
    set_ray(org, dir, plan->t_near, out, k);
    if (camera->lens_radius > 0) camera_lane_through_lens(camera, lens[0], lens[1], out, k);
}

/* Limits the ray to what lies between the camera's clip planes. */
static void clip(const render_plan *plan, const shade_camera *camera, trace_rays *rays, uint32_t k) {
    const vec3_f64 from = sub_f64(widen(trace_org(rays, k)), plan_eye(plan, camera)),
                   dir = widen(trace_dir(rays, k));
    rays->t_near[k] = fmaxf(rays->t_near[k], (float)camera_way_to(camera, camera->near_clip, from, dir));
    rays->t_far[k] = (float)fmax(camera_way_to(camera, camera->far_clip, from, dir), 0);
}

/* Makes rays one by one: if the camera moves, each uses the camera at its own time. */
static void single_rays(const render_plan *plan, const wave_square *s, const square_samples *samples,
                        trace_rays *out) {
    shade_camera camera = plan->camera;
    for (uint32_t k = 0; k < LANES; ++k) {
        const sample_key key = wave_square_key(s, k);
        if (plan->camera_moves) wave_camera_when(plan, wave_time_of(plan, key), &camera);
        const uint32_t from = samples->alike ? 0 : k;
        const double at[2] = {(double)(int32_t)(s->left + k % 4) + samples->x[from],
                              (double)(int32_t)(s->top + k / 4) + samples->y[from]};
        double lens[2] = {0, 0};
        if (camera.lens_radius > 0) sample_2d(&plan->sampler, key, SAMPLE_LENS, &lens[0], &lens[1]);
        (plan->far ? far_ray : near_ray)(plan, &camera, at, lens, out, k);
        if (camera.clips) clip(plan, &camera, out, k);
    }
}

static void camera_rays(const render_plan *plan, const wave_square *s, const square_samples *at,
                        trace_rays *out) {
    if (plan->camera_moves || plan->far) {
        single_rays(plan, s, at, out);
        return;
    }
    plan->camera_kernels->rays(&plan->camera, plan->t_near, s->left, s->top, at, out);
    if (plan->camera.lens_radius > 0) {
        double u[LANES], v[LANES];
        numbers(plan, s, SAMPLE_LENS, u, v);
        plan->camera_kernels->lens(&plan->camera, u, v, out);
    }
    for (uint32_t k = 0; plan->camera.clips && k < LANES; ++k) clip(plan, &plan->camera, out, k);
}

vec3_f32 wave_start(const trace_rays *rays, size_t i) {
    return madd_f32(trace_org(rays, i), rays->t_near[i], trace_dir(rays, i));
}

void wave_square_rays(const render_plan *plan, const wave_square *s, trace_rays *out) {
    square_samples at;
    place(plan, s, &at);
    camera_rays(plan, s, &at, out);
}

static uint8_t depth_at(const render_plan *plan, const trace_rays *rays, size_t i) {
    return plan->depths_differ ? watertight_depth(plan->watertight, wave_start(rays, i)) : plan->eye_depth;
}

/* A packet of 16 rays is a square: its rays stay coherent longer than those of a line. first: the slot of the
 * square's first pixel. */
static void push_whole(wave *w, const wave_square *s, uint32_t first, const square_samples *at) {
    camera_rays(w->run.plan, s, at, &w->now.rays[w->now.count / LANES].rays);
    w->run.plan->kernels->begin_paths(first, w->run.plan->eye_depth, &w->now.paths[w->now.count / LANES]);
    const trace_rays *rays = &w->now.rays[w->now.count / LANES].rays;
    for (uint32_t k = 0; w->run.plan->depths_differ && k < LANES; ++k)
        w->now.paths[w->now.count / LANES].depth[k] = depth_at(w->run.plan, rays, k);
    w->now.count += LANES;
}

static void push_pixel(wave *w, uint32_t slot, const trace_rays *from, uint32_t i) {
    size_t lane = w->now.count % LANES;
    path_block *path = &w->now.paths[w->now.count / LANES];
    trace_rays_move(from, i, &w->now.rays[w->now.count / LANES].rays, lane);
    for (int c = 0; c < 3; ++c) path->weight[c][lane] = 1;
    path->slot[lane] = slot;
    path->depth[lane] = depth_at(w->run.plan, from, i);
    ++w->now.count;
}

static void push_partial(wave *w, const wave_region *region, const wave_square *s, uint32_t first,
                         const square_samples *at) {
    trace_rays rays;
    camera_rays(w->run.plan, s, at, &rays);
    for (uint32_t left = wave_square_pixels(region, s); left; left &= left - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(left);
        push_pixel(w, first + i, &rays, i);
    }
}

static void push_squares(wave *w, const wave_region *region, const wave_batch *batch, bool whole) {
    square_samples at;
    for (uint32_t i = 0; i < batch->count; ++i) {
        const wave_square *s = &batch->squares[i];
        if (wave_square_is_whole(region, s) != whole) continue;
        place(w->run.plan, s, &at);
        if (whole)
            push_whole(w, s, i * LANES, &at);
        else
            push_partial(w, region, s, i * LANES, &at);
    }
}

/* Partial squares at image borders come after the whole ones, which fill whole blocks. */
bool wave_camera_rays(wave *w, const wave_region *region, const wave_batch *batch) {
    w->now.count = 0;
    if (!wave_reserve_paths(w, &w->now, WAVE_SLOTS)) return false;
    push_squares(w, region, batch, true);
    push_squares(w, region, batch, false);
    w->run.rays.camera += w->now.count;
    return true;
}
