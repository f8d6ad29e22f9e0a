#include "cli/validate_extremes.h"

#include "base/file.h"
#include "cli/command.h"
#include "cli/json_text.h"
#include "parity/verdict_bound.h"

#include <stdlib.h>
#include <string.h>

compare_family validate_sum(const validate_run *run) {
    compare_family sum;
    memset(&sum, 0, sizeof sum);
    for (int f = 0; f < RAYS_FAMILIES; ++f) compare_family_join(&sum, &run->result.families[f]);
    return sum;
}

/* ---- the table ---- */

static void print_row(const char *name, const compare_family *f) {
    printf("%-14s %9llu", name, (unsigned long long)f->rays);
    for (int v = 0; v < VERDICT_COUNT; ++v) printf(" %8llu", (unsigned long long)f->counts[v]);
    printf(" %8.2g %8.2g %8.2g %8.2g\n", histogram_quantile(&f->ulps, 0.5),
           histogram_quantile(&f->ulps, 0.999), f->most_ulps.value, f->constant.value);
}

static void print_heading(void) {
    printf("%-14s %9s", "", "rays");
    for (int v = 0; v < VERDICT_COUNT; ++v) printf(" %8.8s", verdict_name((verdict)v));
    printf(" %8s %8s %8s %8s\n", "median", "99.9 %", "max ulp", "constant");
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
        compare_family sum = validate_sum(run);
        print_row(run->scene, &sum);
        for (int f = 0; f < RAYS_FAMILIES && settings->verbose; ++f) {
            char name[32];
            snprintf(name, sizeof name, "  %s", rays_family_name((rays_family)f));
            if (run->result.families[f].rays) print_row(name, &run->result.families[f]);
        }
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

static json_t *pack_error(const histogram *h, const compare_most *most) {
    return json_pack("{s:f, s:f, s:o}", "median", histogram_quantile(h, 0.5), "p99.9",
                     histogram_quantile(h, 0.999), "max", pack_most(most));
}

static json_t *pack_family(const char *name, const compare_family *f) {
    json_t *verdicts = json_object();
    for (int v = 0; v < VERDICT_COUNT; ++v)
        json_object_set_new(verdicts, verdict_name((verdict)v), json_count(f->counts[v]));
    return json_pack("{s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "family", name, "rays", json_count(f->rays),
                     "verdicts", verdicts, "tUlps", pack_error(&f->ulps, &f->most_ulps), "tRelative",
                     pack_error(&f->relative, &f->most_relative), "constant", pack_most(&f->constant),
                     "oracleAsked", json_count(f->asked), "oracleExact", json_count(f->exact));
}

static json_t *pack_run(const validate_run *run) {
    json_t *families = json_array();
    for (int f = 0; f < RAYS_FAMILIES; ++f) {
        if (!run->result.families[f].rays) continue;
        json_array_append_new(families,
                              pack_family(rays_family_name((rays_family)f), &run->result.families[f]));
    }
    return json_pack("{s:o, s:o, s:s, s:f, s:o, s:o}", "scene", json_text(run->scene), "spec",
                     json_text(run->spec), "tracer", run->tracer, "seconds", run->seconds, "families",
                     families, "failures", validate_failures_json(run));
}

static json_t *pack(const validate_runs *runs, const extremes_rows *extremes,
                    const validate_settings *settings) {
    json_t *list = json_array();
    for (size_t i = 0; i < runs->count; ++i) json_array_append_new(list, pack_run(&runs->items[i]));
    json_t *bounds = json_pack("{s:f, s:f, s:f, s:f}", "sphere", verdict_constant(ORACLE_SPHERE), "triangle",
                               verdict_constant(ORACLE_TRIANGLE), "quad", verdict_constant(ORACLE_QUAD),
                               "plane", verdict_constant(ORACLE_PLANE));
    json_t *root =
        json_pack("{s:s, s:o, s:o, s:o, s:o}", "fathom", fathom_version(), "seed", json_count(settings->seed),
                  "raysPerFamily", json_count(settings->rays), "boundConstants", bounds, "runs", list);
    if (settings->extremes) json_object_set_new(root, "extremes", validate_extremes_json(extremes));
    return root;
}

static fathom_status write_text(fathom_context *context, const json_t *root, const char *path) {
    char *bytes = json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    if (!bytes) return fail_memory(context, 4096);
    file_writer *writer;
    fathom_status status = file_writer_open(context, path, &writer);
    if (status == FATHOM_OK) {
        file_writer_put(writer, bytes, strlen(bytes));
        file_writer_put(writer, "\n", 1);
        status = file_writer_commit(writer);
    }
    free(bytes);
    return status;
}

fathom_status validate_write_json(fathom_context *context, const validate_runs *runs,
                                  const extremes_rows *extremes, const validate_settings *settings) {
    json_t *root = pack(runs, extremes, settings);
    if (!root) return fail_memory(context, 4096);
    fathom_status status = FATHOM_OK;
    if (settings->json) status = write_text(context, root, settings->json);
    if (status == FATHOM_OK && settings->report) status = validate_write_report(context, root, settings);
    json_decref(root);
    return status;
}
