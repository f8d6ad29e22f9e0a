/* A library that is right. */
#include "linear.h"

static bool inside(double u, double v, bool front) {
    (void)front;
    return u >= 0 && v >= 0 && u + v <= 1;
}

const fathom_plugin *fathom_plugin_get(void) {
    static const fathom_plugin plugin = LINEAR_PLUGIN("example: correct");
    return &plugin;
}
