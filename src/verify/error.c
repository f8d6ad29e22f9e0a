/* Computes in quadruple precision, which has far more digits than any tracer needs. */
#include "verify/error.h"
#include "verify/exact/exact.h"
#include "verify/mode.h"

double error_ulp(double x) {
    int exponent;
    (void)frexp(x, &exponent);
    return ldexp(1, exponent - 24 < -149 ? -149 : exponent - 24);
}

static double position_error(const oracle_ray *ray, const oracle_answer *answer, double t) {
    const double moved = (double)fabsl((long double)(answer->t - (real_f128)t));
    vec3_f128 p = madd_f128(quadruple_f32(ray->org), answer->t, quadruple_f32(ray->dir));
    double far = fmax(fabs((double)p.x), fmax(fabs((double)p.y), fabs((double)p.z)));
    return moved * length_f64(widen(ray->dir)) / error_ulp(far);
}

/* The sphere's normal at the point; for a quad, that of the part. */
static vec3_f128 exact_normal(const oracle_ray *ray, const oracle_primitive *p, const oracle_answer *answer) {
    if (p->shape == ORACLE_PLANE) return quadruple_f32(p->v[1]);
    if (p->shape == ORACLE_SPHERE) {
        const object_ray r = object_ray_of(ray, p->instance);
        return madd_f128(sub_f128(r.org, quadruple_f64(oracle_center(p))), answer->t, r.dir);
    }
    vec3_f32 v[3];
    oracle_part(p, answer->part, v);
    const vec3_f128 a = quadruple_f32(v[0]), b = quadruple_f32(v[1]), c = quadruple_f32(v[2]);
    return cross_f128(sub_f128(b, a), sub_f128(c, a));
}

static double angle(vec3_f128 a, vec3_f128 b) {
    const long double across = (long double)length_f128(cross_f128(a, b));
    return (double)atan2l(across, (long double)dot_f128(a, b));
}

static double normal_error(const oracle_ray *ray, const oracle_primitive *p, const oracle_answer *answer,
                           vec3_f32 said) {
    bool any = finite_f32(said) && (said.x != 0 || said.y != 0 || said.z != 0);
    return (any ? angle(exact_normal(ray, p, answer), quadruple_f32(said)) : 3.141592653589793) * 0x1p24;
}

static double uv_error(const oracle_primitive *p, const oracle_answer *answer, const error_said *said) {
    if (p->shape == ORACLE_SPHERE || p->shape == ORACLE_PLANE) return -1;
    double error = isfinite(said->u) && isfinite(said->v) ? 0 : (double)INFINITY;
    for (int k = 1; k <= 2; ++k) {
        real_f128 exact = answer->weight[k];
        if (p->shape == ORACLE_QUAD && answer->part) exact = 1 - exact;
        error = fmax(error, (double)fabsl((long double)(exact - (real_f128)(k == 1 ? said->u : said->v))));
    }
    return error * 0x1p24;
}

static MODE_APART void measure(const oracle_ray *ray, const oracle_primitive *p, const oracle_answer *answer,
                               const error_said *said, error_report *out) {
    out->position = position_error(ray, answer, said->t);
    out->normal = normal_error(ray, p, answer, said->normal);
    out->uv = uv_error(p, answer, said);
}

void error_measure(const oracle_ray *ray, const oracle_primitive *primitive, const oracle_answer *answer,
                   const error_said *said, error_report *out) {
    unsigned mode = mode_enter();
    measure(ray, primitive, answer, said, out);
    mode_leave(mode);
}

void histogram_add(histogram *h, double value) {
    ++h->total;
    if (value > h->largest) h->largest = value;
    if (!(value > 0)) {
        ++h->zeros;
        return;
    }
    double place = floor(HISTOGRAM_PER_OCTAVE * (log2(value) - HISTOGRAM_FIRST));
    unsigned bin = place < 0 ? 0 : place >= HISTOGRAM_BINS ? HISTOGRAM_BINS - 1 : (unsigned)place;
    ++h->bins[bin];
}

void histogram_join(histogram *h, const histogram *other) {
    h->zeros += other->zeros, h->total += other->total;
    h->largest = fmax(h->largest, other->largest);
    for (unsigned i = 0; i < HISTOGRAM_BINS; ++i) h->bins[i] += other->bins[i];
}

double histogram_quantile(const histogram *h, double q) {
    double wanted = q * (double)h->total, below = (double)h->zeros;
    if (below >= wanted) return 0;
    for (unsigned i = 0; i < HISTOGRAM_BINS; ++i) {
        below += (double)h->bins[i];
        if (below >= wanted)
            return fmin(h->largest, exp2((double)(i + 1) / HISTOGRAM_PER_OCTAVE + HISTOGRAM_FIRST));
    }
    return (double)INFINITY;
}
