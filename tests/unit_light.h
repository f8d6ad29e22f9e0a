/* The emitters of a scene, for tests that fill it: set-up and tear-down of each. */
#pragma once

#include "light/emitters.h"
#include "unit_scene.h"

static world *w;
static emitters *e;

/* The background is black until a test sets another. */
static inline int begin_light(void **state) {
    const int failed = open_scene(state);
    if (!failed) fathom_scene_set_background(scene, (float[3]){0, 0, 0});
    return failed;
}

/* The scene must be filled. */
static inline void open_light(void) {
    assert_ok(context, world_create(scene, &w));
    assert_ok(context, emitters_create(context, w, NULL, NULL, &e));
}

static inline int end_light(void **state) {
    emitters_destroy(e);
    world_destroy(w);
    e = NULL, w = NULL;
    return close_scene(state);
}
