/* Rays from the vertices of photons to the camera. A vertex is a surface point twice: as the photon sees it,
 * and as the camera does, whose view decides about its BSDF. */
#include "integrate/caustics/photons.h"

#include "math/limit.h"

#include <math.h>
#include <string.h>

/* The lanes' points in the camera's view. */
typedef struct camera_views {
    emitter_sample to;   /* direction to the start of the camera's ray, or where it passes the near plane */
    float width[LANES];  /* of the camera's cone at the point */
    double view[LANES];  /* caustic_view() */
    double scale[LANES]; /* the filter's density in the pixel, over the probability of the pixel's choice */
    uint32_t pixel[LANES];
} camera_views;

/* Lanes whose photons may end here. */
static uint32_t lanes_to_end(const photon_wave *w, const vertex_block *v) {
    const path_wave *p = w->path;
    const render_plan *plan = p->wave.run.plan;
    uint32_t lanes = 0;
    for (unsigned i = 0; i < v->surface.count; ++i) {
        const uint32_t before = path_scattered(p, v->path.slot[i]);
        const fathom_id material = v->surface.material[i];
        if (!before || before >= plan->max_depth || !w->caustics->ends[material]) continue;
        if (!caustic_begins(plan, &plan->shaders[material])) continue;
        lanes |= 1u << i;
    }
    return lanes;
}

/* The vector to the lane's point from where the camera's ray starts: the eye, a point on the lens, or one of
 * the plane of an orthographic camera. */
static vec3_f64 way_of_ray(const shade_camera *camera, vec3_f64 from_eye, unsigned i, const lanes3 u) {
    double x, y;
    if (camera->parallel) return scale_f64(dot_f64(from_eye, camera->view), camera->view);
    if (!(camera->lens_radius > 0)) return from_eye;
    camera_lens_point(camera, (double)u[0][i], (double)u[1][i], &x, &y);
    const vec3_f64 on_lens = add_f64(scale_f64(camera->lens_radius * x, camera->right),
                                     scale_f64(camera->lens_radius * y, camera->up));
    return sub_f64(from_eye, on_lens);
}

/* Chooses one of the pixels whose filter holds the place x of the image, in proportion to the filter; u: a
 * number in [0,1). Returns the sum of the filter's densities there, 0 if there are none. */
static double choose_pixel(const pixel_filter *f, double x, double u, int64_t *out) {
    enum { MOST = 18 }; /* filters are at most 16 pixels wide */
    const int64_t first = (int64_t)floor(x) - MOST / 2;
    double sum = 0, sums[MOST];
    if (f->box) {
        *out = (int64_t)floor(x);
        return 1;
    }
    for (int k = 0; k < MOST; ++k) sums[k] = sum += filter_density(f, x - (double)(first + k));
    for (int k = 0; k < MOST; ++k) {
        *out = first + k;
        if (u * sum < sums[k]) break;
    }
    return sum;
}

/* The pixel of the ray from the lens; u: two numbers in [0,1). Returns the scale of its light, 0 if it is not
 * in the map. */
static double find_pixel(const photon_wave *w, const shade_camera *camera, vec3_f64 way, vec3_f64 from_eye,
                         const double u[2], uint32_t *pixel) {
    const caustics *c = w->caustics;
    const pixel_filter *filter = &w->path->wave.run.plan->filter;
    double x, y;
    int64_t column, row;
    vec3_f64 on = from_eye;
    if (camera->lens_radius > 0)
        on = add_f64(sub_f64(from_eye, way),
                     scale_f64(camera->focus_distance / dot_f64(way, camera->view), way));
    if (!camera_place(camera, on, &x, &y) || !(fabs(x) < 0x1p20 && fabs(y) < 0x1p20)) return 0;
    const double scale = choose_pixel(filter, x, u[0], &column) * choose_pixel(filter, y, u[1], &row);
    column -= c->x0, row -= c->y0;
    if (column < 0 || column >= c->width || row < 0 || row >= c->height) return 0;
    *pixel = (uint32_t)row * c->width + (uint32_t)column;
    return scale;
}

/* Returns the lanes that the camera may see. */
static uint32_t find_views(const photon_wave *w, const vertex_block *v, uint32_t lanes, camera_views *out) {
    const path_wave *p = w->path;
    const render_plan *plan = p->wave.run.plan;
    shade_camera camera = plan->camera;
    vertex_keys keys;
    lanes3 u;
    float across[LANES] = {0}, down[LANES] = {0};
    uint32_t seen = 0;
    memset(&out->to, 0, sizeof out->to);
    path_find_keys(p, v, &keys);
    if (camera.lens_radius > 0) path_numbers(p, &keys, SAMPLE_ROULETTE, false, u);
    if (!plan->filter.box)
        plan->sample_kernels->pairs(keys.pixel, keys.index, photon_dimension(p, SAMPLE_SCATTER), across,
                                    down);
    for (unsigned i = 0; i < LANES; ++i) out->to.direction[2][i] = 1, out->width[i] = 0, out->view[i] = 0;
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        if (plan->camera_moves) wave_camera_when(plan, p->wave.times[v->path.slot[i]], &camera);
        const vec3_f64 from_eye = sub_f64(widen(lane_f32(v->surface.p, i)), widen(camera.eye)),
                       way = way_of_ray(&camera, from_eye, i, u);
        const double depth = dot_f64(from_eye, camera.view);
        if (!(depth > camera.near_clip && depth <= camera.far_clip)) continue;
        const double places[2] = {(double)across[i], (double)down[i]};
        out->scale[i] = find_pixel(w, &camera, way, from_eye, places, &out->pixel[i]);
        if (!(out->scale[i] > 0)) continue;
        const double length = length_f64(way);
        put_lane_f32(out->to.direction, i, narrow(scale_f64(-1 / length, way)));
        out->to.distance[i] = (float)(length * (1 - camera.near_clip / depth));
        out->width[i] = plan->pixel_width + plan->pixel_spread * (float)length;
        out->view[i] = caustic_view(&camera, way, widen(lane_f32(v->surface.ng, i)));
        seen |= 1u << i;
    }
    return seen;
}

void photon_turn(const photon_wave *w, const vertex_block *v, const lanes3 direction, vertex_block *out) {
    out->surface = w->bare, out->path = v->path;
    surface_block *s = &out->surface;
    for (unsigned i = 0; i < LANES; ++i) {
        const vec3_f32 to = lane_f32(direction, i);
        put_lane_f32(s->v, i, to);
        if (!(dot_f32(lane_f32(s->ng, i), to) < 0)) continue;
        put_lane_f32(s->ng, i, neg_f32(lane_f32(s->ng, i)));
        put_lane_f32(s->ns, i, neg_f32(lane_f32(s->ns, i)));
        s->entering[i] = ~s->entering[i];
    }
}

/* The photon's light as the camera's path would carry it, and the part of it that photons count. */
static void find_gain(const photon_wave *w, const vertex_block *seen, const camera_views *views,
                      const lanes3 to_light, uint32_t lanes, lanes3 gain) {
    const render_plan *plan = w->path->wave.run.plan;
    lanes3 f;
    float density[LANES];
    plan->shader_kernels->evaluate(&seen->surface, &seen->shader, to_light, f, density);
    memset(gain, 0, 3 * sizeof *gain);
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        const vec3_f32 ng = lane_f32(seen->surface.ng, i), l = lane_f32(to_light, i);
        if (!caustic_plain(ng, lane_f32(seen->shader.n, i), l)) continue;
        const shader *s = seen->shader.at[i];
        const uint32_t slot = seen->path.slot[i];
        if (s->one_sided && plan->to_camera && !seen->surface.entering[i]) continue;
        const double view = views->view[i] / fabs((double)dot_f32(ng, l)),
                     share =
                         1 - caustic_share(w->caustics, view * (double)density[i] * (double)w->chain[slot],
                                           (double)w->found[slot]);
        for (int c = 0; c < 3; ++c)
            gain[c][i] =
                limited(seen->path.weight[c][i] * limited(f[c][i] * (float)(view * share * views->scale[i])));
    }
}

static void note_depths(const vertex_block *v, const uint32_t behind[LANES], shadow_depths *out) {
    for (int i = 0; i < LANES; ++i) {
        out->start[i] = behind[i] ? v->depth_behind[i] : v->path.depth[i];
        out->end[i] = WATERTIGHT_UNSURE;
        out->sized[i] = 1;
    }
}

void photon_connect(photon_wave *w, vertex_block *v) {
    path_wave *p = w->path;
    const render_plan *plan = p->wave.run.plan;
    camera_views views;
    light_block ray;
    lanes3 gain;
    uint32_t behind[LANES];
    shadow_depths depths;
    uint32_t lanes = lanes_to_end(w, v);
    if (lanes) lanes = find_views(w, v, lanes, &views);
    if (!lanes) return;
    vertex_block *seen = v + 1;
    photon_turn(w, v, views.to.direction, seen);
    path_find_shaders(p, seen, views.width);
    plan->shader_kernels->make(&seen->surface, &seen->shader);
    find_gain(w, seen, &views, v->surface.v, lanes, gain);
    plan->path_kernels->aim(&v->surface, v->surface.ng, &views.to, &ray, behind);
    if (p->media) path_dim_lights(p, v, &ray, behind, gain);
    note_depths(v, behind, &depths);
    for (uint32_t left = lanes; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        const uint32_t slot = v->path.slot[i];
        if (!(gain[0][i] > 0 || gain[1][i] > 0 || gain[2][i] > 0)) continue;
        w->asked[w->asked_count++] = slot, w->pixel[slot] = views.pixel[i];
    }
    wave_push_shadows(&p->wave, 0, &ray, &depths, gain, false);
}
