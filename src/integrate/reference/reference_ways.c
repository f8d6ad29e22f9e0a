/* Random directions of the reference's paths: by the cosine on either side, by half vectors of rough facets,
 * towards a lamp or towards the light of a sky. Several strategies may sample the same direction, so its
 * density is the sum of theirs (Veach 1997, one-sample model): a direction that any strategy samples often
 * never has a small density. */
#include "integrate/reference/reference_inner.h"
#include "math/frame.h"

vec3_f64 reference_around(vec3_f64 axis, double cosine, reference_random *random) {
    const frame_f64 f = frame_from((vec3_f64){0, 0, 0}, axis, (vec3_f64){0, 0, 0});
    const double angle = 2 * M_PI * reference_uniform(random), sine = sqrt(fmax(1 - cosine * cosine, 0));
    const vec3_f64 flat = madd_f64(scale_f64(sine * cos(angle), f.x), sine * sin(angle), f.y);
    return normalize_f64(madd_f64(flat, cosine, f.z));
}

enum { FRONT, BACK, FACETS, COAT, LAMPS, SKY, WAYS };

/* The fraction of all directions that go to lamps if there are any, and of the remaining ones to images of
 * skies. */
#define TO_LAMPS 0.4
#define TO_SKY 0.4

static void share_out(const reference_scene *r, const reference_scatter *all, double shares[WAYS]) {
    const double parts[WAYS] = {all->front, all->back, all->facets, all->coat, 0, 0};
    const double lamps = r->lamps.count ? TO_LAMPS : 0, sky = r->sky_count ? (1 - lamps) * TO_SKY : 0;
    double sum = 0;
    for (int k = 0; k < WAYS; ++k) sum += parts[k];
    for (int k = 0; k < WAYS; ++k) shares[k] = sum > 0 ? (1 - lamps - sky) * parts[k] / sum : 0;
    shares[LAMPS] = sum > 0 ? lamps : 0, shares[SKY] = sum > 0 ? sky : 0;
}

/* ---- facets ---- */

typedef struct alphas {
    double along, across;
} alphas;

static alphas alphas_of(const fathom_material *m, bool coat) {
    const double on_top = reference_coat_alpha(m);
    return coat ? (alphas){on_top, on_top} : (alphas){reference_alpha_along(m), reference_alpha(m)};
}

/* In the surface's frame, stretched along its axes. */
static vec3_f64 stretched(const reference_surface *s, double along, double across, vec3_f64 d) {
    return vec_f64(along * dot_f64(d, s->along), across * dot_f64(d, cross_f64(s->normal, s->along)),
                   dot_f64(d, s->normal));
}

/* Samples a half vector of those GGX facets that the viewer sees: stretched to a hemisphere, they reflect to
 * it from a cap of directions with even density (Dupuy & Benyoub 2023). Half vectors by D alone would miss
 * the steep facets that a slanted view sees, and the few that they met would weigh a hundred times as much.
 */
static vec3_f64 half_vector(const reference_surface *s, alphas a, reference_random *random) {
    const vec3_f64 v = normalize_f64(stretched(s, a.along, a.across, s->to_viewer));
    const double angle = 2 * M_PI * reference_uniform(random), z = 1 - reference_uniform(random) * (1 + v.z),
                 radius = sqrt(fmax(1 - z * z, 0));
    const vec3_f64 h = add_f64(v, vec_f64(radius * cos(angle), radius * sin(angle), z));
    const vec3_f64 flat =
        madd_f64(scale_f64(a.along * h.x, s->along), a.across * h.y, cross_f64(s->normal, s->along));
    return normalize_f64(madd_f64(flat, h.z, s->normal));
}

/* D (v·h) G1(v) / (n·v): the density of a half vector. */
static double half_density(const reference_surface *s, alphas a, vec3_f64 h) {
    const vec3_f64 v = stretched(s, a.along, a.across, s->to_viewer),
                   q = stretched(s, 1 / a.along, 1 / a.across, h);
    const double square = dot_f64(q, q);
    if (!(q.z > 0)) return 0;
    return 2 * dot_f64(s->to_viewer, h) / (v.z + length_f64(v)) /
           (M_PI * a.along * a.across * square * square);
}

/* l mirrored to the other side of a thin wall. */
static vec3_f64 across_wall(const reference_surface *s, vec3_f64 l) {
    return madd_f64(l, -2 * dot_f64(l, s->normal), s->normal);
}

/* False: the facet scatters nothing to the side that chance chose. */
static bool by_facet(const reference_surface *s, bool coat, reference_random *random, vec3_f64 *out) {
    const vec3_f64 h = half_vector(s, alphas_of(s->material, coat), random);
    const double vh = dot_f64(s->to_viewer, h);
    const bool through = !coat && reference_uniform(random) < reference_facets_pass(s, vh);
    const bool bends = through && reference_refracts(s->material);
    if (!(vh > 0) || (bends && reference_far_cosine(vh, s->turn) < 0)) return false;
    *out = reference_mirrored(s->to_viewer, h);
    if (through) *out = bends ? reference_refracted(s->to_viewer, h, s->turn) : across_wall(s, *out);
    return dot_f64(*out, s->normal) * (through ? -1 : 1) > 0;
}

/* The density of directions that facets scatter to. The solid angle of half vectors is 1 / (4 v·h) of the
 * mirrored directions', and |l·h| ratio^2 / (v·h + ratio l·h)^2 of the refracted ones' (Walter et al. 2007).
 */
static double facet_density(const reference_surface *s, bool coat, vec3_f64 l) {
    const bool through = dot_f64(s->normal, l) < 0, bends = through && reference_refracts(s->material);
    vec3_f64 h = bends ? scale_f64(s->turn, l) : through ? across_wall(s, l) : l;
    h = normalize_f64(add_f64(s->to_viewer, h));
    if (dot_f64(h, s->normal) < 0) h = neg_f64(h);
    const double vh = dot_f64(s->to_viewer, h), lh = dot_f64(h, l), sum = vh + s->turn * lh;
    if (!(vh > 0) || (bends && !(lh < 0))) return 0;
    const double passing = coat ? 0 : reference_facets_pass(s, vh);
    const double density =
        half_density(s, alphas_of(s->material, coat), h) * (through ? passing : 1 - passing);
    return bends ? density * -lh * s->turn * s->turn / (sum * sum) : density / (4 * vh);
}

/* ---- lamps: the cone that the ball around one covers, or all directions from inside the ball ---- */

static double least_cosine(const reference_lamp *lamp, vec3_f64 point, vec3_f64 *axis) {
    const vec3_f64 way = sub_f64(lamp->center, point);
    const double sine = lamp->radius / length_f64(way);
    *axis = normalize_f64(way);
    return sine < 1 ? sqrt((1 - sine) * (1 + sine)) : -1;
}

static vec3_f64 to_lamp(const reference_scene *r, const reference_surface *s, reference_random *random) {
    vec3_f64 axis;
    const size_t k = (size_t)(reference_uniform(random) * (double)r->lamps.count);
    const double least = least_cosine(&r->lamps.items[k], s->point, &axis);
    return reference_around(axis, 1 - (1 - least) * reference_uniform(random), random);
}

static double lamps_density(const reference_scene *r, const reference_surface *s, vec3_f64 l) {
    double sum = 0;
    for (size_t k = 0; k < r->lamps.count; ++k) {
        vec3_f64 axis;
        const double least = least_cosine(&r->lamps.items[k], s->point, &axis);
        if (dot_f64(axis, l) >= least) sum += 1 / (2 * M_PI * (1 - least));
    }
    return sum / fmax((double)r->lamps.count, 1);
}

/* ---- all of them ---- */

static double density_of(const reference_scene *r, const reference_surface *s, const double shares[WAYS],
                         vec3_f64 l) {
    const double nl = dot_f64(s->normal, l);
    double sum = (nl > 0 ? shares[FRONT] : shares[BACK]) * fabs(nl) / M_PI;
    if (shares[FACETS] > 0) sum += shares[FACETS] * facet_density(s, false, l);
    if (shares[COAT] > 0) sum += shares[COAT] * facet_density(s, true, l);
    if (shares[LAMPS] > 0) sum += shares[LAMPS] * lamps_density(r, s, l);
    if (shares[SKY] > 0) sum += shares[SKY] * reference_sky_density(r, l);
    return sum;
}

double reference_choose(const reference_scene *r, const reference_surface *s, const reference_scatter *all,
                        reference_random *random, vec3_f64 *out) {
    double shares[WAYS], pick = reference_uniform(random);
    int way = 0;
    share_out(r, all, shares);
    while (way < WAYS - 1 && pick >= shares[way]) pick -= shares[way++];
    if (way == FRONT || way == BACK) {
        const vec3_f64 axis = way == FRONT ? s->normal : neg_f64(s->normal);
        *out = reference_around(axis, sqrt(1 - reference_uniform(random)), random);
    } else if (way == LAMPS) {
        if (!(shares[LAMPS] > 0)) return 0;
        *out = to_lamp(r, s, random);
    } else if (way == SKY) {
        if (!(shares[SKY] > 0)) return 0;
        *out = reference_to_sky(r, random);
    } else if (!by_facet(s, way == COAT, random, out)) {
        return 0;
    }
    return density_of(r, s, shares, *out);
}
