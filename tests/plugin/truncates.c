/* A library that cuts a file to nothing, the one that $TRUNCATE names: when it is built, or when it is asked
 * for the first ray, as $TRUNCATE_WHEN says ("build", "trace"). */
#include "linear.h"

#include <string.h>
#include <unistd.h>

static bool inside(const double weight[3], bool front) {
    (void)front;
    return weight[0] >= 0 && weight[1] >= 0 && weight[2] >= 0;
}

static void strike(const char *moment) {
    const char *path = getenv("TRUNCATE"), *when = getenv("TRUNCATE_WHEN");
    if (!path || !when || strcmp(when, moment) != 0) return;
    if (truncate(path, 0) != 0) perror(path);
}

static int build_cut(const fathom_plugin_mesh *mesh, unsigned threads, char *message, size_t message_size,
                     void **out) {
    strike("build");
    return build(mesh, threads, message, message_size, out);
}

static void closest_cut(const void *tracer, fathom_plugin_block *blocks, size_t count) {
    strike("trace");
    closest(tracer, blocks, count);
}

const fathom_plugin *fathom_plugin_get(void) {
    static fathom_plugin plugin = LINEAR_PLUGIN("example: cuts files");
    plugin.build = build_cut;
    plugin.closest = closest_cut;
    return &plugin;
}
