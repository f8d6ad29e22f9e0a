/* Parameters of materials at a point. */
#include "material/textured_inner.h"
#include "math/limit.h"
#include "math/rgb.h"

#define NONE ((size_t)-1)

/* Members of fathom_material by kind of map, for each model. */
static const struct {
    size_t metallic, classic;
    int count;
    bool bounded; /* to at most 1 */
} members[FATHOM_MAPS] = {
    [FATHOM_MAP_COLOR] = {offsetof(fathom_material, base_color), offsetof(fathom_material, k_d), 3, true},
    [FATHOM_MAP_OPACITY] = {offsetof(fathom_material, opacity), offsetof(fathom_material, opacity), 1, true},
    [FATHOM_MAP_METALLIC] = {offsetof(fathom_material, metallic), NONE, 1, true},
    [FATHOM_MAP_ROUGHNESS] = {offsetof(fathom_material, roughness), NONE, 1, true},
    [FATHOM_MAP_EMISSIVE] = {offsetof(fathom_material, emissive), offsetof(fathom_material, k_e), 3, false},
    [FATHOM_MAP_NORMAL] = {NONE, NONE, 0, false},
    [FATHOM_MAP_TRANSMISSION] = {offsetof(fathom_material, transmission), NONE, 1, true},
    [FATHOM_MAP_SPECULAR] = {offsetof(fathom_material, specular_factor), NONE, 1, true},
    [FATHOM_MAP_SPECULAR_COLOR] = {offsetof(fathom_material, specular_color), offsetof(fathom_material, k_s),
                                   3, false},
    [FATHOM_MAP_CLEARCOAT] = {offsetof(fathom_material, clearcoat), NONE, 1, true},
    [FATHOM_MAP_CLEARCOAT_ROUGHNESS] = {offsetof(fathom_material, clearcoat_roughness), NONE, 1, true},
    [FATHOM_MAP_SHININESS] = {NONE, offsetof(fathom_material, shininess), 1, false},
    [FATHOM_MAP_SHEEN_COLOR] = {offsetof(fathom_material, sheen_color), NONE, 3, true},
    [FATHOM_MAP_SHEEN_ROUGHNESS] = {offsetof(fathom_material, sheen_roughness), NONE, 1, true},
    [FATHOM_MAP_ANISOTROPY] = {NONE, NONE, 0, false},
    [FATHOM_MAP_IRIDESCENCE] = {offsetof(fathom_material, iridescence), NONE, 1, true},
    [FATHOM_MAP_IRIDESCENCE_THICKNESS] = {NONE, NONE, 0, false},
    [FATHOM_MAP_DIFFUSE_TRANSMISSION] = {offsetof(fathom_material, diffuse_transmission), NONE, 1, true},
    [FATHOM_MAP_CLEARCOAT_NORMAL] = {NONE, NONE, 0, false},
    [FATHOM_MAP_BUMP] = {NONE, NONE, 0, false},
    [FATHOM_MAP_DIFFUSE_TRANSMISSION_COLOR] = {offsetof(fathom_material, diffuse_transmission_color), NONE, 3,
                                               true},
};

static size_t offset_of(const fathom_material *m, int kind) {
    return is_classic(m) ? members[kind].classic : members[kind].metallic;
}

static void multiply(float *to, int count, const float *factor, bool inverted, bool bounded) {
    for (int c = 0; c < count; ++c) {
        const float value = inverted ? 1 - (1 - to[c]) * factor[c] : to[c] * factor[c];
        const float positive = most(value, 0);
        to[c] = bounded ? least(positive, 1) : positive;
    }
}

void texturing_multiply(fathom_material *m, int kind, const float *factor, bool inverted) {
    const size_t offset = offset_of(m, kind);
    if (offset == NONE) return;
    multiply((float *)(void *)((char *)m + offset), members[kind].count, factor, inverted,
             members[kind].bounded);
}

void texturing_plan_parameters(material_plan *p) {
    static const float white[3] = {1, 1, 1};
    p->even = *p->material;
    for (int kind = 0; kind < FATHOM_MAPS; ++kind) {
        const fathom_map *map = &p->material->maps[kind];
        const size_t offset = offset_of(p->material, kind);
        if (p->of[kind] == NO_LOOKUP || offset == NONE) continue;
        p->parameters[p->parameter_count++] =
            (mapped_parameter){.offset = (uint16_t)offset,
                               .lookup = p->of[kind],
                               .count = (uint8_t)members[kind].count,
                               .channel = members[kind].count == 1 ? (uint8_t)map->channel : 0,
                               .inverted = map->inverted,
                               .bounded = members[kind].bounded};
    }
    if (p->of[FATHOM_MAP_COLOR] == NO_LOOKUP) texturing_multiply(&p->even, FATHOM_MAP_COLOR, white, false);
}

void texturing_dissolve(fathom_material *m) {
    const float left = m->opacity;
    float *const colours[] = {m->k_a, m->k_d, m->k_s, m->k_r, m->k_e};
    if (left >= 1) return;
    if (!rgb_any(m->k_t)) m->ior = 1, m->fresnel = false;
    for (int c = 0; c < 3; ++c) {
        for (size_t i = 0; i < sizeof colours / sizeof *colours; ++i) colours[i][c] *= left;
        m->k_t[c] = m->k_t[c] * left + (1 - left);
    }
}

/* Applies the images that do not just multiply one parameter. */
static void apply_others(const material_plan *p, const float (*values)[4], fathom_material *m) {
    const uint8_t way = p->of[FATHOM_MAP_ANISOTROPY], thickness = p->of[FATHOM_MAP_IRIDESCENCE_THICKNESS];
    if (way != NO_LOOKUP) {
        m->anisotropy *= least(most(values[way][2], 0), 1);
        m->anisotropy_rotation += atan2f(2 * values[way][1] - 1, 2 * values[way][0] - 1);
    }
    if (thickness != NO_LOOKUP) {
        const float *of = &values[thickness][p->material->maps[FATHOM_MAP_IRIDESCENCE_THICKNESS].channel];
        const float t = least(most(*of, 0), 1);
        m->iridescence_thickness_max =
            (1 - t) * m->iridescence_thickness_min + t * m->iridescence_thickness_max;
    }
}

void texturing_color(const material_plan *p, fathom_material *m, const float *color) {
    if (color) {
        texturing_multiply(m, material_only_emits(p->material) ? FATHOM_MAP_EMISSIVE : FATHOM_MAP_COLOR,
                           color, false);
        texturing_multiply(m, FATHOM_MAP_OPACITY, &color[3], false);
    }
    m->opacity = material_opacity(m), m->opacity_cutoff = 0;
}

void texturing_apply(const material_plan *p, const float (*values)[4], const float *color,
                     fathom_material *m) {
    *m = p->even;
    for (unsigned k = 0; k < p->parameter_count; ++k) {
        const mapped_parameter *at = &p->parameters[k];
        multiply((float *)(void *)((char *)m + at->offset), at->count, &values[at->lookup][at->channel],
                 at->inverted, at->bounded);
    }
    apply_others(p, values, m);
    texturing_color(p, m, color);
}
