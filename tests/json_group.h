/* A json_scene for a group of tests, with its set-up and tear-down. */
#pragma once

#include "json_scene.h"

static json_scene s;

static inline int setup(void **state) {
    (void)state;
    json_scene_open(&s);
    return 0;
}

static inline int teardown(void **state) {
    (void)state;
    json_scene_close(&s);
    return 0;
}
