#include "cli/bench/bench.h"

#include "base/clock.h"
#include "base/status.h"
#include "cli/machine.h"
#include "cli/outputs.h"
#include "cli/report.h"
#include "json/memory.h"

#include <stdlib.h>
#include <string.h>

const char *const bench_clock_names[BENCH_CLOCKS] = {"cpu", "wall"};

/* ---- files ---- */

static void put_text(FILE *out, const char *text) {
    if (!text[strcspn(text, ",\"\r\n")]) {
        fputs(text, out);
        return;
    }
    fputc('"', out);
    for (; *text; ++text) {
        if (*text == '"') fputc('"', out);
        fputc(*text, out);
    }
    fputc('"', out);
}

/* Numbers that are not finite are null in JSON; they become inf here, to differ from missing ones. */
static void put_value(FILE *out, const json_t *value) {
    if (json_is_string(value))
        put_text(out, json_string_value(value));
    else if (json_is_number(value))
        fprintf(out, "%.9g", json_number_value(value));
    else if (json_is_boolean(value))
        fputc(json_is_true(value) ? '1' : '0', out);
    else
        fputs(value ? "inf" : "nan", out);
}

/* Reads the next column of "name=path, name"; false at the end. */
static bool next_column(const char **columns, char name[64], char path[64]) {
    int used = 0;
    path[0] = '\0';
    if (sscanf(*columns, " %63[^=,]%n", name, &used) != 1) return false;
    *columns += used;
    if (**columns == '=' && sscanf(*columns, "=%63[^,]%n", path, &used) == 1) *columns += used;
    if (!path[0]) snprintf(path, 64, "%s", name);
    *columns += **columns == ',';
    return true;
}

static void put_row(FILE *out, const char *columns, const json_t *outer, const json_t *inner) {
    char name[64], path[64];
    for (bool first = true; next_column(&columns, name, path); first = false) {
        const json_t *value = json_at(inner, path);
        if (!first) fputc(',', out);
        put_value(out, value ? value : json_at(outer, path));
    }
    fputc('\n', out);
}

static void put_rows(FILE *out, const json_t *root, const bench_csv *csv) {
    const char *columns = csv->columns;
    char name[64], path[64];
    for (bool first = true; next_column(&columns, name, path); first = false)
        fprintf(out, "%s%s", first ? "" : ",", name);
    fputc('\n', out);
    size_t i, k;
    json_t *row, *inner;
    json_array_foreach(json_object_get(root, csv->rows), i, row) {
        if (!csv->inner) put_row(out, csv->columns, NULL, row);
        json_array_foreach(csv->inner ? json_object_get(row, csv->inner) : NULL, k, inner)
            put_row(out, csv->columns, row, inner);
    }
}

static void put_facts(FILE *out, const json_t *root) {
    const char *key, *commit = json_text_at(root, "commit");
    json_t *value;
    fprintf(out, "# fathom bench %s, fathom %s%s%s, %s\n", json_text_at(root, "bench"),
            json_text_at(root, "fathom"), *commit ? ", commit " : "", commit, json_text_at(root, "date"));
    json_object_foreach(json_object_get(root, "machine"), key, value) {
        if (json_is_string(value))
            fprintf(out, "# %s: %s\n", key, json_string_value(value));
        else
            fprintf(out, "# %s: %g\n", key, json_number_value(value));
    }
}

static fathom_status write_csv(fathom_context *context, const char *path, const json_t *root,
                               const bench_csv *csv) {
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    if (!out) return fail_memory(context, 4096);
    put_facts(out, root);
    put_rows(out, root, csv);
    fathom_status status = FATHOM_OK;
    if (fclose(out) != 0) status = fail_memory(context, size);
    if (status == FATHOM_OK) status = outputs_write(context, path, text, size);
    free(text);
    return status;
}

static fathom_status write_outputs(fathom_context *context, const bench_settings *asked, const json_t *root) {
    fathom_status status = FATHOM_OK;
    if (asked->json) status = json_write_file(context, asked->json, root);
    if (status == FATHOM_OK && asked->csv) status = write_csv(context, asked->csv, root, asked->table);
    if (status == FATHOM_OK && asked->report) status = report_write(context, asked->report, root);
    return status;
}

/* ---- results ---- */

static json_t *head(const char *what) {
    double load[3];
    json_t *root = machine_head();
    if (getloadavg(load, 3) > 0) json_add(json_object_get(root, "machine"), JSON("load", load[0]));
    return json_add(root, JSON("bench", what));
}

void bench_add_tracer(json_t *root, const char *tracer_name) {
    if (strncmp(tracer_name, "Embree ", 7) != 0) return;
    json_add(json_object_get(root, "machine"), JSON("embree", tracer_name + 7));
}

json_t *bench_quartiles(quartiles q) {
    return json_of(JSON("low", q.low), JSON("median", q.median), JSON("high", q.high));
}

json_t *bench_clocks(const quartiles q[BENCH_CLOCKS]) {
    return json_of(JSON("cpu", bench_quartiles(q[BENCH_CPU])), JSON("wall", bench_quartiles(q[BENCH_WALL])));
}

void bench_print_slope(const json_t *slope, const json_t *half, int width) {
    char text[48] = "-";
    if (json_is_number(slope) && json_is_number(half))
        snprintf(text, sizeof text, "%.3f +- %.3f", json_number_value(slope), json_number_value(half));
    else if (json_is_number(slope))
        snprintf(text, sizeof text, "%.3f", json_number_value(slope));
    printf("  %*s", width, text);
}

/* ---- progress ---- */

/* Before this fraction of the work, or this many seconds, an estimate is too uncertain. */
#define SURE_FRACTION 0.01
#define SURE_SECONDS 5.0

static struct {
    double began; /* start of measuring; 0: not started */
    bool estimated;
} state;

static void progress_start(bool quiet) {
    state.began = 0;
    state.estimated = false;
    progress_begin(quiet, "measure");
    progress_phase(FATHOM_PHASE_READ);
}

void bench_progress_tell(void *unused, double fraction) {
    (void)unused;
    if (state.began <= 0) state.began = clock_seconds();
    const double seconds = clock_seconds() - state.began;
    if (!state.estimated && fraction > 0 && (fraction >= SURE_FRACTION || seconds >= SURE_SECONDS)) {
        state.estimated = true;
        progress_estimate(seconds / fraction);
    }
    progress_work(state.began, fraction, 0);
}

bench_watch bench_progress_part(double from, double to) {
    return (bench_watch){bench_progress_tell, NULL, from, to};
}

/* ---- running ---- */

static fathom_status measure_and_write(fathom_context *context, const bench_settings *asked, json_t *root) {
    const fathom_status measured = asked->measure(context, asked, root);
    progress_clear_line();
    fflush(stdout);
    const bool partial = measured == FATHOM_INTERRUPTED && json_is_true(json_object_get(root, "interrupted"));
    if (measured != FATHOM_OK && !partial) return measured;
    if (json_memory_lacked()) return fail_memory(context, 4096); /* some results are missing */
    const fathom_status written = write_outputs(context, asked, root);
    return written == FATHOM_OK ? measured : written;
}

fathom_status bench_run(fathom_context *context, void *settings) {
    const bench_settings *asked = settings;
    const char *const files[] = {asked->json, asked->csv};
    fathom_status status = report_check_files(context, files, asked->report, asked->scene);
    if (status == FATHOM_OK) {
        progress_start(asked->common.quiet);
        json_t *root = head(asked->command->name + strlen("bench "));
        status = measure_and_write(context, asked, root);
        json_decref(root);
    }
    return say_status(asked->command, context, status);
}

/* ---- scenes ---- */

fathom_status bench_open(fathom_context *context, const bench_settings *asked, bool classic,
                         bench_stage *out) {
    fathom_scene *scene;
    fathom_settings settings;
    const args_size size = asked->size;
    *out = (bench_stage){.scene = NULL};
    const fathom_read_options read = {.size = sizeof read,
                                      .width = size.width,
                                      .height = size.height,
                                      .choose_integrator = classic,
                                      .integrator = FATHOM_INTEGRATOR_CLASSIC,
                                      .own_spp = true};
    fathom_status status = fathom_scene_read_with(context, asked->scene, &read, &scene);
    if (status != FATHOM_OK) return status;
    fathom_scene_settings(scene, &settings);
    settings.spp = 1;
    settings.target_error = settings.max_time = 0;
    if (size.width) settings.width = size.width, settings.height = size.height;
    return stage_open(context, scene, &settings, out);
}

fathom_status bench_sphere(fathom_context *context, uint64_t triangles, fathom_scene **out) {
    fathom_generate_options options;
    fathom_generate_options_default(&options);
    options.triangles = triangles;
    *out = NULL;
    fathom_status status = fathom_scene_create(context, out);
    return status == FATHOM_OK ? fathom_scene_generate(*out, FATHOM_ROOT, &options) : status;
}

const command *const benches[] = {&command_bench_trace, &command_bench_render, &command_bench_error, NULL};

static fathom_status run(int argc, char **argv) {
    if (argc < 2) return say_usage(&command_bench, "bench: expected what to measure: trace, render or error");
    args_problem problem;
    const command *found = command_find(benches, argv[1], &problem);
    if (found) return command_run(found, argc - 1, argv + 1);
    if (args_ask_help(argc, argv)) {
        help_command(&command_bench, stdout);
        return FATHOM_OK;
    }
    return say_usage(&command_bench, problem.text);
}

const command command_bench = {
    .name = "bench",
    .usage = "WHAT [SCENE] [options]",
    .summary = "Measure speed, and error against time.",
    .text = "WHAT is one of\n"
            "  trace   rays per second of every tracer\n"
            "  render  the phases of a render, its distance from Embree's ceiling, and how\n"
            "          all of them grow with the triangles\n"
            "  error   image error against run time\n"
            "fathom help bench WHAT tells more.\n",
    .run = run};
