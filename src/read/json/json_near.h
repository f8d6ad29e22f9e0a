/* The name that was meant by a misspelt one. */
#ifndef READ_JSON_NEAR_H
#define READ_JSON_NEAR_H

#include <stddef.h>

typedef struct near_search {
    const char *wanted, *best; /* best: NULL while nothing is near enough */
    size_t distance;
} near_search;

near_search near_begin(const char *wanted);
/* Candidates with equal distance: the first one stays. */
void near_offer(near_search *search, const char *candidate);

#endif
