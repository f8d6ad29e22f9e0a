/* Samples light from outside the scene: the background, environments and suns. */
#include "light/emitters_inner.h"

#include <string.h>

/* ---- suns ---- */

static double solid_angle(const emitter_sun *sun) { return 2 * SHAPE_PI * sun->cap; }

/* A surface that faces a disc of half the angle a gets pi L sin²a = E. */
static vec3_f32 disc_radiance(const emitter_sun *sun) {
    const double sine2 = sun->cap * (2 - sun->cap);
    return scale_f32((float)(1 / (SHAPE_PI * sine2)), load_f32(sun->irradiance));
}

/* chance: of all suns. */
static float disc_density(const emitter_sun *sun, double chance) {
    return density_f32(chance * sun->chance / solid_angle(sun));
}

/* Without a size it has the irradiance of a surface that faces it: E times 2 / (1 + cos a) over the disc. */
void emitters_sample_sun(const emitters *e, double u, double v, double choice, double chance,
                         emitter_sample *out, unsigned i) {
    uint32_t k = e->sun_count - 1;
    while (k > 0 && choice < e->suns[k].below) --k;
    const emitter_sun *sun = &e->suns[k];
    const shape_cone cone = {shape_unit(widen(sun->to_light)), 1, sun->cap};
    put_lane_f32(out->direction, i, narrow(shape_cone_sample(&cone, u, v)));
    out->distance[i] = INFINITY, out->group[i] = sun->group;
    out->sized[i] = sun->cap > 0 && e->found ? ~0u : 0;
    if (out->sized[i]) {
        put_lane_f32(out->radiance, i, disc_radiance(sun));
        out->density[i] = disc_density(sun, chance);
        return;
    }
    put_lane_f32(out->radiance, i, scale_f32((float)(2 / (2 - sun->cap)), load_f32(sun->irradiance)));
    out->density[i] = (float)(chance * sun->chance);
}

uint32_t emitters_sun_count(const emitters *e) { return e->disc_count; }

bool emitters_disc(const emitters *e, uint32_t k, vec3_f32 p, vec3_f32 n, vec3_f32 direction,
                   emitter_disc *out) {
    const emitter_sun *sun = &e->suns[k];
    const shape_cone cone = {shape_unit(widen(sun->to_light)), 1, sun->cap};
    if (!shape_cone_holds(&cone, normalize_f64(widen(direction)))) return false;
    store_f32(out->radiance, disc_radiance(sun));
    out->density = e->found ? disc_density(sun, emitters_shares(e, p, n)->of[EMITTER_DIRECTIONAL]) : 0;
    out->distance = INFINITY, out->group = sun->group;
    return true;
}

/* ---- background and environments ---- */

/* Background and environments add up. One of them samples a direction; the density includes all of them. */
static void look_outside(const emitters *e, unsigned lanes, const lanes3 p, const lanes3_f64 n,
                         const lanes3_f64 direction, sky_light *out) {
    for (unsigned left = lanes; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        put_lane_f32(out->radiance, i, load_f32(e->background));
        out->density[i] = e->background_chance * shape_all_density(lane_f64(n, i), lane_f64(direction, i));
    }
    for (uint32_t k = 0; k < e->sky_count; ++k) {
        sky_light more;
        environment_at(e->skies[k].image, lanes, p, n, direction, &more);
        for (unsigned left = lanes; left; left &= left - 1) {
            const unsigned i = lane_first(left);
            for (int c = 0; c < 3; ++c) out->radiance[c][i] += more.radiance[c][i];
            out->density[i] += e->skies[k].chance * more.density[i];
        }
    }
}

/* The lanes, of those that remain, that sample environment k. If rounding leaves a choice beyond all
 * probabilities, the last environment with one above 0 takes it, unless there is a background. */
static unsigned who_asks(const emitters *e, uint32_t k, unsigned lanes, double choice[LANES]) {
    unsigned asks = 0;
    bool last = !(e->background_chance > 0);
    for (uint32_t other = k + 1; other < e->sky_count; ++other) last &= !(e->skies[other].chance > 0);
    for (; lanes && e->skies[k].chance > 0; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        if (last || choice[i] < e->skies[k].chance) asks |= 1u << i;
        choice[i] -= e->skies[k].chance;
    }
    return asks;
}

/* Each lane samples a direction from one source. For an environment this also sets radiance and density,
 * which are complete if there is no other source. */
static void aim_outside(const emitters *e, unsigned lanes, const lanes3 p, const lanes3_f64 n, const lanes3 u,
                        double choice[LANES], lanes3_f64 direction, sky_light *out) {
    for (uint32_t k = 0; k < e->sky_count; ++k) {
        const unsigned asks = who_asks(e, k, lanes, choice);
        if (asks) environment_sample(e->skies[k].image, asks, p, n, u[0], u[1], direction, out);
        lanes &= ~asks;
    }
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        put_lane_f64(direction, i, shape_all_sample(lane_f64(n, i), (double)u[0][i], (double)u[1][i]));
    }
}

static bool is_one_environment(const emitters *e) {
    return e->sky_count == 1 && !(e->background_chance > 0) &&
           !(e->background[0] + e->background[1] + e->background[2] > 0);
}

static void find_normals(unsigned lanes, const lanes3 n, lanes3_f64 out) {
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        put_lane_f64(out, i, unit_or_zero(lane_f32(n, i)));
    }
}

void emitters_sample_outside(const emitters *e, unsigned lanes, const emitter_query *from, const lanes3 u,
                             const double choice[LANES], const emitter_shares *const shares[LANES],
                             emitter_sample *out) {
    lanes3_f64 n, direction;
    sky_light light;
    double left[LANES];
    memcpy(left, choice, sizeof left);
    find_normals(lanes, from->n, n);
    aim_outside(e, lanes, from->p, n, u, left, direction, &light);
    for (unsigned some = lanes; some; some &= some - 1) {
        const unsigned i = lane_first(some);
        put_lane_f32(out->direction, i, narrow(lane_f64(direction, i)));
        put_lane_f64(direction, i, widen(lane_f32(out->direction, i)));
    }
    if (!is_one_environment(e)) look_outside(e, lanes, from->p, n, direction, &light);
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        const vec3_f32 radiance = lane_f32(light.radiance, i);
        emitters_finish(out, i, light.density[i] * shares[i]->of[EMITTER_OUTSIDE],
                        (float[3]){radiance.x, radiance.y, radiance.z});
        if (out->density[i] > 0) out->distance[i] = INFINITY;
        out->group[i] = e->outside_group;
    }
}

void emitters_outside(const emitters *e, unsigned lanes, const lanes3 p, const lanes3 n,
                      const lanes3 direction, lanes3 radiance, float density[LANES]) {
    lanes3_f64 normals, directions;
    sky_light light;
    find_normals(lanes, n, normals);
    for (unsigned left = lanes; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        put_lane_f64(directions, i, widen(lane_f32(direction, i)));
    }
    look_outside(e, lanes, p, normals, directions, &light);
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        put_lane_f32(radiance, i, lane_f32(light.radiance, i));
        const emitter_shares *shares = emitters_shares(e, lane_f32(p, i), lane_f32(n, i));
        density[i] = density_f32(shares->of[EMITTER_OUTSIDE] * light.density[i]);
    }
}
