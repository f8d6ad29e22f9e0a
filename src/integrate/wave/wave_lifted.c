/* Points of smooth meshes are lifted off their facets, because a facet shades its neighbours where the round
 * surface would not. But other geometry may lie in between: a cube with smooth normals stands on a floor that
 * covers the lifted points near its base. So a light is visible if either the lifted point or the point
 * itself sees it: lifting only adds light. The second ray is traced if the first was occluded and the facet
 * faces the light; otherwise the facet itself would occlude it. */
#include "integrate/wave/wave.h"

#include <string.h>

/* Rays from facets, and the indices in the queue of the rays that they replace. */
typedef struct second_look {
    light_block from;
    size_t ray[LANES];
    _Alignas(16) uint8_t depth[LANES], end_depth[LANES];
    unsigned count;
    uint32_t light;
} second_look;

static bool is_lifted(const surface_block *s, unsigned i) {
    return s->lift[0][i] != 0 || s->lift[1][i] != 0 || s->lift[2][i] != 0;
}

static bool faces(const surface_block *s, unsigned i, const shade_light *light) {
    vec3_f32 ng = {s->ng[0][i], s->ng[1][i], s->ng[2][i]}, p = {s->p[0][i], s->p[1][i], s->p[2][i]};
    bool parallel = light->type == FATHOM_LIGHT_DIRECTIONAL;
    return dot_f32(ng, parallel ? light->to_light : sub_f32(light->position, p)) > 0;
}

static void add_ray(wave *w, second_look *look, const surface_block *s, unsigned i, size_t ray) {
    const shadow_block *shadows = &w->shadows.shadows[ray / LANES];
    for (int c = 0; c < 3; ++c)
        look->from.origin[c][look->count] = surface_start(s->p[c][i], s->offset[i], s->ng[c][i]);
    look->depth[look->count] = shadows->depth[ray % LANES];
    look->end_depth[look->count] = shadows->end_depth[ray % LANES];
    look->ray[look->count++] = ray;
}

/* Traces the collected rays. */
static void cast(wave *w, second_look *look, trace_coherence coherence) {
    static const lanes3 no_gain;
    const render_plan *plan = w->run.plan;
    trace_rays rays;
    memset(&rays, 0, sizeof rays);
    plan->light_kernels->aim(&plan->lights[look->light], &look->from);
    plan->kernels->shadow_rays(&look->from, no_gain, plan->t_near, &rays);
    trace_any(plan->tracer, &rays, look->count, coherence);
    w->run.rays.shadow += look->count;
    if (plan->watertight)
        w->run.rays.repaired +=
            watertight_any(plan->watertight, &rays, look->depth, look->end_depth, look->count);
    for (unsigned i = 0; i < look->count; ++i) {
        const size_t ray = look->ray[i];
        if (!(rays.t_far[i] < 0)) w->shadows.rays[ray / LANES].t_far[ray % LANES] = 0;
    }
    look->count = 0;
}

static uint32_t shadowed(const trace_rays *rays) {
    uint32_t bits = 0;
    for (int i = 0; i < LANES; ++i) bits |= rays->t_far[i] < 0 ? 1u << i : 0;
    return bits;
}

/* Rays to one light are traced together. */
static void look_again(wave *w, second_look *look, size_t ray, trace_coherence coherence) {
    const shadow_source source = w->shadows.sources[ray];
    const surface_block *s = &w->vertices[source.vertex / LANES].surface;
    const unsigned i = source.vertex % LANES;
    if (!is_lifted(s, i) || !faces(s, i, &w->run.plan->lights[source.light])) return;
    if (look->count && look->light != source.light) cast(w, look, coherence);
    look->light = source.light;
    add_ray(w, look, s, i, ray);
    if (look->count == LANES) cast(w, look, coherence);
}

void wave_look_from_facets(wave *w, trace_coherence coherence) {
    const shadow_queue *queue = &w->shadows;
    second_look look;
    memset(&look, 0, sizeof look);
    for (size_t done = 0; done < queue->count; done += LANES) {
        uint32_t bits = shadowed(&queue->rays[done / LANES]);
        bits &= (1u << wave_lanes(queue->count, done)) - 1;
        for (; bits; bits &= bits - 1) look_again(w, &look, done + (size_t)__builtin_ctz(bits), coherence);
    }
    if (look.count) cast(w, &look, coherence);
}
