#include "cli/validate/validate.h"

#include "base/clock.h"
#include "cli/interrupt.h"
#include "cli/render/progress.h"

#include <string.h>

/* A case gets 1 / SHARE of the rays of a family in a scene. */
#define SHARE 12

/* Maximum number of failures of each family, case and tracer in --failures. */
#define FAILURES_KEPT 100

static const char *const default_tracers[] = {"linear:f32", "linear:f64", "bvh", "embree", "embree:user"};

typedef struct grid {
    double cases, done, start;
    uint64_t rays;
} grid;

static bool on_progress(void *user, uint64_t rays) {
    const grid *g = user;
    progress_work(g->start, g->done / g->cases, g->rays + rays);
    return !interrupt_asked();
}

static extremes_options options_of(const validate_settings *settings, grid *g) {
    extremes_options o = {.specs = default_tracers,
                          .spec_count = sizeof default_tracers / sizeof *default_tracers,
                          .rays = (settings->rays + SHARE - 1) / SHARE,
                          .seed = settings->seed,
                          .threads = settings->threads,
                          .progress = on_progress,
                          .user = g};
    if (settings->tracers_given) o.specs = settings->tracers.items, o.spec_count = settings->tracers.count;
    return o;
}

fathom_status validate_extremes_run(fathom_context *context, const validate_settings *settings,
                                    validate_results *results) {
    extremes_rows *rows = &results->extremes;
    grid g = {.start = clock_seconds()};
    extremes_options options = options_of(settings, &g);
    if (settings->failures) options.failures = &results->extremes_failures, options.kept = FAILURES_KEPT;
    for (unsigned k = 0; k < extremes_groups(); ++k) g.cases += extremes_cases(k);
    progress_begin(settings->common.quiet, "extremes");
    fathom_status status = FATHOM_OK;
    for (unsigned k = 0; k < extremes_groups(); ++k) {
        for (unsigned i = 0; i < extremes_cases(k) && status == FATHOM_OK; ++i) {
            size_t first = rows->count;
            status = extremes_run(context, k, i, &options, rows);
            for (; first < rows->count; ++first) g.rays += rows->items[first].rays;
            ++g.done;
        }
    }
    progress_clear_line();
    return status;
}

uint64_t validate_extremes_total(const extremes_rows *rows, verdict v) {
    uint64_t sum = 0;
    for (size_t i = 0; i < rows->count; ++i) sum += rows->items[i].counts[v] + rows->items[i].any_counts[v];
    return sum;
}

static void print_counts(const extremes_row *row) {
    printf(" %9llu", (unsigned long long)row->rays);
    for (verdict v = 0; v < VERDICT_COUNT; ++v) {
        if (row->counts[v])
            printf(" %8llu", (unsigned long long)row->counts[v]);
        else
            printf(" %8s", "-");
    }
    printf(" %8.2g\n", row->constant);
}

#define NAME_WIDTH 36

static void print_heading(const char *title) {
    printf("\n%-*s %9s", NAME_WIDTH, title, "rays");
    for (verdict v = 0; v < VERDICT_COUNT; ++v) printf(" %8.8s", verdict_name(v));
    printf(" %8s\n", "constant");
}

static void add_row(extremes_row *sum, const extremes_row *row) {
    sum->rays += row->rays;
    for (verdict v = 0; v < VERDICT_COUNT; ++v) sum->counts[v] += row->counts[v];
    if (row->constant > sum->constant) sum->constant = row->constant;
}

static bool is_last_of_case(const extremes_rows *rows, size_t i) {
    if (i + 1 == rows->count) return true;
    const extremes_row *a = &rows->items[i], *b = &rows->items[i + 1];
    return strcmp(a->group, b->group) != 0 || a->parameter != b->parameter;
}

static void print_group(const extremes_row *row) {
    char title[96];
    snprintf(title, sizeof title, "%s%s%s", row->group, *row->meaning ? ": " : "", row->meaning);
    print_heading(title);
}

/* Prints the parameter; in words if the number is only an index in a list. */
static void print_parameter(const extremes_row *row) {
    if (*row->meaning)
        printf("%-*g", NAME_WIDTH, row->parameter);
    else
        printf("%-*.*s", NAME_WIDTH, NAME_WIDTH, row->words);
}

/* Prints one line per case for all tracers; with --verbose also one for each tracer. */
static void print_cases(const extremes_rows *rows, bool verbose) {
    const char *group = "";
    extremes_row sum = {.rays = 0};
    for (size_t i = 0; i < rows->count; ++i) {
        const extremes_row *row = &rows->items[i];
        if (strcmp(group, row->group) != 0) print_group(row);
        group = row->group;
        add_row(&sum, row);
        if (verbose) {
            printf("    %-*s", NAME_WIDTH - 4, row->spec);
            print_counts(row);
        }
        if (!is_last_of_case(rows, i)) continue;
        print_parameter(row);
        print_counts(&sum);
        if (verbose) printf("  %s\n", row->words);
        sum = (extremes_row){.rays = 0};
    }
}

static void print_tracers(const extremes_rows *rows) {
    print_heading("extreme cases, all");
    for (size_t i = 0; i < rows->count; ++i) {
        const char *spec = rows->items[i].spec;
        bool known = false;
        for (size_t k = 0; k < i && !known; ++k) known = strcmp(rows->items[k].spec, spec) == 0;
        if (known) continue;
        extremes_row sum = {.rays = 0};
        for (size_t k = i; k < rows->count; ++k) {
            if (strcmp(rows->items[k].spec, spec) == 0) add_row(&sum, &rows->items[k]);
        }
        printf("%-*s", NAME_WIDTH, spec);
        print_counts(&sum);
    }
}

/* Repeats the wrong cases after the table, because the table is long. */
static void print_wrong(const extremes_rows *rows) {
    for (size_t i = 0; i < rows->count; ++i) {
        const extremes_row *row = &rows->items[i];
        uint64_t any = row->any_counts[VERDICT_WRONG];
        if (!row->counts[VERDICT_WRONG] && !any) continue;
        printf("found: %s, extreme case %s %g: wrong: %llu of %llu", row->spec, row->group, row->parameter,
               (unsigned long long)row->counts[VERDICT_WRONG], (unsigned long long)row->rays);
        if (any) printf(", and %llu of any hit", (unsigned long long)any);
        printf(": %s\n", row->words);
    }
}

void validate_extremes_print(const extremes_rows *rows, const validate_settings *settings) {
    print_cases(rows, settings->verbose);
    print_tracers(rows);
    print_wrong(rows);
}

static json_t *pack_row(const extremes_row *row) {
    const bool ok = !row->counts[VERDICT_WRONG] && !row->any_counts[VERDICT_WRONG];
    json_t *any =
        json_of(JSON("rays", row->any_rays), JSON("verdicts", validate_verdicts_json(row->any_counts)));
    return json_of(JSON("group", row->group), JSON("parameter", row->parameter), JSON("case", row->words),
                   JSON("spec", row->spec), JSON("rays", row->rays),
                   JSON("verdicts", validate_verdicts_json(row->counts)), JSON("any", any),
                   JSON("constant", row->constant), JSON("ok", ok));
}

json_t *validate_extremes_json(const extremes_rows *rows) {
    json_t *list = json_array();
    for (size_t i = 0; i < rows->count; ++i) json_array_append_new(list, pack_row(&rows->items[i]));
    return list;
}
