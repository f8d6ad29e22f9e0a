/* Suns and lamps of the reference. Light samples find all of them; beams, which those leave out, meet suns
 * and lamps that have a size. */
#include "integrate/reference/reference_inner.h"

/* glTF's falloff: the square of a function that is linear in the cosine between the two angles. */
static double spot_falloff(const fathom_light *light, vec3_f64 to_light) {
    if (light->type != FATHOM_LIGHT_SPOT) return 1;
    const double cosine = -dot_f64(to_light, normalize_f64(load_f64(light->direction)));
    const double outer = cos((double)light->outer_angle), inner = cos((double)light->inner_angle);
    const double part = fmin(fmax((cosine - outer) / (inner - outer), 0), 1);
    return part * part;
}

/* Takes a direction that is uniform in the cone around the sphere, whose radiance is 1/R². Points of the
 * surface would have an unbounded variance where the sphere is near. */
static reference_arrival from_sphere(const fathom_light *light, vec3_f64 to, reference_random *random) {
    const double R = (double)light->radius, square = dot_f64(to, to), sine2 = R * R / square;
    const double less = sine2 / (1 + sqrt(1 - sine2)); /* 1 - the cosine of half the cone's angle */
    const vec3_f64 direction =
        reference_around(normalize_f64(to), 1 - less * reference_uniform(random), random);
    const double along = dot_f64(to, direction), root = along * along - (square - R * R);
    return (reference_arrival){direction, along - sqrt(fmax(root, 0)),
                               2 * M_PI * less / (R * R) * spot_falloff(light, direction)};
}

/* An intensity of 1 has the irradiance pi at distance 1. Points inside the sphere see a point. */
static reference_arrival from_place(const fathom_light *light, vec3_f64 point, reference_random *random) {
    const vec3_f64 to = sub_f64(load_f64(light->position), point);
    const double R = (double)light->radius;
    if (R > 0 && length_f64(to) > R) return from_sphere(light, to, random);
    reference_arrival a = {normalize_f64(to), length_f64(to), 0};
    a.power = a.distance > 0 ? M_PI * spot_falloff(light, a.direction) / (a.distance * a.distance) : 0;
    return a;
}

/* As a disc in the sky of half the angle A: radiance 1/sin²A, divided by the density 1 / (2 pi (1 - cos
 * A)). */
static reference_arrival from_afar(const fathom_light *light, reference_random *random) {
    const vec3_f64 axis = normalize_f64(neg_f64(load_f64(light->direction)));
    if (!(light->angular_radius > 0)) return (reference_arrival){axis, (double)INFINITY, M_PI};
    const double half = sin((double)light->angular_radius / 2), less = 2 * half * half;
    const vec3_f64 direction = reference_around(axis, 1 - less * reference_uniform(random), random);
    return (reference_arrival){direction, (double)INFINITY, 2 * M_PI / (2 - less)};
}

vec3_f64 reference_suns(const reference_scene *r, vec3_f64 direction) {
    const size_t count = scene_replaces_lights(r->scene) ? 0 : r->scene->lights.count;
    vec3_f64 sum = {0, 0, 0};
    for (size_t i = 0; i < count; ++i) {
        const fathom_light *light = &r->scene->lights.items[i];
        const double angle = (double)light->angular_radius, sine = sin(angle);
        const vec3_f64 axis = normalize_f64(neg_f64(load_f64(light->direction)));
        if (light->type != FATHOM_LIGHT_DIRECTIONAL || !(angle > 0)) continue;
        if (dot_f64(axis, direction) < cos(angle)) continue;
        sum = add_f64(sum, scale_f64(1 / (sine * sine), color_of(light->intensity)));
    }
    return sum;
}

reference_arrival reference_arrive(const fathom_light *light, vec3_f64 point, reference_random *random) {
    if (light->type == FATHOM_LIGHT_DIRECTIONAL) return from_afar(light, random);
    return from_place(light, point, random);
}

vec3_f64 reference_lamp_seen(const fathom_light *light, vec3_f64 origin, vec3_f64 direction,
                             double *distance) {
    const vec3_f64 from = sub_f64(origin, load_f64(light->position));
    const double R = (double)light->radius, along = dot_f64(from, direction),
                 outside = dot_f64(from, from) - R * R, root = along * along - outside;
    *distance = (double)INFINITY;
    if (light->type == FATHOM_LIGHT_DIRECTIONAL || !(R > 0 && outside > 0 && along < 0 && root > 0))
        return gray(0);
    *distance = -along - sqrt(root);
    return scale_f64(spot_falloff(light, direction) / (R * R), color_of(light->intensity));
}
