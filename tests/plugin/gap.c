/* A library with a deliberate bug that images hardly show: rays through the first vertex's sides within a
 * millionth of the edge are lost. */
#include "linear.h"

static bool inside(const double weight[3], bool front) {
    (void)front;
    return weight[0] >= 0 && weight[1] > 1e-6 && weight[2] > 1e-6;
}

const fathom_plugin *fathom_plugin_get(void) {
    static const fathom_plugin plugin = LINEAR_PLUGIN("example: loses edges");
    return &plugin;
}
