#include "fuzz.h"

#include "read/read.h"

#include <stdlib.h>
#include <string.h>

static void look_for_controls(const char *text) {
    for (const char *c = text; *c; ++c) {
        const bool above = (unsigned char)c[0] == 0xc2 && (unsigned char)c[1] < 0xa0; /* C1 in UTF-8 */
        if ((unsigned char)*c < 32 || *c == 127 || above)
            fuzz_wrong("a control character in the message: %s", text);
    }
}

static void on_warning(void *user, const char *message) {
    (void)user;
    look_for_controls(message);
}

fathom_context *fuzz_context(void) {
    static fathom_context *context;
    if (context) return context;
    if (fathom_context_create(&context) != FATHOM_OK) abort();
    fathom_context_set_threads(context, 1);
    fathom_context_on_warning(context, on_warning, NULL);
    return context;
}

void fuzz_judge(fathom_status status) {
    if (status == FATHOM_OK) return;
    const char *message = fathom_context_message(fuzz_context());
    if (status != FATHOM_BAD_INPUT) fuzz_wrong("status %d: %s", (int)status, message);
    if (!fuzz_names_file(message)) fuzz_wrong("a message that begins with no file: %s", message);
    look_for_controls(message);
}

/* Once more as options have it: with smooth normals, while a shutter is open, as a variant. */
static void read_otherwise(const char *path) {
    fathom_scene *scene;
    if (fathom_scene_create(fuzz_context(), &scene) != FATHOM_OK) abort();
    const read_mesh_options options = {.material = FATHOM_NONE, .smooth = true};
    const fathom_read_options asked = {
        .size = sizeof asked, .choose_time = true, .time = 0.25, .shutter = 0.5, .variant = "0"};
    scene->asked = &asked;
    fuzz_judge(read_mesh(scene, FATHOM_ROOT, path, &options));
    fathom_scene_destroy(scene);
}

void fuzz_scene(const char *path, size_t size, size_t factor) {
    fathom_scene *scene;
    fathom_context *context = fuzz_context();
    fuzz_begin(size, factor);
    fathom_status status = fathom_scene_read(context, path, &scene);
    fuzz_judge(status);
    fathom_scene_destroy(scene);
    if (status == FATHOM_OK && !strstr(path, ".json")) read_otherwise(path);
    fuzz_end();
}
