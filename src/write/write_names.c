/* Unique names of materials and groups, for formats that require them. */
#include "write/write.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct named {
    const char *name;
    size_t index;
} named;

static int compare_names(const void *a, const void *b) {
    const named *x = a, *y = b;
    const int order = strcmp(x->name, y->name);
    return order ? order : x->index < y->index ? -1 : 1;
}

/* If `words`: without blanks and #, so that any reader accepts it. */
static bool is_name(const char *name, bool words) {
    if (!*name) return false;
    for (; words && *name; ++name) {
        if ((unsigned char)*name <= ' ' || *name == '#') return false;
    }
    return true;
}

static int compare_to_name(const void *name, const void *item) {
    return strcmp(name, ((const named *)item)->name);
}

/* A name by the item's number, or that number plus a multiple of the count, that no item has. */
static char *numbered(const named *items, size_t count, const char *prefix, size_t number) {
    char name[48];
    do {
        snprintf(name, sizeof name, "%s%zu", prefix, number);
        number += count;
    } while (bsearch(name, items, count, sizeof *items, compare_to_name));
    return strdup(name);
}

/* The first of several items with the same name keeps it. *replaced: counts those that do not. */
static fathom_status name_all(fathom_context *context, named *items, size_t count, const char *prefix,
                              bool words, char **names, size_t *replaced) {
    qsort(items, count, sizeof *items, compare_names);
    for (size_t i = 0; i < count; ++i) {
        const named *at = &items[i];
        const bool first = i == 0 || strcmp(at[-1].name, at->name) != 0;
        const bool keeps = first && is_name(at->name, words);
        names[at->index] = keeps ? strdup(at->name) : numbered(items, count, prefix, at->index);
        if (!names[at->index]) return fail_memory(context, strlen(prefix));
        *replaced += !keeps && *at->name;
    }
    return FATHOM_OK;
}

fathom_status write_names(const fathom_scene *scene, bool groups, bool words, note_list *notes, char ***out) {
    const size_t count = groups ? scene->groups.count : scene->materials.count;
    size_t replaced = 0;
    named *items = calloc(count, sizeof *items);
    char **names = *out = calloc(count + 1, sizeof *names);
    fathom_status status =
        items && names ? FATHOM_OK : fail_memory(scene->context, count * (sizeof *items + sizeof *names));
    for (size_t i = 0; status == FATHOM_OK && i < count; ++i) {
        const char *name = groups ? scene->groups.items[i] : scene->materials.items[i].name;
        items[i] = (named){name ? name : "", i};
    }
    if (status == FATHOM_OK)
        status =
            name_all(scene->context, items, count, groups ? "group_" : "material_", words, names, &replaced);
    free(items);
    if (replaced)
        notes_add(notes, replaced, "", "the name of a %s is replaced: another has it%s",
                  groups ? "group" : "material", words ? ", or it has blanks or #" : "");
    return status;
}

void write_names_free(char **names, size_t count) {
    for (size_t i = 0; names && i < count; ++i) free(names[i]);
    free(names);
}
