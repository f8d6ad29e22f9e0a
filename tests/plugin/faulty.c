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

const fathom_plugin *fathom_plugin_get(void) {
    static const fathom_plugin next = {
        FATHOM_PLUGIN_VERSION + 1, "next", 0.5, build, answer, answer, destroy};
    static const fathom_plugin holes = {FATHOM_PLUGIN_VERSION, "holes", 0.5, build, NULL, answer, destroy};
    static const fathom_plugin fails = {FATHOM_PLUGIN_VERSION, "fails", 0.5, build, answer, answer, destroy};
    static const fathom_plugin wild = {
        FATHOM_PLUGIN_VERSION, "wild", 0.5, build_nothing, answer, answer, destroy};
    const char *what = getenv("FATHOM_TEST_PLUGIN");
    if (!what) return NULL;
    if (strcmp(what, "next") == 0) return &next;
    if (strcmp(what, "holes") == 0) return &holes;
    return strcmp(what, "wild") == 0 ? &wild : &fails;
}
