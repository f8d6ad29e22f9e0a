/* Refraction with indices from nearly that of vacuum to far beyond any glass: through a slab, through a ball,
 * into a half-space, and the Fresnel factors. A ruler (beam_radiance()) behind the glass shows where each ray
 * lands. */
#include "verify/light/shading_studio.h"

#define PIXELS 33

static const vec3_f64 eye = {0, 0, 0}, view = {0, 0, -1}, across = {1, 0, 0}, up = {0, 0, 1};

typedef struct optic {
    const char *name;
    double ior;   /* index of the formula */
    double field; /* width of the view */
    double floor; /* z of the ruler */
    void (*build)(studio *s, fathom_material glass);
    /* Moves the beam to the ruler. False: total reflection, no light arrives. *sure: float certainly gets the
     * same result. */
    bool (*follow)(beam *b, double ior, bool *sure);
} optic;

/* Refracts at a surface at height z with its normal towards the eye. */
static bool cross(beam *b, double z, double eta, bool *sure) {
    beam_go(b, (z - b->at.z) / b->along.z, 3);
    *sure = *sure && fabs(beam_doubt(b, up, 4 * SHADING_U, eta)) > 1;
    return beam_refract(b, up, 4 * SHADING_U, eta);
}

static void land(beam *b, double z) { beam_go(b, (z - b->at.z) / b->along.z, fabs(z) + fabs(b->at.x)); }

/* ---- a slab, z = -1 to z = -2: the ray leaves at its old angle, displaced by tan(in) - tan(out) ---- */

static void build_slab(studio *s, fathom_material glass) {
    paint_plane(&s->b, (vec3_f64){0, 0, -1}, up, glass);
    paint_plane(&s->b, (vec3_f64){0, 0, -2}, neg_f64(up), glass);
}

static bool follow_slab(beam *b, double ior, bool *sure) {
    vec3_f64 d = b->along;
    double sine = d.x / ior, slope = -d.x / d.z;
    if (!cross(b, -1, 1 / ior, sure) || !cross(b, -2, ior, sure)) return false;
    land(b, -3);
    b->at.x = 2 * slope + sine / sqrt(1 - sine * sine);
    return true;
}

/* ---- a half-space below z = -1 ---- */

static void build_half(studio *s, fathom_material glass) {
    paint_plane(&s->b, (vec3_f64){0, 0, -1}, up, glass);
}

static bool follow_half(beam *b, double ior, bool *sure) {
    double sine = b->along.x / ior, slope = -b->along.x / b->along.z;
    if (!cross(b, -1, 1 / ior, sure)) return false;
    land(b, -2);
    b->at.x = slope + sine / sqrt(1 - sine * sine);
    return true;
}

/* ---- a ball of radius 1 around z = -3: twice the same angles, at the ends of a chord ---- */

static const vec3_f64 ball = {0, 0, -3};

static void build_ball(studio *s, fathom_material glass) { paint_sphere(&s->b, ball, 1, glass); }

/* The normal depends on the point: its error is the point's error divided by the radius. */
static bool cross_ball(beam *b, bool leaving, double eta, bool *sure) {
    vec3_f64 f = sub_f64(b->at, ball);
    double half = dot_f64(f, b->along), root = half * half - dot_f64(f, f) + 1;
    if (root < 1e-3) {
        *sure = false;
        return false;
    }
    beam_go(b, leaving ? -2 * half : -half - sqrt(root), 4);
    vec3_f64 n = normalize_f64(sub_f64(b->at, ball));
    if (leaving) n = neg_f64(n);
    double slant = -dot_f64(b->along, n), normal_error = b->aside / slant + 8 * SHADING_U;
    *sure = *sure && fabs(beam_doubt(b, n, normal_error, eta)) > 1;
    return beam_refract(b, n, normal_error, eta);
}

static bool follow_ball(beam *b, double ior, bool *sure) {
    if (!cross_ball(b, false, 1 / ior, sure) || !cross_ball(b, true, ior, sure)) return false;
    if (!(b->along.z < -0.1)) {
        *sure = false; /* refracted past the ruler */
        return false;
    }
    land(b, -5);
    return true;
}

/* ---- one image ---- */

static void judge(studio *s, const optic *c, vec3_f64 light, uint32_t i) {
    beam b = beam_start(eye, studio_direction(s, view, across, c->field, i));
    bool sure = true, lands = c->follow(&b, c->ior, &sure);
    double bound = 0, value = 0;
    if (!sure) return;
    if (lands) value = beam_radiance(&b, light, up, fabs(c->floor) + fabs(b.at.x), &bound);
    studio_judge(s, 0, studio_at(s, 0, i), value, bound);
}

static void one(studio *s, optic c, float ior, const char *group, double parameter, const char *sign) {
    const vec3_f64 light = {0.5, 0.25, c.floor + 0.5};
    studio_begin(s, PIXELS);
    c.build(s, studio_glass(ior));
    paint_plane(&s->b, (vec3_f64){0, 0, c.floor}, up, build_lambert(vec_f64(1, 1, 1)));
    build_point_light(&s->b, light, vec_f64(1, 1, 1), 0);
    studio_camera(s, eye, view, across, c.field);
    c.ior = studio_twisted(s, (double)ior);
    for (uint32_t i = 0, n = studio_render(s); i < n; ++i) judge(s, &c, light, i);
    studio_row(s, 0, group, parameter, "%s of ior %s%g", c.name, sign, parameter);
}

static const optic
    slab = {.name = "through a slab", .field = 2.2, .floor = -3, .build = build_slab, .follow = follow_slab},
    ball_of = {.name = "through a ball",
               .field = 0.5,
               .floor = -5,
               .build = build_ball,
               .follow = follow_ball},
    half_space = {
        .name = "into a half-space", .field = 2.2, .floor = -2, .build = build_half, .follow = follow_half};

/* ---- Fresnel factors: red is reflected to an emitter of 1 behind the eye; green is transmitted ---- */

/* The terms have the errors of the cosines, about 8 u, divided by a sum that is at least as large as the
 * larger term; the factors are in [0, 1]. If the refracted cosine is small, its error is the error of its
 * square divided by twice the cosine. */
static double reflectance(double cos_in, double eta, double *bound) {
    double cos2 = 1 - eta * eta * (1 - cos_in * cos_in);
    if (cos2 <= 0) return 1;
    double cos_out = sqrt(cos2), cos2_error = 12 * SHADING_U * (1 + eta * eta);
    double parallel = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    double perpendicular = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    double share = cos2_error / (2 * cos2) + 8 * SHADING_U / cos_in + 8 * SHADING_U;
    *bound = 2 * share + 8 * SHADING_U;
    return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

static void fresnel(studio *s, float ior, double parameter) {
    studio_begin(s, PIXELS);
    fathom_material glass = studio_glass(ior);
    glass.k_r[0] = glass.k_r[1] = glass.k_r[2] = 1;
    glass.fresnel = true;
    paint_plane(&s->b, (vec3_f64){0, 0, -1}, up, glass);
    paint_plane(&s->b, (vec3_f64){0, 0, 1}, neg_f64(up), build_emitter(vec_f64(1, 0, 0)));
    paint_plane(&s->b, (vec3_f64){0, 0, -2}, up, build_emitter(vec_f64(0, 1, 0)));
    studio_camera(s, eye, view, across, 20);
    double eta = 1 / studio_twisted(s, (double)ior);
    for (uint32_t i = 0, n = studio_render(s); i < n; ++i) {
        double bound = 0, share = reflectance(-studio_direction(s, view, across, 20, i).z, eta, &bound);
        if (bound > 0.5) continue; /* float cannot decide whether reflection is total */
        studio_judge(s, 0, studio_at(s, 0, i), share, bound);
        studio_judge(s, 0, studio_at(s, 1, i), 1 - share, bound);
    }
    studio_row(s, 0, "fresnel", parameter, "mirrored and let through by ior %.9g", (double)ior);
}

/* ---- all ---- */

static void near_one(studio *s, double step) {
    float above = (float)(1 + step), below = (float)(1 - step);
    one(s, slab, above, "ior", step, "1 + ");
    one(s, slab, below, "ior", step, "1 - ");
    one(s, ball_of, above, "ior", step, "1 + ");
    one(s, ball_of, below, "ior", step, "1 - ");
    fresnel(s, above, (double)above);
}

/* Below 1, only rays nearly along the normal enter, so the view is only slightly wider than their cone. If
 * this cone is narrower than float can resolve, a wide view sees only reflection. From 1e7 on, the direction
 * inside has lost the direction outside, so only the half-space has a formula. */
static void extreme(studio *s, double ior) {
    optic into = half_space, through = slab;
    into.field = through.field = ior < 1 && ior > 1e-5 ? 2.2 * ior : 2.2;
    one(s, into, (float)ior, "ior extreme", ior, "");
    if (ior > 1e-5 && ior < 1e5) one(s, through, (float)ior, "ior extreme", ior, "");
    fresnel(s, (float)ior, ior);
}

void shading_ior(studio *s) {
    static const double extremes[] = {1e-30, 1e-7, 1e-3, 0.1, 1.5, 10, 100, 1e4, 1e7, 1e30};
    one(s, slab, 1, "ior", 0, "1 + ");
    for (int e = 1; e <= 7; ++e) near_one(s, pow(10, -e));
    for (size_t i = 0; i < sizeof extremes / sizeof *extremes; ++i) extreme(s, extremes[i]);
}
