#include "light/tree_view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS = 16, MOST_PARTS = 256, MOST_NEAR = TREE_LISTED * TREE_WIDE };
/* Nodes less unsure than this fraction of all light are not replaced by their children. */
#define LITTLE 0.005
/* Parts less unsure than this fraction of all light may be far. */
#define NOTABLE 0.01
/* The mean square of samples, divided by the least possible: a list has enough near parts below the first
 * value, and is used below the second. */
#define ENOUGH 1.03
#define USABLE 1.1

typedef struct part {
    uint32_t slot;
    float factor;
    double weight[POINTS];
    double unsure; /* as tree_kernels.weigh() says, for the region as a whole */
    double steady; /* weight as a far part: above 0 for all that can reach a point of the region */
    double share;  /* mean fraction of all light; 1 more if the part must be near */
} part;

typedef struct lister {
    const tree *t;
    const tree_view *view;
    uint32_t count, part_count; /* of points and parts */
    vec3_f32 p[POINTS], n[POINTS], center;
    float half[3];      /* of the box; positions and lengths are multiplied by the tree's scale */
    double sum[POINTS]; /* of the weights of all parts */
    part parts[MOST_PARTS];
} lister;

static uint32_t child_of(const tree *t, uint32_t slot) {
    return t->nodes[slot / TREE_WIDE].child[slot % TREE_WIDE];
}

static double mean(const lister *l, const double of[POINTS]) {
    double sum = 0;
    for (uint32_t k = 0; k < l->count; ++k) sum += of[k];
    return sum / l->count;
}

/* ---- parts ---- */

static void weigh_points(lister *l, const tree_node *node, part *const parts[TREE_WIDE]) {
    for (uint32_t k = 0; k < l->count; ++k) {
        float weight[TREE_WIDE], unsure[TREE_WIDE];
        l->t->kernels->weigh(node, l->p[k], l->n[k], weight, unsure);
        for (int i = 0; i < TREE_WIDE; ++i) {
            if (!parts[i]) continue;
            parts[i]->weight[k] = (double)(parts[i]->factor * weight[i]);
            l->sum[k] += parts[i]->weight[k];
        }
    }
}

/* As seen from a part, the box of the points increases its own. The surfaces of the region may also have
 * other normals than the points: so a far part has at least a 64th of its weight without a normal. */
static void weigh_region(const lister *l, const tree_node *node, part *const parts[TREE_WIDE]) {
    const vec3_f32 any = {0, 0, 0};
    float weight[TREE_WIDE], unsure[TREE_WIDE];
    tree_node wide = *node;
    for (int i = 0; i < TREE_WIDE; ++i) {
        wide.half_x[i] += l->half[0], wide.half_y[i] += l->half[1], wide.half_z[i] += l->half[2];
        wide.child[i] = 0;
    }
    l->t->kernels->weigh(&wide, l->center, any, weight, unsure);
    for (int i = 0; i < TREE_WIDE; ++i) {
        double squares[POINTS];
        for (uint32_t k = 0; parts[i] && k < l->count; ++k)
            squares[k] = parts[i]->weight[k] * parts[i]->weight[k];
        if (parts[i]) parts[i]->steady = sqrt(mean(l, squares)) + (double)(parts[i]->factor * weight[i]) / 64;
    }
    for (uint32_t k = 0; k < l->count; ++k) {
        l->t->kernels->weigh(&wide, l->center, l->n[k], weight, unsure);
        for (int i = 0; i < TREE_WIDE; ++i)
            if (parts[i]) parts[i]->unsure += (double)(parts[i]->factor * unsure[i]) / l->count;
    }
}

static void add_children(lister *l, uint32_t index, float inherited) {
    const tree_node *node = &l->t->nodes[index];
    const uint32_t row = l->view->factors ? l->t->row_of[index] : FATHOM_NONE;
    part *parts[TREE_WIDE] = {NULL};
    for (uint32_t i = 0; i < TREE_WIDE; ++i) {
        if (!(node->power[i] > 0)) continue;
        parts[i] = &l->parts[l->part_count++];
        *parts[i] = (part){.slot = index * TREE_WIDE + i, .factor = inherited};
        if (row != FATHOM_NONE) parts[i]->factor = l->view->factors[row * TREE_WIDE + i];
    }
    weigh_points(l, node, parts);
    weigh_region(l, node, parts);
}

/* Replaces the node that is most unsure by its children. False: none is unsure enough. */
static bool open_part(lister *l) {
    double most = LITTLE * mean(l, l->sum);
    uint32_t found = FATHOM_NONE;
    for (uint32_t i = 0; i < l->part_count; ++i)
        if (!(child_of(l->t, l->parts[i].slot) & TREE_LEAF) && l->parts[i].unsure > most)
            most = l->parts[i].unsure, found = i;
    if (found == FATHOM_NONE) return false;
    const part opened = l->parts[found];
    l->parts[found] = l->parts[--l->part_count];
    for (uint32_t k = 0; k < l->count; ++k) l->sum[k] -= opened.weight[k];
    add_children(l, child_of(l->t, opened.slot), opened.factor);
    return true;
}

/* ---- near and far ---- */

static int compare_parts(const void *a, const void *b) {
    const part *x = a, *y = b;
    if (x->share != y->share) return x->share > y->share ? -1 : 1;
    return (x->slot > y->slot) - (x->slot < y->slot);
}

/* Returns the number of parts that must be near; they come first. */
static uint32_t sort_parts(lister *l) {
    const double notable = NOTABLE * mean(l, l->sum);
    uint32_t must = 0;
    for (uint32_t i = 0; i < l->part_count; ++i) {
        part *p = &l->parts[i];
        double share[POINTS];
        for (uint32_t k = 0; k < l->count; ++k) share[k] = l->sum[k] > 0 ? p->weight[k] / l->sum[k] : 0;
        must += p->unsure > notable;
        p->share = mean(l, share) + (p->unsure > notable ? 1 : 0);
    }
    qsort(l->parts, l->part_count, sizeof *l->parts, compare_parts);
    return must;
}

/* The mean square of samples if the first parts are near, divided by that of samples in proportion to the
 * weights. At a point whose near parts weigh N, and all W, a far part of the weight w and the constant weight
 * c has the probability c / (N + sum of c): the quotient is (N + sum of c) (N + sum of w² / c) / W². Points
 * count in proportion to W. */
static double mean_square(const lister *l, uint32_t near) {
    double of[POINTS], steady = 0;
    for (uint32_t i = near; i < l->part_count; ++i) steady += l->parts[i].steady;
    for (uint32_t k = 0; k < l->count; ++k) {
        double sum = 0, squares = 0;
        for (uint32_t i = 0; i < near; ++i) sum += l->parts[i].weight[k];
        for (uint32_t i = near; i < l->part_count; ++i)
            if (l->parts[i].weight[k] > 0)
                squares += l->parts[i].weight[k] * l->parts[i].weight[k] / l->parts[i].steady;
        of[k] = l->sum[k] > 0 ? (sum + steady) * (sum + squares) / l->sum[k] : 0;
    }
    return mean(l, of) / mean(l, l->sum);
}

/* The number of near parts; 0: no list is usable. */
static uint32_t near_parts(const lister *l, uint32_t must) {
    uint32_t near = TREE_WIDE;
    while (near < MOST_NEAR && (near < must || mean_square(l, near) > ENOUGH)) near += TREE_WIDE;
    near = near < l->part_count ? near : l->part_count;
    return near >= must && mean_square(l, near) < USABLE ? near : 0;
}

/* ---- the list ---- */

static void copy_part(const tree *t, const part *p, tree_node *to, uint32_t i) {
    const tree_node *from = &t->nodes[p->slot / TREE_WIDE];
    const uint32_t k = p->slot % TREE_WIDE;
    to->x[i] = from->x[k], to->y[i] = from->y[k], to->z[i] = from->z[k];
    to->half_x[i] = from->half_x[k], to->half_y[i] = from->half_y[k], to->half_z[i] = from->half_z[k];
    to->axis_x[i] = from->axis_x[k], to->axis_y[i] = from->axis_y[k], to->axis_z[i] = from->axis_z[k];
    to->spread[i] = from->spread[k], to->child[i] = from->child[k];
    to->power[i] = from->power[k] * p->factor;
}

static bool store(const lister *l, uint32_t near, tree_view *v) {
    const uint32_t nodes = (near + TREE_WIDE - 1) / TREE_WIDE, far = l->part_count - near;
    double sum = 0;
    v->near = calloc(nodes, sizeof *v->near), v->slot = malloc((nodes * TREE_WIDE + far) * sizeof *v->slot);
    v->far = malloc((far + 1) * sizeof *v->far), v->child = malloc((far + 1) * sizeof *v->child);
    if (!v->near || !v->slot || !v->far || !v->child) return false;
    for (uint32_t i = 0; i < nodes * TREE_WIDE; ++i) {
        v->slot[i] = i < near ? l->parts[i].slot : FATHOM_NONE;
        if (i < near) copy_part(l->t, &l->parts[i], &v->near[i / TREE_WIDE], i % TREE_WIDE);
    }
    for (uint32_t i = 0; i < far; ++i) {
        const part *p = &l->parts[near + i];
        v->far[i] = sum += p->steady;
        v->slot[nodes * TREE_WIDE + i] = p->slot, v->child[i] = child_of(l->t, p->slot);
    }
    v->near_count = nodes, v->far_count = far;
    return true;
}

/* The box is a quarter larger than that of the points. */
static void bound(const float (*points)[6], size_t count, tree_view *v) {
    for (int c = 0; c < 3; ++c) {
        float lower = INFINITY, upper = -INFINITY;
        for (size_t k = 0; k < count; ++k)
            lower = fminf(lower, points[k][c]), upper = fmaxf(upper, points[k][c]);
        v->lower[c] = lower - (upper - lower) / 8, v->upper[c] = upper + (upper - lower) / 8;
    }
}

/* Spreads the points at which parts are weighed over those of the region. */
static void place(lister *l, const float (*points)[6], size_t count) {
    const float *lower = l->view->lower, *upper = l->view->upper;
    vec3_f32 half = {upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]};
    l->count = count < POINTS ? (uint32_t)count : POINTS;
    for (uint32_t k = 0; k < l->count; ++k) {
        const float *from = points[count * k / l->count];
        l->p[k] = scale_f32(l->t->scale, load_f32(from)), l->n[k] = load_f32(from + 3);
    }
    half = scale_f32(l->t->scale / 2, half);
    l->center = add_f32(scale_f32(l->t->scale, load_f32(lower)), half);
    store_f32(l->half, half);
}

bool tree_view_list(const tree *t, const float (*points)[6], size_t count, tree_view *view) {
    lister *l = malloc(sizeof *l);
    if (!l) return false;
    l->t = t, l->view = view, l->part_count = 0;
    memset(l->sum, 0, sizeof l->sum);
    bound(points, count, view);
    place(l, points, count);
    add_children(l, 0, 1);
    while (l->part_count + TREE_WIDE <= MOST_PARTS && open_part(l)) {
    }
    const uint32_t near = near_parts(l, sort_parts(l));
    const bool fine = !near || store(l, near, view);
    free(l);
    return fine;
}

void tree_view_destroy(tree_view *view) {
    free(view->near);
    free(view->far);
    free(view->child);
    free(view->slot);
    *view = (tree_view){.factors = NULL};
}
