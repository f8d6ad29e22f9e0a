#include "cli/bench/bench_output.h"

#include "base/file.h"
#include "base/threads.h"
#include "cli/json_text.h"
#include "cli/machine.h"
#include "cli/render/outputs.h"
#include "cli/report.h"
#include "cli/standard_output.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

fathom_status bench_output_check(fathom_context *context, const bench_output *output, const char *input) {
    char paths[REPORT_FILES][PATH_MAX];
    const char *files[2 + REPORT_FILES];
    const char *const asked[] = {output->json, output->csv};
    size_t count = 0;
    fathom_status status = standard_output_begin(context, &(args_list){.count = 0}, asked, 2);
    for (int i = 0; i < 2; ++i) {
        if (asked[i] && !standard_output_is_named(asked[i])) files[count++] = asked[i];
    }
    for (size_t i = 0; i < count && status == FATHOM_OK; ++i) {
        status = file_check_writable(context, files[i]);
    }
    if (status == FATHOM_OK && output->report) status = report_check(context, output->report);
    if (output->report) {
        report_paths(output->report, paths[0], paths[1]);
        files[count++] = paths[0], files[count++] = paths[1];
    }
    return status == FATHOM_OK ? outputs_check_distinct(context, files, count, input) : status;
}

static json_t *pack_machine(void) {
    char cpu[128];
    double load[3] = {NAN, NAN, NAN};
    machine_cpu(cpu, sizeof cpu);
    json_t *machine = json_pack("{s:o, s:o, s:s, s:s, s:s}", "cpu", json_text(cpu), "processors",
                                json_count(processor_count()), "kernels", machine_kernels(), "compiler",
                                machine_compiler(), "flags", machine_flags());
    if (getloadavg(load, 3) > 0) json_object_set_new(machine, "load", json_real(load[0]));
    return machine;
}

json_t *bench_head(const char *what) {
    char date[16];
    machine_date(date);
    const char *commit = fathom_commit();
    return json_pack("{s:s, s:s, s:o, s:s, s:o}", "bench", what, "fathom", fathom_version(), "commit",
                     *commit ? json_string(commit) : json_null(), "date", date, "machine", pack_machine());
}

void bench_head_tracer(json_t *root, const char *tracer_name) {
    if (strncmp(tracer_name, "Embree ", 7) != 0) return;
    json_object_set_new(json_object_get(root, "machine"), "embree", json_string(tracer_name + 7));
}

json_t *bench_quartiles(quartiles q) {
    return json_pack("{s:f, s:f, s:f}", "low", q.low, "median", q.median, "high", q.high);
}

json_t *bench_clocks(const quartiles q[BENCH_CLOCKS]) {
    return json_pack("{s:o, s:o}", "cpu", bench_quartiles(q[BENCH_CPU]), "wall",
                     bench_quartiles(q[BENCH_WALL]));
}

double bench_number(const json_t *object, const char *key, const char *inner) {
    const json_t *value = json_object_get(object, key);
    if (inner) value = json_object_get(value, inner);
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

void bench_csv_text(FILE *out, const char *text) {
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

/* ---- files ---- */

static void put_facts(FILE *out, const json_t *root) {
    const char *key;
    const json_t *value;
    const json_t *machine = json_object_get(root, "machine");
    fprintf(out, "# fathom bench %s, fathom %s", json_string_value(json_object_get(root, "bench")),
            json_string_value(json_object_get(root, "fathom")));
    const char *commit = json_string_value(json_object_get(root, "commit"));
    if (commit) fprintf(out, ", commit %s", commit);
    fprintf(out, ", %s\n", json_string_value(json_object_get(root, "date")));
    for (void *i = json_object_iter((json_t *)machine); i; i = json_object_iter_next((json_t *)machine, i)) {
        key = json_object_iter_key(i), value = json_object_iter_value(i);
        if (json_is_string(value))
            fprintf(out, "# %s: %s\n", key, json_string_value(value));
        else
            fprintf(out, "# %s: %g\n", key, json_number_value(value));
    }
}

static fathom_status write_csv(fathom_context *context, const char *path, const json_t *root,
                               void (*put_csv)(FILE *out, const json_t *root)) {
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    if (!out) return fail_memory(context, 4096);
    put_facts(out, root);
    put_csv(out, root);
    fathom_status status = FATHOM_OK;
    if (fclose(out) != 0) status = fail_memory(context, size);
    if (status == FATHOM_OK) status = outputs_write(context, path, text, size);
    free(text);
    return status;
}

fathom_status bench_output_write(fathom_context *context, const bench_output *output, const json_t *root,
                                 void (*put_csv)(FILE *out, const json_t *root)) {
    fathom_status status = FATHOM_OK;
    if (output->json) status = json_write_file(context, output->json, root);
    if (status == FATHOM_OK && output->csv) status = write_csv(context, output->csv, root, put_csv);
    if (status == FATHOM_OK && output->report) status = report_write(context, output->report, root);
    return status;
}
