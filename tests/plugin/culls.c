/* A library with a deliberate bug: triangles are not hit from behind. */
#include "linear.h"

static bool inside(double u, double v, bool front) { return front && u >= 0 && v >= 0 && u + v <= 1; }

const fathom_plugin *fathom_plugin_get(void) {
    static const fathom_plugin plugin = LINEAR_PLUGIN("example: culls back faces");
    return &plugin;
}
