/* Typed values and their paths in the document. */
#include "base/text.h"
#include "read/gltf/gltf.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const fathom_place *gltf_place(const gltf *g, const gltf_value *at, const char *key, where_spot *spot) {
    const where member = {gltf_steps(at), key, 0}, *steps = key ? &member : member.parent;
    where_path(steps, spot->path, sizeof spot->path);
    const where_place found = where_find(g->text, steps);
    spot->place = (fathom_place){.file = g->path, .field = spot->path};
    if (g->text_at)
        spot->place.has_byte = true, spot->place.byte = g->text_at + (size_t)(found.value - g->text);
    else
        spot->place.line = found.line;
    return &spot->place;
}

const fathom_place *gltf_field(const gltf *g, const gltf_value *at, where_spot *spot) {
    where_path(gltf_steps(at), spot->path, sizeof spot->path);
    spot->place = (fathom_place){.file = g->path, .field = spot->path};
    return &spot->place;
}

fathom_status gltf_fail_memory(gltf *g, size_t bytes) {
    if (gltf_fine(g)) g->status = fail_memory(g->context, bytes);
    return g->status;
}

fathom_status gltf_within(gltf *g, const gltf_value *at, const char *key, fathom_status status) {
    where_spot spot;
    if (!gltf_fine(g)) return g->status;
    g->status =
        status == FATHOM_BAD_INPUT ? fail_within(g->context, status, gltf_place(g, at, key, &spot)) : status;
    return g->status;
}

static void note_text(gltf *g, const char *place, const char *format, va_list args) {
    char text[320];
    vsnprintf(text, sizeof text, format, args);
    if (!g->quiet) notes_add(&g->notes, 1, place, "%s", text);
}

void gltf_note(gltf *g, const gltf_value *at, const char *key, const char *format, ...) {
    char place[128] = ": ";
    const where member = {gltf_steps(at), key, 0};
    va_list args;
    where_path(key ? &member : member.parent, place + 2, sizeof place - 2);
    va_start(args, format);
    note_text(g, place[2] ? place : "", format, args);
    va_end(args);
}

void gltf_note_node(gltf *g, uint32_t node, const char *format, ...) {
    char place[128];
    const char *name = gltf_name(json_array_get(g->nodes.json, node));
    va_list args;
    snprintf(place, sizeof place, ": nodes[%u]%s%.40s%s", node, name ? " (\"" : "", name ? name : "",
             name ? "\")" : "");
    va_start(args, format);
    note_text(g, place, format, args);
    va_end(args);
}

static const char *kind_name(const json_t *json) {
    switch (json_typeof(json)) {
    case JSON_OBJECT: return "an object";
    case JSON_ARRAY: return "an array";
    case JSON_STRING: return "a string";
    case JSON_INTEGER:
    case JSON_REAL: return "a number";
    case JSON_TRUE:
    case JSON_FALSE: return "a boolean";
    case JSON_NULL: return "null";
    }
    return "something unknown";
}

static void fail_kind(gltf *g, gltf_value *at, const char *expected) {
    gltf_fail(g, at, NULL, "is %s; expected %s", kind_name(at->json), expected);
    at->json = NULL;
}

/* Some languages write null for members without a value. */
static gltf_value member(const gltf_value *parent, const char *key) {
    gltf_value out = {json_object_get(parent->json, key), {gltf_steps(parent), key, 0}};
    if (json_is_null(out.json)) out.json = NULL;
    return out;
}

fathom_status gltf_object(gltf *g, const gltf_value *parent, const char *key, gltf_value *out) {
    *out = member(parent, key);
    if (out->json && !json_is_object(out->json)) fail_kind(g, out, "an object");
    return g->status;
}

fathom_status gltf_array(gltf *g, const gltf_value *parent, const char *key, gltf_value *out) {
    *out = member(parent, key);
    if (out->json && !json_is_array(out->json)) fail_kind(g, out, "an array");
    return g->status;
}

fathom_status gltf_item(gltf *g, const gltf_value *array, size_t index, gltf_value *out) {
    *out = gltf_entry(array, index);
    if (!json_is_object(out->json)) fail_kind(g, out, "an object");
    return g->status;
}

fathom_status gltf_extension(gltf *g, const gltf_value *parent, const char *name, gltf_value *holder,
                             gltf_value *out) {
    gltf_object(g, parent, "extensions", holder);
    return gltf_object(g, holder, name, out);
}

size_t gltf_count(const gltf_value *array) { return json_array_size(array->json); }

static void number_of(gltf *g, gltf_value *v, double lowest, double highest, double *out) {
    const double value = json_number_value(v->json);
    if (!json_is_number(v->json))
        fail_kind(g, v, "a number");
    else if (value >= lowest && value <= highest)
        *out = value;
    else {
        *out = value < lowest ? lowest : highest;
        gltf_note(g, v, NULL, "%s is out of range: expected a number %s %g; the nearest is taken",
                  v->at.key ? v->at.key : v->at.parent->key, value < lowest ? ">=" : "<=", *out);
    }
}

fathom_status gltf_number(gltf *g, const gltf_value *parent, const char *key, double lowest, double highest,
                          double *out) {
    gltf_value v = member(parent, key);
    if (v.json) number_of(g, &v, lowest, highest, out);
    return g->status;
}

fathom_status gltf_numbers(gltf *g, const gltf_value *parent, const char *key, size_t n, double lowest,
                           double highest, double *out) {
    gltf_value array;
    gltf_array(g, parent, key, &array);
    if (!array.json) return g->status;
    if (gltf_count(&array) != n)
        return gltf_fail(g, &array, NULL, "has %zu entries; expected %zu numbers", gltf_count(&array), n);
    for (size_t i = 0; i < n && gltf_fine(g); ++i) {
        gltf_value v = gltf_entry(&array, i);
        number_of(g, &v, lowest, highest, &out[i]);
    }
    return g->status;
}

/* 3.0 is accepted as an integer: some languages have only one kind of number. */
static void integer_of(gltf *g, gltf_value *v, uint64_t lowest, uint64_t highest, uint64_t *out) {
    const double real = json_number_value(v->json);
    const bool whole = json_is_integer(v->json) || (fabs(real) < 0x1p53 && floor(real) == real);
    const int64_t value = json_is_integer(v->json) ? (int64_t)json_integer_value(v->json)
                          : whole                  ? (int64_t)real
                                                   : 0;
    if (!json_is_number(v->json))
        fail_kind(g, v, "an integer");
    else if (!whole)
        gltf_fail(g, v, NULL, "is %g; expected an integer", real);
    else if (value < 0 || (uint64_t)value < lowest || (uint64_t)value > highest)
        gltf_fail(g, v, NULL, "is %lld; expected an integer in [%llu, %llu]", (long long)value,
                  (unsigned long long)lowest, (unsigned long long)highest);
    else
        *out = (uint64_t)value;
}

fathom_status gltf_integer(gltf *g, const gltf_value *parent, const char *key, uint64_t lowest,
                           uint64_t highest, uint64_t *out) {
    gltf_value v = member(parent, key);
    if (v.json) integer_of(g, &v, lowest, highest, out);
    return g->status;
}

static void index_of(gltf *g, gltf_value *v, const gltf_value *into, uint32_t *out) {
    const long long below = json_integer_value(v->json); /* 0: not an integer */
    uint64_t index = 0;
    if (below >= 0) integer_of(g, v, 0, INT64_MAX, &index);
    if (below < 0 || index >= gltf_count(into) || index >= GLTF_ABSENT)
        gltf_fail(g, v, NULL, "is %lld; expected an index into %s, which has %zu entries",
                  below < 0 ? below : (long long)index, into->at.key, gltf_count(into));
    if (gltf_fine(g)) *out = (uint32_t)index;
}

fathom_status gltf_index(gltf *g, const gltf_value *parent, const char *key, const gltf_value *into,
                         uint32_t *out) {
    gltf_value v = member(parent, key);
    if (json_is_integer(v.json) && json_integer_value(v.json) == -1)
        gltf_note(g, &v, NULL, "an index of -1, which is against the format, is taken as none");
    else if (v.json)
        index_of(g, &v, into, out);
    return g->status;
}

fathom_status gltf_index_item(gltf *g, const gltf_value *array, size_t i, const gltf_value *into,
                              uint32_t *out) {
    gltf_value v = gltf_entry(array, i);
    index_of(g, &v, into, out);
    return g->status;
}

fathom_status gltf_text(gltf *g, const gltf_value *parent, const char *key, const char **out) {
    gltf_value v = member(parent, key);
    if (v.json && !json_is_string(v.json)) fail_kind(g, &v, "a string");
    if (v.json) *out = json_string_value(v.json);
    return g->status;
}

int gltf_word(gltf *g, const gltf_value *parent, const char *key, const char *words, const char *expected,
              int missing) {
    const char *word = NULL;
    gltf_text(g, parent, key, &word);
    const int found = word ? words_find(words, word, strlen(word)) : missing;
    if (found < 0) gltf_fail(g, parent, key, "is \"%.40s\"; expected %s", word ? word : "", expected);
    return found < 0 ? 0 : found;
}

fathom_status gltf_flag(gltf *g, const gltf_value *parent, const char *key, bool *out) {
    gltf_value v = member(parent, key);
    if (v.json && !json_is_boolean(v.json)) fail_kind(g, &v, "true or false");
    if (v.json) *out = json_is_true(v.json);
    return g->status;
}
