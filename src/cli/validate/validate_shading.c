#include "cli/validate/validate.h"

#include "cli/interrupt.h"

#include <math.h>
#include <string.h>

/* Moves the rows of each group together, in their original order. */
static void gather_groups(shading_rows *rows) {
    for (size_t i = 1; i < rows->count; ++i) {
        shading_row row = rows->items[i];
        size_t at = i, to = i;
        while (to > 0 && strcmp(rows->items[to - 1].group, row.group) != 0) --to;
        if (to == 0) continue; /* the first of its group */
        for (; at > to; --at) rows->items[at] = rows->items[at - 1];
        rows->items[to] = row;
    }
}

fathom_status validate_shading_run(fathom_context *context, const validate_settings *settings,
                                   validate_results *results) {
    shading_rows *rows = &results->shading;
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < settings->tracers.count && status == FATHOM_OK; ++i) {
        const shading_options options = {.spec = settings->tracers.items[i], .progress = interrupt_go_on};
        trace_spec spec;
        status = trace_spec_parse(context, options.spec, &spec);
        if (status != FATHOM_OK || spec.kind == TRACE_PLUGIN) continue;
        status = shading_run(context, &options, rows);
        if (status == FATHOM_OK) status = shading_earth(context, &options, rows);
    }
    gather_groups(rows);
    return status;
}

uint64_t validate_shading_wrong(const shading_rows *rows) {
    uint64_t wrong = 0;
    for (size_t i = 0; i < rows->count; ++i) wrong += !rows->items[i].ok;
    return wrong;
}

static double share_of(const shading_row *row) {
    if (row->error == 0) return 0;
    return row->bound > 0 ? row->error / row->bound : (double)INFINITY;
}

static void print_row(const shading_row *row) {
    printf("  %-64.64s %-20s %12.6g %12.6g %9.2g %9.2g%s\n", row->what, row->spec, row->measured,
           row->expected, row->error, row->bound, row->ok ? "" : "  wrong");
}

/* Prints a line for each group; below it the wrong cases, or with --verbose every case. */
static size_t print_group(const shading_rows *rows, size_t first, bool verbose) {
    size_t end = first, wrong = 0;
    double most = 0;
    for (; end < rows->count && strcmp(rows->items[end].group, rows->items[first].group) == 0; ++end) {
        wrong += !rows->items[end].ok;
        most = fmax(most, share_of(&rows->items[end]));
    }
    printf("%-20s %9zu %8zu %12.2g\n", rows->items[first].group, end - first, wrong, most);
    for (size_t i = first; i < end; ++i) {
        if (verbose || !rows->items[i].ok) print_row(&rows->items[i]);
    }
    return end;
}

void validate_shading_print(const shading_rows *rows, const validate_settings *settings) {
    if (!rows->count) return;
    printf("\n%-20s %9s %8s %12s\n", "shading", "cases", "wrong", "error/bound");
    for (size_t i = 0; i < rows->count;) i = print_group(rows, i, settings->verbose);
}

static json_t *pack_row(const shading_row *row) {
    char words[sizeof row->what + 64];
    snprintf(words, sizeof words, "%s, by %s", row->what, row->spec);
    return json_of(JSON("group", row->group), JSON("parameter", row->parameter), JSON("case", words),
                   JSON("spec", row->spec), JSON("measured", row->measured), JSON("expected", row->expected),
                   JSON("error", row->error), JSON("bound", row->bound), JSON("ok", row->ok));
}

json_t *validate_shading_json(const shading_rows *rows) {
    json_t *list = json_array();
    for (size_t i = 0; i < rows->count; ++i) json_array_append_new(list, pack_row(&rows->items[i]));
    return list;
}
