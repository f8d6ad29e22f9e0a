/* Classic recursive ray tracing: each vertex gets the light of every light source, and sends a mirrored and a
 * refracted ray. Whitted, "An improved illumination model for shaded display" (1980), with Phong's and
 * Blinn's highlights. */
#include "integrate/wave/wave.h"
#include "math/limit.h"

#include <stdlib.h>
#include <string.h>

/* ---- hits and misses ---- */

static light_tag tag_after(uint32_t bounces, uint8_t group) {
    return (light_tag){(uint8_t)light_kind_of(bounces), group};
}

/* There is no environment, so the direction is not used. */
static const vec3_f32 anywhere = {0, 0, 0};

static uint8_t background_group(const render_plan *plan) {
    return plan->groups.count ? plan->groups.of[FATHOM_SOURCE_BACKGROUND][0] : 0;
}

static bool emits(const bsdf_block *b) {
    float sum = 0;
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) sum += b->emission[c][i];
    }
    return sum > 0;
}

static void make_bsdfs(wave *w, vertex_block *v) {
    const render_plan *plan = w->run.plan;
    const bsdf *at[LANES];
    bsdf made[LANES];
    for (int i = 0; i < LANES; ++i) at[i] = &plan->bsdfs[v->surface.material[i]];
    if (plan->texturing) texturing_classic(plan->texturing, w->gather, &v->surface, made, at);
    plan->material_kernels->make(at, &v->bsdf);
    for (unsigned i = 0; w->run.samples.layers && i < v->surface.count; ++i)
        v->group[i] = wave_hit_group(w, i); /* as long as the hits are in w->gather */
}

static void add_background(wave *w, const trace_block *block, const path_block *path, uint32_t missed) {
    (void)block;
    const float *background = w->run.plan->scene->background;
    for (; missed; missed &= missed - 1) {
        int i = __builtin_ctz(missed);
        uint32_t slot = path->slot[i];
        float rgb[3];
        for (int c = 0; c < 3; ++c) {
            rgb[c] = limited(path->weight[c][i] * background[c]);
            w->run.samples.radiance[c][slot] += rgb[c];
        }
        if (w->run.samples.layers)
            wave_add_layers(w, slot, tag_after(w->bounces, background_group(w->run.plan)), anywhere, rgb);
    }
}

static const wave_stages classic_stages = {make_bsdfs, add_background, NULL, NULL};

/* ---- light ---- */

static void add_emission_layers(wave *w, const vertex_block *v, const lanes3 value) {
    for (unsigned i = 0; i < v->surface.count; ++i) {
        const float rgb[3] = {value[0][i], value[1][i], value[2][i]};
        wave_add_layers(w, v->path.slot[i], tag_after(w->bounces, v->group[i]), anywhere, rgb);
    }
}

/* Ambient and emitted light. Its layers are added here too, after all misses: a sample has several paths, and
 * the order of its sums must not depend on how they share blocks with paths of others. */
static void add_emission(wave *w, const vertex_block *v) {
    lanes3 value;
    if (!emits(&v->bsdf)) return;
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) value[c][i] = limited(v->path.weight[c][i] * v->bsdf.emission[c][i]);
        for (uint32_t i = 0; i < v->surface.count; ++i)
            w->run.samples.radiance[c][v->path.slot[i]] += value[c][i];
    }
    if (w->run.samples.layers) add_emission_layers(w, v, (const float(*)[LANES])value);
}

/* Rounded upwards: `lost` is never less than the sum of the gains, however many are added. */
static float sum_above(float lost, float gain) { return (lost + gain) * (1 + 0x1p-21f); }

static bool may_lose(const wave *w, uint32_t slot, const lanes3 gain, uint32_t i) {
    const fathom_settings *settings = &w->run.plan->settings;
    for (int c = 0; c < 3; ++c) {
        float most = settings->max_loss + settings->max_relative_loss * w->run.samples.radiance[c][slot];
        if (!(sum_above(w->lost[c][slot], gain[c][i]) <= most)) return false;
    }
    return true;
}

/* Skips gains that are not worth a shadow ray. If every light were visible, a sample would lose at most
 * max_loss + max_relative_loss R, with R its radiance so far: radiance only grows, so R is at most the
 * sample's final radiance. A pixel is the mean of its samples, and loses at most max_loss + max_relative_loss
 * times its value. Each sample depends only on its own paths, in their order, so the grouping into blocks
 * changes nothing. */
static void leave_out_faint(wave *w, const vertex_block *v, light_block *light, lanes3 gain) {
    for (uint32_t i = 0; i < v->surface.count; ++i) {
        const uint32_t slot = v->path.slot[i];
        if (!(gain[0][i] + gain[1][i] + gain[2][i] > 0) || !may_lose(w, slot, gain, i)) continue;
        for (int c = 0; c < 3; ++c) {
            w->lost[c][slot] = sum_above(w->lost[c][slot], gain[c][i]);
            gain[c][i] = 0;
        }
        light->distance[i] = 0;
        ++w->run.rays.faint;
    }
}

/* The gains of a block of vertices from a light, and the shadow rays towards it. */
static void push_light(wave *w, size_t block, uint32_t index, bool first) {
    const render_plan *plan = w->run.plan;
    const shade_light *light = &plan->lights[index];
    const vertex_block *v = &w->vertices[block];
    light_block sample;
    bsdf_value value;
    lanes3 gain;
    plan->light_kernels->sample(light, v->surface.p, &sample);
    if (!plan->material_kernels->evaluate(&v->surface, &v->bsdf, sample.direction, sample.falloff, &value))
        return;
    plan->surface_kernels->starts(&v->surface, sample.direction, value.behind, sample.origin);
    if (light->type != FATHOM_LIGHT_DIRECTIONAL) plan->light_kernels->aim(light, &sample);
    plan->kernels->gains(&v->path, &sample, &value, gain);
    if (w->lost[0]) leave_out_faint(w, v, &sample, gain);
    shadow_depths depths;
    memcpy(depths.start, v->path.depth, sizeof depths.start);
    memset(depths.sized, 0, sizeof depths.sized);
    memset(depths.end, plan->watertight ? plan->light_depths[index] : WATERTIGHT_UNSURE, sizeof depths.end);
    for (int i = 0; w->run.samples.layers && i < LANES; ++i)
        depths.tag[i] = tag_after(w->bounces + 1, plan->light_group_of[index]);
    wave_push_shadows(w, block, &sample, &depths, gain, first);
}

/* One light at a time, because rays to one point are coherent. */
static bool add_light(wave *w, uint32_t index, bool first) {
    const uint64_t faint = w->run.rays.faint;
    if (!wave_begin_shadows(w, w->vertex_count)) return false;
    for (size_t b = 0; b < wave_blocks(w->vertex_count); ++b) push_light(w, b, index, first);
    if (!wave_cast_shadows(w, first ? TRACE_COHERENT : TRACE_INCOHERENT)) return false;
    w->run.rays.unlit += w->vertex_count - w->shadows.count - (w->run.rays.faint - faint);
    return true;
}

static bool add_lights(wave *w, bool first) {
    for (size_t b = 0; b < wave_blocks(w->vertex_count); ++b) add_emission(w, &w->vertices[b]);
    for (uint32_t i = 0; i < w->run.plan->light_count; ++i) {
        if (!add_light(w, i, first)) return false;
    }
    return true;
}

/* ---- mirrored and refracted rays ---- */

static void push_path(wave *w, const vertex_block *v, const scatter_block *from, const float weight[3],
                      const uint8_t *depths, uint32_t i) {
    size_t block = w->next.count / LANES, lane = w->next.count % LANES;
    trace_rays *rays = &w->next.rays[block].rays;
    path_block *path = &w->next.paths[block];
    rays->org_x[lane] = from->origin[0][i];
    rays->org_y[lane] = from->origin[1][i];
    rays->org_z[lane] = from->origin[2][i];
    rays->dir_x[lane] = from->direction[0][i];
    rays->dir_y[lane] = from->direction[1][i];
    rays->dir_z[lane] = from->direction[2][i];
    rays->t_near[lane] = w->run.plan->t_near;
    rays->t_far[lane] = INFINITY;
    for (int c = 0; c < 3; ++c) path->weight[c][lane] = weight[c];
    path->slot[lane] = v->path.slot[i];
    path->depth[lane] = depths[i];
    ++w->next.count;
}

/* A path ends here if its weight is at most min_weight. */
static bool push_paths(wave *w, const vertex_block *v, const scatter_block *from, const uint8_t *depths) {
    const float limit = w->run.plan->settings.min_weight;
    if (!wave_reserve_paths(w, &w->next, LANES)) return false;
    for (uint32_t i = 0; i < v->surface.count; ++i) {
        float weight[3];
        for (int c = 0; c < 3; ++c) weight[c] = limited(v->path.weight[c][i] * from->share[c][i]);
        if (weight[0] > limit || weight[1] > limit || weight[2] > limit)
            push_path(w, v, from, weight, depths, i);
    }
    return true;
}

/* Fills `next`: mirrored rays, then refracted ones. Rays of one kind are coherent; packets of both kinds
 * would not be. */
static bool scatter(wave *w) {
    const material_kernels *kernels = w->run.plan->material_kernels;
    const bool refracts = (w->run.plan->features & MATERIAL_REFRACT) != 0;
    const size_t blocks = wave_blocks(w->vertex_count);
    if (refracts && !wave_reserve_refracted(w, blocks)) return false;
    for (size_t b = 0; b < blocks; ++b) {
        const vertex_block *v = &w->vertices[b];
        scatter_block mirrored, none;
        kernels->scatter(&v->surface, &v->bsdf, &mirrored, refracts ? &w->refracted[b] : &none);
        if (!push_paths(w, v, &mirrored, v->path.depth)) return false;
    }
    w->next.mirrored = w->next.count;
    for (size_t b = 0; refracts && b < blocks; ++b) {
        const vertex_block *v = &w->vertices[b];
        if (!push_paths(w, v, &w->refracted[b], v->depth_behind)) return false;
    }
    w->run.rays.reflection += w->next.mirrored;
    w->run.rays.refraction += w->next.count - w->next.mirrored;
    return true;
}

/* ---- the path loop ---- */

/* The coherence of the mirrored or of the other rays of `now` at this depth. Mirrored rays of the first hits
 * start at neighbouring points, and most of them do not hit the same surface again. Refracted rays cross the
 * object that they enter, and reach its other side far from one another. */
static trace_coherence classic_coherence(uint32_t depth, bool mirrored) {
    if (depth == 0) return TRACE_COHERENT;
    return depth == 1 && mirrored ? TRACE_NEIGHBOURS : TRACE_INCOHERENT;
}

/* A block of both kinds counts as refracted. */
static bool trace_paths(wave *w, uint32_t depth) {
    size_t count = w->now.count, mirrored = w->now.mirrored;
    if (depth == 0) mirrored = 0;
    if (mirrored < count) mirrored -= mirrored % LANES;
    return wave_trace(w, 0, mirrored, classic_coherence(depth, true)) &&
           wave_trace(w, mirrored, count, classic_coherence(depth, false));
}

/* The stages after the camera's: the hits of `now`, their light, and the rays that leave them, which become
 * the next `now`. Repeated until no rays remain; depth counts up from 0. */
static bool classic_step(wave *w, uint32_t depth) {
    w->bounces = depth;
    if (!trace_paths(w, depth)) return false;
    if (!wave_surfaces(w, depth == 0) || !add_lights(w, depth == 0)) return false;
    w->next.count = 0;
    if (depth < w->run.plan->max_depth && !scatter(w)) return false;
    path_queue kept = w->now;
    w->now = w->next;
    w->next = kept;
    return true;
}

static bool run(integration *state, const wave_region *region, const wave_batch *batch) {
    wave *w = (wave *)state;
    wave_begin_samples(w);
    if (w->lost[0]) memset(w->lost[0], 0, 3 * WAVE_SLOTS * sizeof(float));
    if (!wave_camera_rays(w, region, batch)) return false;
    for (uint32_t depth = 0; w->now.count; ++depth) {
        wave_count_rays(w);
        if (!classic_step(w, depth)) return false;
    }
    return true;
}

static integration *create(const render_plan *plan, const atomic_bool *stop) {
    wave *w = malloc(sizeof *w);
    if (w && wave_create(plan, stop, &classic_stages, w)) return &w->run;
    free(w);
    return NULL;
}

static void destroy(integration *state) {
    if (!state) return;
    wave_destroy((wave *)state);
    free(state);
}

const integrator integrator_classic = {create, run, destroy};
