/* Light groups: sets of light sources whose light is kept separate in the image. */
#include "scene/light_groups.h"

#include <stdlib.h>
#include <string.h>

/* Names become parts of channel names; compositors allow no other letters and no greater length. */
static bool is_name(const char *name) {
    const size_t length = strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_");
    return length > 0 && length < LIGHT_GROUP_NAME && !name[length];
}

fathom_status light_group_find(fathom_scene *scene, const char *name, uint8_t *out) {
    light_group_names *names = &scene->light_groups;
    if (!is_name(name))
        return fail(scene->context, FATHOM_BAD_INPUT,
                    "light group: expected 1 to %d letters of A-Z, a-z, 0-9 and _, found \"%.40s\"",
                    LIGHT_GROUP_NAME - 1, name);
    if (!names->count) strcpy(names->names[names->count++], LIGHT_GROUP_REST);
    for (uint32_t i = 0; i < names->count; ++i) {
        *out = (uint8_t)i;
        if (strcmp(names->names[i], name) == 0) return FATHOM_OK;
    }
    if (names->count == LIGHT_GROUPS)
        return fail(scene->context, FATHOM_BAD_INPUT,
                    "light group: \"%s\" is one too many; expected at most %d", name, LIGHT_GROUPS - 1);
    *out = (uint8_t)names->count;
    strcpy(names->names[names->count++], name);
    return FATHOM_OK;
}

static size_t count_of(const fathom_scene *scene, fathom_light_source source) {
    switch (source) {
    case FATHOM_SOURCE_LIGHT: return scene->lights.count;
    case FATHOM_SOURCE_ENVIRONMENT: return scene->environments.count;
    case FATHOM_SOURCE_MATERIAL: return scene->materials.count;
    case FATHOM_SOURCE_OBJECT: return scene->objects.count;
    case FATHOM_SOURCE_BACKGROUND: return 1;
    }
    return 0;
}

fathom_status fathom_scene_set_light_group(fathom_scene *scene, fathom_light_source source, fathom_id id,
                                           const char *name) {
    if (!scene) return FATHOM_BAD_USAGE;
    fathom_context *context = scene->context;
    if (!name) return fail_null(context, "name");
    if (id >= count_of(scene, source))
        return fail(context, FATHOM_BAD_USAGE, "light group: there is no source %d with the id %u",
                    (int)source, id);
    scene_grouped_light item = {.source = source, .id = id};
    fathom_status status = light_group_find(scene, name, &item.group);
    if (status == FATHOM_OK && !array_push(&scene->grouped_lights, item))
        return fail_memory(context, sizeof item);
    return status;
}

/* ---- by source ---- */

fathom_status light_groups_create(const fathom_scene *scene, light_groups *out) {
    const size_t counts[] = {scene->lights.count, scene->environments.count, scene->materials.count,
                             scene->objects.count, 1};
    size_t all = 0;
    for (size_t k = 0; k < LIGHT_SOURCES; ++k) all += counts[k];
    *out = (light_groups){.count = scene->light_groups.count > 1 ? scene->light_groups.count : 1};
    uint8_t *at = malloc(all);
    if (!at) return fail_memory(scene->context, all);
    for (size_t k = 0; k < LIGHT_SOURCES; at += counts[k++]) out->of[k] = at;
    memset(out->of[0], 0, all);
    memset(out->of[FATHOM_SOURCE_OBJECT], LIGHT_GROUP_NONE, scene->objects.count);
    for (size_t i = 0; i < scene->grouped_lights.count; ++i) {
        const scene_grouped_light *g = &scene->grouped_lights.items[i];
        out->of[g->source][g->id] = g->group;
    }
    return FATHOM_OK;
}

void light_groups_destroy(light_groups *groups) {
    free(groups->of[0]);
    *groups = (light_groups){.count = 0};
}
