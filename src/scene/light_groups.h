/* Light groups: which sources of light are kept apart in the image. */
#ifndef SCENE_LIGHT_GROUPS_H
#define SCENE_LIGHT_GROUPS_H

#include "scene/scene.h"

#define LIGHT_SOURCES ((size_t)FATHOM_SOURCE_BACKGROUND + 1)
/* Stand for light from outside that belongs to several groups at once, and for an object without a group.
 */
#define LIGHT_GROUP_OUTSIDE 255
#define LIGHT_GROUP_NONE 254

/* The group of each source, by its id. Group 0 is of those that were put into none. */
typedef struct light_groups {
    uint32_t count;             /* of groups; 0: nobody asked for them */
    uint8_t *of[LIGHT_SOURCES]; /* by fathom_light_source */
} light_groups;

/* The number of the group of this name, which becomes one if it is new. FATHOM_BAD_INPUT: the name cannot be
 * one, or there are too many. */
fathom_status light_group_find(fathom_scene *scene, const char *name, uint8_t *out);

fathom_status light_groups_create(const fathom_scene *scene, light_groups *out);
void light_groups_destroy(light_groups *groups);

/* The group of a surface. */
static inline uint8_t light_group_at(const light_groups *g, fathom_id object, fathom_id material) {
    const uint8_t own = g->of[FATHOM_SOURCE_OBJECT][object];
    return own == LIGHT_GROUP_NONE ? g->of[FATHOM_SOURCE_MATERIAL][material] : own;
}

#endif
