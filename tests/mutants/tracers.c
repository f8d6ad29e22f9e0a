/* Tracers with one fault each, chosen by $FATHOM_MUTANT; "none" is correct. A median-split hierarchy over a
 * watertight test in double (Woop, Benthin, Wald 2013); tracers of 24 bits round their t to float.
 * mutants.tsv names the faults and says what the validator must find. */
#include <fathom/plugin.h>

#include <float.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MISS FATHOM_PLUGIN_MISS
#define LEAF 4

static const char *mutant = "none";
static bool is(const char *name) { return strcmp(mutant, name) == 0; }

/* The faults, each the name of a mutant. */
/* clang-format off */
#define FAULTS(X) \
    X(lose_last) X(lose_first) X(lose_far_index) X(short_index) X(lose_high) X(cull_back) \
    X(cull_front) X(open_edge) X(thin) X(fat) X(first_found) X(farthest) X(near_closed) \
    X(far_closed) X(any_near_closed) X(any_far_closed) X(no_near) X(no_far) X(any_no_near) \
    X(any_no_far) X(epsilon) X(infinity_1e30) X(swap_uv) X(u_off) X(nan_v) X(turned_uv) X(bias_up) \
    X(bias_down) X(unit_length) X(slab_nan) X(tiny_zero) X(minus_zero) X(short_stack) X(few_nodes) \
    X(axis_miss) X(far_miss) X(long_t_miss) X(wrong_id) X(static_last) X(static_first) X(race_ray) \
    X(race_any) X(lane_last) X(lane_swap) X(alone) X(partial) X(second_block) \
    X(fifth_block) X(octant) X(shared_origin) X(coherent_lane) X(coherent_any) X(thread_bound) \
    X(worn_out) X(build_threads) X(noise) X(any_misses) X(any_phantom) X(nan_t) X(negative_t) \
    X(t_low_bits) X(shared_vertex) X(dies_with_other) X(acne) X(any_acne)
/* clang-format on */

/* Looked up once: a fault costs a comparison a ray. */
static struct {
#define DECLARE(name) bool name;
    FAULTS(DECLARE)
    double miss, phantom;
} f;

static void choose(void) {
    const char *name = getenv("FATHOM_MUTANT");
    mutant = name ? name : "none";
#define CHOOSE(name) f.name = is(#name);
    FAULTS(CHOOSE)
    f.miss = is("miss_1e-3")        ? 1e-3
             : is("miss_1e-4")      ? 1e-4
             : is("miss_1e-5")      ? 1e-5
             : is("miss_1e-6_unit") ? 1e-6
                                    : 0;
    f.phantom = is("phantom_1e-3") ? 1e-3 : is("phantom_1e-5") ? 1e-5 : 0;
}

static bool is_float(void) {
    return is("float") || f.bias_up || f.bias_down || f.noise || f.acne || f.any_acne;
}

/* ---- the hierarchy ---- */

typedef struct node {
    float low[3], high[3];
    uint32_t first, count; /* of a leaf: triangles in `order`; else count 0, children first and first + 1 */
} node;

typedef struct tree {
    fathom_plugin_mesh mesh;
    uint32_t *order, nodes_used;
    node *nodes;
    pthread_t builder;
    double extent;
    bool damaged;
    struct tree *built_before; /* of those that are there */
} tree;

static const float *corner(const tree *t, uint32_t triangle, int k) {
    uint32_t index = t->mesh.indices[3 * (size_t)triangle + (size_t)k];
    if (f.short_index) index &= 0xffff;
    return &t->mesh.positions[3 * (size_t)index];
}

static bool usable(const tree *t, uint32_t triangle) {
    for (int k = 0; k < 9; ++k) {
        if (!(fabsf(corner(t, triangle, k / 3)[k % 3]) <= FLT_MAX)) return false;
    }
    return true;
}

static void bound(const tree *t, node *n) {
    for (int k = 0; k < 3; ++k) n->low[k] = INFINITY, n->high[k] = -INFINITY;
    for (uint32_t i = n->first; i < n->first + n->count; ++i) {
        for (int k = 0; k < 9; ++k) {
            float x = corner(t, t->order[i], k / 3)[k % 3];
            n->low[k % 3] = fminf(n->low[k % 3], x), n->high[k % 3] = fmaxf(n->high[k % 3], x);
        }
    }
}

static float middle(const tree *t, uint32_t triangle, int axis) {
    return corner(t, triangle, 0)[axis] + corner(t, triangle, 1)[axis] + corner(t, triangle, 2)[axis];
}

/* Splits in the middle of the longest side, or by number where that leaves a side empty. */
static void split(tree *t, uint32_t at) {
    bound(t, &t->nodes[at]);
    node n = t->nodes[at];
    if (n.count <= LEAF) return;
    int axis = 0;
    for (int k = 1; k < 3; ++k) {
        if (n.high[k] - n.low[k] > n.high[axis] - n.low[axis]) axis = k;
    }
    float half = 1.5f * (n.low[axis] + n.high[axis]);
    uint32_t low = n.first, high = n.first + n.count;
    while (low < high) {
        if (middle(t, t->order[low], axis) < half) {
            ++low;
        } else {
            uint32_t other = t->order[--high];
            t->order[high] = t->order[low], t->order[low] = other;
        }
    }
    if (low == n.first || low == n.first + n.count) low = n.first + n.count / 2;
    uint32_t child = t->nodes_used;
    t->nodes_used += 2;
    t->nodes[child] = (node){.first = n.first, .count = low - n.first};
    t->nodes[child + 1] = (node){.first = low, .count = n.first + n.count - low};
    t->nodes[at].first = child, t->nodes[at].count = 0;
    split(t, child), split(t, child + 1);
}

static tree *last_built;
static const tree *first_built;
static bool other_died;
static pthread_rwlock_t builds = PTHREAD_RWLOCK_INITIALIZER; /* last_built, and what static_last traces */

static void keep_last(tree *t) {
    pthread_rwlock_wrlock(&builds);
    t->built_before = last_built, last_built = t;
    pthread_rwlock_unlock(&builds);
}

static void forget(const tree *t) {
    pthread_rwlock_wrlock(&builds);
    tree **at = &last_built;
    while (*at && *at != t) at = &(*at)->built_before;
    if (*at) *at = t->built_before;
    pthread_rwlock_unlock(&builds);
}

static int build(const fathom_plugin_mesh *mesh, unsigned threads, char *message, size_t size, void **out) {
    tree *t = calloc(1, sizeof *t);
    size_t count = mesh->triangle_count;
    if (t) {
        t->order = malloc((count + 1) * sizeof *t->order);
        t->nodes = calloc(2 * count + 2, sizeof *t->nodes);
    }
    if (!t || !t->order || !t->nodes) {
        snprintf(message, size, "out of memory");
        return 1;
    }
    t->mesh = *mesh;
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; ++i) {
        bool lost = (f.lose_last && i + 1 == count) || (f.lose_first && i == 0) ||
                    (f.lose_high && i >= 1u << 18) || (f.build_threads && threads > 1 && i % 50 == 7);
        for (int k = 0; f.lose_far_index && k < 3; ++k)
            lost = lost || mesh->indices[3 * (size_t)i + (size_t)k] >= 65536;
        if (!lost && usable(t, i)) t->order[kept++] = i;
    }
    t->nodes[0] = (node){.count = kept}, t->nodes_used = 1;
    split(t, 0);
    for (int k = 0; k < 3 && kept; ++k)
        t->extent = fmax(t->extent, (double)(t->nodes[0].high[k] - t->nodes[0].low[k]));
    t->builder = pthread_self();
    keep_last(t);
    if (!first_built) first_built = t;
    *out = t;
    return 0;
}

static void destroy(void *tracer) {
    tree *t = tracer;
    forget(t);
    if (first_built == t) first_built = NULL;
    other_died = true;
    free(t->order), free(t->nodes), free(t);
}

/* ---- one ray ---- */

typedef struct ray {
    float org[3], dir[3];
    double near, far;
    bool any;
} ray;

typedef struct hit {
    uint32_t triangle;
    double t, u, v;
} hit;

static double random_of(const ray *r) {
    uint32_t h = 2166136261u;
    unsigned char bytes[24];
    memcpy(bytes, r->org, 12), memcpy(bytes + 12, r->dir, 12);
    for (int i = 0; i < 24; ++i) h = (h ^ bytes[i]) * 16777619u;
    h ^= h >> 15, h *= 0x2c1b3c6du, h ^= h >> 12, h *= 0x297a2d39u, h ^= h >> 15;
    return h * 0x1p-32;
}

/* A slab test whose boxes are wider by some rounding; ordered so that a NaN never hides a box, but for the
 * faults. */
static bool meets_box(const node *n, const ray *r, double far) {
    double begin = -INFINITY, end = INFINITY;
    for (int k = 0; k < 3; ++k) {
        double d = (double)r->dir[k], o = (double)r->org[k];
        if (f.tiny_zero && fabs(d) < 1e-12) d = 0;
        double slack = 1e-12 * (fabs(o) + fabs((double)n->low[k]) + fabs((double)n->high[k]));
        if (f.slab_nan) slack = 0;
        double low = (double)n->low[k] - slack - o, high = (double)n->high[k] + slack - o;
        if (f.slab_nan) {
            double a = low * (1 / d), b = high * (1 / d);
            if (isnan(a) || isnan(b)) return false;
        }
        if (d == 0) {
            if (f.minus_zero && signbit(d)) return false;
            if (low > 0 || high < 0) return false;
            continue;
        }
        double a = low / d, b = high / d;
        begin = fmax(begin, fmin(a, b)), end = fmin(end, fmax(a, b));
    }
    return !(begin * (1 - 1e-12) > end * (1 + 1e-12) + 1e-300) && !(begin > far + 1e-12 * fabs(far)) &&
           !(end < 0 && end < r->near);
}

static void shear(const float *vertex, const ray *r, int axis, double out[3]) {
    int x = (axis + 1) % 3, y = (axis + 2) % 3;
    double z = (double)vertex[axis] - (double)r->org[axis], dz = (double)r->dir[axis];
    out[0] = (double)vertex[x] - (double)r->org[x] - (double)r->dir[x] / dz * z;
    out[1] = (double)vertex[y] - (double)r->org[y] - (double)r->dir[y] / dz * z;
    out[2] = z;
}

static double side(const double a[3], const double b[3]) { return a[0] * b[1] - a[1] * b[0]; }

static bool inside(const double w[3]) {
    double low = f.thin ? 2e-4 : f.fat ? -2e-4 : 0;
    for (int k = 0; k < 3; ++k) {
        if (f.open_edge ? !(w[k] > 0) : !(w[k] >= low)) return false;
    }
    return true;
}

/* t in the open interval, but for the faults. */
static bool in_interval(double t, const ray *r, double far) {
    bool near_closed = r->any ? f.any_near_closed : f.near_closed;
    bool far_closed = r->any ? f.any_far_closed : f.far_closed;
    bool no_near = r->any ? f.any_no_near : f.no_near, no_far = r->any ? f.any_no_far : f.no_far;
    if (far == r->far && no_far) far = INFINITY;
    if (f.infinity_1e30 && far > 1e30) far = 1e30;
    if (f.epsilon && !(t > 1e-4)) return false;
    if (f.acne || (f.any_acne && r->any)) return t > r->near - 1e-5 && t < far;
    bool above = no_near ? t > 0 : near_closed ? t >= r->near : t > r->near;
    return above && (far == r->far && far_closed ? t <= far : t < far);
}

static bool meets(const tree *in, uint32_t i, const ray *r, double far, hit *h) {
    int axis = 0;
    for (int k = 1; k < 3; ++k) {
        if (fabsf(r->dir[k]) > fabsf(r->dir[axis])) axis = k;
    }
    double p[3][3];
    for (int k = 0; k < 3; ++k) shear(corner(in, i, k), r, axis, p[k]);
    double w[3] = {side(p[2], p[1]), side(p[0], p[2]), side(p[1], p[0])}, sum = w[0] + w[1] + w[2], t = 0;
    if (!(sum != 0)) return false;
    bool front = (sum > 0) == (r->dir[axis] > 0);
    if ((f.cull_back && !front) || (f.cull_front && front)) return false;
    for (int k = 0; k < 3; ++k) w[k] /= sum, t += w[k] * p[k][2];
    if (f.shared_vertex && w[0] > 0.9999) return false;
    t /= (double)r->dir[axis];
    if (is_float()) t = (double)(float)t;
    if (!inside(w) || !in_interval(t, r, far)) return false;
    *h = (hit){i, t, w[1], w[2]};
    return true;
}

static bool worse(const hit *best, const hit *h) {
    if (best->triangle == MISS) return true;
    if (f.first_found) return false;
    return f.farthest ? h->t > best->t : h->t < best->t || (h->t == best->t && h->triangle < best->triangle);
}

static hit search(const tree *in, const ray *r) {
    uint32_t stack[128], waiting = 0, seen = 0;
    hit best = {MISS, 0, 0, 0}, h;
    double far = r->far;
    if (!in->nodes[0].count && in->nodes_used == 1) return best;
    stack[waiting++] = 0;
    while (waiting) {
        const node *n = &in->nodes[stack[--waiting]];
        if (f.few_nodes && ++seen > 60) break;
        if (!meets_box(n, r, f.farthest || f.no_far || f.any_no_far ? (double)INFINITY : far)) continue;
        for (uint32_t i = n->first; i < n->first + n->count; ++i) {
            if (!meets(in, in->order[i], r,
                       f.farthest ? r->far : nextafter(far, far == r->far ? far : (double)INFINITY), &h) ||
                !worse(&best, &h))
                continue;
            best = h;
            if (!f.farthest && !f.first_found) far = h.t;
            if (r->any) return best;
        }
        if (n->count) continue;
        if (waiting + 2 <= (f.short_stack ? 5 : 128))
            stack[waiting++] = n->first, stack[waiting++] = n->first + 1;
    }
    return best;
}

/* ---- blocks ---- */

static double length_of(const float v[3]) {
    return sqrt((double)v[0] * (double)v[0] + (double)v[1] * (double)v[1] + (double)v[2] * (double)v[2]);
}

static bool lost(const tree *t, const ray *r) {
    static atomic_uint asked;
    int zeros = (r->dir[0] == 0) + (r->dir[1] == 0) + (r->dir[2] == 0);
    if (f.axis_miss && zeros == 2) return true;
    if (f.far_miss && length_of(r->org) > 1e5 * t->extent) return true;
    if (f.thread_bound && !pthread_equal(t->builder, pthread_self())) return true;
    if (f.worn_out && atomic_fetch_add(&asked, 1) > 5000 && random_of(r) < 0.05) return true;
    if (f.any_misses && r->any && random_of(r) < 0.002) return true;
    if (f.dies_with_other && other_died) return true;
    return f.miss > 0 && random_of(r) < f.miss;
}

static void spoil(const tree *t, const ray *r, hit *h) {
    if (h->triangle == MISS) {
        bool phantom = random_of(r) < f.phantom || (f.any_phantom && r->any && random_of(r) < 0.002);
        double far = r->far < 1e30 ? r->far : 10 * t->extent / length_of(r->dir);
        if (phantom && t->mesh.triangle_count) *h = (hit){0, 0.5 * (r->near + far), 0.25, 0.25};
        return;
    }
    double u = h->u;
    if (f.swap_uv) h->u = h->v, h->v = u;
    if (f.u_off) h->u += 1e-3;
    if (f.nan_v) h->v = NAN;
    if (f.turned_uv) h->u = 1 - h->u - h->v, h->v = u;
    if (f.bias_up) h->t = (double)(float)(h->t * (1 + 3e-6));
    if (f.bias_down) h->t = (double)(float)(h->t * (1 - 1e-6));
    if (f.noise) h->t = (double)(float)(h->t * (1 + 4e-6 * (random_of(r) - 0.5)));
    if (f.unit_length) h->t *= length_of(r->dir);
    if (f.t_low_bits) h->t = (double)(float)h->t;
    if (f.nan_t && random_of(r) < 0.001) h->t = NAN;
    if (f.negative_t && random_of(r) < 0.001) h->t = -h->t;
    if (f.wrong_id && u < 0.01) h->triangle = (h->triangle + 1) % t->mesh.triangle_count;
    if (f.long_t_miss && h->t > 1e18) h->triangle = MISS;
}

/* Whether the active rays of a block run alike and begin alike. */
static bool alike(const fathom_plugin_block *b, double spread) {
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int i = 0; i < 16; ++i) {
        const float d[3] = {b->dir_x[i], b->dir_y[i], b->dir_z[i]};
        if (b->active != 0xffff) return false;
        for (int k = 0; k < 3; ++k) low[k] = fminf(low[k], d[k]), high[k] = fmaxf(high[k], d[k]);
    }
    double most = 0;
    for (int k = 0; k < 3; ++k) most = fmax(most, fmax(fabs((double)low[k]), fabs((double)high[k])));
    for (int k = 0; k < 3; ++k) {
        if ((double)(high[k] - low[k]) > spread * most) return false;
    }
    return true;
}

static ray load(const tree *t, const fathom_plugin_block *b, int i, bool any) {
    int from = i;
    ray r = {.any = any};
    if (f.shared_origin && i > 0 && b->active & 1) {
        const float gap[3] = {b->org_x[i] - b->org_x[0], b->org_y[i] - b->org_y[0],
                              b->org_z[i] - b->org_z[0]};
        if (length_of(gap) < 0.02 * t->extent) from = 0;
    }
    r.org[0] = b->org_x[from], r.org[1] = b->org_y[from], r.org[2] = b->org_z[from];
    r.dir[0] = b->dir_x[i], r.dir[1] = b->dir_y[i], r.dir[2] = b->dir_z[i];
    r.near = (double)b->t_near[i], r.far = (double)b->t_far[i];
    return r;
}

static hit answer(const tree *t, const fathom_plugin_block *b, int i, bool any) {
    static ray shared, shared_any;
    ray r = load(t, b, i, any);
    hit none = {MISS, 0, 0, 0};
    if (f.race_ray && !any) shared = r, r = ((volatile ray *)&shared)[0];
    if (f.race_any && any) shared_any = r, r = ((volatile ray *)&shared_any)[0];
    if (f.octant && b->active & 1) {
        const float *d[3] = {b->dir_x, b->dir_y, b->dir_z};
        for (int k = 0; k < 3 && alike(b, 0.7); ++k) {
            if (signbit(d[k][0]) != signbit(d[k][i])) return none;
        }
    }
    if (lost(t, &r)) return none;
    hit h = search(t, &r);
    if (f.race_ray && !any) {
        ray now = ((volatile ray *)&shared)[0];
        if (memcmp(now.org, r.org, sizeof r.org) != 0) h = search(t, &now);
    }
    if (f.race_any && any) {
        ray now = ((volatile ray *)&shared_any)[0];
        if (memcmp(now.org, r.org, sizeof r.org) != 0) h = search(t, &now);
    }
    spoil(t, &r, &h);
    return h;
}

static int bits(uint32_t set) {
    int count = 0;
    for (; set; set &= set - 1) ++count;
    return count;
}

static void store(fathom_plugin_block *b, int i, const hit *h) {
    b->primitive[i] = h->triangle, b->t[i] = h->t, b->u[i] = h->u, b->v[i] = h->v;
}

static void trace(const void *tracer, fathom_plugin_block *blocks, size_t count, bool any) {
    const tree *t = tracer;
    if (f.static_last) {
        pthread_rwlock_rdlock(&builds);
        t = last_built;
    }
    if (f.static_first && first_built) t = first_built;
    for (size_t k = 0; k < count; ++k) {
        fathom_plugin_block *b = &blocks[k];
        bool whole_lost = (f.second_block && k == 1) || (f.fifth_block && k >= 4) ||
                          (f.alone && bits(b->active) == 1) || (any && f.coherent_any && alike(b, 0.1));
        for (int i = 0; i < 16; ++i) {
            hit h = {MISS, 0, 0, 0};
            bool asked = b->active >> i & 1 && !whole_lost && !(f.lane_last && i == 15) &&
                         !(f.coherent_lane && i == 7 && alike(b, 0.1)) &&
                         !(f.partial && b->active != 0xffff && b->active >> (i + 1) == 0);
            if (asked) h = answer(t, b, f.lane_swap && i < 2 && (b->active & 3) == 3 ? 1 - i : i, any);
            store(b, i, &h);
        }
    }
    if (f.static_last) pthread_rwlock_unlock(&builds);
}

static void closest(const void *tracer, fathom_plugin_block *blocks, size_t count) {
    trace(tracer, blocks, count, false);
}
static void any(const void *tracer, fathom_plugin_block *blocks, size_t count) {
    trace(tracer, blocks, count, true);
}
static void nothing(const void *tracer, fathom_plugin_block *blocks, size_t count) {
    (void)tracer;
    for (size_t k = 0; k < count; ++k) {
        for (int i = 0; i < 16; ++i) blocks[k].primitive[i] = MISS;
    }
}

const fathom_plugin *fathom_plugin_get(void) {
    static fathom_plugin table = {FATHOM_PLUGIN_VERSION, "mutant", 0x1p-53, build, closest, any, destroy};
    choose();
    if (is_float()) table.unit = 0x1p-24;
    if (is("unit_16") || is("miss_1e-6_unit")) table.unit = 0x1p-16;
    if (is("unit_tenth")) table.unit = 0.1;
    if (is("unit_half")) table.unit = 0.5, table.closest = table.any = nothing;
    return &table;
}
