/* Union-find over vertices. A vertex's parent is never a later vertex, so one pass in order leaves every
 * vertex next to its root. */
#include "scene/pieces.h"

#include "scene/boundary.h"

#include <stdlib.h>
#include <string.h>

static uint32_t root_of(uint32_t *parent, uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
}

static void join(uint32_t *parent, uint32_t a, uint32_t b) {
    if (parent[a] == parent[b]) return;
    a = root_of(parent, a), b = root_of(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

static void join_triangles(const fathom_mesh *mesh, uint32_t *parent) {
    const uint32_t *t = mesh->indices, *end = t + 3 * (size_t)mesh->triangle_count;
    for (; t < end; t += 3) join(parent, t[0], t[1]), join(parent, t[0], t[2]);
}

/* Bits that are equal where the positions are: +0 makes one zero of two. */
static void position_bits(const fathom_mesh *mesh, uint32_t v, uint32_t out[3]) {
    const char *at = (const char *)mesh->positions + v * mesh->position_stride;
    float p[3];
    memcpy(p, at, sizeof p);
    for (int c = 0; c < 3; ++c) p[c] += 0.0f;
    memcpy(out, p, sizeof p);
}

/* Joins vertices at equal positions, by a hash table of the first one at each. */
static bool join_positions(const fathom_mesh *mesh, uint32_t *parent) {
    size_t size = 16;
    while (size < 2 * (size_t)mesh->vertex_count) size *= 2;
    uint32_t *table = malloc(size * sizeof *table);
    if (!table) return false;
    memset(table, 0xff, size * sizeof *table); /* FATHOM_NONE */
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        uint32_t key[3], other[3];
        position_bits(mesh, v, key);
        size_t k = boundary_mixed(key[0] ^ boundary_mixed(key[1] ^ boundary_mixed(key[2])));
        for (k &= size - 1; table[k] != FATHOM_NONE; k = (k + 1) & (size - 1)) {
            position_bits(mesh, table[k], other);
            if (memcmp(key, other, sizeof key) == 0) break;
        }
        if (table[k] == FATHOM_NONE)
            table[k] = v;
        else
            join(parent, table[k], v);
    }
    free(table);
    return true;
}

/* Whether all vertices have the root of the first triangle. Vertices that no triangle has spoil this, and
 * only cost the time of number_roots(). */
static bool is_one(const fathom_mesh *mesh, uint32_t *parent) {
    bool one = true;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        parent[v] = parent[parent[v]];
        one &= parent[v] == parent[0];
    }
    return one || !mesh->triangle_count;
}

/* Numbers the roots of triangles in order, and gives every vertex its number. False: more than `most`. */
static bool number_roots(const fathom_mesh *mesh, uint32_t *parent, uint32_t *number, uint32_t most,
                         uint32_t *count) {
    *count = 0;
    memset(number, 0xff, mesh->vertex_count * sizeof *number);
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        uint32_t root = parent[mesh->indices[3 * i]];
        if (number[root] == FATHOM_NONE) number[root] = (*count)++;
        if (*count > most) return false;
    }
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) number[v] = number[parent[v]];
    return true;
}

bool pieces_find(const fathom_mesh *mesh, bool by_position, uint32_t most, pieces *out) {
    *out = (pieces){.count = 1};
    uint32_t *parent = malloc(mesh->vertex_count * sizeof *parent), *number = NULL;
    if (!parent) return false;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) parent[v] = v;
    join_triangles(mesh, parent);
    bool fine = !by_position || join_positions(mesh, parent);
    if (fine && !is_one(mesh, parent)) {
        number = malloc(mesh->vertex_count * sizeof *number);
        fine = number != NULL;
        if (fine && !number_roots(mesh, parent, number, most, &out->count)) out->count = 0;
    }
    free(parent);
    if (fine && out->count > 1)
        out->of_vertex = number;
    else
        free(number);
    return fine;
}
