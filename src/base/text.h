/* Text from files and users. */
#ifndef BASE_TEXT_H
#define BASE_TEXT_H

#include <stddef.h>

/* The length in bytes of the UTF-8 character at `text`, and its code; 0 when there is none. */
size_t text_character(const char *text, unsigned *code);

/* Puts '?' for each byte that could steer a terminal or look like other text: control characters (C0 and C1),
 * Unicode's line ends and direction marks, and bytes that are not UTF-8. */
void text_disarm(char *text);

/* The part of "a|b|c" that is `word`, or -1. */
int words_find(const char *words, const char *word, size_t length);
/* Part i of "a|b|c" and its length; NULL behind the last. */
const char *words_at(const char *words, unsigned i, size_t *length);

/* The known name nearest to one that was misspelt: at most a third of its letters differ, whatever their
 * case, and at least one may. Offer each; `best` is the first of the nearest, or NULL. */
typedef struct text_search {
    const char *wanted, *best;
    size_t distance;
} text_search;

text_search text_search_begin(const char *wanted);
void text_search_offer(text_search *search, const char *candidate);

#endif
