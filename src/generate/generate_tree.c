#include "generate/generate_tree.h"

#include "math/frame.h"

#include <stdlib.h>

uint32_t tree_vertex(tree_part *part, vec3_f64 p) {
    if (!array_room(&part->positions, 3)) part->failed = true;
    if (part->failed) return 0;
    store_f32(part->positions.items + part->positions.count, narrow(p));
    part->positions.count += 3;
    return (uint32_t)(part->positions.count / 3 - 1);
}

static void add_normal(tree_part *part, vec3_f64 n) {
    if (!array_room(&part->normals, 3)) part->failed = true;
    if (part->failed) return;
    store_f32(part->normals.items + part->normals.count, narrow(normalize_f64(n)));
    part->normals.count += 3;
}

void tree_triangle(tree_part *part, uint32_t a, uint32_t b, uint32_t c) {
    if (!array_room(&part->indices, 3)) part->failed = true;
    if (part->failed) return;
    uint32_t *t = part->indices.items + part->indices.count;
    t[0] = a, t[1] = b, t[2] = c;
    part->indices.count += 3;
}

void tree_leaf(tree_part *part, vec3_f64 a, vec3_f64 b, vec3_f64 c) {
    uint32_t first = tree_vertex(part, a);
    tree_vertex(part, b);
    tree_vertex(part, c);
    tree_triangle(part, first, first + 1, first + 2);
}

/* Taylor's series within an eighth of a turn, off by less than 2^-41. */
vec3_f64 tree_turn(double turns) {
    turns -= (double)(uint64_t)turns;
    int quarter = (int)(turns * 4 + 0.5);
    double x = (turns - quarter * 0.25) * 6.283185307179586, y = x * x;
    double s = x * (1 - y / 6 * (1 - y / 20 * (1 - y / 42 * (1 - y / 72 * (1 - y / 110 * (1 - y / 156))))));
    double c = 1 - y / 2 * (1 - y / 12 * (1 - y / 30 * (1 - y / 56 * (1 - y / 90 * (1 - y / 132)))));
    switch (quarter & 3) {
    case 0: return (vec3_f64){c, 0, s};
    case 1: return (vec3_f64){-s, 0, c};
    case 2: return (vec3_f64){-c, 0, -s};
    default: return (vec3_f64){s, 0, -c};
    }
}

void tree_cone(tree_part *part, vec3_f64 from, vec3_f64 to, double from_radius, double to_radius,
               uint32_t sides) {
    vec3_f64 axis = sub_f64(to, from);
    frame_f64 f = frame_from(from, axis, (vec3_f64){0, 0, 0});
    double lean = (from_radius - to_radius) / length_f64(axis);
    uint32_t first = (uint32_t)(part->positions.count / 3);
    for (uint32_t k = 0; k < sides; ++k) {
        vec3_f64 c = tree_turn(k / (double)sides);
        vec3_f64 out = add_f64(scale_f64(c.x, f.x), scale_f64(c.z, f.y)), normal = madd_f64(out, lean, f.z);
        tree_vertex(part, madd_f64(from, from_radius, out));
        add_normal(part, normal);
        tree_vertex(part, madd_f64(to, to_radius, out));
        add_normal(part, normal);
    }
    for (uint32_t k = 0; k < sides; ++k) {
        uint32_t a = first + 2 * k, b = first + 2 * ((k + 1) % sides);
        tree_triangle(part, a, b, a + 1);
        if (to_radius > 0) tree_triangle(part, b, b + 1, a + 1);
    }
}

static fathom_status finish_part(fathom_scene *scene, fathom_id group, const tree_part *part,
                                 fathom_id material) {
    if (part->failed) return fail_memory(scene->context, part->indices.capacity * sizeof(uint32_t));
    fathom_mesh mesh;
    fathom_mesh_default(&mesh);
    mesh.positions = part->positions.items, mesh.vertex_count = (uint32_t)(part->positions.count / 3);
    mesh.normals = part->normals.items, mesh.normal_count = (uint32_t)(part->normals.count / 3);
    mesh.indices = part->indices.items, mesh.triangle_count = (uint32_t)(part->indices.count / 3);
    mesh.material = material;
    return fathom_scene_add_mesh(scene, group, &mesh, NULL);
}

static void free_part(tree_part *part) {
    array_free(&part->positions);
    array_free(&part->normals);
    array_free(&part->indices);
}

fathom_status generate_tree(fathom_scene *scene, fathom_id group, const tree *t) {
    tree_maker m = {.random = noise_random_from(t->seed, t->conifer ? 3 : 2)};
    if (t->conifer)
        tree_conifer(&m, t->triangles);
    else
        tree_broadleaf(&m, t->triangles);
    fathom_status status = finish_part(scene, group, &m.wood, t->bark);
    if (status == FATHOM_OK) status = finish_part(scene, group, &m.leaves, t->leaves);
    free_part(&m.wood);
    free_part(&m.leaves);
    return status;
}
