/* A tracer as anyone might write one: linear search in double by Woop, Benthin and Wald 2013, so that
 * neighbours agree about their edge. The libraries beside it include this text, each with a test for "inside"
 * of its own. */
#pragma once

#include <fathom/plugin.h>

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

/* Whether a point with these weights of the three vertices is inside; `front`: the ray comes from the side
 * from which the vertices run counterclockwise. */
static bool inside(const double weight[3], bool front);

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

/* The vertex as seen by a ray that starts at 0 and runs along z. */
static void shear(const float *vertex, const float org[3], const double dir[3], int axis, double out[3]) {
    double p[3];
    subtract(vertex, org, p);
    int x = (axis + 1) % 3, y = (axis + 2) % 3;
    out[0] = p[x] - dir[x] / dir[axis] * p[axis], out[1] = p[y] - dir[y] / dir[axis] * p[axis];
    out[2] = p[axis];
}

static double side(const double a[3], const double b[3]) { return a[0] * b[1] - a[1] * b[0]; }

static int longest_axis(const double v[3]) {
    double x = fabs(v[0]), y = fabs(v[1]), z = fabs(v[2]);
    return x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
}

static bool meets(const fathom_plugin_mesh *mesh, uint32_t triangle, const float org[3], const double dir[3],
                  double t_near, double t_far, double hit[3]) {
    const uint32_t *index = &mesh->indices[3 * (size_t)triangle];
    const float *v[3];
    double p[3][3], e[3], g[3], n[3];
    int axis = longest_axis(dir);
    for (int k = 0; k < 3; ++k) {
        v[k] = &mesh->positions[3 * (size_t)index[k]];
        shear(v[k], org, dir, axis, p[k]);
    }
    double weight[3] = {side(p[2], p[1]), side(p[0], p[2]), side(p[1], p[0])};
    double sum = weight[0] + weight[1] + weight[2], depth = 0;
    for (int k = 0; k < 3; ++k) weight[k] /= sum, depth += weight[k] * p[k][2];
    subtract(v[1], v[0], e), subtract(v[2], v[0], g), cross(e, g, n);
    double along = dot(dir, n), t = depth / dir[axis];
    if (!(along != 0 && t > t_near && t < t_far && inside(weight, along < 0))) return false;
    hit[0] = t, hit[1] = weight[1], hit[2] = weight[2];
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
