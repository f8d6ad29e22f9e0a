#include "trace/embree/beside.h"

#include "base/kernel.h"

KERNEL_DECLARE(beside_kernels, beside_kernels);

const beside_kernels *beside_kernels_best(void) {
    static const beside_kernels *const all[] = KERNEL_SETS(beside_kernels);
    return all[kernel_levels() - 1];
}

static void add_sphere(const world *w, uint32_t geometry, uint32_t primitive, beside_spheres *out) {
    const world_geometry *run = &w->geometries.items[geometry];
    const world_sphere *sphere = &w->spheres.items[run->first + primitive];
    unsigned k = out->count++;
    out->x[k] = sphere->center.x, out->y[k] = sphere->center.y, out->z[k] = sphere->center.z;
    out->radius[k] = sphere->radius;
    out->sphere[k] = sphere;
    out->geometry[k] = geometry, out->primitive[k] = primitive;
    if (!(run->flags & FATHOM_CASTS_NO_SHADOW)) out->shadows |= 1u << k;
}

bool beside_gather(const world *w, beside_spheres *out) {
    const world_group *root = &w->groups.items[0];
    *out = (beside_spheres){.count = 0};
    uint64_t count = 0;
    for (uint32_t g = root->first; g < root->first + root->count; ++g)
        count += w->geometries.items[g].kind == WORLD_SPHERES ? w->geometries.items[g].count : 0;
    if (!count || count > BESIDE_MOST) return false;
    for (uint32_t g = root->first; g < root->first + root->count; ++g) {
        if (w->geometries.items[g].kind != WORLD_SPHERES) continue;
        for (uint32_t i = 0; i < w->geometries.items[g].count; ++i) add_sphere(w, g, i, out);
    }
    return true;
}
