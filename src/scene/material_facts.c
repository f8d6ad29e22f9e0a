/* Questions about single materials: scene.h. */
#include "math/rgb.h"
#include "scene/scene.h"

#include <math.h>

bool material_has_maps(const fathom_material *m) {
    for (int k = 0; k < FATHOM_MAPS; ++k) {
        if (m->maps[k].texture != FATHOM_NONE) return true;
    }
    return false;
}

bool material_map_is_color(int kind) {
    return kind == FATHOM_MAP_COLOR || kind == FATHOM_MAP_EMISSIVE || kind == FATHOM_MAP_SPECULAR_COLOR ||
           kind == FATHOM_MAP_SHEEN_COLOR || kind == FATHOM_MAP_DIFFUSE_TRANSMISSION_COLOR;
}

bool material_is_directed(const fathom_material *m) {
    return m->model == FATHOM_MODEL_METALLIC_ROUGHNESS && m->anisotropy > 0;
}

/* Such maps change neither how much light passes nor how much it is scattered. */
static bool is_map_aside(int map) {
    return map == FATHOM_MAP_NORMAL || map == FATHOM_MAP_CLEARCOAT_NORMAL || map == FATHOM_MAP_BUMP ||
           map == FATHOM_MAP_EMISSIVE;
}

/* The fraction of light that absorption leaves. */
static float left_of(const fathom_material *m, int c) {
    if (!(m->thickness > 0 && m->attenuation_distance > 0)) return 1;
    return powf(m->attenuation_color[c], m->thickness / m->attenuation_distance);
}

/* The largest roughness of clear materials. Path tracing: lobes of rougher ones bring the light of lamps, too
 * (SHADER_SMOOTH_ALPHA). */
#define CLEAR_ROUGHNESS 0.011f
#define CLEAR_ROUGHNESS_CLASSIC 0.15f

bool material_is_clear(const scene_named_material *material, fathom_integrator integrator) {
    const fathom_material *m = &material->value;
    const bool metallic_roughness = m->model == FATHOM_MODEL_METALLIC_ROUGHNESS,
               classic = integrator == FATHOM_INTEGRATOR_CLASSIC;
    float through = 0;
    for (int k = 0; k < FATHOM_MAPS; ++k) {
        if (m->maps[k].texture != FATHOM_NONE && !is_map_aside(k)) return false;
    }
    if (metallic_roughness && material_opacity(m) == 0) return true;
    if (metallic_roughness && m->roughness >= (classic ? CLEAR_ROUGHNESS_CLASSIC : CLEAR_ROUGHNESS))
        return false;
    if (metallic_roughness && !classic && (!(m->thickness > 0) || material_is_directed(m))) return false;
    for (int c = 0; c < 3; ++c) {
        const float sent = (1 - m->metallic) * m->transmission * m->base_color[c];
        through += (metallic_roughness ? sent : material->classic.k_t[c]) * left_of(m, c);
    }
    return through > 1.5f;
}

bool material_only_emits(const fathom_material *m) {
    if (m->model == FATHOM_MODEL_CLASSIC)
        return !rgb_any(m->k_d) && !rgb_any(m->k_s) && !rgb_any(m->k_r) && !rgb_any(m->k_t);
    return !rgb_any(m->base_color) && m->metallic == 0 && m->specular_factor == 0 && m->transmission == 0 &&
           m->diffuse_transmission == 0 && m->clearcoat == 0 && !rgb_any(m->sheen_color) &&
           m->iridescence == 0;
}

bool material_is_one_sided(const fathom_material *m) {
    const bool bounds = m->thickness > 0 && (m->transmission > 0 || m->diffuse_transmission > 0);
    return m->model == FATHOM_MODEL_METALLIC_ROUGHNESS && !m->double_sided && !bounds;
}

float material_opacity(const fathom_material *m) {
    return m->opacity_cutoff > 0 ? (m->opacity >= m->opacity_cutoff ? 1.0f : 0.0f) : m->opacity;
}

bool material_is_pane(const fathom_material *m) {
    if (m->model == FATHOM_MODEL_CLASSIC) return m->ior == 1;
    return m->transmission > 0 && !(m->thickness > 0);
}

bool material_may_pass(const fathom_material *m) {
    fathom_material between;
    mapped_between(m, &between);
    return material_is_pane(&between) || m->opacity < 1 || m->maps[FATHOM_MAP_OPACITY].texture != FATHOM_NONE;
}
