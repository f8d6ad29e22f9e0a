#include "write/write_form.h"

#include "write/write.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const form *form_variant(const form *f, int id) {
    const form *const *variant = f->variants;
    while (*variant && (*variant)->id != id) ++variant;
    return *variant;
}

/* ---- which keys ---- */

static size_t numbers_in(const form_key *key) {
    return (size_t)(key->count ? key->count : 1) * (key->rows ? key->rows : 1);
}

static bool differs(const form_key *key, const void *values, const void *usual);

static bool any_differs(const form *f, const void *values, const void *usual) {
    for (const form_key *const *part = f->parts; *part; ++part) {
        for (const form_key *key = *part; key->name; ++key) {
            if (differs(key, values, usual)) return true;
        }
    }
    return false;
}

static bool differs(const form_key *key, const void *values, const void *usual) {
    const char *value = (const char *)values + key->offset, *other = (const char *)usual + key->offset;
    switch (key->kind) {
    case FORM_BOOL: return *(const bool *)value != *(const bool *)other;
    case FORM_U32:
    case FORM_F32:
    case FORM_WORD:
    case FORM_WORDS: return memcmp(value, other, 4 * numbers_in(key)) != 0;
    case FORM_U64:
    case FORM_F64: return memcmp(value, other, 8 * numbers_in(key)) != 0;
    case FORM_TEXT: return *(const char *const *)(const void *)value != NULL;
    case FORM_OBJECT: return any_differs(key->form, value, other);
    case FORM_TAG:
    case FORM_ROWS:
    case FORM_LIST:
    case FORM_MAP:
    case FORM_MAP_OF_LISTS: return false;
    }
    return false;
}

static bool named_differs(const form *f, const char *name, const void *values, const void *usual) {
    const form_key *key = form_find(f, name);
    return key && differs(key, values, usual);
}

/* True if an image raises the parameter towards 1. */
static bool is_raised(const form *f, const char *name, const void *values) {
    char image[64];
    snprintf(image, sizeof image, "%sTexture", name);
    const form_key *key = form_find(f, image);
    if (!key || key->kind != FORM_OBJECT) return false;
    const form_texture_values *v = (const void *)((const char *)values + key->offset);
    return v->file && v->inverted;
}

/* True if the keys that this key needs, or has no effect without, are written. */
static bool has_needed(const form *f, const form_key *key, const void *values, const void *usual) {
    for (const form_rule *const *part = f->rules; *part; ++part) {
        for (const form_rule *rule = *part; rule->kind != FORM_NO_RULE; ++rule) {
            const bool one = rule->kind == FORM_WANTS_ONE_OF,
                       all = rule->kind == FORM_NEEDS || rule->kind == FORM_WANTS;
            size_t count = 0, written = 0;
            if (!(one || all) || strcmp(rule->key, key->name) != 0) continue;
            for (const char *const *other = rule->others; *other; ++other, ++count)
                written += named_differs(f, *other, values, usual) || is_raised(f, *other, values);
            if (all ? written < count : !written) return false;
        }
    }
    return true;
}

/* Factors that are divided out and multiplied in again round some numbers four times. */
static bool changes(const form_key *key, const void *before, const void *after) {
    const float *a = (const float *)(const void *)((const char *)before + key->offset);
    const float *b = (const float *)(const void *)((const char *)after + key->offset);
    if (key->kind != FORM_F32) return differs(key, before, after);
    for (size_t i = 0; i < numbers_in(key); ++i) {
        if (!(fabsf(a[i] - b[i]) <= 4 * 0x1p-24f * fmaxf(fabsf(a[i]), fabsf(b[i])))) return true;
    }
    return false;
}

void form_note_changes(const form *f, const void *before, const void *after, const void *usual,
                       const char *format, note_list *notes) {
    for (const form_key *const *part = f->parts; *part; ++part) {
        for (const form_key *key = *part; key->name; ++key) {
            if (key->kind < FORM_TEXT && has_needed(f, key, before, usual) && changes(key, before, after))
                notes_add(notes, 1, "", "%s cannot hold \"%s\" of a material; it changes", format, key->name);
        }
    }
}

/* ---- text ---- */

/* The fewest digits, at least 6, that read back as the same number, or as the same float. */
static void put_shortest(file_writer *t, double number, bool single) {
    char text[40];
    for (int digits = 6; digits <= (single ? 9 : 17); ++digits) {
        snprintf(text, sizeof text, "%.*g", digits, number);
        if (single ? strtof(text, NULL) == (float)number : strtod(text, NULL) == number) break;
    }
    file_writer_print(t, "%s", text);
}

void form_put_number(file_writer *t, double number) { put_shortest(t, number, false); }

double form_nearest(const form_key *key, double number, bool single) {
    const double low = key->range.low, high = key->range.high;
    if ((low == 0 && high == 0) || (number >= low && number <= high)) return number;
    const double near = number < low ? low : high;
    if (!single) return near;
    const float rounded = (float)near;
    if ((double)rounded > high) return (double)nextafterf(rounded, -INFINITY);
    return (double)((double)rounded < low ? nextafterf(rounded, INFINITY) : rounded);
}

void form_note_nearest(const form_key *key, size_t changed, note_list *notes) {
    notes_add(notes, changed, "", "scene JSON has \"%s\" in [%.9g, %.9g]; the nearest number is written",
              key->name, key->range.low, key->range.high);
}

static double limit(const form_key *key, double number, bool single, note_list *notes) {
    const double near = form_nearest(key, number, single);
    form_note_nearest(key, near != number, notes);
    return near;
}

static void put_one(file_writer *t, const form_key *key, const char *value, size_t i, note_list *notes) {
    const void *at = value;
    uint64_t whole;
    switch (key->kind) {
    case FORM_U32: file_writer_print(t, "%u", ((const uint32_t *)at)[i]); break;
    case FORM_U64:
        whole = ((const uint64_t *)at)[i];
        if ((double)whole > key->range.high) whole = (uint64_t)limit(key, (double)whole, false, notes);
        file_writer_print(t, "%llu", (unsigned long long)whole);
        break;
    case FORM_F32: put_shortest(t, limit(key, (double)((const float *)at)[i], true, notes), true); break;
    case FORM_F64: form_put_number(t, limit(key, ((const double *)at)[i], false, notes)); break;
    case FORM_BOOL:
    case FORM_WORD:
    case FORM_WORDS:
    case FORM_TEXT:
    case FORM_TAG:
    case FORM_OBJECT:
    case FORM_ROWS:
    case FORM_LIST:
    case FORM_MAP:
    case FORM_MAP_OF_LISTS: break;
    }
}

void form_put_numbers(file_writer *t, const form_key *key, const void *value, note_list *notes) {
    const size_t count = numbers_in(key);
    for (size_t i = 0; i < count; ++i) {
        const bool opens = key->rows && i % key->count == 0;
        file_writer_print(t, "%s%s", i ? "," : key->count ? "[" : "", opens ? "[" : "");
        put_one(t, key, value, i, notes);
        if (key->rows && i % key->count == key->count - 1) file_writer_print(t, "]");
    }
    if (key->count) file_writer_print(t, "]");
}

/* The word at a place in "a|b|c". */
static void put_word(file_writer *t, const char *words, uint32_t place) {
    while (place--) words = strchr(words, '|') + 1;
    file_writer_print(t, "\"%.*s\"", (int)strcspn(words, "|"), words);
}

static void put_words(file_writer *t, const char *words, uint32_t bits) {
    const char *comma = "[";
    file_writer_print(t, bits ? "" : "[");
    for (uint32_t i = 0; i < 32; ++i) {
        if (!(bits >> i & 1)) continue;
        file_writer_print(t, "%s", comma);
        put_word(t, words, i);
        comma = ",";
    }
    file_writer_print(t, "]");
}

static void put_value(file_writer *t, const form *f, const form_key *key, const void *values,
                      const void *usual, note_list *notes) {
    const char *value = (const char *)values + key->offset;
    uint32_t word;
    switch (key->kind) {
    case FORM_BOOL: file_writer_print(t, *(const bool *)value ? "true" : "false"); break;
    case FORM_U32:
    case FORM_U64:
    case FORM_F32:
    case FORM_F64: form_put_numbers(t, key, value, notes); break;
    case FORM_WORD:
    case FORM_WORDS:
        memcpy(&word, value, sizeof word);
        if (key->kind == FORM_WORD)
            put_word(t, key->words, word);
        else
            put_words(t, key->words, word);
        break;
    case FORM_TEXT: write_quoted(t, *(const char *const *)(const void *)value); break;
    case FORM_TAG: write_quoted(t, f->name); break;
    case FORM_OBJECT:
        file_writer_print(t, "{");
        form_put(t, key->form, value, (const char *)usual + key->offset, notes);
        file_writer_print(t, "}");
        break;
    case FORM_ROWS:
    case FORM_LIST:
    case FORM_MAP:
    case FORM_MAP_OF_LISTS: break;
    }
}

void form_put(file_writer *t, const form *f, const void *values, const void *usual, note_list *notes) {
    const char *comma = "";
    for (const form_key *const *part = f->parts; *part; ++part) {
        for (const form_key *key = *part; key->name; ++key) {
            const bool listed = key->kind >= FORM_ROWS;
            const bool given = key->required || key->kind == FORM_TAG || differs(key, values, usual);
            if (listed || !given || !has_needed(f, key, values, usual)) continue;
            file_writer_print(t, "%s\"%s\":", comma, key->name);
            put_value(t, f, key, values, usual, notes);
            comma = ",";
        }
    }
}
