/* Worlds that end with the test that made them. */
#pragma once

#include "owned.h"
#include "scene/scene.h"
#include "scene/world/world.h"

UNIT_OWNS(world, world, world_destroy)

static inline world *new_world(const fathom_scene *of) {
    world *w;
    assert_ok(of->context, world_create(of, &w));
    return own_world(w);
}
