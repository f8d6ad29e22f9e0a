#include "verify/statistics.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

static bool find(statistics_findings *out, const char *format, ...) __attribute__((format(printf, 2, 3)));
static bool find(statistics_findings *out, const char *format, ...) {
    statistics_finding finding;
    va_list list;
    va_start(list, format);
    vsnprintf(finding.words, sizeof finding.words, format, list);
    va_end(list);
    return array_push(out, finding);
}

double statistics_power(uint64_t rays) { return rays ? -expm1(-2.995732273553991 / (double)rays) : 1; }

void statistics_bias(const compare_bias *bias, double *mean, double *error) {
    double n = (double)bias->count, sum = (double)bias->sum / 1024;
    *mean = *error = 0;
    if (!bias->count) return;
    *mean = sum / n;
    double variance = fmax(0, (double)bias->squares / (1024.0 * 1024.0) / n - *mean * *mean);
    *error = sqrt((variance + 1) / n); /* at least a variance of one unit */
}

static bool check_constants(const histogram *constants, statistics_findings *out) {
    double median = histogram_quantile(constants, 0.5), high = histogram_quantile(constants, 0.999);
    if (constants->total < STATISTICS_LEAST || (median <= STATISTICS_MEDIAN && high <= STATISTICS_HIGH))
        return true;
    return find(out,
                "constants: the median error of t is %.2g units of its condition, the 99.9th percentile "
                "%.2g; expected at most %g and %g",
                median, high, STATISTICS_MEDIAN, STATISTICS_HIGH);
}

static bool check_bias(const compare_bias *bias, statistics_findings *out) {
    double mean, error;
    statistics_bias(bias, &mean, &error);
    bool fine = fabs(mean) - STATISTICS_SIGMAS * error <= STATISTICS_BIAS;
    if (bias->count < STATISTICS_LEAST || fine) return true;
    return find(out,
                "bias: t is off by %+.2f units of roundoff on average, with a standard error of %.2g; "
                "expected at most %g",
                mean, error, STATISTICS_BIAS);
}

/* The fraction of rays of a family that such a tracer is known to lose. It is about twice the measured one:
 * Embree 3.13.5 with each instruction set and closed meshes; robust: 1.9 % at vertices, 0.1 % elsewhere; else
 * 31 % at vertices (also taken for lattice rays), 6 % at edges. */
static double known_leaks(const trace_spec *spec, rays_family family) {
    bool robust = spec->kind == TRACE_EMBREE && spec->flags == TRACE_SCENE_ROBUST;
    if (robust) return family == RAYS_VERTEX ? 0.04 : 0.003;
    return family == RAYS_VERTEX || family == RAYS_LATTICE ? 0.62 : 0.12;
}

/* True if the count exceeds the known fraction by six standard deviations of a Poisson count plus ten. For a
 * correct tracer the probability is below 1e-9 for any count. */
static bool is_more(uint64_t found, double share, uint64_t rays) {
    const double known = share * (double)rays;
    return (double)found > known + STATISTICS_SIGMAS * sqrt(known) + 10;
}

/* A render starts its rays off the surface by the error of a hit, and ends shadow rays before their light. So
 * a correct tracer never gets RANGE there. A tracer with self-intersections darkens the image. */
static bool check_ends(const compare_family *f, statistics_findings *out) {
    const uint64_t ends =
        f->counts[VERDICT_RANGE] + f->any_counts[VERDICT_RANGE] + f->other_counts[VERDICT_RANGE];
    const uint64_t rays = f->rays + f->any_rays;
    if (!is_more(ends, STATISTICS_ENDS, rays)) return true;
    return find(out,
                "ends: %llu of %llu rays of a render are answered with a surface at an end of their "
                "interval; expected at most %.2g %%",
                (unsigned long long)ends, (unsigned long long)rays, 100 * STATISTICS_ENDS);
}

static bool check_leaks(const trace_spec *spec, rays_family family, uint64_t rays, uint64_t leaks,
                        statistics_findings *out) {
    const double share = known_leaks(spec, family);
    if (!is_more(leaks, share, rays)) return true;
    return find(out, "leaks: %llu of %llu rays of the family %s; such a tracer is known to lose %.2g %%",
                (unsigned long long)leaks, (unsigned long long)rays, rays_family_name(family), 100 * share);
}

bool statistics_run(const trace_spec *spec, const compare_family families[RAYS_FAMILIES],
                    statistics_findings *out) {
    bool room = true;
    histogram constants = {.total = 0};
    compare_bias bias = {.count = 0};
    for (rays_family f = 0; f < RAYS_FAMILIES; ++f) {
        const compare_family *family = &families[f];
        /* Excluded, because inputs that are exactly zero add nothing to a condition number. */
        const unsigned special = 1u << RAYS_AXIS | 1u << RAYS_TINY | 1u << RAYS_LATTICE | 1u << RAYS_ENDS;
        if (!(special >> f & 1)) histogram_join(&constants, &family->constants);
        bias.sum += family->bias.sum, bias.squares += family->bias.squares, bias.count += family->bias.count;
        room = check_leaks(spec, f, family->rays, family->counts[VERDICT_LEAK], out) && room;
        room = check_leaks(spec, f, family->any_rays, family->any_counts[VERDICT_LEAK], out) && room;
    }
    room = check_constants(&constants, out) && check_bias(&bias, out) && room;
    return check_ends(&families[RAYS_RENDERED], out) && room;
}

/* Only plug-ins declare a unit. The units of Fathom's own tracers follow from their precision. */
bool statistics_tracer(const trace_spec *spec, double unit, const compare_family *sum,
                       statistics_findings *out) {
    if (spec->kind != TRACE_PLUGIN) return true;
    double measured = histogram_quantile(&sum->constants, 0.99) * unit;
    if (sum->constants.total < STATISTICS_LEAST) {
        if (unit <= 0x1p-24) return true;
        return find(out,
                    "unit: the library declares a unit roundoff of %.2g, and has %llu hits to measure it by; "
                    "expected %d, or at most that of float",
                    unit, (unsigned long long)sum->constants.total, STATISTICS_LEAST);
    }
    if (unit <= STATISTICS_UNIT * measured) return true;
    return find(out,
                "unit: the library declares a unit roundoff of %.2g and computes with one of %.2g; expected "
                "at most %g times that",
                unit, measured, STATISTICS_UNIT);
}
