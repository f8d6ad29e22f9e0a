/* The table of groups, and the code that runs a case. */
#include "verify/extremes/case.h"

#include <string.h>

typedef struct group {
    const char *name, *meaning;
    void (*make)(judged_scene *c, double parameter);
    const double *values;
    unsigned count, shape;
} group;

static const double scales[] = {1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1,
                                1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8};
static const double sizes[] = {1e-35, 1e-30, 1e-25, 1e-20, 1e-15, 1e-12, 1e12, 1e15, 1e17};
static const double reaches[] = {1e16, 1e17, 1e18, 3e18, 9e19, 1e25, 1e38, 1e39};
static const double offsets[] = {0, 1e2, 1e3, 1e4, 1e5, 1e6, 6.371e6, 1e8, 1e10, 1e12};
static const double aspects[] = {1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8};
static const double angles[] = {1, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};
static const double tangents[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 0};
static const double ratios[] = {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6};
static const double parts[] = {1e-3, 1e-2, 1e-1, 1, 1e1, 1e2, 1e3, 1e4, 1e5};
static const double counts[] = {2, 10, 100, 1000, 10000};
static const double layers[] = {2, 10, 100, 1000};
static const double steps[] = {1e-6, 1e-4, 1e-2, 1, 1e2, 1e4, 1e6};
static const double numbers[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

#define VALUES(a) .values = (a), .count = sizeof(a) / sizeof *(a)

static const group groups[] = {
    {"scale-spheres", "scale", scale_make, VALUES(scales), CASE_SPHERES},
    {"scale-quads", "scale", scale_make, VALUES(scales), CASE_QUADS},
    {"scale-triangles", "scale", scale_make, VALUES(scales), CASE_TRIANGLES},
    {"size-spheres", "scale", scale_make, VALUES(sizes), CASE_SPHERES},
    {"size-quads", "scale", scale_make, VALUES(sizes), CASE_QUADS},
    {"size-triangles", "scale", scale_make, VALUES(sizes), CASE_TRIANGLES},
    {"beyond-spheres", "size", beyond_spheres, VALUES(reaches)},
    {"beyond-quads", "size", beyond_quads, VALUES(reaches)},
    {"beyond-triangles", "size", beyond_triangles, .values = reaches, .count = 7},
    {"offset-near", "distance", offset_near, VALUES(offsets)},
    {"offset-raw", "distance", offset_raw, VALUES(offsets)},
    {"sliver", "length/width", sliver_make, VALUES(aspects)},
    {"grazing-triangles", "radians", grazing_make, VALUES(angles), CASE_TRIANGLES},
    {"grazing-quads", "radians", grazing_make, VALUES(angles), CASE_QUADS},
    {"grazing-spheres", "radians", grazing_make, VALUES(angles), CASE_SPHERES},
    {"grazing-planes", "radians", grazing_make, VALUES(angles), CASE_PLANES},
    {"tangent", "distance over radius", tangent_make, VALUES(tangents)},
    {"ratio-outside", "radius over distance", ratio_outside, VALUES(ratios)},
    {"ratio-inside", "radius over distance", ratio_inside, .values = ratios + 6, .count = 7},
    {"ratio-surface", "radius over distance", ratio_surface, VALUES(ratios)},
    {"planet-part", "metres", planet_make, VALUES(parts)},
    {"planet-all", "metres", planet_outer, VALUES(parts)},
    {"copies-triangles", "copies", copies_make, VALUES(counts), CASE_TRIANGLES},
    {"copies-quads", "copies", copies_make, VALUES(counts), CASE_QUADS},
    {"copies-spheres", "copies", copies_make, VALUES(counts), CASE_SPHERES},
    {"overlap-level", "triangles", overlap_level, VALUES(layers)},
    {"overlap-tilted", "triangles", overlap_tilted, VALUES(layers)},
    {"nested-back", "factor", nested_back, VALUES(steps)},
    {"nested-grow", "factor", nested_grow, VALUES(steps)},
    {"nested-stretch", "factor", nested_stretch, VALUES(steps)},
    {"nested-mirror", "factor", nested_mirror, VALUES(steps)},
    {"broken", "", broken_make, .values = numbers, .count = 15},
};

unsigned extremes_groups(void) { return sizeof groups / sizeof *groups; }
const char *extremes_name(unsigned g) { return groups[g].name; }
unsigned extremes_cases(unsigned g) { return groups[g].count; }

bool judged_suits(const judged_scene *c, const trace_spec *spec) {
    const world *w = c->world;
    return spec->kind != TRACE_PLUGIN ||
           !(w->spheres.count || w->quads.count || w->planes.count || w->instances.count);
}

static void sum_up(const compare_result *result, extremes_row *row) {
    for (int f = 0; f < RAYS_FAMILIES; ++f) {
        const compare_family *family = &result->families[f];
        row->rays += family->rays, row->any_rays += family->any_rays;
        for (int v = 0; v < VERDICT_COUNT; ++v) {
            row->counts[v] += family->counts[v];
            row->any_counts[v] += family->any_counts[v];
        }
        row->constant = fmax(row->constant, family->constant.value);
    }
}

static bool keep_failures(const compare_result *result, const extremes_options *o, const char *text,
                          const extremes_row *row) {
    for (size_t i = 0; i < result->failures.count; ++i) {
        extremes_failure failure = {row->group, text, row->parameter, result->failures.items[i]};
        if (!array_push(o->failures, failure)) return false;
    }
    return true;
}

static fathom_status compare_case(const judged_scene *c, const char *text, const trace_spec *spec,
                                  trace_tracer *tracer, const extremes_options *o, extremes_row *row) {
    compare_subject subject = {c->world, c->search, c->source, tracer,
                               verdict_tracer_of(spec, trace_unit(tracer))};
    unsigned families = c->maker ? 1u : c->families,
             share = (unsigned)__builtin_popcount(families) * (c->thin ? c->thin : 1);
    compare_options options = {.families = families,
                               .rays = (o->rays + share - 1) / share,
                               .seed = o->seed,
                               .threads = o->threads,
                               .once =
                                   true, /* a ray among many copies is as expensive as thousands of others */
                               .failures = o->kept,
                               .progress = o->progress,
                               .user = o->user};
    compare_result result;
    memset(&result, 0, sizeof result);
    fathom_status status = compare_run(c->b.context, &subject, &options, &result);
    sum_up(&result, row);
    if (o->failures && !keep_failures(&result, o, text, row))
        status = fail_memory(c->b.context, sizeof *o->failures->items);
    compare_result_free(&result);
    return status;
}

static fathom_status ask_tracer(const judged_scene *c, const extremes_options *o, const char *text,
                                extremes_row *row, extremes_rows *rows) {
    trace_spec spec;
    fathom_status status = trace_spec_parse(c->b.context, text, &spec);
    if (status != FATHOM_OK || !judged_suits(c, &spec)) return status;
    trace_tracer *tracer;
    trace_options options = {.spec = &spec, .width = LANES, .threads = o->threads};
    status = trace_create(c->b.context, c->world, &options, &tracer);
    if (status == FATHOM_OK) status = compare_case(c, text, &spec, tracer, o, row);
    trace_destroy(tracer);
    if (status == FATHOM_OK || status == FATHOM_INTERRUPTED) {
        row->spec = text;
        if (!array_push(rows, *row)) return fail_memory(c->b.context, sizeof *row);
    }
    return status;
}

fathom_status extremes_run(fathom_context *context, unsigned g, unsigned index, const extremes_options *o,
                           extremes_rows *rows) {
    const double parameter = groups[g].values[index];
    judged_scene c;
    fathom_status status = case_open(context, groups[g].make, groups[g].shape, parameter, &c);
    for (size_t i = 0; i < o->spec_count && status == FATHOM_OK; ++i) {
        extremes_row row = {.group = groups[g].name, .meaning = groups[g].meaning, .parameter = parameter};
        memcpy(row.words, c.words, sizeof row.words);
        status = ask_tracer(&c, o, o->specs[i], &row, rows);
    }
    judged_close(&c);
    return status;
}

fathom_status extremes_open(fathom_context *context, const char *name, double parameter, judged_scene *out) {
    memset(out, 0, sizeof *out);
    for (unsigned g = 0; g < extremes_groups(); ++g) {
        if (strcmp(groups[g].name, name) == 0)
            return case_open(context, groups[g].make, groups[g].shape, parameter, out);
    }
    return fail(context, FATHOM_BAD_INPUT, "there is no group of extreme cases \"%.60s\"", name);
}
