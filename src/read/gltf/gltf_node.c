/* The hierarchy: each node with a mesh becomes an instance of the mesh's group, placed by the product of the
 * transforms above it, in double. */
#include "read/gltf/gltf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct step {
    uint32_t node;
    bool hidden; /* the node's parent is */
} step;

typedef ARRAY(step) walk;

/* ---- the graph ---- */

static fathom_status find_parents(gltf *g, uint32_t *parents) {
    uint32_t count = (uint32_t)gltf_count(&g->nodes);
    for (uint32_t i = 0; i < count; ++i) parents[i] = GLTF_ABSENT;
    for (uint32_t i = 0; i < count; ++i) {
        gltf_value node, children;
        fathom_status status = gltf_item(g, &g->nodes, i, &node);
        if (status == FATHOM_OK) status = gltf_array(g, &node, "children", &children);
        for (size_t k = 0; status == FATHOM_OK && k < gltf_count(&children); ++k) {
            uint32_t child = GLTF_ABSENT;
            status = gltf_index_item(g, &children, k, &g->nodes, &child);
            if (status != FATHOM_OK) return status;
            if (parents[child] != GLTF_ABSENT) {
                return gltf_fail(
                    g, &children, NULL,
                    "names nodes[%u], which is a child of nodes[%u] already; expected one parent", child,
                    parents[child]);
            }
            parents[child] = i;
        }
        if (status != FATHOM_OK) return status;
    }
    return FATHOM_OK;
}

/* Each node has one parent, so a node without a root above it lies on a cycle or below one. Every node is
 * visited once: `seen` holds the walk upwards that passed it. */
static fathom_status find_cycle(gltf *g, const uint32_t *parents) {
    uint32_t count = (uint32_t)gltf_count(&g->nodes);
    uint32_t *seen = calloc((size_t)count + 1, sizeof *seen), at = GLTF_ABSENT;
    if (!seen) return fail_memory(g->context, count * sizeof *seen);
    for (uint32_t i = 0; i < count && at == GLTF_ABSENT; ++i) {
        uint32_t k = i;
        while (k != GLTF_ABSENT && !seen[k]) {
            seen[k] = i + 1;
            k = parents[k];
        }
        if (k != GLTF_ABSENT && seen[k] == i + 1) at = k;
    }
    free(seen);
    if (at == GLTF_ABSENT) return FATHOM_OK;
    gltf_value node = {.parent = &g->nodes, .index = at};
    return gltf_fail(g, &node, "children", "leads back to nodes[%u]: a node may not hold itself", at);
}

/* ---- placing ---- */

static bool is_finite(const gltf_way *way) {
    for (size_t i = 0; i < way->count * 12; ++i) {
        if (!isfinite(way->at[i / 12].m[i % 12 / 4][i % 4])) return false;
    }
    return true;
}

static fathom_status add_instance(gltf *g, const gltf_value *node, fathom_id group, const gltf_way *way) {
    affine_f64 inverse;
    fathom_instance instance;
    fathom_instance_default(&instance);
    instance.group = group;
    instance.parent = g->group;
    memcpy(instance.transform, way->at[0].m, sizeof instance.transform);
    if (!is_finite(way))
        return gltf_fail(g, node, NULL, "is placed out of the range of numbers by its transforms");
    /* Files hide things by a scale of zero. */
    if (!affine_invert(&way->at[0], &inverse)) {
        gltf_note(g, node, NULL, "is scaled to nothing, and left out");
        return FATHOM_OK;
    }
    const bool moves = gltf_way_moves(way), blurs = moves && gltf_way_can_blur(way);
    if (moves && !blurs)
        gltf_note(g, node, NULL,
                  "\"%.40s\" is flat or turned inside out while the shutter is open, and not blurred; it "
                  "stands as the shutter opens",
                  gltf_name(node));
    if (blurs) {
        instance.key_count = (uint32_t)way->count, instance.key_times = g->key_times;
        instance.key_transforms = &way->at[0].m[0][0];
    }
    /* Held twice, plus half as much again while the array grows. */
    fathom_status status =
        gltf_charge(g, node, NULL, 3 * sizeof instance + instance.key_count * 13 * sizeof(double));
    if (status != FATHOM_OK) return status;
    return gltf_within(g, node, NULL, fathom_scene_add_instance(g->scene, &instance, NULL));
}

typedef struct instance_parts {
    gltf_elements translations, rotations, scales; /* values NULL: not given */
    uint32_t count;
} instance_parts;

static fathom_status read_part(gltf *g, const gltf_value *attributes, const char *key, unsigned components,
                               unsigned takes, gltf_elements *out, uint32_t *count) {
    bool present;
    fathom_status status = gltf_array_read(g, attributes, key, components, takes, &present, out);
    if (status != FATHOM_OK || !present) return status;
    if (*count && out->count != *count)
        return gltf_fail(g, attributes, key, "has %u entries where another attribute has %u", out->count,
                         *count);
    *count = out->count;
    return FATHOM_OK;
}

static void part_at(const gltf_elements *part, uint32_t i, int n, double *out) {
    if (!part->values) return;
    float values[4];
    memcpy(values, (const char *)part->values + part->stride * i, (size_t)n * sizeof(float));
    for (int k = 0; k < n; ++k) out[k] = (double)values[k];
}

/* EXT_mesh_gpu_instancing: one node, many places. */
static fathom_status add_many(gltf *g, const gltf_value *node, const gltf_value *instancing, fathom_id group,
                              const gltf_way *to_world) {
    gltf_value attributes;
    instance_parts p = {.count = 0};
    gltf_way way;
    fathom_status status = gltf_object(g, instancing, "attributes", &attributes);
    if (status == FATHOM_OK)
        status = read_part(g, &attributes, "TRANSLATION", 3, GLTF_TAKES_FLOAT, &p.translations, &p.count);
    if (status == FATHOM_OK)
        status = read_part(g, &attributes, "ROTATION", 4, GLTF_TAKES_FLOAT | GLTF_TAKES_SIGNED, &p.rotations,
                           &p.count);
    if (status == FATHOM_OK)
        status = read_part(g, &attributes, "SCALE", 3, GLTF_TAKES_FLOAT, &p.scales, &p.count);
    for (uint32_t i = 0; i < p.count && status == FATHOM_OK; ++i) {
        double parts[GLTF_PARTS][4] = {{0, 0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1, 0}};
        part_at(&p.translations, i, 3, parts[GLTF_TRANSLATION]);
        part_at(&p.rotations, i, 4, parts[GLTF_ROTATION]);
        part_at(&p.scales, i, 3, parts[GLTF_SCALE]);
        if (!gltf_is_rotation(parts[GLTF_ROTATION]))
            return gltf_fail(g, &attributes, "ROTATION", "entry %u is zero; expected unit quaternions", i);
        const affine_f64 one = gltf_compose(parts);
        gltf_way_of(to_world, &one, &way);
        status = add_instance(g, node, group, &way);
    }
    return status;
}

/* A node with a skin, or with weights of its own, has a copy of its mesh. */
static fathom_status read_shape(gltf *g, gltf_moment *m, const gltf_value *node, uint32_t mesh, bool *own,
                                gltf_shape *out) {
    uint32_t skin = GLTF_ABSENT;
    gltf_value at;
    const gltf_pose *pose = gltf_pose_of(m, (uint32_t)node->index);
    fathom_status status = gltf_index(g, node, "skin", &g->skins, &skin);
    if (status == FATHOM_OK) status = gltf_item(g, &g->meshes, mesh, &at);
    *own = skin != GLTF_ABSENT || json_object_get(node->json, "weights") || (pose && pose->weights);
    if (status != FATHOM_OK || !*own) return status;
    status = gltf_weights_read(g, pose, node, &at, out);
    if (status == FATHOM_OK && skin != GLTF_ABSENT) status = gltf_skin_read(g, m, skin, &out->joints);
    return status;
}

/* *joints: as the shutter opens; NULL: no skin. */
static fathom_status shape_mesh(gltf *g, const gltf_value *node, uint32_t mesh, const gltf_joints **joints,
                                fathom_id *group) {
    gltf_shape shapes[GLTF_MOMENTS] = {{.weights = NULL}};
    bool own = false;
    fathom_status status = FATHOM_OK;
    for (size_t k = 0; k < g->moments.count && status == FATHOM_OK; ++k)
        status = read_shape(g, &g->moments.items[k], node, mesh, &own, &shapes[k]);
    if (status == FATHOM_OK) status = gltf_mesh_group(g, mesh, own ? shapes : NULL, group);
    for (size_t k = 0; k < g->moments.count; ++k) free(shapes[k].weights);
    *joints = shapes[0].joints;
    return status;
}

static fathom_status place_mesh(gltf *g, const gltf_value *node, const gltf_way *to_world) {
    uint32_t mesh = GLTF_ABSENT;
    fathom_id group = GLTF_EMPTY;
    gltf_value extensions, instancing;
    const gltf_joints *joints;
    fathom_status status = gltf_index(g, node, "mesh", &g->meshes, &mesh);
    if (status != FATHOM_OK || mesh == GLTF_ABSENT) return status;
    status = shape_mesh(g, node, mesh, &joints, &group);
    if (status != FATHOM_OK || group == GLTF_EMPTY) return status;
    status = gltf_extension(g, node, "EXT_mesh_gpu_instancing", &extensions, &instancing);
    if (status != FATHOM_OK) return status;
    if (joints) {
        const gltf_way moved = {.count = 1, .at = {affine_translation(joints->origin)}};
        if (instancing.json)
            gltf_note(g, node, NULL, "the instances of a mesh with a skin are left out but one");
        return add_instance(g, node, group, &moved);
    }
    if (instancing.json) return add_many(g, node, &instancing, group, to_world);
    return add_instance(g, node, group, to_world);
}

/* Pushes children last to first, so that nodes come in the order of the file. */
static fathom_status stack_children(gltf *g, walk *w, const gltf_value *list, bool hidden) {
    for (size_t i = gltf_count(list); i-- > 0;) {
        step next = {.hidden = hidden};
        fathom_status status = gltf_index_item(g, list, i, &g->nodes, &next.node);
        if (status != FATHOM_OK) return status;
        if (!array_push(w, next)) return fail_memory(g->context, sizeof next);
    }
    return FATHOM_OK;
}

/* KHR_node_visibility hides meshes and lights of the node and of all below it. */
static fathom_status read_visibility(gltf *g, const gltf_value *node, bool *hidden) {
    gltf_value extensions, visibility;
    bool visible = true;
    fathom_status status = gltf_extension(g, node, "KHR_node_visibility", &extensions, &visibility);
    if (status == FATHOM_OK) status = gltf_flag(g, &visibility, "visible", &visible);
    if (!visible) gltf_note(g, node, NULL, "KHR_node_visibility hides it, and what is below it");
    *hidden = *hidden || !visible;
    return status;
}

static fathom_status visit(gltf *g, walk *w, const step *at) {
    gltf_value node, children;
    gltf_way to_world;
    bool hidden = at->hidden;
    fathom_status status = gltf_item(g, &g->nodes, at->node, &node);
    if (status == FATHOM_OK) status = gltf_node_way(g, at->node, &to_world);
    if (status == FATHOM_OK) status = read_visibility(g, &node, &hidden);
    if (status != FATHOM_OK) return status;
    if (!hidden) status = place_mesh(g, &node, &to_world);
    if (status == FATHOM_OK && g->options->surroundings) {
        status = gltf_camera_note(g, &node);
        if (status == FATHOM_OK && !hidden) status = gltf_light_place(g, &node, &to_world);
    }
    if (status == FATHOM_OK) status = gltf_array(g, &node, "children", &children);
    return status == FATHOM_OK ? stack_children(g, w, &children, hidden) : status;
}

static fathom_status walk_down(gltf *g, walk *w) {
    fathom_status status = FATHOM_OK;
    while (w->count && status == FATHOM_OK) {
        step at = w->items[--w->count];
        status = visit(g, w, &at);
    }
    return status;
}

/* ---- where to begin ---- */

#define IN_SCENE (GLTF_ABSENT - 1) /* as a parent: none, and the scene's list names the node */

static fathom_status check_scene_roots(gltf *g, const gltf_value *list) {
    for (size_t i = 0; i < gltf_count(list); ++i) {
        uint32_t node = GLTF_ABSENT;
        fathom_status status = gltf_index_item(g, list, i, &g->nodes, &node);
        if (status != FATHOM_OK) return status;
        if (g->parents[node] == IN_SCENE) return gltf_fail(g, list, NULL, "names nodes[%u] twice", node);
        if (g->parents[node] != GLTF_ABSENT)
            return gltf_fail(g, list, NULL, "names nodes[%u], a child of nodes[%u]; expected root nodes",
                             node, g->parents[node]);
        g->parents[node] = IN_SCENE;
    }
    return FATHOM_OK;
}

static fathom_status walk_scene(gltf *g, walk *w) {
    uint32_t index = 0;
    gltf_value scene, list;
    fathom_status status = gltf_index(g, &g->root, "scene", &g->scenes, &index);
    if (status == FATHOM_OK) status = gltf_item(g, &g->scenes, index, &scene);
    if (status == FATHOM_OK) status = gltf_array(g, &scene, "nodes", &list);
    if (status == FATHOM_OK) status = check_scene_roots(g, &list);
    if (status == FATHOM_OK) status = stack_children(g, w, &list, false);
    return status == FATHOM_OK ? walk_down(g, w) : status;
}

static fathom_status walk_roots(gltf *g, walk *w) {
    fathom_status status = FATHOM_OK;
    for (uint32_t i = 0; i < gltf_count(&g->nodes) && status == FATHOM_OK; ++i) {
        step root = {i, false};
        if (g->parents[i] == GLTF_ABSENT) status = visit(g, w, &root);
        if (status == FATHOM_OK) status = walk_down(g, w);
    }
    return status;
}

/* A library of meshes without nodes: places each once. */
static fathom_status place_all_meshes(gltf *g) {
    const gltf_way identity = {.count = 1, .at = {affine_identity()}};
    fathom_status status = FATHOM_OK;
    for (uint32_t i = 0; i < gltf_count(&g->meshes) && status == FATHOM_OK; ++i) {
        fathom_id group = GLTF_EMPTY;
        gltf_value mesh = {.parent = &g->meshes, .index = i};
        status = gltf_mesh_group(g, i, NULL, &group);
        if (status == FATHOM_OK && group != GLTF_EMPTY) status = add_instance(g, &mesh, group, &identity);
    }
    return status;
}

static fathom_status place_all(gltf *g, walk *w) {
    fathom_status status = find_parents(g, g->parents);
    if (status == FATHOM_OK) status = find_cycle(g, g->parents);
    if (status == FATHOM_OK) status = gltf_animation_choose(g);
    if (status == FATHOM_OK) status = gltf_moments_open(g);
    if (status != FATHOM_OK) return status;
    if (!gltf_count(&g->nodes)) return place_all_meshes(g);
    return gltf_count(&g->scenes) ? walk_scene(g, w) : walk_roots(g, w);
}

fathom_status gltf_nodes_place(gltf *g) {
    const size_t bytes = (gltf_count(&g->nodes) + 1) * sizeof *g->parents;
    walk w = {NULL, 0, 0};
    g->parents = malloc(bytes);
    fathom_status status = g->parents ? place_all(g, &w) : fail_memory(g->context, bytes);
    array_free(&w);
    return status;
}
