/* Light that bounces inside closed surfaces. */
#include "verify/laws/common.h"

/* Albedos of the three channels, and the walls' emission. */
static const vec3_f64 albedo = {0.75, 0.5, 0.25}, sent = {1, 0.5, 2};

static fathom_material wall(void) {
    fathom_material m = build_lambert(albedo);
    build_rgb(m.k_e, sent);
    return m;
}

/* ---- white furnaces: L_e (1 - ρⁿ⁺¹)/(1 - ρ) after n bounces ---- */

static void furnace(law_room *room, uint32_t depth) {
    room->depth = depth;
    law_look(room, vec_f64(0.3, 0.2, 0.1), vec_f64(0.5, -0.4, 1));
    law_value(room, vec_f64(sent.x * law_powers(albedo.x, 0, (int)depth),
                            sent.y * law_powers(albedo.y, 0, (int)depth),
                            sent.z * law_powers(albedo.z, 0, (int)depth)));
}

static void furnace_sphere(law_room *room) {
    paint_sphere(&room->b, origin, 2, wall());
    furnace(room, (uint32_t)room->number);
}

static void furnace_box(law_room *room) {
    law_box(room, false, wall());
    furnace(room, 64);
}

static void furnace_mesh(law_room *room) {
    fathom_material m = law_metallic();
    build_rgb(m.base_color, albedo);
    build_rgb(m.emissive, scale_f64(0.5, sent));
    m.emissive_strength = 2;
    law_box(room, true, m);
    furnace(room, 8);
}

/* A white octahedron with the normals of a ball, in an even sky. Light from below a facet's horizon counts
 * where the shading normal faces it. Paths that meet the facets again have lost nothing. */
static void furnace_smooth(law_room *room) {
    static const float corners[18] = {1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
    static const uint32_t facets[24] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                        2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    fathom_mesh mesh;
    fathom_mesh_default(&mesh);
    mesh.positions = mesh.normals = corners, mesh.vertex_count = mesh.normal_count = 6;
    mesh.indices = facets, mesh.triangle_count = 8;
    build_mesh(&room->b, mesh, build_material(&room->b, build_lambert(white)));
    build_background(&room->b, white);
    law_look(room, vec_f64(2, 1, 0.8), vec_f64(0.6, 0.3, 0.1));
    law_value(room, white);
}

/* ---- a sphere with a light at its centre ---- */

static const double sphere_radius = 1.5, intensity = 3;

/* k_l/R² (ρ + ρ² + …); direct light alone gives k_l ρ/R². */
static double lit_sphere(double rho, const double *unused) {
    (void)unused;
    return intensity / (sphere_radius * sphere_radius) * law_powers(rho, 1, 64);
}

static void light_in_sphere(law_room *room) {
    paint_sphere(&room->b, origin, sphere_radius, build_lambert(albedo));
    build_point_light(&room->b, origin, gray(intensity), room->number);
    law_look(room, vec_f64(0.4, 0, 0), vec_f64(0.2, 1, 0.3));
    law_value(room, law_each(albedo, lit_sphere, NULL));
}

/* The radiance of the wall outside the cone: the mean over the sphere of the directly lit wall's radiance,
 * times ρ + ρ² + …. A squared ramp in the cosine from `outer` to `inner` has the mean (1 - inner + (inner -
 * outer)/3)/2. */
static double spot_wall(double rho, const double *share) { return *share * (rho * lit_sphere(rho, NULL)); }

static void spot_in_sphere(law_room *room) {
    fathom_light light = build_light_of(FATHOM_LIGHT_SPOT, origin, down, gray(intensity));
    light.inner_angle = 0.6f, light.outer_angle = 1.2f;
    const double inner = cos((double)light.inner_angle), outer = cos((double)light.outer_angle);
    paint_sphere(&room->b, origin, sphere_radius, build_lambert(albedo));
    build_light(&room->b, &light);
    law_look(room, vec_f64(0.4, 0, 0), vec_f64(0.3, 0.1, 1));
    const double share = (1 - inner + (inner - outer) / 3) / 2;
    law_value(room, law_each(albedo, spot_wall, &share));
}

/* ---- a sphere cut by an emitting plane ----
 * Every ray from the wall to the removed cap crosses the plane, so the plane fills the fraction f of the view
 * of any point of the wall. The plane sees only the wall. B = ρ (f (L + σB) + (1-f) B) for the wall, σ the
 * plane's albedo. */

static double cut_sphere(double rho, const double *f_and_plane) {
    const double f = f_and_plane[0];
    return rho * f / (1 - rho * (1 - f) - rho * f_and_plane[1] * f);
}

static void cut(law_room *room) {
    const double height = 0.4, numbers[] = {(1 - height) / 2, room->number};
    fathom_material m = build_emitter(white);
    build_rgb(m.k_d, gray(room->number));
    paint_sphere(&room->b, origin, 1, build_lambert(albedo));
    paint_plane(&room->b, vec_f64(0, 0, height), up, m);
    law_look(room, origin, vec_f64(0.2, 0.3, -1));
    law_value(room, law_each(albedo, cut_sphere, numbers));
}

/* ---- a sphere inside another ---- */

static const double inner_albedo = 0.3, inner_share = 0.25;

static double outer_wall(double rho, const double *unused) {
    (void)unused;
    return rho * inner_share / (1 - rho * (1 - inner_share) - inner_albedo * rho * inner_share);
}

static double inner_wall(double rho, const double *unused) {
    return 1 + inner_albedo * outer_wall(rho, unused);
}

/* The camera looks at the wall of the outer sphere at x = 1, or at the inner one. */
static void two_spheres(law_room *room) {
    const vec3_f64 walls = {0.7, 0.5, 0.2};
    fathom_material m = build_emitter(white);
    build_rgb(m.k_d, gray(inner_albedo));
    paint_sphere(&room->b, origin, 0.5, m);
    paint_sphere(&room->b, origin, 1, build_lambert(walls));
    law_look(room, vec_f64(0.75, 0, 0), vec_f64(room->number, 0.1, 0.2));
    law_value(room, law_each(walls, room->number == 1 ? outer_wall : inner_wall, NULL));
}

const law laws_of_enclosures[] = {{"furnace, sphere", "L_e (1-ρⁿ⁺¹)/(1-ρ)", furnace_sphere, 64},
                                  {"furnace, four bounces", "L_e (1-ρⁿ⁺¹)/(1-ρ)", furnace_sphere, 4},
                                  {"furnace, box of quads", "L_e (1-ρⁿ⁺¹)/(1-ρ)", furnace_box, 0},
                                  {"furnace, box of triangles", "L_e (1-ρⁿ⁺¹)/(1-ρ)", furnace_mesh, 0},
                                  {"smooth octahedron in an even sky", "L", furnace_smooth, 0},
                                  {"point light in a sphere", "I ρ/(πR²(1-ρ))", light_in_sphere, 0},
                                  {"light with a radius in a sphere", "I ρ/(πR²(1-ρ))", light_in_sphere, 0.3},
                                  {"spot light in a sphere", "mean I ρ²/(πR²(1-ρ))", spot_in_sphere, 0},
                                  {"sphere, black emitting cap", "L ρf/(1-ρ(1-f))", cut, 0},
                                  {"sphere, gray emitting cap", "L ρf/(1-ρ(1-f)-ρσf)", cut, 0.5},
                                  {"sphere in a sphere, outer", "ρ₂kE/(1-ρ₂(1-k)-ρ₁ρ₂k)", two_spheres, 1},
                                  {"sphere in a sphere, inner", "E + ρ₁B₂", two_spheres, 0.1},
                                  {NULL, NULL, NULL, 0}};
