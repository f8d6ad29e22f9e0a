/* Finds the known name nearest to a misspelt one. */
#ifndef READ_JSON_NEAR_H
#define READ_JSON_NEAR_H

#include <stddef.h>

typedef struct near_search {
    const char *wanted, *best; /* best: NULL while nothing is near enough */
    size_t distance;
} near_search;

near_search near_begin(const char *wanted);
/* The first of several candidates at equal distance wins. */
void near_offer(near_search *search, const char *candidate);

#endif
