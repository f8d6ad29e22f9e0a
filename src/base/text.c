#include "base/text.h"

#include <ctype.h>
#include <stdbool.h>
#include <string.h>

size_t text_character(const char *at, unsigned *code) {
    const unsigned char *text = (const unsigned char *)at;
    static const unsigned least[] = {0, 0, 0x80, 0x800, 0x10000};
    const unsigned char lead = *text;
    const size_t length = lead < 0x80   ? 1
                          : lead < 0xc0 ? 0
                          : lead < 0xe0 ? 2
                          : lead < 0xf0 ? 3
                          : lead < 0xf8 ? 4
                                        : 0;
    *code = length < 2 ? lead : lead & (0x7fu >> length);
    for (size_t i = 1; i < length; ++i) {
        if ((text[i] & 0xc0) != 0x80) return 0; /* also at the end of the text */
        *code = *code << 6 | (text[i] & 0x3fu);
    }
    const bool surrogate = *code >= 0xd800 && *code < 0xe000;
    return *code < least[length] || *code > 0x10ffff || surrogate ? 0 : length;
}

locale_t text_locale_begin(void) { return uselocale(newlocale(LC_ALL_MASK, "C", (locale_t)0)); }

void text_locale_end(locale_t own) { freelocale(uselocale(own)); }

/* True if the character could control a terminal or reorder text. */
static bool steers(unsigned code) {
    return code < ' ' || (code >= 0x7f && code < 0xa0) || code == 0x61c || code == 0x200e || code == 0x200f ||
           (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
}

void text_disarm(char *text) {
    while (*text) {
        unsigned code;
        size_t length = text_character(text, &code);
        const bool harmless = length && !steers(code);
        if (!length) length = 1;
        if (!harmless) memset(text, '?', length);
        text += length;
    }
}

const char *words_at(const char *words, unsigned i, size_t *length) {
    for (;; ++words) {
        *length = strcspn(words, "|");
        if (i-- == 0) return words;
        words += *length;
        if (!*words) return NULL;
    }
}

int words_find(const char *words, const char *word, size_t length) {
    size_t found;
    const char *at;
    for (unsigned i = 0; (at = words_at(words, i, &found)); ++i)
        if (found == length && strncmp(at, word, length) == 0) return (int)i;
    return -1;
}

/* ---- the nearest name ---- */

/* Longer names are not compared. */
enum { NEAR_LENGTH = 64 };

static size_t least(size_t a, size_t b) { return a < b ? a : b; }

static bool alike(char a, char b) { return tolower((unsigned char)a) == tolower((unsigned char)b); }

/* The minimum number of edits, ignoring case: to change, add or remove a letter, or to swap two neighbours
 * (optimal string alignment distance). Three rows of its table suffice. */
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

text_search text_search_begin(const char *wanted) {
    size_t length = strlen(wanted);
    return (text_search){.wanted = wanted, .distance = (length < 6 ? 1 : length / 3) + 1};
}

void text_search_offer(text_search *search, const char *candidate) {
    if (strlen(search->wanted) > NEAR_LENGTH || strlen(candidate) > NEAR_LENGTH) return;
    size_t distance = edit_distance(search->wanted, candidate);
    if (distance >= search->distance) return;
    search->distance = distance;
    search->best = candidate;
}
