/* Layers and lobes of metallicRoughness from glTF extensions. */
#include "verify/laws/common.h"

static const vec3_f64 eye = {0, 0, 1}, aside = {0.8, 0, 0.6}, across = {0, 0.8, 0.6};

/* A dielectric without reflection and with a black base. */
static fathom_material bare(void) {
    fathom_material m = law_metallic();
    m.specular_factor = 0;
    build_rgb(m.base_color, origin);
    return m;
}

/* ---- diffuse transmission ---- */

static const vec3_f64 base = {0.8, 0.5, 0.2}, through = {0.3, 0.9, 0.6};

static fathom_material leaf_material(void) {
    fathom_material m = bare();
    build_rgb(m.base_color, base);
    m.diffuse_transmission = 0.75f;
    build_rgb(m.diffuse_transmission_color, through);
    return m;
}

static void leaf(law_room *room) {
    law_lobe(room, leaf_material(), eye, add_f64(scale_f64(0.25, base), scale_f64(0.75, through)));
}

static void leaf_from_behind(law_room *room) {
    build_directional_light(&room->b, up, white, 0);
    law_lobe(room, leaf_material(), eye, scale_f64(0.75, through));
    build_background(&room->b, origin);
}

/* A white leaf under a dielectric layer is lossless. */
static void white_leaf(law_room *room) {
    fathom_material m = law_metallic();
    m.diffuse_transmission = m.roughness = 0.5f, m.specular_factor = 1, m.multiscatter = true;
    law_unseen_ball(room, m);
}

/* ---- sheen: KHR_materials_sheen's formulas, by midpoints over the hemisphere
 * ---- */

static double fit(double x, double alpha) {
    const double t = square(1 - alpha), s = 1 - t;
    return (21.5473 * s + 25.3245 * t) /
               (1 + (3.82987 * s + 3.32435 * t) * pow(x, 0.19823 * s + 0.16801 * t)) -
           (1.97760 * s + 1.27393 * t) * x - (4.32054 * s + 4.85967 * t);
}

static double lambda(double z, double alpha) {
    return exp(z < 0.5 ? fit(z, alpha) : 2 * fit(0.5, alpha) - fit(1 - z, alpha));
}

static double sheen_reflectance(double alpha, double nv) {
    enum { RINGS = 2000, AROUND = 200 };
    double sum = 0;
    for (int i = 0; i < RINGS * AROUND; ++i) {
        const double nl = (i / AROUND + 0.5) / RINGS, phi = M_PI * (i % AROUND + 0.5) / AROUND;
        const double cosine = nv * nl + sqrt((1 - nv * nv) * (1 - nl * nl)) * cos(phi);
        const double sine2 = 1 - square(nv + nl) / (2 + 2 * cosine);
        const double d = (2 + 1 / alpha) * pow(sine2, 0.5 / alpha) / (2 * M_PI);
        sum += d / (4 * nv * (1 + lambda(nv, alpha) + lambda(nl, alpha)));
    }
    return sum * 2 * M_PI / (RINGS * AROUND);
}

static void sheen(law_room *room) {
    fathom_material m = bare();
    build_rgb(m.sheen_color, through);
    m.sheen_roughness = 0.5f;
    law_lobe(room, m, aside, scale_f64(sheen_reflectance(0.25, 0.6), through));
}

/* ---- anisotropy: GGX of two alphas with F = 1; see ggx_aslant() in matter.c
 * ---- */

/* Seen along the tangent (1), or across it (0). */
static void brushed(law_room *room) {
    const vec3_f64 from = room->number == 1 ? aside : across;
    fathom_material m = law_metallic();
    m.metallic = 1, m.roughness = m.anisotropy = 0.6f;
    law_lobe(room, m, from, scale_f64(law_ggx_albedo(0.36 * 0.64 + 0.36, 0.36, from), white));
}

/* ---- a thin film on smooth metal, at a cosine of 9/16: Belcour & Barla's
 * (2017) sum, term by term ---- */

static double airy(double f0, double cosine, int channel) {
    const double index = 1.5, nanometres = 450;
    static const double fits[4][3] = {{5.4856e-13, 1.6810e6, 4.3278e9},
                                      {4.4201e-13, 1.7953e6, 9.3046e9},
                                      {5.2481e-13, 2.2084e6, 6.6121e9},
                                      {9.7470e-14, 2.2399e6, 4.5282e9}};
    static const double rgb[3][4] = {{3.2404542, -1.5371385, -0.4985314, 3.2404542},
                                     {-0.9692660, 1.8760108, 0.0415560, -0.9692660},
                                     {0.0556434, -0.2040259, 1.0572252, 0.0556434}};
    const double inside = sqrt(1 - (1 - cosine * cosine) / (index * index)),
                 metal = (1 + sqrt(f0)) / (1 - sqrt(f0));
    const double f1 = square((index - 1) / (index + 1)), f2 = square((metal - index) / (metal + index));
    const double r1 = f1 + (1 - f1) * pow(1 - cosine, 5), r2 = f2 + (1 - f2) * pow(1 - inside, 5);
    const double again = square(1 - r1) * r2 / (1 - r1 * r2);
    double sum = r1 + again;
    for (int order = 1; order <= 2; ++order) {
        const double way = 2 * M_PI * 1e-9 * order * 2 * index * nanometres * inside;
        double seen = 0;
        for (int k = 0; k < 4; ++k)
            seen += rgb[channel][k] * fits[k][0] * sqrt(2 * M_PI * fits[k][2]) *
                    cos(fits[k][1] * way + order * (metal < index ? 2 : 1) * M_PI) *
                    exp(-fits[k][2] * way * way);
        sum += 2 * (again - (1 - r1)) * pow(r1 * r2, order / 2.0) * seen / 1.0685e-7;
    }
    return sum;
}

static void film(law_room *room) {
    const double cosine = 0.5625;
    const vec3_f64 color = {0.9, 0.6, 0.2};
    fathom_material m = law_metallic();
    m.metallic = m.iridescence = 1, m.iridescence_ior = 1.5f, m.iridescence_thickness_max = 450;
    build_rgb(m.base_color, color);
    law_lobe(room, m, vec_f64(sqrt(1 - cosine * cosine), 0, cosine),
             vec_f64(airy(color.x, cosine, 0), airy(color.y, cosine, 1), airy(color.z, cosine, 2)));
}

/* Each channel of the base gets what the film does not reflect. Without that, this ball is 0.27 darker. */
static fathom_material filmed(double roughness) {
    fathom_material m = law_metallic();
    m.specular_factor = m.iridescence = 1, m.iridescence_ior = 1.3f, m.iridescence_thickness_max = 400;
    m.roughness = (float)roughness, m.multiscatter = true;
    return m;
}

static void film_over_white(law_room *room) { law_unseen_ball(room, filmed(room->number)); }

static void bubble(law_room *room) {
    fathom_material m = filmed(0);
    m.transmission = 1;
    law_unseen_ball(room, m);
}

/* The film is over the glass alone when viewed from inside: the base would gain 0.15. */
static void half_glass_film(law_room *room) {
    fathom_material m = filmed(0);
    m.transmission = 0.8f, m.thickness = 1;
    law_unseen_ball(room, m);
}

/* ---- volumes ---- */

static fathom_material clear(double index, unsigned priority) {
    fathom_material m = law_clear(1);
    m.ior = (float)index, m.priority = priority;
    return m;
}

/* A lossless material is invisible in a uniform sky, whatever its dispersion. */
static void fire(law_room *room) {
    fathom_material m = clear(1.5, 0);
    m.dispersion = 5;
    law_unseen_ball(room, m);
}

static double both(double r, double s) { return r + square(1 - r) * s / (1 - r * s); }

/* Both planes have the same material: a ray enters the volume at one and leaves it at the other. */
static void slab(law_room *room, double top, double bottom, fathom_material m) {
    const fathom_id material = build_material(&room->b, m);
    build_plane(&room->b, vec_f64(0, 0, top), up, material);
    build_plane(&room->b, vec_f64(0, 0, bottom), down, material);
}

/* Two overlapping slabs: the one with higher priority fills the overlap, and the other one begins at its
 * end. */
static void overlap(law_room *room, fathom_material first, double second) {
    slab(room, -1, -2, first);
    slab(room, -1.5, -3, clear(second, 1));
    paint_plane(&room->b, vec_f64(0, 0, 2), down, build_emitter(white));
    law_look(room, origin, down);
}

static void overlap_even(law_room *room) {
    overlap(room, clear(1.5, 2), 1.5);
    law_value(room, scale_f64(both(0.04, 0.04), white));
}

/* The first slab absorbs over its full thickness, there and back. */
static double from_slabs(double remains, const double *reflected) {
    const double r = reflected[0], s = reflected[1] * square(remains);
    return r + square(1 - r) * s / (1 - r * s);
}

static void overlap_uneven(law_room *room) {
    const double reflected[2] = {0.04, both(square((2 - 1.5) / (2 + 1.5)), square((2.0 - 1) / (2 + 1)))};
    overlap(room, law_tinted(clear(1.5, 2)), 2);
    law_value(room, law_each(law_left, from_slabs, reflected));
}

/* The clear slab has the higher priority and fills the overlap, so light is absorbed over a distance of 1. */
static double through_slabs(double remains, const double *reflected) {
    const double r = reflected[0];
    return square(1 - r) * remains / (1 - square(r * remains));
}

static void overlap_absorbs(law_room *room) {
    static const double reflected[1] = {0.04};
    slab(room, -1, -2, clear(1.5, 2));
    slab(room, -1.5, -3, law_tinted(clear(1.5, 1)));
    paint_plane(&room->b, vec_f64(0, 0, -4), up, build_emitter(white));
    law_look(room, origin, down);
    law_value(room, law_each(law_left, through_slabs, reflected));
}

const law laws_of_layers[] = {
    {"leaf under an even sky", "(1-t) ρ + t τ", leaf, 0},
    {"leaf lit from behind", "k_l t τ", leaf_from_behind, 0},
    {"white leaf in an even sky", "L", white_leaf, 0},
    {"sheen", "∫ D V cos", sheen, 0},
    {"brushed metal, along", "∫ D G₂ v·h / n·v", brushed, 1},
    {"brushed metal, across", "∫ D G₂ v·h / n·v", brushed, 0},
    {"thin film on metal", "Belcour & Barla's sum", film, 0},
    {"smooth film over a white base", "L", film_over_white, 0},
    {"rough film over a white base", "L", film_over_white, 0.4},
    {"bubble in an even sky", "L", bubble, 0},
    {"partly diffuse ball with a film", "L", half_glass_film, 0},
    {"dispersive ball in an even sky", "L", fire, 0},
    {"slabs of one index that overlap", "2r/(1+r)", overlap_even, 0},
    {"slabs of two indices that overlap", "r + (1-r)² c² s/(1-r c² s)", overlap_uneven, 0},
    {"slabs that overlap, one absorbing", "(1-r)² c/(1-r²c²)", overlap_absorbs, 0},
    {NULL, NULL, NULL, 0}};
