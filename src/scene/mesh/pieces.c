/* Union-find over vertices, by all threads at once. The parent of a vertex is never a later vertex, so after
 * one pass in order the parent of every vertex is its root. */
#include "scene/mesh/closed.h"

#include "base/threads.h"
#include "scene/kernels.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define GRAIN ((size_t)1 << 15)

typedef _Atomic uint32_t shared;

typedef struct search {
    const fathom_mesh *mesh;
    shared *parent; /* by vertex */
    shared *table;  /* hash table of positions: the first vertex inserted at each; FATHOM_NONE: empty */
    size_t mask;    /* its number of slots, a power of two, minus 1 */
} search;

static inline uint32_t get(shared *from) { return atomic_load_explicit(from, memory_order_relaxed); }
static inline void set(shared *to, uint32_t v) { atomic_store_explicit(to, v, memory_order_relaxed); }

/* Finds the root and halves the path. Another thread may do the same; each writes an ancestor. */
static uint32_t root_of(shared *parent, uint32_t v) {
    for (uint32_t above = get(&parent[v]); above != v; above = get(&parent[v])) {
        uint32_t next = get(&parent[above]);
        if (next != above) set(&parent[v], next); /* else the cache line stays shared */
        v = next;
    }
    return v;
}

/* The later root becomes a child of the earlier one, so the final roots do not depend on the order of
 * work. */
static void join(shared *parent, uint32_t a, uint32_t b) {
    if (get(&parent[a]) == get(&parent[b])) return;
    for (;;) {
        a = root_of(parent, a), b = root_of(parent, b);
        if (a == b) return;
        uint32_t late = a > b ? a : b, early = a > b ? b : a;
        if (atomic_compare_exchange_strong(&parent[late], &(uint32_t){late}, early)) return;
    }
}

static void join_triangles(void *user, size_t begin, size_t end) {
    const search *s = user;
    const uint32_t *t = s->mesh->indices + 3 * begin;
    for (size_t i = begin; i < end; ++i, t += 3) join(s->parent, t[0], t[1]), join(s->parent, t[0], t[2]);
}

/* The first vertex inserted at the position of v; this may be v. */
static uint32_t first_at(const search *s, uint32_t v) {
    uint32_t key[3], other[3];
    closed_position_bits(s->mesh, v, key);
    size_t k = boundary_mixed(key[0] ^ boundary_mixed(key[1] ^ boundary_mixed(key[2])));
    for (;; ++k) {
        shared *place = &s->table[k & s->mask];
        uint32_t there = FATHOM_NONE;
        if (atomic_compare_exchange_strong(place, &there, v)) return v;
        closed_position_bits(s->mesh, there, other);
        if (memcmp(key, other, sizeof key) == 0) return there;
    }
}

static void join_positions(void *user, size_t begin, size_t end) {
    const search *s = user;
    for (size_t v = begin; v < end; ++v) join(s->parent, first_at(s, (uint32_t)v), (uint32_t)v);
}

/* Joins vertices at equal positions. */
static bool join_doubles(search *s, unsigned threads) {
    size_t size = 16;
    while (size < 2 * (size_t)s->mesh->vertex_count) size *= 2;
    s->mask = size - 1;
    s->table = malloc(size * sizeof *s->table);
    if (!s->table) return false;
    memset(s->table, 0xff, size * sizeof *s->table);
    loop_parallel(threads, s->mesh->vertex_count, GRAIN, join_positions, s);
    free(s->table);
    return true;
}

/* Sets the parent of every vertex to its root. True when all have the same root, or there are no triangles.
 * Vertices without a triangle are roots too; with them the result may be false for a single piece, and
 * number_roots() is called in vain. */
static bool flatten(const search *s) {
    bool one = true;
    for (uint32_t v = 0; v < s->mesh->vertex_count; ++v) {
        uint32_t root = get(&s->parent[get(&s->parent[v])]);
        set(&s->parent[v], root);
        one &= root == 0;
    }
    return one || !s->mesh->triangle_count;
}

/* Numbers the roots in the order of the triangles, and gives every vertex the number of its root. False:
 * there are more than `most`. */
static bool number_roots(const search *s, uint32_t *number, uint32_t most, uint32_t *count) {
    *count = 0;
    memset(number, 0xff, s->mesh->vertex_count * sizeof *number);
    for (size_t i = 0; i < s->mesh->triangle_count; ++i) {
        uint32_t root = get(&s->parent[s->mesh->indices[3 * i]]);
        if (number[root] == FATHOM_NONE) number[root] = (*count)++;
        if (*count > most) return false;
    }
    for (uint32_t v = 0; v < s->mesh->vertex_count; ++v) number[v] = number[get(&s->parent[v])];
    return true;
}

bool pieces_find(unsigned threads, const fathom_mesh *mesh, bool by_position, uint32_t most, pieces *out) {
    search s = {.mesh = mesh, .parent = malloc(mesh->vertex_count * sizeof *s.parent)};
    uint32_t *number = NULL;
    *out = (pieces){.count = 1};
    if (!s.parent) return false;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) set(&s.parent[v], v);
    loop_parallel(threads, mesh->triangle_count, GRAIN, join_triangles, &s);
    bool fine = !by_position || join_doubles(&s, threads);
    if (fine && !flatten(&s)) {
        number = malloc(mesh->vertex_count * sizeof *number);
        fine = number != NULL;
        if (fine && !number_roots(&s, number, most, &out->count)) out->count = 0;
    }
    free(s.parent);
    if (fine && out->count > 1)
        out->of_vertex = number;
    else
        free(number);
    return fine;
}
