#include "read/json/json_doc.h"

#include "base/parameter.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- errors and their places ---- */

enum { TEXT_ROOM = 512 };

const fathom_place *doc_place(const doc *d, const where *at, where_spot *spot) {
    where_path(at, spot->path, sizeof spot->path);
    spot->place = (fathom_place){.file = d->path, .line = where_find(d->text, at).line, .field = spot->path};
    return &spot->place;
}

void doc_warn(const doc *d, const where *at, const char *format, ...) {
    /* Finding the line of each takes a search of the text. */
    enum { MOST_WARNINGS = 20 };
    if (++*d->told == MOST_WARNINGS + 1) warn(d->context, "%s: further warnings are left out", d->path);
    if (*d->told > MOST_WARNINGS) return;
    where_spot spot;
    char text[2 * TEXT_ROOM];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    const fathom_place *place = doc_place(d, at, &spot);
    warn(d->context, "%s:%zu: %s: %s", place->file, place->line, place->field, text);
}

/* "min spp" becomes "minSpp". */
static void name_key(const char *field, char out[PARAMETER_NAME]) {
    char *to = out;
    for (const char *c = field; *c && to < out + PARAMETER_NAME - 1; ++c)
        if (*c != ' ') *to++ = c > field && c[-1] == ' ' ? (char)toupper((unsigned char)*c) : *c;
    *to = '\0';
}

fathom_status doc_within(const doc *d, const where *at, fathom_status status) {
    where_spot spot;
    char key[PARAMETER_NAME];
    const fathom_error *error = fathom_context_error(d->context);
    name_key(error->place->field, key);
    const where field = {at, key, 0};
    const bool named = !*error->place->file && *field.key && where_find(d->text, &field).whole;
    const fathom_place *place = doc_place(d, named ? &field : at, &spot);
    return named ? fail_at(d->context, status, place, "%s", error->text)
                 : fail_within(d->context, status, place);
}

fathom_status doc_expected(const doc *d, const where *at, json_t *value, const char *expected) {
    if (json_is_array(value))
        return doc_fail(d, at, "expected %s, found an array of %zu", expected, json_array_size(value));
    if (json_is_object(value)) return doc_fail(d, at, "expected %s, found an object", expected);
    where_place place = where_find(d->text, at);
    size_t most = 40;
    if (place.length <= most)
        return doc_fail(d, at, "expected %s, found %.*s", expected, (int)place.length, place.value);
    /* Does not cut a UTF-8 sequence. */
    while (((unsigned char)place.value[most] & 0xC0) == 0x80) --most;
    return doc_fail(d, at, "expected %s, found %.*s...", expected, (int)most, place.value);
}

/* The three texts together say what is expected. */
static fathom_status fail_kind(const doc *d, const where *at, json_t *value, const char *a, const char *b,
                               const char *c) {
    char text[TEXT_ROOM + 8];
    snprintf(text, sizeof text, "%s%s%s", a, b, c);
    return doc_expected(d, at, value, text);
}

/* ---- numbers ---- */

static void describe_range(form_range r, char *out, size_t room) {
    out[0] = '\0';
    bool open_low = r.open & FORM_OPEN_LOW, open_high = r.open & FORM_OPEN_HIGH;
    if (r.open & FORM_NO_ZERO) snprintf(out, room, " other than 0");
    if (r.low == 0 && r.high == 0) return;
    if (isinf(r.high))
        snprintf(out, room, " %s %.16g", open_low ? ">" : ">=", r.low);
    else
        snprintf(out, room, " in %c%.16g, %.16g%c", open_low ? '(' : '[', r.low, r.high,
                 open_high ? ')' : ']');
}

static bool is_whole(const form_key *key) {
    return key->kind == FORM_U32 || key->kind == FORM_U64 || key->whole;
}

static const char *meaning_of(const form_key *key) { return key->meaning ? key->meaning : ""; }

static fathom_status fail_number(const doc *d, const where *at, json_t *value, const form_key *key) {
    char range[80];
    describe_range(key->range, range, sizeof range);
    return fail_kind(d, at, value, is_whole(key) ? "an integer" : "a number", range, meaning_of(key));
}

static fathom_status fail_count(const doc *d, const where *at, json_t *value, const form_key *key,
                                unsigned rows) {
    char range[80], numbers[240], text[280];
    describe_range(key->range, range, sizeof range);
    snprintf(numbers, sizeof numbers, "%u %s%s%s%s", key->count, is_whole(key) ? "integer" : "number",
             key->count == 1 ? "" : "s", range, meaning_of(key));
    if (rows)
        snprintf(text, sizeof text, "an array of %u arrays of %s", rows, numbers);
    else
        snprintf(text, sizeof text, "an array of %s", numbers);
    return doc_expected(d, at, value, text);
}

static bool in_range(form_range r, double x) {
    if (r.low == 0 && r.high == 0) return !(r.open & FORM_NO_ZERO) || x != 0;
    if (r.open & FORM_OPEN_LOW ? !(x > r.low) : !(x >= r.low)) return false;
    return r.open & FORM_OPEN_HIGH ? x < r.high : x <= r.high;
}

static bool is_common_angle(double radians) {
    static const double degrees[] = {30, 40, 45, 50, 60, 75, 90, 120, 135, 180, 270, 360};
    for (size_t i = 0; i < sizeof degrees / sizeof *degrees; ++i)
        if (fabs(fabs(radians) * (180 / 3.14159265358979323846) / degrees[i] - 1) < 1e-3) return true;
    return false;
}

static void warn_unit(const doc *d, const where *at, const form_unit *unit, double x) {
    const bool within = fabs(x) >= unit->low && fabs(x) <= unit->high;
    if (x == 0) return;
    if (unit->name && !within) doc_warn(d, at, "expected %s; %g seems to be in another unit", unit->name, x);
    if (!unit->name && is_common_angle(x))
        doc_warn(d, at, "expected degrees; %g seems to be in radians, which are %.4g degrees", x,
                 x * (180 / 3.14159265358979323846));
}

/* `to`: NULL only checks the number; `place`: its index in the member's array. */
static fathom_status read_number(const doc *d, const where *at, json_t *value, const form_key *key, void *to,
                                 size_t place) {
    double x = json_number_value(value);
    if (!json_is_number(value) || !in_range(key->range, x) || (is_whole(key) && floor(x) != x))
        return fail_number(d, at, value, key);
    if (key->unit) warn_unit(d, at, key->unit, x);
    if (!to) return FATHOM_OK;
    if (key->kind == FORM_F32) ((float *)to)[place] = (float)x;
    if (key->kind == FORM_F64) ((double *)to)[place] = x;
    if (key->kind == FORM_U32) ((uint32_t *)to)[place] = (uint32_t)x;
    if (key->kind == FORM_U64) ((uint64_t *)to)[place] = (uint64_t)x;
    return FATHOM_OK;
}

static fathom_status read_row(const doc *d, const where *at, json_t *value, const form_key *key, void *to,
                              size_t place) {
    if (!json_is_array(value) || json_array_size(value) != key->count)
        return fail_count(d, at, value, key, 0);
    bool nonzero = false;
    for (size_t i = 0; i < key->count; ++i) {
        const where item = {at, NULL, i};
        json_t *number = json_array_get(value, i);
        fathom_status status = read_number(d, &item, number, key, to, place + i);
        if (status != FATHOM_OK) return status;
        nonzero = nonzero || json_number_value(number) != 0;
    }
    if (key->nonzero && !nonzero) return doc_fail(d, at, "expected numbers that are not all 0");
    return FATHOM_OK;
}

static fathom_status read_numbers(const doc *d, const where *at, json_t *value, const form_key *key,
                                  void *to) {
    if (!key->count) return read_number(d, at, value, key, to, 0);
    if (!key->rows) return read_row(d, at, value, key, to, 0);
    if (!json_is_array(value) || json_array_size(value) != key->rows)
        return fail_count(d, at, value, key, key->rows);
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < key->rows && status == FATHOM_OK; ++i) {
        const where row = {at, NULL, i};
        status = read_row(d, &row, json_array_get(value, i), key, to, i * key->count);
    }
    return status;
}

/* Checks any number of rows. */
static fathom_status read_rows(const doc *d, const where *at, json_t *value, const form_key *key,
                               json_t **to) {
    if (!json_is_array(value) || !json_array_size(value))
        return doc_expected(d, at, value, "an array of one or more arrays of numbers");
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < json_array_size(value) && status == FATHOM_OK; ++i) {
        const where row = {at, NULL, i};
        status = read_row(d, &row, json_array_get(value, i), key, NULL, 0);
    }
    *to = value;
    return status;
}

/* ---- words ---- */

/* *word: the index of the word in the list. */
static fathom_status choose_word(const doc *d, const where *at, json_t *value, const char *words, int *word) {
    *word =
        json_is_string(value) ? words_find(words, json_string_value(value), json_string_length(value)) : -1;
    if (*word >= 0) return FATHOM_OK;
    char all[TEXT_ROOM] = "", one[PARAMETER_NAME];
    size_t length;
    const char *each;
    for (unsigned i = 0; (each = words_at(words, i, &length)); ++i) {
        snprintf(one, sizeof one, "%.*s", (int)length, each);
        doc_list_word(all, sizeof all, one, "\"");
    }
    return fail_kind(d, at, value, "one of ", all, "");
}

static fathom_status read_words(const doc *d, const where *at, json_t *value, const form_key *key,
                                unsigned *to) {
    if (!json_is_array(value)) return doc_expected(d, at, value, "an array of words");
    *to = 0;
    for (size_t i = 0; i < json_array_size(value); ++i) {
        const where item = {at, NULL, i};
        int word;
        fathom_status status = choose_word(d, &item, json_array_get(value, i), key->words, &word);
        if (status != FATHOM_OK) return status;
        if (*to & 1u << word)
            return doc_fail(d, &item, "\"%s\" is there twice", json_string_value(json_array_get(value, i)));
        *to |= 1u << word;
    }
    return FATHOM_OK;
}

/* ---- objects ---- */

static fathom_status read_member(const doc *d, const where *at, json_t *value, const form_key *key,
                                 void *to) {
    void *member = (char *)to + key->offset;
    switch (key->kind) {
    case FORM_BOOL:
        if (!json_is_boolean(value)) return doc_expected(d, at, value, "true or false");
        *(bool *)member = json_is_true(value);
        return FATHOM_OK;
    case FORM_F32:
    case FORM_F64:
    case FORM_U32:
    case FORM_U64: return read_numbers(d, at, value, key, member);
    case FORM_TEXT:
        if (!json_is_string(value)) return fail_kind(d, at, value, "a string", meaning_of(key), "");
        *(const char **)member = json_string_value(value);
        return FATHOM_OK;
    case FORM_TAG: return FATHOM_OK;
    case FORM_WORD: return choose_word(d, at, value, key->words, member);
    case FORM_WORDS: return read_words(d, at, value, key, member);
    case FORM_OBJECT: return doc_read(d, at, value, key->form, member);
    case FORM_ROWS: return read_rows(d, at, value, key, member);
    case FORM_LIST:
        *(json_t **)member = value;
        if (json_is_array(value) && json_array_size(value) >= key->count) return FATHOM_OK;
        return doc_expected(d, at, value, key->count ? "an array of one or more keys" : "an array");
    case FORM_MAP:
    case FORM_MAP_OF_LISTS:
        *(json_t **)member = value;
        return json_is_object(value) ? FATHOM_OK : doc_expected(d, at, value, "an object");
    }
    return FATHOM_INTERNAL;
}

static fathom_status fail_missing(const doc *d, const where *at, const char *key, const form *f) {
    return doc_fail(d, at, "\"%s\" is missing; every %s needs it", key,
                    strstr(f->name, "Key") ? "key" : f->name);
}

static fathom_status check_required(const doc *d, const where *at, json_t *value, const form *f) {
    for (const form_key *const *part = f->parts; *part; ++part) {
        for (const form_key *key = *part; key->name; ++key) {
            if (!key->required || doc_has(value, key->name)) continue;
            return fail_missing(d, at, key->name, f);
        }
    }
    return FATHOM_OK;
}

static fathom_status check_rule(const doc *d, const where *at, json_t *value, const form_rule *rule) {
    const bool warns = rule->kind == FORM_WANTS || rule->kind == FORM_WANTS_ONE_OF;
    bool applies = rule->kind == FORM_ONE_OF || (doc_has(value, rule->key) && !warns);
    if (!applies) return FATHOM_OK;
    size_t present = 0;
    for (const char *const *other = rule->others; *other; ++other) {
        bool has = doc_has(value, *other);
        present += has;
        if (rule->kind == FORM_NEEDS && !has)
            return doc_fail(d, at, "\"%s\" is given without \"%s\"", rule->key, *other);
        if (rule->kind == FORM_HOLDS && has)
            return doc_fail(d, at, "\"%s\" is given next to \"%s\"; expected it in each item of that", *other,
                            rule->key);
        if (rule->kind == FORM_EXCLUDES && has)
            return doc_fail(d, at, "\"%s\" and \"%s\" exclude each other", rule->key, *other);
    }
    if (rule->kind != FORM_ONE_OF || present == 1) return FATHOM_OK;
    if (rule->others[2])
        return doc_fail(d, at, "expected one of \"%s\", \"%s\" and \"%s\", found %s", rule->others[0],
                        rule->others[1], rule->others[2], present ? "several" : "none");
    return doc_fail(d, at, "expected either \"%s\" or \"%s\", found %s", rule->others[0], rule->others[1],
                    present ? "both" : "neither");
}

static fathom_status check_rules(const doc *d, const where *at, json_t *value, const form *f) {
    for (const form_rule *const *part = f->rules; *part; ++part) {
        for (const form_rule *rule = *part; rule->kind != FORM_NO_RULE; ++rule) {
            fathom_status status = check_rule(d, at, value, rule);
            if (status != FATHOM_OK) return status;
        }
    }
    return FATHOM_OK;
}

/* True if an image raises the parameter towards 1, also from its default of 0. */
static bool is_raised(json_t *value, const char *name) {
    char image[64];
    snprintf(image, sizeof image, "%sTexture", name);
    return json_is_true(json_object_get(json_object_get(value, image), "inverted"));
}

static void warn_useless(const doc *d, const where *at, json_t *value, const form_rule *rule,
                         const char *also) {
    const where key = {at, rule->key, 0};
    const bool one = rule->kind == FORM_WANTS_ONE_OF;
    size_t count = 0, missing = 0;
    char all[TEXT_ROOM] = "";
    if ((rule->kind != FORM_WANTS && !one) || !doc_has(value, rule->key)) return;
    for (const char *const *other = rule->others; *other; ++other, ++count) {
        if (doc_has(value, *other) || is_raised(value, *other) || (also && strcmp(also, *other) == 0))
            continue;
        doc_list_word(all, sizeof all, *other, "\"");
        ++missing;
    }
    if (one ? missing == count : missing)
        doc_warn(d, &key, "it has no effect without %s%s", one ? "one of " : "", all);
}

void doc_warn_useless(const doc *d, const where *at, json_t *value, const form *f, const char *also) {
    for (const form_rule *const *part = f->rules; *part; ++part) {
        for (const form_rule *rule = *part; rule->kind != FORM_NO_RULE; ++rule)
            warn_useless(d, at, value, rule, also);
    }
}

/* Names the keys that the object must have. */
static fathom_status fail_object(const doc *d, const where *at, json_t *value, const form *f) {
    char all[100] = "";
    for (const form_key *const *part = f->parts; *part; ++part) {
        for (const form_key *key = *part; key->name; ++key)
            if (key->required) doc_list_word(all, sizeof all, key->name, "\"");
    }
    return fail_kind(d, at, value, "an object", *all ? " with " : "", all);
}

fathom_status doc_read(const doc *d, const where *at, json_t *value, const form *f, void *to) {
    if (!json_is_object(value)) return fail_object(d, at, value, f);
    const char *name;
    json_t *member;
    json_object_foreach(value, name, member) {
        const where inner = {at, name, 0};
        const form_key *key = form_find(f, name);
        if (!key) return doc_unknown_key(d, &inner, member, f);
        fathom_status status = read_member(d, &inner, member, key, to);
        if (status != FATHOM_OK) return status;
    }
    fathom_status status = check_required(d, at, value, f);
    return status == FATHOM_OK ? check_rules(d, at, value, f) : status;
}

fathom_status doc_choose(const doc *d, const where *at, json_t *value, const form *f, const form **out) {
    if (!json_is_object(value)) return doc_expected(d, at, value, "an object");
    const where type = {at, doc_tag(f), 0};
    json_t *tag = json_object_get(value, type.key);
    *out = f->variants[0];
    if (!tag) return f->tag ? FATHOM_OK : fail_missing(d, at, type.key, f);
    for (const form *const *variant = f->variants; *variant; ++variant) {
        *out = *variant;
        if (json_is_string(tag) && strcmp(json_string_value(tag), (*out)->name) == 0) return FATHOM_OK;
    }
    return doc_unknown_type(d, &type, tag, f);
}
