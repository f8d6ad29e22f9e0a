/* A mesh has no boundary if its directed edges cancel: for each edge from a to b there is one from b to a.
 * Each vertex v gets two numbers x(v) and y(v). The term x(a) y(b) - x(b) y(a) of an edge cancels that of the
 * reverse edge, so the sum over all edges of all triangles, modulo 2^64, is zero if the mesh is closed. In an
 * open mesh the boundary edges remain: each boundary vertex b contributes y(b) times the difference of x at
 * its two neighbours. If x is different for all vertices and y is pseudo-random, the sum is zero with a
 * probability of about 2^-32. (This is a linear map of the chain's boundary; it needs no lookup of edges.)
 *
 * The numbers first come from vertex indices; that sum is computed when a mesh is added. Meshes with
 * duplicate vertices along seams then look open, so for these the numbers come from the positions. */
#include "scene/mesh/closed.h"

#include "base/threads.h"
#include "scene/kernels.h"

#include <stdatomic.h>
#include <stdlib.h>

#define GRAIN ((size_t)1 << 15)

static boundary_pair of_position(const fathom_mesh *mesh, size_t v) {
    uint32_t bits[3];
    closed_position_bits(mesh, v, bits);
    uint32_t h = boundary_mixed(bits[0] + 0x9e3779b9u);
    h = boundary_mixed((h ^ bits[1]) * 0x01000193u + 0x7f4a7c15u);
    h = boundary_mixed((h ^ bits[2]) * 0x01000193u + 0x3c6ef372u);
    return (boundary_pair){h, boundary_mixed(h + 0x7f4a7c15u)};
}

typedef struct sum {
    const fathom_mesh *mesh;
    boundary_pair *pairs;   /* by vertex, from its position */
    _Atomic uint64_t total; /* modulo 2^64, so the order does not matter */
} sum;

static void set_pairs(void *user, size_t begin, size_t end) {
    const sum *s = user;
    for (size_t i = begin; i < end; ++i) s->pairs[i] = of_position(s->mesh, i);
}

static void add_by_position(void *user, size_t begin, size_t end) {
    sum *s = user;
    const uint32_t *t = s->mesh->indices;
    uint64_t total = 0;
    for (size_t i = 3 * begin; i < 3 * end; i += 3)
        total += boundary_sum(s->pairs[t[i]], s->pairs[t[i + 1]], s->pairs[t[i + 2]]);
    atomic_fetch_add(&s->total, total);
}

/* *left: the sum of the mesh by index if that is 0, else by position; 0: the mesh is closed. False when out
 * of memory. */
static bool open_sum(unsigned threads, const fathom_mesh *mesh, const mesh_facts *facts, uint64_t *left) {
    *left = facts->boundary;
    if (!*left) return true;
    sum s = {.mesh = mesh, .pairs = malloc(mesh->vertex_count * sizeof *s.pairs)};
    if (!s.pairs) return false;
    loop_parallel(threads, mesh->vertex_count, GRAIN, set_pairs, &s);
    loop_parallel(threads, mesh->triangle_count, GRAIN, add_by_position, &s);
    *left = atomic_load(&s.total);
    free(s.pairs);
    return true;
}

static bool is_open_mesh(const world *w, uint32_t geometry, const closed_how *closed) {
    return w->geometries.items[geometry].kind == WORLD_MESH && closed[geometry] == CLOSED_NOT;
}

/* Finds the closed meshes among the geometries [first, end) of one group. */
static bool find_in_group(const world *w, uint32_t first, uint32_t end, closed_how *closed) {
    unsigned threads = fathom_context_threads(w->scene->context);
    uint64_t together = 0;
    for (uint32_t i = first; i < end; ++i) {
        uint64_t left;
        if (!is_open_mesh(w, i, closed)) continue;
        uint32_t mesh = w->geometries.items[i].first;
        if (!open_sum(threads, &w->meshes.items[mesh], &w->mesh_facts.items[mesh], &left)) return false;
        if (!left) closed[i] = CLOSED_ALONE;
        together += left;
    }
    for (uint32_t i = first; i < end && !together; ++i) {
        if (is_open_mesh(w, i, closed)) closed[i] = CLOSED_TOGETHER;
    }
    return true;
}

bool closed_find(const world *w, closed_how *closed) {
    bool fine = true;
    for (size_t i = 0; i < w->geometries.count; ++i) closed[i] = CLOSED_NOT;
    for (size_t g = 0; g < w->groups.count && fine; ++g) {
        uint32_t first = w->groups.items[g].first, end = first + w->groups.items[g].count;
        fine = find_in_group(w, first, end, closed);
    }
    return fine;
}
