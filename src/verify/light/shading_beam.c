#include "verify/light/shading_studio.h"

beam beam_start(vec3_f64 eye, vec3_f64 direction) {
    return (beam){.at = eye, .along = direction, .turned = SHADING_U};
}

/* Rounding of t and of the primitive's coordinates moves the point by less than 16 u of both. The next ray
 * starts up to 32 u of the size off the surface (bench/offset.sh); the bound uses twice that. */
void beam_go(beam *b, double t, double size) {
    b->at = madd_f64(b->at, t, b->along);
    b->aside += t * b->turned + 16 * SHADING_U * (size + t) + 64 * SHADING_U * size;
}

/* -v + 2(n·v)n: n·v has 3 roundings, the sum 2 per component, the normalisation 3. */
void beam_mirror(beam *b, vec3_f64 normal, double normal_error) {
    b->along = normalize_f64(madd_f64(b->along, -2 * dot_f64(b->along, normal), normal));
    b->turned += 2 * normal_error + 8 * SHADING_U;
}

typedef struct snell {
    vec3_f64 aside; /* v's component along the surface, v = -along */
    double sine, cos2, sine_error, cos2_error;
} snell;

/* The error of the sine is that of the beam's direction, that of the normal, and 4 roundings. 1 - eta^2 sin^2
 * has twice this relative error, 6 roundings of eta and of the products, and its own. At large angles to the
 * normal, the cosine replaces the sine: 1 - eta^2 + eta^2 cos^2 has the same number of roundings of eta^2. */
static snell snell_at(const beam *b, vec3_f64 normal, double normal_error, double eta) {
    snell s;
    double cos_in = -dot_f64(b->along, normal);
    s.aside = neg_f64(madd_f64(b->along, cos_in, normal));
    s.sine = length_f64(s.aside);
    s.sine_error = b->turned + 2 * normal_error + 4 * SHADING_U;
    double grazing = s.sine * s.sine < 0.5 ? s.sine * s.sine : 1;
    s.cos2 = cos_in * cos_in < 0.5 ? (1 - eta) * (1 + eta) + eta * cos_in * eta * cos_in
                                   : 1 - eta * s.sine * eta * s.sine;
    s.cos2_error = eta * eta * (2 * s.sine * s.sine_error + s.sine_error * s.sine_error) +
                   6 * SHADING_U * eta * eta * grazing + 2 * SHADING_U;
    return s;
}

double beam_doubt(const beam *b, vec3_f64 normal, double normal_error, double eta) {
    snell s = snell_at(b, normal, normal_error, eta);
    return s.cos2 / s.cos2_error;
}

/* The direction is -eta aside - cos_out n. Its error is eta times the sine's error and roundings, plus half
 * the squared cosine's error divided by the cosine. The distance between the two lines changes by the ratio
 * of the cosines. */
bool beam_refract(beam *b, vec3_f64 normal, double normal_error, double eta) {
    snell s = snell_at(b, normal, normal_error, eta);
    if (!(s.cos2 > 0)) return false;
    double cos_in = -dot_f64(b->along, normal), cos_out = sqrt(s.cos2);
    b->aside *= fmax(1, cos_out / cos_in);
    b->turned = eta * s.sine_error + 4 * SHADING_U * eta * s.sine + s.cos2_error / (2 * cos_out) +
                normal_error + 8 * SHADING_U;
    b->along = normalize_f64(madd_f64(scale_f64(-eta, s.aside), -cos_out, normal));
    return true;
}

/* h / r^3 changes by a fraction of at most 3/r + 1/h for each unit that the point moves, and has about 24
 * roundings. */
double beam_radiance(const beam *b, vec3_f64 light, vec3_f64 normal, double size, double *bound) {
    vec3_f64 to_light = sub_f64(light, b->at);
    double h = dot_f64(to_light, normal), r = length_f64(to_light);
    double slant = fabs(dot_f64(b->along, normal)), value = h / (r * r * r);
    double moved = b->aside / slant + 16 * SHADING_U * size;
    *bound = value * ((3 / r + 1 / h) * moved + 24 * SHADING_U);
    return value;
}
