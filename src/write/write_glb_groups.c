/* Groups in glTF: nodes form a tree, so each placement of a group gets its own nodes, which share the same
 * glTF meshes. */
#include "write/write_glb.h"

#include <stdlib.h>

/* A node takes about a hundred bytes of JSON, and a file has at most 2^32. */
#define MOST_NODES ((size_t)1 << 26)

bool glb_is_near(const fathom_mesh *mesh) {
    return mesh->origin[0] == 0 && mesh->origin[1] == 0 && mesh->origin[2] == 0;
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

/* The outermost override counts. */
static bool pass_overrides(const glb_group *from, const fathom_instance *instance, glb_group *to) {
    for (size_t i = 0; i < from->overrides.count; ++i) {
        fathom_id override = from->overrides.items[i];
        if (!array_push(&to->overrides, override != FATHOM_NONE ? override : instance->material))
            return false;
        if (to->overrides.count >= 64 && to->overrides.count == to->overrides.capacity) sort_overrides(to);
    }
    return true;
}

static uint32_t meshes_for_one(const glb_group *group) { return group->far_count + group->near; }

uint32_t glb_mesh_number(const glb *g, uint32_t index, fathom_id override) {
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
        if (glb_is_near(mesh))
            group->near = true;
        else
            ++group->far_count;
    }
    group->first_mesh = *next_mesh;
    *next_mesh += meshes_for_one(group) * (uint32_t)group->overrides.count;
}

static void count_nodes(const glb *g, uint32_t index) {
    glb_group *group = &g->groups[index];
    group->nodes = 1 + group->far_count;
    for (uint32_t i = g->graph->instances.first[index]; i < g->graph->instances.first[index + 1]; ++i) {
        const fathom_instance *instance = &g->scene->instances.items[g->graph->instances.items[i]];
        group->nodes = write_add(group->nodes, g->groups[instance->group].nodes);
    }
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
