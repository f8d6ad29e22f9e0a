/* Where nodes are: the parts of their transforms, which an animation may replace, and the product of the
 * transforms above each, in double. */
#include "read/gltf/gltf.h"

#include <math.h>
#include <stdlib.h>

static fathom_status read_matrix(gltf *g, const gltf_value *node, affine_f64 *out) {
    double m[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    fathom_status status = gltf_numbers(g, node, "matrix", 16, -INFINITY, INFINITY, m);
    if (status != FATHOM_OK) return status;
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
        return gltf_fail(g, node, "matrix", "has the last row %g %g %g %g; expected 0 0 0 1", m[3], m[7],
                         m[11], m[15]);
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) out->m[row][column] = m[column * 4 + row];
    }
    return FATHOM_OK;
}

bool gltf_is_rotation(const double r[4]) { return r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3] > 0; }

affine_f64 gltf_compose(double parts[GLTF_PARTS][4]) {
    affine_f64 scaling = affine_scaling(load_f64(parts[GLTF_SCALE])),
               rotation = affine_rotation(parts[GLTF_ROTATION]);
    affine_f64 out = affine_compose(&rotation, &scaling);
    for (int i = 0; i < 3; ++i) out.m[i][3] = parts[GLTF_TRANSLATION][i];
    return out;
}

static fathom_status check_no_parts(gltf *g, const gltf_value *node, const gltf_pose *pose) {
    for (int i = 0; i < GLTF_PARTS; ++i) {
        if (json_object_get(node->json, gltf_part_names[i]))
            return gltf_fail(g, node, gltf_part_names[i],
                             "is given together with a matrix; expected one or the other");
        if (pose && pose->given[i])
            return gltf_fail(g, node, "matrix",
                             "is that of a node whose %s is animated; expected translation, rotation and "
                             "scale there",
                             gltf_part_names[i]);
    }
    return FATHOM_OK;
}

/* Values that an animation gives replace the node's own. */
static fathom_status read_local(gltf *g, const gltf_value *node, const gltf_pose *pose, affine_f64 *out) {
    if (json_object_get(node->json, "matrix")) {
        fathom_status status = check_no_parts(g, node, pose);
        return status == FATHOM_OK ? read_matrix(g, node, out) : status;
    }
    double parts[GLTF_PARTS][4] = {{0, 0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1, 0}};
    fathom_status status = FATHOM_OK;
    for (int i = 0; i < GLTF_PARTS && status == FATHOM_OK; ++i) {
        const bool rotation = i == GLTF_ROTATION;
        const double most = rotation ? 1e30 : (double)INFINITY;
        status = gltf_numbers(g, node, gltf_part_names[i], rotation ? 4 : 3, -most, most, parts[i]);
        for (int c = 0; pose && pose->given[i] && c < 4; ++c) parts[i][c] = pose->parts[i][c];
    }
    if (status != FATHOM_OK) return status;
    if (!gltf_is_rotation(parts[GLTF_ROTATION]))
        return gltf_fail(g, node, gltf_part_names[GLTF_ROTATION],
                         "is zero; expected a unit quaternion x, y, z, w");
    *out = gltf_compose(parts);
    return FATHOM_OK;
}

const gltf_pose *gltf_pose_of(const gltf_moment *m, uint32_t node) {
    return m->pose_of && m->pose_of[node] ? &m->poses.items[m->pose_of[node] - 1] : NULL;
}

/* Climbs to the first node that is known, then comes down again: each node is computed once. */
fathom_status gltf_node_world(gltf *g, gltf_moment *m, uint32_t node, const affine_f64 **out) {
    const affine_f64 identity = affine_identity();
    ARRAY(uint32_t) below = {NULL, 0, 0};
    fathom_status status = FATHOM_OK;
    uint32_t at = node;
    for (; at < gltf_count(&g->nodes) && !m->worlds[at].known; at = g->parents[at]) {
        if (!array_push(&below, at)) status = fail_memory(g->context, sizeof at);
        if (status != FATHOM_OK) break;
    }
    const affine_f64 *above = at < gltf_count(&g->nodes) ? &m->worlds[at].to_world : &identity;
    while (below.count && status == FATHOM_OK) {
        gltf_value value;
        affine_f64 local;
        at = below.items[--below.count];
        status = gltf_item(g, &g->nodes, at, &value);
        if (status == FATHOM_OK) status = read_local(g, &value, gltf_pose_of(m, at), &local);
        if (status != FATHOM_OK) break;
        m->worlds[at] = (gltf_world){.known = true, .to_world = affine_compose(above, &local)};
        above = &m->worlds[at].to_world;
    }
    array_free(&below);
    *out = &m->worlds[node].to_world;
    return status;
}

fathom_status gltf_moment_open(gltf *g, double time, gltf_moment *m) {
    const size_t nodes = gltf_count(&g->nodes);
    *m = (gltf_moment){.time = time, .worlds = calloc(nodes + 1, sizeof *m->worlds)};
    return m->worlds ? FATHOM_OK : fail_memory(g->context, nodes * sizeof *m->worlds);
}

void gltf_moment_close(gltf_moment *m, const gltf *g) {
    for (size_t i = 0; m->skins && i < gltf_count(&g->skins); ++i) free(m->skins[i].matrices);
    free(m->skins);
    for (size_t i = 0; i < m->poses.count; ++i) free(m->poses.items[i].weights);
    array_free(&m->poses);
    free(m->pose_of);
    free(m->worlds);
}
