/* Unidirectional path tracing (Kajiya 1986). Each vertex samples one direction towards a light and one by the
 * BSDF, weighted by multiple importance sampling (Veach 1997); the path continues in the second. Nothing is
 * clamped, so the mean of the samples is the arriving light.
 *
 * A path has one slot and never splits, so its state is stored there. */
#include "integrate/caustics/caustics.h"
#include "math/limit.h"

#include <stdlib.h>
#include <string.h>

/* True if the path has reached its maximum number of bounces: it may only pass straight through surfaces. */
static bool is_done(const path_wave *p, uint32_t slot) {
    return path_scattered(p, slot) >= p->wave.run.plan->max_depth;
}

void path_find_keys(const path_wave *p, const vertex_block *v, vertex_keys *out) {
    for (int i = 0; i < LANES; ++i) {
        out->pixel[i] = p->pixel[v->path.slot[i]];
        out->index[i] = p->index[v->path.slot[i]];
    }
}

void path_numbers(const path_wave *p, const vertex_keys *keys, sample_purpose purpose, bool choice,
                  lanes3 u) {
    const sample_kernels *kernels = p->wave.run.plan->sample_kernels;
    const sample_dimension dimension = sample_at_vertex(p->depth, purpose);
    if (choice) {
        kernels->triples(keys->pixel, keys->index, dimension, u[0], u[1], u[2]);
    } else {
        kernels->pairs(keys->pixel, keys->index, dimension, u[0], u[1]);
        memset(u[2], 0, sizeof u[2]);
    }
}

/* ---- vertices ---- */

static float width_at(const path_wave *p, const vertex_block *v, unsigned i) {
    const uint32_t slot = v->path.slot[i];
    const vec3_f32 way = sub_f32(lane_f32(v->surface.p, i), of_slot(p->p, slot));
    return p->width[slot] + p->spread[slot] * sqrtf(dot_f32(way, way));
}

/* Bits of the lanes whose paths have met only smooth surfaces: none has widened the cone. */
static uint32_t seen_lanes(const path_wave *p, const vertex_block *v) {
    const float spread = p->wave.run.plan->pixel_spread;
    uint32_t seen = 0;
    for (unsigned i = 0; i < LANES; ++i) seen |= p->spread[v->path.slot[i]] > spread ? 0 : 1u << i;
    return seen;
}

void path_find_shaders(path_wave *p, vertex_block *v, const float *given) {
    wave *w = &p->wave;
    const render_plan *plan = w->run.plan;
    float width[LANES], around[LANES];
    for (int i = 0; i < LANES; ++i) v->shader.at[i] = &plan->shaders[v->surface.material[i]];
    const uint32_t hidden = plan->nested ? path_meet_volumes(p, v, around) : 0;
    if (plan->texturing) {
        for (unsigned i = 0; i < LANES; ++i) width[i] = given ? given[i] : width_at(p, v, i);
        texturing_shade(plan->texturing, w->gather, width, seen_lanes(p, v), plan->nested ? around : NULL,
                        &v->surface, w->made[v - w->vertices], v->shader.at);
    }
    if (plan->dispersive) path_choose_channels(p, v);
    if (plan->nested) path_hide_surfaces(p, v, around, hidden);
    if (wave_looks_through(&p->wave)) path_hide_backs(p, v);
}

static void begin_vertices(wave *w, vertex_block *v) {
    path_wave *p = (path_wave *)w;
    const render_plan *plan = w->run.plan;
    if (p->media) path_absorb(p, v);
    path_find_shaders(p, v, NULL);
    plan->shader_kernels->make(&v->surface, &v->shader);
    for (unsigned i = 0; i < v->surface.count; ++i) {
        const shader *s = v->shader.at[i];
        if (path_sends_light(s)) path_add_emission(p, v, i, s);
    }
}

/* ---- light samples ---- */

/* Light below the horizon of this normal does not count; 0: light from both sides does. A clear coat with a
 * normal of its own reflects light from behind the normal of the layers below it. */
static vec3_f32 lit_side(const vertex_block *v, unsigned i) {
    if (v->shader.at[i]->transmits) return (vec3_f32){0, 0, 0};
    return lane_f32(v->surface.coated >> i & 1 ? v->surface.ng : v->shader.n, i);
}

static void ask(const path_wave *p, const vertex_block *v, emitter_query *out) {
    memcpy(out->p, v->surface.p, sizeof out->p);
    for (unsigned i = 0; p->wave.times && i < LANES; ++i) out->time[i] = p->wave.times[v->path.slot[i]];
    for (unsigned i = 0; i < LANES; ++i) put_lane_f32(out->n, i, lit_side(v, i));
}

/* See wave.passing. */
static bool may_pass(const path_wave *p) {
    const render_plan *plan = p->wave.run.plan;
    return plan->covered || (plan->one_sided && (!p->depth || p->looked_through));
}

/* Lanes whose paths may only pass straight through surfaces, as masks; see is_done(). */
static void find_done(const path_wave *p, const vertex_block *v, uint32_t done[LANES]) {
    memset(done, 0, LANES * sizeof *done);
    for (unsigned i = 0; p->wave.passing && i < LANES; ++i) done[i] = is_done(p, v->path.slot[i]) ? ~0u : 0;
}

/* Light from outside ends in no closed mesh. The depths of other lights are not known. */
static void note_depths(const vertex_block *v, const emitter_sample *light, const light_block *ray,
                        const uint32_t behind[LANES], shadow_depths *out) {
    for (int i = 0; i < LANES; ++i) {
        out->start[i] = behind[i] ? v->depth_behind[i] : v->path.depth[i];
        out->end[i] = ray->distance[i] == INFINITY ? 0 : WATERTIGHT_UNSURE;
        out->sized[i] = light->sized[i] != 0;
    }
}

static void note_tags(const path_wave *p, const vertex_block *v, const emitter_sample *light,
                      shadow_depths *out) {
    const bool groups = p->wave.run.plan->groups.count;
    for (unsigned i = 0; i < LANES; ++i) {
        const bool any = groups && light->density[i] > 0;
        out->tag[i] = (light_tag){(uint8_t)light_kind_of(path_scattered(p, v->path.slot[i]) + 1),
                                  any ? light->group[i] : (uint8_t)0};
    }
}

static void push_light(path_wave *p, const vertex_block *v, const vertex_keys *keys) {
    const render_plan *plan = p->wave.run.plan;
    emitter_query query;
    emitter_sample light;
    light_block ray;
    lanes3 u, f, gain;
    float density[LANES];
    uint32_t behind[LANES], done[LANES];
    shadow_depths depths;
    path_numbers(p, keys, SAMPLE_LIGHT, emitters_choose(plan->emitters), u);
    ask(p, v, &query);
    emitters_sample(plan->emitters, &query, u, &light);
    plan->shader_kernels->evaluate(&v->surface, &v->shader, light.direction, f, density);
    find_done(p, v, done);
    plan->path_kernels->weigh(&v->path, &light, f, density, p->light_factor, done, gain);
    plan->path_kernels->aim(&v->surface, v->shader.n, &light, &ray, behind);
    if (p->media) path_dim_lights(p, v, &ray, behind, gain);
    if (plan->dispersive) path_part_lights(p, v, behind, gain);
    if (p->scout) path_scout_asks(p->scout, v, &query, &light, gain);
    note_depths(v, &light, &ray, behind, &depths);
    if (p->wave.run.samples.layers) note_tags(p, v, &light, &depths);
    wave_push_shadows(&p->wave, 0, &ray, &depths, gain, p->depth == 0);
}

/* ---- scattered rays ---- */

/* Russian roulette starts at the fourth vertex. An earlier start saves time, but not at equal error under a
 * sky (bench/path_tracing.md), and surfaces seen behind two mirrors would be found only at random. */
#define ROULETTE_FROM 3

/* A direction of density d represents directions within about 1/sqrt(d) of it. A small fraction of that angle
 * keeps texture lookups close to the point. */
#define CONE_PART (1 / 16.0f)

static void widen_cone(path_wave *p, const vertex_block *v, const shader_sample *to, unsigned i) {
    const uint32_t slot = v->path.slot[i];
    p->width[slot] = width_at(p, v, i);
    if (to->density[i] < INFINITY) p->spread[slot] += CONE_PART / sqrtf(to->density[i]);
}

/* A chain has a positive density while its last vertex is smooth, else a negative one. */
static void follow_chain(path_wave *p, const vertex_block *v, const shader_sample *to, unsigned i,
                         uint32_t slot) {
    const render_plan *plan = p->wave.run.plan;
    const float before = fabsf(p->chain[slot]), d = to->density[i];
    const bool smooth = !(d < INFINITY);
    if (!path_scattered(p, slot))
        p->chain[slot] = -caustic_chain(p, v, to, i, slot);
    else if (!(before > 0) || !(smooth ? caustic_follows(v, to, i) : caustic_bounces(plan, v, to, i)))
        p->chain[slot] = 0;
    else if (smooth)
        p->chain[slot] =
            limited(before * caustic_stretch(v, lane_f32(to->direction, i), lane_f32(v->surface.v, i), i));
    else
        p->chain[slot] = -limited(
            before * caustic_step(d, dot_f32(lane_f32(v->surface.ng, i), lane_f32(to->direction, i))));
}

/* Records the vertex that the ray leaves. If the ray passes straight through, this is not a vertex: the next
 * hit is weighted as if the ray came from the previous vertex. */
static void leave_vertex(path_wave *p, const vertex_block *v, const shader_sample *to, unsigned i,
                         bool hidden, uint32_t slot) {
    const vec3_f32 at = lane_f32(v->surface.p, i), n = lit_side(v, i);
    if (p->wave.run.samples.first) path_leave_features(p, to, i, slot);
    if (to->straight[i]) {
        const vec3_f32 way = sub_f32(at, of_slot(p->p, slot));
        p->passed[slot] = sqrtf(dot_f32(way, way));
        if (to->pane[i]) p->paned[slot] = true;
        if (p->wave.run.samples.mattes && path_in_view(p, slot)) wave_lose_mattes(&p->wave, slot);
        ++p->passes[slot];
        /* The light samples of the previous vertex do not see past a hidden surface. */
        if (hidden) p->density[slot] = INFINITY;
        return;
    }
    if (p->wave.run.plan->caustics) follow_chain(p, v, to, i, slot);
    p->p[0][slot] = at.x, p->p[1][slot] = at.y, p->p[2][slot] = at.z;
    p->n[0][slot] = n.x, p->n[1][slot] = n.y, p->n[2][slot] = n.z;
    p->density[slot] = to->density[i];
    p->passed[slot] = 0;
}

/* Updates the state of the path in lane i. */
static void keep_path(path_wave *p, const vertex_block *v, const shader_sample *to, unsigned i) {
    const surface_block *s = &v->surface;
    const uint32_t slot = v->path.slot[i];
    const render_plan *plan = p->wave.run.plan;
    const bool hidden = v->shader.at[i] == &p->hidden;
    if (plan->texturing && !to->straight[i]) widen_cone(p, v, to, i);
    leave_vertex(p, v, to, i, hidden, slot);
    if (to->through[i] && (!to->straight[i] || hidden) && p->media && plan->shaders[s->material[i]].encloses)
        media_cross(p->media, slot, s->material[i], s->entering[i] != 0);
}

/* Appends lanes for which the last block has room. */
static void push_some(path_wave *p, const trace_rays *rays, const path_block *path, uint32_t lanes) {
    const render_plan *plan = p->wave.run.plan;
    path_queue *next = &p->wave.next;
    const unsigned at = next->count % LANES;
    path_block *to = &next->paths[next->count / LANES];
    plan->kernels->append(rays, ROWS_OF_RAYS, lanes, &next->rays[next->count / LANES].rays, at);
    plan->kernels->append(path, ROWS_OF_PATHS, lanes, to, at);
    next->count += (unsigned)__builtin_popcount(lanes);
    unsigned k = at;
    for (uint32_t left = plan->watertight ? lanes : 0; left; left &= left - 1)
        to->depth[k++] = path->depth[lane_first(left)];
}

/* The far plane also hides what camera rays find behind holes. */
static void clip_passes(const path_wave *p, const vertex_block *v, const shader_sample *to,
                        trace_rays *rays) {
    const render_plan *plan = p->wave.run.plan;
    shade_camera camera = plan->camera;
    for (unsigned i = 0; i < v->surface.count; ++i) {
        const uint32_t slot = v->path.slot[i];
        if (!to->straight[i] || to->pane[i] || !path_in_view(p, slot)) continue;
        if (plan->camera_moves) wave_camera_when(plan, p->wave.times[slot], &camera);
        const vec3_f64 from = sub_f64(widen(trace_org(rays, i)), plan_eye(plan, &camera));
        rays->t_far[i] =
            (float)fmax(camera_way_to(&camera, camera.far_clip, from, widen(trace_dir(rays, i))), 0);
    }
}

void path_push_lanes(path_wave *p, const vertex_block *v, const shader_sample *to, path_block *path,
                     uint32_t lanes) {
    trace_rays rays;
    uint32_t crossed = 0;
    p->wave.run.plan->path_kernels->depart(&v->surface, to, p->wave.run.plan->t_near, &rays);
    if (p->wave.run.plan->camera.clips) clip_passes(p, v, to, &rays);
    for (uint32_t left = lanes; left; left &= left - 1) keep_path(p, v, to, (unsigned)__builtin_ctz(left));
    memcpy(path->slot, v->path.slot, sizeof path->slot);
    for (unsigned i = 0; i < LANES; ++i) {
        path->depth[i] = to->through[i] ? v->depth_behind[i] : v->path.depth[i];
        crossed |= to->through[i] ? 1u << i : 0;
    }
    crossed &= lanes;
    p->wave.run.rays.refraction += (unsigned)__builtin_popcount(crossed);
    p->wave.run.rays.reflection += (unsigned)__builtin_popcount(lanes & ~crossed);
    const uint32_t room = lowest_lanes(lanes, LANES - p->wave.next.count % LANES);
    push_some(p, &rays, path, room);
    if (room != lanes) push_some(p, &rays, path, lanes & ~room);
}

/* In view, a hole keeps the probability of its area, because AOVs count the paths that end at the surface. */
static void pass_alone(const path_wave *p, vertex_block *v) {
    for (unsigned i = 0; i < LANES; ++i) {
        if (!is_done(p, v->path.slot[i])) continue;
        const float hole = v->shader.take[SHADER_TAKE_STRAIGHT][i],
                    pane = v->shader.at[i]->clear ? v->shader.take[SHADER_TAKE_PASS][i] : 0;
        for (int k = 0; k < SHADER_TAKES; ++k) v->shader.take[k][i] = 0;
        if (!(hole + pane > 0)) continue;
        const float straight = path_in_view(p, v->path.slot[i]) ? hole : hole / (hole + pane);
        v->shader.take[SHADER_TAKE_STRAIGHT][i] = straight;
        v->shader.take[SHADER_TAKE_PASS][i] = pane > 0 ? 1 - straight : 0;
    }
}

void path_part_paths(path_wave *p, const vertex_block *v, const shader_sample *to, lanes3 weight) {
    for (unsigned i = 0; i < v->surface.count; ++i) {
        float rgb[3] = {weight[0][i], weight[1][i], weight[2][i]};
        if (to->straight[i] || !path_part_channels(p, v, i, to->through[i] != 0, rgb)) continue;
        p->channel[v->path.slot[i]] = (uint8_t)v->shader.channel[i];
        for (int c = 0; c < 3; ++c) weight[c][i] = rgb[c];
    }
}

/* Roulette does not end paths where they cross smooth surfaces. A path through a glass crosses several; the
 * few that then find a light would be rare and bright. */
static uint32_t survive(const path_wave *p, const vertex_keys *keys, const shader_sample *to, lanes3 weight) {
    const path_kernels *kernels = p->wave.run.plan->path_kernels;
    lanes3 chance;
    uint32_t safe[LANES];
    if (p->depth < ROULETTE_FROM) return kernels->survive(NULL, NULL, weight);
    path_numbers(p, keys, SAMPLE_ROULETTE, false, chance);
    for (int i = 0; i < LANES; ++i) safe[i] = to->density[i] < INFINITY ? 0 : to->through[i];
    return kernels->survive(chance[0], safe, weight);
}

static void push_paths(path_wave *p, vertex_block *v, const vertex_keys *keys) {
    const render_plan *plan = p->wave.run.plan;
    lanes3 u;
    shader_sample to;
    path_block path;
    path_numbers(p, keys, SAMPLE_SCATTER, v->shader.lobes != SHADER_DIFFUSE, u);
    if (p->wave.passing) pass_alone(p, v);
    plan->shader_kernels->sample(&v->surface, &v->shader, u, &to);
    if (p->wave.run.samples.first && p->depth) path_show_features(p, v, &to);
    plan->path_kernels->carry(&v->path, &to, path.weight);
    if (plan->dispersive) path_part_paths(p, v, &to, path.weight);
    const uint32_t lanes = survive(p, keys, &to, path.weight) & ((1u << v->surface.count) - 1);
    if (lanes) path_push_lanes(p, v, &to, &path, lanes);
}

/* Fills `next` with scattered rays, and samples lights. */
static void scatter(wave *w, vertex_block *v) {
    path_wave *p = (path_wave *)w;
    vertex_keys keys;
    if (w->run.samples.first && w->run.plan->camera_moves) path_show_depths(p, v);
    if (p->ends) {
        if (w->run.samples.first && p->depth) path_show_features(p, v, NULL);
        return;
    }
    path_find_keys(p, v, &keys);
    if (p->lit) push_light(p, v, &keys);
    push_paths(p, v, &keys);
}

static bool is_in_view(const wave *w, uint32_t slot) { return path_in_view((const path_wave *)w, slot); }

static const wave_stages path_stages = {begin_vertices, path_add_outside, scatter, is_in_view};

static bool begin_scatter(path_wave *p) {
    wave *w = &p->wave;
    w->next.count = 0;
    return p->ends || (wave_reserve_paths(w, &w->next, w->now.count) && wave_begin_shadows(w, w->now.count));
}

static bool add_lights(path_wave *p) {
    wave *w = &p->wave;
    if (!p->lit || p->ends) return true;
    if (p->scout) path_scout_waits(p->scout, w);
    if (!wave_cast_shadows(w, p->depth == 0 ? TRACE_NEIGHBOURS : TRACE_INCOHERENT)) return false;
    if (p->scout) path_scout_sees(p->scout, w);
    w->run.rays.unlit += w->vertex_count - w->shadows.count;
    return true;
}

/* ---- the path loop ---- */

static bool step(path_wave *p) {
    wave *w = &p->wave;
    const bool first = p->depth == 0;
    w->passing = may_pass(p);
    p->ends = p->depth >= w->run.plan->max_depth && !w->passing;
    if (!wave_trace(w, 0, w->now.count, first ? TRACE_COHERENT : TRACE_INCOHERENT)) return false;
    if (!first && p->shows_lamps) path_add_lamps(p);
    if (!first && !wave_sort_hits(w)) return false;
    if (!begin_scatter(p) || !wave_surfaces(w, first) || !add_lights(p)) return false;
    const path_queue kept = w->now;
    w->now = w->next;
    w->next = kept;
    return true;
}

static bool run(integration *state, const wave_region *region, const wave_batch *batch) {
    path_wave *p = (path_wave *)state;
    wave *w = &p->wave;
    wave_begin_samples(w);
    p->lit = !emitters_none(w->run.plan->emitters);
    p->shows_lamps = emitters_any_spheres(w->run.plan->emitters);
    p->light_factor = emitters_mis_factor(w->run.plan->emitters);
    p->looked_through = false;
    path_begin(p, batch);
    if (w->run.plan->caustics) caustics_add(w->run.plan->caustics, w, batch);
    if (!wave_camera_rays(w, region, batch)) return false;
    path_begin_rays(p);
    for (p->depth = 0; w->now.count; ++p->depth) {
        wave_count_rays(w);
        if (!step(p)) return false;
    }
    return true;
}

static void destroy(integration *state) { path_wave_destroy((path_wave *)state); }

void path_wave_destroy(path_wave *p) {
    if (!p) return;
    free(p->media);
    wave_destroy(&p->wave);
    free(p);
}

path_wave *path_wave_create(const render_plan *plan, const atomic_bool *stop, const wave_stages *stages) {
    path_wave *p = calloc(1, sizeof *p);
    if (!p || !wave_create(plan, stop, stages, &p->wave)) {
        free(p);
        return NULL;
    }
    shader_prepare_hole(&p->hidden);
    if ((plan->absorbs || plan->nested) && !(p->media = media_create(plan->shaders))) {
        path_wave_destroy(p);
        return NULL;
    }
    if (plan->moves &&
        (!(p->wave.times = calloc(WAVE_SLOTS, sizeof *p->wave.times)) || !wave_create_vectors(&p->wave))) {
        path_wave_destroy(p);
        return NULL;
    }
    return p;
}

static integration *create(const render_plan *plan, const atomic_bool *stop) {
    path_wave *p = path_wave_create(plan, stop, &path_stages);
    return p ? &p->wave.run : NULL;
}

const integrator integrator_path = {create, run, destroy};
