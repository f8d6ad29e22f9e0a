#include "cli/bench/bench_growth.h"

#include "cli/bench/bench_output.h"
#include "cli/json_text.h"
#include "measure/growth.h"

#include <math.h>
#include <stdlib.h>

/* A mesh of less fits into caches, and calls of threads outweigh the work on the smallest. */
#define HEAVY 0.9e6

typedef struct series {
    const char *name, *key, *inner, *words;
} series;

static const series all_series[] = {
    {"read", "readSeconds", "cpu", "reading"},
    {"build", "buildSeconds", "cpu", "building"},
    {"render", "renderCpuSeconds", NULL, "render phase"},
    {"bare", "bareCpuSeconds", NULL, "bare calls"},
    {"renderToBare", "renderToBare", NULL, "render over bare"},
};
#define SERIES (sizeof all_series / sizeof *all_series)

static double median(const json_t *run, const series *s) {
    const json_t *value = json_object_get(run, s->key);
    return bench_number(s->inner ? json_object_get(value, s->inner) : value, "median", NULL);
}

static json_t *pack_fit(const json_t *runs, const series *s, double least) {
    size_t room = json_array_size(runs), count = 0, i;
    double *x = malloc(2 * (room + 1) * sizeof *x);
    if (!x) return json_null();
    json_t *run;
    json_array_foreach(runs, i, run) {
        if (bench_number(run, "triangles", NULL) < least) continue;
        x[count] = bench_number(run, "triangles", NULL), x[room + count++] = median(run, s);
    }
    growth_fit fit = growth_fit_of(x, x + room, count);
    free(x);
    if (!isfinite(fit.exponent)) return json_null();
    return json_pack("{s:f, s:o, s:f, s:o}", "exponent", fit.exponent, "half",
                     isfinite(fit.half) ? json_real(fit.half) : json_null(), "scale", fit.scale, "sizes",
                     json_count(fit.count));
}

void bench_growth_fit(json_t *root) {
    json_t *fits = json_object();
    const json_t *runs = json_object_get(root, "runs");
    for (size_t i = 0; i < SERIES; ++i) {
        const series *s = &all_series[i];
        json_object_set_new(
            fits, s->name,
            json_pack("{s:o, s:o}", "all", pack_fit(runs, s, 0), "heavy", pack_fit(runs, s, HEAVY)));
    }
    json_object_set_new(root, "fits", fits);
}

static void print_fit(const json_t *fit) {
    char text[48] = "-";
    double half = bench_number(fit, "half", NULL);
    if (json_is_object(fit) && isfinite(half))
        snprintf(text, sizeof text, "%.3f +- %.3f", bench_number(fit, "exponent", NULL), half);
    else if (json_is_object(fit))
        snprintf(text, sizeof text, "%.3f", bench_number(fit, "exponent", NULL));
    printf("  %-18s", text);
}

void bench_growth_print(const json_t *root) {
    printf("\n%-18s  %-18s  %s\n", "seconds ~ triangles", "exponent, all", "from a million on");
    for (size_t i = 0; i < SERIES; ++i) {
        const json_t *fit = json_object_get(json_object_get(root, "fits"), all_series[i].name);
        printf("%-18s", all_series[i].words);
        print_fit(json_object_get(fit, "all"));
        print_fit(json_object_get(fit, "heavy"));
        putchar('\n');
    }
}

void bench_growth_csv(FILE *out, const json_t *root) {
    fputs("triangles,file_bytes,bvh_bytes,bvh_peak_bytes,read_cpu_seconds,read_seconds,build_cpu_seconds,"
          "build_seconds,rays,render_cpu_seconds,bare_cpu_seconds,render_to_bare_low,render_to_bare_median,"
          "render_to_bare_high\n",
          out);
    size_t i;
    json_t *run;
    json_array_foreach(json_object_get(root, "runs"), i, run) {
        static const char *const counts[] = {"triangles", "fileBytes", "bvhBytes", "bvhPeakBytes"};
        for (int k = 0; k < 4; ++k) fprintf(out, "%.0f,", bench_number(run, counts[k], NULL));
        static const char *const phases[] = {"readSeconds", "buildSeconds"};
        for (int k = 0; k < 2; ++k) {
            const json_t *clocks = json_object_get(run, phases[k]);
            fprintf(out, "%.6g,%.6g,", bench_number(clocks, "cpu", "median"),
                    bench_number(clocks, "wall", "median"));
        }
        fprintf(out, "%.0f,%.6g,%.6g,%.5g,%.5g,%.5g\n", bench_number(run, "rays", NULL),
                bench_number(run, "renderCpuSeconds", "median"),
                bench_number(run, "bareCpuSeconds", "median"), bench_number(run, "renderToBare", "low"),
                bench_number(run, "renderToBare", "median"), bench_number(run, "renderToBare", "high"));
    }
}
