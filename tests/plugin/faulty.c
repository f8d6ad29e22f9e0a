/* A library that does not keep the contract, in the way that FATHOM_TEST_PLUGIN names. */
#include <fathom/plugin.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int build(const fathom_plugin_mesh *mesh, unsigned threads, char *message, size_t message_size,
                 void **out) {
    (void)mesh, (void)threads, (void)out;
    snprintf(message, message_size, "not today");
    return 1;
}

static int build_mutely(const fathom_plugin_mesh *mesh, unsigned threads, char *message, size_t message_size,
                        void **out) {
    (void)mesh, (void)threads, (void)message, (void)message_size, (void)out;
    return 1;
}

static int build_nothing(const fathom_plugin_mesh *mesh, unsigned threads, char *message, size_t message_size,
                         void **out) {
    (void)mesh, (void)threads, (void)message, (void)message_size;
    *out = NULL;
    return 0;
}

/* Names a triangle that does not exist. */
static void answer(const void *tracer, fathom_plugin_block *blocks, size_t count) {
    (void)tracer;
    for (size_t b = 0; b < count; ++b) {
        for (int i = 0; i < FATHOM_PLUGIN_WIDTH; ++i) blocks[b].primitive[i] = 0x7fffffff, blocks[b].t[i] = 1;
    }
}

static void destroy(void *tracer) { (void)tracer; }

/* "no N": the N-th of the table's fields behind the version is missing, or a unit that is none. */
static const fathom_plugin *with_hole(char digit) {
    static fathom_plugin table;
    table = (fathom_plugin){FATHOM_PLUGIN_VERSION, "holes", 0.5, build, answer, answer, destroy};
    switch (digit) {
    case '0': table.name = NULL; break;
    case '1': table.unit = 0; break;
    case '2': table.unit = 1; break;
    case '3': table.build = NULL; break;
    case '4': table.closest = NULL; break;
    case '5': table.any = NULL; break;
    default: table.destroy = NULL; break;
    }
    return &table;
}

const fathom_plugin *fathom_plugin_get(void) {
    static const fathom_plugin next = {
        FATHOM_PLUGIN_VERSION + 1, "next", 0.5, build, answer, answer, destroy};
    static const fathom_plugin fails = {FATHOM_PLUGIN_VERSION, "fails", 0.5, build, answer, answer, destroy};
    static const fathom_plugin mute = {
        FATHOM_PLUGIN_VERSION, "mute", 0.5, build_mutely, answer, answer, destroy};
    static const fathom_plugin wild = {
        FATHOM_PLUGIN_VERSION, "wild", 0.5, build_nothing, answer, answer, destroy};
    const char *what = getenv("FATHOM_TEST_PLUGIN");
    if (!what) return NULL;
    if (strcmp(what, "next") == 0) return &next;
    if (strncmp(what, "no ", 3) == 0) return with_hole(what[3]);
    if (strcmp(what, "mute") == 0) return &mute;
    return strcmp(what, "wild") == 0 ? &wild : &fails;
}
