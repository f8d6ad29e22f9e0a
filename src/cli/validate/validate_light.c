/* fathom validate --light: a table and JSON of laws of light. */
#include "cli/interrupt.h"
#include "cli/machine.h"
#include "cli/render/progress.h"
#include "cli/validate/validate.h"

#include "base/clock.h"
#include "base/status.h"
#include "base/threads.h"
#include "verify/laws/laws.h"

#include <math.h>
#include <stdio.h>

/* Correct images fail in one run of 500. With about 250 tests, each test fails at about 4.5 standard errors,
 * if the standard errors are well known. */
#define LEVEL 0.002
/* Rounding error in float of the 65 products of a path and the same number of sums. */
#define ALLOWANCE 2e-5

/* user: the time at which the work began. */
static bool on_progress(void *user, double fraction) {
    progress_work(*(const double *)user, fraction, 0);
    return !interrupt_asked();
}

/* ---- closed forms ---- */

static void print_rows(const laws_rows *rows) {
    printf("%-33s %-8s %11s %11s %9s %9s %9s %11s\n", "law of light", "", "measured", "expected", "rel.error",
           "off/error", "p", "samples");
    for (size_t i = 0; i < rows->rows.count; ++i) {
        const laws_row *r = &rows->rows.items[i];
        const sample_mean *m = &r->found[r->worst];
        const double value = r->value[r->worst];
        printf("%-33s %-8s", r->law->name, laws_verdict_name(r->verdict));
        if (r->verdict == LAWS_REFUSED)
            printf(" %s\n", r->refusal);
        else
            printf(" %11.7f %11.7f %9.1e %9.2f %9.1e %11llu\n", m->mean, value, m->error / fabs(value),
                   r->off, r->p, (unsigned long long)r->samples);
    }
    printf("\n%zu of %zu laws fail; the smallest of %zu p-values is %.2g after correction, and %g fails\n",
           laws_failed(rows), rows->rows.count, rows->tests, rows->p, LEVEL);
}

static json_t *pack_row(const laws_row *r) {
    json_t *channels = json_array();
    for (int c = 0; c < 3; ++c)
        json_array_append_new(channels,
                              json_of(JSON("measured", r->found[c].mean), JSON("expected", r->value[c]),
                                      JSON("standardError", r->found[c].error),
                                      JSON("freedom", r->found[c].freedom)));
    return json_of(JSON("law", r->law->name), JSON("form", r->law->form),
                   JSON("verdict", laws_verdict_name(r->verdict)), JSON("p", r->p),
                   JSON("samples", r->samples), JSON("seconds", r->seconds),
                   JSON("refusal", r->refusal[0] ? r->refusal : NULL), JSON("channels", channels));
}

static json_t *pack(const laws_rows *rows, const validate_settings *settings) {
    json_t *list = json_array();
    for (size_t i = 0; i < rows->rows.count; ++i) json_array_append_new(list, pack_row(&rows->rows.items[i]));
    return json_add(machine_head(), JSON("integrator", "path"), JSON("seed", settings->seed),
                    JSON("level", LEVEL), JSON("tests", rows->tests), JSON("levelOfOne", rows->test_level),
                    JSON("p", rows->p), JSON("relativeError", settings->light_error), JSON("light", list));
}

static fathom_status write_json(fathom_context *context, const validate_settings *settings, json_t *root) {
    const fathom_status status = json_write_file(context, settings->json, root);
    json_decref(root);
    return status;
}

static fathom_status closed_forms(fathom_context *context, const validate_settings *settings, bool *fails) {
    double began = clock_seconds();
    const laws_options options = {.render = laws_path,
                                  .level = LEVEL,
                                  .error = settings->light_error,
                                  .allowance = ALLOWANCE,
                                  .pilot = 1 << 16,
                                  .samples = (uint64_t)1 << 26,
                                  .seed = settings->seed,
                                  .only = settings->light_only,
                                  .go_on = on_progress,
                                  .user = &began};
    laws_rows rows = {.tests = 0};
    fathom_status status = laws_run(context, &options, &rows);
    progress_clear_line();
    if (status == FATHOM_OK && !rows.rows.count)
        status = fail(context, FATHOM_BAD_USAGE, "--light-only: no law's name holds \"%.60s\"",
                      settings->light_only);
    *fails = laws_failed(&rows) > 0;
    if (!settings->common.quiet && rows.rows.count) print_rows(&rows);
    if (status == FATHOM_OK && settings->json) status = write_json(context, settings, pack(&rows, settings));
    laws_rows_free(&rows);
    return status;
}

/* ---- a scene ---- */

static void print_difference(const laws_difference *d, const laws_pair *pair) {
    const size_t cell = d->worst / 3;
    char where[96] = "of the whole image";
    if (cell < (size_t)pair->across * pair->down)
        snprintf(where, sizeof where, "in cell %zu of %u from the left, %zu of %u from the top",
                 cell % pair->across + 1, pair->across, cell / pair->across + 1, pair->down);
    printf("path less reference: %+.3e +- %.1e of the light; the smallest of %zu p-values is %.2g after "
           "correction, %s, and %g fails\n",
           d->relative, d->relative_error, d->tests, d->p, where, LEVEL);
}

/* Means of 8 x 8 cells, each of 64 pixels. */
static fathom_status compare_scene(fathom_context *context, const validate_settings *settings, bool *fails) {
    fathom_scene *scene;
    fathom_settings of_scene;
    laws_difference d = {.tests = 0};
    fathom_status status = fathom_scene_read(context, settings->scene, &scene);
    if (status != FATHOM_OK) return status;
    fathom_scene_settings(scene, &of_scene);
    const double ratio = of_scene.height ? (double)of_scene.width / of_scene.height : 1;
    laws_pair pair = {.across = (uint32_t)fmax(round(8 * fmin(ratio, 1)), 1),
                      .down = (uint32_t)fmax(round(8 / fmax(ratio, 1)), 1),
                      .depth = of_scene.max_depth,
                      .seed = settings->seed,
                      .threads = settings->common.threads ? settings->common.threads : processor_count(),
                      .allowance = ALLOWANCE};
    /* The relative standard deviation of a sample is about 1 to 10. */
    pair.samples = (uint64_t)(4 / (settings->light_error * settings->light_error));
    status = fathom_scene_check(scene);
    if (status == FATHOM_OK) status = laws_pair_run(context, scene, &pair, &d);
    *fails = d.tests && d.p < LEVEL;
    if (status == FATHOM_OK && !settings->common.quiet) print_difference(&d, &pair);
    if (status == FATHOM_OK && settings->json)
        status =
            write_json(context, settings,
                       json_add(machine_head(), JSON("scene", settings->scene), JSON("seed", settings->seed),
                                JSON("samples", pair.samples), JSON("tests", d.tests), JSON("p", d.p),
                                JSON("level", LEVEL), JSON("difference", d.relative),
                                JSON("standardError", d.relative_error)));
    fathom_scene_destroy(scene);
    return status;
}

fathom_status validate_light(fathom_context *context, const validate_settings *settings) {
    bool fails = false;
    progress_begin(settings->common.quiet, "validate");
    interrupt_keep_work(true);
    const fathom_status status = (settings->scene ? compare_scene : closed_forms)(context, settings, &fails);
    say_status(&command_validate, context, status);
    return status == FATHOM_OK && fails ? FATHOM_CHECK_FAILED : status;
}
