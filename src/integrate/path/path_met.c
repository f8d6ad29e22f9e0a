/* Adds the light that path rays meet: from lamps on the way, and at their ends emission or light from
 * outside, weighted against light samples. Fills in the AOVs. */
#include "integrate/caustics/caustics.h"
#include "math/limit.h"

#include <math.h>
#include <string.h>

/* Light that a BSDF-sampled ray hit. */
typedef struct met_light {
    float radiance[3], density; /* density: of its direction among light samples */
    uint8_t group;
    bool sky;    /* as in path_share() */
    float chain; /* the share of a chain that photons find, too; else 1 */
    vec3_f32 direction;
} met_light;

static void add_light(path_wave *p, uint32_t slot, const path_block *path, unsigned i, const met_light *met) {
    const float share = path_share(p->density[slot], p->light_factor * met->density, met->sky ? ~0u : 0);
    float rgb[3];
    for (int c = 0; c < 3; ++c) {
        rgb[c] = limited(path->weight[c][i] * (met->radiance[c] * (share * met->chain)));
        p->wave.run.samples.radiance[c][slot] += rgb[c];
    }
    if (!p->wave.run.samples.layers) return;
    const light_tag tag = {(uint8_t)light_kind_of(path_scattered(p, slot)), met->group};
    wave_add_layers(&p->wave, slot, tag, met->direction, rgb);
}

/* The ray of this slot ends a chain at a light, and a photon may have come the same way. */
static bool ends_chain(const path_wave *p, uint32_t slot, vec3_f32 direction, double distance,
                       caustic_entry *out) {
    const caustics *c = p->wave.run.plan->caustics;
    return c && p->chain[slot] > 0 &&
           caustic_enter(c, widen(of_slot(p->p, slot)), widen(direction), distance, out);
}

static float chain_share(const path_wave *p, uint32_t slot, const caustic_entry *at, float density) {
    return (float)caustic_share(p->wave.run.plan->caustics, (double)p->chain[slot],
                                at->density * (double)density);
}

/* Finds the light from outside for the lanes whose bits are set, and its densities. */
static void look_outside(path_wave *p, const trace_block *block, const path_block *path, uint32_t lanes,
                         lanes3 radiance, float density[LANES]) {
    lanes3 from, n, direction;
    for (uint32_t left = lanes; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        const vec3_f32 to = trace_dir(&block->rays, i);
        direction[0][i] = to.x, direction[1][i] = to.y, direction[2][i] = to.z;
        const uint32_t slot = path->slot[i];
        for (int c = 0; c < 3; ++c) from[c][i] = p->p[c][slot], n[c][i] = p->n[c][slot];
    }
    emitters_outside(p->wave.run.plan->emitters, lanes, from, n, direction, radiance, density);
}

/* Suns are not in view. left: the fraction of their light that volumes let pass. */
static void add_suns(path_wave *p, uint32_t slot, const path_block *path, unsigned i, vec3_f32 direction,
                     const float left[3]) {
    const emitters *e = p->wave.run.plan->emitters;
    for (uint32_t k = 0; k < emitters_sun_count(e) && !path_in_view(p, slot); ++k) {
        emitter_disc disc;
        if (!emitters_disc(e, k, of_slot(p->p, slot), of_slot(p->n, slot), direction, &disc)) continue;
        if (!(disc.density > 0) && p->density[slot] < INFINITY) continue;
        met_light met = {.density = disc.density, .group = disc.group, .chain = 1, .direction = direction};
        for (int c = 0; c < 3; ++c) met.radiance[c] = disc.radiance[c] * left[c];
        caustic_entry at;
        if (ends_chain(p, slot, direction, INFINITY, &at) &&
            emitters_disc(e, k, at.p, at.n, direction, &disc))
            met.chain = chain_share(p, slot, &at, disc.density);
        add_light(p, slot, path, i, &met);
    }
}

/* The shares of chains that end at images of skies. */
static void share_skies(const path_wave *p, const trace_block *block, const path_block *path, uint32_t lanes,
                        float share[LANES]) {
    const caustics *c = p->wave.run.plan->caustics;
    caustic_entry at[LANES];
    lanes3 from, n, direction, radiance;
    float density[LANES];
    uint32_t chains = 0;
    for (unsigned i = 0; i < LANES; ++i) share[i] = 1;
    for (; c && c->images && lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        const vec3_f32 to = trace_dir(&block->rays, i);
        if (!ends_chain(p, path->slot[i], to, INFINITY, &at[i])) continue;
        put_lane_f32(from, i, at[i].p), put_lane_f32(n, i, at[i].n), put_lane_f32(direction, i, to);
        chains |= 1u << i;
    }
    if (!chains) return;
    emitters_outside(p->wave.run.plan->emitters, chains, from, n, direction, radiance, density);
    for (; chains; chains &= chains - 1) {
        const unsigned i = lane_first(chains);
        share[i] = chain_share(p, path->slot[i], &at[i], density[i]);
    }
}

void path_add_outside(wave *w, const trace_block *block, const path_block *path, uint32_t missed) {
    path_wave *p = (path_wave *)w;
    lanes3 radiance;
    float density[LANES], share[LANES];
    look_outside(p, block, path, missed, radiance, density);
    share_skies(p, block, path, missed, share);
    for (; missed; missed &= missed - 1) {
        const unsigned i = lane_first(missed);
        float left[3] = {1, 1, 1};
        if (p->media) media_left(p->media, path->slot[i], INFINITY, left);
        met_light met = {.sky = true,
                         .density = density[i],
                         .chain = share[i],
                         .group = emitters_outside_group(w->run.plan->emitters),
                         .direction = trace_dir(&block->rays, i)};
        for (int c = 0; c < 3; ++c) met.radiance[c] = radiance[c][i] * left[c];
        add_light(p, path->slot[i], path, i, &met);
        add_suns(p, path->slot[i], path, i, met.direction, left);
    }
}

/* ---- lamps with a radius ---- */

/* The ray in lane i of a block. */
typedef struct way_of_lane {
    path_wave *p;
    const path_block *path;
    unsigned i;
    vec3_f32 direction;
} way_of_lane;

static void add_lamp(void *user, const emitter_disc *lamp) {
    const way_of_lane *way = user;
    path_wave *p = way->p;
    const uint32_t slot = way->path->slot[way->i];
    met_light met = {.density = lamp->density, .group = lamp->group, .chain = 1, .direction = way->direction};
    float left[3] = {1, 1, 1};
    if (p->media) media_left(p->media, slot, lamp->distance - p->passed[slot], left);
    for (int c = 0; c < 3; ++c) met.radiance[c] = lamp->radiance[c] * left[c];
    caustic_entry at;
    if (ends_chain(p, slot, way->direction, (double)lamp->distance, &at))
        met.chain = chain_share(p, slot, &at,
                                emitters_sphere_density(p->wave.run.plan->emitters, lamp->lamp, at.p, at.n));
    add_light(p, slot, way->path, way->i, &met);
}

static void look_for_lamps(path_wave *p, const trace_block *block, const path_block *path, unsigned i) {
    const uint32_t slot = path->slot[i];
    const float passed = p->passed[slot];
    way_of_lane way = {p, path, i, trace_dir(&block->rays, i)};
    const emitter_ray ray = {.p = of_slot(p->p, slot),
                             .n = of_slot(p->n, slot),
                             .direction = way.direction,
                             .from = passed,
                             .to = passed + block->rays.t_far[i],
                             .smooth = !(p->density[slot] < INFINITY)};
    if (!path_in_view(p, slot)) emitters_find_spheres(p->wave.run.plan->emitters, &ray, add_lamp, &way);
}

void path_add_lamps(path_wave *p) {
    const wave *w = &p->wave;
    for (size_t k = 0; k < w->now.count; ++k)
        look_for_lamps(p, &w->now.rays[k / LANES], &w->now.paths[k / LANES], k % LANES);
}

/* ---- surfaces ---- */

void path_add_emission(path_wave *p, const vertex_block *v, unsigned i, const shader *s) {
    const surface_gather *g = p->wave.gather;
    const uint32_t slot = v->path.slot[i];
    const emitter_hit hit = {.geometry = g->geometry[i],
                             .primitive = g->primitive[i],
                             .instance = g->instance[i],
                             .time = p->wave.times ? p->wave.times[slot] : 0,
                             .inside = !v->surface.entering[i]};
    const vec3_f32 direction = neg_f32(lane_f32(v->surface.v, i)),
                   way = sub_f32(lane_f32(v->surface.p, i), of_slot(p->p, slot));
    met_light met = {.group = wave_hit_group(&p->wave, i), .chain = 1};
    caustic_entry at;
    memcpy(met.radiance, s->emission, sizeof met.radiance);
    if (p->density[slot] < INFINITY)
        met.density = emitters_hit_density(p->wave.run.plan->emitters, of_slot(p->p, slot),
                                           of_slot(p->n, slot), direction, &hit);
    else if (ends_chain(p, slot, direction, (double)sqrtf(dot_f32(way, way)), &at))
        met.chain = chain_share(
            p, slot, &at, emitters_hit_density(p->wave.run.plan->emitters, at.p, at.n, direction, &hit));
    add_light(p, slot, &v->path, i, &met);
}

/* ---- features ---- */

/* Denoisers need the normals and albedo seen in smooth mirrors and through glass (Open Image Denoise,
 * "Albedos" and "Normals"): those of the first vertex that scatters otherwise. Fresnel's equations mix them
 * over the samples, as they mix the light. */
void path_show_features(path_wave *p, const vertex_block *v, const shader_sample *to) {
    for (unsigned i = 0; i < v->surface.count; ++i) {
        const uint32_t slot = v->path.slot[i];
        if (to && to->straight[i] && !to->pane[i]) continue;
        const float tint[3] = {p->tint[0][slot], p->tint[1][slot], p->tint[2][slot]};
        if (p->smooth[slot]) wave_keep_features(&p->wave, v, i, tint);
    }
}

/* A coloured mirror tints the features behind it. */
void path_leave_features(path_wave *p, const shader_sample *to, unsigned i, uint32_t slot) {
    p->smooth[slot] &= to->straight[i] || isinf(to->density[i]);
    for (int c = 0; c < 3 && p->smooth[slot]; ++c) p->tint[c][slot] *= fminf(to->weight[c][i], 1);
}

void path_show_depths(path_wave *p, const vertex_block *v) {
    wave *w = &p->wave;
    for (unsigned i = 0; i < v->surface.count; ++i) {
        const uint32_t slot = v->path.slot[i];
        if (!path_in_view(p, slot)) continue;
        shade_camera camera;
        wave_camera_when(w->run.plan, w->times[slot], &camera);
        const vec3_f32 way = sub_f32(lane_f32(v->surface.p, i), camera.eye);
        w->run.samples.first->z[slot] = (float)dot_f64(widen(way), camera.view);
    }
}
