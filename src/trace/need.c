#include "trace/need.h"

/* Embree 3.13.5 on a displaced sphere, bytes a triangle beyond the mesh's own: of 2 and 8 million triangles
 * the usual structures keep 68 and 63 and pass 35 and 32 while they are built; at low quality they keep 92
 * and pass 12, which is the same at the most. Compact ones keep 36 and pass 2; at low quality, 50 and 22. Of
 * less than a million, compact ones pass as much as the usual, and some megabytes. Spheres are boxes with a
 * callback, and cost about as much; quads are two triangles. */
static const trace_need usual = {68, 36}, compact = {37, 4};

/* Of a million and two million instances of one triangle, with what Embree allocates for each besides what it
 * tells of. */
static const trace_need instance = {440, 120};

/* A mesh with flat triangles has its indices copied, quads have indices and corners; see embree_native.c. */
static double copied_bytes(const world_geometry *geometry) {
    double indices = 3 * sizeof(uint32_t) * (double)geometry->count;
    if (geometry->kind == WORLD_QUADS) return 2 * indices + sizeof(world_quad) * (double)geometry->count;
    return geometry->kind == WORLD_MESH && geometry->flat ? indices : 0;
}

trace_need trace_need_of(const world *w, bool is_compact) {
    trace_need each = is_compact ? compact : usual;
    double n = 0, more = 0, copied = 0, instances = (double)w->instances.count;
    for (size_t i = 0; i < w->geometries.count; ++i) {
        const world_geometry *geometry = &w->geometries.items[i];
        n += (geometry->kind == WORLD_QUADS ? 2.0 : 1.0) * geometry->count;
        copied += copied_bytes(geometry);
    }
    if (is_compact && n < 1e6) each.passed = usual.passed, more = 16e6;
    return (trace_need){each.kept * n + instance.kept * instances + copied,
                        each.passed * n + instance.passed * instances + more};
}
