/* Contexts, scenes and films that end with the test that made them. */
#pragma once

#include "base/status.h" /* before unit.h: cmocka has a macro fail() */

#include "defaults.h"
#include "unit.h"

UNIT_OWNS(context, fathom_context, fathom_context_destroy)
UNIT_OWNS(scene, fathom_scene, fathom_scene_destroy)
UNIT_OWNS(film, fathom_film, fathom_film_destroy)

static inline fathom_context *new_context(void) {
    fathom_context *context;
    assert_int_equal(fathom_context_create(&context), FATHOM_OK);
    return own_context(context);
}

static inline fathom_scene *new_scene(fathom_context *context) {
    fathom_scene *scene;
    assert_ok(context, fathom_scene_create(context, &scene));
    return own_scene(scene);
}

static inline fathom_scene *scene_of_file(fathom_context *context, const char *path) {
    fathom_scene *scene;
    assert_ok(context, fathom_scene_read(context, path, &scene));
    return own_scene(scene);
}

static inline fathom_id new_group(fathom_scene *scene, const char *name) {
    fathom_id id;
    assert_int_equal(fathom_scene_add_group(scene, name, &id), FATHOM_OK);
    return id;
}

static inline fathom_id new_material(fathom_scene *scene, const char *name, const fathom_material *material) {
    fathom_id id;
    assert_int_equal(fathom_scene_add_material(scene, name, material, &id), FATHOM_OK);
    return id;
}

static inline fathom_id new_texture(fathom_scene *scene, const fathom_texture *texture) {
    fathom_id id;
    assert_int_equal(fathom_scene_add_texture(scene, texture, &id), FATHOM_OK);
    return id;
}
