#include "read/mesh/names.h"

#include <search.h>
#include <stdlib.h>
#include <string.h>

static int compare(const void *a, const void *b) {
    const name_entry *x = a, *y = b;
    if (x->length != y->length) return x->length < y->length ? -1 : 1;
    return memcmp(x->text, y->text, x->length);
}

uint32_t names_find(const name_table *table, const char *text, size_t length) {
    const name_entry wanted = {text, length, 0}, **found = tfind(&wanted, &table->tree, compare);
    return found ? (*found)->number : UINT32_MAX;
}

uint32_t names_add(name_table *table, const char *text, size_t length) {
    uint32_t known = names_find(table, text, length);
    if (known != UINT32_MAX) return known;
    name_entry *entry = malloc(sizeof *entry);
    if (!entry || !array_push(&table->entries, entry)) {
        free(entry);
        return UINT32_MAX;
    }
    *entry = (name_entry){text, length, (uint32_t)table->entries.count - 1};
    return tsearch(entry, &table->tree, compare) ? entry->number : UINT32_MAX;
}

static void keep(void *entry) { (void)entry; }

void names_free(name_table *table) {
    tdestroy(table->tree, keep);
    for (size_t i = 0; i < table->entries.count; ++i) free(table->entries.items[i]);
    array_free(&table->entries);
    *table = (name_table){0};
}
