#include "read/json_near.h"

#include <ctype.h>
#include <string.h>

/* Longer names are not compared. */
enum { NEAR_LENGTH = 64 };

static size_t least(size_t a, size_t b) { return a < b ? a : b; }

/* Levenshtein's distance, with letters of either case alike. */
static size_t edit_distance(const char *a, const char *b) {
    size_t row[NEAR_LENGTH + 1], length = strlen(b);
    for (size_t j = 0; j <= length; ++j) row[j] = j;
    for (size_t i = 0; a[i]; ++i) {
        size_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t j = 0; j < length; ++j) {
            size_t change =
                diagonal + (tolower((unsigned char)a[i]) == tolower((unsigned char)b[j]) ? 0u : 1u);
            diagonal = row[j + 1];
            row[j + 1] = least(change, least(row[j], row[j + 1]) + 1);
        }
    }
    return row[length];
}

near_search near_begin(const char *wanted) {
    /* Up to a third of the letters may be wrong, and one always. */
    size_t length = strlen(wanted);
    return (near_search){.wanted = wanted, .distance = (length < 6 ? 1 : length / 3) + 1};
}

void near_offer(near_search *search, const char *candidate) {
    if (strlen(search->wanted) > NEAR_LENGTH || strlen(candidate) > NEAR_LENGTH) return;
    size_t distance = edit_distance(search->wanted, candidate);
    if (distance >= search->distance) return;
    search->distance = distance;
    search->best = candidate;
}
