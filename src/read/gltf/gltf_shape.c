/* How nodes deform their meshes. Nodes with the same mesh, skin and weights, at all moments, share one posed
 * mesh. */
#include "base/hash.h"
#include "read/gltf/gltf_mesh.h"
#include "read/gltf/gltf_pose.h"

#include <stdlib.h>
#include <string.h>

/* Posed meshes in a hash table. There are at most as many as nodes, or as meshes if there are no nodes. */
struct gltf_posed {
    uint64_t hash;
    uint32_t next; /* in the same place of the table: its index plus 1; 0: none */
    uint32_t mesh, skin;
    bool mirrored, flat, moves;
    gltf_shape *shapes; /* one for each moment if it moves, else one; owned */
    fathom_id group;    /* or GLTF_EMPTY */
};

static size_t shape_count(const gltf *g, const gltf_posed *p) { return p->moves ? g->moments.count : 1; }

static void free_shapes(gltf_shape *shapes, size_t count) {
    for (size_t k = 0; shapes && k < count; ++k) free(shapes[k].weights);
    free(shapes);
}

void gltf_posed_close(gltf *g) {
    for (size_t i = 0; i < g->posed_meshes.count; ++i)
        free_shapes(g->posed_meshes.items[i].shapes, shape_count(g, &g->posed_meshes.items[i]));
    array_free(&g->posed_meshes);
    free(g->posed_table);
}

/* ---- keys ---- */

static void read_shape(gltf *g, gltf_moment *m, const gltf_value *node, const gltf_posed *p,
                       gltf_shape *out) {
    gltf_value mesh;
    gltf_item(g, &g->meshes, p->mesh, &mesh);
    gltf_weights_read(g, node ? gltf_pose_of(m, (uint32_t)node->at.index) : NULL, node, &mesh, out);
    if (p->skin != GLTF_ABSENT && gltf_fine(g)) out->joints = gltf_skin_read(g, m, p->skin, p->mirrored);
}

static void keep_first(gltf_posed *p, size_t moments) {
    for (size_t k = 1; k < moments; ++k) free(p->shapes[k].weights);
    gltf_shape *one = realloc(p->shapes, sizeof *one);
    if (one) p->shapes = one;
}

static void flatten(gltf *g, const gltf_value *node, const gltf_way *way, size_t k, gltf_shape *out) {
    if (gltf_fine(g))
        out->joints = gltf_skin_flatten(g, node, &way->at[k], affine_point(&way->at[0], (vec3_f64){0, 0, 0}));
}

/* Reads the shapes at all moments, and keeps one if they do not differ. */
static void read_key(gltf *g, const gltf_value *node, uint32_t mesh, const gltf_way *way, gltf_posed *out) {
    const size_t moments = g->moments.count;
    *out = (gltf_posed){.mesh = mesh, .skin = GLTF_ABSENT, .moves = true};
    if (node) gltf_index(g, node, "skin", &g->skins, &out->skin);
    out->mirrored = out->skin != GLTF_ABSENT && gltf_way_mirrors(way);
    out->flat = out->skin == GLTF_ABSENT && gltf_way_flattens(way);
    out->shapes = calloc(moments, sizeof *out->shapes);
    if (!out->shapes) gltf_fail_memory(g, moments * sizeof *out->shapes);
    for (size_t k = 0; k < moments && gltf_fine(g); ++k) {
        g->quiet = k > 0;
        read_shape(g, &g->moments.items[k], node, out, &out->shapes[k]);
        if (out->flat) flatten(g, node, way, k, &out->shapes[k]);
    }
    g->quiet = false;
    if (!gltf_fine(g)) return;
    out->moves = gltf_shapes_move(out->shapes, moments);
    if (!out->moves) keep_first(out, moments);
    hash h;
    hash_begin(&h);
    hash_put(&h, (uint32_t[]){mesh, out->skin}, 2 * sizeof(uint32_t));
    for (size_t k = 0; k < shape_count(g, out); ++k)
        hash_put(&h, out->shapes[k].weights, out->shapes[k].weight_count * sizeof(double));
    out->hash = hash_end(&h);
}

static bool same_key(const gltf *g, const gltf_posed *a, const gltf_posed *b) {
    if (a->flat || b->flat) return false;
    if (a->hash != b->hash || a->mesh != b->mesh || a->skin != b->skin || a->mirrored != b->mirrored ||
        a->moves != b->moves)
        return false;
    for (size_t k = 0; k < shape_count(g, a); ++k) {
        const gltf_shape *x = &a->shapes[k], *y = &b->shapes[k];
        if (x->weight_count != y->weight_count) return false;
        if (x->weight_count && memcmp(x->weights, y->weights, x->weight_count * sizeof *x->weights) != 0)
            return false;
    }
    return true;
}

/* ---- the table ---- */

static size_t table_size(const gltf *g) { return gltf_count(&g->nodes) + gltf_count(&g->meshes) + 1; }

static bool be_open(gltf *g) {
    if (!g->posed_table) g->posed_table = calloc(table_size(g), sizeof *g->posed_table);
    if (!g->posed_table) gltf_fail_memory(g, table_size(g) * sizeof *g->posed_table);
    return gltf_fine(g);
}

static const gltf_posed *find(const gltf *g, const gltf_posed *key) {
    uint32_t i = g->posed_table[key->hash % table_size(g)];
    for (; i; i = g->posed_meshes.items[i - 1].next) {
        if (same_key(g, &g->posed_meshes.items[i - 1], key)) return &g->posed_meshes.items[i - 1];
    }
    return NULL;
}

/* The table then owns the shapes of `made`. */
static void keep(gltf *g, gltf_posed *made) {
    uint32_t *place = &g->posed_table[made->hash % table_size(g)];
    made->next = *place;
    if (array_push(&g->posed_meshes, *made))
        *place = (uint32_t)g->posed_meshes.count, made->shapes = NULL;
    else
        gltf_fail_memory(g, sizeof *made);
}

fathom_id gltf_shape_mesh(gltf *g, const gltf_value *node, uint32_t mesh, const gltf_way *way,
                          const gltf_joints **joints) {
    gltf_posed key = {.shapes = NULL};
    fathom_id group = GLTF_EMPTY;
    if (be_open(g)) read_key(g, node, mesh, way, &key);
    if (gltf_fine(g)) {
        *joints = key.shapes->joints;
        const gltf_posed *shared = find(g, &key);
        group = shared ? shared->group : gltf_mesh_group(g, mesh, key.shapes, key.moves);
        key.group = group;
        if (!shared && gltf_fine(g)) keep(g, &key);
    }
    free_shapes(key.shapes, shape_count(g, &key));
    return group;
}
