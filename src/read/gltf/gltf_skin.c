/* Skins: each vertex is transformed by the weighted sum of its joints' matrices, from mesh to world space.
 * The transform of the mesh's own node is not used (specification, 3.7.3.2), except that triangles wind the
 * other way if it mirrors (3.7.2.1).
 *
 * Positions become float here, so they are relative to the first joint: a figure far from the origin keeps
 * its digits. Normals are transformed by the cofactor matrix, so that they stay perpendicular to the surface
 * for any scale of the joints, and on its side if they mirror. */
#include "base/threads.h"
#include "read/gltf/gltf_data.h"
#include "read/gltf/gltf_mesh.h"
#include "read/gltf/gltf_pose.h"

#include <stdio.h>
#include <stdlib.h>

/* ---- joints ---- */

/* False: there are no inverse bind matrices. */
static bool read_inverse(gltf *g, const gltf_value *skin, uint32_t joints, gltf_elements *out) {
    if (!gltf_array_read(g, skin, "inverseBindMatrices", 16, GLTF_TAKES_FLOAT, out)) return false;
    if (out->count < joints)
        gltf_fail(g, skin, "inverseBindMatrices", "has %u entries; expected one for each of %u joints",
                  out->count, joints);
    for (uint32_t i = 0; i < joints && gltf_fine(g); ++i) {
        const float *m = gltf_element(out, i);
        gltf_check_row(g, skin, "inverseBindMatrices",
                       (const double[4]){(double)m[3], (double)m[7], (double)m[11], (double)m[15]});
    }
    return gltf_fine(g);
}

static affine_f64 matrix_at(const gltf_elements *matrices, uint32_t i) {
    double m[16];
    for (int k = 0; k < 16; ++k) m[k] = (double)gltf_element(matrices, i)[k];
    return affine_of_columns(m);
}

static void fill_joints(gltf *g, gltf_moment *m, const gltf_value *skin, const gltf_value *list,
                        gltf_joints *out) {
    gltf_elements inverse;
    const bool bound = read_inverse(g, skin, out->count, &inverse);
    for (uint32_t i = 0; i < out->count && gltf_fine(g); ++i) {
        uint32_t node = GLTF_ABSENT;
        gltf_index_item(g, list, i, &g->nodes, &node);
        if (!gltf_fine(g)) return;
        affine_f64 moved = gltf_node_world(g, m, node),
                   bind = bound ? matrix_at(&inverse, i) : affine_identity();
        if (i == 0 && m == g->moments.items) out->origin = affine_point(&moved, (vec3_f64){0, 0, 0});
        moved.m[0][3] -= out->origin.x, moved.m[1][3] -= out->origin.y, moved.m[2][3] -= out->origin.z;
        for (int c = 0; out->mirrored && c < 4; ++c) moved.m[0][c] = -moved.m[0][c];
        out->matrices[i] = affine_compose(&moved, &bind);
    }
}

const gltf_joints *gltf_skin_read(gltf *g, gltf_moment *m, uint32_t index, bool mirrored) {
    const size_t count = 2 * gltf_count(&g->skins);
    gltf_value skin, list;
    if (!m->skins) m->skins = calloc(count + 1, sizeof *m->skins);
    if (!m->skins) {
        gltf_fail_memory(g, count * sizeof *m->skins);
        return NULL;
    }
    gltf_joints *joints = &m->skins[2 * (size_t)index + mirrored];
    if (joints->matrices) return joints;
    joints->mirrored = mirrored;
    if (m != g->moments.items) {
        const gltf_joints *first = gltf_skin_read(g, g->moments.items, index, mirrored);
        if (first) joints->origin = first->origin;
    }
    gltf_item(g, &g->skins, index, &skin);
    gltf_array(g, &skin, "joints", &list);
    if (!gltf_count(&list)) gltf_fail(g, &skin, "joints", "is empty; expected at least one node");
    if (!gltf_fine(g)) return NULL;
    joints->count = (uint32_t)gltf_count(&list);
    joints->matrices = malloc(joints->count * sizeof *joints->matrices);
    if (joints->matrices)
        fill_joints(g, m, &skin, &list, joints);
    else
        gltf_fail_memory(g, joints->count * sizeof *joints->matrices);
    return joints;
}

const gltf_joints *gltf_skin_flatten(gltf *g, const gltf_value *node, const affine_f64 *to_world,
                                     vec3_f64 origin) {
    void *memory;
    if (gltf_allocate(g, node, NULL, sizeof(gltf_joints) + sizeof(affine_f64), &memory) != FATHOM_OK)
        return NULL;
    affine_f64 *matrix = memory;
    gltf_joints *out = (gltf_joints *)(void *)(matrix + 1);
    *matrix = *to_world;
    matrix->m[0][3] -= origin.x, matrix->m[1][3] -= origin.y, matrix->m[2][3] -= origin.z;
    *out = (gltf_joints){.matrices = matrix, .count = 1, .flat = true, .origin = origin};
    return out;
}

/* ---- vertices ---- */

enum { SETS = 8 }; /* maximum sets of four joints for each vertex */

typedef struct skinning {
    const gltf_joints *joints;
    gltf_elements places[SETS], weights[SETS];
    unsigned sets, components;
    gltf_kind kind;
    gltf_elements from;
    float *to;
} skinning;

static double weight_of(const skinning *s, size_t i) {
    double sum = 0;
    for (unsigned k = 0; k < s->sets * 4; ++k) sum += (double)gltf_element(&s->weights[k / 4], i)[k % 4];
    return sum;
}

/* The matrix of vertex i. Weights are divided by their sum; if all are 0, the vertex follows its first
 * joint. */
static affine_f64 blend(const skinning *s, size_t i) {
    affine_f64 out = {{{0}}};
    if (s->joints->flat) return s->joints->matrices[0];
    const double sum = weight_of(s, i);
    if (!(sum > 0)) return s->joints->matrices[(uint32_t)gltf_element(&s->places[0], i)[0]];
    for (unsigned k = 0; k < s->sets * 4; ++k) {
        const double weight = (double)gltf_element(&s->weights[k / 4], i)[k % 4] / sum;
        if (weight == 0) continue;
        const affine_f64 *m = &s->joints->matrices[(uint32_t)gltf_element(&s->places[k / 4], i)[k % 4]];
        for (int e = 0; e < 12; ++e) out.m[e / 4][e % 4] += weight * m->m[e / 4][e % 4];
    }
    return out;
}

/* -1 if the map mirrors; not if it flattens, but for the rounding of floats. */
static double side_of(const affine_f64 *a) {
    double most = 0x1p-20;
    for (int i = 0; i < 3; ++i) most *= sqrt(dot_f64(load_f64(a->m[i]), load_f64(a->m[i])));
    return affine_determinant(a) < -most ? -1 : 1;
}

static vec3_f64 carry_normal(const affine_f64 *a, vec3_f64 n) {
    const vec3_f64 x = load_f64(a->m[0]), y = load_f64(a->m[1]), z = load_f64(a->m[2]);
    n = scale_f64(side_of(a), n);
    return normalize_f64(
        (vec3_f64){dot_f64(cross_f64(y, z), n), dot_f64(cross_f64(z, x), n), dot_f64(cross_f64(x, y), n)});
}

static void carry(void *user, size_t begin, size_t end) {
    const skinning *s = user;
    for (size_t i = begin; i < end; ++i) {
        const float *from = gltf_element(&s->from, i);
        float *to = s->to + i * s->components;
        const affine_f64 map = blend(s, i);
        vec3_f64 v = widen(load_f32(from));
        switch (s->kind) {
        case GLTF_POINT: v = affine_point(&map, v); break;
        case GLTF_NORMAL: v = carry_normal(&map, v); break;
        case GLTF_TANGENT: v = normalize_f64(affine_vector(&map, v)); break;
        }
        if (s->components == 4) to[3] = (float)side_of(&map) * from[3];
        store_f32(to, narrow(v));
    }
}

static void check_joint(gltf *g, const gltf_value *attributes, const char *key, size_t i, float joint,
                        uint32_t joints) {
    if (!(joint >= 0 && joint < (float)joints))
        gltf_fail(g, attributes, key, "entry %zu names joint %g; the skin has %u", i, (double)joint, joints);
}

/* A joint of weight 0 may be any number, except the first joint of a vertex without weights: blend() uses
 * it. */
static void check_joints(gltf *g, const gltf_value *attributes, const char *key, unsigned set,
                         const skinning *s) {
    for (size_t i = 0; i < s->places[set].count; ++i) {
        const float *joints = gltf_element(&s->places[set], i), *weights = gltf_element(&s->weights[set], i);
        for (int k = 0; k < 4; ++k) {
            if (weights[k] != 0) check_joint(g, attributes, key, i, joints[k], s->joints->count);
        }
    }
}

static void check_first_joints(gltf *g, const gltf_value *attributes, const skinning *s) {
    for (size_t i = 0; i < s->places[0].count; ++i) {
        if (!(weight_of(s, i) > 0))
            check_joint(g, attributes, "JOINTS_0", i, gltf_element(&s->places[0], i)[0], s->joints->count);
    }
}

/* Four numbers for each vertex. */
static void read_set(gltf *g, const gltf_value *attributes, const char *key, unsigned takes,
                     uint32_t vertices, gltf_elements *out) {
    if (gltf_array_read(g, attributes, key, 4, takes, out) && out->count != vertices)
        gltf_fail(g, attributes, key, "has %u entries; expected as many as POSITION has, %u", out->count,
                  vertices);
}

/* Reads JOINTS_0 and WEIGHTS_0, JOINTS_1 and WEIGHTS_1, … as long as both exist. */
static void read_sets(gltf *g, const gltf_value *attributes, uint32_t vertices, skinning *s) {
    for (unsigned n = 0; gltf_fine(g); ++n) {
        char places[32], weights[32];
        snprintf(places, sizeof places, "JOINTS_%u", n);
        snprintf(weights, sizeof weights, "WEIGHTS_%u", n);
        if (!json_object_get(attributes->json, places) || !json_object_get(attributes->json, weights)) break;
        if (n == SETS) {
            gltf_note(g, attributes, places, "joints beyond the first %d of a vertex are left out", SETS * 4);
            break;
        }
        read_set(g, attributes, places, GLTF_TAKES_FLOAT | GLTF_TAKES_UNSIGNED, vertices, &s->places[n]);
        read_set(g, attributes, weights, GLTF_TAKES_FLOAT | GLTF_TAKES_UNSIGNED, vertices, &s->weights[n]);
        if (gltf_fine(g)) check_joints(g, attributes, places, n, s);
        s->sets = n + 1;
    }
    if (!s->sets)
        gltf_fail(g, attributes, NULL, "lacks JOINTS_0 or WEIGHTS_0; expected both in a mesh with a skin");
    if (gltf_fine(g)) check_first_joints(g, attributes, s);
}

void gltf_skin_carry(gltf *g, const gltf_value *attributes, const gltf_joints *joints, gltf_kind kind,
                     gltf_elements *floats, float *to) {
    skinning s = {
        .joints = joints, .kind = kind, .from = *floats, .components = kind == GLTF_TANGENT ? 4 : 3};
    const size_t bytes = s.components * sizeof(float);
    void *memory = to;
    if (!joints->flat) read_sets(g, attributes, floats->count, &s);
    if (gltf_fine(g) && !to) gltf_allocate(g, attributes, NULL, floats->count * (uint64_t)bytes, &memory);
    if (!gltf_fine(g)) return;
    s.to = memory;
    loop_parallel(fathom_context_threads(g->context), floats->count, 1u << 12, carry, &s);
    floats->values = memory, floats->stride = bytes;
}
