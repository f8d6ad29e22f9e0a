/* A library with a deliberate bug that images hardly show: rays through the first vertex's sides within a
 * millionth of the edge are lost. */
#include "linear.h"

static bool inside(double u, double v, bool front) {
    (void)front;
    return u > 1e-6 && v > 1e-6 && u + v <= 1;
}

const fathom_plugin *fathom_plugin_get(void) {
    static const fathom_plugin plugin = LINEAR_PLUGIN("example: loses edges");
    return &plugin;
}
