/* Paths of photons: a wave of path tracing that starts at the lights. */
#include "integrate/caustics/photons.h"

#include "light/shape.h"
#include "math/limit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static photon_wave *of_wave(wave *w) { return ((path_wave *)w)->photons; }

/* ---- the start ---- */

/* u: a number in [0,1). */
static uint32_t choose_caster(const caustics *c, double u) {
    double left = u;
    uint32_t last = 0;
    for (uint32_t k = 0; k < c->count; ++k) {
        if (!(c->casters[k].chance > 0)) continue;
        last = k;
        if (left < c->casters[k].chance) break;
        left -= c->casters[k].chance;
    }
    return last;
}

typedef struct photon_starts {
    uint64_t pixel[LANES];
    uint32_t index[LANES], slot[LANES], caster[LANES];
    emitter_query at;
    emitter_sample light;
} photon_starts;

static void ask_lights(photon_wave *w, photon_starts *s) {
    const render_plan *plan = w->path->wave.run.plan;
    lanes3 u;
    plan->sample_kernels->triples(s->pixel, s->index, sample_at_vertex(0, SAMPLE_LIGHT), u[0], u[1], u[2]);
    for (unsigned i = 0; i < LANES; ++i) {
        s->caster[i] = choose_caster(w->caustics, (double)u[2][i]);
        const caustic_caster *c = &w->caustics->casters[s->caster[i]];
        const vec3_f64 n = shape_all_sample((vec3_f64){0, 0, 0}, (double)u[0][i], (double)u[1][i]);
        put_lane_f32(s->at.p, i, narrow(madd_f64(c->center, c->radius, n)));
        put_lane_f32(s->at.n, i, narrow(n));
        s->at.time[i] = w->path->wave.times ? w->path->wave.times[s->slot[i]] : 0;
    }
    plan->sample_kernels->triples(s->pixel, s->index, sample_at_vertex(1, SAMPLE_LIGHT), u[0], u[1], u[2]);
    emitters_sample(plan->emitters, &s->at, u, &s->light);
}

/* Beyond everything that the ray may meet: the scene and planes. */
static double way_outside(const photon_wave *w, vec3_f64 p, vec3_f64 direction) {
    const world *scene = w->path->wave.run.plan->world;
    double way = length_f64(sub_f64(w->bounds.center, p)) + 2 * w->bounds.radius;
    for (size_t k = 0; k < scene->planes.count; ++k) {
        const world_plane *plane = &scene->planes.items[k];
        const double t =
            dot_f64(sub_f64(widen(plane->point), p), plane->unit) / dot_f64(direction, plane->unit);
        if (t > way && t < WORLD_REACH) way = 2 * t;
    }
    return way;
}

static void begin_slot(photon_wave *w, uint32_t slot, vec3_f32 start) {
    static const uint32_t none[1];
    path_wave *p = w->path;
    p->density[slot] = INFINITY;
    p->width[slot] = p->spread[slot] = p->passed[slot] = 0;
    p->passes[slot] = 0, p->paned[slot] = false, p->channel[slot] = 0;
    p->p[0][slot] = start.x, p->p[1][slot] = start.y, p->p[2][slot] = start.z;
    p->n[0][slot] = p->n[1][slot] = p->n[2][slot] = 0;
    if (p->media) media_begin(p->media, slot, none, 0);
}

static bool is_lit(const photon_wave *w, const photon_starts *s, unsigned i) {
    const emitter_sample *light = &s->light;
    if (!(light->density[i] > 0) || !light->sized[i]) return false;
    if (!(dot_f32(lane_f32(s->at.n, i), lane_f32(light->direction, i)) > 0)) return false; /* not an entry */
    return light->part[i] != EMITTER_OUTSIDE || w->caustics->images;
}

/* Starts the photon of lane i. Lights are outside of all spheres, and no volume is around them. */
static void start(photon_wave *w, const photon_starts *s, unsigned i) {
    wave *paths = &w->path->wave;
    const emitter_sample *light = &s->light;
    const uint32_t slot = s->slot[i];
    caustic_entry entry;
    if (!is_lit(w, s, i)) return;
    const vec3_f64 p = widen(lane_f32(s->at.p, i)), direction = widen(lane_f32(light->direction, i));
    const double distance = (double)light->distance[i];
    if (!caustic_enter(w->caustics, p, direction, distance, &entry) || entry.caster != s->caster[i]) return;
    const double found = entry.density * (double)light->density[i];
    const bool far = light->distance[i] == INFINITY;
    const vec3_f32 from = narrow(madd_f64(p, far ? way_outside(w, p, direction) : distance, direction));
    const size_t k = paths->now.count++;
    trace_rays *ray = &paths->now.rays[k / LANES].rays;
    path_block *path = &paths->now.paths[k / LANES];
    ray->org_x[k % LANES] = from.x, ray->org_y[k % LANES] = from.y, ray->org_z[k % LANES] = from.z;
    ray->dir_x[k % LANES] = -light->direction[0][i];
    ray->dir_y[k % LANES] = -light->direction[1][i];
    ray->dir_z[k % LANES] = -light->direction[2][i];
    ray->t_near[k % LANES] = paths->run.plan->t_near, ray->t_far[k % LANES] = INFINITY;
    for (int c = 0; c < 3; ++c)
        path->weight[c][k % LANES] = limited((float)((double)light->radiance[c][i] / found));
    path->slot[k % LANES] = slot;
    path->depth[k % LANES] =
        paths->run.plan->watertight && !far ? watertight_depth(paths->run.plan->watertight, from) : 0;
    w->found[slot] = (float)found, w->chain[slot] = 1;
    w->caster[slot] = (uint8_t)s->caster[i];
    w->group[slot] = paths->run.plan->groups.count ? light->group[i] : 0;
    put_slot(w->to_light, slot, lane_f32(light->direction, i));
    begin_slot(w, slot, from);
}

static bool start_all(photon_wave *w, uint32_t group, uint32_t first, uint32_t count) {
    path_wave *p = w->path;
    const render_plan *plan = p->wave.run.plan;
    const uint64_t pixel = sample_pixel_hash(&plan->sampler, group, 0);
    photon_starts s;
    p->wave.now.count = 0;
    if (!wave_reserve_paths(&p->wave, &p->wave.now, WAVE_SLOTS)) return false;
    for (uint32_t done = 0; done < count; done += LANES) {
        for (uint32_t i = 0; i < LANES; ++i) {
            const uint32_t slot = done + i;
            s.slot[i] = slot, s.pixel[i] = p->pixel[slot] = pixel, s.index[i] = p->index[slot] = first + slot;
            if (p->wave.times) p->wave.times[slot] = wave_time_of(plan, (sample_key){group, 0, first + slot});
        }
        ask_lights(w, &s);
        for (unsigned i = 0; i < LANES && done + i < count; ++i) start(w, &s, i);
    }
    return true;
}

/* ---- vertices ---- */

static void vertices(wave *w, vertex_block *v) {
    path_wave *p = (path_wave *)w;
    if (p->media) path_absorb(p, v);
    of_wave(w)->bare = v->surface;
    photon_connect(of_wave(w), v);
    path_find_shaders(p, v, NULL);
    w->run.plan->shader_kernels->make(&v->surface, &v->shader);
}

/* A photon leaves a vertex that is not smooth. Its light is that of the camera's path through this vertex:
 * the BSDF is that of the other direction. */
typedef struct photon_bounce {
    float f[3][LANES];    /* f |cosine| of the light, */
    float density[LANES]; /* and the density with which the camera's path samples it */
} photon_bounce;

/* Lanes that bounce so that the camera's path could, too. */
static uint32_t lanes_to_bounce(const path_wave *p, const vertex_block *v, const shader_sample *to) {
    const render_plan *plan = p->wave.run.plan;
    uint32_t lanes = 0;
    for (unsigned i = 0; i < v->surface.count; ++i) {
        const uint32_t before = path_scattered(p, v->path.slot[i]);
        if (to->straight[i] || !(to->density[i] < INFINITY) || !before || before + 2 > plan->max_depth)
            continue;
        const bool through = dot_f32(lane_f32(v->surface.ng, i), lane_f32(to->direction, i)) < 0;
        if (!(to->density[i] > 0) || through != (to->through[i] != 0) || !caustic_bounces(plan, v, to, i))
            continue;
        lanes |= 1u << i;
    }
    return lanes;
}

static void look_back(photon_wave *w, vertex_block *v, const shader_sample *to, photon_bounce *out) {
    static const float no_width[LANES];
    const render_plan *plan = w->path->wave.run.plan;
    vertex_block *seen = v + 1;
    photon_turn(w, v, to->direction, seen);
    path_find_shaders(w->path, seen, no_width);
    plan->shader_kernels->make(&seen->surface, &seen->shader);
    plan->shader_kernels->evaluate(&seen->surface, &seen->shader, v->surface.v, out->f, out->density);
}

/* The weight of a photon after its bounce; Russian roulette keeps the largest component constant. u: a number
 * in [0,1). False: it ends. */
static bool bounce(photon_wave *w, const vertex_block *v, const shader_sample *to, const photon_bounce *b,
                   unsigned i, float u, lanes3 weight) {
    const vec3_f32 ng = lane_f32(v->surface.ng, i);
    const float light = fabsf(dot_f32(ng, lane_f32(v->surface.v, i))),
                factor = fabsf(dot_f32(ng, lane_f32(to->direction, i))) / (light * to->density[i]);
    float before = 0, after = 0, rgb[3];
    for (int c = 0; c < 3; ++c) {
        rgb[c] = limited(v->path.weight[c][i] * limited(b->f[c][i] * factor));
        before = most(before, v->path.weight[c][i]), after = most(after, rgb[c]);
    }
    const float stays = after < before ? after / before : 1;
    if (!(u < stays)) return false;
    for (int c = 0; c < 3; ++c) weight[c][i] = limited(rgb[c] / stays);
    w->chain[v->path.slot[i]] *= caustic_step(b->density[i], light);
    return true;
}

static uint32_t bounce_lanes(photon_wave *w, vertex_block *v, const shader_sample *to, uint32_t lanes,
                             const vertex_keys *keys, lanes3 weight) {
    const sample_kernels *kernels = w->path->wave.run.plan->sample_kernels;
    photon_bounce b;
    float u[LANES], other[LANES];
    uint32_t stay = 0;
    look_back(w, v, to, &b);
    kernels->pairs(keys->pixel, keys->index, photon_dimension(w->path, SAMPLE_ROULETTE), u, other);
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        if (bounce(w, v, to, &b, i, u[i], weight)) stay |= 1u << i;
    }
    return stay;
}

/* Lanes that go on at smooth surfaces, or pass. Another vertex must follow. */
static uint32_t lanes_to_follow(photon_wave *w, const vertex_block *v, const shader_sample *to,
                                lanes3 weight) {
    const path_wave *p = w->path;
    uint32_t lanes = 0;
    for (unsigned i = 0; i < v->surface.count; ++i) {
        if (!(weight[0][i] > 0 || weight[1][i] > 0 || weight[2][i] > 0)) continue;
        if (!to->straight[i]) {
            if (to->density[i] < INFINITY || !caustic_follows(v, to, i)) continue;
            if (path_scattered(p, v->path.slot[i]) + 2 > p->wave.run.plan->max_depth) continue;
            const float factor = caustic_stretch(v, lane_f32(v->surface.v, i), lane_f32(to->direction, i), i);
            if (!(factor < 0x1p60f)) continue; /* it grazes the surface, which has no measure */
            w->chain[v->path.slot[i]] *= factor;
            for (int c = 0; c < 3; ++c) weight[c][i] = limited(weight[c][i] * factor);
        }
        lanes |= 1u << i;
    }
    return lanes;
}

static void leave(wave *w, vertex_block *v) {
    path_wave *p = (path_wave *)w;
    const render_plan *plan = w->run.plan;
    vertex_keys keys;
    lanes3 u;
    shader_sample to;
    path_block path;
    path_find_keys(p, v, &keys);
    path_numbers(p, &keys, SAMPLE_SCATTER, true, u);
    plan->shader_kernels->sample(&v->surface, &v->shader, u, &to);
    plan->path_kernels->carry(&v->path, &to, path.weight);
    if (plan->dispersive) path_part_paths(p, v, &to, path.weight);
    uint32_t lanes = lanes_to_follow(of_wave(w), v, &to, path.weight);
    const uint32_t bounced = lanes_to_bounce(p, v, &to);
    if (bounced) lanes |= bounce_lanes(of_wave(w), v, &to, bounced, &keys, path.weight);
    if (lanes) path_push_lanes(p, v, &to, &path, lanes);
}

static bool in_view(const wave *w, uint32_t slot) {
    (void)w, (void)slot;
    return false;
}

static const wave_stages photon_stages = {vertices, NULL, leave, in_view};

/* ---- all ---- */

/* The light that arrived at the camera in this step. */
static bool collect(photon_wave *w, caustic_splats *out) {
    float *const *light = w->path->wave.run.samples.radiance;
    for (size_t k = 0; k < w->asked_count; ++k) {
        const uint32_t slot = w->asked[k];
        caustic_splat splat = {.pixel = w->pixel[slot], .group = w->group[slot], .caster = w->caster[slot]};
        for (int c = 0; c < 3; ++c) splat.rgb[c] = light[c][slot], light[c][slot] = 0;
        if (!(splat.rgb[0] > 0 || splat.rgb[1] > 0 || splat.rgb[2] > 0)) continue;
        splat.direction = of_slot(w->to_light, slot);
        if (!array_push(out, splat)) return false;
    }
    w->asked_count = 0;
    return true;
}

static bool step(photon_wave *w, caustic_splats *out) {
    wave *paths = &w->path->wave;
    paths->passing = paths->run.plan->covered;
    if (!wave_trace(paths, 0, paths->now.count, TRACE_INCOHERENT) || !wave_sort_hits(paths)) return false;
    paths->next.count = 0;
    if (!wave_reserve_paths(paths, &paths->next, paths->now.count)) return false;
    if (!wave_begin_shadows(paths, paths->now.count) || !wave_surfaces(paths, false)) return false;
    if (!wave_cast_shadows(paths, TRACE_INCOHERENT) || !collect(w, out)) return false;
    const path_queue kept = paths->now;
    paths->now = paths->next;
    paths->next = kept;
    return true;
}

bool photon_wave_run(photon_wave *w, uint32_t group, uint32_t first, uint32_t count, caustic_splats *out) {
    path_wave *p = w->path;
    wave_begin_samples(&p->wave);
    if (!start_all(w, group, first, count)) return false;
    for (p->depth = 0; p->wave.now.count; ++p->depth)
        if (!step(w, out)) return false;
    return true;
}

photon_wave *photon_wave_create(const render_plan *plan, const caustics *c, const atomic_bool *stop) {
    photon_wave *w = aligned_alloc(64, (sizeof *w + 63) / 64 * 64); /* of its surface block */
    if (!w) return NULL;
    memset(w, 0, sizeof *w);
    w->caustics = c;
    w->path = path_wave_create(plan, stop, &photon_stages);
    /* The second block of vertices is seen from the other side: see photon_turn(). */
    if (!w->path || trace_approach_find(plan->world, &w->bounds) != FATHOM_OK ||
        !wave_reserve_vertices(&w->path->wave, 2 * LANES)) {
        photon_wave_destroy(w);
        return NULL;
    }
    w->path->photons = w;
    shader_prepare_hole(&w->path->hidden);
    return w;
}

void photon_wave_destroy(photon_wave *w) {
    if (!w) return;
    path_wave_destroy(w->path);
    free(w);
}
