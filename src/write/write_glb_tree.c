/* The hierarchy of binary glTF: groups as meshes, and each instance of a group as nodes. */
#include "write/write_glb.h"

#include "scene/motion/motion.h"

#include <math.h>
#include <stdlib.h>

/* ---- groups ---- */

/* A node takes about a hundred bytes of JSON, and a file has at most 2^32 bytes. */
#define MOST_NODES ((size_t)1 << 26)

static const char *name_of(const glb *g, uint32_t item) {
    return g->scene->objects.items[g->graph->objects.items[item]].name;
}

static bool has_origin(const fathom_mesh *mesh) {
    return mesh->origin[0] != 0 || mesh->origin[1] != 0 || mesh->origin[2] != 0;
}

/* True if the mesh needs a node of its own, for its origin or its name. */
static bool stands_alone(const glb *g, uint32_t item, const fathom_mesh *mesh) {
    return has_origin(mesh) || name_of(g, item);
}

static int compare_ids(const void *a, const void *b) {
    const fathom_id *x = a, *y = b;
    return *x < *y ? -1 : *x > *y;
}

static void sort_overrides(glb_group *group) {
    fathom_id *items = group->overrides.items;
    size_t count = 0;
    if (!group->overrides.count) return;
    qsort(items, group->overrides.count, sizeof *items, compare_ids);
    for (size_t i = 0; i < group->overrides.count; ++i) {
        if (!count || items[count - 1] != items[i]) items[count++] = items[i];
    }
    group->overrides.count = count;
}

/* The outermost override is the one that applies. */
static bool pass_overrides(const glb_group *from, const fathom_instance *instance, glb_group *to) {
    for (size_t i = 0; i < from->overrides.count; ++i) {
        fathom_id override = from->overrides.items[i];
        if (!array_push(&to->overrides, override != FATHOM_NONE ? override : instance->material))
            return false;
        if (to->overrides.count >= 64 && to->overrides.count == to->overrides.capacity) sort_overrides(to);
    }
    return true;
}

static uint32_t meshes_for_one(const glb_group *group) { return group->alone_count + group->together; }

/* The glTF mesh of a group placed under an override. */
static uint32_t mesh_number(const glb *g, uint32_t index, fathom_id override) {
    const glb_group *group = &g->groups[index];
    const fathom_id *found =
        bsearch(&override, group->overrides.items, group->overrides.count, sizeof override, compare_ids);
    return group->first_mesh + (uint32_t)(found - group->overrides.items) * meshes_for_one(group);
}

static void count_meshes(const glb *g, uint32_t index, uint32_t *next_mesh) {
    glb_group *group = &g->groups[index];
    uint32_t unused;
    for (uint32_t i = g->graph->objects.first[index]; i < g->graph->objects.first[index + 1]; ++i) {
        const fathom_mesh *mesh = glb_object_mesh(g, i, &unused);
        if (!mesh) continue;
        if (stands_alone(g, i, mesh))
            ++group->alone_count;
        else
            group->together = true;
    }
    group->first_mesh = *next_mesh;
    *next_mesh += meshes_for_one(group) * (uint32_t)group->overrides.count;
}

static double shear_of(const affine_f64 *map, int i, int j, double squares[2]) {
    double dot = squares[0] = squares[1] = 0;
    for (int k = 0; k < 3; ++k) {
        const double x = map->m[k][i], y = map->m[k][j];
        dot += x * y, squares[0] += x * x, squares[1] += y * y;
    }
    return dot;
}

static bool is_sheared(const affine_f64 *map) {
    for (int i = 0; i < 3; ++i) {
        double squares[2];
        if (fabs(shear_of(map, i, (i + 1) % 3, squares)) > 1e-5 * sqrt(squares[0] * squares[1])) return true;
    }
    return false;
}

static void turn_columns(affine_f64 *map, int i, int j, double angle) {
    const double c = cos(angle), s = sin(angle);
    for (int k = 0; k < 3; ++k) {
        const double x = map->m[k][i], y = map->m[k][j];
        map->m[k][i] = c * x - s * y, map->m[k][j] = s * x + c * y;
    }
}

/* map = outer inner, where outer does not shear and inner rotates. One-sided Jacobi rotations make the
 * columns orthogonal: (c x - s y) . (s x + c y) = 0 for tan 2a = 2 x.y / (y.y - x.x). They sort the
 * columns by length, so i < j, and converge quadratically: 8 times 3 are more than double needs. */
static affine_f64 split_shear(const affine_f64 *map, affine_f64 *inner) {
    affine_f64 outer = *map, turned = affine_identity();
    for (int k = 0; k < 24; ++k) {
        const int i = k % 3 / 2, j = k % 3 ? 2 : 1;
        double squares[2];
        const double dot = shear_of(&outer, i, j, squares),
                     angle = atan2(2 * dot, squares[1] - squares[0]) / 2;
        turn_columns(&outer, i, j, angle);
        turn_columns(&turned, i, j, angle);
    }
    for (int i = 0; i < 12; ++i) inner->m[i / 4][i % 4] = i % 4 < 3 ? turned.m[i % 4][i / 4] : 0;
    return outer;
}

static affine_f64 place_of(const glb *g, const fathom_instance *instance) {
    return motion_place(instance, g->scene->camera.shutter[0]);
}

/* The nodes of an instance and all its descendants. */
static size_t nodes_of(const glb *g, fathom_id number) {
    const fathom_instance *instance = &g->scene->instances.items[number];
    const affine_f64 map = place_of(g, instance);
    return write_add(g->groups[instance->group].nodes, is_sheared(&map));
}

static void count_nodes(const glb *g, uint32_t index) {
    glb_group *group = &g->groups[index];
    group->nodes = 1 + group->alone_count;
    for (uint32_t i = g->graph->instances.first[index]; i < g->graph->instances.first[index + 1]; ++i)
        group->nodes = write_add(group->nodes, nodes_of(g, g->graph->instances.items[i]));
}

fathom_status glb_plan_groups(glb *g) {
    bool good = array_push(&g->groups[FATHOM_ROOT].overrides, FATHOM_NONE);
    uint32_t meshes = 0;
    for (uint32_t k = 0; k < g->graph->order_count && good; ++k) {
        uint32_t index = g->graph->order[k];
        sort_overrides(&g->groups[index]);
        count_meshes(g, index, &meshes);
        for (uint32_t i = g->graph->instances.first[index]; i < g->graph->instances.first[index + 1] && good;
             ++i) {
            const fathom_instance *instance = &g->scene->instances.items[g->graph->instances.items[i]];
            good = pass_overrides(&g->groups[index], instance, &g->groups[instance->group]);
        }
    }
    if (!good) return fail_memory(g->scene->context, g->scene->instances.count * sizeof(fathom_id));
    for (uint32_t k = g->graph->order_count; k-- > 0;) count_nodes(g, g->graph->order[k]);
    size_t nodes = g->groups[FATHOM_ROOT].nodes;
    if (nodes <= MOST_NODES) return FATHOM_OK;
    return fail_file(g->scene->context, FATHOM_BAD_USAGE, g->path,
                     "glTF needs a node for each of %zu placed groups, and a .glb has room for about %zu",
                     nodes, MOST_NODES);
}

void glb_put_name(file_writer *t, const char *separator, const char *name) {
    file_writer_print(t, "%s\"name\":", separator);
    write_quoted(t, name);
}

static void put_primitive(const glb *g, file_writer *t, uint32_t index, fathom_id override) {
    static const char *const names[GLB_INDEX] = {"POSITION",   "NORMAL",  "TEXCOORD_0",
                                                 "TEXCOORD_1", "COLOR_0", "TANGENT"};
    const glb_mesh *m = &g->meshes[index];
    uint32_t accessor = m->accessor;
    size_t sizes[GLB_ARRAYS];
    glb_sizes(m, sizes);
    for (int kind = 0; kind < GLB_INDEX; ++kind) {
        if (sizes[kind])
            file_writer_print(t, "%s\"%s\":%u", kind ? "," : "{\"attributes\":{", names[kind], accessor++);
    }
    if (sizes[GLB_INDEX])
        file_writer_print(t, "},\"indices\":%u", accessor);
    else
        file_writer_print(t, "},\"mode\":0"); /* points */
    file_writer_print(t, ",\"material\":%u}",
                      override != FATHOM_NONE ? override : m->vertices.mesh->material);
}

/* Writes one glTF mesh for the meshes that share a node, then one for each other mesh, in the order of
 * mesh_number(). */
static void put_group_meshes(const glb *g, file_writer *t, uint32_t group, fathom_id override,
                             const char **comma) {
    for (int alone = g->groups[group].together ? 0 : 1; alone < 2; ++alone) {
        const char *separator = alone ? *comma : "";
        if (!alone) file_writer_print(t, "%s\n{\"primitives\":[", *comma);
        for (uint32_t i = g->graph->objects.first[group], index; i < g->graph->objects.first[group + 1];
             ++i) {
            const fathom_mesh *mesh = glb_object_mesh(g, i, &index);
            if (!mesh || stands_alone(g, i, mesh) != (alone == 1)) continue;
            file_writer_print(t, "%s%s", separator, alone ? "\n{\"primitives\":[" : "");
            put_primitive(g, t, index, override);
            if (alone) file_writer_print(t, "]");
            if (alone && name_of(g, i)) glb_put_name(t, ",", name_of(g, i));
            if (alone) file_writer_print(t, "}");
            separator = *comma = ",";
        }
        if (alone) continue;
        file_writer_print(t, "]");
        if (g->scene->groups.items[group]) glb_put_name(t, ",", g->scene->groups.items[group]);
        file_writer_print(t, "}");
    }
}

static void put_meshes(const glb *g, file_writer *t) {
    const char *comma = "";
    for (uint32_t k = 0; k < g->graph->order_count; ++k) {
        const glb_group *group = &g->groups[g->graph->order[k]];
        for (size_t i = 0; i < group->overrides.count; ++i)
            put_group_meshes(g, t, g->graph->order[k], group->overrides.items[i], &comma);
    }
}

/* glTF stores matrices by columns, with the row 0 0 0 1. */
static void put_transform(file_writer *t, const char **separator, const affine_f64 *map) {
    if (affine_is_identity(map)) return;
    file_writer_print(t, "%s\"matrix\":", *separator);
    *separator = ",";
    for (int i = 0; i < 16; ++i) {
        double number = i % 4 < 3 ? map->m[i % 4][i / 4] : i / 4 == 3;
        file_writer_print(t, "%s%.17g", i ? "," : "[", number);
    }
    file_writer_print(t, "]");
}

/* Children are numbered after their parent, each followed by all its descendants. */
static void put_children(const glb *g, file_writer *t, const char *separator, uint32_t group, size_t number) {
    size_t child = number + 1;
    const char *comma = "[";
    if (g->groups[group].nodes == 1) return;
    file_writer_print(t, "%s\"children\":", separator);
    for (uint32_t i = 0; i < g->groups[group].alone_count; ++i, comma = ",")
        file_writer_print(t, "%s%zu", comma, child++);
    for (uint32_t i = g->graph->instances.first[group]; i < g->graph->instances.first[group + 1];
         ++i, comma = ",") {
        file_writer_print(t, "%s%zu", comma, child);
        child += nodes_of(g, g->graph->instances.items[i]);
    }
    file_writer_print(t, "]");
}

static void put_lone_nodes(const glb *g, file_writer *t, uint32_t group, uint32_t mesh) {
    for (uint32_t i = g->graph->objects.first[group], index; i < g->graph->objects.first[group + 1]; ++i) {
        const fathom_mesh *alone = glb_object_mesh(g, i, &index);
        if (!alone || !stands_alone(g, i, alone)) continue;
        file_writer_print(t, ",\n{\"mesh\":%u", mesh++);
        if (name_of(g, i)) glb_put_name(t, ",", name_of(g, i));
        if (has_origin(alone))
            file_writer_print(t, ",\"translation\":[%.17g,%.17g,%.17g]", alone->origin[0], alone->origin[1],
                              alone->origin[2]);
        file_writer_print(t, "}");
    }
}

/* glTF forbids matrices that shear, and programs that take one apart lose the shear. So another node around
 * that of the instance stretches it. Returns what remains for the latter. */
static affine_f64 put_shear(file_writer *t, const affine_f64 *map, size_t *number) {
    affine_f64 inner = *map;
    if (!is_sheared(map)) return inner;
    const affine_f64 outer = split_shear(map, &inner);
    const char *separator = "";
    put_transform(t, &separator, &outer);
    file_writer_print(t, ",\"children\":[%zu]},\n{", ++*number);
    return inner;
}

/* Each instance of a group gets its own nodes, because nodes form a tree. */
static void put_nodes(const glb *g, file_writer *t, uint32_t group, const fathom_instance *instance,
                      fathom_id override, size_t *number) {
    const char *name = instance && instance->name ? instance->name : g->scene->groups.items[group],
               *separator = "";
    uint32_t mesh = mesh_number(g, group, override);
    affine_f64 map = instance ? place_of(g, instance) : affine_identity();
    file_writer_print(t, *number ? ",\n{" : "\n{");
    map = put_shear(t, &map, number);
    if (name) glb_put_name(t, separator, name), separator = ",";
    put_transform(t, &separator, &map);
    if (g->groups[group].together) {
        file_writer_print(t, "%s\"mesh\":%u", separator, mesh++);
        separator = ",";
    }
    put_children(g, t, separator, group, *number);
    file_writer_print(t, "}");
    put_lone_nodes(g, t, group, mesh);
    *number += 1 + g->groups[group].alone_count;
    for (uint32_t i = g->graph->instances.first[group]; i < g->graph->instances.first[group + 1]; ++i) {
        const fathom_instance *child = &g->scene->instances.items[g->graph->instances.items[i]];
        put_nodes(g, t, child->group, child, override != FATHOM_NONE ? override : child->material, number);
    }
}

void glb_put_tree(const glb *g, file_writer *t) {
    const size_t nodes = g->groups[FATHOM_ROOT].nodes, others = glb_surroundings(g);
    size_t number = 0;
    file_writer_print(t, "\"scene\":0,\"scenes\":[{\"nodes\":[0");
    for (size_t i = 0; i < others; ++i) file_writer_print(t, ",%zu", nodes + i);
    file_writer_print(t, "]");
    if (*g->scene->name) glb_put_name(t, ",", g->scene->name);
    file_writer_print(t, "}],\n\"nodes\":[");
    put_nodes(g, t, FATHOM_ROOT, NULL, FATHOM_NONE, &number);
    glb_put_surroundings(g, t);
    file_writer_print(t, "],\n\"meshes\":[");
    put_meshes(g, t);
    file_writer_print(t, "]");
}
