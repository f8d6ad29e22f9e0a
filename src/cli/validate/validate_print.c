#include "cli/validate/validate.h"

#include "base/status.h"
#include "base/text.h"
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

/* Spent tracing closest hits, by one thread. */
static double ns_per_ray(const validate_run *run) {
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
    if (verbose) print_errors(&sum, ns_per_ray(run));
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

static json_t *pack_vector(vec3_f32 v) { return json_vector((double)v.x, (double)v.y, (double)v.z); }

static json_t *pack_most(const compare_most *most) {
    return json_of(JSON("value", most->value), JSON("index", most->index),
                   JSON("origin", pack_vector(most->ray.org)), JSON("direction", pack_vector(most->ray.dir)),
                   JSON("tNear", most->ray.t_near), JSON("tFar", most->ray.t_far));
}

static json_t *pack_histogram(const histogram *h) {
    unsigned used = HISTOGRAM_BINS;
    while (used > 0 && h->bins[used - 1] == 0) --used;
    json_t *bins = json_array();
    for (unsigned i = 0; i < used; ++i) json_array_append_new(bins, json_count(h->bins[i]));
    return json_of(JSON("zeros", h->zeros), JSON("first", HISTOGRAM_FIRST),
                   JSON("perOctave", HISTOGRAM_PER_OCTAVE), JSON("bins", bins));
}

static json_t *pack_error(const compare_error *e) {
    return json_of(JSON("median", histogram_quantile(&e->counts, 0.5)),
                   JSON("p99.9", histogram_quantile(&e->counts, 0.999)), JSON("max", pack_most(&e->most)),
                   JSON("histogram", pack_histogram(&e->counts)));
}

json_t *validate_verdicts_json(const uint64_t counts[VERDICT_COUNT]) {
    json_t *verdicts = json_object();
    for (int v = 0; v < VERDICT_COUNT; ++v) json_add(verdicts, JSON(verdict_name((verdict)v), counts[v]));
    return verdicts;
}

static json_t *pack_any(const compare_family *f) {
    return json_of(JSON("rays", f->any_rays), JSON("verdicts", validate_verdicts_json(f->any_counts)));
}

static json_t *pack_family(const char *name, const compare_family *f) {
    static const char *const measures[COMPARE_MEASURES] = {"tUlps", "tRelative", "position", "normal", "uv"};
    json_t *family = json_of(JSON("family", name), JSON("rays", f->rays),
                             JSON("verdicts", validate_verdicts_json(f->counts)), JSON("any", pack_any(f)),
                             JSON("constant", pack_most(&f->constant)), JSON("oracleAsked", f->asked),
                             JSON("oracleExact", f->exact));
    for (int m = 0; m < COMPARE_MEASURES; ++m) {
        if (f->errors[m].counts.total) json_add(family, JSON(measures[m], pack_error(&f->errors[m])));
    }
    return family;
}

static json_t *pack_run(const validate_run *run) {
    json_t *families = json_array();
    for (int f = 0; f < RAYS_FAMILIES; ++f) {
        const compare_family *family = &run->result.families[f];
        if (!family->rays) continue;
        json_array_append_new(families, pack_family(rays_family_name((rays_family)f), family));
    }
    compare_family sum = validate_sum(run);
    return json_of(JSON("scene", run->scene), JSON("spec", run->spec), JSON("tracer", run->tracer),
                   JSON("isa", validate_isa_of(run)), JSON("seconds", run->seconds),
                   JSON("nsPerRay", ns_per_ray(run)), JSON("any", pack_any(&sum)), JSON("families", families),
                   JSON("failures", validate_failures_json(run)));
}

static json_t *pack_machine(const validate_runs *runs, unsigned threads) {
    char embree[32] = "";
    for (size_t i = 0; i < runs->count && !embree[0]; ++i) {
        const char *name = runs->items[i].tracer;
        if (strncmp(name, "Embree ", 7) == 0)
            snprintf(embree, sizeof embree, "%.*s", (int)strcspn(name + 7, ","), name + 7);
    }
    return json_add(machine_json(), JSON("threads", threads), JSON("embree", embree[0] ? embree : NULL));
}

static json_t *pack(const validate_results *results, const validate_settings *settings) {
    const validate_runs *runs = &results->runs;
    char date[16];
    machine_date(date);
    json_t *list = json_array();
    for (size_t i = 0; i < runs->count; ++i) json_array_append_new(list, pack_run(&runs->items[i]));
    json_t *bounds = json_of(
        JSON("sphere", verdict_constant(ORACLE_SPHERE)), JSON("triangle", verdict_constant(ORACLE_TRIANGLE)),
        JSON("quad", verdict_constant(ORACLE_QUAD)), JSON("plane", verdict_constant(ORACLE_PLANE)));
    json_t *root =
        json_of(JSON("fathom", fathom_version()), JSON("date", date),
                JSON("machine", pack_machine(runs, settings->threads)), JSON("seed", settings->seed),
                JSON("raysPerFamily", settings->rays), JSON("boundConstants", bounds), JSON("runs", list));
    if (!settings->extremes) return root;
    return json_add(root, JSON("extremes", validate_extremes_json(&results->extremes)),
                    JSON("shading", validate_shading_json(&results->shading)),
                    JSON("images", validate_images_json(&results->images)));
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
