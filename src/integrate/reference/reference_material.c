/* Scattering: the classic model of MODEL.md, and glTF's metallic-roughness (glTF 2.0, appendix B;
 * KHR_materials_ior, _specular, _transmission, _volume; others are in reference_layers.c and
 * reference_energy.c). n is the shading normal, on the viewer's side; v points to the viewer, l to the
 * direction from which light arrives, h is their half vector. */
#include "integrate/reference/reference_inner.h"

/* ---- what is implemented ---- */

bool reference_refracts(const fathom_material *m) {
    return m->model == FATHOM_MODEL_METALLIC_ROUGHNESS && m->transmission > 0 && m->thickness > 0;
}

bool reference_is_rough_glass(const fathom_material *m) {
    return reference_refracts(m) && m->ior != 1 && m->metallic < 1 && reference_alpha(m) > 0;
}

const char *reference_lacks(const fathom_material *m) {
    const float *s = m->specular_color;
    const bool plain = m->specular_factor == 1 && s[0] == 1 && s[1] == 1 && s[2] == 1;
    if (m->model == FATHOM_MODEL_CLASSIC) return NULL;
    if (m->transmission > 0 && (m->clearcoat > 0 || largest(color_of(m->sheen_color)) > 0))
        return "clearcoat or sheen_color with transmission";
    if (m->iridescence > 0 && (reference_refracts(m) || !plain))
        return "iridescence with refraction, specular_factor or specular_color";
    if (reference_refracts(m) && m->ior != 1 && !plain)
        return "specular_factor or specular_color with refraction";
    if (reference_refracts(m) && m->opacity < 1) return "opacity with refraction";
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

double reference_far_cosine(double cosine, double ratio) {
    const double square = 1 - (1 - cosine * cosine) / (ratio * ratio);
    return square > 0 ? sqrt(square) : -1;
}

vec3_f64 reference_mirrored(vec3_f64 v, vec3_f64 n) { return sub_f64(scale_f64(2 * dot_f64(n, v), n), v); }

/* The normal of smooth lobes: the geometric one if a mirrored direction would enter the surface. */
static vec3_f64 beam_normal(const reference_surface *s) {
    return dot_f64(reference_mirrored(s->to_viewer, s->normal), s->geometric) > 0 ? s->normal : s->geometric;
}

static vec3_f64 mirror_direction(const reference_surface *s) {
    return reference_mirrored(s->to_viewer, beam_normal(s));
}

vec3_f64 reference_refracted(vec3_f64 v, vec3_f64 n, double ratio) {
    const double near = dot_f64(n, v), far = fmax(reference_far_cosine(near, ratio), 0);
    return normalize_f64(madd_f64(scale_f64(near / ratio - far, n), -1 / ratio, v));
}

/* A direction that would return to the viewer's side is mirrored to the far side. */
static vec3_f64 refracted_direction(const reference_surface *s) {
    const vec3_f64 t = reference_refracted(s->to_viewer, beam_normal(s), s->turn);
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
    const double near = dot_f64(beam_normal(s), s->to_viewer), far = reference_far_cosine(near, s->ratio);
    const double share = far < 0 ? 1 : m->fresnel ? fresnel(near, far, s->ratio) : 0;
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
    if (nl < 0 && !m->lit_from_behind) return gray(0);
    switch (m->specular) {
    case FATHOM_SPECULAR_NONE: break;
    case FATHOM_SPECULAR_PHONG: base = dot_f64(s->to_viewer, reference_mirrored(l, s->normal)); break;
    case FATHOM_SPECULAR_BLINN: base = dot_f64(s->normal, normalize_f64(add_f64(l, s->to_viewer))); break;
    }
    const double highlight = m->specular && base > 0 ? pow(base, (double)m->shininess) : 0;
    return scale_f64(fabs(nl) / M_PI, madd_f64(color_of(m->k_d), highlight, color_of(m->k_s)));
}

/* ---- metallic-roughness ---- */

reference_reflectances reference_reflect(const fathom_material *m, double ior, double slant, double cosine) {
    const double weight = (double)m->specular_factor, mix = (double)m->iridescence;
    const double rise = pow(1 - fmin(fmax(slant, 0), 1), 5), metal_rise = pow(1 - fmin(cosine, 1), 5);
    const double root = (ior - 1) / (ior + 1);
    const vec3_f64 f0 = scale_f64(root * root, color_of(m->specular_color)), one = gray(1);
    const vec3_f64 f0_limited = {fmin(f0.x, 1), fmin(f0.y, 1), fmin(f0.z, 1)},
                   color = color_of(m->base_color);
    vec3_f64 dielectric = slant < 0 ? one : scale_f64(weight, blend(f0_limited, one, rise));
    vec3_f64 metal = blend(color, one, metal_rise);
    if (mix > 0) dielectric = blend(dielectric, reference_film(m, f0_limited, cosine), mix);
    if (mix > 0) metal = blend(metal, reference_film(m, color, cosine), mix);
    /* With `multiscatter`, each channel of a film keeps from the base what it reflects itself. */
    const bool each = mix > 0 && m->multiscatter;
    return (reference_reflectances){dielectric, metal,
                                    sub_f64(one, each ? dielectric : gray(largest(dielectric)))};
}

/* Refraction uses the cosine on the side of the smaller index, so that both directions of a path have the
 * same reflectance. The channel's own index decides on total reflection; at normal incidence all channels
 * reflect as with `ior`. */
static reference_reflectances reflect_of(const reference_surface *s, double cosine) {
    const bool refracts = reference_refracts(s->material);
    const double slant = refracts && s->turn < 1 ? reference_far_cosine(cosine, s->turn) : cosine;
    return reference_reflect(s->material, refracts ? s->ratio : (double)s->material->ior, slant, cosine);
}

/* The minimum alpha of facets. A surface with a smaller one is a mirror by definition. */
#define LEAST_ALPHA 0x1p-13

/* Anisotropic facets are never a mirror across the tangent: a smaller alpha is raised to the minimum. */
double reference_alpha(const fathom_material *m) {
    const double alpha = (double)m->roughness * (double)m->roughness;
    return alpha >= LEAST_ALPHA ? alpha : m->anisotropy > 0 ? LEAST_ALPHA : 0;
}

double reference_coat_alpha(const fathom_material *m) {
    const double alpha = (double)m->clearcoat_roughness * (double)m->clearcoat_roughness;
    return alpha >= LEAST_ALPHA ? alpha : 0;
}

double reference_alpha_along(const fathom_material *m) {
    const double across = reference_alpha(m), part = (double)m->anisotropy;
    return across + (1 - across) * part * part;
}

/* GGX's D G / (4 nl nv), with Smith's height-correlated G, for two alphas as in KHR_materials_anisotropy. l
 * may be on either side. */
static double lobe_of(const reference_surface *s, vec3_f64 h, vec3_f64 l, double along, double across) {
    const vec3_f64 t = s->along, b = cross_f64(s->normal, t), v = s->to_viewer;
    const double nl = fabs(dot_f64(s->normal, l)), nv = dot_f64(s->normal, v), nh = dot_f64(s->normal, h);
    if (!(across > 0 && nh > 0)) return 0;
    const double q = length_f64(vec_f64(dot_f64(h, t) / along, dot_f64(h, b) / across, nh));
    const double from_v = length_f64(vec_f64(along * dot_f64(v, t), across * dot_f64(v, b), nv));
    const double from_l = length_f64(vec_f64(along * dot_f64(l, t), across * dot_f64(l, b), nl));
    return 0.5 / (M_PI * along * across * pow(q, 4) * (nl * from_v + nv * from_l));
}

static double base_lobe(const reference_surface *s, vec3_f64 h, vec3_f64 l) {
    return lobe_of(s, h, l, reference_alpha_along(s->material), reference_alpha(s->material));
}

/* Transmitted light takes a single direction instead of being scattered. */
static bool passes_clear(const reference_surface *s) {
    return reference_alpha(s->material) == 0 || (reference_refracts(s->material) && s->ratio == 1);
}

/* ---- layers on top: a clear coat (index 1.5) over fibres over all else ---- */

static bool is_covered(const fathom_material *m) {
    return m->clearcoat > 0 || largest(color_of(m->sheen_color)) > 0;
}

static double coat_reflects(double cosine) { return 0.04 + 0.96 * pow(1 - fmin(cosine, 1), 5); }

/* The fraction of light that passes the layers, arriving from l and leaving to v. */
static double below_layers(const reference_surface *s, double nl, double nv, double *below_coat) {
    *below_coat = 1;
    if (!is_covered(s->material)) return 1;
    const double most = largest(color_of(s->material->sheen_color));
    const double all = fmax(reference_curve(s->albedos->sheen, nl), reference_curve(s->albedos->sheen, nv));
    *below_coat = (1 - reference_curve(s->albedos->coat, nl)) * (1 - reference_curve(s->albedos->coat, nv));
    return *below_coat * (1 - most * fmin(all, 1));
}

/* The reflection of the layers themselves: f without the cosine. */
static vec3_f64 layers_reflect(const reference_surface *s, vec3_f64 l, vec3_f64 h, double below_coat) {
    const fathom_material *m = s->material;
    if (!is_covered(m)) return gray(0);
    const double nl = dot_f64(s->normal, l), nv = dot_f64(s->normal, s->to_viewer);
    const double alpha = reference_coat_alpha(m);
    const double all = fmax(reference_curve(s->albedos->sheen, nl), reference_curve(s->albedos->sheen, nv));
    const double coat = (double)m->clearcoat * coat_reflects(dot_f64(h, l)) * lobe_of(s, h, l, alpha, alpha);
    const double fibres = reference_fibres(m, nl, nv, dot_f64(s->normal, h)) / fmax(all, 1);
    return madd_f64(gray(coat), below_coat * fibres, color_of(m->sheen_color));
}

/* ---- all of it ---- */

bool reference_is_pane(const fathom_material *m) {
    if (m->model == FATHOM_MODEL_CLASSIC) return m->ior == 1;
    return m->transmission > 0 && !(m->thickness > 0) && reference_alpha(m) == 0;
}

/* Facets at this cosine reflect this fraction of white light and, unless a beam carries it, transmit
 * *through. */
static double facets_send(const reference_surface *s, double cosine, double *through) {
    const fathom_material *m = s->material;
    const reference_reflectances f = reflect_of(s, cosine);
    *through = passes_clear(s) ? 0
                               : (1 - (double)m->metallic) * (double)m->transmission *
                                     largest(color_of(m->base_color)) * largest(f.base);
    return largest(blend(f.dielectric, f.metal, (double)m->metallic));
}

double reference_facets_pass(const reference_surface *s, double cosine) {
    double through;
    const double back = facets_send(s, cosine, &through);
    return through > 0 ? through / (back + through) : 0;
}

static reference_scatter metallic_scatter(const reference_surface *s) {
    const fathom_material *m = s->material;
    const vec3_f64 base = color_of(m->base_color), leaf = color_of(m->diffuse_transmission_color);
    const double metallic = (double)m->metallic, through = (1 - metallic) * (double)m->transmission;
    const double diffuse = 1 - metallic - through, behind = diffuse * (double)m->diffuse_transmission;
    const double nv = dot_f64(s->normal, s->to_viewer);
    const reference_reflectances f = reflect_of(s, nv);
    const bool smooth = reference_alpha(m) == 0, clear = passes_clear(s);
    double below_coat, passing;
    const double below = below_layers(s, nv, nv, &below_coat), reflecting = facets_send(s, nv, &passing);
    /* Rough glass scatters little light into other directions than its facets do, but more than once. */
    reference_scatter out = {
        .front = smooth && !is_covered(m) ? largest(base) * (diffuse - behind) : 0.5 - 0.3 * through,
        .back = (clear ? 0 : 0.1 * through * largest(base)) + behind * largest(leaf),
        .facets = smooth ? 0 : reflecting + passing,
        .coat = reference_coat_alpha(m) > 0 ? (double)m->clearcoat * coat_reflects(nv) : 0};
    if (m->clearcoat > 0 && reference_coat_alpha(m) == 0)
        add_beam(&out, mirror_direction(s), gray((double)m->clearcoat * coat_reflects(nv)));
    const vec3_f64 layer = scale_f64(reference_is_inside(s) ? (double)m->transmission : 1, f.dielectric);
    if (smooth) add_beam(&out, mirror_direction(s), scale_f64(below, blend(layer, f.metal, metallic)));
    if (clear)
        add_beam(&out, reference_refracts(m) ? refracted_direction(s) : neg_f64(s->to_viewer),
                 scale_f64(through, times(reference_passes(s, f.base), base)));
    return out;
}

/* Lambert's lobe on either side. */
static vec3_f64 diffuse_of(const fathom_material *m, bool behind, vec3_f64 base) {
    const double part = (double)m->diffuse_transmission;
    const vec3_f64 color = color_of(behind ? m->diffuse_transmission_color : m->base_color);
    return scale_f64((1 - (double)m->transmission) * (behind ? part : 1 - part) / M_PI, times(base, color));
}

static vec3_f64 metallic_reflect(const reference_surface *s, vec3_f64 l, vec3_f64 h) {
    const fathom_material *m = s->material;
    const reference_reflectances f = reflect_of(s, dot_f64(h, s->to_viewer));
    const double lobe = base_lobe(s, h, l), again = reference_again(s, l);
    const double glass = (1 - (double)m->metallic) * (double)m->transmission * reference_glass_again(s, l);
    const vec3_f64 diffuse = diffuse_of(m, false, reference_base(s, l, f.base));
    const double bare = reference_is_inside(s) ? (double)m->transmission : 1;
    const vec3_f64 plain =
        blend(madd_f64(diffuse, bare * lobe, f.dielectric), scale_f64(lobe, f.metal), (double)m->metallic);
    const vec3_f64 once = add_f64(plain, gray(glass));
    if (!(again > 0)) return once;
    return madd_f64(once, again, reference_is_inside(s) ? s->albedos->again_inside : s->albedos->again);
}

/* Thin walls: the reflected lobe, mirrored to the far side. Solids: Walter et al. 2007, equation 21, times
 * the squared ratio of indices (see reference.h). */
static double transmitted_lobe(const reference_surface *s, vec3_f64 l, vec3_f64 mirrored, double *cosine) {
    const double ratio = s->turn;
    vec3_f64 h = reference_refracts(s->material) ? scale_f64(ratio, l) : mirrored;
    h = normalize_f64(add_f64(s->to_viewer, h));
    if (dot_f64(h, s->normal) < 0) h = neg_f64(h);
    const double vh = dot_f64(h, s->to_viewer), lh = dot_f64(h, l), sum = vh + ratio * lh;
    const double lobe = base_lobe(s, h, l);
    *cosine = vh;
    if (!reference_refracts(s->material)) return lobe;
    return vh > 0 && lh < 0 ? 4 * vh * -lh * ratio * ratio * lobe / (sum * sum) : 0;
}

static vec3_f64 metallic_transmit(const reference_surface *s, vec3_f64 l) {
    const fathom_material *m = s->material;
    const vec3_f64 front = madd_f64(l, -2 * dot_f64(s->normal, l), s->normal);
    const vec3_f64 h = normalize_f64(add_f64(s->to_viewer, front));
    const double again = reference_refracts(m) ? 0 : reference_again(s, l) * (double)m->transmission;
    vec3_f64 sum = diffuse_of(m, true, reference_base(s, l, reflect_of(s, dot_f64(h, s->to_viewer)).base));
    if (again > 0)
        sum = madd_f64(sum, again, times(sub_f64(gray(1), s->albedos->again_base), color_of(m->base_color)));
    if (!passes_clear(s) && m->transmission > 0) {
        double cosine;
        const double lobe = transmitted_lobe(s, l, front, &cosine);
        const vec3_f64 both = madd_f64(gray(reference_glass_again(s, l)), lobe, reflect_of(s, cosine).base);
        sum = madd_f64(sum, (double)m->transmission, times(both, color_of(m->base_color)));
    }
    return scale_f64(1 - (double)m->metallic, sum);
}

static vec3_f64 metallic_evaluate(const reference_surface *s, vec3_f64 l) {
    const double nl = dot_f64(s->normal, l), nv = dot_f64(s->normal, s->to_viewer);
    const vec3_f64 h = normalize_f64(add_f64(s->to_viewer, l));
    double below_coat;
    const double below = below_layers(s, nl, nv, &below_coat);
    vec3_f64 sum = scale_f64(below, nl > 0 ? metallic_reflect(s, l, h) : metallic_transmit(s, l));
    if (nl > 0) sum = add_f64(sum, layers_reflect(s, l, h, below_coat));
    return scale_f64(fabs(nl), sum);
}

reference_scatter reference_scatter_of(const reference_surface *s) {
    return s->material->model == FATHOM_MODEL_CLASSIC ? classic_scatter(s) : metallic_scatter(s);
}

/* A direction on different sides of the two normals carries no light, except above the horizon of a lifted
 * point's shading normal. */
vec3_f64 reference_evaluate(const reference_surface *s, vec3_f64 l) {
    const double nl = dot_f64(s->normal, l), gl = dot_f64(s->geometric, l);
    if (!(nl * gl > 0 || (s->lifted && nl > 0))) return gray(0);
    return s->material->model == FATHOM_MODEL_CLASSIC ? classic_evaluate(s, l) : metallic_evaluate(s, l);
}
