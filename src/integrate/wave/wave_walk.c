/* Some shadow rays cannot be resolved by an any-hit query. They are walked from closest hit to closest hit,
 * until they reach their light or their gain is 0. If the tracer tells opaque surfaces from others, only rays
 * are walked that meet no opaque point, but points where a part of the light passes.
 *
 * Partly transparent surfaces (`opacity` below 1) and clear thin walls multiply the gain by the fraction of
 * light that passes straight through: the expected value of what paths do by chance.
 *
 * Shapes that cast no shadow are skipped on the way to lights that rays cannot hit. They block the light of
 * all other emitters, because BSDF-sampled rays hit these shapes, too, and scatter there. */
#include "integrate/wave/wave.h"

#include <string.h>

bool wave_note_ends(wave *w) {
    shadow_queue *queue = &w->shadows;
    if (!wave_reserve_paths(w, &w->now, queue->count)) return false;
    for (size_t k = 0; k < queue->count; ++k)
        queue->ends[k] = (shadow_end){queue->rays[k / LANES].t_far[k % LANES],
                                      queue->shadows[k / LANES].sized[k % LANES] != 0,
                                      queue->tags ? queue->tags[k] : (light_tag){0}};
    return true;
}

static void take(wave *w, size_t k) {
    const shadow_queue *queue = &w->shadows;
    const shadow_block *shadows = &queue->shadows[k / LANES];
    const size_t i = k % LANES, lane = w->now.count % LANES;
    trace_rays *rays = &w->now.rays[w->now.count / LANES].rays;
    path_block *path = &w->now.paths[w->now.count / LANES];
    trace_rays_move(&queue->rays[k / LANES], i, rays, lane);
    rays->t_far[lane] = queue->ends[k].length;
    queue->ends[w->now.count++] = queue->ends[k];
    for (int c = 0; c < 3; ++c) path->weight[c][lane] = shadows->gain[c][i];
    path->slot[lane] = shadows->slot[i];
    path->depth[lane] = shadows->depth[i];
}

/* The shadow rays replace the paths in `now`, whose hits are vertices already. From here on, `ends` belongs
 * to them. */
void wave_take_shadows(wave *w) {
    const render_plan *plan = w->run.plan;
    const bool told = trace_tells_opaque(plan->tracer);
    w->now.count = 0;
    for (size_t k = 0; k < w->shadows.count; ++k) {
        float *t_far = &w->shadows.rays[k / LANES].t_far[k % LANES];
        const bool stopped = !plan->to_camera && (!plan->covered || (told && *t_far == -INFINITY));
        if (*t_far < 0 ? stopped : !(plan->unshadowed && w->shadows.ends[k].sized)) continue;
        take(w, k);
        *t_far = -INFINITY;
    }
}

static void add_reached(wave *w, const path_block *path, size_t lane, light_tag tag, vec3_f32 direction) {
    const float gain[3] = {path->weight[0][lane], path->weight[1][lane], path->weight[2][lane]};
    for (int c = 0; c < 3; ++c) w->run.samples.radiance[c][path->slot[lane]] += gain[c];
    if (w->run.samples.layers) wave_add_layers(w, path->slot[lane], tag, direction, gain);
}

/* The surface in lane i is skipped by light that no ray can hit. */
static bool is_skipped(const wave *w, unsigned i, bool sized) {
    const world *scene = w->run.plan->world;
    const surface_gather *g = w->gather;
    const unsigned flags = g->geometry[i] == TRACE_PLANE ? scene->planes.items[g->primitive[i]].flags
                                                         : scene->geometries.items[g->geometry[i]].flags;
    return flags & FATHOM_CASTS_NO_SHADOW && !sized;
}

/* Light that passes here shows the camera the back of a one-sided surface. */
static bool is_back(const wave *w, const surface_block *s, unsigned i) {
    return s->entering[i] && w->run.plan->shaders[wave_hit_material(w, i)].one_sided;
}

static float hole_at(const wave *w, unsigned i) {
    const render_plan *plan = w->run.plan;
    const fathom_id material = wave_hit_material(w, i);
    if (plan->texturing) return 1 - texturing_opacity(plan->texturing, w->gather, i, material);
    return plan->shaders[material].hole;
}

/* What clear thin walls among the lanes let pass, as sample() of their materials has it. */
static void find_panes(wave *w, surface_block *s, lanes3 part) {
    const render_plan *plan = w->run.plan;
    static const float no_width[LANES];
    shader_block b;
    for (unsigned i = 0; i < LANES; ++i) {
        s->material[i] = wave_hit_material(w, i < s->count ? i : s->count - 1);
        b.at[i] = &plan->shaders[s->material[i]];
    }
    if (plan->texturing)
        texturing_shade(plan->texturing, w->gather, no_width, ~0u, NULL, s, w->made[0], b.at);
    memset(b.channel, 0, sizeof b.channel);
    plan->shader_kernels->make(s, &b);
    for (unsigned i = 0; i < s->count; ++i) {
        for (int c = 0; c < 3; ++c) part[c][i] = b.at[i]->clear ? b.pass_share[c][i] : 0;
    }
}

/* The fraction of light that passes the surfaces straight. */
static void find_parts(wave *w, surface_block *s, lanes3 part) {
    memset(part, 0, 3 * sizeof *part);
    if (w->run.plan->panes) find_panes(w, s, part);
    for (unsigned i = 0; i < s->count; ++i) {
        const float hole = hole_at(w, i);
        for (int c = 0; c < 3; ++c) part[c][i] += hole;
    }
}

/* The remaining length from `start` on, less its rounding error: 5 units for the product, and 1 for the
 * difference. */
static float remaining(float end, const float start[3], vec3_f32 origin, vec3_f32 direction) {
    const vec3_f32 way = sub_f32(load_f32(start), origin);
    return end < INFINITY ? end - dot_f32(way, direction) - end * (8 * 0x1p-24f) : end;
}

/* Continues the ray `from` behind lane i of the surfaces. */
static void move_on(wave *w, size_t from, const surface_block *s, unsigned i, const lanes3 part) {
    const watertight *closed = w->run.plan->watertight;
    const trace_block *block = &w->now.rays[from / LANES];
    const path_block *path = &w->now.paths[from / LANES];
    const size_t old = from % LANES, lane = w->now.count % LANES;
    uint8_t depth = path->depth[old];
    float start[3];
    if (closed) depth = watertight_sides_of(closed, block, (unsigned)old, depth).behind;
    for (int c = 0; c < 3; ++c) start[c] = surface_start(s->p[c][i], -s->offset[i], s->ng[c][i]);
    shadow_end end = w->shadows.ends[from];
    end.length = remaining(end.length, start, trace_org(&block->rays, old), trace_dir(&block->rays, old));
    path_block *to = &w->now.paths[w->now.count / LANES];
    for (int c = 0; c < 3; ++c) to->weight[c][lane] = path->weight[c][old] * part[c][i];
    to->slot[lane] = path->slot[old], to->depth[lane] = depth;
    if (!(end.length > 0)) {
        add_reached(w, to, lane, end.tag, trace_dir(&block->rays, old));
        return;
    }
    trace_rays *rays = &w->now.rays[w->now.count / LANES].rays;
    trace_rays_move(&block->rays, old, rays, lane);
    rays->org_x[lane] = start[0], rays->org_y[lane] = start[1], rays->org_z[lane] = start[2];
    rays->t_far[lane] = end.length;
    w->shadows.ends[w->now.count++] = end;
}

/* Handles the lanes of a block that hit something. Rays that continue move to the front of the queue: no ray
 * overwrites one that is still waiting. */
static void pass_surfaces(wave *w, size_t done, uint32_t met) {
    const render_plan *plan = w->run.plan;
    surface_block s;
    lanes3 part;
    unsigned lanes[LANES], count = 0;
    surface_gather_begin(w->gather);
    for (; met; met &= met - 1) {
        lanes[count++] = (unsigned)__builtin_ctz(met);
        surface_gather_add(w->gather, plan->world, &w->now.rays[done / LANES], lanes[count - 1]);
    }
    if (!count) return;
    surface_gather_end(w->gather, plan->world, plan->surface_kernels, false, !(plan->settings.epsilon > 0),
                       &s);
    s.count = count;
    find_parts(w, &s, part);
    for (unsigned i = 0; i < count; ++i) {
        const bool skipped = is_skipped(w, i, w->shadows.ends[done + lanes[i]].sized) ||
                             (plan->to_camera && is_back(w, &s, i));
        for (int c = 0; c < 3 && skipped; ++c) part[c][i] = 1;
        if (part[0][i] > 0 || part[1][i] > 0 || part[2][i] > 0) move_on(w, done + lanes[i], &s, i, part);
    }
}

bool wave_walk_shadows(wave *w) {
    while (w->now.count) {
        const size_t count = w->now.count;
        w->run.rays.shadow += count;
        if (!wave_trace(w, 0, count, TRACE_INCOHERENT)) return false;
        w->now.count = 0;
        for (size_t done = 0; done < count; done += LANES) {
            const trace_block *block = &w->now.rays[done / LANES];
            const uint32_t lanes = (1u << wave_lanes(count, done)) - 1,
                           met = w->run.plan->kernels->met(&block->hits) & lanes;
            for (uint32_t seen = lanes & ~met; seen; seen &= seen - 1) {
                const size_t i = (size_t)__builtin_ctz(seen);
                add_reached(w, &w->now.paths[done / LANES], i, w->shadows.ends[done + i].tag,
                            trace_dir(&block->rays, i));
            }
            pass_surfaces(w, done, met);
        }
    }
    return true;
}
