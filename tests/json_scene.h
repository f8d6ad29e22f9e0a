/* Scene JSON from text, for tests. */
#pragma once

#include "owned.h"
#include "read/read.h"

#include <unistd.h>

/* A folder of the test's own with triangle.obj and the scene.json that is being read. */
typedef struct json_scene {
    fathom_context *context;
    char folder[64], file[96], mesh[96];
} json_scene;

static inline void json_scene_open(json_scene *s) {
    static const char triangle[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    assert_int_equal(fathom_context_create(&s->context), FATHOM_OK);
    snprintf(s->folder, sizeof s->folder, "/tmp/fathom-json-XXXXXX");
    assert_non_null(mkdtemp(s->folder));
    snprintf(s->file, sizeof s->file, "%s/scene.json", s->folder);
    snprintf(s->mesh, sizeof s->mesh, "%s/triangle.obj", s->folder);
    unit_write_file(s->mesh, triangle, strlen(triangle));
}

static inline void json_scene_close(json_scene *s) {
    unlink(s->file);
    unlink(s->mesh);
    rmdir(s->folder);
    fathom_context_destroy(s->context);
}

/* Reads the text into a new scene; *out is NULL when that fails. */
static inline fathom_status json_scene_read(json_scene *s, const char *text, size_t size,
                                            fathom_scene **out) {
    unit_write_file(s->file, text, size);
    fathom_scene *scene = new_scene(s->context);
    const fathom_status status = read_json(scene, s->file);
    *out = status == FATHOM_OK ? scene : NULL;
    return status;
}

static inline fathom_scene *json_scene_good(json_scene *s, const char *text) {
    fathom_scene *scene;
    assert_ok(s->context, json_scene_read(s, text, strlen(text), &scene));
    return scene;
}

/* The text is refused with a message that holds all of `message`. */
static inline void json_scene_bad(json_scene *s, const char *text, const char *message) {
    fathom_scene *scene;
    assert_fails(s->context, json_scene_read(s, text, strlen(text), &scene), FATHOM_BAD_INPUT, message);
}
