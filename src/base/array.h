/* Growing arrays: a pointer, a count, a capacity. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* Makes room for `more` further items of `size` bytes each. `items` is the address of the array's pointer.
 * Returns false when out of memory. */
bool array_reserve(void *items, size_t *capacity, size_t count, size_t more, size_t size);

/* Declares an array: ARRAY(type) name, set to zero. array_push(&name, value) returns false when out of
 * memory. */
#define ARRAY(type)                                                                                          \
    struct {                                                                                                 \
        type *items;                                                                                         \
        size_t count, capacity;                                                                              \
    }
#define array_room(array, more)                                                                              \
    array_reserve(&(array)->items, &(array)->capacity, (array)->count, (more), sizeof *(array)->items)
#define array_push(array, value)                                                                             \
    (array_room((array), 1) ? ((array)->items[(array)->count++] = (value), true) : false)
#define array_free(array) free((array)->items)
