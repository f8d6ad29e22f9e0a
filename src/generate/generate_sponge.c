/* A Menger sponge: a mesh of the boundary of a small sponge, and nested groups of twenty instances of it.
 *
 * The boundary of a sponge of depth b has 2·20^b + 4·8^b unit squares. With b from 0 (a cube) to 4 and any
 * depth of nesting, the number of triangles is close to any request. */
#include "generate/generate.h"

#include <stdlib.h>
#include <string.h>

/* At most 672,768 stored triangles and 160,000 instances. */
#define DEEPEST_MESH 4u
#define DEEPEST_NEST 4u

typedef struct sponge {
    unsigned mesh_depth, nest_depth;
} sponge;

static uint64_t power(uint64_t base, unsigned exponent) {
    uint64_t result = 1;
    while (exponent--) result *= base;
    return result;
}

static uint64_t boundary_triangles(unsigned depth) { return 4 * power(20, depth) + 8 * power(8, depth); }

/* The sponge with the closest number of triangles; of two, the one with fewer instances. */
static sponge nearest_sponge(uint64_t triangles) {
    sponge best = {0, 0};
    uint64_t least = UINT64_MAX;
    for (unsigned nest = 0; nest <= DEEPEST_NEST; ++nest) {
        for (unsigned mesh = 0; mesh <= DEEPEST_MESH; ++mesh) {
            uint64_t count = boundary_triangles(mesh) * power(20, nest);
            uint64_t off = count > triangles ? count - triangles : triangles - count;
            if (off < least) least = off, best = (sponge){mesh, nest};
        }
    }
    return best;
}

/* False for an empty cell: at some depth it lies in the middle of its parent along two or three axes. */
static bool solid(unsigned depth, uint32_t x, uint32_t y, uint32_t z) {
    for (unsigned d = 0; d < depth; ++d, x /= 3, y /= 3, z /= 3)
        if ((x % 3 == 1) + (y % 3 == 1) + (z % 3 == 1) >= 2) return false;
    return true;
}

typedef struct sponge_mesher {
    unsigned depth;
    uint32_t cells;  /* along an edge: 3^depth */
    uint32_t *named; /* lattice point -> vertex + 1; 0: not used yet */
    generate_mesh mesh;
    uint32_t vertices, triangles; /* so far; the arrays may be NULL, for counting only */
} sponge_mesher;

static uint32_t lattice_vertex(sponge_mesher *m, const uint32_t p[3]) {
    uint32_t side = m->cells + 1, *name = &m->named[(p[2] * side + p[1]) * side + p[0]];
    if (!*name) {
        float *position = m->mesh.positions ? m->mesh.positions + (size_t)m->vertices * 3 : NULL;
        for (int a = 0; position && a < 3; ++a) position[a] = (float)(2.0 * p[a] / m->cells - 1);
        *name = ++m->vertices;
    }
    return *name - 1;
}

/* The face of cell c towards +axis (side 1) or -axis (side 0), facing out. */
static void add_face(sponge_mesher *m, const uint32_t c[3], int axis, uint32_t side) {
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    uint32_t corner[4];
    for (uint32_t k = 0; k < 4; ++k) {
        uint32_t p[3];
        p[axis] = c[axis] + side;
        p[u] = c[u] + (k == 1 || k == 2);
        p[v] = c[v] + (k >= 2);
        corner[side ? k : 3 - k] = lattice_vertex(m, p);
    }
    uint32_t *t = m->mesh.indices ? m->mesh.indices + (size_t)m->triangles * 3 : NULL;
    m->triangles += 2;
    if (!t) return;
    t[0] = t[3] = corner[0], t[1] = corner[1], t[2] = t[4] = corner[2], t[5] = corner[3];
}

static void add_cell(sponge_mesher *m, const uint32_t c[3]) {
    for (int axis = 0; axis < 3; ++axis) {
        for (uint32_t side = 0; side < 2; ++side) {
            uint32_t n[3] = {c[0], c[1], c[2]};
            n[axis] += side ? 1u : UINT32_MAX; /* -1 wraps to a large number, which is also outside */
            if (n[axis] < m->cells && solid(m->depth, n[0], n[1], n[2])) continue;
            add_face(m, c, axis, side);
        }
    }
}

static void mesh_pass(sponge_mesher *m) {
    uint32_t side = m->cells + 1, c[3];
    memset(m->named, 0, (size_t)side * side * side * sizeof *m->named);
    m->vertices = m->triangles = 0;
    for (c[2] = 0; c[2] < m->cells; ++c[2]) {
        for (c[1] = 0; c[1] < m->cells; ++c[1]) {
            for (c[0] = 0; c[0] < m->cells; ++c[0])
                if (solid(m->depth, c[0], c[1], c[2])) add_cell(m, c);
        }
    }
}

/* Two passes: the first counts the vertices. */
static fathom_status add_boundary(fathom_scene *scene, fathom_id group, unsigned depth, fathom_id material) {
    sponge_mesher m = {.depth = depth, .cells = (uint32_t)power(3, depth)};
    size_t side = m.cells + 1, bytes = side * side * side * sizeof *m.named;
    m.named = malloc(bytes);
    if (!m.named) return fail_memory(scene->context, bytes);
    mesh_pass(&m);
    fathom_status status = generate_allocate(scene, m.vertices, m.triangles, 0, &m.mesh);
    if (status == FATHOM_OK) mesh_pass(&m);
    free(m.named);
    return status == FATHOM_OK ? generate_finish(scene, group, &m.mesh, material) : status;
}

/* Adds twenty instances of `group`, scaled to a third, to `parent`: the next level. */
static fathom_status add_twenty(fathom_scene *scene, fathom_id group, fathom_id parent) {
    fathom_status status = FATHOM_OK;
    for (uint32_t cell = 0; cell < 27 && status == FATHOM_OK; ++cell) {
        uint32_t p[3] = {cell % 3, cell / 3 % 3, cell / 9};
        if (!solid(1, p[0], p[1], p[2])) continue;
        fathom_instance instance;
        fathom_instance_default(&instance);
        instance.group = group, instance.parent = parent;
        for (int a = 0; a < 3; ++a) {
            instance.transform[5 * a] = 1.0 / 3;
            instance.transform[4 * a + 3] = 2.0 * ((double)p[a] - 1) / 3;
        }
        status = fathom_scene_add_instance(scene, &instance, NULL);
    }
    return status;
}

fathom_status generate_sponge(fathom_scene *scene, fathom_id group, const fathom_generate_options *options) {
    sponge s = nearest_sponge(options->triangles);
    fathom_status status = FATHOM_OK;
    /* From the outermost level inwards; each level except the first has its own group. */
    for (unsigned level = s.nest_depth; level > 0 && status == FATHOM_OK; --level) {
        fathom_id inner;
        status = fathom_scene_add_group(scene, "sponge", &inner);
        if (status == FATHOM_OK) status = add_twenty(scene, inner, group);
        group = inner;
    }
    return status == FATHOM_OK ? add_boundary(scene, group, s.mesh_depth, options->material) : status;
}
