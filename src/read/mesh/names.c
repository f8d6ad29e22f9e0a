#include "read/mesh/names.h"

#include "base/keyed_hash.h"

#include <stdlib.h>
#include <string.h>

/* The slot that holds the name, or the free one where it belongs. */
static size_t find_slot(const name_table *table, const char *text, size_t length) {
    size_t slot = (size_t)sip_hash(process_hash_key(), text, length) & (table->slot_count - 1);
    for (; table->slots[slot]; slot = (slot + 1) & (table->slot_count - 1)) {
        const name_entry *entry = &table->entries.items[table->slots[slot] - 1];
        if (entry->length == length && memcmp(entry->text, text, length) == 0) break;
    }
    return slot;
}

/* At most half full. */
static bool grow(name_table *table) {
    if (2 * (table->entries.count + 1) <= table->slot_count) return true;
    size_t slot_count = table->slot_count ? 2 * table->slot_count : 16;
    uint32_t *slots = calloc(slot_count, sizeof *slots);
    if (!slots) return false;
    free(table->slots);
    table->slots = slots;
    table->slot_count = slot_count;
    for (size_t i = 0; i < table->entries.count; ++i) {
        const name_entry *entry = &table->entries.items[i];
        slots[find_slot(table, entry->text, entry->length)] = (uint32_t)i + 1;
    }
    return true;
}

uint32_t names_add(name_table *table, const char *text, size_t length) {
    if (!grow(table)) return UINT32_MAX;
    size_t slot = find_slot(table, text, length);
    if (!table->slots[slot]) {
        name_entry entry = {text, length};
        if (!array_push(&table->entries, entry)) return UINT32_MAX;
        table->slots[slot] = (uint32_t)table->entries.count;
    }
    return table->slots[slot] - 1;
}

uint32_t names_find(const name_table *table, const char *text, size_t length) {
    if (!table->slot_count) return UINT32_MAX;
    return table->slots[find_slot(table, text, length)] - 1;
}

void names_free(name_table *table) {
    array_free(&table->entries);
    free(table->slots);
    *table = (name_table){0};
}
