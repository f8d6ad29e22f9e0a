/* Errors about names that no form has. */
#include "base/text.h"
#include "read/json/json_doc.h"

#include <stdio.h>
#include <string.h>

enum { TEXT_ROOM = 512, KEYS_ROOM = 2048 };

const char *doc_tag(const form *f) { return f->tag ? f->tag : "type"; }

void doc_list_word(char *text, size_t room, const char *word, const char *mark) {
    static const char more[] = ", ...";
    const size_t used = strlen(text), end = sizeof more - 1;
    if (used >= end && strcmp(text + used - end, more) == 0) return;
    if (used + strlen(word) + 2 * strlen(mark) + 2 + sizeof more > room)
        snprintf(text + used, room - used, "%s", more);
    else
        snprintf(text + used, room - used, "%s%s%s%s", used ? ", " : "", mark, word, mark);
}

fathom_status doc_unknown_name(const doc *d, const where *at, const char *what, const char *name,
                               json_t *names) {
    text_search search = text_search_begin(name);
    char all[TEXT_ROOM] = "";
    const char *key;
    json_t *value;
    json_object_foreach(names, key, value) {
        text_search_offer(&search, key);
        doc_list_word(all, sizeof all, key, "\"");
    }
    if (search.best)
        return doc_fail(d, at, "there is no %s \"%.60s\"; did you mean \"%.60s\"?", what, name, search.best);
    if (!*all) return doc_fail(d, at, "there is no %s \"%.60s\"; the file has none", what, name);
    return doc_fail(d, at, "there is no %s \"%.60s\"; there are: %s", what, name, all);
}

/* Finds the key of `f` that is nearest to `wanted`. all: a list of the keys, or NULL. */
static text_search search_keys(const form *f, const char *wanted, char *all) {
    text_search search = text_search_begin(wanted);
    for (const form_key *const *part = f->parts; *part; ++part) {
        for (const form_key *key = *part; key->name; ++key) {
            text_search_offer(&search, key->name);
            if (all) doc_list_word(all, KEYS_ROOM, key->name, "");
        }
    }
    return search;
}

/* The form that `f` is a variant of, or NULL. */
static const form *family_of(const form *f) {
    static const form *const families[] = {&form_material, &form_light, &form_object};
    for (size_t i = 0; i < sizeof families / sizeof *families; ++i) {
        for (const form *const *variant = families[i]->variants; *variant; ++variant)
            if (*variant == f) return families[i];
    }
    return NULL;
}

static bool has_variant(const form *f, const char *name) {
    for (const form *const *variant = f->variants; variant && *variant; ++variant)
        if (strcmp((*variant)->name, name) == 0) return true;
    return false;
}

/* The key of this form that other programs call `word`, or NULL. */
static const char *translated(const form *f, const char *word, json_t *value) {
    static const struct {
        const form *family;
        const char *word, *key;
    } words[] = {{&form_object, "position", "translation"}, {&form_object, "location", "translation"},
                 {&form_object, "vertices", "positions"},   {&form_object, "faces", "indices"},
                 {&form_camera, "position", "eye"},         {&form_camera, "lookAt", "target"},
                 {&form_image, "samples", "spp"},           {&form_image, "resolution", "width"},
                 {&form_material, "color", "kd"},           {&form_material, "color", "baseColor"},
                 {&form_material, "diffuse", "kd"},         {&form_material, "diffuse", "baseColor"},
                 {&form_material, "albedo", "kd"},          {&form_material, "albedo", "baseColor"},
                 {&form_material, "emission", "ke"},        {&form_material, "emission", "emissive"},
                 {&form_material, "metalness", "metallic"}, {&form_light, "strength", "intensity"},
                 {&form_light, "power", "intensity"},       {&form_light, "energy", "intensity"}};
    const form *family = family_of(f) ? family_of(f) : f;
    const bool rows = json_is_array(json_array_get(value, 0));
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i) {
        const form_key *key = form_find(f, words[i].key);
        if (words[i].family == family && !strcmp(words[i].word, word) && key &&
            rows == (key->kind == FORM_ROWS))
            return key->name;
    }
    return NULL;
}

fathom_status doc_unknown_key(const doc *d, const where *at, json_t *value, const form *f) {
    char all[KEYS_ROOM] = "";
    const text_search search = search_keys(f, at->key, all);
    const form *family = family_of(f);
    const char *here = translated(f, at->key, value);
    if (here) return doc_fail(d, at, "unknown key; did you mean \"%s\"?", here);
    for (const form *const *other = family ? family->variants : NULL; other && *other; ++other) {
        const text_search there = search_keys(*other, at->key, NULL);
        if (*other == f || !there.best || (search.best && there.distance)) continue;
        return doc_fail(d, at, "unknown key for \"%s\": \"%s\"%s; \"%s\": \"%s\" has \"%s\"", doc_tag(family),
                        f->name, family->tag && f == family->variants[0] ? ", the default" : "",
                        doc_tag(family), (*other)->name, there.best);
    }
    for (const form *const *m = family == &form_object ? form_material.variants : NULL; m && *m; ++m) {
        if (!search.best && form_find(*m, at->key))
            return doc_fail(d, at, "unknown key; materials have \"%s\"", at->key);
    }
    if (search.best) return doc_fail(d, at, "unknown key; did you mean \"%s\"?", search.best);
    for (const form_key *const *part = f->parts; *part; ++part) {
        for (const form_key *key = *part; key->name; ++key) {
            if (key->kind == FORM_OBJECT && form_find(key->form, at->key))
                return doc_fail(d, at, "unknown key; \"%s\" has \"%s\"", key->name, at->key);
            if (key->kind == FORM_LIST && has_variant(key->form, at->key))
                return doc_fail(d, at, "unknown key; items of \"%s\" have \"type\": \"%s\"", key->name,
                                at->key);
        }
    }
    return doc_fail(d, at, "unknown key; known here: %s", all);
}

fathom_status doc_unknown_type(const doc *d, const where *at, json_t *value, const form *f) {
    const char *word = json_is_string(value) ? json_string_value(value) : "";
    char all[TEXT_ROOM] = "", text[TEXT_ROOM + 8];
    if (f == &form_object && has_variant(&form_light, word))
        return doc_fail(d, at, "no object is of this type; items of \"lights\" are");
    if (f == &form_light && (has_variant(&form_object, word) || strcmp(word, "area") == 0))
        return doc_fail(d, at,
                        "no light is of this type; an area light is an object whose material has \"ke\" or "
                        "\"emissive\"");
    for (const form *const *variant = f->variants; *variant; ++variant)
        doc_list_word(all, sizeof all, (*variant)->name, "\"");
    snprintf(text, sizeof text, "one of %s", all);
    return doc_expected(d, at, value, text);
}
