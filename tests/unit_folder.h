/* A folder of the test's own, and a context. A file that is left in it and that no test names makes the
 * program fail. */
#pragma once

#include "unit.h"

#include <fathom/base.h>

#include <unistd.h>

static fathom_context *context;
static char folder[] = "/tmp/fathom-test-XXXXXX";

static inline void remove_path(void *path) {
    remove(path);
    free(path);
}

/* The path of a file in it; valid until the eighth call after. The file ends with the test, and a library of
 * materials with its .obj file. */
static inline const char *in_folder(const char *name) {
    static char paths[8][512];
    static unsigned next;
    char *path = paths[next++ % 8];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    unit_own(strdup(path), remove_path);
    char *end = strrchr(path, '.'), *library;
    if (end && strcmp(end, ".obj") == 0) {
        assert_true(asprintf(&library, "%.*s.mtl", (int)(end - path), path) > 0);
        unit_own(library, remove_path);
    }
    return path;
}

static inline const char *put_text(const char *name, const char *text) {
    const char *path = in_folder(name);
    unit_write_file(path, text, strlen(text));
    return path;
}

static char warned[4096]; /* the warnings since forget_warnings(), a line each */
static unsigned warning_count;

static inline void note_warning(void *user, const char *text) {
    (void)user;
    ++warning_count;
    const size_t used = strlen(warned);
    snprintf(warned + used, sizeof warned - used, "%s\n", text);
}

static inline void forget_warnings(void) { warning_count = 0, warned[0] = '\0'; }

static inline void expect_warning(const char *text) {
    if (!strstr(warned, text)) fail_msg("no \"%s\" in:\n%s", text, warned);
}

/* Set-up and tear-down of a group of tests. Views are those of no $OCIO. */
static inline int open_folder(void **state) {
    (void)state;
    unsetenv("OCIO");
    if (!mkdtemp(folder) || fathom_context_create(&context) != FATHOM_OK) return -1;
    fathom_context_on_warning(context, note_warning, NULL);
    return 0;
}

static inline int remove_folder(void **state) {
    (void)state;
    fathom_context_destroy(context);
    return rmdir(folder);
}
