/* Shaders of plain materials; the formulas are those of prepare_metallic() in shader.c. */
#include "material/plain.h"

#include "base/kernel.h"
#include "material/mixture.h"

static void mix(const plain_block *b, plain_shaders *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        const float metal = b->metallic[i], base = 1 - metal, specular = b->specular[i];
        float layer[3], most_layer = 0, diffuse[3];
        for (int c = 0; c < 3; ++c) {
            layer[c] = mixture_layer(b->ior[i], specular, b->specular_color[c][i]);
            diffuse[c] = base * b->base_color[c][i];
            most_layer = most(most_layer, layer[c]);
        }
        for (int c = 0; c < 3; ++c) {
            const float f0 = mixed(layer[c], b->base_color[c][i], metal);
            out->f0[c][i] = f0, out->diffuse[c][i] = diffuse[c];
            out->albedo[c][i] = least(f0 + diffuse[c] * (1 - most_layer), 1);
        }
        out->layer0[i] = most_layer;
        out->f90[i] = mixed(specular, 1, metal);
    }
}

static void name_lobes(const plain_block *b, plain_shaders *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        const uint32_t lit = (out->diffuse[0][i] > 0) | (out->diffuse[1][i] > 0) | (out->diffuse[2][i] > 0);
        const uint32_t shiny =
            (out->f90[i] > 0) | (out->f0[0][i] > 0) | (out->f0[1][i] > 0) | (out->f0[2][i] > 0);
        const uint32_t smooth = b->alpha[i] < SHADER_SMOOTH_ALPHA ? SHADER_MIRROR : SHADER_GGX;
        const uint32_t layer = b->specular[i] > 0 ? SHADER_LAYER : 0;
        const uint32_t facets = layer | (shiny ? smooth : 0);
        out->lobes[i] = (lit ? SHADER_DIFFUSE : 0) | (facets || !lit ? facets | SHADER_EVEN : 0);
    }
}

/* Compensation for light that scatters more than once; Lambert's lobe alone needs none. */
static void give_back(const plain_block *b, plain_shaders *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        const uint32_t even = out->lobes[i] & SHADER_EVEN ? ~0u : 0;
        const float mean = b->mean[i], specular = b->specular[i], metal = b->metallic[i];
        const float again = mixture_again(out->layer0[i], specular, mean), scale = mixture_scale(1 - mean);
        const float under = mixture_under(out->layer0[i], specular, again, mean, b->mean_edge[i]);
        float share = 0;
        for (int c = 0; c < 3; ++c) {
            const float layer = mixture_layer(b->ior[i], specular, b->specular_color[c][i]);
            const float q = mixed(mixture_again(layer, specular, mean),
                                  mixture_again(b->base_color[c][i], 1, mean), metal);
            out->again[c][i] = chosen(even, q * scale, 0), share += q * (1 / 3.0f);
            out->diffuse[c][i] = chosen(even, mixture_lifted(out->diffuse[c][i], under), out->diffuse[c][i]);
        }
        out->layer_again[i] = chosen(even, again, 0), out->mean_under[i] = chosen(even, under, 1);
        out->missing_share[i] = chosen(even, share, 0);
    }
}

static void prepare(const plain_block *b, plain_shaders *out) {
    mix(b, out);
    name_lobes(b, out);
    give_back(b, out);
}

extern const plain_kernels KERNEL(plain_kernels);
const plain_kernels KERNEL(plain_kernels) = {prepare};
