/* Light groups: sets of light sources whose light is kept separate in the image. */
#pragma once

#include "scene/scene.h"

#define LIGHT_SOURCES ((size_t)FATHOM_SOURCE_BACKGROUND + 1)
/* Special values: for light from outside the scene that belongs to several groups, and for an object without
 * a group. */
#define LIGHT_GROUP_OUTSIDE 255
#define LIGHT_GROUP_NONE 254

/* The group of each source, by its id. Sources without a group are in group 0. */
typedef struct light_groups {
    uint32_t count;             /* of groups; 0: light groups are not used */
    uint8_t *of[LIGHT_SOURCES]; /* by fathom_light_source */
} light_groups;

/* Finds the number of the group with this name; adds the group if it is new. FATHOM_BAD_INPUT: the name is
 * not valid, or there are too many groups. */
fathom_status light_group_find(fathom_scene *scene, const char *name, uint8_t *out);

fathom_status light_groups_create(const fathom_scene *scene, light_groups *out);
void light_groups_destroy(light_groups *groups);

/* The group of a surface: that of the object, else that of the material. */
static inline uint8_t light_group_at(const light_groups *g, fathom_id object, fathom_id material) {
    const uint8_t own = g->of[FATHOM_SOURCE_OBJECT][object];
    return own == LIGHT_GROUP_NONE ? g->of[FATHOM_SOURCE_MATERIAL][material] : own;
}
