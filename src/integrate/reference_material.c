/* Scattering: the classic model of MODEL.md, and glTF's metallic-roughness (glTF 2.0, appendix B;
 * KHR_materials_ior, _specular, _transmission and _volume). n is the shading normal, on the viewer's side; v
 * points to the viewer, l to where light arrives from, h halves them. */
#include "integrate/reference_inner.h"

/* ---- what is implemented ---- */

bool reference_refracts(const fathom_material *m) {
    return m->model == FATHOM_MODEL_METALLIC_ROUGHNESS && m->transmission > 0 && m->thickness > 0;
}

const char *reference_lacks(const fathom_material *m) {
    const float *s = m->specular_color;
    const bool plain = m->specular_factor == 1 && s[0] == 1 && s[1] == 1 && s[2] == 1;
    if (m->model == FATHOM_MODEL_CLASSIC) return NULL;
    if (m->clearcoat > 0) return "clearcoat";
    if (largest(color_of(m->sheen_color)) > 0) return "sheen_color";
    if (m->anisotropy > 0) return "anisotropy";
    if (m->iridescence > 0) return "iridescence";
    if (m->diffuse_transmission > 0) return "diffuse_transmission";
    if (reference_refracts(m) && m->dispersion > 0) return "dispersion";
    if (reference_refracts(m) && m->priority > 0) return "priority";
    if (m->multiscatter && m->roughness > 0 &&
        (m->metallic > 0 || m->specular_factor > 0 || m->transmission > 0))
        return "multiscatter";
    if (reference_refracts(m) && m->ior != 1 && !plain)
        return "specular_factor or specular_color with refraction";
    return NULL;
}

/* ---- volumes and emission ---- */

vec3_f64 reference_absorbed(const fathom_material *m, double distance) {
    const vec3_f64 c = color_of(m->attenuation_color);
    const double way = (double)m->attenuation_distance, part = way > 0 ? distance / way : 0;
    return vec_f64(pow(c.x, part), pow(c.y, part), pow(c.z, part));
}

vec3_f64 reference_emission(const fathom_material *m) {
    if (m->model == FATHOM_MODEL_CLASSIC) return color_of(m->k_e);
    return scale_f64((double)m->emissive_strength, color_of(m->emissive));
}

/* ---- mirrors and refraction ---- */

/* The index of the far side over that of the viewer's. */
static double ratio_of(const reference_surface *s) {
    return s->behind ? 1 / (double)s->material->ior : (double)s->material->ior;
}

/* The cosine on the far side by Snell's law; negative: total internal reflection. */
static double far_cosine(double cosine, double ratio) {
    const double square = 1 - (1 - cosine * cosine) / (ratio * ratio);
    return square > 0 ? sqrt(square) : -1;
}

static vec3_f64 mirrored(vec3_f64 v, vec3_f64 n) { return sub_f64(scale_f64(2 * dot_f64(n, v), n), v); }

/* The normal of smooth lobes: the geometric one where a mirrored direction would enter the surface. */
static vec3_f64 beam_normal(const reference_surface *s) {
    return dot_f64(mirrored(s->to_viewer, s->normal), s->geometric) > 0 ? s->normal : s->geometric;
}

static vec3_f64 mirror_direction(const reference_surface *s) {
    return mirrored(s->to_viewer, beam_normal(s));
}

static vec3_f64 refracted(vec3_f64 v, vec3_f64 n, double ratio) {
    const double near = dot_f64(n, v), far = fmax(far_cosine(near, ratio), 0);
    return normalize_f64(madd_f64(scale_f64(near / ratio - far, n), -1 / ratio, v));
}

/* A direction that would come back out is turned to the far side. */
static vec3_f64 refracted_direction(const reference_surface *s) {
    const vec3_f64 t = refracted(s->to_viewer, beam_normal(s), ratio_of(s));
    return madd_f64(t, -2 * fmax(dot_f64(t, s->geometric), 0), s->geometric);
}

static void add_beam(reference_scatter *out, vec3_f64 direction, vec3_f64 weight) {
    if (largest(weight) > 0) out->beam[out->beams++] = (reference_beam){direction, weight};
}

/* ---- the classic model ---- */

/* Fresnel's equations for unpolarized light: the mean of both squared amplitudes. */
static double fresnel(double near, double far, double ratio) {
    const double across = (near - ratio * far) / (near + ratio * far);
    const double parallel = (ratio * near - far) / (ratio * near + far);
    return (across * across + parallel * parallel) / 2;
}

static reference_scatter classic_scatter(const reference_surface *s) {
    const fathom_material *m = s->material;
    const vec3_f64 k_r = color_of(m->k_r), k_t = color_of(m->k_t);
    const double near = dot_f64(beam_normal(s), s->to_viewer), far = far_cosine(near, ratio_of(s));
    const double share = far < 0 ? 1 : m->fresnel ? fresnel(near, far, ratio_of(s)) : 0;
    const double rough = largest(color_of(m->k_d)) + (m->specular ? largest(color_of(m->k_s)) : 0);
    reference_scatter out = {.front = rough, .back = m->lit_from_behind ? rough : 0};
    add_beam(&out, mirror_direction(s), m->fresnel ? scale_f64(share, k_r) : madd_f64(k_r, share, k_t));
    if (far >= 0) add_beam(&out, refracted_direction(s), scale_f64(1 - share, k_t));
    return out;
}

static vec3_f64 classic_evaluate(const reference_surface *s, vec3_f64 l) {
    const fathom_material *m = s->material;
    const double nl = dot_f64(s->normal, l);
    double base = 0;
    if (!(nl * dot_f64(s->geometric, l) > 0) || (nl < 0 && !m->lit_from_behind)) return gray(0);
    switch (m->specular) {
    case FATHOM_SPECULAR_NONE: break;
    case FATHOM_SPECULAR_PHONG: base = dot_f64(s->to_viewer, mirrored(l, s->normal)); break;
    case FATHOM_SPECULAR_BLINN: base = dot_f64(s->normal, normalize_f64(add_f64(l, s->to_viewer))); break;
    }
    const double highlight = m->specular ? pow(fmax(base, 0), (double)m->shininess) : 0;
    return scale_f64(fabs(nl) / PI, madd_f64(color_of(m->k_d), highlight, color_of(m->k_s)));
}

/* ---- metallic-roughness ---- */

typedef struct reflectances {
    vec3_f64 dielectric, metal;
    double base; /* of the dielectric: what the reflection leaves to the base under it */
} reflectances;

/* Schlick's, for the cosine between v and h. Refraction takes the cosine on the side of the smaller index, so
 * that both ways of a path reflect alike. */
static reflectances reflect_of(const reference_surface *s, double cosine) {
    const fathom_material *m = s->material;
    const double root = ((double)m->ior - 1) / ((double)m->ior + 1), weight = (double)m->specular_factor;
    const double slant = reference_refracts(m) && ratio_of(s) < 1 ? far_cosine(cosine, ratio_of(s)) : cosine;
    const double rise = pow(1 - fmin(fmax(slant, 0), 1), 5), metal_rise = pow(1 - fmin(cosine, 1), 5);
    const vec3_f64 f0 = scale_f64(root * root, color_of(m->specular_color)), one = gray(1);
    const vec3_f64 f0_limited = {fmin(f0.x, 1), fmin(f0.y, 1), fmin(f0.z, 1)};
    const vec3_f64 dielectric = slant < 0 ? one : scale_f64(weight, blend(f0_limited, one, rise));
    return (reflectances){dielectric, blend(color_of(m->base_color), one, metal_rise),
                          1 - largest(dielectric)};
}

static double alpha_of(const fathom_material *m) { return (double)m->roughness * (double)m->roughness; }

/* GGX's D times G over 4 nl nv, with Smith's height-correlated G. Both cosines are positive. */
static double lobe_of(double nh, double nl, double nv, double alpha) {
    const double a2 = alpha * alpha, q = nh * nh * (a2 - 1) + 1;
    if (!(alpha > 0 && nh > 0)) return 0;
    return a2 / (PI * q * q) * 0.5 /
           (nl * sqrt(nv * nv * (1 - a2) + a2) + nv * sqrt(nl * nl * (1 - a2) + a2));
}

/* Light passes by one direction instead of being scattered. */
static bool passes_clear(const fathom_material *m) {
    return alpha_of(m) == 0 || (reference_refracts(m) && m->ior == 1);
}

static reference_scatter metallic_scatter(const reference_surface *s) {
    const fathom_material *m = s->material;
    const vec3_f64 base = color_of(m->base_color);
    const double metallic = (double)m->metallic, through = (1 - metallic) * (double)m->transmission;
    const reflectances f = reflect_of(s, dot_f64(s->normal, s->to_viewer));
    const bool smooth = alpha_of(m) == 0, clear = passes_clear(m);
    reference_scatter out = {.front =
                                 smooth ? largest(base) * (1 - metallic) * (1 - (double)m->transmission) : 1,
                             .back = clear ? 0 : through * largest(base)};
    if (smooth) add_beam(&out, mirror_direction(s), blend(f.dielectric, f.metal, metallic));
    if (clear)
        add_beam(&out, reference_refracts(m) ? refracted_direction(s) : neg_f64(s->to_viewer),
                 scale_f64(through * f.base, base));
    return out;
}

static vec3_f64 metallic_reflect(const reference_surface *s, vec3_f64 l) {
    const fathom_material *m = s->material;
    const double nl = dot_f64(s->normal, l), nv = dot_f64(s->normal, s->to_viewer);
    const vec3_f64 h = normalize_f64(add_f64(s->to_viewer, l));
    const reflectances f = reflect_of(s, dot_f64(h, s->to_viewer));
    const double lobe = lobe_of(dot_f64(s->normal, h), nl, nv, alpha_of(m));
    const vec3_f64 base = scale_f64((1 - (double)m->transmission) * f.base / PI, color_of(m->base_color));
    const vec3_f64 dielectric = madd_f64(base, lobe, f.dielectric), metal = scale_f64(lobe, f.metal);
    return scale_f64(nl, blend(dielectric, metal, (double)m->metallic));
}

/* Thin walls: the reflected lobe, mirrored to the far side. Others: Walter et al. 2007, equation 21, times
 * the squared ratio of indices (see reference.h). */
static double transmitted_lobe(const reference_surface *s, vec3_f64 l, double *cosine) {
    const bool thin = !reference_refracts(s->material);
    const double nl = -dot_f64(s->normal, l), nv = dot_f64(s->normal, s->to_viewer), ratio = ratio_of(s);
    vec3_f64 h = thin ? madd_f64(l, 2 * nl, s->normal) : scale_f64(ratio, l);
    h = normalize_f64(add_f64(s->to_viewer, h));
    if (dot_f64(h, s->normal) < 0) h = neg_f64(h);
    const double vh = dot_f64(h, s->to_viewer), lh = dot_f64(h, l), sum = vh + ratio * lh;
    const double lobe = lobe_of(dot_f64(s->normal, h), nl, nv, alpha_of(s->material));
    *cosine = vh;
    if (thin) return lobe;
    return vh > 0 && lh < 0 ? 4 * vh * -lh * ratio * ratio * lobe / (sum * sum) : 0;
}

static vec3_f64 metallic_transmit(const reference_surface *s, vec3_f64 l) {
    const fathom_material *m = s->material;
    if (passes_clear(m) || !(m->transmission > 0)) return gray(0);
    double cosine;
    const double lobe = transmitted_lobe(s, l, &cosine);
    const double share = (1 - (double)m->metallic) * (double)m->transmission * reflect_of(s, cosine).base;
    return scale_f64(share * lobe * fabs(dot_f64(s->normal, l)), color_of(m->base_color));
}

reference_scatter reference_scatter_of(const reference_surface *s) {
    return s->material->model == FATHOM_MODEL_CLASSIC ? classic_scatter(s) : metallic_scatter(s);
}

/* A direction on different sides of the two normals carries nothing. */
vec3_f64 reference_evaluate(const reference_surface *s, vec3_f64 l) {
    const double nl = dot_f64(s->normal, l), gl = dot_f64(s->geometric, l);
    if (s->material->model == FATHOM_MODEL_CLASSIC) return classic_evaluate(s, l);
    if (nl > 0 && gl > 0) return metallic_reflect(s, l);
    return nl < 0 && gl < 0 ? metallic_transmit(s, l) : gray(0);
}
