/* Point and spot lights: samples of their light, and the spheres of those that have a radius, which scattered
 * rays find.
 *
 * Such a lamp is a sphere of the radiance k_l / r²; each of its points has the lamp's falloff. It blocks no
 * ray. Points inside the sphere see the lamp as one without size at its centre. So do points so far away that
 * the sphere is too small to be hit. */
#include "light/emitters_inner.h"

#include <stdlib.h>
#include <string.h>

/* ---- spheres ---- */

/* False: the lamp has no size as seen from the point. from: the vector from the lamp to the point. */
static bool find_cone(const emitter_lamp *lamp, vec3_f64 from, shape_cone *out) {
    const double r = (double)lamp->radius;
    if (!lamp->sphere || !(dot_f64(from, from) > r * r)) return false;
    *out = shape_cone_of(from, r);
    return out->cap > 0x1p-100;
}

/* direction: unit, towards the lamp. */
static vec3_f32 radiance_of(const emitter_lamp *lamp, vec3_f32 direction) {
    const double r = (double)lamp->radius;
    float falloff = 1;
    if (lamp->light.type == FATHOM_LIGHT_SPOT)
        falloff = light_falloff(&lamp->light, direction.x, direction.y, direction.z);
    return narrow(scale_f64((double)falloff / (r * r), widen(load_f32(lamp->light.intensity))));
}

/* ---- samples ---- */

static void sample_sphere(const emitter_lamp *lamp, vec3_f64 from, const shape_cone *cone, double u, double v,
                          emitter_sample *out, unsigned i) {
    const vec3_f64 d = shape_cone_sample(cone, u, v);
    const double end = shape_sphere_root(from, d, (double)lamp->radius, -1) * (1 - 0x1p-20);
    put_lane_f32(out->direction, i, narrow(d));
    put_lane_f32(out->radiance, i, radiance_of(lamp, narrow(d)));
    out->distance[i] = (float)fmax(end, 0x1p-126);
}

static void sample_point(const light_block *seen, const light_block *aimed, emitter_sample *out, unsigned i) {
    out->distance[i] = aimed->distance[i];
    for (int k = 0; k < 3; ++k) {
        out->direction[k][i] = aimed->direction[k][i];
        out->radiance[k][i] = (float)SHAPE_PI * (seen->radiance[k][i] * seen->falloff[i]);
    }
}

static void sample_lamp(const emitters *e, const emitter_lamp *lamp, const emitter_choices *c, unsigned lanes,
                        emitter_sample *out) {
    light_block seen, aimed;
    e->points->sample(&lamp->light, c->from->p, &seen);
    memcpy(aimed.origin, c->from->p, sizeof aimed.origin);
    e->points->aim(&lamp->light, &aimed);
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        const vec3_f64 from = sub_f64(widen(lane_f32(c->from->p, i)), widen(lamp->light.position));
        shape_cone cone;
        if (find_cone(lamp, from, &cone)) {
            sample_sphere(lamp, from, &cone, (double)c->u[0][i], (double)c->u[1][i], out, i);
            out->density[i] = density_f32(c->chance[i] / shape_cone_angle(&cone));
            out->sized[i] = e->found ? ~0u : 0;
        } else {
            sample_point(&seen, &aimed, out, i);
            out->density[i] = seen.distance[i] > 0 ? (float)c->chance[i] : 0;
            out->sized[i] = 0;
        }
    }
}

/* Samples lanes that chose the same lamp together. */
void emitters_sample_lamps(const emitters *e, const emitter_choices *c, emitter_sample *out) {
    for (unsigned left = c->lamps; left;) {
        const uint32_t emitter = c->emitter[lane_first(left)];
        unsigned same = 0;
        for (unsigned i = 0; i < LANES; ++i) {
            if (left >> i & 1 && c->emitter[i] == emitter) same |= 1u << i;
        }
        sample_lamp(e, &e->lamps[emitter - e->surface_count], c, same, out);
        left &= ~same;
    }
}

/* ---- scattered rays ---- */

/* The other lamps' radiance would leave the range of float. */
static bool is_sphere(const emitter_lamp *lamp) {
    const float *k = lamp->light.intensity;
    const double most = (double)fmaxf(fmaxf(k[0], k[1]), k[2]), r = (double)lamp->radius;
    return r > 0 && most < 0x1p100 * r * r;
}

bool emitters_prepare_lamps(emitters *e) {
    tree_item *items = calloc(e->lamp_count + 1, sizeof *items);
    uint32_t *slots = calloc(e->lamp_count + 1, sizeof *slots), count = 0;
    bool fine = items && slots;
    for (uint32_t i = 0; fine && i < e->lamp_count; ++i) {
        if (!(e->lamps[i].sphere = is_sphere(&e->lamps[i]))) continue;
        items[count].light = i;
        emitters_lamp_item(&e->lamps[i], &items[count++]);
    }
    fine = fine && tree_build(items, count, &e->spheres, slots);
    free(items);
    free(slots);
    return fine;
}

bool emitters_any_spheres(const emitters *e) { return e->spheres.nodes != NULL; }

/* The lamps that part of a ray meets. */
typedef struct lamp_search {
    const emitters *e;
    const emitter_ray *ray;
    void (*found)(void *user, const emitter_disc *lamp);
    void *user;
    vec3_f32 p; /* in the tree's scale, as `length` */
    float length;
} lamp_search;

static float density_of(const emitters *e, uint32_t k, vec3_f32 p, vec3_f32 n, const shape_cone *cone) {
    double chance = emitters_shares(e, p, n)->of[EMITTER_FINITE];
    if (e->only == FATHOM_NONE)
        chance *= tree_chance(&e->lights, p, n, emitters_view(e, p, n), e->slot_of[e->surface_count + k]);
    return density_f32(chance / shape_cone_angle(cone));
}

float emitters_sphere_density(const emitters *e, uint32_t lamp, vec3_f32 p, vec3_f32 n) {
    const emitter_lamp *l = &e->lamps[lamp];
    shape_cone cone;
    if (!e->found || !find_cone(l, sub_f64(widen(p), widen(l->light.position)), &cone)) return 0;
    return density_of(e, lamp, p, n, &cone);
}

static void look_at(const lamp_search *s, uint32_t k) {
    const emitter_lamp *lamp = &s->e->lamps[k];
    const emitter_ray *ray = s->ray;
    const vec3_f64 from = sub_f64(widen(ray->p), widen(lamp->light.position)),
                   d = normalize_f64(widen(ray->direction));
    shape_cone cone;
    if (!find_cone(lamp, from, &cone) || !shape_cone_holds(&cone, d)) return;
    const double distance = shape_sphere_root(from, d, (double)lamp->radius, -1);
    if (!(distance >= (double)ray->from && distance < (double)ray->to)) return;
    emitter_disc disc = {.distance = (float)distance, .lamp = k, .group = lamp->group};
    store_f32(disc.radiance, radiance_of(lamp, ray->direction));
    if (!(disc.radiance[0] + disc.radiance[1] + disc.radiance[2] > 0)) return;
    if (!ray->smooth) disc.density = density_of(s->e, k, ray->p, ray->n, &cone);
    s->found(s->user, &disc);
}

static void walk(const lamp_search *s, uint32_t at) {
    const tree_node *node = &s->e->spheres.nodes[at];
    unsigned met = s->e->spheres.kernels->meet(node, s->p, s->ray->direction, s->length);
    for (; met; met &= met - 1) {
        const uint32_t child = node->child[lane_first(met)];
        if (child & TREE_LEAF)
            look_at(s, child & ~TREE_LEAF);
        else
            walk(s, child);
    }
}

/* Rays of rough lobes add nothing where light samples count alone. */
void emitters_find_spheres(const emitters *e, const emitter_ray *ray,
                           void (*found)(void *user, const emitter_disc *lamp), void *user) {
    if (!e->found && !ray->smooth) return;
    const float scale = e->spheres.scale;
    const lamp_search s = {e, ray, found, user, scale_f32(scale, ray->p), scale * ray->to};
    walk(&s, 0);
}
