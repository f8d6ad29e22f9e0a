/* Scenes that go through a file. */
#pragma once

#include "owned.h"
#include "unit_folder.h"

static inline fathom_scene *written(const fathom_scene *scene, const char *name) {
    assert_ok(context, fathom_scene_write(scene, in_folder(name)));
    return scene_of_file(context, in_folder(name));
}
