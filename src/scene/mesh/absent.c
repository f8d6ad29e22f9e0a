#include "scene/mesh/absent.h"

#include <stdlib.h>

static bool all_are(const float rgb[3], float value) {
    return rgb[0] == value && rgb[1] == value && rgb[2] == value;
}

bool absent_material(const fathom_material *m) {
    const bool ambient = m->k_a[0] >= 0 && !all_are(m->k_a, 0); /* negative: the same as k_d */
    const bool highlight = m->specular != FATHOM_SPECULAR_NONE && !all_are(m->k_s, 0);
    return all_are(m->k_t, 1) && m->ior == 1 && all_are(m->k_d, 0) && all_are(m->k_r, 0) &&
           all_are(m->k_e, 0) && !ambient && !highlight;
}

static unsigned flags_of(const fathom_scene *scene, scene_object object) {
    switch (object.kind) {
    case SCENE_SPHERE: return scene->spheres.items[object.index].flags;
    case SCENE_QUAD: return scene->quads.items[object.index].flags;
    case SCENE_PLANE: return scene->planes.items[object.index].flags;
    case SCENE_MESH: return scene->meshes.items[object.index].flags;
    }
    return 0;
}

/* Path tracing shows volumes, layers and reflection at grazing angles, which the classic form of a material
 * lacks. So a metallic-roughness material must cover nothing, everywhere. */
static bool is_absent(const fathom_material *m) {
    const fathom_map *map = &m->maps[FATHOM_MAP_OPACITY];
    if (m->model == FATHOM_MODEL_CLASSIC) return absent_material(m);
    return material_opacity(m) == 0 && (map->texture == FATHOM_NONE || !map->inverted);
}

bool absent_object(const fathom_scene *scene, fathom_id object) {
    const fathom_id material = scene_object_material(scene, object);
    return flags_of(scene, scene->objects.items[object]) & FATHOM_CASTS_NO_SHADOW &&
           is_absent(&scene->materials.items[material].value);
}

bool absent_by_own_material(const fathom_scene *scene) {
    for (size_t i = 0; i < scene->instances.count; ++i) {
        if (scene->instances.items[i].material != FATHOM_NONE) return false;
    }
    return true;
}

/* Sets replaced[g] if an instance on some path from the root to group g replaces materials. */
static void find_replaced(const fathom_scene *scene, const scene_graph *graph, bool *replaced) {
    for (uint32_t k = 0; k < graph->order_count; ++k) {
        const uint32_t g = graph->order[k];
        for (uint32_t i = graph->instances.first[g]; i < graph->instances.first[g + 1]; ++i) {
            const fathom_instance *instance = &scene->instances.items[graph->instances.items[i]];
            replaced[instance->group] |= replaced[g] || instance->material != FATHOM_NONE;
        }
    }
}

fathom_status absent_find(const fathom_scene *scene, const scene_graph *graph, bool **out) {
    bool *replaced = calloc(scene->groups.count, sizeof *replaced);
    *out = calloc(scene->objects.count + 1, sizeof **out);
    if (!replaced || !*out) {
        free(replaced);
        return fail_memory(scene->context, scene->groups.count + scene->objects.count);
    }
    find_replaced(scene, graph, replaced);
    for (size_t g = 0; g < scene->groups.count; ++g) {
        for (uint32_t i = graph->objects.first[g]; i < graph->objects.first[g + 1]; ++i) {
            const fathom_id object = graph->objects.items[i];
            (*out)[object] = !replaced[g] && absent_object(scene, object);
        }
    }
    free(replaced);
    return FATHOM_OK;
}
