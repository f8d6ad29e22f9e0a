#include "read/json/json_near.h"

#include <ctype.h>
#include <stdbool.h>
#include <string.h>

/* Longer names are not compared. */
enum { NEAR_LENGTH = 64 };

static size_t least(size_t a, size_t b) { return a < b ? a : b; }

static bool alike(char a, char b) { return tolower((unsigned char)a) == tolower((unsigned char)b); }

/* The number of letters to change, add, remove or swap with their neighbour (optimal string alignment
 * distance), ignoring case. Three rows of its table suffice. */
static size_t edit_distance(const char *a, const char *b) {
    size_t rows[3][NEAR_LENGTH + 1], length = strlen(b);
    size_t *before = rows[0], *last = rows[1], *row = rows[2];
    for (size_t j = 0; j <= length; ++j) row[j] = j;
    for (size_t i = 1; i <= strlen(a); ++i) {
        size_t *spare = before;
        before = last, last = row, row = spare;
        row[0] = i;
        for (size_t j = 1; j <= length; ++j) {
            size_t changed = last[j - 1] + (alike(a[i - 1], b[j - 1]) ? 0u : 1u);
            row[j] = least(changed, least(row[j - 1], last[j]) + 1);
            bool swapped = i > 1 && j > 1 && alike(a[i - 1], b[j - 2]) && alike(a[i - 2], b[j - 1]);
            if (swapped) row[j] = least(row[j], before[j - 2] + 1);
        }
    }
    return row[length];
}

near_search near_begin(const char *wanted) {
    /* Allows a third of the letters to be wrong, but at least one. */
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
