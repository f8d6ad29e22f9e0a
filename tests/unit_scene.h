/* An empty scene and its context, for tests that fill it: set-up and tear-down of each. */
#pragma once

#include "unit.h"

#include <fathom/scene.h>

static fathom_context *context;
static fathom_scene *scene;

static inline int open_scene(void **state) {
    (void)state;
    if (fathom_context_create(&context) != FATHOM_OK) return -1;
    return fathom_scene_create(context, &scene) == FATHOM_OK ? 0 : -1;
}

static inline int close_scene(void **state) {
    (void)state;
    fathom_scene_destroy(scene);
    fathom_context_destroy(context);
    return 0;
}
