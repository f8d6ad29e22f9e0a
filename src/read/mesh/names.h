/* Names to numbers: the first name is 0, the next new one 1, … */
#ifndef READ_NAMES_H
#define READ_NAMES_H

#include "base/array.h"

#include <stdint.h>

typedef struct name_entry {
    const char *text; /* the caller's, not terminated */
    size_t length;
    uint32_t number;
} name_entry;

/* Zero it to start with. A balanced tree: no choice of names makes it slow. */
typedef struct name_table {
    ARRAY(name_entry *) entries; /* by number */
    void *tree;
} name_table;

/* The number of a name, which is added if it is new; UINT32_MAX when out of memory. The text must outlive the
 * table. */
uint32_t names_add(name_table *table, const char *text, size_t length);
/* UINT32_MAX when there is none. */
uint32_t names_find(const name_table *table, const char *text, size_t length);
void names_free(name_table *table);

#endif
