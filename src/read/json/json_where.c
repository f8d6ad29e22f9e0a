/* jansson does not store positions, so after an error the value is searched for in the text. */
#include "read/json/json_where.h"

#include "json/memory.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

static const char *skip_space(const char *c) {
    while (*c == ' ' || *c == '\t' || *c == '\n' || *c == '\r') ++c;
    return c;
}

/* c: the opening quote. */
static const char *skip_string(const char *c) {
    for (++c; *c && *c != '"'; ++c) {
        if (*c == '\\' && c[1]) ++c;
    }
    return *c ? c + 1 : c;
}

static const char *skip_value(const char *c) {
    if (*c == '"') return skip_string(c);
    if (*c != '{' && *c != '[') return c + strcspn(c, ",]} \t\r\n");
    size_t depth = 0;
    while (*c) {
        if (*c == '"') {
            c = skip_string(c);
            continue;
        }
        if (*c == '{' || *c == '[') ++depth;
        if (*c == '}' || *c == ']') --depth;
        ++c;
        if (!depth) break;
    }
    return c;
}

/* c: after an item; returns the next one, or the closing bracket. */
static const char *next_item(const char *c) {
    c = skip_space(c);
    return *c == ',' ? skip_space(c + 1) : c;
}

/* True when the quoted string from begin to end is `key`. jansson decodes escapes. */
static bool says(const char *begin, const char *end, const char *key) {
    size_t length = (size_t)(end - begin);
    if (!memchr(begin, '\\', length)) {
        return length == strlen(key) + 2 && memcmp(begin + 1, key, length - 2) == 0;
    }
    json_arena arena = {NULL, false};
    json_error_t error;
    const json_t *string = json_arena_read(&arena, begin, length, JSON_DECODE_ANY, &error);
    bool same = string && strcmp(json_string_value(string), key) == 0;
    json_arena_release(&arena);
    return same;
}

/* Takes one step down from the value at c. *shown: the position whose line is reported. */
static const char *step(const char *c, const where *at, const char **shown) {
    if (*c != (at->key ? '{' : '[')) return NULL;
    c = skip_space(c + 1);
    for (size_t i = 0; *c && *c != '}' && *c != ']'; ++i) {
        const char *value = c;
        bool found = i == at->index;
        if (at->key) {
            const char *end = skip_string(c);
            found = says(c, end, at->key);
            end = skip_space(end);
            value = *end == ':' ? skip_space(end + 1) : end;
        }
        if (found) {
            *shown = c;
            return value;
        }
        c = next_item(skip_value(value));
    }
    return NULL;
}

/* False if a step is missing; *value and *shown are then those of the last step found. */
static bool descend(const char *text, const where *at, const char **value, const char **shown) {
    if (!at) {
        *value = *shown = skip_space(text);
        return true;
    }
    if (!descend(text, at->parent, value, shown)) return false;
    const char *next = step(*value, at, shown);
    if (next) *value = next;
    return next != NULL;
}

where_place where_find(const char *text, const where *at) {
    where_place place = {.line = 1};
    const char *shown;
    place.whole = descend(text, at, &place.value, &shown);
    place.length = (size_t)(skip_value(place.value) - place.value);
    for (const char *c = text; c < shown; ++c) place.line += *c == '\n';
    return place;
}

static bool is_plain(const char *key) {
    for (const char *c = key; *c; ++c) {
        if (!isalnum((unsigned char)*c) && *c != '_' && *c != '$') return false;
    }
    return *key != '\0';
}

static size_t write_path(const where *at, char *out, size_t room) {
    if (!at) return 0;
    size_t used = write_path(at->parent, out, room);
    if (used >= room) return used;
    int length;
    if (!at->key)
        length = snprintf(out + used, room - used, "[%zu]", at->index);
    else if (is_plain(at->key))
        length = snprintf(out + used, room - used, "%s%s", used ? "." : "", at->key);
    else
        length = snprintf(out + used, room - used, "[\"%s\"]", at->key);
    return used + (size_t)length;
}

void where_path(const where *at, char *out, size_t room) {
    out[0] = '\0';
    write_path(at, out, room);
    for (char *c = out; *c; ++c) {
        if (iscntrl((unsigned char)*c)) *c = '?';
    }
}
