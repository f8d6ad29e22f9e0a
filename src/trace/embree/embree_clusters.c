#include "trace/embree/embree_clusters.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/threads.h"
#include "trace/embree/embree_limits.h"

#include <math.h>
#include <stdlib.h>

/* ---- spheres in the order of clusters ---- */

typedef struct item {
    float at[3];
    uint32_t primitive;
} item;

typedef struct run {
    item *items;
    size_t count;
} run;

/* The number of runs that are split in parallel. */
enum { LEVELS = 6, RUNS = 1 << LEVELS };

typedef struct run_list {
    run runs[RUNS];
    size_t count;
} run_list;

static unsigned longest_axis(const run *r) {
    float lower[3], upper[3];
    for (int k = 0; k < 3; ++k) lower[k] = upper[k] = r->items[0].at[k];
    for (size_t i = 1; i < r->count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const float x = r->items[i].at[k];
            lower[k] = x < lower[k] ? x : lower[k], upper[k] = x > upper[k] ? x : upper[k];
        }
    }
    const float x = upper[0] - lower[0], y = upper[1] - lower[1], z = upper[2] - lower[2];
    return x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
}

/* Moves the `first` smallest items along the axis to the front (Hoare's selection). Pivots come from a fixed
 * pseudo-random sequence, so that no usual order of spheres is the worst case. */
static void select_first(const run *r, size_t first, unsigned axis) {
    item *a = r->items;
    ptrdiff_t low = 0, high = (ptrdiff_t)r->count - 1, k = (ptrdiff_t)first;
    uint64_t draw = r->count;
    while (low < high) {
        draw = draw * 6364136223846793005u + 1442695040888963407u;
        const float pivot = a[low + (ptrdiff_t)((draw >> 33) % (uint64_t)(high - low + 1))].at[axis];
        ptrdiff_t i = low, j = high;
        while (i <= j) {
            while (a[i].at[axis] < pivot) ++i;
            while (a[j].at[axis] > pivot) --j;
            if (i > j) break;
            const item kept = a[i];
            a[i++] = a[j], a[j--] = kept;
        }
        if (k > j && k < i) return;
        if (k <= j)
            high = j;
        else
            low = i;
    }
}

/* Halves the run along its longest axis recursively, always at a multiple of CLUSTER, down to single
 * clusters. With `left`, it stops after `levels` levels and appends the remaining runs to the list. */
static void halve(const run *r, unsigned levels, run_list *left) {
    if (r->count <= CLUSTER) return;
    if (left && !levels) {
        left->runs[left->count++] = *r;
        return;
    }
    const size_t first = (r->count + CLUSTER - 1) / CLUSTER / 2 * CLUSTER;
    select_first(r, first, longest_axis(r));
    halve(&(run){r->items, first}, levels - 1, left);
    halve(&(run){r->items + first, r->count - first}, levels - 1, left);
}

static void halve_runs(void *user, size_t begin, size_t end) {
    const run_list *list = user;
    for (size_t i = begin; i < end; ++i) halve(&list->runs[i], 0, NULL);
}

/* ---- clusters ---- */

typedef struct filling {
    run all;
    sphere_clusters *out;
} filling;

static void fill(void *user, size_t begin, size_t end) {
    const filling *f = user;
    for (size_t c = begin; c < end; ++c) {
        sphere_cluster *to = &f->out->items[c];
        const item *from = f->all.items + CLUSTER * c;
        const size_t count = f->all.count - CLUSTER * c < CLUSTER ? f->all.count - CLUSTER * c : CLUSTER;
        *to = (sphere_cluster){.lanes = (1u << count) - 1};
        for (size_t k = 0; k < CLUSTER; ++k) {
            /* Unused lanes repeat the first sphere. */
            const uint32_t primitive = from[k < count ? k : 0].primitive;
            const world_sphere *s = &f->out->spheres[primitive];
            to->x[k] = s->center.x, to->y[k] = s->center.y, to->z[k] = s->center.z;
            to->radius[k] = s->radius, to->primitive[k] = primitive;
            to->split |= (uint32_t)world_sphere_is_split(s) << k;
        }
    }
}

/* True if Embree can hold the sphere, including the margin of its bounds. */
static bool holdable(const world_sphere *s) {
    return world_reach_of(s->center) + fabsf(s->radius) < REACH_LARGEST * (1 - 0x1p-8f);
}

fathom_status clusters_make(fathom_context *context, const world_sphere *spheres, uint32_t count,
                            unsigned threads, sphere_clusters *out) {
    const size_t most = ((size_t)count + CLUSTER - 1) / CLUSTER,
                 bytes = count * sizeof(item) + most * sizeof *out->items;
    run_list left = {.count = 0};
    run all = {memory_has(bytes) ? malloc(count * sizeof *all.items) : NULL, 0};
    out->spheres = spheres;
    out->items = all.items ? aligned_alloc(_Alignof(sphere_cluster), most * sizeof *out->items) : NULL;
    if (!out->items) {
        free(all.items);
        return fail_memory(context, bytes);
    }
    for (uint32_t i = 0; i < count; ++i) {
        const vec3_f32 c = spheres[i].center;
        if (holdable(&spheres[i])) all.items[all.count++] = (item){{c.x, c.y, c.z}, i};
    }
    halve(&all, LEVELS, &left);
    loop_parallel(threads, left.count, 1, halve_runs, &left);
    out->count = (uint32_t)((all.count + CLUSTER - 1) / CLUSTER);
    loop_parallel(threads, out->count, 1024, fill, &(filling){all, out});
    free(all.items);
    return FATHOM_OK;
}
