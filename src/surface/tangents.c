#include "surface/tangents.h"

#include "base/memory.h"

#include <stdlib.h>

/* Orientation of the uvs on a triangle: degenerate, v to the right of u, or v to the left. */
enum { LIES_NOT, LIES_RIGHT, LIES_LEFT };

struct surface_tangents {
    unsigned set;
    uint8_t *lies;          /* of each triangle */
    uint32_t *vertex;       /* of each corner; NULL: the mesh's indices */
    vec3_f32 (*tangent)[2]; /* of each vertex, separately for mirrored and unmirrored triangles */
};

#define MOST_CORNERS ((size_t)1 << 24)

static const uint32_t *uv_indices(const fathom_mesh *m, unsigned set) {
    return set == 0 && m->uv_indices ? m->uv_indices : m->indices;
}
static const uint32_t *normal_indices(const fathom_mesh *m) {
    return m->normal_indices ? m->normal_indices : m->indices;
}

/* ---- corners that are the same vertex ---- */

static uint64_t mixed(uint64_t x) {
    x ^= x >> 32, x *= UINT64_C(0xd6e8feb86659fd93);
    x ^= x >> 32, x *= UINT64_C(0xd6e8feb86659fd93);
    return x ^ x >> 32;
}

static bool same_corner(const fathom_mesh *m, unsigned set, size_t a, size_t b) {
    return m->indices[a] == m->indices[b] && normal_indices(m)[a] == normal_indices(m)[b] &&
           uv_indices(m, set)[a] == uv_indices(m, set)[b];
}

/* Numbers the vertices with an open-addressing hash table of the first corner of each. Returns their
 * number. */
static uint32_t number_vertices(const fathom_mesh *m, unsigned set, uint32_t *table, size_t mask,
                                uint32_t *vertex) {
    uint32_t count = 0;
    for (size_t i = 0; i < 3 * (size_t)m->triangle_count; ++i) {
        const uint64_t key =
            mixed(m->indices[i] ^ mixed(normal_indices(m)[i] ^ mixed(uv_indices(m, set)[i])));
        size_t at = (size_t)key & mask;
        while (table[at] && !same_corner(m, set, table[at] - 1, i)) at = (at + 1) & mask;
        if (!table[at]) {
            table[at] = (uint32_t)i + 1;
            vertex[i] = count++;
        } else {
            vertex[i] = vertex[table[at] - 1];
        }
    }
    return count;
}

static bool match_corners(const fathom_mesh *m, surface_tangents *t, uint32_t *count) {
    const size_t corners = 3 * (size_t)m->triangle_count;
    size_t room = 16;
    while (room < 2 * corners) room *= 2;
    uint32_t *table = calloc(room, sizeof *table);
    t->vertex = malloc(corners * sizeof *t->vertex);
    if (table && t->vertex) *count = number_vertices(m, t->set, table, room - 1, t->vertex);
    free(table);
    return t->vertex && *count;
}

/* ---- sums ---- */

static bool make_unit(vec3_f32 *v) {
    const float length = length_f32(*v);
    if (!(length > 0) || !isfinite(length)) return false;
    *v = scale_f32(1 / length, *v);
    return true;
}

static vec3_f32 across(vec3_f32 n, vec3_f32 v) { return sub_f32(v, scale_f32(dot_f32(n, v), n)); }

/* The tangent (direction of u) on the triangle, and whether v runs to the left of it. False: the uvs are
 * degenerate. */
static bool way_of_u(const fathom_mesh *m, unsigned set, uint32_t triangle, vec3_f32 *way, bool *left) {
    const uint32_t *p = m->indices + 3 * (size_t)triangle, *uv = uv_indices(m, set) + 3 * (size_t)triangle;
    vec3_f32 at[3];
    const float *to[3];
    for (int k = 0; k < 3; ++k) {
        at[k] = load_f32(mesh_vertex(m, p[k]));
        to[k] = set ? mesh_row(m->uvs_1, m->uv_1_stride, uv[k]) : mesh_row(m->uvs, m->uv_stride, uv[k]);
    }
    const float bu = to[1][0] - to[0][0], bv = to[1][1] - to[0][1];
    const float cu = to[2][0] - to[0][0], cv = to[2][1] - to[0][1], area = bu * cv - cu * bv;
    *left = area > 0;
    *way = sub_f32(scale_f32(cv, sub_f32(at[1], at[0])), scale_f32(bv, sub_f32(at[2], at[0])));
    if (area < 0) *way = neg_f32(*way);
    return area != 0 && make_unit(way);
}

/* The triangle's angle at corner k, projected along the normal. */
static float angle_at(const fathom_mesh *m, const uint32_t *p, int k, vec3_f32 n) {
    const vec3_f32 at = load_f32(mesh_vertex(m, p[k]));
    vec3_f32 a = across(n, sub_f32(load_f32(mesh_vertex(m, p[(k + 1) % 3])), at));
    vec3_f32 b = across(n, sub_f32(load_f32(mesh_vertex(m, p[(k + 2) % 3])), at));
    if (!make_unit(&a) || !make_unit(&b)) return 0;
    const float cosine = dot_f32(a, b);
    return acosf(cosine > 1 ? 1 : cosine < -1 ? -1 : cosine);
}

static uint32_t vertex_of(const surface_tangents *t, const fathom_mesh *m, size_t corner) {
    return t->vertex ? t->vertex[corner] : m->indices[corner];
}

static void add_triangle(const fathom_mesh *m, uint32_t triangle, surface_tangents *t) {
    vec3_f32 way;
    bool left;
    if (!way_of_u(m, t->set, triangle, &way, &left)) return;
    t->lies[triangle] = left ? LIES_LEFT : LIES_RIGHT;
    for (int k = 0; k < 3; ++k) {
        const size_t corner = 3 * (size_t)triangle + (size_t)k;
        vec3_f32 n = load_f32(mesh_row(m->normals, m->normal_stride, normal_indices(m)[corner]));
        if (!make_unit(&n)) continue;
        vec3_f32 along = across(n, way);
        if (!make_unit(&along)) continue;
        vec3_f32 *sum = &t->tangent[vertex_of(t, m, corner)][left];
        *sum = madd_f32(*sum, angle_at(m, m->indices + 3 * (size_t)triangle, k, n), along);
    }
}

fathom_status surface_tangents_make(fathom_context *context, const fathom_mesh *m, unsigned set,
                                    surface_tangents **out) {
    const bool matched = m->normal_indices || (set == 0 && m->uv_indices);
    uint32_t count = m->vertex_count;
    surface_tangents made = {.set = set};
    *out = NULL;
    if (!m->normals || !(set ? m->uvs_1 : m->uvs)) return FATHOM_OK;
    if (matched && 3 * (size_t)m->triangle_count > MOST_CORNERS) return FATHOM_OK;
    bool fine = !matched || match_corners(m, &made, &count);
    const size_t bytes = sizeof made + count * sizeof *made.tangent + m->triangle_count;
    surface_tangents *t = fine && memory_has(bytes) ? calloc(1, bytes) : NULL;
    if (!t) {
        free(made.vertex);
        return fail_memory(context, bytes);
    }
    *t = made;
    t->tangent = (void *)(t + 1);
    t->lies = (uint8_t *)(t->tangent + count);
    for (uint32_t i = 0; i < m->triangle_count; ++i) add_triangle(m, i, t);
    for (uint32_t i = 0; i < count; ++i) {
        for (int side = 0; side < 2; ++side) {
            if (!make_unit(&t->tangent[i][side])) t->tangent[i][side] = (vec3_f32){0, 0, 0};
        }
    }
    *out = t;
    return FATHOM_OK;
}

void surface_tangents_free(surface_tangents *t) {
    if (t) free(t->vertex);
    free(t);
}

bool surface_tangents_at(const surface_tangents *t, const fathom_mesh *m, uint32_t triangle,
                         const float weight[3], vec3_f32 *tangent) {
    vec3_f32 sum = {0, 0, 0};
    if (t->lies[triangle] == LIES_NOT) return false;
    const bool left = t->lies[triangle] == LIES_LEFT;
    for (size_t k = 0; k < 3; ++k)
        sum = madd_f32(sum, weight[k], t->tangent[vertex_of(t, m, 3 * (size_t)triangle + k)][left]);
    *tangent = sum;
    return dot_f32(sum, sum) > 0x1p-20f;
}
