/* An empty scene and its context, for tests that fill it: set-up of each. */
#pragma once

#include "math/affine.h"
#include "owned.h"

static fathom_context *context;
static fathom_scene *scene;

static inline int open_scene(void **state) {
    (void)state;
    context = new_context();
    scene = new_scene(context);
    return 0;
}

static inline fathom_id add_group(void) { return new_group(scene, NULL); }

static inline void place_still(fathom_id group, fathom_id parent, const affine_f64 *map) {
    fathom_instance instance = default_instance();
    memcpy(instance.transform, map->m, sizeof instance.transform);
    instance.group = group, instance.parent = parent;
    assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
}
