/* What the files of `fathom bench error` share. */
#ifndef CLI_BENCH_ERROR_H
#define CLI_BENCH_ERROR_H

#include "cli/bench/bench_output.h"
#include "measure/converge.h"

typedef struct bench_error_settings {
    const char *scene, *tracer;
    args_size size;
    uint32_t seeds, max_spp, half_spp; /* half_spp 0: four times max_spp */
    uint64_t seed;
    double ppd;
    unsigned threads;
    bool quiet;
    bench_output output;
    bool allow_outside;
} bench_error_settings;

/* ---- bench_error_json.c ---- */
json_t *bench_error_json(const bench_error_settings *asked, const bench_stage *stage,
                         const converge_result *result);
void bench_error_csv(FILE *out, const json_t *root);

/* ---- bench_error_print.c ---- */
void bench_error_print(const bench_error_settings *asked, const bench_stage *stage,
                       const converge_result *result);

#endif
