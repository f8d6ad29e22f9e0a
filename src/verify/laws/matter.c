/* Materials, volumes and environment light. */
#include "verify/laws/common.h"

static const vec3_f64 eye = {0, 0, 1};

/* ---- environment light ---- */

static const vec3_f64 albedo = {1, 0.5, 0.2};

static void even_sky(law_room *room) {
    paint_plane(&room->b, origin, up, build_lambert(albedo));
    build_background(&room->b, vec_f64(1, 0.5, 0.25));
    law_look(room, eye, origin);
    law_value(room, vec_f64(1, 0.25, 0.05));
}

/* Legendre polynomials around one axis per channel: bands 0 to 4 of a rotated spherical harmonic. */
static const double bands[5] = {1, 0.4, 0.25, 0.2, 0.1};
static const vec3_f64 sky_axes[3] = {{0, 0, 1}, {0.6, 0, 0.8}, {0.48, 0.64, -0.6}};

static void legendre(double x, double out[5]) {
    out[0] = 1, out[1] = x;
    for (int l = 2; l < 5; ++l) out[l] = ((2 * l - 1) * x * out[l - 1] - (l - 1) * out[l - 2]) / l;
}

static double band_sum(vec3_f64 axis, vec3_f64 direction, const double factors[5]) {
    double p[5], sum = 0;
    legendre(dot_f64(axis, direction), p);
    for (int l = 0; l < 5; ++l) sum += factors[l] * bands[l] * p[l];
    return sum;
}

static vec3_f64 harmonic_sky(vec3_f64 d) {
    static const double all[5] = {1, 1, 1, 1, 1};
    return vec_f64(band_sum(sky_axes[0], d, all), band_sum(sky_axes[1], d, all),
                   band_sum(sky_axes[2], d, all));
}

/* Irradiance weights bands by π, 2π/3, π/4, 0, -π/24; the floor's radiance is the irradiance divided by π. */
static void harmonics(law_room *room) {
    const double factors[5] = {1, 2.0 / 3, 0.25, 0, -1.0 / 24};
    paint_plane(&room->b, origin, up, build_lambert(white));
    law_look(room, eye, origin);
    law_sky(room, harmonic_sky);
    for (int c = 0; c < 3; ++c) room->value[c] = band_sum(sky_axes[c], up, factors);
}

/* ---- mirrors with a Fresnel factor, averaged over the cosine: a floor under a mirror ceiling ---- */

/* B = 1 + ρ F B. */
static void ceiling(law_room *room, vec3_f64 normal, fathom_material mirror, vec3_f64 mean) {
    fathom_material m = build_lambert(albedo);
    build_rgb(m.k_e, white);
    paint_plane(&room->b, origin, up, m);
    paint_plane(&room->b, up, normal, mirror);
    law_look(room, vec_f64(0, 0, 0.5), vec_f64(0.2, 0.1, 0));
    law_value(room,
              vec_f64(1 / (1 - albedo.x * mean.x), 1 / (1 - albedo.y * mean.y), 1 / (1 - albedo.z * mean.z)));
}

static fathom_material glass(double k_t) {
    fathom_material m = build_black();
    build_rgb(m.k_r, white);
    build_rgb(m.k_t, gray(k_t));
    m.fresnel = true, m.ior = 1.5f;
    return m;
}

/* The mean of Fresnel's factor outside the glass, or inside. */
static void fresnel(law_room *room) {
    ceiling(room, room->number < 0.5 ? down : up, glass(0), gray(room->number));
}

static void schlick(law_room *room) {
    const vec3_f64 f0 = {0.04, 0.5, 0.9};
    fathom_material m = law_metallic();
    m.metallic = 1;
    build_rgb(m.base_color, f0);
    ceiling(room, down, m, vec_f64(f0.x + (1 - f0.x) / 21, f0.y + (1 - f0.y) / 21, f0.z + (1 - f0.z) / 21));
}

/* ---- the reflectance of a lobe at normal incidence, under a uniform sky ---- */

static void ggx_full(law_room *room) {
    fathom_material m = law_metallic();
    m.metallic = m.roughness = 1;
    law_lobe(room, m, eye, gray(1 - log(2)));
}

static void ggx(law_room *room) {
    const vec3_f64 from = {room->number, 0, room->number > 0 ? 0.6 : 1};
    fathom_material m = law_metallic();
    m.metallic = 1, m.roughness = 0.6f;
    law_lobe(room, m, from, gray(law_ggx_albedo(0.36, 0.36, from)));
}

static fathom_material highlight(fathom_specular specular) {
    fathom_material m = build_black();
    m.specular = specular, m.shininess = 10;
    build_rgb(m.k_s, albedo);
    return m;
}

static void phong(law_room *room) {
    law_lobe(room, highlight(FATHOM_SPECULAR_PHONG), eye, scale_f64(2.0 / 12, albedo));
}

/* 2 ∫ cosⁿ(θ/2) cos θ sin θ dθ, by u = cos(θ/2). */
static void blinn(law_room *room) {
    const double n = 10, u = sqrt(0.5);
    const double at_one = 2 / (n + 4) - 1 / (n + 2);
    const double at_u = 2 * pow(u, n + 4) / (n + 4) - pow(u, n + 2) / (n + 2);
    law_lobe(room, highlight(FATHOM_SPECULAR_BLINN), eye, scale_f64(8 * (at_one - at_u), albedo));
}

static void lit_from_behind(law_room *room) {
    fathom_material m = build_lambert(scale_f64(0.5, albedo));
    m.lit_from_behind = true;
    law_lobe(room, m, eye, albedo);
}

/* ---- lossless objects are invisible in a uniform sky ---- */

static void glass_ball(law_room *room) { law_unseen_ball(room, glass(1)); }

/* The number is the thickness: 0 makes a thin wall, 1 a solid. */
static void clear_ball(law_room *room) { law_unseen_ball(room, law_clear(room->number)); }

/* Without compensation, a ball of this roughness loses 0.29 of the light. */
static void rough_ball(law_room *room) {
    fathom_material m = law_clear(1);
    m.roughness = 0.7f, m.multiscatter = true;
    law_unseen_ball(room, m);
}

/* Without compensation, this one loses 0.45. */
static void brushed_glass_ball(law_room *room) {
    fathom_material m = law_clear(1);
    m.roughness = 0.3f, m.anisotropy = 0.9f, m.multiscatter = true;
    law_unseen_ball(room, m);
}

/* Light that is reflected totally inside must not meet the white base as well. */
static void half_glass_ball(law_room *room) {
    fathom_material m = law_clear(1);
    m.transmission = 0.8f;
    law_unseen_ball(room, m);
}

/* A black emitter with the sky's radiance is invisible, in glass or outside, and so is the glass. */
static void lamp_in_glass(law_room *room) {
    paint_sphere(&room->b, vec_f64(0, 0.2, 0), 0.5, build_emitter(white));
    law_unseen_ball(room, law_clear(1));
}

/* ---- glass ---- */

/* Both surfaces reflect r, with all orders of reflection between them. */
static void slab(law_room *room) {
    const double r = 0.04;
    paint_plane(&room->b, vec_f64(0, 0, -1), up, glass(1));
    paint_plane(&room->b, vec_f64(0, 0, -2), down, glass(1));
    paint_plane(&room->b, vec_f64(0, 0, 2), down, build_emitter(white));
    law_look(room, origin, down);
    law_value(room, gray(2 * r / (1 + r)));
}

/* The image is the square around the ball: the ball's disc and the sky around it. From 1000 radii away the
 * view is parallel to about 1e-6. */
static double through_ball(double remains, const double *unused) {
    (void)unused;
    const double way = -2 * log(remains); /* 2σR */
    return 1 - M_PI / 4 * (1 - 2 * (1 - (1 + way) * exp(-way)) / (way * way));
}

static void absorbing_ball(law_room *room) {
    fathom_material m = law_tinted(law_clear(1));
    m.specular_factor = 0, m.ior = 1;
    paint_sphere(&room->b, origin, 1, m);
    build_background(&room->b, white);
    law_look_down(room, 1000, 2);
    law_value(room, law_each(law_left, through_ball, NULL));
}

/* ---- coverage: a black sheet with coverage 1/4, between a floor and the sun ---- */

static fathom_material sheet(void) {
    fathom_material m = law_metallic();
    build_rgb(m.base_color, origin);
    m.opacity = 0.25f;
    return m;
}

static void coverage(law_room *room) {
    paint_plane(&room->b, origin, up, build_lambert(albedo));
    paint_plane(&room->b, up, up, sheet());
    build_directional_light(&room->b, down, white, 0);
    law_look(room, vec_f64(0.5, 0, 2), origin);
    law_value(room, scale_f64(0.75 * 0.75, albedo));
}

/* Passing through the uncovered part of a sheet is not a bounce: with four sheets on the path, one bounce
 * reaches the sky. */
static void sky_through_sheets(law_room *room) {
    paint_plane(&room->b, origin, up, build_lambert(albedo));
    paint_sphere(&room->b, origin, 3, sheet());
    paint_plane(&room->b, up, up, sheet());
    paint_plane(&room->b, vec_f64(0, 0, 2), up, sheet());
    build_background(&room->b, white);
    law_look(room, vec_f64(0.5, 0, 1.5), origin);
    law_value(room, scale_f64(0.75 * 0.75 * 0.75 * 0.75, albedo));
    room->depth = 1;
}

static void lamp_behind_sheets(law_room *room) {
    paint_plane(&room->b, origin, up, build_lambert(albedo));
    paint_plane(&room->b, vec_f64(0, 0, 0.5), up, sheet());
    paint_plane(&room->b, vec_f64(0, 0, 0.75), up, sheet());
    law_look(room, vec_f64(-0.5, -0.4, 0.4), origin);
    law_value(room, scale_f64(0.75 * 0.75 * law_ball(room, build_emitter(white)), albedo));
}

/* Clear thin walls tint light that passes them straight, from light samples and from BSDF samples. They are
 * no bounces either. */
static void lamp_behind_panes(law_room *room) {
    const vec3_f64 tint = {0.75, 0.5, 0.25};
    fathom_material m = law_clear(0);
    m.specular_factor = 0;
    build_rgb(m.base_color, tint);
    paint_plane(&room->b, origin, up, build_lambert(albedo));
    paint_plane(&room->b, vec_f64(0, 0, 0.5), up, m);
    paint_plane(&room->b, vec_f64(0, 0, 0.75), up, m);
    law_look(room, vec_f64(-0.5, -0.4, 0.4), origin);
    const vec3_f64 left = {tint.x * tint.x * albedo.x, tint.y * tint.y * albedo.y,
                           tint.z * tint.z * albedo.z};
    law_value(room, scale_f64(law_ball(room, build_emitter(white)), left));
    room->depth = 1;
}

/* ---- shapes that cast no shadow still hide the sky ---- */

static void no_shadow(law_room *room) {
    room->b.flags = FATHOM_CASTS_NO_SHADOW;
    paint_plane(&room->b, up, up, build_black());
    room->b.flags = 0;
    paint_plane(&room->b, origin, up, build_lambert(albedo));
    build_point_light(&room->b, vec_f64(0, 0, 2), gray(4), 0.5);
    paint_sphere(&room->b, vec_f64(0, 0, 3), 1, build_emitter(white));
    build_background(&room->b, white);
    law_look(room, vec_f64(0.5, 0, 0.5), origin);
    law_value(room, albedo);
}

/* ---- a lens: the edge of an emitting half plane, out of focus ----
 * The image is one point of the plane of focus. Through the lens, this point projects to a disc on the plane
 * of the edge. The fraction of the disc beyond the edge at x radii is (acos x - x √(1-x²))/π. */

static void lens(law_room *room) {
    const double focus = 4, distance = 3, radius = 0.5, offset = 0.05;
    const double disc = radius * (focus - distance) / focus, x = offset / disc;
    paint_quad(&room->b, vec_f64(offset + 5, 0, focus - distance), vec_f64(5, 0, 0), vec_f64(0, 10, 0),
               build_emitter(white));
    fathom_camera camera = build_view(vec_f64(0, 0, focus), origin, 1);
    camera.d = 1, camera.h = 1.0 / 4096, camera.lens_radius = radius, camera.focus_distance = focus;
    build_camera(&room->b, camera);
    law_value(room, gray(fabs(x) < 1 ? (acos(x) - x * sqrt(1 - x * x)) / M_PI : 0));
}

const law laws_of_matter[] = {{"floor under an even sky", "ρ L", even_sky, 0},
                              {"sky in spherical harmonics", "Σ A_l L_lm Y_lm", harmonics, 0},
                              {"Fresnel's mean, outside", "1/(1-ρF)", fresnel, 0.09177796},
                              {"Fresnel's mean, inside", "1/(1-ρF)", fresnel, 0.59634576},
                              {"Schlick's mean", "F₀ + (1-F₀)/21", schlick, 0},
                              {"GGX, roughness 1", "1 - ln 2", ggx_full, 0},
                              {"GGX, roughness 0.6", "∫ D G₂ v·h / n·v", ggx, 0},
                              {"GGX, roughness 0.6, from aside", "∫ D G₂ v·h / n·v", ggx, 0.8},
                              {"Phong lobe", "2 k_s/(n+2)", phong, 0},
                              {"Blinn lobe", "k_s ∫ cosⁿ(θ/2) cos θ", blinn, 0},
                              {"sheet lit from behind", "2 k_d", lit_from_behind, 0},
                              {"glass ball in an even sky", "L", glass_ball, 0},
                              {"thin-walled ball in an even sky", "L", clear_ball, 0},
                              {"refracting ball in an even sky", "L", clear_ball, 1},
                              {"rough glass ball in an even sky", "L", rough_ball, 0},
                              {"brushed glass ball in an even sky", "L", brushed_glass_ball, 0},
                              {"partly diffuse glass ball", "L", half_glass_ball, 0},
                              {"lamp in a refracting ball", "L", lamp_in_glass, 0},
                              {"glass slab", "2r/(1+r)", slab, 0},
                              {"absorbing ball", "(1-(1+2σR)e^(-2σR))/(2σ²R²)", absorbing_ball, 0},
                              {"coverage", "k_l (1-c)²", coverage, 0},
                              {"sky through sheets", "ρ L (1-c)⁴", sky_through_sheets, 0},
                              {"lamp behind sheets", "ρ (1-c)² (R/d)² cos θ", lamp_behind_sheets, 0},
                              {"lamp behind panes", "ρ t² (R/d)² cos θ", lamp_behind_panes, 0},
                              {"shape that casts no shadow", "k_l cos θ/d²", no_shadow, 0},
                              {"edge out of focus", "(acos x - x √(1-x²))/π", lens, 0},
                              {NULL, NULL, NULL, 0}};
