/* The hierarchy: each node with a mesh becomes an instance of the mesh's group. Its transform is the product
 * of the transforms above it, in double. */
#include "read/gltf/gltf_data.h"
#include "read/gltf/gltf_mesh.h"
#include "read/gltf/gltf_pose.h"
#include "read/gltf/gltf_tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct step {
    uint32_t link;
    bool hidden; /* the node's parent is hidden */
} step;

typedef struct walk {
    ARRAY(step) steps;
    bool *shown; /* for each link */
} walk;

/* ---- placing ---- */

static bool is_finite(const gltf_way *way) {
    for (size_t i = 0; i < way->count * 12; ++i) {
        if (!isfinite(way->at[i / 12].m[i % 12 / 4][i % 4])) return false;
    }
    return true;
}

/* Some files hide objects by a scale of zero, or of nearly zero, which no tracer can invert. */
static bool is_tiny(const affine_f64 *a) {
    double square = 0;
    for (int k = 0; k < 9; ++k) square += a->m[k / 3][k % 3] * a->m[k / 3][k % 3];
    return square < 1e-22;
}

static void add_instance(gltf *g, const gltf_value *node, fathom_id group, const gltf_way *way) {
    affine_f64 inverse;
    fathom_instance instance;
    fathom_instance_default(&instance);
    instance.group = group;
    instance.parent = g->group;
    instance.name = gltf_name(node->json);
    memcpy(instance.transform, way->at[0].m, sizeof instance.transform);
    if (!is_finite(way)) {
        gltf_fail(g, node, NULL, "has transforms that place it beyond the range of numbers");
        return;
    }
    if (!affine_invert(&way->at[0], &inverse) || is_tiny(&way->at[0])) {
        g->scene->hides = true;
        gltf_note(g, node, NULL, "is scaled to nothing, and left out");
        return;
    }
    if (gltf_way_moves(way)) {
        instance.key_count = (uint32_t)way->count, instance.key_times = g->key_times;
        instance.key_transforms = &way->at[0].m[0][0];
    }
    /* The instance is stored twice, plus half of that while the array grows; so is the owner of its name. */
    gltf_charge(g, node, NULL, 3 * sizeof instance);
    if (instance.name) gltf_charge(g, node, NULL, 3 * sizeof(scene_blob) + strlen(instance.name) + 32);
    g->posing = true;
    gltf_charge(g, node, NULL, instance.key_count * 13 * sizeof(double));
    g->posing = false;
    if (gltf_fine(g)) gltf_within(g, node, NULL, fathom_scene_add_instance(g->scene, &instance, NULL));
}

static void read_part(gltf *g, const gltf_value *attributes, const char *key, unsigned components,
                      unsigned takes, gltf_elements *out, uint32_t *count) {
    if (!gltf_array_read(g, attributes, key, components, takes, out)) return;
    if (*count && out->count != *count)
        gltf_fail(g, attributes, key, "has %u entries where another attribute has %u", out->count, *count);
    *count = out->count;
}

static void part_at(const gltf_elements *part, uint32_t i, int n, double *out) {
    for (int k = 0; k < n && part->values; ++k) out[k] = (double)gltf_element(part, i)[k];
}

/* Other attributes, such as _ID, do not affect images. */
static void note_colors(gltf *g, const gltf_value *attributes) {
    const char *key;
    json_t *value;
    json_object_foreach(attributes->json, key, value) {
        if (strncmp(key, "_COLOR_", 7) == 0)
            gltf_note(g, attributes, key, "%.40s of instances is ignored; they have their mesh's colours",
                      key);
    }
}

/* EXT_mesh_gpu_instancing: one node with many instances. */
static void add_many(gltf *g, const gltf_value *node, const gltf_value *instancing, fathom_id group,
                     const gltf_way *to_world) {
    gltf_value attributes;
    gltf_elements translations, rotations, scales;
    uint32_t count = 0;
    gltf_way way;
    gltf_object(g, instancing, "attributes", &attributes);
    note_colors(g, &attributes);
    read_part(g, &attributes, "TRANSLATION", 3, GLTF_TAKES_FLOAT, &translations, &count);
    read_part(g, &attributes, "ROTATION", 4, GLTF_TAKES_FLOAT | GLTF_TAKES_SIGNED, &rotations, &count);
    read_part(g, &attributes, "SCALE", 3, GLTF_TAKES_FLOAT, &scales, &count);
    if (!translations.values && !rotations.values && !scales.values && gltf_fine(g))
        gltf_note(g, instancing, NULL, "instances without TRANSLATION, ROTATION and SCALE are left out");
    for (uint32_t i = 0; i < count && gltf_fine(g); ++i) {
        double parts[GLTF_PARTS][4] = {{0, 0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1, 0}};
        part_at(&translations, i, 3, parts[GLTF_TRANSLATION]);
        part_at(&rotations, i, 4, parts[GLTF_ROTATION]);
        part_at(&scales, i, 3, parts[GLTF_SCALE]);
        if (!gltf_is_rotation(parts[GLTF_ROTATION]))
            gltf_fail(g, &attributes, "ROTATION", "entry %u is zero; expected unit quaternions", i);
        const affine_f64 one = gltf_compose(parts);
        gltf_way_of(to_world, &one, &way);
        if (gltf_fine(g)) add_instance(g, node, group, &way);
    }
}

/* Replaces the way of a mesh's node that tracers cannot follow. The way of a skin is that of its joints, and
 * a mesh that is flat at first is posed as if it had one. */
static void hold_way(gltf *g, const gltf_value *node, gltf_way *way) {
    if (json_object_get(node->json, "skin") || !gltf_way_moves(way) || gltf_way_flattens(way) ||
        gltf_way_can_blur(way))
        return;
    gltf_note_node(
        g, (uint32_t)node->at.index,
        "a node is flat or turned inside out while the shutter is open, and not blurred; " GLTF_HELD);
    const affine_f64 middle = gltf_way_middle(way);
    for (size_t k = 0; k < way->count; ++k) way->at[k] = middle;
}

static void place_mesh(gltf *g, const gltf_value *node, gltf_way *to_world) {
    uint32_t mesh = GLTF_ABSENT;
    gltf_value extensions, instancing;
    const gltf_joints *joints = NULL;
    gltf_index(g, node, "mesh", &g->meshes, &mesh);
    if (mesh == GLTF_ABSENT) return;
    hold_way(g, node, to_world);
    const fathom_id group = gltf_shape_mesh(g, node, mesh, to_world, &joints);
    gltf_extension(g, node, "EXT_mesh_gpu_instancing", &extensions, &instancing);
    if (!gltf_fine(g) || group == GLTF_EMPTY) return;
    if (joints) {
        gltf_way moved = {.count = 1, .at = {affine_translation(joints->origin)}};
        if (joints->mirrored) moved.at[0].m[0][0] = -1;
        if (instancing.json)
            gltf_note(g, node, NULL,
                      "the instances of a mesh with a skin, or that a node flattens, are left out but one");
        add_instance(g, node, group, &moved);
    } else if (instancing.json) {
        add_many(g, node, &instancing, group, to_world);
    } else {
        add_instance(g, node, group, to_world);
    }
}

static void stack(gltf *g, walk *w, uint32_t link, bool hidden) {
    const step next = {link, hidden};
    if (!array_push(&w->steps, next)) gltf_fail_memory(g, sizeof next);
}

static void stack_children(gltf *g, walk *w, uint32_t link, bool hidden) {
    for (uint32_t c = g->links.items[link].child; c != GLTF_ABSENT && gltf_fine(g);
         c = g->links.items[c].next)
        stack(g, w, c, hidden);
}

/* KHR_node_visibility hides meshes and lights of the node and of all nodes below it. */
static bool is_visible(gltf *g, const gltf_value *node) {
    gltf_value extensions, visibility;
    bool visible = true;
    gltf_extension(g, node, "KHR_node_visibility", &extensions, &visibility);
    gltf_flag(g, &visibility, "visible", &visible);
    if (!visible) gltf_note(g, node, NULL, "KHR_node_visibility hides it, and what is below it");
    return visible;
}

static void visit(gltf *g, walk *w, const step *at) {
    gltf_value node;
    gltf_way to_world;
    if (w->shown[at->link]) return;
    w->shown[at->link] = true;
    gltf_item(g, &g->nodes, g->links.items[at->link].node, &node);
    gltf_node_way(g, at->link, &to_world);
    const bool hidden = !is_visible(g, &node) || at->hidden;
    if (!gltf_fine(g)) return;
    g->scene->hides |= hidden;
    if (!hidden) place_mesh(g, &node, &to_world);
    if (g->options->surroundings) {
        gltf_camera_note(g, &node, at->link);
        if (!hidden) gltf_light_place(g, &node, &to_world);
    }
    stack_children(g, w, at->link, hidden);
}

static void walk_down(gltf *g, walk *w) {
    while (w->steps.count && gltf_fine(g)) {
        step at = w->steps.items[--w->steps.count];
        visit(g, w, &at);
    }
}

/* ---- start of the walk ---- */

/* A scene should list only roots, each once. Adds notes on other nodes: each node is added once, with the
 * transforms of its parents. */
static void note_odd_roots(gltf *g, const gltf_value *list, bool *named) {
    for (size_t i = 0; i < gltf_count(list); ++i) {
        uint32_t node = GLTF_ABSENT;
        gltf_index_item(g, list, i, &g->nodes, &node);
        if (!gltf_fine(g)) return;
        if (named[node])
            gltf_note(g, list, NULL, "a scene names a node twice; it is shown once");
        else if (g->links.items[node].parent != GLTF_ABSENT)
            gltf_note(g, list, NULL, "a scene names a node that has a parent; it stays where that places it");
        named[node] = true;
    }
    memset(named, 0, gltf_count(&g->nodes) * sizeof *named);
}

/* Adds a note for each scene with a node that is not shown. Errors in these scenes are ignored. */
static void note_other_scenes(gltf *g, uint32_t taken, const bool *shown) {
    const json_int_t count = (json_int_t)gltf_count(&g->nodes);
    char names[GLTF_LIST];
    gltf_print_names(&g->scenes, names);
    for (size_t i = 0; i < gltf_count(&g->scenes); ++i) {
        const gltf_value scene = gltf_entry(&g->scenes, i);
        const json_t *list = json_object_get(scene.json, "nodes");
        bool whole = true;
        for (size_t k = 0; k < json_array_size(list); ++k) {
            const json_int_t node = json_integer_value(json_array_get(list, k));
            whole &= node < 0 || node >= count || shown[node];
        }
        if (!whole)
            gltf_note(g, &scene, NULL,
                      "a scene is left out, because scenes[%u] is shown; --scene NAME|N takes one of %s",
                      taken, names);
    }
}

/* Marks the contents of skipped scenes as shown. Errors in these scenes are ignored. */
static void mark_other_scenes(gltf *g, walk *w) {
    const json_int_t count = (json_int_t)gltf_count(&g->nodes);
    for (size_t i = 0; i < gltf_count(&g->scenes); ++i) {
        const json_t *list = json_object_get(json_array_get(g->scenes.json, i), "nodes");
        for (size_t k = 0; k < json_array_size(list); ++k) {
            const json_int_t node = json_integer_value(json_array_get(list, k));
            if (node >= 0 && node < count) stack(g, w, (uint32_t)node, true);
        }
    }
    while (w->steps.count && gltf_fine(g)) {
        const step at = w->steps.items[--w->steps.count];
        if (!w->shown[at.link]) stack_children(g, w, at.link, true);
        w->shown[at.link] = true;
    }
}

/* Some exporters write nodes of deleted or hidden objects. */
static void note_lost_nodes(gltf *g, walk *w) {
    const uint32_t count = (uint32_t)gltf_count(&g->nodes);
    mark_other_scenes(g, w);
    for (size_t i = count; i < g->links.count; ++i) w->shown[g->links.items[i].node] |= w->shown[i];
    for (uint32_t i = 0; i < count && gltf_fine(g); ++i) {
        const json_t *node = json_array_get(g->nodes.json, i);
        if (!w->shown[i] && json_is_integer(json_object_get(node, "mesh")))
            gltf_note_node(g, i, "a node with a mesh is in no scene, and is left out");
    }
}

static uint32_t choose_scene(gltf *g, const char *wanted) {
    uint32_t index = 0;
    g->scene->has_scenes = true;
    gltf_index(g, &g->root, "scene", &g->scenes, &index);
    return wanted && gltf_fine(g) ? gltf_choose(g, &g->scenes, "scene", wanted) : index;
}

static void walk_scene(gltf *g, walk *w) {
    gltf_value scene, list;
    const char *wanted = g->scene->asked ? g->scene->asked->scene : NULL;
    const uint32_t index = choose_scene(g, wanted);
    if (!gltf_fine(g)) return;
    gltf_item(g, &g->scenes, index, &scene);
    gltf_array(g, &scene, "nodes", &list);
    note_odd_roots(g, &list, w->shown);
    for (size_t i = gltf_count(&list); i-- > 0 && gltf_fine(g);) {
        uint32_t root = GLTF_ABSENT;
        gltf_index_item(g, &list, i, &g->nodes, &root);
        if (gltf_fine(g)) stack(g, w, root, false);
    }
    walk_down(g, w);
    if (gltf_fine(g) && !wanted) note_other_scenes(g, index, w->shown);
    if (gltf_fine(g)) note_lost_nodes(g, w);
}

static void walk_roots(gltf *g, walk *w) {
    for (uint32_t i = 0; i < gltf_count(&g->nodes); ++i) {
        step root = {i, false};
        if (g->links.items[i].parent == GLTF_ABSENT && gltf_fine(g)) visit(g, w, &root);
        walk_down(g, w);
    }
}

/* For a file of meshes without nodes: adds each mesh once. */
static void place_all_meshes(gltf *g) {
    const gltf_way identity = {.count = 1, .at = {affine_identity()}};
    for (uint32_t i = 0; i < gltf_count(&g->meshes) && gltf_fine(g); ++i) {
        const gltf_value mesh = {NULL, {&g->meshes.at, NULL, i}};
        const gltf_joints *none = NULL;
        const fathom_id group = gltf_shape_mesh(g, NULL, i, &identity, &none);
        if (gltf_fine(g) && group != GLTF_EMPTY) add_instance(g, &mesh, group, &identity);
    }
}

void gltf_nodes_place(gltf *g) {
    gltf_tree_open(g);
    walk w = {.shown = calloc(g->links.count + 1, sizeof *w.shown)};
    g->told = calloc(gltf_count(&g->nodes) + 1, sizeof *g->told);
    if (!g->told || !w.shown) gltf_fail_memory(g, g->links.count * sizeof *w.shown);
    if (gltf_fine(g)) gltf_animation_choose(g);
    if (gltf_fine(g)) gltf_moments_open(g);
    if (gltf_fine(g) && !gltf_count(&g->nodes))
        place_all_meshes(g);
    else if (gltf_fine(g) && gltf_count(&g->scenes))
        walk_scene(g, &w);
    else if (gltf_fine(g))
        walk_roots(g, &w);
    array_free(&w.steps);
    free(w.shown);
}
