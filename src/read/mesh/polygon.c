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

/* The corner of a fan: 0, 1, then the last of each triangle. */
static size_t fan_place(size_t corner) { return corner < 2 ? corner : 3 * (corner - 2) + 2; }

/* Of the two diagonals the one that both triangles keep their winding with; when both do, the one opposite to
 * the smaller angles (Delaunay's choice, which makes the smallest angle largest): 0-2 while the angles at 1
 * and 3 sum to at most pi, sin(B + D) >= 0. Rectangles and the cells of grids and spheres are ties, decided
 * by rounding alone unless 0-2 is kept up to a slack: 2^-8, a quarter of a degree, changes no angle by more
 * than that, and is above the rounding of corners whose edges keep 8 bits of the coordinates' 24. */
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

/* A corner of the polygon that is left: how the outline turns there. Convex corners stay convex when ears are
 * cut, as angles only shrink. */
typedef enum turn { TURN_CONVEX, TURN_FLAT, TURN_REFLEX, TURN_GONE } turn;

/* The polygon in the plane, counterclockwise, as a ring; and a grid over the corners that are not convex:
 * only they can lie in an ear. */
typedef struct ring {
    uint32_t n, cells; /* the grid has cells × cells */
    double (*point)[2];
    uint32_t *next, *last;
    uint32_t *cell_first, *cell_items;
    uint32_t *triangles; /* corner numbers, 3 each */
    uint32_t *moved;     /* n, for carrying streams along */
    uint32_t *queue;     /* corners that may be ears: a circle of n */
    uint32_t *queued;    /* whether a corner is in it */
    uint32_t queue_begin, queue_count;
    turn *turns;
    double low[2], scale[2];
    uint32_t triangle_count;
} ring;

static double orientation(const double a[2], const double b[2], const double c[2]) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static turn turn_at(const ring *r, uint32_t i) {
    double area = orientation(r->point[r->last[i]], r->point[i], r->point[r->next[i]]);
    return area > 0 ? TURN_CONVEX : area < 0 ? TURN_REFLEX : TURN_FLAT;
}

static bool ring_allocate(polygon_work *work, uint32_t n, ring *r) {
    /* About two corners to a cell. */
    uint32_t cells = (uint32_t)sqrt(n / 2.0);
    r->n = n;
    r->cells = cells < 1 ? 1 : cells > 1024 ? 1024 : cells;
    size_t words[] = {4 * (size_t)n,
                      n,
                      n,
                      (size_t)r->cells * r->cells + 1,
                      n,
                      3 * (size_t)n,
                      n,
                      n,
                      n,
                      (size_t)n * sizeof *r->turns / sizeof(uint32_t)};
    size_t bytes = 0;
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i) bytes += words[i] * sizeof(uint32_t);
    if (bytes > work->size) {
        void *memory = realloc(work->memory, bytes);
        if (!memory) return false;
        work->memory = memory;
        work->size = bytes;
    }
    r->point = work->memory;
    uint32_t *at = (uint32_t *)work->memory + words[0];
    uint32_t **parts[] = {&r->next,      &r->last,  &r->cell_first, &r->cell_items,
                          &r->triangles, &r->moved, &r->queue,      &r->queued};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i) {
        *parts[i] = at;
        at += words[i + 1];
    }
    r->turns = (turn *)(void *)at;
    return true;
}

/* Newell's normal, which sums the areas seen along each axis: the polygon is looked at along the axis of the
 * largest, which loses no bit of the coordinates. */
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

/* All corners turn left, and the outline goes round once: then x turns back just twice. */
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

/* In cells, from 0 to r->cells. */
static double in_cells(const ring *r, double x, int axis) { return (x - r->low[axis]) * r->scale[axis]; }

static uint32_t cell_number(const ring *r, double cell) {
    return cell <= 0 ? 0 : cell >= r->cells - 1 ? r->cells - 1 : (uint32_t)cell;
}

static uint32_t *cell_at(const ring *r, uint32_t i) {
    uint32_t x = cell_number(r, in_cells(r, r->point[i][0], 0));
    uint32_t y = cell_number(r, in_cells(r, r->point[i][1], 1));
    return r->cell_first + y * r->cells + x;
}

/* Counting sort of the corners that are not convex into cells. */
static void fill_grid(ring *r) {
    double high[2];
    memcpy(r->low, r->point[0], sizeof r->low);
    memcpy(high, r->point[0], sizeof high);
    for (uint32_t i = 1; i < r->n; ++i) {
        for (int k = 0; k < 2; ++k) {
            r->low[k] = fmin(r->low[k], r->point[i][k]);
            high[k] = fmax(high[k], r->point[i][k]);
        }
    }
    for (int k = 0; k < 2; ++k) r->scale[k] = high[k] > r->low[k] ? r->cells / (high[k] - r->low[k]) : 0;
    size_t count = (size_t)r->cells * r->cells;
    memset(r->cell_first, 0, (count + 1) * sizeof *r->cell_first);
    for (uint32_t i = 0; i < r->n; ++i) {
        if (r->turns[i] != TURN_CONVEX) ++*cell_at(r, i);
    }
    for (size_t c = 1; c <= count; ++c) r->cell_first[c] += r->cell_first[c - 1];
    for (uint32_t i = 0; i < r->n; ++i) {
        if (r->turns[i] != TURN_CONVEX) r->cell_items[--*cell_at(r, i)] = i;
    }
}

static bool same_point(const double a[2], const double b[2]) { return a[0] == b[0] && a[1] == b[1]; }

/* Whether corner k is in the way of the ear a, b, c. Corners at the same place as one of its own are not: an
 * outline may touch itself where a hole is joined to it. */
static bool blocks(const ring *r, uint32_t k, const double *a, const double *b, const double *c) {
    if (r->turns[k] != TURN_FLAT && r->turns[k] != TURN_REFLEX) return false;
    const double *p = r->point[k];
    return orientation(a, b, p) >= 0 && orientation(b, c, p) >= 0 && orientation(c, a, p) >= 0 &&
           !same_point(p, a) && !same_point(p, b) && !same_point(p, c);
}

static double clamp(double x, double low, double high) { return x < low ? low : x > high ? high : x; }

/* The part of a row of cells, from y to y + 1, that the triangle t covers: from x[0] to x[1]. The row is
 * taken a little higher: places in the grid, numbers up to 2^10, are rounded by less than 2^-40. */
static void row_range(double t[3][2], double y, double x[2]) {
    const double low = y - 0x1p-20, high = y + 1 + 0x1p-20;
    x[0] = (double)INFINITY, x[1] = -(double)INFINITY;
    for (int k = 0; k < 3; ++k) {
        const double *a = t[k], *b = t[(k + 1) % 3];
        if (a[1] > b[1]) {
            const double *swap = a;
            a = b;
            b = swap;
        }
        if (b[1] < low || a[1] > high) continue;
        for (int end = 0; end < 2; ++end) {
            double rise = b[1] - a[1],
                   part = rise > 0 ? (clamp(end ? high : low, a[1], b[1]) - a[1]) / rise : end;
            double at = a[0] + part * (b[0] - a[0]);
            x[0] = at < x[0] ? at : x[0];
            x[1] = at > x[1] ? at : x[1];
        }
    }
}

/* Only the cells that the triangle touches are looked at, not those of its box: ears can be long and thin. */
static bool is_ear(const ring *r, uint32_t i) {
    if (r->turns[i] != TURN_CONVEX) return false;
    const double *a = r->point[r->last[i]], *b = r->point[i], *c = r->point[r->next[i]];
    double t[3][2];
    for (int k = 0; k < 2; ++k) {
        t[0][k] = in_cells(r, a[k], k);
        t[1][k] = in_cells(r, b[k], k);
        t[2][k] = in_cells(r, c[k], k);
    }
    uint32_t top = cell_number(r, fmax(t[0][1], fmax(t[1][1], t[2][1])) + 0x1p-20);
    for (uint32_t y = cell_number(r, fmin(t[0][1], fmin(t[1][1], t[2][1])) - 0x1p-20); y <= top; ++y) {
        double x[2];
        row_range(t, y, x);
        /* Cells of a row lie one after the other. */
        const uint32_t *row = r->cell_first + y * r->cells;
        uint32_t end = row[cell_number(r, x[1] + 0x1p-20) + 1];
        for (uint32_t item = row[cell_number(r, x[0] - 0x1p-20)]; item < end; ++item) {
            if (blocks(r, r->cell_items[item], a, b, c)) return false;
        }
    }
    return true;
}

static void cut(ring *r, uint32_t i) {
    uint32_t last = r->last[i], next = r->next[i];
    uint32_t *t = r->triangles + 3 * (size_t)r->triangle_count++;
    t[0] = last, t[1] = i, t[2] = next;
    r->turns[i] = TURN_GONE;
    r->next[last] = next;
    r->last[next] = last;
    r->turns[last] = turn_at(r, last);
    r->turns[next] = turn_at(r, next);
}

/* No corner is an ear: the outline crosses itself, or what is left has no area. Flat corners go first, they
 * cover nothing; then convex ones. */
static uint32_t least_bad(const ring *r, uint32_t i) {
    uint32_t best = i;
    for (uint32_t k = r->next[i]; k != i; k = r->next[k]) {
        if (r->turns[k] == TURN_FLAT) return k;
        if (r->turns[k] == TURN_CONVEX && r->turns[best] == TURN_REFLEX) best = k;
    }
    return best;
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

/* Cutting an ear makes at most its two neighbours into ears: a corner in the way of another ear is reflex,
 * and is neither cut nor turned convex while it is in there (Eberly, "Triangulation by ear clipping"). So
 * each cut looks at two corners again, not at all. The one after an ear waits: cutting on and on would make a
 * fan of slivers. */
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

bool polygon_split(polygon_work *work, const polygon_vertices *vertices, uint32_t corners, uint32_t *fan,
                   uint32_t *second, uint32_t *third) {
    if (corners <= 3) return true;
    if (corners == 4) {
        split_quad(vertices, fan, second, third);
        return true;
    }
    ring r = {0};
    if (!ring_allocate(work, corners, &r)) return false;
    project(vertices, fan, &r);
    for (uint32_t i = 0; i < r.n; ++i) r.turns[i] = turn_at(&r, i);
    if (is_convex(&r)) return true;
    fill_grid(&r);
    cut_ears(&r);
    move_stream(&r, fan);
    move_stream(&r, second);
    move_stream(&r, third);
    return true;
}
