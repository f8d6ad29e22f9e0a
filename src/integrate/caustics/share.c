/* Densities of chains: of photons at the light's end, of the camera's paths at the other. */
#include "integrate/caustics/caustics.h"

#include <math.h>

/* Where a line leaves a sphere. False: it misses it. */
static bool leave(const caustic_caster *s, vec3_f64 from, vec3_f64 direction, double *in, double *out) {
    const vec3_f64 way = sub_f64(s->center, from);
    const double middle = dot_f64(way, direction);
    const vec3_f64 off = madd_f64(way, -middle, direction);
    const double square = s->radius * s->radius - dot_f64(off, off);
    if (!(square > 0)) return false;
    *in = middle - sqrt(square), *out = middle + sqrt(square);
    return true;
}

bool caustic_enter(const caustics *c, vec3_f64 from, vec3_f64 direction, double distance,
                   caustic_entry *out) {
    const caustic_caster *first = NULL;
    double at = -INFINITY;
    for (uint32_t k = 0; k < c->count; ++k) {
        double in, end;
        if (!leave(&c->casters[k], from, direction, &in, &end) || in >= distance) continue;
        if (end >= distance) return false; /* the light is inside */
        if (end > at) at = end, first = &c->casters[k];
    }
    if (!first || !(first->chance > 0)) return false;
    const vec3_f64 p = madd_f64(from, at, direction),
                   n = scale_f64(1 / first->radius, sub_f64(p, first->center));
    const double cosine = dot_f64(n, direction);
    if (!(cosine > 0)) return false;
    out->p = narrow(p), out->n = narrow(n);
    out->caster = (uint32_t)(first - c->casters);
    out->density = first->chance / (4 * M_PI * first->radius * first->radius * cosine);
    return true;
}

double caustic_view(const shade_camera *camera, vec3_f64 way, vec3_f64 ng) {
    const double pixel = length_f64(cross_f64(camera->across, camera->down));
    if (camera->parallel) return fabs(dot_f64(camera->view, ng)) / pixel;
    const double square = dot_f64(way, way), length = sqrt(square),
                 cosine = dot_f64(way, camera->view) / length, plane = dot_f64(camera->corner, camera->view);
    return plane * plane * fabs(dot_f64(way, ng)) / (pixel * cosine * cosine * cosine * square * length);
}

bool caustic_follows(const vertex_block *v, const shader_sample *to, unsigned i) {
    const vec3_f32 ng = lane_f32(v->surface.ng, i), n = lane_f32(v->surface.ns, i),
                   d = lane_f32(to->direction, i);
    if (v->surface.mapped >> i & 1 || !(dot_f32(n, lane_f32(v->surface.v, i)) > 0)) return false;
    return caustic_plain(ng, n, d) && (dot_f32(ng, d) < 0) == (to->through[i] != 0);
}

float caustic_stretch(const vertex_block *v, vec3_f32 to_light, vec3_f32 to_camera, unsigned i) {
    const vec3_f32 ng = lane_f32(v->surface.ng, i), n = lane_f32(v->shader.n, i);
    return fabsf(dot_f32(ng, to_camera) * dot_f32(n, to_light)) /
           fabsf(dot_f32(ng, to_light) * dot_f32(n, to_camera));
}

/* A normal map may turn the normal towards the viewer, or away from a grazing one, so that both ends would
 * see different normals. They see the same one if it is not near the horizon of either. */
#define MAPPED_LEAST (1 / 16.0f)

bool caustic_bounces(const render_plan *plan, const vertex_block *v, const shader_sample *to, unsigned i) {
    const vec3_f32 ng = lane_f32(v->surface.ng, i), n = lane_f32(v->surface.ns, i),
                   d = lane_f32(to->direction, i);
    const float least = v->surface.mapped >> i & 1 ? MAPPED_LEAST : 0;
    if (!caustic_begins(plan, v->shader.at[i]) || v->shader.at[i]->lobes & SHADER_TURNED) return false;
    return dot_f32(n, lane_f32(v->surface.v, i)) > least && fabsf(dot_f32(n, d)) > least &&
           caustic_plain(ng, n, d);
}

float caustic_chain(const path_wave *p, const vertex_block *v, const shader_sample *to, unsigned i,
                    uint32_t slot) {
    const render_plan *plan = p->wave.run.plan;
    const vec3_f32 ng = lane_f32(v->surface.ng, i), d = lane_f32(to->direction, i);
    if (!(to->density[i] < INFINITY) || !caustic_begins(plan, v->shader.at[i])) return 0;
    if (!caustic_plain(ng, lane_f32(v->shader.n, i), d)) return 0;
    shade_camera camera = plan->camera;
    if (plan->camera_moves) wave_camera_when(plan, p->wave.times[slot], &camera);
    const vec3_f64 way = sub_f64(widen(lane_f32(v->surface.p, i)), widen(of_slot(p->p, slot)));
    const double view = caustic_view(&camera, way, widen(ng)),
                 chain = view * (double)to->density[i] / fabs((double)dot_f32(ng, d));
    return chain < 0x1p100 ? (float)chain : 0x1p100f;
}
