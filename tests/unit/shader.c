/* BSDFs of every model: samples follow their density, weights are f over density, and no input makes a number
 * that is not finite. */
#include "defaults.h"
#include "math/lane.h"
#include "shading.h"
#include "variants.h"

VARIANTS(shader_kernels)

/* ---- materials ---- */

static fathom_material classic(float k_d, float k_s, fathom_specular specular, float shininess) {
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_d[c] = k_d, m.k_s[c] = k_s;
    m.specular = specular, m.shininess = shininess;
    return m;
}

static fathom_material metallic(float metal, float roughness) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.metallic = metal, m.roughness = roughness;
    return m;
}

/* thickness 0: a thin wall. */
static fathom_material glassy(float roughness, float thickness, float ior, float transmission) {
    fathom_material m = metallic(0, roughness);
    m.thickness = thickness, m.ior = ior, m.transmission = transmission;
    return m;
}

static fathom_material velvet(float roughness) {
    fathom_material m = metallic(0, 0.8f);
    m.base_color[0] = 0.2f, m.sheen_roughness = roughness;
    for (int c = 0; c < 3; ++c) m.sheen_color[c] = 1;
    return m;
}

static fathom_material brushed(float metal, float roughness) {
    fathom_material m = metallic(metal, roughness);
    m.anisotropy = 0.8f;
    return m;
}

static fathom_material filmed(float metal, float roughness) {
    fathom_material m = metallic(metal, roughness);
    m.iridescence = 0.8f;
    return m;
}

static fathom_material leaf(void) {
    fathom_material m = metallic(0, 0.4f);
    m.diffuse_transmission = 0.6f, m.diffuse_transmission_color[0] = 0.3f;
    return m;
}

/* ---- samples against densities ---- */

enum { RINGS = 24, SECTORS = 16, BINS = RINGS * SECTORS, FINE = 16 };

/* Rings about the mirrored viewer (0, 1, 2: x, y, z of an axis), narrower towards it. */
typedef struct polar {
    double x[3], y[3], z[3], power;
} polar;

static polar polar_of(double cosine, double power) {
    const double sine = sqrt((1 - cosine) * (1 + cosine));
    return (polar){{cosine, 0, sine}, {0, 1, 0}, {-sine, 0, cosine}, power};
}

static double ring_edge(const polar *p, double k) { return M_PI * pow(k / RINGS, p->power); }

static int bin_of(const polar *p, const shader_sample *s, int i) {
    double at[3] = {0, 0, 0};
    for (int c = 0; c < 3; ++c) {
        const double d = (double)s->direction[c][i];
        at[0] += d * p->x[c], at[1] += d * p->y[c], at[2] += d * p->z[c];
    }
    const double theta = atan2(hypot(at[0], at[1]), at[2]);
    double turn = atan2(at[1], at[0]) / (2 * M_PI);
    turn -= floor(turn);
    int ring = (int)(pow(theta / M_PI, 1 / p->power) * RINGS), sector = (int)(turn * SECTORS);
    ring = ring < RINGS ? ring : RINGS - 1, sector = sector < SECTORS ? sector : SECTORS - 1;
    return ring * SECTORS + sector;
}

/* The density's integral over each bin, by midpoints. */
static void integrate_bins(const shading *at, const polar *p, double out[BINS]) {
    for (int bin = 0; bin < BINS; ++bin) {
        const double low = ring_edge(p, bin / SECTORS), high = ring_edge(p, bin / SECTORS + 1);
        out[bin] = 0;
        for (int k = 0; k < FINE * FINE; k += LANES) {
            lanes3 l, f;
            float density[LANES];
            double measure[LANES];
            for (int i = 0; i < LANES; ++i) {
                const double theta = low + (high - low) * ((k + i) / FINE + 0.5) / FINE;
                const double phi = 2 * M_PI * (bin % SECTORS + ((k + i) % FINE + 0.5) / FINE) / SECTORS;
                const double a = sin(theta) * cos(phi), b = sin(theta) * sin(phi), z = cos(theta);
                for (int c = 0; c < 3; ++c) l[c][i] = (float)(a * p->x[c] + b * p->y[c] + z * p->z[c]);
                measure[i] = sin(theta) * (high - low) * 2 * M_PI / (SECTORS * FINE * FINE);
            }
            at->kernels->evaluate(&at->surface, &at->block, l, f, density);
            for (int i = 0; i < LANES; ++i) out[bin] += (double)density[i] * measure[i];
        }
    }
}

/* The chance of a chi² this large (Wilson & Hilferty 1931). */
static double chi_chance(double chi, double freedom) {
    const double v = 2 / (9 * freedom), z = (cbrt(chi / freedom) - (1 - v)) / sqrt(v);
    return 0.5 * erfc(z / sqrt(2));
}

/* Bins that expect fewer than 10 samples are put together, and what is absorbed is one more. */
static double chi_of(const shading *at, const polar *p, random_state *r, int blocks) {
    static double expected[BINS + 1];
    static double found[BINS + 1];
    const double n = 16.0 * blocks;
    integrate_bins(at, p, expected);
    memset(found, 0, sizeof found);
    for (int k = 0; k < blocks; ++k) {
        lanes3 u;
        shader_sample s;
        shading_numbers(r, u);
        at->kernels->sample(&at->surface, &at->block, u, &s);
        for (int i = 0; i < LANES; ++i)
            found[s.density[i] > 0 && isfinite(s.density[i]) ? bin_of(p, &s, i) : BINS] += 1;
    }
    expected[BINS] = 1;
    for (int k = 0; k < BINS; ++k) expected[BINS] -= expected[k];
    double chi = 0, few_expected = 0, few_found = 0;
    int bins = 0;
    for (int k = 0; k <= BINS; ++k) {
        const double e = n * fmax(expected[k], 0);
        if (e < 10) {
            few_expected += e, few_found += found[k];
            continue;
        }
        chi += (found[k] - e) * (found[k] - e) / e, ++bins;
    }
    chi += (few_found - few_expected) * (few_found - few_expected) / fmax(few_expected, 10);
    return chi_chance(chi, bins);
}

/* Level 1e-4 over all cases together, Šidák's correction for how many there are. 65,536 samples each. */
UNIT_TEST(samples_follow_the_density) {
    if (SANITIZED) skip();
    fathom_material behind = classic(0.5f, 0.4f, FATHOM_SPECULAR_PHONG, 10);
    behind.lit_from_behind = true;
    fathom_material wide = classic(0.1f, 0.5f, FATHOM_SPECULAR_BLINN, 0.2f);
    wide.lit_from_behind = true;
    fathom_material half = glassy(0.4f, 0, 1.5f, 0.3f);
    half.opacity = 0.5f;
    fathom_material coated = metallic(0.5f, 0.6f);
    coated.clearcoat = 0.8f, coated.clearcoat_roughness = 0.3f;
    fathom_material tilted = coated;
    tilted.maps[FATHOM_MAP_CLEARCOAT_NORMAL].texture = 0;
    fathom_material brushed_wall = brushed(0, 0.3f), fire = glassy(0.5f, 1, 1.5f, 1);
    brushed_wall.transmission = 0.7f, fire.dispersion = 3;
    const struct {
        const char *name;
        fathom_material m;
        double power;
    } cases[] = {
        {"Lambert", classic(0.7f, 0, FATHOM_SPECULAR_NONE, 0), 1},
        {"Phong 0", classic(0, 0.5f, FATHOM_SPECULAR_PHONG, 0), 1},
        {"Phong 20", classic(0.3f, 0.5f, FATHOM_SPECULAR_PHONG, 20), 2},
        {"Phong 1e7", classic(0.01f, 0.5f, FATHOM_SPECULAR_PHONG, 1e7f), 6},
        {"Blinn 3", classic(0.1f, 0.5f, FATHOM_SPECULAR_BLINN, 3), 1},
        {"Blinn 500", classic(0.1f, 0.5f, FATHOM_SPECULAR_BLINN, 500), 3},
        {"from behind", behind, 1},
        {"Blinn from behind", wide, 1},
        {"metal 1", metallic(1, 1), 1},
        {"metal 0.3", metallic(1, 0.3f), 2.5},
        {"metal 0.02", metallic(1, 0.02f), 6},
        {"dielectric 0.5", metallic(0, 0.5f), 1.5},
        {"half 0.1", metallic(0.5f, 0.1f), 4},
        {"thin wall 0.3", glassy(0.3f, 0, 1.5f, 0.8f), 1},
        {"half there", half, 1.5},
        {"velvet", velvet(0.3f), 1},
        {"fibres 0.07", velvet(0), 1},
        {"brushed", brushed(1, 0.15f), 1.5},
        {"brushed dielectric", brushed(0, 0.4f), 1.5},
        {"brushed wall", brushed_wall, 1},
        {"film", filmed(0, 0.3f), 1.5},
        {"film on metal", filmed(1, 0.5f), 1.5},
        {"leaf", leaf(), 1},
        {"fire", fire, 1},
        {"coated", coated, 2},
        {"coat with a normal of its own", tilted, 2},
        {"glass 0.4", glassy(0.4f, 1, 1.5f, 1), 1},
        {"glass 0.8", glassy(0.8f, 1, 1.2f, 0.5f), 1},
        {"light glass 0.6", glassy(0.6f, 1, 0.8f, 1), 1},
    };
    static const double cosines[] = {1, 0.6, 0.05};
    const int tests = (int)(6 * sizeof cases / sizeof *cases);
    random_state r = {11};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        for (int j = 0; j < 6; ++j) {
            shading at;
            shading_open(&at, &cases[k].m, cosines[j / 2], j % 2);
            const polar p = polar_of(cosines[j / 2], cases[k].power);
            const double chance = chi_of(&at, &p, &r, 4096);
            if (!(chance > 1 - pow(1 - 1e-4, 1.0 / tests)))
                fail_msg("%s at cosine %g, %s: chance %g", cases[k].name, cosines[j / 2],
                         j % 2 ? "entering" : "leaving", chance);
        }
    }
}

/* ---- any input ---- */

static vec3_f32 any_direction(random_state *r) {
    vec3_f64 v;
    do v = vec_f64(random_in(r, -1, 1), random_in(r, -1, 1), random_in(r, -1, 1));
    while (dot_f64(v, v) > 1 || dot_f64(v, v) < 1e-4);
    if (random_unit(r) < 0.2) v.z *= 1e-6; /* along the surface z = 0 */
    return narrow(normalize_f64(v));
}

static void put(lanes3 to, int i, vec3_f32 v) { to[0][i] = v.x, to[1][i] = v.y, to[2][i] = v.z; }

/* ng and ns may be anything that surface_block allows: ng faces the viewer, ns may not. */
static void random_surface(random_state *r, surface_block *s) {
    memset(s, 0, sizeof *s);
    s->count = LANES, s->directed = 0x0f0f, s->coated = 0x3333;
    const bool one = random_unit(r) < 0.5;
    for (int i = 0; i < LANES; ++i) {
        vec3_f32 ng = {0, 0, 1}, v = any_direction(r), ns = any_direction(r);
        if (v.z < 0) v.z = -v.z;
        if (ns.z < 0) ns.z = -ns.z;
        if (random_unit(r) < 0.1) v = ng;
        put(s->ng, i, ng);
        put(s->ns, i, random_unit(r) < 0.5 ? ng : ns);
        put(s->v, i, v);
        put(s->along, i, any_direction(r));
        put(s->coat, i, any_direction(r));
        put(s->base, i, random_unit(r) < 0.5 ? ng : ns);
        s->material[i] = one ? 0 : (uint32_t)random_in(r, 0, 8);
        s->entering[i] = random_unit(r) < 0.5 ? ~0u : 0, s->smooth[i] = random_unit(r) < 0.3 ? ~0u : 0;
    }
}

static float choice(random_state *r, const float *from, unsigned count) {
    return from[(unsigned)(random_unit(r) * count)];
}

#define CHOICE(r, ...)                                                                                       \
    choice(r, (const float[]){__VA_ARGS__}, sizeof(const float[]){__VA_ARGS__} / sizeof(float))

static fathom_material random_material(random_state *r) {
    fathom_material m = default_material();
    m.model = random_unit(r) < 0.5 ? FATHOM_MODEL_CLASSIC : FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.specular = (fathom_specular)(random_unit(r) * 3);
    m.shininess = CHOICE(r, 0, 0.5f, 40, 1e6f, 1e9f);
    m.fresnel = random_unit(r) < 0.5, m.lit_from_behind = random_unit(r) < 0.3;
    m.ior = CHOICE(r, 1, 1 + 1e-7f, 1 - 1e-7f, 1.5f, 3, 0.3f, 1e3f, 1e-3f);
    for (int c = 0; c < 3; ++c) {
        m.k_d[c] = CHOICE(r, 0, 1, 0.5f), m.k_s[c] = CHOICE(r, 0, 1, 1e30f);
        m.k_r[c] = CHOICE(r, 0, 1, 0.5f), m.k_t[c] = CHOICE(r, 0, 1, 0.5f);
        m.base_color[c] = CHOICE(r, 0, 1, 0.3f), m.specular_color[c] = CHOICE(r, 0, 1, 1e6f);
    }
    m.metallic = CHOICE(r, 0, 1, 0.5f), m.roughness = CHOICE(r, 0, 1e-4f, 0.011f, 0.012f, 0.3f, 1);
    m.specular_factor = CHOICE(r, 0, 1, 0.5f);
    m.transmission = CHOICE(r, 0, 1, 0.5f), m.thickness = CHOICE(r, 0, 1, 1e30f);
    m.attenuation_distance = CHOICE(r, 0, 1, 1e-30f, 1e30f), m.multiscatter = random_unit(r) < 0.7;
    if (m.model == FATHOM_MODEL_METALLIC_ROUGHNESS && random_unit(r) < 0.1) m.ior = 0;
    m.emissive[0] = m.emissive_strength = CHOICE(r, 0, 1, 1e30f);
    m.attenuation_color[0] = CHOICE(r, 0, 1, 0.5f), m.opacity = CHOICE(r, 0, 0.3f, 1, 1);
    m.clearcoat = CHOICE(r, 0, 0, 0.5f, 1), m.clearcoat_roughness = CHOICE(r, 0, 0.012f, 0.3f, 1);
    if (random_unit(r) < 0.3) m.maps[FATHOM_MAP_CLEARCOAT_NORMAL].texture = 0;
    if (random_unit(r) < 0.5) return m;
    m.sheen_color[0] = CHOICE(r, 0, 0.5f, 1), m.sheen_roughness = CHOICE(r, 0, 0.07f, 0.4f, 1);
    m.anisotropy = CHOICE(r, 0, 0.5f, 1), m.iridescence = CHOICE(r, 0, 0, 0.5f, 1);
    m.iridescence_ior = CHOICE(r, 1, 1.3f, 5), m.iridescence_thickness_max = CHOICE(r, 0, 300, 1e6f);
    m.dispersion = CHOICE(r, 0, 0.5f, 1e3f), m.diffuse_transmission = CHOICE(r, 0, 0, 0.5f, 1);
    return m;
}

static float random_number(random_state *r) {
    if (random_unit(r) < 0.1) return CHOICE(r, 0, 0x1p-24f, 0.5f, 0x1.fffffep-1f);
    return (float)(random_unit(r) * (1 - 0x1p-24));
}

/* The shading normal alone decides about smooth lanes. */
static bool is_above(const surface_block *s, const lanes3 direction, unsigned i) {
    const vec3_f32 to = lane_f32(direction, i);
    return dot_f32(lane_f32(s->ng, i), to) >= 0 || (s->smooth[i] && dot_f32(lane_f32(s->ns, i), to) > 0);
}

static void check_sample(const surface_block *s, const shader *table, const shader_sample *out,
                         const lanes3 f, const float density[LANES], unsigned i) {
    float length = 0, up = 0;
    for (int c = 0; c < 3; ++c) {
        length += out->direction[c][i] * out->direction[c][i];
        up += out->direction[c][i] * s->ng[c][i];
        assert_true(isfinite(out->weight[c][i]) && out->weight[c][i] >= 0);
        assert_true(isfinite(f[c][i]) && f[c][i] >= 0);
    }
    assert_near(length, 1, 1e-6); /* a few roundings of 2^-24 */
    assert_true(out->density[i] >= 0 && density[i] >= 0 && isfinite(density[i]));
    const bool carries = out->weight[0][i] + out->weight[1][i] + out->weight[2][i] > 0;
    if (carries) assert_true(out->through[i] ? up <= 0 : is_above(s, out->direction, i));
    if (out->through[i] && carries) assert_true(table[s->material[i]].transmits);
    if (isinf(out->density[i])) return;
    if (out->density[i] == 0) {
        assert_false(carries);
        return;
    }
    assert_true(out->density[i] == density[i]);
    for (int c = 0; c < 3 && density[i] > 1e-30f; ++c) {
        /* The same operations in another order: a few roundings. */
        const double expected = fmin((double)f[c][i] / (double)density[i], 0x1p100);
        assert_near(out->weight[c][i], expected, 1e-6 * expected + 0x1p-126); /* denormals have few digits */
    }
}

UNIT_TEST(any_material_gives_finite_numbers_and_no_light_through_what_is_opaque) {
    random_state r = {3};
    const shader_kernels *kernels = shader_kernels_best();
    for (int round = 0; round < (SANITIZED ? 250 : 20000); ++round) {
        surface_block s;
        shader table[8];
        shader_block block;
        shader_sample out;
        lanes3 u, f;
        float density[LANES];
        for (int k = 0; k < 8; ++k) {
            const fathom_material m = random_material(&r);
            shader_prepare(&m, &table[k]);
            for (int c = 0; c < 3; ++c) {
                assert_true(isfinite(table[k].absorption[c]) && table[k].absorption[c] >= 0);
                assert_true(isfinite(table[k].emission[c]) && table[k].albedo[c] <= 1);
            }
        }
        random_surface(&r, &s);
        for (int i = 0; i < LANES; ++i) {
            for (int c = 0; c < 3; ++c) u[c][i] = random_number(&r);
        }
        for (int i = 0; i < LANES; ++i)
            block.at[i] = &table[s.material[i]], block.channel[i] = (uint32_t)(i % 4);
        kernels->make(&s, &block);
        kernels->sample(&s, &block, u, &out);
        kernels->evaluate(&s, &block, out.direction, f, density);
        for (unsigned i = 0; i < LANES; ++i) check_sample(&s, table, &out, f, density, i);
        for (int i = 0; i < LANES; ++i) put(u, i, any_direction(&r));
        kernels->evaluate(&s, &block, u, f, density);
        for (unsigned i = 0; i < LANES; ++i) {
            assert_true(isfinite(density[i]) && density[i] >= 0);
            for (int c = 0; c < 3; ++c) assert_true(isfinite(f[c][i]) && f[c][i] >= 0);
            if (!is_above(&s, u, i) && !table[s.material[i]].transmits)
                assert_true(f[0][i] + f[1][i] + f[2][i] == 0);
        }
    }
}

/* Points of eight materials, and the numbers of their samples. */
static void random_block(random_state *r, shader table[8], surface_block *s, lanes3 u) {
    for (int k = 0; k < 8; ++k) {
        const fathom_material m = random_material(r);
        shader_prepare(&m, &table[k]);
    }
    random_surface(r, s);
    for (int i = 0; i < LANES; ++i) {
        for (int c = 0; c < 3; ++c) u[c][i] = random_number(r);
    }
}

UNIT_TEST(every_instruction_set_gives_the_same_bits) {
    random_state r = {5};
    for (int round = 0; round < 500; ++round) {
        surface_block s;
        shader table[8];
        lanes3 u;
        random_block(&r, table, &s, u);
        shader_sample first = {.density = {0}};
        for (unsigned k = 0; shader_kernels_at(k); ++k) {
            shader_block block;
            shader_sample out;
            memset(&out, 0, sizeof out);
            for (int i = 0; i < LANES; ++i)
                block.at[i] = &table[s.material[i]], block.channel[i] = (uint32_t)(i % 4);
            shader_kernels_at(k)->make(&s, &block);
            shader_kernels_at(k)->sample(&s, &block, u, &out);
            if (k == 0) first = out;
            assert_memory_equal(&first, &out, sizeof out);
        }
    }
}

/* Lane `from` in all lanes. */
static surface_block repeated(const surface_block *s, int from) {
    surface_block out = *s;
    for (int i = 0; i < LANES; ++i) {
        for (int c = 0; c < 3; ++c) {
            out.ng[c][i] = s->ng[c][from], out.ns[c][i] = s->ns[c][from], out.v[c][i] = s->v[c][from];
            out.along[c][i] = s->along[c][from], out.coat[c][i] = s->coat[c][from];
            out.base[c][i] = s->base[c][from];
        }
        out.material[i] = s->material[from], out.entering[i] = s->entering[from];
        out.smooth[i] = s->smooth[from];
    }
    const uint32_t bit = 1u << from;
    out.mapped = s->mapped & bit ? 0xffff : 0, out.coated = s->coated & bit ? 0xffff : 0;
    out.directed = s->directed & bit ? 0xffff : 0;
    return out;
}

typedef struct lane_found {
    float direction[3], weight[3], density, f[3], of_f;
    uint32_t through, straight;
} lane_found;

/* What lane i is told of its sample, and of light from l. */
static lane_found found_by(const shader_kernels *kernels, const surface_block *s, const shader *table,
                           const uint32_t channel[LANES], const lanes3 u, const lanes3 l, int i) {
    shader_block block;
    shader_sample out;
    lanes3 f;
    float density[LANES];
    for (int k = 0; k < LANES; ++k) block.at[k] = &table[s->material[k]], block.channel[k] = channel[k];
    kernels->make(s, &block);
    kernels->sample(s, &block, u, &out);
    kernels->evaluate(s, &block, l, f, density);
    lane_found found = {.density = out.density[i],
                        .of_f = density[i],
                        .through = out.through[i],
                        .straight = out.straight[i]};
    for (int c = 0; c < 3; ++c)
        found.direction[c] = out.direction[c][i] + 0.0f, found.weight[c] = out.weight[c][i] + 0.0f,
        found.f[c] = f[c][i] + 0.0f; /* no -0 */
    return found;
}

/* Which points share a block depends on the crop and on the wave: what they become must not. */
UNIT_TEST(no_lane_depends_on_its_neighbours) {
    random_state r = {8};
    for (int round = 0; round < (SANITIZED ? 250 : 10000); ++round) {
        surface_block s;
        shader table[8];
        lanes3 u, l;
        uint32_t channel[LANES];
        random_block(&r, table, &s, u);
        for (int i = 0; i < LANES; ++i) {
            put(l, i, any_direction(&r));
            channel[i] = (uint32_t)(i % 4);
            if (!(table[s.material[i]].lobes & SHADER_TURNED)) s.coated &= ~(1u << i);
        }
        const int i = (int)(random_unit(&r) * LANES);
        const lane_found among = found_by(shader_kernels_best(), &s, table, channel, u, l, i);
        const surface_block alone = repeated(&s, i);
        for (int k = 0; k < LANES; ++k) {
            channel[k] = channel[i];
            for (int c = 0; c < 3; ++c) u[c][k] = u[c][i], l[c][k] = l[c][i];
        }
        const lane_found by_itself = found_by(shader_kernels_best(), &alone, table, channel, u, l, i);
        assert_memory_equal(&among, &by_itself, sizeof among);
    }
}

/* ---- laws ---- */

/* f of light from l, as seen from v, both above or below z = 0; the solid is below. */
static void value_between(const fathom_material *m, const double v[3], const double l[3], double f[3]) {
    const double up = v[2] < 0 ? -1 : 1; /* turns v to z > 0 */
    const double length = hypot(v[0], v[1]), x = length > 0 ? v[0] / length : 1,
                 y = length > 0 ? v[1] / length : 0;
    const double to[3] = {x * l[0] + y * l[1], -y * l[0] + x * l[1], up * l[2]};
    shading at;
    shading_open(&at, m, fabs(v[2]), up > 0);
    shading_direct(&at, x, -y, 0);
    shading_value(&at, to, f);
    for (int c = 0; c < 3; ++c) f[c] /= fabs(l[2]);
}

static void random_unit_vector(random_state *r, double out[3]) {
    const double z = random_in(r, 0.02, 1) * (random_unit(r) < 0.5 ? -1 : 1), phi = random_in(r, 0, 2 * M_PI);
    out[0] = sqrt(1 - z * z) * cos(phi), out[1] = sqrt(1 - z * z) * sin(phi), out[2] = z;
}

/* f(a,b) = f(b,a), over the squared indices of the media that the light comes from. Half vectors and dot
 * products have a few roundings of 2^-24; the power n <= 500 makes 500 of each, GGX 2 / alpha with alpha >=
 * 0.04, and a refracting half vector, of which eta - 1 >= 0.2 is left, 5. Cosines of grazing facets are known
 * to a few 2^-24 absolutely. */
UNIT_TEST(scattering_is_reciprocal) {
    random_state r = {9};
    for (int k = 0; k < (SANITIZED ? 64 : 10000); ++k) {
        const float roughness = (float)random_in(&r, 0.2, 1), ior = (float)random_in(&r, 1.2, 2);
        fathom_material m = metallic((float)random_unit(&r), roughness);
        const bool lectures = k % 4 == 0;
        if (lectures)
            m = classic(0.5f, 0.5f, k % 8 ? FATHOM_SPECULAR_PHONG : FATHOM_SPECULAR_BLINN,
                        (float)random_in(&r, 0, 500));
        if (k % 4 == 1) m = glassy(roughness, 0, ior, 0.7f);
        if (k % 4 == 2) m = glassy(roughness, 1, ior, 1);
        m.base_color[0] = 0.3f, m.multiscatter = k % 8 < 4;
        m.clearcoat = k % 16 < 8 ? 0 : 0.7f, m.clearcoat_roughness = 0.4f;
        if (k % 4 != 2) m.diffuse_transmission = k % 5 ? 0 : 0.4f;
        m.sheen_color[1] = k % 3 ? 0 : 0.8f, m.sheen_roughness = 0.3f;
        m.anisotropy = k % 7 ? 0 : 0.6f, m.iridescence = k % 11 ? 0 : 0.7f;
        double a[3], b[3], f[3], g[3];
        random_unit_vector(&r, a), random_unit_vector(&r, b);
        value_between(&m, a, b, f), value_between(&m, b, a, g);
        const double index = k % 4 == 2 ? (double)ior : 1;
        const double from_a = a[2] < 0 ? index * index : 1, from_b = b[2] < 0 ? index * index : 1;
        for (int c = 0; c < 3; ++c) {
            const double wrong = 8 * 0x1p-24 * (lectures ? 500 : 250 * f[c] / from_b + 1);
            assert_near(f[c] / from_b, g[c] / from_a, wrong);
        }
    }
}

/* L k_d |n·l| of the lectures is the radiance under the irradiance pi L: f |cosine| pi. */
UNIT_TEST(classic_values_are_the_lectures_over_pi) {
    fathom_material m = classic(0.3f, 0.6f, FATHOM_SPECULAR_PHONG, 5);
    const double l[3] = {0.6, 0, 0.8}; /* the viewer is at (0.8, 0, 0.6): r·l = 0.8 · 0.6 - 0.48 = 0 */
    double f[3];
    shading at;
    shading_open(&at, &m, 0.6, true);
    shading_value(&at, l, f);
    assert_near(f[0], 0.3 * 0.8 / M_PI, 1e-6);
    const double mirrored[3] = {-0.8, 0, 0.6};
    shading_value(&at, mirrored, f);
    assert_near(f[0], (0.3 + 0.6) * 0.6 / M_PI, 1e-6);
}

int main(void) { return unit_main(NULL, NULL); }
