/* Text from files and users. */
#pragma once

#include <locale.h>
#include <stddef.h>

/* Decodes the UTF-8 character at `text` to *code. Returns its length in bytes, or 0 if the bytes are not
 * valid UTF-8. */
size_t text_character(const char *text, unsigned *code);

/* Replaces by '?' each byte that could control a terminal or imitate other text: control characters (C0 and
 * C1), Unicode's line ends and direction marks, and bytes that are not UTF-8. */
void text_disarm(char *text);

/* Gives this thread the C locale, whose numbers have a decimal point whatever the process has chosen. Returns
 * the thread's own, which text_locale_end() gives back. */
locale_t text_locale_begin(void);
void text_locale_end(locale_t own);

/* The index of `word` among the parts of "a|b|c", or -1. */
int words_find(const char *words, const char *word, size_t length);
/* Part i of "a|b|c" and its length; NULL after the last. */
const char *words_at(const char *words, unsigned i, size_t *length);

/* Finds the known name that is nearest to a misspelt one, ignoring case. It may differ in up to a third of
 * the letters, and in one letter of a short name. Offer each known name; `best` is then the nearest one, the
 * first of several, or NULL. */
typedef struct text_search {
    const char *wanted, *best;
    size_t distance;
} text_search;

text_search text_search_begin(const char *wanted);
void text_search_offer(text_search *search, const char *candidate);
