#include "report/place.h"

#include <math.h>
#include <string.h>

bool box_overlap(const box *a, const box *b) {
    return a->left < b->right && b->left < a->right && a->top < b->bottom && b->top < a->bottom;
}

/* Clips the line by each pair of sides in turn (Liang and Barsky, 1984). */
bool box_meets_line(const box *b, double x0, double y0, double x1, double y1) {
    double from = 0, to = 1;
    double start[2] = {x0, y0}, along[2] = {x1 - x0, y1 - y0};
    double low[2] = {b->left, b->top}, high[2] = {b->right, b->bottom};
    for (int k = 0; k < 2; ++k) {
        if (along[k] == 0) {
            if (start[k] <= low[k] || start[k] >= high[k]) return false;
            continue;
        }
        double s = (low[k] - start[k]) / along[k], t = (high[k] - start[k]) / along[k];
        from = fmax(from, fmin(s, t)), to = fmin(to, fmax(s, t));
    }
    return from < to;
}

void label_leader(const label *l, double *x, double *y) {
    *x = fmax(l->at.left, fmin(l->x, l->at.right));
    *y = fmax(l->at.top, fmin(l->y, l->at.bottom));
}

typedef struct room {
    const label *labels;
    size_t count;
    const box *taken;
    size_t taken_count;
    const box *frame;
    enum { LINES_FREE, LINES_OFF_LABELS, LINES_OFF_ALL } lines; /* what lines to labels keep off */
} room;

static bool line_meets(const label *from, const box *b) {
    double x, y;
    label_leader(from, &x, &y);
    return from->far && box_meets_line(b, from->x, from->y, x, y);
}

/* A line begins on a mark of its own, and on whatever else is there. */
static bool line_crosses(const label *from, const box *b) {
    bool begins = from->x >= b->left && from->x <= b->right && from->y >= b->top && from->y <= b->bottom;
    return !begins && line_meets(from, b);
}

/* Whether the label can go where it is: nothing lies under it, and no line under a label. */
static bool is_free(const room *r, const label *l) {
    const box *f = r->frame, *at = &l->at;
    if (at->left < f->left || at->right > f->right || at->top < f->top || at->bottom > f->bottom)
        return false;
    for (size_t i = 0; i < r->taken_count; ++i) {
        if (box_overlap(at, &r->taken[i])) return false;
        if (r->lines == LINES_OFF_ALL && line_crosses(l, &r->taken[i])) return false;
    }
    for (size_t i = 0; i < r->count; ++i) {
        const label *other = &r->labels[i];
        if (!other->placed) continue;
        if (box_overlap(at, &other->at)) return false;
        if (r->lines != LINES_FREE && (line_meets(other, at) || line_meets(l, &other->at))) return false;
    }
    return true;
}

static box box_around(double x, double y, double width, double height) {
    return (box){x - width / 2, y - height / 2, x + width / 2, y + height / 2};
}

/* On the ellipse-like path around the point where the label's near side is `gap` away from it. */
static box at_direction(const label *l, double gap, double angle) {
    double c = cos(angle), s = sin(angle);
    return box_around(l->x + c * (gap + l->width / 2), l->y + s * (gap + l->height / 2), l->width, l->height);
}

#define NEAR 8.0 /* pixels: past the point's own mark */
#define STEP 6.0
#define REACH 15 /* steps */
#define TURN 0.39269908169872414

/* Right first, as text is read, then left, above, below and between; then further out. Returns how far out,
 * or FAILED. */
#define FAILED 1000.0
static double place(label *l, const room *r) {
    static const double turns[16] = {0, 8, 12, 4, 14, 2, 10, 6, 15, 1, 9, 7, 13, 3, 11, 5};
    for (int step = 0; step < REACH; ++step) {
        for (int i = 0; i < 16; ++i) {
            l->at = at_direction(l, NEAR + STEP * step, turns[i] * TURN);
            l->far = step > 0;
            if (is_free(r, l)) return step;
        }
    }
    return FAILED;
}

/* The free place nearest to the point, wherever it is. */
static bool place_anywhere(label *l, const room *r) {
    double best = INFINITY;
    box found = l->at;
    l->far = true;
    for (double y = r->frame->top + l->height / 2; y + l->height / 2 <= r->frame->bottom; y += 3) {
        for (double x = r->frame->left + l->width / 2; x + l->width / 2 <= r->frame->right; x += 3) {
            double away = hypot(x - l->x, 2 * (y - l->y));
            l->at = box_around(x, y, l->width, l->height);
            if (away < best && is_free(r, l)) best = away, found = l->at;
        }
    }
    l->at = found;
    return isfinite(best);
}

/* What comes first takes the best places, and may leave none to others: which order is good is found by
 * trying. */
static double place_in_order(label *labels, const size_t *order, const room *r) {
    double cost = 0;
    for (size_t i = 0; i < r->count; ++i) labels[i].placed = false;
    for (size_t i = 0; i < r->count; ++i) {
        label *l = &labels[order[i]];
        double out = place(l, r);
        l->placed = out < FAILED;
        cost += out;
    }
    return cost;
}

/* Another order each time, and the same ones in each run. */
static void shuffle(size_t *order, size_t count, unsigned *state) {
    for (size_t i = count; i > 1; --i) {
        *state = *state * 1664525u + 1013904223u;
        size_t k = (*state >> 16) % i, was = order[i - 1];
        order[i - 1] = order[k], order[k] = was;
    }
}

#define ORDERS 40

void place_labels(label *labels, size_t count, const box *taken, size_t taken_count, const box *frame) {
    room r = {labels, count, taken, taken_count, frame, LINES_OFF_ALL};
    size_t order[PLACE_LABELS], best[PLACE_LABELS];
    double least = INFINITY;
    unsigned state = 1;
    if (count > PLACE_LABELS) r.count = count = PLACE_LABELS;
    for (size_t i = 0; i < count; ++i) order[i] = i;
    for (int k = 0; k < ORDERS && least > 0; ++k) {
        double cost = place_in_order(labels, order, &r);
        if (cost < least) least = cost, memcpy(best, order, sizeof best);
        shuffle(order, count, &state);
    }
    if (count) place_in_order(labels, best, &r);
    /* Where it is that crowded, a line over something is less bad than a point without a name. */
    for (r.lines = LINES_OFF_LABELS;; r.lines = LINES_FREE) {
        for (size_t i = 0; i < count; ++i)
            labels[i].placed = labels[i].placed || place_anywhere(&labels[i], &r);
        if (r.lines == LINES_FREE) break;
    }
}
