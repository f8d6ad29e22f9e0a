#include "read/mesh/weld.h"

#include <stdlib.h>
#include <string.h>

/* Pairs of one vertex that are compared, so that the time is linear. */
#define WELD_TRIES 256

static const char *value_at(const weld *w, uint32_t row) { return (const char *)w->values + w->stride * row; }

/* The pair that begins the list, or one after it, with the value of the row; UINT32_MAX: none. */
static uint32_t find_pair(const weld *w, uint32_t pair, uint32_t row) {
    for (int tries = 0; pair != UINT32_MAX && tries < WELD_TRIES; ++tries) {
        const weld_pair *p = &w->pairs.items[pair];
        if (memcmp(value_at(w, p->row), value_at(w, row), w->bytes) == 0) return pair;
        pair = p->next;
    }
    return UINT32_MAX;
}

fathom_status weld_corners(fathom_context *context, weld *w, const uint32_t *rows, uint32_t *out) {
    const size_t bytes = w->vertex_count * sizeof(uint32_t);
    uint32_t *last = malloc(bytes); /* the last pair of each vertex */
    if (!last) return fail_memory(context, bytes);
    memset(last, 0xff, bytes);
    bool fine = true;
    for (size_t i = 0; i < w->corners && fine; ++i) {
        const uint32_t vertex = w->vertices[i], row = rows ? rows[i] : (uint32_t)(i / 3);
        out[i] = find_pair(w, last[vertex], row);
        if (out[i] != UINT32_MAX) continue;
        const weld_pair pair = {vertex, row, last[vertex]};
        out[i] = last[vertex] = (uint32_t)w->pairs.count;
        fine = w->pairs.count < UINT32_MAX - 1 && array_push(&w->pairs, pair);
    }
    free(last);
    return fine ? FATHOM_OK : fail_memory(context, w->pairs.count * sizeof *w->pairs.items);
}
