/* What `fathom bench growth` makes of its runs. */
#ifndef CLI_BENCH_GROWTH_H
#define CLI_BENCH_GROWTH_H

#include <jansson.h>
#include <stdio.h>

/* Adds "fits": {"read", "build", "render", "bare", "renderToBare"}, each {"all", "heavy"} of {"exponent",
 * "half", "scale", "sizes"}, or null; heavy: of the sizes from a million on. Of processor seconds. */
void bench_growth_fit(json_t *root);
void bench_growth_print(const json_t *root);
void bench_growth_csv(FILE *out, const json_t *root);

#endif
