/* A library that strikes a file, the one that $TRUNCATE names: when it is built, or when it is asked for rays
 * for the first or the hundredth time, as $TRUNCATE_WHEN says ("build", "trace", "late"). $TRUNCATE_HOW says
 * what it does: cuts it to nothing (default), or changes the last byte ("write"). */
#include "linear.h"

#include <fcntl.h>
#include <stdatomic.h>

#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static bool inside(const double weight[3], bool front) {
    (void)front;
    return weight[0] >= 0 && weight[1] >= 0 && weight[2] >= 0;
}

/* The system's clock of files ticks a hundred times a second or more. */
static int write_last(const char *path) {
    char last;
    usleep(20000);
    int descriptor = open(path, O_RDWR);
    off_t at = lseek(descriptor, -1, SEEK_END);
    if (descriptor < 0 || pread(descriptor, &last, 1, at) != 1) return -1;
    last ^= 1;
    if (pwrite(descriptor, &last, 1, at) != 1) return -1;
    return close(descriptor);
}

static int strike_so(const char *path, const char *how) {
    if (how && strcmp(how, "write") == 0) return write_last(path);
    return truncate(path, 0);
}

static void strike(const char *moment) {
    static atomic_bool struck;
    const char *path = getenv("TRUNCATE"), *when = getenv("TRUNCATE_WHEN");
    if (!path || !when || strcmp(when, moment) != 0 || atomic_exchange(&struck, true)) return;
    if (strike_so(path, getenv("TRUNCATE_HOW")) != 0) perror(path);
}

static int build_cut(const fathom_plugin_mesh *mesh, unsigned threads, char *message, size_t message_size,
                     void **out) {
    strike("build");
    return build(mesh, threads, message, message_size, out);
}

static void closest_cut(const void *tracer, fathom_plugin_block *blocks, size_t count) {
    static atomic_uint calls;
    strike("trace");
    if (atomic_fetch_add(&calls, 1) == 99) strike("late");
    closest(tracer, blocks, count);
}

const fathom_plugin *fathom_plugin_get(void) {
    static fathom_plugin plugin = LINEAR_PLUGIN("example: strikes files");
    plugin.build = build_cut;
    plugin.closest = closest_cut;
    return &plugin;
}
