/* Motion while the shutter is open. Nodes are posed at uniform times. There are enough poses that the error
 * of linear interpolation is at most 2^-8 of the largest displacement during the exposure: one pixel for a
 * motion of 256 pixels. */
#include "read/gltf/gltf_mesh.h"
#include "read/gltf/gltf_pose.h"
#include "read/gltf/gltf_tree.h"

#include "scene/motion/motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Poses are sampled at 8 to 64 intervals, twice as many as the keys may then use, and at least as many as
 * samplers have keys. With too few samples, a wheel that returns to the same position at every pose would
 * seem not to move. */
enum { INTERVALS_FIRST = 8, INTERVALS_MOST = GLTF_MOMENTS - 1 };

/* Without a requested time, scene JSON's shutter opens when the file says, and animations stand at 0. */
double gltf_shutter(const gltf *g) {
    const fathom_read_options *asked = g->scene->asked;
    if (!asked || !g->playing.count) return 0;
    return asked->choose_time ? read_shutter(g->scene) : asked->shutter;
}

static uint64_t moment_bytes(const gltf *g) { return g->links.count * sizeof(gltf_world); }

static void open_at(gltf *g, double time) {
    const size_t links = g->links.count;
    g->posing = true;
    if (g->moments.count) gltf_charge(g, &g->animations, NULL, moment_bytes(g));
    g->posing = false;
    if (!gltf_fine(g)) return;
    gltf_moment m = {.time = time, .worlds = calloc(links + 1, sizeof *m.worlds)};
    if (!m.worlds || !array_push(&g->moments, m)) {
        free(m.worlds);
        gltf_fail_memory(g, links * sizeof *m.worlds);
        return;
    }
    if (g->playing.count) gltf_animation_pose(g, &g->moments.items[g->moments.count - 1]);
}

static void close_moment(gltf_moment *m, const gltf *g) {
    for (size_t i = 0; m->skins && i < 2 * gltf_count(&g->skins); ++i) free(m->skins[i].matrices);
    free(m->skins);
    for (size_t i = 0; i < m->poses.count; ++i) free(m->poses.items[i].weights);
    array_free(&m->poses);
    free(m->pose_of);
    free(m->worlds);
}

void gltf_moments_close(gltf *g) {
    for (size_t i = 0; i < g->moments.count; ++i) close_moment(&g->moments.items[i], g);
    g->moments.count = 0;
}

/* ---- how many keys ---- */

/* A column of a node's matrix, or one of its weights, at all moments. */
typedef struct curve {
    gltf *g;
    uint32_t link;
    bool weights;
    bool placed; /* motion_place() must follow it */
    size_t at;
    double part; /* allowed error, as a part of the way */
} curve;

static void point_of(const curve *c, size_t moment, double out[3]) {
    gltf_moment *m = &c->g->moments.items[moment];
    out[1] = out[2] = 0;
    if (c->weights) {
        out[0] = gltf_pose_of(m, c->g->links.items[c->link].node)->weights[c->at];
        return;
    }
    const affine_f64 world = gltf_node_world(c->g, m, c->link);
    for (int i = 0; i < 3; ++i) out[i] = world.m[i][c->at];
}

static double distance(const double a[3], const double b[3]) {
    return length_f64(sub_f64(load_f64(a), load_f64(b)));
}

/* True if both maps have an inverse, and the change from one to the other reverses no axis and turns by less
 * than a right angle: by Hurwitz, each eigenvalue of its linear part has a positive real part. */
static bool keeps_sides(const affine_f64 *from, const affine_f64 *to) {
    affine_f64 back;
    if (!affine_invert(to, &back) || !affine_invert(from, &back)) return false;
    const affine_f64 change = affine_compose(&back, to);
    const double(*m)[4] = change.m;
    const double trace = m[0][0] + m[1][1] + m[2][2],
                 minors = m[0][0] * m[1][1] - m[0][1] * m[1][0] + m[1][1] * m[2][2] - m[1][2] * m[2][1] +
                          m[2][2] * m[0][0] - m[2][0] * m[0][2],
                 determinant = affine_determinant(&change);
    return trace > 0 && determinant > 0 && trace * minors > determinant;
}

/* The point that motion_place() puts between two places. Inside a squashed parent, the rotation that it
 * interpolates is faster than the node's. */
static void place_between(const curve *c, size_t from, size_t to, double u, double out[3]) {
    gltf_moment *m = c->g->moments.items;
    const affine_f64 a = gltf_node_world(c->g, &m[from], c->link), b = gltf_node_world(c->g, &m[to], c->link);
    if (!keeps_sides(&a, &b)) return;
    const motion_parts p = motion_take_apart(&a), q = motion_take_apart(&b), at = motion_between(&p, &q, u);
    const affine_f64 made = motion_put_together(&at);
    for (int i = 0; i < 3; ++i) out[i] = made.m[i][c->at];
}

/* Reduces *stride, to 1 if necessary, until interpolation fits the curve. Positions are sums of products of
 * doubles: 2^-40 of their size is far above the rounding error and far below a visible size. Axes also have
 * the rounding of a file's floats: that of a quaternion turns by up to 2^-23, so 2^-22 allows for two nodes.
 * Otherwise the axle of a wheel, which rests, would need all poses. */
static void fit_curve(const curve *c, size_t *stride) {
    double points[INTERVALS_MOST + 1][3], way = 0, size = 0;
    const size_t intervals = c->g->moments.count - 1;
    for (size_t i = 0; i <= intervals; ++i) {
        point_of(c, i, points[i]);
        way = fmax(way, distance(points[i], points[0]));
        size = fmax(size, length_f64(load_f64(points[i])));
    }
    if (way == 0) return;
    const double slack = c->part * way + (c->weights || c->at == 3 ? 0x1p-40 : 0x1p-22) * size;
    for (size_t i = 0; i<intervals && * stride> 1; ++i) {
        const size_t from = i / *stride * *stride;
        const double u = (double)(i - from) / (double)*stride;
        double between[3];
        for (int k = 0; k < 3; ++k) between[k] = (1 - u) * points[from][k] + u * points[from + *stride][k];
        if (c->placed) place_between(c, from, from + *stride, u, between);
        /* Starts again with half the stride. */
        if (!(distance(between, points[i]) <= slack)) *stride /= 2, i = 0;
    }
}

static void fit_node(gltf *g, uint32_t link, double part, size_t *stride) {
    const gltf_pose *pose = gltf_pose_of(&g->moments.items[0], g->links.items[link].node);
    curve c = {.g = g, .link = link, .part = part};
    for (; c.at < 4 && gltf_fine(g); ++c.at) fit_curve(&c, stride);
    c.weights = true;
    for (c.at = 0; pose && pose->weights && c.at < pose->weight_count && gltf_fine(g); ++c.at)
        fit_curve(&c, stride);
}

#define PART 0x1p-8

/* Vertices are interpolated linearly, and instances are placed. All poses are too few if every second one
 * errs by four times the part: where motion is smooth, each errs by a quarter of that. */
static void fit_all(gltf *g, size_t *stride, bool *uneven) {
    size_t second = 2;
    for (uint32_t i = 0; i < g->links.count; ++i) fit_node(g, i, PART, stride);
    for (uint32_t i = 0; i < g->links.count && *stride == 1; ++i) fit_node(g, i, 4 * PART, &second);
    *uneven = second == 1;
    for (uint32_t i = 0; i < g->links.count && gltf_fine(g); ++i) {
        for (size_t k = 0; k < 3; ++k)
            fit_curve(&(curve){.g = g, .link = i, .at = k, .placed = true, .part = PART}, stride);
    }
}

/* Keeps every `stride`-th pose. */
static void thin(gltf *g, size_t stride) {
    size_t kept = 0;
    for (size_t i = 0; i < g->moments.count; ++i) {
        if (i % stride == 0)
            g->moments.items[kept++] = g->moments.items[i];
        else
            close_moment(&g->moments.items[i], g);
    }
    g->moments.count = kept;
}

static void open_even(gltf *g, double time, double shutter, size_t intervals) {
    if (g->moments.count) g->charged[1] -= (g->moments.count - 1) * moment_bytes(g);
    gltf_moments_close(g);
    for (size_t i = 0; i <= intervals && gltf_fine(g); ++i)
        open_at(g, time + shutter * ((double)i / (double)intervals));
}

static void list_times(gltf *g) {
    void *times;
    g->status = scene_allocate_items(g->scene, g->moments.count, sizeof(double), &times);
    g->key_times = times;
    for (size_t i = 0; times && i < g->moments.count; ++i) g->key_times[i] = g->moments.items[i].time;
}

void gltf_moments_open(gltf *g) {
    const double time = g->scene->asked ? g->scene->asked->time : 0, shutter = gltf_shutter(g);
    if (!(shutter > 0)) {
        open_at(g, time);
        return;
    }
    size_t stride = 1;
    bool uneven = true;
    for (size_t intervals = INTERVALS_FIRST; stride == 1 && intervals <= INTERVALS_MOST; intervals *= 2) {
        open_even(g, time, shutter, intervals);
        if (!gltf_fine(g)) return;
        if (intervals < g->keys_inside && intervals < INTERVALS_MOST) continue;
        stride = intervals;
        fit_all(g, &stride, &uneven);
    }
    if (!gltf_fine(g)) return;
    if (uneven) {
        notes_add(&g->notes, 1, "",
                  "an animation moves things so unevenly while the shutter is open that %d poses only "
                  "approximate it; shorten the shutter",
                  INTERVALS_MOST + 1);
    }
    thin(g, stride);
    list_times(g);
}

/* ---- keys ---- */

bool gltf_shapes_move(const gltf_shape *shapes, size_t count) {
    for (size_t k = 1; k < count; ++k) {
        const gltf_shape *a = &shapes[0], *b = &shapes[k];
        if (a->weight_count && memcmp(a->weights, b->weights, a->weight_count * sizeof *a->weights) != 0)
            return true;
        if (a->joints &&
            memcmp(a->joints->matrices, b->joints->matrices, a->joints->count * sizeof(affine_f64)) != 0)
            return true;
    }
    return false;
}

void gltf_node_way(gltf *g, uint32_t link, gltf_way *out) {
    out->count = g->moments.count;
    for (size_t k = 0; k < out->count; ++k) out->at[k] = gltf_node_world(g, &g->moments.items[k], link);
}

void gltf_way_of(const gltf_way *way, const affine_f64 *inner, gltf_way *out) {
    out->count = way->count;
    for (size_t k = 0; k < way->count; ++k) out->at[k] = affine_compose(&way->at[k], inner);
}

bool gltf_way_moves(const gltf_way *way) {
    for (size_t k = 1; k < way->count; ++k) {
        if (memcmp(way->at[0].m, way->at[k].m, sizeof way->at[0].m) != 0) return true;
    }
    return false;
}

/* The number of poses is odd, or 2, between which all moves evenly. */
affine_f64 gltf_way_middle(const gltf_way *way) {
    affine_f64 out = way->at[way->count / 2];
    for (int i = 0; i < 12 && way->count == 2; ++i)
        out.m[i / 4][i % 4] = 0.5 * way->at[0].m[i / 4][i % 4] + 0.5 * way->at[1].m[i / 4][i % 4];
    return out;
}

bool gltf_way_mirrors(const gltf_way *way) { return affine_determinant(&way->at[0]) < 0; }

bool gltf_way_flattens(const gltf_way *way) {
    affine_f64 inverse;
    const affine_f64 *a = &way->at[0];
    const vec3_f64 x = load_f64(a->m[0]), y = load_f64(a->m[1]), z = load_f64(a->m[2]);
    const double length = length_f64(x) + length_f64(y) + length_f64(z),
                 area =
                     length_f64(cross_f64(x, y)) + length_f64(cross_f64(y, z)) + length_f64(cross_f64(z, x));
    return isfinite(length) && !affine_invert(a, &inverse) && area > 1e-12 * length * length;
}

/* From one pose to the next, an axis that passes through zero is reversed. Real turns are smaller than a
 * right angle: a chord errs by at most 2^-8 of the way, so an arc is below 15 degrees, or there are 64. */
bool gltf_way_can_blur(const gltf_way *way) {
    for (size_t k = 1; k < way->count; ++k) {
        if (!keeps_sides(&way->at[k - 1], &way->at[k])) return false;
    }
    return true;
}
