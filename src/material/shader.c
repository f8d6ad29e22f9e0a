#include "material/shader.h"

#include "material/layers.h"
#include "material/mixture.h"

#include "base/kernel.h"
#include "math/limit.h"
#include "math/rgb.h"

#include <math.h>
#include <string.h>

static float largest(const float rgb[3]) { return most(rgb[0], most(rgb[1], rgb[2])); }

/* ---- the classic model ---- */

/* The classic model's L k_d |n·l| is the radiance under the irradiance pi L |n·l|: so f = rho / pi, for the
 * diffuse and the specular term. Ambient light and k_a belong to the classic integrator only. */
static void prepare_classic(const fathom_material *m, shader *out) {
    const bool shiny = m->specular != FATHOM_SPECULAR_NONE && rgb_any(m->k_s);
    const bool phong = m->specular == FATHOM_SPECULAR_PHONG;
    const float spread = phong ? 2 / (m->shininess + 2) : 8 / (m->shininess + 8);
    for (int c = 0; c < 3; ++c) {
        out->diffuse[c] = m->k_d[c];
        out->highlight[c] = shiny ? m->k_s[c] : 0;
        out->k_r[c] = m->k_r[c], out->k_t[c] = m->k_t[c];
        out->albedo[c] = least(m->k_d[c] + out->highlight[c] * spread + m->k_r[c] + m->k_t[c], 1);
    }
    out->shininess = m->shininess;
    out->ior = m->ior;
    out->blinn = shiny && !phong ? ~0u : 0;
    out->fresnel = m->fresnel ? ~0u : 0;
    out->from_behind = m->lit_from_behind ? ~0u : 0;
    out->encloses = rgb_any(m->k_t);
    out->clear = rgb_any(m->k_t) && m->ior == 1;
    out->transmits = m->lit_from_behind || out->encloses;
    out->lobes = (rgb_any(m->k_d) ? SHADER_DIFFUSE : 0u) | (shiny ? SHADER_HIGHLIGHT : 0u) |
                 (rgb_any(m->k_r) || rgb_any(m->k_t) ? SHADER_CLASSIC : 0u) |
                 (m->lit_from_behind ? SHADER_BEHIND : 0u);
}

/* ---- metallic-roughness ---- */

typedef struct mixture {
    float metal, layer[3], f0[3], f90; /* layer: F0 of the dielectric */
} mixture;

static mixture mixture_of(const fathom_material *m) {
    mixture x = {.metal = m->metallic, .f90 = mixed(m->specular_factor, 1, m->metallic)};
    for (int c = 0; c < 3; ++c) {
        x.layer[c] = mixture_layer(m->ior, m->specular_factor, m->specular_color[c]);
        x.f0[c] = mixed(x.layer[c], m->base_color[c], x.metal);
    }
    return x;
}

bool shader_coat_has_normal(const fathom_material *m) {
    static const int kinds[] = {FATHOM_MAP_NORMAL, FATHOM_MAP_BUMP, FATHOM_MAP_CLEARCOAT_NORMAL};
    bool has = false;
    for (int k = 0; k < 3; ++k) has |= m->maps[kinds[k]].texture != FATHOM_NONE;
    return has && m->model == FATHOM_MODEL_METALLIC_ROUGHNESS && m->clearcoat > 0;
}

/* The clear coat; shader_below_coat() then gives C of shader.h. */
static void prepare_coat(const fathom_material *m, shader *out) {
    const float alpha = m->clearcoat_roughness * m->clearcoat_roughness;
    if (!(m->clearcoat > 0)) return;
    out->coat_facets = energy_curve_of(alpha);
    out->coat = out->coat_strength = m->clearcoat;
    out->coat_alpha = most(alpha, SHADER_SMOOTH_ALPHA);
    const bool turned = shader_coat_has_normal(m);
    out->lobes |= SHADER_COATED | (turned ? SHADER_TURNED : 0);
    out->lobes |= alpha < SHADER_SMOOTH_ALPHA && !turned ? SHADER_MIRROR : SHADER_COAT;
}

/* Mean albedos of the base's facets. */
static void find_means(float alpha, shader *out, float *mean, float *mean_edge) {
    if (!(out->lobes & SHADER_STRETCHED)) {
        out->facets = energy_curve_of(alpha);
        energy_means(&out->facets, mean, mean_edge);
        return;
    }
    float all[ENERGY_NODES], edge[ENERGY_NODES];
    energy_stretched(out->along, out->alpha, &out->stretch);
    energy_stretched_curves(&out->stretch, all, edge);
    *mean = energy_mean(all), *mean_edge = energy_mean(edge);
}

/* The mean fraction of a channel's light that reaches the base through layer and coat. */
static float mean_below(const shader *out, int c) {
    float all[ENERGY_NODES], edge[ENERGY_NODES];
    if (out->lobes & SHADER_STRETCHED) {
        energy_stretched_curves(&out->stretch, all, edge);
    } else {
        for (int k = 0; k < ENERGY_NODES; ++k)
            all[k] = energy_all(&out->facets, k), edge[k] = energy_edge(&out->facets, k);
    }
    for (int k = 0; k < ENERGY_NODES; ++k) {
        const float x = (float)k / ENERGY_STEPS;
        const float under =
            out->lobes & SHADER_FILM
                ? film_under(out, c, all[k], edge[k], film_read(out->film_rest[c], x * x * (x * x)))
                : shader_under(out, all[k], edge[k]);
        all[k] = under * shader_below_coat(out, k);
    }
    return energy_mean(all);
}

static void find_missing(float alpha, shader *out) {
    if (!(out->lobes & SHADER_STRETCHED)) {
        energy_glass(alpha, out->eta, out->layer0, out->layer90, out->glass_missing);
        return;
    }
    energy_glass_stretched(out->along, out->alpha, out->eta, out->layer0, out->layer90, &out->glass_stretch);
    energy_glass_stretched_curves(&out->glass_stretch, out->glass_missing);
}

/* The factors of light that leaves rough glass after more than one scattering. part: weight of the glass. */
static void prepare_glass(float alpha, float part, shader *out) {
    const float open = 1 - (out->layer0 + (out->layer90 - out->layer0) * (1 / 21.0f)), eta = out->eta;
    float lost[2];
    find_missing(alpha, out);
    for (int side = 0; side < 2; ++side) {
        lost[side] = energy_mean(out->glass_missing[side]);
        energy_sums(out->glass_missing[side], out->glass_sums[side]);
    }
    for (int side = 0; side < 2; ++side) {
        const bool denser = (eta < 1) == (side == 0);
        const float through = denser ? open * least(eta * eta, 1 / (eta * eta)) : open;
        const float crosses = through * lost[!side] / most(most(lost[0], lost[1]), 1e-6f);
        out->glass_through[side] = crosses;
        out->glass_again[side] = part * (1 - crosses) * mixture_scale(lost[side]);
        for (int c = 0; c < 3; ++c)
            out->glass_again_cross[side][c] = out->cross[c] * crosses * mixture_scale(lost[!side]);
    }
    out->glass_part = part;
    out->lobes |= SHADER_GLASS;
}

/* The means of the light that reaches the base, by which its lobes are divided. */
static void prepare_base(const film_means *film, float mean, float mean_edge, shader *out) {
    out->layer_again = mixture_again(out->layer0, out->layer90, mean);
    if (out->lobes & SHADER_FILM) {
        prepare_film_base(film, mean, out);
        for (int c = 0; c < 3; ++c) out->film_lift[c] = mixture_lifted(1, mean_below(out, c));
        return;
    }
    out->mean_under = mixture_under(out->layer0, out->layer90, out->layer_again, mean, mean_edge);
    if (out->lobes & SHADER_COATED) out->mean_under = mean_below(out, 0);
    for (int c = 0; c < 3; ++c) {
        out->diffuse[c] = mixture_lifted(out->diffuse[c], out->mean_under);
        out->leaf[c] = mixture_lifted(out->leaf[c], out->mean_under);
    }
}

static void prepare_even(const fathom_material *m, const mixture *x, const film_means *film, float alpha,
                         shader *out) {
    const float glass = out->lobes & SHADER_REFRACT ? (1 - x->metal) * m->transmission : 0;
    const bool filmed = out->lobes & SHADER_FILM;
    float mean, mean_edge;
    find_means(alpha, out, &mean, &mean_edge);
    prepare_base(film, mean, mean_edge, out);
    const float scale = mixture_scale(1 - mean);
    for (int c = 0; c < 3; ++c) {
        const float *d = film->dielectric, *b = film->metal;
        const float layer =
            filmed ? mixture_again(d[c], d[c], mean) : mixture_again(x->layer[c], m->specular_factor, mean);
        const float metal =
            filmed ? mixture_again(b[c], b[c], mean) : mixture_again(m->base_color[c], 1, mean);
        const float q = mixed(layer, metal, x->metal) - glass * layer;
        out->again[c] = q * scale;
        if (out->lobes & SHADER_SOLID)
            out->base_again[c] = (1 - x->metal) * (1 - m->transmission) * layer * scale;
        out->missing_share += q * (1 / 3.0f);
        const float kept = filmed ? out->film_again[c] : out->layer_again;
        if (out->lobes & SHADER_THIN) out->again_cross[c] = out->cross[c] * (1 - kept) * scale;
    }
    if (glass > 0) prepare_glass(alpha, glass, out);
    out->even = ~0u;
    out->lobes |= SHADER_EVEN;
}

/* An index of 0 does not refract, and its surface transmits no light. Rough surfaces whose index deflects
 * light by less than their least alpha do not refract. */
static uint32_t crossing_lobe(const fathom_material *m, float alpha, shader *out) {
    const float bend = fabsf(m->ior - 1), least_bend = alpha < SHADER_SMOOTH_ALPHA ? 0 : SHADER_SMOOTH_ALPHA;
    const bool solid = m->thickness > 0 && m->ior > 0 && bend > least_bend;
    if (!rgb_any(out->cross)) return 0;
    out->transmits = true;
    out->encloses = m->thickness > 0;
    out->clear = !solid && !out->encloses && alpha < SHADER_SMOOTH_ALPHA;
    if (!solid)
        return alpha < SHADER_SMOOTH_ALPHA ? SHADER_PASS : (m->thickness > 0 ? SHADER_PASS : SHADER_THIN);
    out->eta = least(most(m->ior, 1e-3f), 1e3f);
    const bool clear = alpha * least(fabsf(out->eta - 1), 1) < SHADER_SMOOTH_ALPHA;
    /* Only if the surface refracts: otherwise the colours do not separate. */
    if (m->dispersion > 0 && out->eta > 1) {
        out->eta_spread = 0.025f * (out->eta - 1) * least(m->dispersion, 40);
        return (clear ? SHADER_PASS : SHADER_REFRACT) | SHADER_SOLID | SHADER_DISPERSIVE;
    }
    return (clear ? SHADER_PASS : SHADER_REFRACT) | SHADER_SOLID;
}

static void prepare_absorption(const fathom_material *m, shader *out) {
    if (!(m->thickness > 0 && out->transmits && m->attenuation_distance > 0)) return;
    for (int c = 0; c < 3; ++c)
        out->absorption[c] = limited(fmaxf(-logf(m->attenuation_color[c]) / m->attenuation_distance, 0));
}

static void scale(float factor, float rgb[3]) {
    for (int c = 0; c < 3; ++c) rgb[c] *= factor;
}

static void cover(float opacity, shader *out) {
    if (opacity >= 1) return;
    float *const colours[] = {out->diffuse, out->f0,          out->mirror0,   out->cross,     out->again,
                              out->k_r,     out->again_cross, out->highlight, out->k_t,       out->leaf,
                              out->sheen,   out->metal_rise,  out->base_f0,   out->base_again};
    for (size_t i = 0; i < sizeof colours / sizeof *colours; ++i) scale(opacity, colours[i]);
    for (int side = 0; side < 2 && out->lobes & SHADER_GLASS; ++side) {
        scale(opacity, out->glass_again_cross[side]);
        out->glass_again[side] *= opacity;
    }
    out->base_f90 *= opacity;
    out->coat *= opacity, out->f90 *= opacity, out->mirror90 *= opacity, out->missing_share *= opacity;
    for (int c = 0; c < 3 && out->lobes & SHADER_FILM; ++c) {
        for (int k = 0; k <= FILM_STEPS; ++k) out->film[c][k] *= opacity;
    }
    out->hole = 1 - opacity;
    out->lobes |= SHADER_STRAIGHT;
    out->transmits = true;
}

/* Reflection by the surface of a solid, which is not the same from inside. */
static void prepare_solid(const fathom_material *m, const mixture *x, shader *out) {
    const float base = (1 - x->metal) * (1 - m->transmission);
    for (int c = 0; c < 3; ++c) out->base_f0[c] = base * x->layer[c];
    out->base_f90 = out->lobes & SHADER_FILM ? base : base * m->specular_factor;
    if (!(x->metal > 0)) return;
    for (int c = 0; c < 3; ++c) out->metal_rise[c] = x->metal * (1 - m->base_color[c]);
    out->lobes |= SHADER_INNER_METAL;
}

/* Schlick's reflectance is linear in F0 and F90, so those of dielectric and metal are mixed once. The light
 * left for the base under the dielectric depends on the largest channel (KHR_materials_specular). */
static void prepare_metallic(const fathom_material *m, shader *out) {
    const mixture x = mixture_of(m);
    film_means means = {{0}, {0}, {0}};
    const float alpha = m->roughness * m->roughness, base = 1 - x.metal, film = m->iridescence;
    const float along = mixed(alpha, 1, m->anisotropy * m->anisotropy);
    const bool shiny = x.f90 > 0 || rgb_any(x.f0) || film > 0, smooth = along < SHADER_SMOOTH_ALPHA;
    out->layer0 = largest(x.layer);
    out->layer90 = m->specular_factor;
    for (int c = 0; c < 3; ++c) {
        const float solid = base * (1 - m->transmission);
        out->diffuse[c] = solid * (1 - m->diffuse_transmission) * m->base_color[c];
        out->leaf[c] = solid * m->diffuse_transmission * m->diffuse_transmission_color[c];
        out->cross[c] = base * m->transmission * m->base_color[c];
        out->albedo[c] =
            least(x.f0[c] + (out->diffuse[c] + out->cross[c] + out->leaf[c]) * (1 - out->layer0), 1);
    }
    memcpy(smooth ? out->mirror0 : out->f0, x.f0, sizeof x.f0);
    *(smooth ? &out->mirror90 : &out->f90) = x.f90;
    out->alpha = most(alpha, SHADER_SMOOTH_ALPHA);
    out->along = along;
    out->ior = m->ior, out->priority = m->priority;
    out->lobes = (rgb_any(out->diffuse) ? SHADER_DIFFUSE : 0u) | (out->layer90 > 0 ? SHADER_LAYER : 0u) |
                 (shiny && !smooth ? SHADER_GGX : 0u) | (shiny && smooth ? SHADER_MIRROR : 0u);
    if (film > 0) prepare_film(m, x.layer, out, &means);
    out->lobes |= crossing_lobe(m, along, out);
    if (along > out->alpha && out->lobes & (SHADER_GGX | SHADER_THIN | SHADER_REFRACT))
        out->lobes |= SHADER_STRETCHED;
    if (out->lobes & SHADER_SOLID) prepare_solid(m, &x, out);
    if (rgb_any(out->leaf)) {
        out->lobes |= SHADER_LEAF;
        out->transmits = true;
        out->encloses |= m->thickness > 0;
    }
    prepare_absorption(m, out);
    if (rgb_any(m->sheen_color)) prepare_sheen(m, out);
    prepare_coat(m, out);
    /* Lambert's lobe alone has no facets, and faster kernels. */
    if (m->multiscatter && out->lobes != SHADER_DIFFUSE) prepare_even(m, &x, &means, alpha, out);
    out->one_sided = material_is_one_sided(m);
}

void shader_emission(const fathom_material *m, float out[3]) {
    const bool classic = m->model == FATHOM_MODEL_CLASSIC;
    const float opacity = material_opacity(m);
    for (int c = 0; c < 3; ++c) {
        out[c] = limited(classic ? m->k_e[c] : m->emissive_strength * m->emissive[c]);
        if (opacity < 1) out[c] *= opacity;
    }
}

/* Textured surfaces prepare a shader for each point: large members that the lobes do not use are not
 * cleared. */
void shader_prepare(const fathom_material *m, shader *out) {
    memset(out, 0, offsetof(shader, stretch));
    out->facets = out->coat_facets = energy_none;
    out->model = m->model, out->alpha = out->ior = out->eta = out->mean_under = 1;
    shader_emission(m, out->emission);
    switch (m->model) {
    case FATHOM_MODEL_CLASSIC: prepare_classic(m, out); break;
    case FATHOM_MODEL_METALLIC_ROUGHNESS: prepare_metallic(m, out); break;
    }
    cover(material_opacity(m), out);
}

void shader_prepare_hole(shader *out) {
    memset(out, 0, sizeof *out);
    out->facets = out->coat_facets = energy_none;
    out->alpha = out->ior = out->eta = out->mean_under = out->hole = 1;
    out->transmits = true;
    out->lobes = SHADER_STRAIGHT;
}

float shader_index(const shader *m, uint32_t channel) {
    if (!(m->lobes & SHADER_DISPERSIVE)) return m->ior;
    return fmaxf(m->ior + ((float)channel - 2) * m->eta_spread, 1.0001f);
}

KERNEL_BEST(shader_kernels)
