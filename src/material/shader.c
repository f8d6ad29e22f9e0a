#include "material/shader.h"

#include "base/kernel.h"
#include "math/limit.h"

#include <math.h>
#include <string.h>

static bool any(const float rgb[3]) { return rgb[0] > 0 || rgb[1] > 0 || rgb[2] > 0; }

static float largest(const float rgb[3]) { return fmaxf(rgb[0], fmaxf(rgb[1], rgb[2])); }

/* ---- the classic model ---- */

/* The lectures' L k_d |n·l| is the radiance under the irradiance pi L |n·l|: so f = rho / pi, of the diffuse
 * and the specular part alike. Ambient light and k_a are the classic integrator's. */
static void prepare_classic(const fathom_material *m, shader *out) {
    const bool shiny = m->specular != FATHOM_SPECULAR_NONE && any(m->k_s);
    const bool phong = m->specular == FATHOM_SPECULAR_PHONG;
    const float spread = phong ? 2 / (m->shininess + 2) : 8 / (m->shininess + 8);
    for (int c = 0; c < 3; ++c) {
        out->diffuse[c] = m->k_d[c];
        out->highlight[c] = shiny ? m->k_s[c] : 0;
        out->k_r[c] = m->k_r[c], out->k_t[c] = m->k_t[c];
        out->emission[c] = limited(m->k_e[c]);
        out->albedo[c] = fminf(m->k_d[c] + out->highlight[c] * spread + m->k_r[c] + m->k_t[c], 1);
    }
    out->shininess = m->shininess;
    out->ior = m->ior;
    out->phong = shiny && phong ? ~0u : 0;
    out->blinn = shiny && !phong ? ~0u : 0;
    out->fresnel = m->fresnel ? ~0u : 0;
    out->from_behind = m->lit_from_behind ? ~0u : 0;
    out->transmits = m->lit_from_behind || any(m->k_t);
    out->lobes = (any(m->k_d) ? SHADER_DIFFUSE : 0u) | (shiny ? SHADER_HIGHLIGHT : 0u) |
                 (any(m->k_r) || any(m->k_t) ? SHADER_CLASSIC : 0u);
}

/* ---- metallic-roughness ---- */

/* Schlick's reflectance of a mixture is the mixture of reflectances: F0 and F90 of dielectric and metal are
 * mixed once. Where they stay apart is the base under the dielectric: it gets 1 - F, of the largest channel
 * (KHR_materials_specular). */
static void prepare_metallic(const fathom_material *m, shader *out) {
    const float ratio = (m->ior - 1) / (m->ior + 1), metal = m->metallic;
    float layer[3], f0[3], f90 = (1 - metal) * m->specular_factor + metal;
    for (int c = 0; c < 3; ++c) {
        layer[c] = m->specular_factor * fminf(ratio * ratio * m->specular_color[c], 1);
        f0[c] = (1 - metal) * layer[c] + metal * m->base_color[c];
        out->diffuse[c] = (1 - metal) * m->base_color[c];
        out->emission[c] = limited(m->emissive_strength * m->emissive[c]);
    }
    out->layer0 = largest(layer);
    out->layer90 = m->specular_factor;
    for (int c = 0; c < 3; ++c) out->albedo[c] = fminf(f0[c] + out->diffuse[c] * (1 - out->layer0), 1);
    const float alpha = m->roughness * m->roughness;
    const bool shiny = f90 > 0 || any(f0), smooth = alpha < SHADER_SMOOTH_ALPHA;
    memcpy(smooth ? out->mirror0 : out->f0, f0, sizeof f0);
    *(smooth ? &out->mirror90 : &out->f90) = f90;
    out->alpha = smooth ? SHADER_SMOOTH_ALPHA : alpha;
    out->lobes = (any(out->diffuse) ? SHADER_DIFFUSE : 0u) | (out->layer90 > 0 ? SHADER_LAYER : 0u) |
                 (shiny && !smooth ? SHADER_GGX : 0u) | (shiny && smooth ? SHADER_MIRROR : 0u);
    out->opacity = m->opacity;
}

void shader_prepare(const fathom_material *m, shader *out) {
    *out = (shader){.model = m->model, .opacity = 1, .alpha = 1, .ior = 1};
    switch (m->model) {
    case FATHOM_MODEL_CLASSIC: prepare_classic(m, out); break;
    case FATHOM_MODEL_METALLIC_ROUGHNESS: prepare_metallic(m, out); break;
    }
}

KERNEL_CHOICE(shader_kernels)
