#include "cli/validate/validate.h"

#include "base/text.h"
#include "cli/machine.h"
#include "cli/report.h"
#include "verify/verdict/verdict.h"

#include <string.h>

compare_family validate_sum(const validate_run *run) {
    compare_family sum;
    memset(&sum, 0, sizeof sum);
    for (rays_family f = 0; f < RAYS_FAMILIES; ++f) compare_family_join(&sum, &run->result.families[f]);
    return sum;
}

compare_family validate_sum_tracer(const validate_runs *runs, size_t first, size_t *end) {
    compare_family sum = validate_sum(&runs->items[first]);
    for (*end = first + 1; *end < runs->count && strcmp(runs->items[*end].spec, runs->items[first].spec) == 0;
         ++*end) {
        const compare_family more = validate_sum(&runs->items[*end]);
        compare_family_join(&sum, &more);
    }
    return sum;
}

/* Time of one thread for tracing closest hits. */
static double ns_per_ray(const validate_run *run) {
    uint64_t rays = run->result.rays;
    return rays ? (double)run->result.nanoseconds / (double)rays : 0;
}

/* ---- the table ---- */

static void print_counts(const char *name, uint64_t rays, const uint64_t counts[VERDICT_COUNT]) {
    printf("%-16s %8llu", name, (unsigned long long)rays);
    for (verdict v = 0; v < VERDICT_COUNT; ++v) printf(" %7llu", (unsigned long long)counts[v]);
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
    for (verdict v = 0; v < VERDICT_COUNT; ++v) printf(" %7.7s", verdict_name(v));
    printf(" %7s %7s %7s %8s\n", "median", "99.9 %", "max ulp", "constant");
}

static void print_statistics(const compare_family *f, double nanoseconds) {
    double mean, error;
    statistics_bias(&f->bias, &mean, &error);
    printf(
        "  error of t by condition  median %8.2g   99.9 %% %8.2g   max %8.2g, bias %+.2g ± %.1g roundoffs\n",
        histogram_quantile(&f->constants, 0.5), histogram_quantile(&f->constants, 0.999), f->constant.value,
        mean, error);
    const oracle_ray *w = &f->widest.ray;
    printf("  widest bound of t: %.2g roundoffs, from %g %g %g along %g %g %g\n", f->widest.value,
           (double)w->org.x, (double)w->org.y, (double)w->org.z, (double)w->dir.x, (double)w->dir.y,
           (double)w->dir.z);
    if (f->others) printf("  %llu answers depend on how rays are asked\n", (unsigned long long)f->others);
    if (f->repaired) printf("  %llu answers repaired\n", (unsigned long long)f->repaired);
    printf("  %.0f ns a ray\n", nanoseconds);
}

static void print_errors(const compare_family *f) {
    static const char *const names[COMPARE_MEASURES] = {NULL, "t |d| / scene", "position, ulp", "normal, ulp",
                                                        "u and v, ulp"};
    for (int m = COMPARE_T_RELATIVE; m < COMPARE_MEASURES; ++m) {
        const compare_error *e = &f->errors[m];
        if (!e->counts.total) continue;
        printf("  error of %-15s median %8.2g   99.9 %% %8.2g   max %8.2g\n", names[m],
               histogram_quantile(&e->counts, 0.5), histogram_quantile(&e->counts, 0.999), e->most.value);
    }
}

static void print_run(const validate_run *run, bool verbose) {
    compare_family sum = validate_sum(run);
    char scene[256];
    snprintf(scene, sizeof scene, "%s", run->scene);
    text_disarm(scene);
    print_row(scene, &sum);
    if (verbose || sum.any_counts[VERDICT_WRONG] || sum.any_counts[VERDICT_LEAK]) print_any_row(scene, &sum);
    for (rays_family f = 0; f < RAYS_FAMILIES && verbose; ++f) {
        char name[32];
        snprintf(name, sizeof name, "  %s", rays_family_name(f));
        const compare_family *family = &run->result.families[f];
        if (!family->rays) continue;
        print_row(name, family);
        print_any_row(name, family);
    }
    if (!verbose) return;
    print_errors(&sum);
    print_statistics(&sum, ns_per_ray(run));
}

/* ---- statistical power and findings ---- */

/* Two digits, rounded up, so that the statement stays true. */
static double rate_below(uint64_t rays) {
    const double rate = statistics_power(rays), place = pow(10, floor(log10(rate)) - 1);
    return ceil(rate / place) * place;
}

static void print_power(const validate_runs *runs, size_t first, const compare_family *sum, size_t end) {
    const uint64_t wrong =
        sum->counts[VERDICT_WRONG] + sum->any_counts[VERDICT_WRONG] + sum->other_counts[VERDICT_WRONG];
    uint64_t screened = 0;
    for (size_t i = first; i < end; ++i) screened += runs->items[i].result.screened;
    printf("%s: %llu answers wrong in %llu rays judged", runs->items[first].spec, (unsigned long long)wrong,
           (unsigned long long)sum->rays);
    if (!wrong) printf(": the rate is below %.2g at 95 %%", rate_below(sum->rays));
    if (screened) printf("; %llu more asked of a second tracer, too", (unsigned long long)screened);
    if (screened && !wrong) printf(": below %.2g", rate_below(screened + sum->rays));
    putchar('\n');
}

static void print_powers(const validate_runs *runs) {
    putchar('\n');
    for (size_t i = 0, end; i < runs->count; i = end) {
        const compare_family sum = validate_sum_tracer(runs, i, &end);
        print_power(runs, i, &sum, end);
    }
}

static void print_wrong(const validate_run *run) {
    const compare_family sum = validate_sum(run);
    const uint64_t closest = sum.counts[VERDICT_WRONG], any = sum.any_counts[VERDICT_WRONG],
                   others = sum.other_counts[VERDICT_WRONG];
    if (!closest && !any && !others) return;
    printf("found: %s, %s: wrong: %llu closest hits, %llu any hits, %llu answers to other ways of asking, "
           "repaired or screened\n",
           run->spec, run->scene, (unsigned long long)closest, (unsigned long long)any,
           (unsigned long long)others);
}

static void print_skips(const validate_results *results) {
    for (size_t i = 0; i < results->skips.count; ++i) {
        const validate_skip *skip = &results->skips.items[i];
        bool new = i == 0 || strcmp(skip[-1].spec, skip->spec) != 0;
        if (new) printf("%s%s cannot hold: %s", i ? "\n" : "", skip->spec, skip->scene);
        if (!new) printf(", %s", skip->scene);
    }
    if (results->skips.count) putchar('\n');
}

void validate_print_findings(const validate_results *results) {
    const validate_runs *runs = &results->runs;
    print_powers(runs);
    print_skips(results);
    for (size_t i = 0; i < runs->count; ++i) {
        print_wrong(&runs->items[i]);
        for (size_t k = 0; k < runs->items[i].findings.count; ++k)
            printf("found: %s, %s: %s\n", runs->items[i].spec, runs->items[i].scene,
                   runs->items[i].findings.items[k].words);
    }
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
    for (verdict v = 0; v < VERDICT_COUNT; ++v) json_add(verdicts, JSON(verdict_name(v), counts[v]));
    return verdicts;
}

static json_t *pack_any(const compare_family *f) {
    return json_of(JSON("rays", f->any_rays), JSON("verdicts", validate_verdicts_json(f->any_counts)));
}

static json_t *pack_others(const compare_family *f) {
    return json_of(JSON("answers", f->others), JSON("verdicts", validate_verdicts_json(f->other_counts)),
                   JSON("repaired", f->repaired));
}

static json_t *pack_constants(const compare_family *f) {
    double mean, error;
    statistics_bias(&f->bias, &mean, &error);
    return json_of(JSON("median", histogram_quantile(&f->constants, 0.5)),
                   JSON("p99.9", histogram_quantile(&f->constants, 0.999)), JSON("bias", mean),
                   JSON("biasError", error));
}

static json_t *pack_findings(const validate_run *run) {
    json_t *list = json_array();
    for (size_t i = 0; i < run->findings.count; ++i)
        json_array_append_new(list, json_text(run->findings.items[i].words));
    return list;
}

static json_t *pack_family(const char *name, const compare_family *f) {
    static const char *const measures[COMPARE_MEASURES] = {"tUlps", "tRelative", "position", "normal", "uv"};
    json_t *family = json_of(
        JSON("family", name), JSON("rays", f->rays), JSON("verdicts", validate_verdicts_json(f->counts)),
        JSON("any", pack_any(f)), JSON("others", pack_others(f)), JSON("constants", pack_constants(f)),
        JSON("constant", pack_most(&f->constant)), JSON("widestBound", pack_most(&f->widest)));
    for (int m = 0; m < COMPARE_MEASURES; ++m) {
        if (f->errors[m].counts.total) json_add(family, JSON(measures[m], pack_error(&f->errors[m])));
    }
    return family;
}

static json_t *pack_run(const validate_run *run) {
    json_t *families = json_array();
    for (rays_family f = 0; f < RAYS_FAMILIES; ++f) {
        const compare_family *family = &run->result.families[f];
        if (!family->rays) continue;
        json_array_append_new(families, pack_family(rays_family_name(f), family));
    }
    const compare_family sum = validate_sum(run);
    char version[64], isa[64];
    const bool embree = machine_embree(run->tracer, version, isa);
    return json_of(JSON("scene", run->scene), JSON("spec", run->spec), JSON("tracer", run->tracer),
                   JSON("isa", embree ? isa : NULL), JSON("seconds", run->seconds),
                   JSON("nsPerRay", ns_per_ray(run)), JSON("any", pack_any(&sum)), JSON("families", families),
                   JSON("screened", run->result.screened), JSON("findings", pack_findings(run)),
                   JSON("failures", validate_failures_json(run)));
}

static json_t *pack_head(const validate_runs *runs, unsigned threads) {
    json_t *head = machine_head();
    char version[64], isa[64];
    bool embree = false;
    for (size_t i = 0; i < runs->count && !embree; ++i)
        embree = machine_embree(runs->items[i].tracer, version, isa);
    json_add(json_object_get(head, "machine"), JSON("threads", threads),
             JSON("embree", embree ? version : NULL));
    return head;
}

static json_t *pack(const validate_results *results, const validate_settings *settings) {
    const validate_runs *runs = &results->runs;
    json_t *list = json_array();
    for (size_t i = 0; i < runs->count; ++i) json_array_append_new(list, pack_run(&runs->items[i]));
    json_t *bounds = json_of(
        JSON("sphere", verdict_constant(ORACLE_SPHERE)), JSON("triangle", verdict_constant(ORACLE_TRIANGLE)),
        JSON("quad", verdict_constant(ORACLE_QUAD)), JSON("plane", verdict_constant(ORACLE_PLANE)));
    json_t *root =
        json_add(pack_head(runs, settings->threads), JSON("seed", settings->seed),
                 JSON("raysPerFamily", settings->rays), JSON("boundConstants", bounds), JSON("runs", list));
    if (!settings->extremes) return root;
    return json_add(root, JSON("extremes", validate_extremes_json(&results->extremes)),
                    JSON("shading", validate_shading_json(&results->shading)));
}

fathom_status validate_write_json(fathom_context *context, const validate_results *results,
                                  const validate_settings *settings) {
    json_t *root = pack(results, settings);
    fathom_status status = FATHOM_OK;
    if (settings->json) status = json_write_file(context, settings->json, root);
    if (status == FATHOM_OK && settings->report) status = report_write(context, settings->report, root);
    json_decref(root);
    return status;
}
