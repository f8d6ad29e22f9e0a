#include "base/array.h"

#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

bool array_reserve(void *items, size_t *capacity, size_t count, size_t more, size_t size) {
    if (more > SIZE_MAX / size - count) return false;
    size_t need = count + more;
    if (need <= *capacity) return true;
    size_t room = *capacity < 8 ? 8 : *capacity + *capacity / 2;
    if (room < need || room > SIZE_MAX / size) room = need;
    if (!memory_has((room - *capacity) * size)) return false;
    /* Copied as bytes: the pointer has the caller's type, and reading it as void * would violate strict
     * aliasing. */
    void *pointer;
    memcpy(&pointer, items, sizeof pointer);
    pointer = realloc(pointer, room * size);
    if (!pointer) return false;
    memcpy(items, &pointer, sizeof pointer);
    *capacity = room;
    return true;
}
