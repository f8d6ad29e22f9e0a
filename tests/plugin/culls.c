/* A library with a deliberate bug: triangles are not hit from behind. */
#include "linear.h"

static bool inside(const double weight[3], bool front) {
    return front && weight[0] >= 0 && weight[1] >= 0 && weight[2] >= 0;
}

const fathom_plugin *fathom_plugin_get(void) {
    static const fathom_plugin plugin = LINEAR_PLUGIN("example: culls back faces");
    return &plugin;
}
