/* Conversion of metallic-roughness to the classic model. The former is a microfacet model: a dielectric layer
 * over a diffuse base, mixed with a metal. The classic model has Lambert, a Blinn highlight, a mirror and
 * refraction. Let m = metallic, b = base colour, r = roughness, alpha = r^2, T = transmission, f0 =
 * ((ior - 1) / (ior + 1))^2 tinted by KHR_materials_specular, and F0 = (1 - m) f0 + m b:
 *
 * - k_d = (1 - m) (1 - T) (1 - f0) (1 - D) b: light that the layer reflects does not reach the base, and its
 *   diffuse transmission D leaves on the other side. With D, as much light comes from behind. The format's
 *   BRDF is b / pi. The classic one has no factor 1 / pi; the lights contain it (see gltf_light.c).
 * - n = 2 / alpha^2 - 2, in [1, 1e6]: Blinn's exponent whose lobe is as wide as the format's. The variance of
 *   its slopes is 2 / (n + 2), that of a Beckmann lobe is alpha^2.
 * - k_s = F0 N(n), N(n) = (n + 2)(n + 4) / (8 (2^(-n/2) + n)): the lobe reflects F0 of the light at normal
 *   incidence, because its integral with the cosine is pi / N(n). It is limited, with the same hue, so that
 *   k_d + k_s <= 1 in every channel: small bright lobes stay displayable.
 * - k_r = w F0, w = t^2 / (alpha^2 + t^2), t = tan(3 degrees): the fraction of GGX microfacets tilted by less
 *   than 3 degrees. This part of the reflection is blurred so little that a mirror can represent it. If w
 *   would be below 0.05 (r > 0.48), it is 0. A dielectric (m < 1/2) has k_r = w times the specular factor and
 *   colour, and `fresnel`, whose reflectance rises from f0; metals keep their colour instead.
 * - k_t = (1 - m) T b, refracted by ior, with Fresnel (without `fresnel`: times 1 - f0). It is not blurred,
 *   whatever r is. The format's transmission without a volume is a thin wall; here the mesh counts as a
 *   solid.
 * - k_a = k_d + (1 - w) F0: the rough part reflects light from all directions; the mirror traces its own.
 *
 * Mirrored rays never hit lights, so k_s (for lights) and k_r (for everything else) share F0, and no light is
 * counted twice: a surface passes on k_d + max(k_s / N, k_r F) + k_t (1 - F) <= 1 in all.
 *
 * - cover: scales all of the above. k_t gets the remainder, with ior 1, so this light passes without
 *   refraction. With T > 0 the ior of the refraction is kept.
 * - emission: k_e = its colour times its strength.
 * - ior 0: f0 is the specular colour, and there is no refraction. Older workflows are converted this way. */

#include "scene/scene.h"

#include <math.h>

static double mirror_share(double alpha) {
    const double tangent = 0.052407779283041196; /* tan(3 degrees) */
    double w = tangent * tangent / (alpha * alpha + tangent * tangent);
    return w < 0.05 ? 0 : w;
}

static double exponent_of(double alpha) {
    /* alpha = 0 gives infinity, which fmin() limits. */
    return fmin(fmax(2 / (alpha * alpha) - 2, 1), 1e6);
}

static double lobe_norm(double n) { return (n + 2) * (n + 4) / (8 * (exp2(-n / 2) + n)); }

void metallic_to_classic(const fathom_material *f, fathom_material *out) {
    const double m = (double)f->metallic, alpha = (double)f->roughness * (double)f->roughness,
                 ior = (double)f->ior, transmission = (double)f->transmission,
                 cover = (double)material_opacity(f);
    const double ratio = ior > 0 ? (ior - 1) / (ior + 1) : 1, w = mirror_share(alpha), n = exponent_of(alpha);
    const bool refracts = cover > 0 && transmission > 0 && ior > 0 && m < 1,
               straight = cover < 1 && !refracts;
    double scale = lobe_norm(n), f0[3];
    fathom_material_default(out);
    out->fresnel = ior > 0 && m < 0.5 && !straight;
    out->lit_from_behind = f->diffuse_transmission > 0;
    for (int i = 0; i < 3; ++i) {
        const double specular = (double)f->specular_factor, tint = (double)f->specular_color[i],
                     b = (double)f->base_color[i], layer = specular * fmin(ratio * ratio * tint, 1),
                     diffuse = (1 - m) * (1 - transmission) * (1 - layer) *
                               (1 - (double)f->diffuse_transmission) * b;
        f0[i] = (1 - m) * layer + m * b;
        if (f0[i] > 0) scale = fmin(scale, (1 - diffuse) / f0[i]);
        const double mirror = out->fresnel ? fmin(specular * tint, 1) : f0[i];
        const double inward = out->fresnel ? 1 : 1 - layer;
        out->k_r[i] = (float)(cover * w * mirror);
        out->k_t[i] = (float)(cover * (1 - m) * transmission * inward * b + 1 - cover);
        out->k_d[i] = (float)(cover * diffuse);
        out->k_a[i] = (float)(cover * (diffuse + (1 - w) * f0[i]));
        out->k_e[i] = (float)fmin(cover * (double)f->emissive_strength * (double)f->emissive[i], 1e30);
    }
    for (int i = 0; i < 3; ++i) {
        out->k_s[i] = (float)(cover * scale * f0[i]);
        if (out->k_s[i] > 0) out->specular = FATHOM_SPECULAR_BLINN;
    }
    out->shininess = (float)n;
    out->ior = straight || !(ior > 0) ? 1 : (float)ior;
}
