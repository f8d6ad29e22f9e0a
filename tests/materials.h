/* Materials by name. */
#pragma once

#include "scene/scene.h"

#include <string.h>

/* FATHOM_NONE: there is none. */
static inline fathom_id find_material(const fathom_scene *scene, const char *name) {
    for (size_t i = 0; i < scene->materials.count; ++i) {
        const char *other = scene->materials.items[i].name;
        if (other && strcmp(other, name) == 0) return (fathom_id)i;
    }
    return FATHOM_NONE;
}
