/* Laws of lamps with a radius: what rays find, and what light samples say of it. */
#include "unit_light.h"

typedef struct lamp {
    vec3_f64 at;
    double radius, intensity;
} lamp;

enum { MOST = 300 };

/* Lamps of all sizes in a box; every tenth has none. Their intensities tell them apart. */
static void add_lamps(random_state *r, uint32_t count, lamp *out) {
    for (uint32_t k = 0; k < count; ++k) {
        fathom_light light = default_light();
        for (int c = 0; c < 3; ++c) light.position[c] = (double)(float)random_in(r, -4, 4);
        light.radius = k % 10 ? (float)random_log(r, 1e-3, 1) : 0;
        for (int c = 0; c < 3; ++c) light.intensity[c] = (float)(k + 1);
        assert_ok(context, fathom_scene_add_light(scene, &light, NULL));
        out[k] = (lamp){load_f64(light.position), (double)light.radius, k + 1.0};
    }
}

/* ---- what a ray finds ---- */

typedef struct finds {
    uint32_t count;
    double distance[MOST], radiance[MOST], density[MOST];
} finds;

static void note(void *user, const emitter_disc *disc) {
    finds *f = user;
    assert_true(f->count < MOST);
    f->distance[f->count] = (double)disc->distance, f->radiance[f->count] = (double)disc->radiance[0];
    f->density[f->count++] = (double)disc->density;
}

static bool is_found(const finds *f, double distance, double radiance) {
    for (uint32_t k = 0; k < f->count; ++k) {
        if (fabs(f->distance[k] - distance) < 1e-4 && fabs(f->radiance[k] / radiance - 1) < 1e-6) return true;
    }
    return false;
}

/* The distance to the sphere; INFINITY: none, from inside, or no closer than `near` to any decision. */
static double distance_to(const lamp *l, vec3_f64 p, vec3_f64 d, double near, bool *sure) {
    const vec3_f64 from = sub_f64(p, l->at);
    const double along = -dot_f64(from, d), outside = dot_f64(from, from) - l->radius * l->radius,
                 root = along * along - outside;
    *sure = fabs(outside) > near && fabs(root) > near;
    return l->radius > 0 && outside > 0 && along > 0 && root > 0 ? along - sqrt(root) : (double)INFINITY;
}

/* A part of a ray finds each lamp once, as a whole and cut in two. near: float's roundings of distances up to
 * 20. */
UNIT_TEST(rays_find_each_lamp_that_they_enter) {
    static lamp lamps[MOST];
    random_state r = {5};
    const double near = 1e-4;
    uint32_t found = 0;
    add_lamps(&r, MOST, lamps);
    open_light();
    for (int trial = 0; trial < 6000; ++trial) {
        const vec3_f64 at = {random_in(&r, -6, 6), random_in(&r, -6, 6), random_in(&r, -6, 6)};
        const float middle = (float)random_in(&r, 0, 6), stop = trial % 3 ? INFINITY : middle + 3;
        emitter_ray ray = {.p = narrow(sub_f64(at, w->origin)), .direction = narrow(random_direction(&r))};
        const vec3_f64 p = add_f64(widen(ray.p), w->origin), d = normalize_f64(widen(ray.direction));
        finds f = {0};
        ray.to = middle, ray.smooth = trial % 2;
        emitters_find_spheres(e, &ray, note, &f);
        ray.from = middle, ray.to = stop;
        emitters_find_spheres(e, &ray, note, &f);
        uint32_t most = 0, least = 0;
        for (int k = 0; k < MOST; ++k) {
            bool sure;
            const double distance = distance_to(&lamps[k], p, d, near, &sure);
            const bool meets = distance < (double)stop;
            sure &= !(fabs(distance - (double)stop) < near);
            most += meets || !sure, least += meets && sure;
            if (meets && sure)
                assert_true(is_found(&f, distance, lamps[k].intensity / pow(lamps[k].radius, 2)));
        }
        assert_true(f.count >= least && f.count <= most);
        found += least;
    }
    assert_true(found > 1000);
}

/* ---- what light samples say ---- */

/* A ray along a sample finds the lamp, its radiance, its distance and its density. 1e-5: roundings of float.
 * A direction that is rounded at the edge of a sphere misses it, or meets it elsewhere: of a share of 4 u
 * d/R, 2e-4 in the mean. */
UNIT_TEST(rays_along_samples_find_what_they_say) {
    static lamp lamps[MOST];
    random_state r = {7};
    uint32_t same = 0, all = 0;
    add_lamps(&r, 60, lamps);
    open_light();
    for (int trial = 0; trial < 400; ++trial) {
        const vec3_f64 p = {random_in(&r, -6, 6), random_in(&r, -6, 6), random_in(&r, -6, 6)};
        const vec3_f32 at = narrow(sub_f64(p, w->origin)),
                       n = trial % 3 ? narrow(random_direction(&r)) : (vec3_f32){0, 0, 0};
        emitter_query q;
        emitter_sample s;
        lanes3 u;
        for (unsigned i = 0; i < LANES; ++i) {
            put_lane_f32(q.p, i, at), put_lane_f32(q.n, i, n);
            for (int c = 0; c < 3; ++c) u[c][i] = (float)(random_bits(&r) >> 40) * 0x1p-24f;
        }
        emitters_sample(e, &q, u, &s);
        for (unsigned i = 0; i < LANES; ++i) {
            const emitter_ray ray = {.p = at, .n = n, .direction = lane_f32(s.direction, i), .to = INFINITY};
            finds f = {0};
            if (!s.sized[i] || !(s.density[i] > 0)) continue;
            emitters_find_spheres(e, &ray, note, &f);
            bool found = false;
            for (uint32_t k = 0; k < f.count; ++k) {
                found |= fabs(f.distance[k] - (double)s.distance[i]) < 1e-3 &&
                         fabs(f.radiance[k] / (double)s.radiance[0][i] - 1) < 1e-6 &&
                         fabs(f.density[k] / (double)s.density[i] - 1) < 1e-5;
            }
            same += found, ++all;
        }
    }
    assert_true(all > 4000);
    assert_true(same >= all - all / 500);
}

int main(void) { return unit_main_each(begin_light, NULL); }
