#include "cli/bench/bench_error.h"
#include "cli/command.h"

#include <math.h>

static const char *const titles[CONVERGE_METRICS] = {"RMSE", "relMSE", "FLIP"};

static void print_head(const bench_error_settings *asked, const bench_stage *stage,
                       const converge_result *result) {
    const converge_reference *r = &result->reference;
    print_name(stdout, asked->scene);
    printf(", %ux%u, %s\n", stage->settings.width, stage->settings.height, trace_name(stage->tracer));
    printf("rendering alone is timed; the build took %.3f s of CPU time, %.3f s by the clock\n",
           stage->build.by[BENCH_CPU], stage->build.by[BENCH_WALL]);
    printf("reference: two halves of %u samples a pixel, sobol; its own RMSE %.3g, relMSE %.3g, FLIP at most "
           "%.3g\n",
           r->spp, r->own[CONVERGE_RMSE], r->own[CONVERGE_RELMSE], r->own[CONVERGE_FLIP]);
    uint64_t nonfinite = r->nonfinite;
    for (size_t i = 0; i < result->runs.count; ++i) nonfinite += result->runs.items[i].nonfinite;
    printf("pixels that are not finite: %llu\n", (unsigned long long)nonfinite);
}

static void print_points(const converge_result *result) {
    printf("\n%-10s %6s %10s %10s  %10s  %10s  %10s   medians and geometric means of %u seeds\n", "pattern",
           "spp", "cpu s", "clock s", titles[0], titles[1], titles[2], result->rounds);
    bool marked = false;
    for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p) {
        for (unsigned step = 0; step < result->steps; ++step) {
            const converge_point *point = &result->curves[p].points[step];
            printf("%-10s %6u %10.4g %10.4g", converge_pattern_name((fathom_pattern)p), point->spp,
                   point->seconds.by[BENCH_CPU], point->seconds.by[BENCH_WALL]);
            for (int m = 0; m < CONVERGE_METRICS; ++m) {
                printf("  %9.3g%c", point->errors[m], point->below[m] ? '*' : ' ');
                marked |= point->below[m];
            }
            putchar('\n');
        }
    }
    if (marked)
        puts("* closer to the reference than its halves are to each other: in no slope or table below");
}

static void print_slope(const converge_slope *s) {
    char text[40] = "-";
    if (isfinite(s->slope.mean) && isfinite(s->slope.half))
        snprintf(text, sizeof text, "%.3f +- %.3f", s->slope.mean, s->slope.half);
    else if (isfinite(s->slope.mean))
        snprintf(text, sizeof text, "%.3f", s->slope.mean);
    printf("  %18s", text);
}

static void print_slopes(const converge_result *result) {
    static const char *const clocks[BENCH_CLOCKS] = {"cpu", "clock"};
    printf("\nslope of ln error over ln seconds, and its 95 %% interval over seeds\n%-10s %6s  %18s  %18s  "
           "%18s\n",
           "pattern", "time", titles[0], titles[1], titles[2]);
    for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p) {
        for (int c = 0; c < BENCH_CLOCKS; ++c) {
            printf("%-10s %6s", converge_pattern_name((fathom_pattern)p), clocks[c]);
            for (int m = 0; m < CONVERGE_METRICS; ++m) print_slope(&result->curves[p].slopes[m][c]);
            putchar('\n');
        }
    }
}

static void print_rows(const char *title, const char *at, const converge_row *rows, size_t count) {
    printf("\n%s\n%12s", title, at);
    for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p)
        printf(" %11s", converge_pattern_name((fathom_pattern)p));
    putchar('\n');
    if (!count) puts("  the patterns have nothing in common here");
    for (size_t i = 0; i < count; ++i) {
        printf("%12.3g", rows[i].at);
        for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p) printf(" %11.3g", rows[i].values[p]);
        putchar('\n');
    }
}

void bench_error_print(const bench_error_settings *asked, const bench_stage *stage,
                       const converge_result *result) {
    print_head(asked, stage, result);
    print_points(result);
    print_slopes(result);
    converge_row rows[CONVERGE_ROWS];
    for (int m = 0; m < CONVERGE_METRICS; ++m) {
        char title[80];
        size_t count = converge_equal_time(result, (converge_metric)m, rows);
        snprintf(title, sizeof title, "%s in equal time", titles[m]);
        print_rows(title, "cpu s", rows, count);
        count = converge_equal_error(result, (converge_metric)m, rows);
        snprintf(title, sizeof title, "seconds of CPU time for equal %s", titles[m]);
        print_rows(title, titles[m], rows, count);
    }
}
