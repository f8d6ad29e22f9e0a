/* How much light a node's children may send to a point, and the random choice of one light. */
#include "base/kernel.h"
#include "light/tree_view.h"
#include "math/limit.h"

/* Nodes less unsure than this fraction of the total are not replaced by their children. */
#define LITTLE 0.005f
/* The fraction of the bound in a cosine. */
#define BOUND 0.125f

static inline float positive(float x) { return x > 0 ? x : 0; }

/* cos(a - b), or 1 if a <= b, for angles in [0, pi] given by their cosines and the sine of b. */
static inline float cos_less(float cos_a, float cos_b, float sin_b) {
    float less = cos_a * cos_b + sqrtf(positive(1 - cos_a * cos_a)) * sin_b;
    return cos_a >= cos_b ? 1 : less;
}

/* Power times the cosines at both ends, divided by a squared distance. A cosine is mostly that of the box's
 * centre. An eighth of an upper bound keeps a probability above 0 for all lights that can reach the point:
 * the height of the highest corner, above the surface or the lights' own plane, divided by the distance of
 * the nearest point. Distances are at least half of the half diagonal, because a large light sends a bounded
 * amount to a point near it. One of many lights may be very near, so the squared distance of a node is the
 * product of the distances of the centre and of the nearest point. A beam sends light if its bound may reach
 * the point, and twice as much if its centre does. leaf: all ones for a single light, 0 for a node. */
static inline float light_of(const tree_node *node, int i, vec3_f32 p, vec3_f32 n, uint32_t leaf,
                             float *restrict unsure) {
    const float one_sided = n.x != 0 || n.y != 0 || n.z != 0 ? 1 : 0;
    float x = node->x[i] - p.x, y = node->y[i] - p.y, z = node->z[i] - p.z;
    float hx = node->half_x[i], hy = node->half_y[i], hz = node->half_z[i];
    float ax = node->axis_x[i], ay = node->axis_y[i], az = node->axis_z[i];
    float square = x * x + y * y + z * z, r2 = hx * hx + hy * hy + hz * hz;
    float ahead = -(x * ax + y * ay + z * az);
    float nx = positive(fabsf(x) - hx), ny = positive(fabsf(y) - hy), nz = positive(fabsf(z) - hz);
    float nearest = nx * nx + ny * ny + nz * nz, spread = node->spread[i];
    float inverse = 1 / sqrtf(nearest + 0x1p-120f);
    float leaving = fabsf(ahead), arriving = x * n.x + y * n.y + z * n.z;
    float along = hx * fabsf(ax) + hy * fabsf(ay) + hz * fabsf(az);
    float above = arriving + hx * fabsf(n.x) + hy * fabsf(n.y) + hz * fabsf(n.z);
    float middle = 1 / sqrtf(square + 0x1p-120f);
    float most_off = least(1, (leaving + along) * inverse), most_met = least(1, positive(above * inverse));
    float off = BOUND * most_off + (1 - BOUND) * leaving * middle;
    float met = BOUND * most_met + (1 - BOUND) * positive(arriving * middle);
    met = one_sided > 0 ? met : 1, most_met = one_sided > 0 ? most_met : 1;
    float sent = cos_less(off, spread, sqrtf(positive(1 - spread * spread)));
    float lit = ((ahead + along) * inverse >= -spread ? 0.5f : 0) + (ahead * middle >= -spread ? 0.5f : 0);
    sent = spread < 0 ? lit : sent;
    float most_sent = spread < 0 || sent > most_off ? sent : most_off;
    float within = 0.25f * r2, far = square > within ? square : within;
    far = chosen(leaf, far, sqrtf(far) * sqrtf(nearest + r2 / 64)); /* the product may overflow */
    const float near = least(inverse * inverse, 0x1p96f);           /* a power is below 2^28 */
    *unsure = chosen(leaf, 0, node->power[i] * most_sent * most_met * near * least(1, r2 * near));
    return node->power[i] * sent * met / (far + 0x1p-120f);
}

static void weigh(const tree_node *node, vec3_f32 p, vec3_f32 n, float weight[restrict TREE_WIDE],
                  float unsure[restrict TREE_WIDE]) {
    for (int i = 0; i < TREE_WIDE; ++i)
        weight[i] = light_of(node, i, p, n, node->child[i] & TREE_LEAF ? ~0u : 0, &unsure[i]);
}

static inline float sum_of(const float value[TREE_WIDE]) {
    float sum = 0;
    for (int i = 0; i < TREE_WIDE; ++i) sum += value[i];
    return sum;
}

/* The point and the normal of a light sample, and its factors. */
typedef struct query {
    vec3_f32 p, n;
    tree_factors factors;
} query;

/* The nodes that a cut opens, how unsure their children are, and the factors of these. */
typedef struct opening {
    float unsure[1 + TREE_NEAR][TREE_WIDE], most[1 + TREE_NEAR], factor[1 + TREE_NEAR][TREE_WIDE];
    float sum;      /* sum of all weights */
    uint32_t level; /* the first node of the lowest level */
} opening;

/* Weighs the children of node k of the cut; inherited: the node's own factor. */
static inline void weigh_node(const tree *t, const query *q, float inherited, uint32_t k, opening *o,
                              tree_cut *out) {
    weigh(&t->nodes[out->node[k]], q->p, q->n, out->weight[k], o->unsure[k]);
    if (!q->factors) return;
    const uint32_t row = t->row_of[out->node[k]];
    for (int i = 0; i < TREE_WIDE; ++i) {
        const float factor = row == FATHOM_NONE ? inherited : q->factors[row * TREE_WIDE + (uint32_t)i];
        o->factor[k][i] = factor, out->weight[k][i] *= factor, o->unsure[k][i] *= factor;
    }
}

static inline void begin_cut(const tree *t, const query *q, opening *o, tree_cut *out) {
    out->node[0] = out->next[0] = 0, out->count = 1;
    weigh_node(t, q, 1, 0, o, out);
    o->sum = sum_of(out->weight[0]), o->level = 0;
}

/* Opens a child of node k. In the order, it comes after node k and all nodes that were more unsure. */
static inline void open_child(const tree *t, const query *q, uint32_t k, int child, opening *o,
                              tree_cut *out) {
    const uint32_t last = out->count++;
    uint32_t before = k;
    o->most[last] = o->unsure[k][child];
    while (out->next[before] && o->most[out->next[before]] >= o->most[last]) before = out->next[before];
    out->next[last] = out->next[before], out->next[before] = last;
    out->node[last] = t->nodes[out->node[k]].child[child];
    weigh_node(t, q, q->factors ? o->factor[k][child] : 1, last, o, out);
    o->sum += sum_of(out->weight[last]) - out->weight[k][child];
    out->weight[k][child] = 0;
}

/* Opens children of the lowest level. False: none. */
static inline bool open_level(const tree *t, const query *q, opening *o, tree_cut *out) {
    const float little = LITTLE * positive(o->sum); /* rounding may make the sum negative */
    const uint32_t end = out->count;
    for (uint32_t k = o->level; k < end; ++k) {
        uint32_t open = 0;
        for (int i = 0; i < TREE_WIDE; ++i) open |= (o->unsure[k][i] > little ? 1u : 0u) << i;
        for (; open && out->count <= TREE_NEAR; open &= open - 1)
            open_child(t, q, k, __builtin_ctz(open), o, out);
    }
    o->level = end;
    return end < out->count;
}

/* Cuts for up to TOGETHER points, level by level: the processor weighs nodes of other points while it waits
 * for those of one. */
enum { TOGETHER = 4 };

static void cut_each(const tree *t, const query *queries, unsigned count, tree_cut *out) {
    opening o[TOGETHER];
    unsigned on = 0;
    for (unsigned i = 0; i < count; ++i) begin_cut(t, &queries[i], &o[i], &out[i]), on |= 1u << i;
    while (on) {
        for (unsigned left = on; left; left &= left - 1) {
            const unsigned i = (unsigned)__builtin_ctz(left);
            if (!open_level(t, &queries[i], &o[i], &out[i])) on &= ~(1u << i);
        }
    }
}

static void cut(const tree *t, vec3_f32 p, vec3_f32 n, tree_factors factors, tree_cut *out) {
    const query q = {p, n, factors};
    cut_each(t, &q, 1, out);
}

/* The child at u times the sum of weights: the first child whose prefix sum exceeds that value, so its weight
 * is above 0. *u becomes the position within the child's interval. */
static int pick(const float weight[TREE_WIDE], double *u, double *chance) {
    double below[TREE_WIDE + 1] = {0};
    for (int i = 0; i < TREE_WIDE; ++i) below[i + 1] = below[i] + (double)weight[i];
    const double sum = below[TREE_WIDE], at = *u * sum, most = sum * (1 - 0x1p-53);
    const double left = at < most ? at : most;
    if (!(sum > 0)) return -1;
    int found = 0;
    for (int i = 1; i < TREE_WIDE; ++i) found += left >= below[i];
    const double part = (left - below[found]) / (double)weight[found];
    *u = part < 1 - 0x1p-53 ? part : 1 - 0x1p-53;
    *chance *= (double)weight[found] / sum;
    return found;
}

/* The part at u times the sum of parts, of which some are above 0. The parts are ordered: next leads from the
 * first to the last. *u becomes the position within the part, and *chance is multiplied by its probability.
 */
static uint32_t pick_part(const double *part, const uint32_t *next, uint32_t count, double sum, double *u,
                          double *chance) {
    double left = *u * sum, own = 0;
    uint32_t found = 0;
    for (uint32_t j = 0, k = 0; j < count; ++j, k = next[k]) {
        if (!(part[k] > 0)) continue;
        if (own > 0 && left < own) break;
        if (own > 0) left -= own;
        found = k, own = part[k];
    }
    *u = left < own * (1 - 0x1p-53) ? left / own : 1 - 0x1p-53;
    *chance *= own / sum;
    return found;
}

/* The node of the cut at u times the sum of weights; -1: all weights are 0. */
static int pick_node(const tree_cut *cut, double *u, double *chance) {
    double part[1 + TREE_NEAR] = {0}, sum = 0;
    for (uint32_t k = 0; k < cut->count; ++k) {
        for (int i = 0; i < TREE_WIDE; ++i) part[k] += (double)cut->weight[k][i];
        sum += part[k];
    }
    return sum > 0 ? (int)pick_part(part, cut->next, cut->count, sum, u, chance) : -1;
}

/* One step of a traversal: chooses a child of a node, whose weights are known. False: the traversal ends. */
static inline bool walk(const tree_node *node, const float weight[TREE_WIDE], double *u, uint32_t *light,
                        double *chance) {
    const int child = pick(weight, u, chance);
    if (child < 0) {
        *chance = 0;
        return false;
    }
    *light = node->child[child];
    return !(*light & TREE_LEAF);
}

static tree_factors factors_of(const tree_view **views, int i) {
    return views && views[i] ? views[i]->factors : NULL;
}

static query query_of(const tree *t, const lanes3 p, const lanes3 n, const tree_view **views, int i) {
    return (query){.p = {t->scale * p[0][i], t->scale * p[1][i], t->scale * p[2][i]},
                   .n = {n[0][i], n[1][i], n[2][i]},
                   .factors = factors_of(views, i)};
}

/* The first step of each lane's traversal; returns the lanes that continue. */
static unsigned leave_cuts(const tree *t, const lanes3 p, const lanes3 n, const tree_view **views,
                           unsigned lanes, double u[LANES], uint32_t light[LANES], double chance[LANES]) {
    unsigned on = 0;
    while (lanes) {
        int lane[TOGETHER];
        unsigned count = 0;
        query queries[TOGETHER];
        tree_cut cuts[TOGETHER];
        for (; lanes && count < TOGETHER; lanes &= lanes - 1) {
            lane[count] = __builtin_ctz(lanes);
            queries[count] = query_of(t, p, n, views, lane[count]), ++count;
        }
        cut_each(t, queries, count, cuts);
        for (unsigned j = 0; j < count; ++j) {
            const int i = lane[j], k = pick_node(&cuts[j], &u[i], &chance[i]);
            if (k < 0)
                chance[i] = 0;
            else if (walk(&t->nodes[cuts[j].node[k]], cuts[j].weight[k], &u[i], &light[i], &chance[i]))
                on |= 1u << i;
        }
    }
    return on;
}

/* ---- lists of views ---- */

/* The far part at u times the sum of their weights; *u becomes the position within the part. */
static uint32_t pick_far(const tree_view *v, double *u, double *own) {
    const double at = *u * tree_view_far(v);
    uint32_t low = 0, high = v->far_count - 1;
    while (low < high) {
        const uint32_t middle = (low + high) / 2;
        if (at < v->far[middle])
            high = middle;
        else
            low = middle + 1;
    }
    const double below = low ? v->far[low - 1] : 0, part = at - below;
    *own = v->far[low] - below;
    *u = part < *own * (1 - 0x1p-53) ? part / *own : 1 - 0x1p-53;
    return v->child[low];
}

/* The first step of a traversal from a list; the last part of its sum are all far parts. False: the traversal
 * ends. */
static bool leave_list(const tree_view *v, const query *q, double *u, uint32_t *light, double *chance) {
    static const uint32_t next[TREE_LISTED + 1] = {1, 2, 3, 4, 0};
    float weight[TREE_LISTED][TREE_WIDE], unsure[TREE_WIDE];
    double part[TREE_LISTED + 1] = {0}, sum, own;
    const uint32_t near = v->near_count;
    for (uint32_t k = 0; k < near; ++k) {
        weigh(&v->near[k], q->p, q->n, weight[k], unsure);
        for (int i = 0; i < TREE_WIDE; ++i) part[k] += (double)weight[k][i];
    }
    sum = part[near] = tree_view_far(v);
    for (uint32_t k = 0; k < near; ++k) sum += part[k];
    if (!(sum > 0)) {
        *chance = 0;
        return false;
    }
    const uint32_t found = pick_part(part, next, near + 1, sum, u, chance);
    if (found < near) return walk(&v->near[found], weight[found], u, light, chance);
    *light = pick_far(v, u, &own);
    *chance *= own / part[near];
    return !(*light & TREE_LEAF);
}

/* The first step of each lane's traversal; returns the lanes that continue. */
static unsigned leave(const tree *t, const lanes3 p, const lanes3 n, const tree_view **views, unsigned lanes,
                      double u[LANES], uint32_t light[LANES], double chance[LANES]) {
    unsigned on = 0, listed = 0;
    for (unsigned left = views ? lanes : 0; left; left &= left - 1) {
        const int i = __builtin_ctz(left);
        const query q = query_of(t, p, n, views, i);
        if (!views[i] || !tree_view_holds(views[i], (vec3_f32){p[0][i], p[1][i], p[2][i]})) continue;
        listed |= 1u << i;
        if (leave_list(views[i], &q, &u[i], &light[i], &chance[i])) on |= 1u << i;
    }
    return on | leave_cuts(t, p, n, views, lanes & ~listed, u, light, chance);
}

/* ---- up to eight lights: all lanes at once ---- */

/* below: sums of the weights of all lights before. */
typedef struct few_lights {
    double weight[TREE_WIDE][LANES], below[TREE_WIDE + 1][LANES];
} few_lights;

static inline void weigh_light(const tree *t, int k, const lanes3 p, const lanes3 n,
                               double weight[restrict LANES]) {
    const float scale = t->scale;
    for (int i = 0; i < LANES; ++i) {
        const vec3_f32 at = {scale * p[0][i], scale * p[1][i], scale * p[2][i]};
        float unsure;
        weight[i] = (double)light_of(t->nodes, k, at, (vec3_f32){n[0][i], n[1][i], n[2][i]}, ~0u, &unsure);
    }
}

static inline void weigh_lights(const tree *t, const lanes3 p, const lanes3 n, const tree_view **views,
                                few_lights *restrict out) {
    for (int i = 0; i < LANES; ++i) out->below[0][i] = 0;
    for (int k = 0; k < TREE_WIDE; ++k) {
        if (t->nodes->power[k] > 0)
            weigh_light(t, k, p, n, out->weight[k]);
        else
            memset(out->weight[k], 0, sizeof out->weight[k]);
        for (int i = 0; views && i < LANES; ++i) {
            const tree_factors factors = factors_of(views, i);
            if (factors) out->weight[k][i] = (double)((float)out->weight[k][i] * factors[k]);
        }
        for (int i = 0; i < LANES; ++i) out->below[k + 1][i] = out->below[k][i] + out->weight[k][i];
    }
}

/* pick() in each lane; undefined in lanes without light. */
static inline void pick_each(const few_lights *f, const double u[LANES], double part[restrict LANES],
                             double chance[restrict LANES], double found[restrict LANES]) {
    for (int i = 0; i < LANES; ++i) {
        const double sum = f->below[TREE_WIDE][i], at = u[i] * sum, most = sum * (1 - 0x1p-53);
        const double left = at < most ? at : most;
        double first = 0, own = f->weight[0][i];
        found[i] = 0;
        for (int k = 1; k < TREE_WIDE; ++k) {
            first = left >= f->below[k][i] ? f->below[k][i] : first;
            own = left >= f->below[k][i] ? f->weight[k][i] : own;
            found[i] = left >= f->below[k][i] ? k : found[i];
        }
        const double within = (left - first) / own;
        part[i] = within < 1 - 0x1p-53 ? within : 1 - 0x1p-53;
        chance[i] = own / sum;
    }
}

static void choose_of_few(const tree *t, const lanes3 p, const lanes3 n, const tree_view **views,
                          unsigned lanes, double u[LANES], uint32_t light[LANES], double chance[LANES]) {
    few_lights f;
    double part[LANES], share[LANES], found[LANES];
    weigh_lights(t, p, n, views, &f);
    pick_each(&f, u, part, share, found);
    for (; lanes; lanes &= lanes - 1) {
        const int i = __builtin_ctz(lanes);
        const bool any = f.below[TREE_WIDE][i] > 0;
        chance[i] = any ? share[i] : 0;
        if (any) u[i] = part[i], light[i] = t->nodes->child[(int)found[i]];
    }
}

/* ---- the choice ---- */

/* A node without a row has one factor for all children, which changes nothing. */
static inline void adjust(const tree *t, uint32_t node, tree_factors factors, float weight[TREE_WIDE]) {
    const uint32_t row = t->row_of[node];
    for (uint32_t k = 0; row != FATHOM_NONE && k < TREE_WIDE; ++k) weight[k] *= factors[row * TREE_WIDE + k];
}

/* Level by level: the processor works on several lanes' nodes at once while they are fetched from memory. */
static void walk_all(const tree *t, const lanes3 p, const lanes3 n, const tree_view **views, unsigned lanes,
                     double u[LANES], uint32_t light[LANES], double chance[LANES]) {
    while (lanes) {
        for (unsigned left = lanes; left; left &= left - 1) {
            const int i = __builtin_ctz(left);
            const vec3_f32 at = {t->scale * p[0][i], t->scale * p[1][i], t->scale * p[2][i]};
            const tree_node *node = &t->nodes[light[i]];
            float weight[TREE_WIDE], unsure[TREE_WIDE];
            weigh(node, at, (vec3_f32){n[0][i], n[1][i], n[2][i]}, weight, unsure);
            const tree_factors factors = factors_of(views, i);
            if (factors) adjust(t, light[i], factors, weight);
            if (!walk(node, weight, &u[i], &light[i], &chance[i]))
                lanes &= ~(1u << i);
            else
                for (int k = 0; k < 6; ++k) __builtin_prefetch((const char *)&t->nodes[light[i]] + 64 * k);
        }
    }
}

static void choose(const tree *t, const lanes3 p, const lanes3 n, const tree_view **views, unsigned lanes,
                   double u[LANES], uint32_t light[LANES], double chance[LANES]) {
    for (int i = 0; i < LANES; ++i) light[i] = 0, chance[i] = 1;
    if (t->count == 1)
        choose_of_few(t, p, n, views, lanes, u, light, chance);
    else
        walk_all(t, p, n, views, leave(t, p, n, views, lanes, u, light, chance), u, light, chance);
    for (int i = 0; i < LANES; ++i) light[i] &= ~TREE_LEAF;
}

/* Tests the sphere around each box. The errors of the cross product and of `along` are below b = 2^-21 of the
 * distance, and (a + b)² <= (1 + 2^-10) a² + (1 + 2^10) b². NaNs, which overflow makes, count as met. */
static unsigned meet(const tree_node *node, vec3_f32 p, vec3_f32 d, float length) {
    int met[TREE_WIDE];
    unsigned bits = 0;
    for (int i = 0; i < TREE_WIDE; ++i) {
        float x = node->x[i] - p.x, y = node->y[i] - p.y, z = node->z[i] - p.z;
        float hx = node->half_x[i], hy = node->half_y[i], hz = node->half_z[i];
        float ax = y * d.z - z * d.y, ay = z * d.x - x * d.z, az = x * d.y - y * d.x;
        float square = x * x + y * y + z * z, r2 = hx * hx + hy * hy + hz * hz;
        float wide = r2 * (1 + 0x1p-10f) + square * 0x1p-31f, reach = sqrtf(wide);
        float along = x * d.x + y * d.y + z * d.z, aside = ax * ax + ay * ay + az * az;
        met[i] = (node->power[i] > 0) & !(aside > wide) & !(along < -reach) & !(along - reach > length);
    }
    for (int i = 0; i < TREE_WIDE; ++i) bits |= (unsigned)met[i] << i;
    return bits;
}

const tree_kernels KERNEL(tree_kernels) = {.weigh = weigh, .cut = cut, .meet = meet, .choose = choose};
