/* Path tracing and the reference scatter light alike: BSDFs of materials by chance, between directions by
 * chance. Neither samples anything here, so that no tail of a distribution can hide or fake a difference. */
#include "defaults.h"
#include "integrate/reference/reference_inner.h"
#include "math/frame.h"
#include "shading.h"

enum { MATERIALS = SANITIZED ? 40 : 150, VIEWS = SANITIZED ? 8 : 24, DIRECTIONS = SANITIZED ? 16 : 64 };

/* ---- materials ---- */

/* 0 and 1 as often as something between. */
static float part(random_state *r) {
    const double u = random_unit(r);
    return u < 0.25 ? 0 : u < 0.5 ? 1 : (float)random_unit(r);
}

static bool happens(random_state *r, double chance) { return random_unit(r) < chance; }

/* See tolerance(). */
static float rough(random_state *r) { return happens(r, 0.15) ? 0 : (float)random_in(r, 0.3, 1); }

static void color(random_state *r, float out[3]) {
    for (int c = 0; c < 3; ++c) out[c] = (float)random_unit(r);
}

static fathom_material metallic(random_state *r) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    color(r, m.base_color);
    m.metallic = happens(r, 0.5) ? 0 : part(r), m.roughness = rough(r);
    m.multiscatter = happens(r, 0.5);
    m.ior = happens(r, 0.1) ? 1 : (float)random_in(r, 1.05, 2.5);
    m.transmission = happens(r, 0.5) ? 0 : part(r), m.thickness = happens(r, 0.7);
    if (m.roughness > 0 && happens(r, 0.2))
        m.anisotropy = (float)random_unit(r), m.anisotropy_rotation = (float)random_unit(r);
    if (happens(r, 0.2)) m.diffuse_transmission = part(r), color(r, m.diffuse_transmission_color);
    if (happens(r, 0.2)) m.iridescence = part(r), m.iridescence_thickness_max = (float)random_in(r, 50, 900);
    if (happens(r, 0.2)) m.specular_factor = part(r), color(r, m.specular_color);
    if (happens(r, 0.2)) m.clearcoat = part(r), m.clearcoat_roughness = rough(r);
    if (happens(r, 0.2)) m.sheen_roughness = rough(r), color(r, m.sheen_color);
    return m;
}

static fathom_material classic(random_state *r) {
    fathom_material m = default_material();
    color(r, m.k_d), color(r, m.k_s), color(r, m.k_r), color(r, m.k_t);
    m.specular = (fathom_specular)(random_bits(r) % 3), m.shininess = (float)random_log(r, 1, 100);
    m.ior = (float)random_in(r, 1.05, 2.5);
    m.fresnel = happens(r, 0.5), m.lit_from_behind = happens(r, 0.5);
    return m;
}

/* ---- points ---- */

/* Off the horizon by more than float's error, where cosines divide. */
static vec3_f64 any_view(random_state *r) {
    const double z = random_in(r, 0.05, 1), angle = random_in(r, 0, 2 * M_PI), sine = sqrt(1 - z * z);
    return vec_f64(sine * cos(angle), sine * sin(angle), z);
}

static void put(lanes3 to, vec3_f64 d) { shading_put(to, d.x, d.y, d.z); }

typedef struct point {
    shading path;
    reference_surface reference;
} point;

/* The same point for both. The shading normal leans a little. */
static void set_point(point *p, const fathom_material *m, const reference_albedos *albedos, random_state *r) {
    const bool entering = happens(r, 0.5);
    const vec3_f64 v = any_view(r), up = vec_f64(0, 0, 1), lean = random_direction(r);
    const vec3_f64 n = happens(r, 0.5) ? up : normalize_f64(madd_f64(up, 0.2, lean));
    const vec3_f64 normal = dot_f64(n, v) > 0 ? n : up;
    const frame_f64 frame = frame_from((vec3_f64){0, 0, 0}, normal, (vec3_f64){0, 0, 0});
    const double ratio = entering ? (double)m->ior : 1 / (double)m->ior;
    p->reference = (reference_surface){.to_viewer = v,
                                       .geometric = up,
                                       .normal = normal,
                                       .along = frame.x,
                                       .behind = !entering,
                                       .material = m,
                                       .albedos = albedos,
                                       .ratio = ratio,
                                       .turn = ratio};
    shading_open(&p->path, m, 1, entering);
    put(p->path.surface.v, v);
    put(p->path.surface.ns, n);
    shading_direct(&p->path, frame.x.x, frame.x.y, frame.x.z);
}

/* ---- laws ---- */

/* The path tracer's albedos are tables, right to 5e-4 (material/energy.h). Where roughness is at least 0.3
 * the lobes made of them are off by 2 * 5e-4 * 0.12 / (pi * 0.023) = 1.6e-3. All else is float's roundoff:
 * alpha is at least 0.09, so a half vector that is off by 2^-23 changes D by 4 * 2^-23 / 0.09, and cosines
 * down to 0.05 add as much. */
static double tolerance(const fathom_material *m, double expected) {
    const bool curves = m->multiscatter || m->clearcoat > 0 || largest(color_of(m->sheen_color)) > 0;
    const bool tables = m->model == FATHOM_MODEL_METALLIC_ROUGHNESS && (curves || m->iridescence > 0);
    return tables ? 2e-3 + 1e-2 * fabs(expected) : 1e-5 + 5e-4 * fabs(expected);
}

/* Films are tables of reflectances, off by 4e-3 where a channel begins to be cut at 0. */
static double film_tolerance(const point *p, vec3_f64 l) {
    fathom_material white = *p->reference.material;
    reference_surface s = p->reference;
    if (!(white.iridescence > 0)) return 0;
    white.iridescence = white.clearcoat = white.sheen_color[0] = white.sheen_color[1] = white.sheen_color[2] =
        0;
    white.metallic = white.base_color[0] = white.base_color[1] = white.base_color[2] = 1;
    white.multiscatter = false;
    s.material = &white;
    return 4e-3 * reference_evaluate(&s, l).x;
}

static void describe(const fathom_material *m, const point *p, char *out, size_t size) {
    const struct {
        const char *name;
        float value;
    } parts[] = {{"metallic", m->metallic},
                 {"roughness", m->roughness},
                 {"transmission", m->transmission},
                 {"thickness", m->thickness},
                 {"ior", m->ior},
                 {"multiscatter", m->multiscatter},
                 {"clearcoat", m->clearcoat},
                 {"its roughness", m->clearcoat_roughness},
                 {"sheen", m->sheen_color[0]},
                 {"its roughness", m->sheen_roughness},
                 {"anisotropy", m->anisotropy},
                 {"iridescence", m->iridescence},
                 {"specular", m->specular_factor},
                 {"diffuse transmission", m->diffuse_transmission}};
    size_t used = (size_t)snprintf(out, size, "%s, from %s", m->model ? "metallicRoughness" : "classic",
                                   p->reference.behind ? "inside" : "outside");
    for (size_t i = 0; i < sizeof parts / sizeof *parts && used < size; ++i)
        used += (size_t)snprintf(out + used, size - used, ", %s %g", parts[i].name, (double)parts[i].value);
}

static void compare_value(const point *p, vec3_f64 l, const fathom_material *m) {
    const vec3_f64 expected = reference_evaluate(&p->reference, l), v = p->reference.to_viewer;
    const double to[3] = {l.x, l.y, l.z}, e[3] = {expected.x, expected.y, expected.z};
    double f[3];
    shading_value(&p->path, to, f);
    const double film = film_tolerance(p, l);
    for (int c = 0; c < 3; ++c) {
        char what[400];
        if (fabs(f[c] - e[c]) <= tolerance(m, e[c]) + film) continue;
        describe(m, p, what, sizeof what);
        fail_msg("%s: v %g %g %g, l %g %g %g: path %g, reference %g", what, v.x, v.y, v.z, l.x, l.y, l.z,
                 f[c], e[c]);
    }
}

/* What the reference sends along one direction by itself. */
static vec3_f64 beams_along(const reference_scatter *all, const lanes3 direction) {
    const vec3_f64 d = vec_f64((double)direction[0][0], (double)direction[1][0], (double)direction[2][0]);
    vec3_f64 sum = {0, 0, 0};
    for (unsigned k = 0; k < all->beams; ++k) {
        if (length_f64(sub_f64(all->beam[k].direction, d)) < 1e-4) sum = add_f64(sum, all->beam[k].weight);
    }
    return sum;
}

/* Mirrors and clear glass, each with its direction: a beam that the path tracer sends elsewhere is one that
 * it lacks. */
static void compare_beams(const point *p, const fathom_material *m) {
    const reference_scatter all = reference_scatter_of(&p->reference);
    const shader_block *b = &p->path.block;
    double sums[2] = {0, 0};
    for (unsigned k = 0; k < all.beams; ++k) sums[0] += all.beam[k].weight.x;
    for (int side = 0; side < 2; ++side) {
        const double share = (double)(side ? b->pass_share : b->mirror_share)[0][0];
        const double expected = share > 0 ? beams_along(&all, side ? b->pass : b->mirror).x : 0;
        sums[1] += share;
        assert_near(share, expected, tolerance(m, expected));
    }
    assert_near(sums[1], sums[0], tolerance(m, sums[0]));
}

static void compare_material(const fathom_material *m, random_state *r) {
    reference_albedos *albedos;
    if (reference_lacks(m)) return;
    assert_true(reference_albedos_make(m, (const double[]){1}, 1, &albedos));
    for (int k = 0; k < VIEWS; ++k) {
        point p;
        set_point(&p, m, albedos, r);
        compare_beams(&p, m);
        for (int i = 0; i < DIRECTIONS; ++i) compare_value(&p, random_direction(r), m);
    }
    free(albedos);
}

UNIT_TEST(path_and_reference_scatter_alike) {
    random_state r = {1};
    for (int i = 0; i < MATERIALS; ++i) {
        const fathom_material m = i % 8 ? metallic(&r) : classic(&r);
        compare_material(&m, &r);
    }
}

int main(void) { return unit_main(NULL, NULL); }
