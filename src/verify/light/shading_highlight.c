/* Highlights against their formula k_s cos^n, for exponents up to a million and beyond: across the peak,
 * where the cosine is 1 to the last digits of float, and down the flanks to where the value vanishes. */
#include "verify/light/shading_studio.h"

#define PIXELS 65

static const vec3_f64 normal = {0, 0, 1}, across = {0.8, 0, -0.6}, mirrored = {0.6, 0, 0.8};

typedef struct gloss {
    fathom_specular kind;
    double n; /* exponent of the formula */
} gloss;

/* The angle in cos^n. Phong: between the viewer and the mirrored light; Blinn: between the normal and the
 * half vector. Uses the sine too, because near the peak the cosine has no information. */
static double angle_of(const gloss *g, vec3_f64 v) {
    vec3_f64 light = {-mirrored.x, 0, mirrored.z};
    vec3_f64 a = g->kind == FATHOM_SPECULAR_PHONG ? mirrored : normal;
    vec3_f64 b = g->kind == FATHOM_SPECULAR_PHONG ? v : normalize_f64(add_f64(light, v));
    return atan2(length_f64(cross_f64(a, b)), dot_f64(a, b));
}

/* Compares with cos^n of the angle. The bound uses angles `off` smaller and larger: v, l, n and the values
 * computed from them have about 10 roundings, and half the square of a small difference has 3 more. 2^-126 is
 * float's smallest normal number. */
static void judge(studio *s, const gloss *g, double field, uint32_t i) {
    const double off = 10 * SHADING_U;
    vec3_f64 v = neg_f64(studio_direction(s, neg_f64(mirrored), across, field, i));
    double angle = angle_of(g, v), value = pow(cos(angle), g->n);
    if (!(angle < 1.5)) return; /* cos ~ 0: the highlight is far below any digit that is compared */
    double nearer = pow(cos(fmax(angle - off, 0)), g->n), further = pow(cos(angle + off), g->n);
    double rounding = 24 * SHADING_U + g->n * 3 * SHADING_U * (1 - cos(angle));
    double bound = mirrored.z * (fmax(nearer - value, value - further) + nearer * rounding + 0x1p-126);
    studio_judge(s, 0, studio_at(s, 1, i), mirrored.z * value, bound);
}

static void one(studio *s, fathom_specular kind, double n, double field) {
    bool phong = kind == FATHOM_SPECULAR_PHONG;
    studio_begin(s, PIXELS);
    fathom_material m = build_black();
    m.k_s[0] = m.k_s[1] = m.k_s[2] = 1;
    m.specular = kind, m.shininess = (float)n;
    paint_plane(&s->b, (vec3_f64){0, 0, 0}, normal, m);
    build_directional_light(&s->b, (vec3_f64){mirrored.x, 0, -mirrored.z}, vec_f64(1, 1, 1), 0);
    studio_camera(s, scale_f64(4, mirrored), neg_f64(mirrored), across, field);
    gloss g = {kind, studio_twisted(s, n)};
    for (uint32_t i = 0, pixels = studio_render(s); i < pixels; ++i) judge(s, &g, field, i);
    studio_row(s, 0, phong ? "phong" : "blinn", n, "%s's highlight of exponent %g over %.2g rad",
               phong ? "Phong" : "Blinn", n, field);
}

void shading_highlights(studio *s) {
    static const fathom_specular kinds[2] = {FATHOM_SPECULAR_PHONG, FATHOM_SPECULAR_BLINN};
    for (int k = 0; k < 2; ++k) {
        for (int e = 0; e <= 9; ++e) {
            double n = pow(10, e);
            /* cos^n is e^-18 at 6/sqrt(n); Blinn's angle is half the viewer's. */
            one(s, kinds[k], n, fmin(1, (k ? 24 : 12) / sqrt(n)));
            if (e >= 4) one(s, kinds[k], n, 1);
        }
    }
}
