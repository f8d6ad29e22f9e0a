#include "material/plain.h"

#include "base/kernel.h"
#include "math/limit.h"

KERNEL_BEST(plain_kernels)

static bool any(const float rgb[3]) { return (rgb[0] > 0) | (rgb[1] > 0) | (rgb[2] > 0); }

static bool is_plain(const fathom_material *m) {
    return m->model == FATHOM_MODEL_METALLIC_ROUGHNESS && m->multiscatter && material_opacity(m) >= 1 &&
           !(m->transmission > 0) & !(m->clearcoat > 0) & !any(m->sheen_color) & !(m->anisotropy > 0) &
               !(m->iridescence > 0) & !(m->diffuse_transmission > 0);
}

bool plain_add(plain_block *b, unsigned i, const fathom_material *m, shader *out) {
    if (!is_plain(m)) return false;
    b->lanes |= 1u << i;
    for (int c = 0; c < 3; ++c)
        b->base_color[c][i] = m->base_color[c], b->specular_color[c][i] = m->specular_color[c];
    b->metallic[i] = m->metallic, b->alpha[i] = m->roughness * m->roughness;
    b->ior[i] = m->ior, b->specular[i] = m->specular_factor;
    shader_begin(m, out);
    out->facets = energy_curve_of(b->alpha[i]);
    energy_means(&out->facets, &b->mean[i], &b->mean_edge[i]);
    out->alpha = most(b->alpha[i], SHADER_SMOOTH_ALPHA), out->along = b->alpha[i];
    out->layer90 = m->specular_factor;
    out->ior = m->ior, out->priority = m->priority;
    return true;
}

void plain_finish(const plain_block *b, const plain_kernels *kernels, shader made[LANES]) {
    plain_shaders p;
    if (!b->lanes) return;
    kernels->prepare(b, &p);
    for (uint32_t left = b->lanes; left; left &= left - 1) {
        const unsigned i = (unsigned)__builtin_ctz(left);
        shader *out = &made[i];
        const bool smooth = p.lobes[i] & SHADER_MIRROR;
        float *const f0 = smooth ? out->mirror0 : out->f0;
        for (int c = 0; c < 3; ++c) {
            out->diffuse[c] = p.diffuse[c][i], out->albedo[c] = p.albedo[c][i];
            out->again[c] = p.again[c][i], f0[c] = p.f0[c][i];
        }
        *(smooth ? &out->mirror90 : &out->f90) = p.f90[i];
        out->layer0 = p.layer0[i], out->layer_again = p.layer_again[i];
        out->mean_under = p.mean_under[i], out->missing_share = p.missing_share[i];
        out->lobes = p.lobes[i];
        if (out->lobes & SHADER_EVEN)
            out->even = ~0u;
        else
            out->facets = energy_none;
    }
}
