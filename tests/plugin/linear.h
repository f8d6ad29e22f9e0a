/* A tracer as anyone might write one: linear search in double by Möller and Trumbore 1997. The libraries
 * beside it include this text, each with a test for "inside" of its own. */
#ifndef TESTS_PLUGIN_LINEAR_H
#define TESTS_PLUGIN_LINEAR_H

#include <fathom/plugin.h>

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

/* Whether weights u, v of the second and third vertex are inside; `front`: the ray comes from the side from
 * which the vertices run counterclockwise. */
static bool inside(double u, double v, bool front);

typedef struct linear_mesh {
    fathom_plugin_mesh mesh;
} linear_mesh;

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void subtract(const float *a, const float *b, double out[3]) {
    for (int k = 0; k < 3; ++k) out[k] = (double)a[k] - (double)b[k];
}

static bool meets(const fathom_plugin_mesh *mesh, uint32_t triangle, const float org[3], const double dir[3],
                  double t_near, double t_far, double hit[3]) {
    const uint32_t *index = &mesh->indices[3 * (size_t)triangle];
    const float *a = &mesh->positions[3 * (size_t)index[0]], *b = &mesh->positions[3 * (size_t)index[1]],
                *c = &mesh->positions[3 * (size_t)index[2]];
    double e[3], g[3], s[3], p[3], q[3];
    subtract(b, a, e), subtract(c, a, g), subtract(org, a, s);
    cross(dir, g, p), cross(s, e, q);
    double along = dot(e, p), t = dot(g, q) / along, u = dot(s, p) / along, v = dot(dir, q) / along;
    if (!(along != 0 && t > t_near && t < t_far && inside(u, v, along > 0))) return false;
    hit[0] = t, hit[1] = u, hit[2] = v;
    return true;
}

static void lane(const fathom_plugin_mesh *mesh, fathom_plugin_block *block, unsigned i, bool any) {
    const float org[3] = {block->org_x[i], block->org_y[i], block->org_z[i]};
    const double dir[3] = {(double)block->dir_x[i], (double)block->dir_y[i], (double)block->dir_z[i]};
    double far = (double)block->t_far[i], hit[3];
    for (uint32_t k = 0; k < mesh->triangle_count; ++k) {
        if (!meets(mesh, k, org, dir, (double)block->t_near[i], far, hit)) continue;
        block->primitive[i] = k;
        block->t[i] = far = hit[0], block->u[i] = hit[1], block->v[i] = hit[2];
        if (any) return;
    }
}

static void trace(const void *tracer, fathom_plugin_block *blocks, size_t count, bool any) {
    const fathom_plugin_mesh *mesh = &((const linear_mesh *)tracer)->mesh;
    for (size_t b = 0; b < count; ++b) {
        for (unsigned i = 0; i < FATHOM_PLUGIN_WIDTH; ++i) {
            blocks[b].primitive[i] = FATHOM_PLUGIN_MISS;
            if (blocks[b].active >> i & 1) lane(mesh, &blocks[b], i, any);
        }
    }
}

static void closest(const void *tracer, fathom_plugin_block *blocks, size_t count) {
    trace(tracer, blocks, count, false);
}
static void any(const void *tracer, fathom_plugin_block *blocks, size_t count) {
    trace(tracer, blocks, count, true);
}

/* The arrays stay valid until destroy(), so there is nothing to copy. */
static int build(const fathom_plugin_mesh *mesh, unsigned threads, char *message, size_t message_size,
                 void **out) {
    (void)threads;
    linear_mesh *own = malloc(sizeof *own);
    if (!own) {
        snprintf(message, message_size, "out of memory");
        return 1;
    }
    own->mesh = *mesh;
    *out = own;
    return 0;
}

static void destroy(void *tracer) { free(tracer); }

#define LINEAR_PLUGIN(name)                                                                                  \
    { FATHOM_PLUGIN_VERSION, name, 0x1p-53, build, closest, any, destroy }

#endif
