/* The oracle against GMP's rational numbers on hard random cases, with denormals flushed, under the flags
 * that it ships with, and within the room that its own whole numbers have. */
#include "math/affine.h"
#include "random.h"
#include "trace/trace.h"
#include "unit.h"
#include "verify/exact/exact.h"

typedef struct tally {
    int asked, hits, parallel;
} tally;

/* ---- rational numbers ---- */

typedef struct rational {
    mpq_t q;
} rational;

static void init(rational *all, size_t count) {
    for (size_t i = 0; i < count; ++i) mpq_init(all[i].q);
}

static void clear(rational *all, size_t count) {
    for (size_t i = 0; i < count; ++i) mpq_clear(all[i].q);
}

/* *r += a b */
static void add_product(rational *r, const rational *a, const rational *b) {
    rational product;
    init(&product, 1);
    mpq_mul(product.q, a->q, b->q);
    mpq_add(r->q, r->q, product.q);
    clear(&product, 1);
}

static void set_dot(rational *r, const rational a[3], const rational b[3]) {
    mpq_set_ui(r->q, 0, 1);
    for (int i = 0; i < 3; ++i) add_product(r, &a[i], &b[i]);
}

static void set_cross(rational r[3], const rational a[3], const rational b[3]) {
    rational minus;
    init(&minus, 1);
    for (int i = 0; i < 3; ++i) {
        mpq_set_ui(r[i].q, 0, 1);
        add_product(&r[i], &a[(i + 1) % 3], &b[(i + 2) % 3]);
        mpq_neg(minus.q, a[(i + 2) % 3].q);
        add_product(&r[i], &minus, &b[(i + 1) % 3]);
    }
    clear(&minus, 1);
}

/* Any float. */
static void set_float(rational *r, float x) { mpq_set_d(r->q, (double)x); }

static void add_float(rational *r, float x) {
    rational more;
    init(&more, 1);
    set_float(&more, x);
    mpq_add(r->q, r->q, more.q);
    clear(&more, 1);
}

/* v, or v carried by an instance. */
static void set_carried(rational r[3], const world_instance *instance, vec3_f32 v, int w) {
    const float in[4] = {v.x, v.y, v.z, (float)w};
    rational a, b;
    init(&a, 1), init(&b, 1);
    for (int i = 0; i < 3; ++i) {
        set_float(&r[i], instance ? 0 : in[i]);
        for (int k = 0; instance && k < 4; ++k) {
            set_float(&a, instance->to_object[i][k]), set_float(&b, in[k]);
            add_product(&r[i], &a, &b);
        }
    }
    clear(&a, 1), clear(&b, 1);
}

/* x, moved by 2^-100 of itself: of any size, by powers of two that double holds. */
static void set_moved(rational *r, real_f128 x, int sign) {
    rational scale, part;
    init(&scale, 1), init(&part, 1);
    mpq_set_ui(scale.q, 1, 1);
    for (; abs_f128(x) > (real_f128)0x1p500; x *= (real_f128)0x1p-500) mpq_mul_2exp(scale.q, scale.q, 500);
    for (; x != 0 && abs_f128(x) < (real_f128)0x1p-500; x *= (real_f128)0x1p500)
        mpq_div_2exp(scale.q, scale.q, 500);
    mpq_set_ui(r->q, 0, 1);
    for (int i = 0; i < 3; ++i, x -= (real_f128)mpq_get_d(part.q)) {
        mpq_set_d(part.q, (double)x);
        mpq_add(r->q, r->q, part.q);
    }
    mpq_mul(r->q, r->q, scale.q);
    mpq_div_2exp(part.q, r->q, 100);
    if (sign < 0) mpq_neg(part.q, part.q);
    if (sign) mpq_add(r->q, r->q, part.q);
    clear(&scale, 1), clear(&part, 1);
}

/* Within 2^-100 of n / d. */
static bool is_quotient(real_f128 x, const rational *n, const rational *d) {
    rational exact, low, high;
    init(&exact, 1), init(&low, 1), init(&high, 1);
    mpq_div(exact.q, n->q, d->q);
    set_moved(&low, x, -mpq_sgn(exact.q)), set_moved(&high, x, mpq_sgn(exact.q));
    const bool same = mpq_cmp(low.q, exact.q) <= 0 && mpq_cmp(exact.q, high.q) <= 0;
    clear(&exact, 1), clear(&low, 1), clear(&high, 1);
    return same && (x == 0) == !mpq_sgn(n->q);
}

/* The sign of a quotient less an end of the interval. */
static int order_at(const rational *n, const rational *d, float end) {
    if (isinf(end)) return end > 0 ? -1 : 1;
    rational t, at;
    init(&t, 1), init(&at, 1);
    mpq_div(t.q, n->q, d->q);
    set_float(&at, end);
    const int order = mpq_cmp(t.q, at.q);
    clear(&t, 1), clear(&at, 1);
    return (order > 0) - (order < 0);
}

static int sign_of(real_f128 x) { return (x > 0) - (x < 0); }

/* t = n / d, and its place in the interval. */
static bool flat_agrees(const oracle_ray *ray, const oracle_answer *a, const rational *n, const rational *d) {
    if (a->parallel || !mpq_sgn(d->q)) return a->parallel == !mpq_sgn(d->q);
    return is_quotient(a->t, n, d) && sign_of(a->above_near) == order_at(n, d, ray->t_near) &&
           sign_of(a->below_far) == -order_at(n, d, ray->t_far);
}

/* All in the primitive's space, as seen from the ray's origin. */
typedef struct setting {
    rational dir[3], from[3][3];
} setting;

static bool triangle_agrees(const oracle_ray *ray, const setting *s, const oracle_answer *a) {
    rational cross[3], edge[3], n, sum;
    init(cross, 3), init(edge, 3), init(&n, 1), init(&sum, 1);
    for (int k = 0; k < 3; ++k) {
        set_cross(cross, s->from[(k + 1) % 3], s->from[(k + 2) % 3]);
        set_dot(&edge[k], s->dir, cross);
        mpq_add(sum.q, sum.q, edge[k].q);
        if (k == 0) set_dot(&n, s->from[0], cross);
    }
    bool same = flat_agrees(ray, a, &n, &sum);
    for (int k = 0; k < 3 && !a->parallel; ++k) same = same && is_quotient(a->weight[k], &edge[k], &sum);
    clear(cross, 3), clear(edge, 3), clear(&n, 1), clear(&sum, 1);
    return same;
}

/* The plane's normal stands in for a second corner. */
static bool plane_agrees(const oracle_ray *ray, const setting *s, const oracle_answer *a, vec3_f32 normal) {
    rational m[3], n, d;
    init(m, 3), init(&n, 1), init(&d, 1);
    set_carried(m, NULL, normal, 0);
    set_dot(&n, s->from[0], m), set_dot(&d, s->dir, m);
    const bool same = flat_agrees(ray, a, &n, &d);
    clear(m, 3), clear(&n, 1), clear(&d, 1);
    return same;
}

/* The sign of (b + s √D) / a - x, for a > 0 and D >= 0. */
static int root_order(const rational *a, const rational *b, const rational *D, int s, const rational *x) {
    rational m, square;
    init(&m, 1), init(&square, 1);
    mpq_mul(m.q, a->q, x->q);
    mpq_sub(m.q, m.q, b->q); /* s √D against m */
    mpq_mul(square.q, m.q, m.q);
    const int apart = mpq_cmp(D->q, square.q), below = mpq_sgn(m.q);
    clear(&m, 1), clear(&square, 1);
    if (s > 0) return below < 0 ? 1 : (apart > 0) - (apart < 0);
    return below > 0 || (below == 0 && apart > 0) ? -1 : (apart < 0) - (apart > 0);
}

static bool sphere_agrees(const oracle_ray *ray, const setting *v, double radius,
                          const oracle_answer *answer) {
    rational a, b, c, r2, D, low, high, whole;
    init(&a, 1), init(&b, 1), init(&c, 1), init(&r2, 1), init(&D, 1), init(&low, 1), init(&high, 1);
    init(&whole, 1);
    mpq_set_d(r2.q, radius);
    mpq_mul(r2.q, r2.q, r2.q);
    set_dot(&a, v->dir, v->dir), set_dot(&b, v->from[0], v->dir), set_dot(&c, v->from[0], v->from[0]);
    mpq_sub(c.q, c.q, r2.q);
    mpq_mul(D.q, b.q, b.q), mpq_mul(whole.q, a.q, c.q);
    mpq_sub(D.q, D.q, whole.q);
    mpq_mul(whole.q, a.q, r2.q);
    bool same = answer->parallel == !mpq_sgn(a.q);
    if (!answer->parallel) {
        same = same && is_quotient(answer->edge, &D, &whole) && answer->line == (mpq_sgn(D.q) >= 0);
        if (!answer->line) same = same && is_quotient(answer->t, &b, &a);
    }
    for (int k = 0; k < 2 && !answer->parallel && answer->line; ++k) {
        const real_f128 t = k ? answer->other : answer->t;
        const int s = (answer->part == 1) != (k == 1) ? 1 : -1;
        set_moved(&low, t, -1), set_moved(&high, t, 1);
        same = same && root_order(&a, &b, &D, s, t < 0 ? &high : &low) >= 0 &&
               root_order(&a, &b, &D, s, t < 0 ? &low : &high) <= 0;
        set_float(&low, isinf(ray->t_near) ? 0 : ray->t_near);
        if (k == 0) same = same && sign_of(answer->above_near) == root_order(&a, &b, &D, s, &low);
        if (k == 0 && isfinite(ray->t_far)) {
            set_float(&high, ray->t_far);
            same = same && sign_of(answer->below_far) == -root_order(&a, &b, &D, s, &high);
        }
    }
    clear(&a, 1), clear(&b, 1), clear(&c, 1), clear(&r2, 1), clear(&D, 1), clear(&low, 1), clear(&high, 1);
    clear(&whole, 1);
    return same;
}

/* A quad's answer is that of its part, a triangle. */
static bool agrees(const oracle_ray *ray, const oracle_primitive *p, const oracle_answer *a) {
    const int parts[2][3] = {{0, 1, p->shape == ORACLE_QUAD ? 3 : 2}, {2, 3, 1}};
    const int *corner = parts[p->shape == ORACLE_QUAD ? a->part : 0];
    if (!finite_f32(ray->dir)) return a->parallel;
    setting s;
    rational org[3];
    init(org, 3), init(s.dir, 3);
    set_carried(org, p->instance, ray->org, 1), set_carried(s.dir, p->instance, ray->dir, 0);
    for (int k = 0; k < 3; ++k) {
        init(s.from[k], 3);
        set_carried(s.from[k], NULL, p->v[corner[k]], 0);
        for (int i = 0; i < 3; ++i) mpq_sub(s.from[k][i].q, s.from[k][i].q, org[i].q);
        const float rest[3] = {p->rest.x, p->rest.y, p->rest.z};
        for (int i = 0; i < 3 && p->shape == ORACLE_SPHERE; ++i) add_float(&s.from[k][i], rest[i]);
    }
    bool same = false;
    switch (p->shape) {
    case ORACLE_SPHERE:
        same = p->radius > 0 ? sphere_agrees(ray, &s, oracle_radius(p), a) : a->parallel;
        break;
    case ORACLE_PLANE: same = plane_agrees(ray, &s, a, p->v[1]); break;
    case ORACLE_TRIANGLE: same = triangle_agrees(ray, &s, a); break;
    case ORACLE_QUAD: same = a->parallel || triangle_agrees(ray, &s, a); break;
    }
    clear(org, 3), clear(s.dir, 3);
    for (int k = 0; k < 3; ++k) clear(s.from[k], 3);
    return same;
}

/* ---- cases ---- */

static bool promises_kept(const oracle_answer *a) {
    if (a->parallel) return !a->hit;
    const bool inside = a->above_near > 0 && a->below_far > 0;
    return a->line == (a->edge >= 0) && a->hit == (a->line && inside);
}

static void check(const oracle_ray *ray, const oracle_primitive *p, tally *count) {
    oracle_answer a;
    oracle_ask(ray, p, &a);
    if (!agrees(ray, p, &a) || !promises_kept(&a)) {
        fail_msg("shape %d: hit %d line %d t %.17g edge %.17g\n"
                 "org %a %a %a dir %a %a %a t (%a, %a)",
                 (int)p->shape, a.hit, a.line, (double)a.t, (double)a.edge, (double)ray->org.x,
                 (double)ray->org.y, (double)ray->org.z, (double)ray->dir.x, (double)ray->dir.y,
                 (double)ray->dir.z, (double)ray->t_near, (double)ray->t_far);
    }
    ++count->asked, count->hits += a.hit, count->parallel += a.parallel;
}

static vec3_f32 point_in(random_state *r, double size) {
    return vec_f32((float)random_in(r, -size, size), (float)random_in(r, -size, size),
                   (float)random_in(r, -size, size));
}

static float whole_in(random_state *r, int size) { return (float)(int)random_in(r, -size, size + 1); }
static vec3_f32 whole_point(random_state *r, int size) {
    float x = whole_in(r, size), y = whole_in(r, size);
    return vec_f32(x, y, whole_in(r, size));
}

/* A float of any size, denormals among them. */
static float wild(random_state *r) {
    uint32_t bits = (uint32_t)random_bits(r);
    float x;
    if ((bits >> 23 & 0xff) == 0xff) bits ^= 0x40000000u;
    memcpy(&x, &bits, sizeof x);
    return x;
}
static vec3_f32 wild_point(random_state *r) {
    float x = wild(r), y = wild(r);
    return vec_f32(x, y, wild(r));
}

typedef enum family { PLAIN, EDGES, WHOLE, SLIVERS, WILD, TINY, FAMILIES } family;
static const char *const family_names[FAMILIES] = {
    "plain", "at edges", "whole numbers", "slivers far away", "any floats", "denormals"};

static vec3_f32 corner_of(random_state *r, family f, vec3_f32 base) {
    switch (f) {
    case PLAIN:
    case EDGES: return point_in(r, 1);
    case WHOLE: return whole_point(r, 3);
    case SLIVERS: {
        float along = (float)random_in(r, -1, 1);
        vec3_f32 p = madd_f32(base, along, vec_f32(1, 0.7f, 0.3f));
        return add_f32(p, point_in(r, 1e-7));
    }
    case WILD: return wild_point(r);
    case TINY: return scale_f32(0x1p-140f, whole_point(r, 99));
    case FAMILIES: break;
    }
    return base;
}

static oracle_primitive shape_of(random_state *r, family f, oracle_shape shape) {
    oracle_primitive p = {.shape = shape};
    vec3_f32 base = f == SLIVERS ? point_in(r, 1e5) : vec_f32(0, 0, 0);
    for (int k = 0; k < 4; ++k) p.v[k] = corner_of(r, f, base);
    p.radius = fabsf(corner_of(r, f, base).x);
    /* As a world splits them: sums that double holds. */
    if (f == PLAIN)
        p.rest = scale_f32(0x1p-40f, whole_point(r, 8191)), p.radius_rest = 0x1p-40f * whole_in(r, 8191);
    return p;
}

/* Through a point of the shape: of a triangle on an edge for EDGES; of a sphere near the silhouette. */
static vec3_f64 target_of(random_state *r, family f, const oracle_primitive *p) {
    double u = random_in(r, -0.1, 1.1), v = f == EDGES ? 0 : random_in(r, -0.1, 1.1 - u);
    vec3_f64 t = madd_f64(scale_f64(1 - u - v, widen(p->v[0])), u, widen(p->v[1]));
    if (p->shape == ORACLE_SPHERE)
        return add_f64(widen(p->v[0]), scale_f64((double)p->radius, widen(point_in(r, 1))));
    return madd_f64(t, v, widen(p->v[2]));
}

static oracle_ray ray_at(random_state *r, family f, const oracle_primitive *p) {
    oracle_ray ray = {.t_near = 0, .t_far = INFINITY};
    ray.org = f == WILD ? wild_point(r) : f == WHOLE ? whole_point(r, 4) : point_in(r, 3);
    if (f == TINY) ray.org = scale_f32(0x1p-140f, whole_point(r, 99));
    vec3_f64 target = target_of(r, f, p);
    ray.dir = narrow(scale_f64(random_log(r, 1e-3, 1e3), sub_f64(target, widen(ray.org))));
    if (f == WHOLE) ray.dir = whole_point(r, 3);
    if (f == WILD && random_bits(r) % 4 == 0) ray.dir = wild_point(r);
    if (f == TINY && random_bits(r) % 2) ray.dir = scale_f32(0x1p-149f, whole_point(r, 9));
    if (random_bits(r) % 2) ray.t_near = (float)random_in(r, 0, 2), ray.t_far = ray.t_near + 1;
    if (f == WHOLE) ray.t_near = truncf(ray.t_near), ray.t_far = truncf(ray.t_far);
    return ray;
}

/* Any map, and the ray that it carries about where it was. */
static void place(random_state *r, family f, world_instance *instance, oracle_ray *ray, oracle_primitive *p) {
    affine_f64 map, inverse;
    memset(instance, 0, sizeof *instance);
    for (int k = 0; k < 12; ++k) {
        float x = f == WILD ? wild(r) : f == WHOLE ? whole_in(r, 2) : (float)random_in(r, -2, 2);
        instance->to_object[k / 4][k % 4] = x, map.m[k / 4][k % 4] = (double)x;
    }
    p->instance = instance;
    if (f == WHOLE || f == WILD || !affine_invert(&map, &inverse)) return;
    if (f == TINY) {
        for (int i = 0; i < 3; ++i) instance->to_object[i][3] = 0, inverse.m[i][3] = 0;
    }
    for (int k = 0; k < 12; ++k) instance->to_world[k / 4][k % 4] = (float)inverse.m[k / 4][k % 4];
    ray->org = narrow(affine_point(&inverse, widen(ray->org)));
    ray->dir = narrow(affine_vector(&inverse, widen(ray->dir)));
}

static void run_family(family f, bool in_instance) {
    static const oracle_shape shapes[] = {ORACLE_SPHERE, ORACLE_TRIANGLE, ORACLE_QUAD, ORACLE_PLANE};
    for (unsigned s = 0; s < 4; ++s) {
        random_state r = {(uint64_t)f * 8 + s + (in_instance ? 1000u : 0u)};
        tally count = {0};
        for (int i = 0; i < 2000; ++i) {
            world_instance instance;
            oracle_primitive p = shape_of(&r, f, shapes[s]);
            oracle_ray ray = ray_at(&r, f, &p);
            if (in_instance) place(&r, f, &instance, &ray, &p);
            check(&ray, &p, &count);
        }
        static const char *const names[] = {"sphere", "triangle", "quad", "plane"};
        print_message("%-18s%-10s%-9s asked %d, hits %d, parallel %d\n", family_names[f], names[s],
                      in_instance ? "instance" : "", count.asked, count.hits, count.parallel);
        assert_true(count.hits > 0 || f == WILD || (f == SLIVERS && in_instance)); /* rounding moves it off */
    }
}

UNIT_TEST(rational_numbers_agree) {
    for (int f = 0; f < FAMILIES; ++f) {
        run_family((family)f, false);
        run_family((family)f, true);
    }
}

/* Tracers run with denormals flushed; the oracle is asked from the same threads. */
UNIT_TEST(a_thread_that_flushes_denormals_gets_the_same_answers) {
    random_state r = {77};
    int hits = 0;
    for (int i = 0; i < 4000; ++i) {
        oracle_primitive p = shape_of(&r, TINY, i % 2 ? ORACLE_SPHERE : ORACLE_TRIANGLE);
        oracle_ray ray = ray_at(&r, TINY, &p);
        oracle_answer plain, flushed;
        oracle_ask(&ray, &p, &plain);
        unsigned mode = trace_thread_begin();
        oracle_ask(&ray, &p, &flushed);
        volatile float least = 0x1p-149f, sum = least + least;
        uint32_t bits;
        memcpy(&bits, (const void *)&sum, sizeof bits);
        trace_thread_end(mode);
#if defined(__SSE2__)
        assert_int_equal(bits, 0); /* the mode was on, and is on again */
#endif
        assert_memory_equal(&plain, &flushed, sizeof plain);
        hits += plain.hit;
    }
    assert_true(hits > 100);
}

UNIT_TEST(pairs_are_ordered_alike) {
    random_state r = {5};
    int ties = 0;
    for (int i = 0; i < 20000; ++i) {
        family f = i % 2 ? WHOLE : PLAIN;
        static const oracle_shape shapes[] = {ORACLE_SPHERE, ORACLE_TRIANGLE, ORACLE_PLANE};
        oracle_pair a = {.primitive = shape_of(&r, f, shapes[random_bits(&r) % 3])};
        oracle_pair b = {.primitive = shape_of(&r, f, shapes[random_bits(&r) % 3])};
        oracle_ray ray = ray_at(&r, f, &a.primitive);
        oracle_ask(&ray, &a.primitive, &a.answer);
        oracle_ask(&ray, &b.primitive, &b.answer);
        if (!a.answer.line || !b.answer.line) continue;
        int order = oracle_compare(&ray, &a, &b);
        assert_int_equal(order, -oracle_compare(&ray, &b, &a));
        assert_int_equal(0, oracle_compare(&ray, &a, &a));
        ties += order == 0;
    }
    assert_true(ties > 20); /* whole numbers meet often */
}

/* A double that is rounded to float must be that float in all that follows: gcc 12's vectoriser of
 * straight-line code can keep the double (see src/CMakeLists.txt). Stores side by side, as in tracers and in
 * tests. */
static __attribute__((noinline)) void round_beside(const double *x, float *d, double *dd) {
    d[0] = (float)x[0], d[1] = (float)x[1];
    dd[0] = (double)d[0], dd[1] = (double)d[1];
}

UNIT_TEST(rounding_to_float_is_kept) {
    random_state r = {9};
    for (int i = 0; i < 1000; ++i) {
        double x[2] = {random_in(&r, -1, 1), random_in(&r, -1, 1)}, dd[2];
        float d[2];
        round_beside(x, d, dd);
        volatile float low = (float)x[0], high = (float)x[1];
        assert_true(dd[0] == (double)low && dd[1] == (double)high);
        oracle_primitive plane = {.shape = ORACLE_PLANE, .v = {{0, 0, 0}, {1, 0, 0}}};
        oracle_ray ray = {{d[0], 0, 0}, {-d[0], 0, 0}, 0, INFINITY};
        oracle_answer answer;
        oracle_ask(&ray, &plane, &answer);
        assert_true(answer.t == 1);
    }
}

/* ---- whole numbers ---- */

/* Numbers stay in the room they have: GMP, which ends the process when memory runs out, never asks for any.
 */
static void *no_allocation(size_t bytes) {
    fail_msg("GMP asks for %zu bytes", bytes);
    return NULL;
}
static void *no_reallocation(void *at, size_t old, size_t bytes) {
    (void)at, (void)old;
    return no_allocation(bytes);
}

static int order_of(const oracle_ray *ray, const oracle_primitive *p, unsigned i, const oracle_primitive *q,
                    unsigned k) {
    exact_root x, y;
    exact_root_of(ray, p, i, &x), exact_root_of(ray, q, k, &y);
    return exact_root_compare(&x, &y);
}

/* Both roots of both spheres; both are met. */
static void order_both_ways(const oracle_ray *ray, const oracle_primitive *p, const oracle_primitive *q) {
    oracle_answer a, b;
    oracle_ask(ray, p, &a), oracle_ask(ray, q, &b);
    assert_true(a.line && b.line && promises_kept(&a) && promises_kept(&b));
    for (unsigned i = 0; i < 2; ++i) {
        for (unsigned k = 0; k < 2; ++k) {
            const int order = order_of(ray, p, i, q, k);
            assert_int_equal(order, -order_of(ray, q, k, p, i));
            if (i != k) assert_int_equal(order, i ? 1 : -1);
        }
    }
}

/* The longest numbers there are: both ends of float's range in one scene, in an instance. */
UNIT_TEST(extremes_stay_within_the_numbers) {
    mp_set_memory_functions(no_allocation, no_reallocation, NULL);
    const float huge = 0x1.fffffep127f, least = 0x1p-149f;
    /* Origins and centres near (huge, huge, huge), 2^-298 the last digit of both: from inside. */
    world_instance inner = {.group = 0};
    for (int k = 0; k < 12; ++k) inner.to_object[k / 4][k % 4] = k % 4 == 3 || k % 5 == 0 ? huge : least;
    oracle_primitive a = {
        .shape = ORACLE_SPHERE, .v = {{huge, huge, huge}}, .radius = huge, .instance = &inner};
    oracle_primitive b = a;
    b.v[0].y = 0x1.fffffcp127f, b.v[0].z = least;
    oracle_ray ray = {{least, -least, least}, {huge, least, -huge}, least, huge};
    order_both_ways(&ray, &a, &a);
    order_both_ways(&ray, &a, &b);
    /* From huge² + least² straight at the centre. */
    world_instance outer = {.group = 0, .to_object = {{huge, least}}};
    oracle_primitive c = {.shape = ORACLE_SPHERE, .v = {{least, 0, 0}}, .radius = huge, .instance = &outer};
    oracle_primitive d = c;
    d.v[0].x = -least, d.v[0].z = least;
    oracle_ray from_far = {{huge, least, 0}, {-huge, least, 0}, least, huge};
    order_both_ways(&from_far, &c, &c);
    order_both_ways(&from_far, &c, &d);
    mp_set_memory_functions(NULL, NULL, NULL);
}

int main(void) { return unit_main(NULL, NULL); }
