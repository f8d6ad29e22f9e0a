#include "read/mesh/polygon.h"

#include "math/vec.h"

#include <stdlib.h>
#include <string.h>

void polygon_work_free(polygon_work *work) {
    free(work->memory);
    *work = (polygon_work){0};
}

static vec3_f64 vertex(const polygon_vertices *v, uint32_t i) {
    const float *p = (const float *)(const void *)((const char *)v->positions + i * v->stride);
    return (vec3_f64){(double)p[0], (double)p[1], (double)p[2]};
}

/* The position of a corner in a fan's indices: 0, 1, then the last index of each triangle. */
static size_t fan_place(size_t corner) { return corner < 2 ? corner : 3 * (corner - 2) + 2; }

/* True if the quad should be split along 1-3 instead of 0-2. The better diagonal keeps the winding of both
 * triangles. If both diagonals do, it is the one opposite to the smaller angles (Delaunay): 0-2 while the
 * angles at 1 and 3 sum to at most pi, sin(B + D) >= 0. Rectangles, and cells of grids and spheres, are ties
 * that rounding error would decide. So 0-2 is kept up to a slack of 2^-8, a quarter of a degree. This is more
 * than the rounding error of corners whose edges keep 8 of the coordinates' 24 bits. */
static bool other_diagonal(const vec3_f64 p[4]) {
    vec3_f64 edge[4];
    for (int i = 0; i < 4; ++i) edge[i] = normalize_f64(sub_f64(p[(i + 1) % 4], p[i]));
    vec3_f64 normal = cross_f64(sub_f64(p[2], p[0]), sub_f64(p[3], p[1]));
    bool convex[4];
    double sine[4], cosine[4];
    for (int i = 0; i < 4; ++i) {
        vec3_f64 turn = cross_f64(edge[(i + 3) % 4], edge[i]);
        convex[i] = dot_f64(turn, normal) > 0;
        sine[i] = length_f64(turn);
        cosine[i] = -dot_f64(edge[(i + 3) % 4], edge[i]);
    }
    bool keeps = convex[1] && convex[3], other_keeps = convex[0] && convex[2];
    if (keeps != other_keeps) return other_keeps;
    return keeps && sine[1] * cosine[3] + cosine[1] * sine[3] < -0x1p-8;
}

static void turn_quad(uint32_t *fan) {
    if (!fan) return;
    uint32_t c[4] = {fan[0], fan[1], fan[2], fan[5]};
    memcpy(fan, (uint32_t[6]){c[0], c[1], c[3], c[1], c[2], c[3]}, 6 * sizeof *fan);
}

static void split_quad(const polygon_vertices *v, uint32_t *fan, uint32_t *second, uint32_t *third) {
    vec3_f64 p[4] = {vertex(v, fan[0]), vertex(v, fan[1]), vertex(v, fan[2]), vertex(v, fan[5])};
    if (!other_diagonal(p)) return;
    turn_quad(fan);
    turn_quad(second);
    turn_quad(third);
}

/* The kind of a corner of the remaining outline. Convex corners stay convex when ears are clipped, because
 * angles only shrink. */
typedef enum turn { TURN_CONVEX, TURN_FLAT, TURN_REFLEX, TURN_GONE } turn;

enum { TURNS = TURN_GONE + 1 };

#define LEAF_CORNERS 16 /* maximum per leaf, so that the tree takes less memory than the ring */

/* A k-d tree of the corners that are not convex: only these can lie in an ear. Node 1 is the root, node k has
 * the children 2k and 2k + 1, and nodes from `leaves` on are leaves. */
typedef struct tree {
    uint32_t leaves;  /* a power of two; 0: the tree is empty */
    uint32_t *order;  /* the corners, leaf after leaf */
    uint32_t *first;  /* start of each leaf in order[], then the end */
    uint32_t *live;   /* of each node: number of its remaining corners that are not convex */
    double (*box)[4]; /* of each node: lowest x, y, highest x, y */
} tree;

/* The polygon in the plane, counterclockwise, as a ring. */
typedef struct ring {
    uint32_t n;
    double (*point)[2];
    uint32_t *next, *last;
    uint32_t *leaf;      /* the tree's leaf that holds a corner; 0: none */
    uint32_t *triangles; /* corner numbers, 3 each */
    uint32_t *moved;     /* n numbers, to reorder streams */
    uint32_t *queue;     /* ring buffer of n corners that may be ears */
    uint32_t *queued;    /* whether a corner is in the queue */
    uint32_t queue_begin, queue_count;
    turn *turns;
    uint32_t count[TURNS]; /* number of corners of each kind */
    uint32_t triangle_count;
    tree tree;
} ring;

static double orientation(const double a[2], const double b[2], const double c[2]) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static turn turn_at(const ring *r, uint32_t i) {
    double area = orientation(r->point[r->last[i]], r->point[i], r->point[r->next[i]]);
    return area > 0 ? TURN_CONVEX : area < 0 ? TURN_REFLEX : TURN_FLAT;
}

static uint32_t leaves_for(uint32_t corners) {
    uint32_t leaves = 1;
    while ((uint64_t)leaves * LEAF_CORNERS < corners) leaves *= 2;
    return leaves;
}

static bool ring_allocate(polygon_work *work, uint32_t n, ring *r) {
    const size_t leaves = leaves_for(n), point = 2 * sizeof(double) / sizeof(uint32_t);
    const size_t words[] = {point * n,
                            2 * point * 2 * leaves,
                            n,
                            n,
                            n,
                            3 * (size_t)n,
                            n,
                            n,
                            n,
                            n,
                            leaves + 1,
                            2 * leaves,
                            (size_t)n * sizeof *r->turns / sizeof(uint32_t)};
    size_t bytes = 0;
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i) bytes += words[i] * sizeof(uint32_t);
    if (bytes > work->size) {
        void *memory = realloc(work->memory, bytes);
        if (!memory) return false;
        work->memory = memory;
        work->size = bytes;
    }
    r->n = n;
    r->point = work->memory;
    r->tree.box = (double(*)[4])(void *)((uint32_t *)work->memory + words[0]);
    uint32_t *at = (uint32_t *)work->memory + words[0] + words[1];
    uint32_t **parts[] = {&r->next,  &r->last,   &r->leaf,       &r->triangles,  &r->moved,
                          &r->queue, &r->queued, &r->tree.order, &r->tree.first, &r->tree.live};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i) {
        *parts[i] = at;
        at += words[i + 2];
    }
    r->turns = (turn *)(void *)at;
    return true;
}

/* Projects along the largest axis of Newell's normal, so that the coordinates keep all their bits. */
static void project(const polygon_vertices *v, const uint32_t *fan, ring *r) {
    vec3_f64 first = vertex(v, fan[0]), normal = {0, 0, 0};
    for (size_t i = 1; i + 1 < r->n; ++i) {
        vec3_f64 a = sub_f64(vertex(v, fan[fan_place(i)]), first);
        vec3_f64 b = sub_f64(vertex(v, fan[fan_place(i + 1)]), first);
        normal = add_f64(normal, cross_f64(a, b));
    }
    double n[3] = {normal.x, normal.y, normal.z};
    int axis = fabs(n[0]) >= fabs(n[1]) ? 0 : 1;
    if (fabs(n[2]) > fabs(n[axis])) axis = 2;
    int x = (axis + 1) % 3, y = (axis + 2) % 3;
    if (n[axis] < 0) {
        int swap = x;
        x = y;
        y = swap;
    }
    for (uint32_t i = 0; i < r->n; ++i) {
        vec3_f64 p = vertex(v, fan[fan_place(i)]);
        double c[3] = {p.x, p.y, p.z};
        r->point[i][0] = c[x];
        r->point[i][1] = c[y];
        r->next[i] = i + 1 < r->n ? i + 1 : 0;
        r->last[i] = i > 0 ? i - 1 : r->n - 1;
    }
}

/* True if all corners turn left and the outline has one revolution: then x changes direction exactly
 * twice. */
static bool is_convex(const ring *r) {
    unsigned reversals = 0;
    bool right = r->point[0][0] > r->point[r->n - 1][0];
    for (uint32_t i = 0; i < r->n; ++i) {
        if (r->turns[i] != TURN_CONVEX) return false;
        double step = r->point[r->next[i]][0] - r->point[i][0];
        if (step == 0) continue;
        reversals += (step > 0) != right;
        right = step > 0;
    }
    return reversals <= 2;
}

/* ---- the tree ---- */

/* Partially sorts order[begin…end) by the axis, so that element `nth` is the same as after a full sort
 * (Hoare's selection). */
static void select_nth(const ring *r, int axis, uint32_t begin, uint32_t end, uint32_t nth) {
    uint32_t *order = r->tree.order;
    while (end - begin > 1) {
        const double pivot = r->point[order[begin + (end - begin) / 2]][axis];
        int64_t low = begin, high = (int64_t)end - 1;
        while (low <= high) {
            while (r->point[order[low]][axis] < pivot) ++low;
            while (r->point[order[high]][axis] > pivot) --high;
            if (low > high) break;
            uint32_t swap = order[low];
            order[low++] = order[high];
            order[high--] = swap;
        }
        if ((int64_t)nth <= high)
            end = (uint32_t)(high + 1);
        else if ((int64_t)nth >= low)
            begin = (uint32_t)low;
        else
            return;
    }
}

static void fit_box(const ring *r, uint32_t begin, uint32_t end, double box[4]) {
    box[0] = box[1] = (double)INFINITY;
    box[2] = box[3] = -(double)INFINITY;
    for (uint32_t i = begin; i < end; ++i) {
        const double *p = r->point[r->tree.order[i]];
        for (int k = 0; k < 2; ++k) {
            box[k] = p[k] < box[k] ? p[k] : box[k];
            box[k + 2] = p[k] > box[k + 2] ? p[k] : box[k + 2];
        }
    }
}

static void build(ring *r, uint32_t node, uint32_t begin, uint32_t end) {
    tree *t = &r->tree;
    t->live[node] = end - begin;
    fit_box(r, begin, end, t->box[node]);
    if (node >= t->leaves) {
        t->first[node - t->leaves] = begin;
        for (uint32_t i = begin; i < end; ++i) r->leaf[t->order[i]] = node;
        return;
    }
    const double *box = t->box[node];
    const uint32_t middle = begin + (end - begin) / 2;
    select_nth(r, box[3] - box[1] > box[2] - box[0], begin, end, middle);
    build(r, 2 * node, begin, middle);
    build(r, 2 * node + 1, middle, end);
}

static void make_tree(ring *r) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < r->n; ++i) {
        r->leaf[i] = 0;
        if (r->turns[i] != TURN_CONVEX) r->tree.order[count++] = i;
    }
    if (!count) return;
    r->tree.leaves = leaves_for(count);
    r->tree.first[r->tree.leaves] = count;
    build(r, 1, 0, count);
}

static bool may_block(turn t) { return t == TURN_FLAT || t == TURN_REFLEX; }

static void set_turn(ring *r, uint32_t i, turn to) {
    const turn from = r->turns[i];
    --r->count[from];
    ++r->count[to];
    r->turns[i] = to;
    if (may_block(from) == may_block(to)) return;
    for (uint32_t node = r->leaf[i]; node; node /= 2) r->tree.live[node] += may_block(to) ? 1 : UINT32_MAX;
}

static bool same_point(const double a[2], const double b[2]) { return a[0] == b[0] && a[1] == b[1]; }

/* True when corner k lies in the ear a, b, c. Corners at the same position as a corner of the ear are
 * ignored: an outline may touch itself where it is connected to a hole. */
static bool blocks(const ring *r, uint32_t k, const double *a, const double *b, const double *c) {
    if (!may_block(r->turns[k])) return false;
    const double *p = r->point[k];
    return orientation(a, b, p) >= 0 && orientation(b, c, p) >= 0 && orientation(c, a, p) >= 0 &&
           !same_point(p, a) && !same_point(p, b) && !same_point(p, c);
}

/* True when all points of the box are to the right of the line from a to b, by orientation(). It is monotonic
 * in each coordinate even after rounding, so checking one corner of the box is enough. */
static bool right_of(const double *a, const double *b, const double box[4]) {
    const double extreme[2] = {b[1] - a[1] < 0 ? box[2] : box[0], b[0] - a[0] < 0 ? box[1] : box[3]};
    return orientation(a, b, extreme) < 0;
}

/* True when a corner of the node lies in the ear. A box of one point at a corner of the ear, where the
 * outline touches itself, is skipped. */
static bool is_blocked(const ring *r, uint32_t node, const double *a, const double *b, const double *c) {
    const tree *t = &r->tree;
    const double *box = t->box[node];
    if (!t->live[node] || right_of(a, b, box) || right_of(b, c, box) || right_of(c, a, box)) return false;
    if (same_point(box, box + 2) && (same_point(box, a) || same_point(box, b) || same_point(box, c)))
        return false;
    if (node < t->leaves) return is_blocked(r, 2 * node, a, b, c) || is_blocked(r, 2 * node + 1, a, b, c);
    for (uint32_t i = t->first[node - t->leaves]; i < t->first[node - t->leaves + 1]; ++i) {
        if (blocks(r, t->order[i], a, b, c)) return true;
    }
    return false;
}

static bool is_ear(const ring *r, uint32_t i) {
    if (r->turns[i] != TURN_CONVEX) return false;
    return !r->tree.leaves || !is_blocked(r, 1, r->point[r->last[i]], r->point[i], r->point[r->next[i]]);
}

static void cut(ring *r, uint32_t i) {
    uint32_t last = r->last[i], next = r->next[i];
    uint32_t *t = r->triangles + 3 * (size_t)r->triangle_count++;
    t[0] = last, t[1] = i, t[2] = next;
    set_turn(r, i, TURN_GONE);
    r->next[last] = next;
    r->last[next] = last;
    set_turn(r, last, turn_at(r, last));
    set_turn(r, next, turn_at(r, next));
}

/* Chooses a corner to cut if no corner is an ear: the outline crosses itself, or the remaining polygon has no
 * area. Takes flat corners first, because they have no area, then convex ones. */
static uint32_t least_bad(const ring *r, uint32_t i) {
    const turn own = r->turns[i];
    const turn wanted = r->count[TURN_FLAT] > (own == TURN_FLAT) ? TURN_FLAT : TURN_CONVEX;
    if (wanted == TURN_CONVEX && (own != TURN_REFLEX || !r->count[TURN_CONVEX])) return i;
    uint32_t k = r->next[i];
    while (r->turns[k] != wanted) k = r->next[k];
    return k;
}

static void enqueue(ring *r, uint32_t i) {
    if (r->queued[i]) return;
    uint32_t place = r->queue_begin + r->queue_count++;
    r->queue[place < r->n ? place : place - r->n] = i;
    r->queued[i] = 1;
}

static uint32_t dequeue(ring *r) {
    uint32_t i = r->queue[r->queue_begin];
    r->queue_begin = r->queue_begin + 1 < r->n ? r->queue_begin + 1 : 0;
    --r->queue_count;
    r->queued[i] = 0;
    return i;
}

/* Cutting an ear can only turn its two neighbours into ears. A corner inside another ear is reflex, and as
 * long as it is inside, it is neither cut nor becomes convex (Eberly, "Triangulation by ear clipping"). So
 * only two corners are tested again after each cut. The next corner is not cut directly after an ear, because
 * this would make a fan of slivers. */
static void cut_ears(ring *r) {
    for (uint32_t i = 0; i < r->n; ++i) {
        r->queued[i] = 0;
        enqueue(r, i);
    }
    uint32_t waits = r->n;
    for (uint32_t left = r->n, i = 0; left > 2;) {
        bool stuck = !r->queue_count;
        i = stuck ? least_bad(r, i) : dequeue(r);
        if (i == waits && !stuck) {
            waits = r->n;
            enqueue(r, i);
            continue;
        }
        if (!stuck && !is_ear(r, i)) continue;
        cut(r, i);
        waits = r->next[i];
        enqueue(r, r->next[i]);
        enqueue(r, r->last[i]);
        i = r->next[i];
        --left;
    }
}

static void move_stream(const ring *r, uint32_t *fan) {
    if (!fan) return;
    for (uint32_t i = 0; i < r->n; ++i) r->moved[i] = fan[fan_place(i)];
    for (size_t i = 0; i < 3 * (size_t)r->triangle_count; ++i) fan[i] = r->moved[r->triangles[i]];
}

/* True for a polygon with a lost vertex (lost.h), which becomes all its corners. */
static bool is_lost(const polygon_vertices *v, uint32_t corners, uint32_t *fan) {
    for (uint32_t i = 0; i < corners; ++i) {
        const uint32_t lost = fan[fan_place(i)];
        if (!isnan(vertex(v, lost).x)) continue;
        for (size_t k = 0; k < 3 * ((size_t)corners - 2); ++k) fan[k] = lost;
        return true;
    }
    return false;
}

bool polygon_split(polygon_work *work, const polygon_vertices *vertices, uint32_t corners, uint32_t *fan,
                   uint32_t *second, uint32_t *third) {
    if (corners <= 3 || is_lost(vertices, corners, fan)) return true;
    if (corners == 4) {
        split_quad(vertices, fan, second, third);
        return true;
    }
    ring r = {0};
    if (!ring_allocate(work, corners, &r)) return false;
    project(vertices, fan, &r);
    for (uint32_t i = 0; i < r.n; ++i) ++r.count[r.turns[i] = turn_at(&r, i)];
    if (is_convex(&r)) return true;
    make_tree(&r);
    cut_ears(&r);
    move_stream(&r, fan);
    move_stream(&r, second);
    move_stream(&r, third);
    return true;
}
