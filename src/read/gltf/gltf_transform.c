/* Transforms of nodes: their components, which an animation may replace, and the product of the transforms
 * above each node, in double. */
#include "read/gltf/gltf_pose.h"
#include "read/gltf/gltf_tree.h"

#include <math.h>

static affine_f64 read_matrix(gltf *g, const gltf_value *node) {
    double m[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    gltf_numbers(g, node, "matrix", 16, -INFINITY, INFINITY, m);
    gltf_check_row(g, node, "matrix", (const double[4]){m[3], m[7], m[11], m[15]});
    return affine_of_columns(m);
}

void gltf_check_row(gltf *g, const gltf_value *at, const char *key, const double row[4]) {
    const double off = fmax(fmax(fabs(row[0]), fabs(row[1])), fmax(fabs(row[2]), fabs(row[3] - 1)));
    if (off > 0x1p-12)
        gltf_fail(g, at, key, "has the last row %g %g %g %g; expected 0 0 0 1", row[0], row[1], row[2],
                  row[3]);
    else if (off > 0)
        gltf_note(g, at, key, "a matrix whose last row is off by a little; 0 0 0 1 is taken");
}

bool gltf_is_rotation(const double r[4]) { return r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3] > 0; }

affine_f64 gltf_compose(double parts[GLTF_PARTS][4]) {
    affine_f64 scaling = affine_scaling(load_f64(parts[GLTF_SCALE])),
               rotation = affine_rotation(parts[GLTF_ROTATION]);
    affine_f64 out = affine_compose(&rotation, &scaling);
    for (int i = 0; i < 3; ++i) out.m[i][3] = parts[GLTF_TRANSLATION][i];
    return out;
}

bool gltf_has_matrix(const gltf_value *node) { return json_is_array(json_object_get(node->json, "matrix")); }

static void note_parts(gltf *g, const gltf_value *node) {
    for (int i = 0; i < GLTF_PARTS; ++i) {
        if (json_object_get(node->json, gltf_part_names[i]))
            gltf_note(g, node, gltf_part_names[i],
                      "a node has a matrix and parts of a transform; the matrix counts");
    }
}

/* Values of an animation replace the node's own. */
static affine_f64 read_local(gltf *g, const gltf_value *node, const gltf_pose *pose) {
    if (gltf_has_matrix(node)) {
        note_parts(g, node);
        return read_matrix(g, node);
    }
    double parts[GLTF_PARTS][4] = {{0, 0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1, 0}};
    for (int i = 0; i < GLTF_PARTS; ++i) {
        const bool rotation = i == GLTF_ROTATION;
        const double most = rotation ? 1e30 : (double)INFINITY;
        gltf_numbers(g, node, gltf_part_names[i], rotation ? 4 : 3, -most, most, parts[i]);
        for (int c = 0; pose && pose->given[i] && c < 4; ++c) parts[i][c] = pose->parts[i][c];
    }
    if (!gltf_is_rotation(parts[GLTF_ROTATION])) {
        gltf_note(g, node, gltf_part_names[GLTF_ROTATION], "a rotation of zeros turns nothing");
        parts[GLTF_ROTATION][3] = 1;
    }
    return gltf_compose(parts);
}

const gltf_pose *gltf_pose_of(const gltf_moment *m, uint32_t node) {
    return m->pose_of && m->pose_of[node] ? &m->poses.items[m->pose_of[node] - 1] : NULL;
}

/* Goes up to the first node whose transform is known, then down again. So each link is computed once. */
affine_f64 gltf_node_world(gltf *g, gltf_moment *m, uint32_t link) {
    affine_f64 above = affine_identity();
    ARRAY(uint32_t) below = {NULL, 0, 0};
    uint32_t at = link;
    for (; at != GLTF_ABSENT && !m->worlds[at].known && gltf_fine(g); at = g->links.items[at].parent) {
        if (!array_push(&below, at)) gltf_fail_memory(g, sizeof at);
    }
    if (at != GLTF_ABSENT) above = m->worlds[at].to_world;
    while (below.count && gltf_fine(g)) {
        gltf_value value;
        at = below.items[--below.count];
        const uint32_t node = g->links.items[at].node;
        gltf_item(g, &g->nodes, node, &value);
        const bool quiet = g->quiet;
        g->quiet |= g->told[node];
        const affine_f64 local = read_local(g, &value, gltf_pose_of(m, node));
        g->quiet = quiet, g->told[node] = true;
        above = affine_compose(&above, &local);
        m->worlds[at] = (gltf_world){.known = true, .to_world = above};
    }
    array_free(&below);
    return above;
}
