#include "cli/validate/validate_extremes.h"
#include "cli/validate/validate_shading.h"

#include "base/file.h"
#include "base/text.h"
#include "cli/command.h"
#include "cli/json_text.h"
#include "cli/machine.h"
#include "cli/report.h"
#include "verify/verdict/verdict.h"

#include <stdlib.h>
#include <string.h>

compare_family validate_sum(const validate_run *run) {
    compare_family sum;
    memset(&sum, 0, sizeof sum);
    for (int f = 0; f < RAYS_FAMILIES; ++f) compare_family_join(&sum, &run->result.families[f]);
    return sum;
}

double validate_ns_per_ray(const validate_run *run) {
    uint64_t rays = run->result.rays;
    return rays ? (double)run->result.nanoseconds / (double)rays : 0;
}

/* ---- the table ---- */

static void print_counts(const char *name, uint64_t rays, const uint64_t counts[VERDICT_COUNT]) {
    printf("%-16s %8llu", name, (unsigned long long)rays);
    for (int v = 0; v < VERDICT_COUNT; ++v) printf(" %7llu", (unsigned long long)counts[v]);
}

static void print_row(const char *name, const compare_family *f) {
    const compare_error *t = &f->errors[COMPARE_T_ULPS];
    print_counts(name, f->rays, f->counts);
    printf(" %7.2g %7.2g %7.2g %8.2g\n", histogram_quantile(&t->counts, 0.5),
           histogram_quantile(&t->counts, 0.999), t->most.value, f->constant.value);
}

static void print_any_row(const char *name, const compare_family *f) {
    char any[264];
    snprintf(any, sizeof any, "%s, any", name);
    print_counts(any, f->any_rays, f->any_counts);
    putchar('\n');
}

static void print_heading(void) {
    printf("%-16s %8s", "", "rays");
    for (int v = 0; v < VERDICT_COUNT; ++v) printf(" %7.7s", verdict_name((verdict)v));
    printf(" %7s %7s %7s %8s\n", "median", "99.9 %", "max ulp", "constant");
}

/* Below the families of a run. */
static void print_errors(const compare_family *f, double nanoseconds) {
    static const char *const names[COMPARE_MEASURES] = {NULL, "t |d| / scene", "position, ulp", "normal, ulp",
                                                        "u and v, ulp"};
    for (int m = COMPARE_T_RELATIVE; m < COMPARE_MEASURES; ++m) {
        const compare_error *e = &f->errors[m];
        if (!e->counts.total) continue;
        printf("  error of %-15s median %8.2g   99.9 %% %8.2g   max %8.2g\n", names[m],
               histogram_quantile(&e->counts, 0.5), histogram_quantile(&e->counts, 0.999), e->most.value);
    }
    printf("  %.0f ns a ray\n", nanoseconds);
}

static void print_run(const validate_run *run, bool verbose) {
    compare_family sum = validate_sum(run);
    char scene[256];
    snprintf(scene, sizeof scene, "%s", run->scene);
    text_disarm(scene);
    print_row(scene, &sum);
    if (verbose || sum.any_counts[VERDICT_WRONG] || sum.any_counts[VERDICT_LEAK]) print_any_row(scene, &sum);
    for (int f = 0; f < RAYS_FAMILIES && verbose; ++f) {
        char name[32];
        snprintf(name, sizeof name, "  %s", rays_family_name((rays_family)f));
        const compare_family *family = &run->result.families[f];
        if (!family->rays) continue;
        print_row(name, family);
        print_any_row(name, family);
    }
    if (verbose) print_errors(&sum, validate_ns_per_ray(run));
}

void validate_print(const validate_runs *runs, const validate_settings *settings) {
    const char *spec = "";
    for (size_t i = 0; i < runs->count; ++i) {
        const validate_run *run = &runs->items[i];
        if (strcmp(spec, run->spec) != 0) {
            printf("%s%s (%s)\n", *spec ? "\n" : "", run->spec, run->tracer);
            print_heading();
        }
        spec = run->spec;
        print_run(run, settings->verbose);
    }
}

/* ---- JSON ---- */

static json_t *pack_vector(vec3_f32 v) {
    return json_pack("[f, f, f]", (double)v.x, (double)v.y, (double)v.z);
}

static json_t *pack_most(const compare_most *most) {
    json_t *far = isinf(most->ray.t_far) ? json_null() : json_real((double)most->ray.t_far);
    return json_pack("{s:f, s:o, s:o, s:o, s:f, s:o}", "value", most->value, "index", json_count(most->index),
                     "origin", pack_vector(most->ray.org), "direction", pack_vector(most->ray.dir), "tNear",
                     (double)most->ray.t_near, "tFar", far);
}

static json_t *pack_histogram(const histogram *h) {
    unsigned used = HISTOGRAM_BINS;
    while (used > 0 && h->bins[used - 1] == 0) --used;
    json_t *bins = json_array();
    for (unsigned i = 0; i < used; ++i) json_array_append_new(bins, json_count(h->bins[i]));
    return json_pack("{s:o, s:i, s:i, s:o}", "zeros", json_count(h->zeros), "first", HISTOGRAM_FIRST,
                     "perOctave", HISTOGRAM_PER_OCTAVE, "bins", bins);
}

static json_t *pack_error(const compare_error *e) {
    return json_pack("{s:f, s:f, s:o, s:o}", "median", histogram_quantile(&e->counts, 0.5), "p99.9",
                     histogram_quantile(&e->counts, 0.999), "max", pack_most(&e->most), "histogram",
                     pack_histogram(&e->counts));
}

static json_t *pack_verdicts(const uint64_t counts[VERDICT_COUNT]) {
    json_t *verdicts = json_object();
    for (int v = 0; v < VERDICT_COUNT; ++v)
        json_object_set_new(verdicts, verdict_name((verdict)v), json_count(counts[v]));
    return verdicts;
}

static json_t *pack_any(const compare_family *f) {
    return json_pack("{s:o, s:o}", "rays", json_count(f->any_rays), "verdicts", pack_verdicts(f->any_counts));
}

static json_t *pack_family(const char *name, const compare_family *f) {
    static const char *const measures[COMPARE_MEASURES] = {"tUlps", "tRelative", "position", "normal", "uv"};
    json_t *family = json_pack("{s:s, s:o, s:o, s:o, s:o, s:o, s:o}", "family", name, "rays",
                               json_count(f->rays), "verdicts", pack_verdicts(f->counts), "any", pack_any(f),
                               "constant", pack_most(&f->constant), "oracleAsked", json_count(f->asked),
                               "oracleExact", json_count(f->exact));
    for (int m = 0; m < COMPARE_MEASURES; ++m) {
        if (f->errors[m].counts.total) json_object_set_new(family, measures[m], pack_error(&f->errors[m]));
    }
    return family;
}

static json_t *pack_run(const validate_run *run) {
    json_t *families = json_array();
    for (int f = 0; f < RAYS_FAMILIES; ++f) {
        if (!run->result.families[f].rays) continue;
        json_array_append_new(families,
                              pack_family(rays_family_name((rays_family)f), &run->result.families[f]));
    }
    compare_family sum = validate_sum(run);
    const char *isa = validate_isa_of(run);
    return json_pack("{s:o, s:o, s:s, s:o, s:f, s:f, s:o, s:o, s:o}", "scene", json_text(run->scene), "spec",
                     json_text(run->spec), "tracer", run->tracer, "isa", isa ? json_string(isa) : json_null(),
                     "seconds", run->seconds, "nsPerRay", validate_ns_per_ray(run), "any", pack_any(&sum),
                     "families", families, "failures", validate_failures_json(run));
}

static json_t *pack_machine(const validate_runs *runs, unsigned threads) {
    char cpu[128], embree[32] = "";
    machine_cpu(cpu, sizeof cpu);
    for (size_t i = 0; i < runs->count && !embree[0]; ++i) {
        const char *name = runs->items[i].tracer;
        if (strncmp(name, "Embree ", 7) == 0)
            snprintf(embree, sizeof embree, "%.*s", (int)strcspn(name + 7, ","), name + 7);
    }
    return json_pack("{s:o, s:o, s:s, s:o, s:s}", "cpu", json_text(cpu), "threads", json_count(threads),
                     "kernels", machine_kernels(), "embree", embree[0] ? json_string(embree) : json_null(),
                     "compiler", machine_compiler());
}

static json_t *pack(const validate_results *results, const validate_settings *settings) {
    const validate_runs *runs = &results->runs;
    json_t *list = json_array();
    for (size_t i = 0; i < runs->count; ++i) json_array_append_new(list, pack_run(&runs->items[i]));
    json_t *bounds = json_pack("{s:f, s:f, s:f, s:f}", "sphere", verdict_constant(ORACLE_SPHERE), "triangle",
                               verdict_constant(ORACLE_TRIANGLE), "quad", verdict_constant(ORACLE_QUAD),
                               "plane", verdict_constant(ORACLE_PLANE));
    char date[16];
    machine_date(date);
    json_t *root =
        json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o}", "fathom", fathom_version(), "date", date, "machine",
                  pack_machine(runs, settings->threads), "seed", json_count(settings->seed), "raysPerFamily",
                  json_count(settings->rays), "boundConstants", bounds, "runs", list);
    if (!settings->extremes) return root;
    json_object_set_new(root, "extremes", validate_extremes_json(&results->extremes));
    json_object_set_new(root, "shading", validate_shading_json(&results->shading));
    json_object_set_new(root, "images", validate_images_json(&results->images));
    return root;
}

fathom_status validate_write_json(fathom_context *context, const validate_results *results,
                                  const validate_settings *settings) {
    json_t *root = pack(results, settings);
    if (!root) return fail_memory(context, 4096);
    fathom_status status = FATHOM_OK;
    if (settings->json) status = json_write_file(context, settings->json, root);
    if (status == FATHOM_OK && settings->report) status = report_write(context, settings->report, root);
    json_decref(root);
    return status;
}
