/* Joins the corners of triangles that have the same vertex and the same value. */
#pragma once

#include "base/array.h"
#include "base/status.h"

/* A vertex with a value. */
typedef struct weld_pair {
    uint32_t vertex, row;
    uint32_t next; /* the pair of the same vertex that was found before; UINT32_MAX: none */
} weld_pair;

typedef struct weld {
    const uint32_t *vertices; /* of each corner */
    size_t corners;
    uint32_t vertex_count;
    const void *values; /* rows, which are the same if their bytes are */
    size_t stride, bytes;
    ARRAY(weld_pair) pairs; /* the result: zero it, and release it with array_free() */
} weld;

/* rows: the value's row of each corner; NULL: the triangle's number. out: the pair of each corner; may be
 * `rows`. Pairs are numbered in the order of their first corners. A vertex with many values may get some
 * pairs twice. FATHOM_OUT_OF_RESOURCES: out of memory, or 2^32 - 1 pairs. */
fathom_status weld_corners(fathom_context *context, weld *w, const uint32_t *rows, uint32_t *out);
