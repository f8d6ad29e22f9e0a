#include "trace/planes.h"
#include "reference/reference.h"

/* Where the plane meets each line: first in a loop without branches, then the few lanes whose sign is in
 * doubt. */
static void planes_distances(const world_plane *plane, const trace_rays *rays, int lanes,
                             float t[TRACE_WIDTH]) {
    int doubt[TRACE_WIDTH], any = 0;
    for (int i = 0; i < TRACE_WIDTH; ++i) {
        bool sure;
        t[i] = plane_ratio_f32(plane->point, plane->normal,
                               vec_f32(rays->org_x[i], rays->org_y[i], rays->org_z[i]),
                               vec_f32(rays->dir_x[i], rays->dir_y[i], rays->dir_z[i]), &sure);
        doubt[i] = !sure & (i < lanes);
    }
    for (int i = 0; i < TRACE_WIDTH; ++i) any |= doubt[i];
    if (!any) return;
    for (int i = 0; i < TRACE_WIDTH; ++i) {
        if (!doubt[i]) continue;
        t[i] = plane_wide_f32(plane->point, plane->normal,
                              vec_f32(rays->org_x[i], rays->org_y[i], rays->org_z[i]),
                              vec_f32(rays->dir_x[i], rays->dir_y[i], rays->dir_z[i]));
    }
}

static int lanes_of(size_t count, size_t block) {
    size_t left = count - block * TRACE_WIDTH;
    return left < TRACE_WIDTH ? (int)left : TRACE_WIDTH;
}

static void set_hit(trace_block *block, int lane, const world_plane *plane, uint32_t index, float t) {
    block->rays.t_far[lane] = t;
    trace_hits *hits = &block->hits;
    hits->ng_x[lane] = plane->normal.x, hits->ng_y[lane] = plane->normal.y,
    hits->ng_z[lane] = plane->normal.z;
    hits->u[lane] = hits->v[lane] = 0;
    hits->primitive[lane] = index;
    hits->geometry[lane] = TRACE_PLANE;
    hits->instance[lane] = FATHOM_NONE;
}

void planes_closest(const world *w, trace_block *blocks, size_t count) {
    if (!w->planes.count) return;
    for (size_t b = 0; b * TRACE_WIDTH < count; ++b) {
        int lanes = lanes_of(count, b);
        for (size_t p = 0; p < w->planes.count; ++p) {
            const world_plane *plane = &w->planes.items[p];
            const trace_rays *rays = &blocks[b].rays;
            float t[TRACE_WIDTH];
            planes_distances(plane, rays, lanes, t);
            for (int i = 0; i < lanes; ++i) {
                if (t[i] > rays->t_near[i] && t[i] < rays->t_far[i])
                    set_hit(&blocks[b], i, plane, (uint32_t)p, t[i]);
            }
        }
    }
}

void planes_any(const world *w, trace_rays *blocks, size_t count) {
    for (size_t p = 0; p < w->planes.count; ++p) {
        const world_plane *plane = &w->planes.items[p];
        if (plane->flags & FATHOM_CASTS_NO_SHADOW) continue;
        for (size_t b = 0; b * TRACE_WIDTH < count; ++b) {
            trace_rays *rays = &blocks[b];
            int lanes = lanes_of(count, b);
            float t[TRACE_WIDTH];
            planes_distances(plane, rays, lanes, t);
            for (int i = 0; i < lanes; ++i) {
                if (t[i] > rays->t_near[i] && t[i] < rays->t_far[i]) rays->t_far[i] = -INFINITY;
            }
        }
    }
}
