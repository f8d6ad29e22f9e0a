/* The oracle's two ways of computing against each other on hard random cases, its whole numbers against GMP's
 * own, and all of it with denormals flushed and under the flags that it ships with. */
#include "math/affine.h"
#include "random.h"
#include "trace/trace.h"
#include "unit.h"
#include "verify/exact/exact.h"

typedef struct tally {
    int asked, hits, exact, parallel;
} tally;

static bool overlap(ball a, ball b) {
    if (a.value == b.value) return true; /* infinities too */
    return (long double)abs_f128(a.value - b.value) <= (a.error + b.error) * (1 + 0x1p-50L);
}

static bool answers_agree(const oracle_answer *a, const oracle_answer *b) {
    if (a->hit != b->hit || a->line != b->line || a->parallel != b->parallel) return false;
    if (a->parallel) return true;
    if (a->line && a->part != b->part) return false;
    /* Which part of a quad was missed less is told to the promised 2^-40 of both. */
    if (!a->line && a->part != b->part) {
        real_f128 apart = abs_f128(a->edge.value - b->edge.value);
        return apart <= abs_f128(a->edge.value) * (real_f128)0x1p-38;
    }
    bool same = overlap(a->t, b->t) && overlap(a->other, b->other) && overlap(a->edge, b->edge) &&
                overlap(a->above_near, b->above_near) && overlap(a->below_far, b->below_far);
    for (int i = 0; i < 3; ++i) same = same && overlap(a->weight[i], b->weight[i]);
    return same;
}

static bool promises_kept(const oracle_answer *a) {
    if (a->parallel) return !a->hit;
    bool known = ball_known(a->t) && ball_known(a->edge) && ball_known(a->other);
    bool inside = a->above_near.value > 0 && a->below_far.value > 0;
    return known && ball_known(a->above_near) && ball_known(a->below_far) &&
           a->line == (a->edge.value >= 0) && a->hit == (a->line && inside);
}

static void check(const oracle_ray *ray, const oracle_primitive *p, tally *count) {
    oracle_answer fast, exact;
    oracle_ask(ray, p, ORACLE_FAST, &fast);
    oracle_ask(ray, p, ORACLE_EXACT, &exact);
    if (!answers_agree(&fast, &exact) || !promises_kept(&fast) || !promises_kept(&exact)) {
        fail_msg("shape %d: fast hit %d t %.17g edge %.17g, exact hit %d t %.17g edge %.17g\n"
                 "org %a %a %a dir %a %a %a t (%a, %a)",
                 (int)p->shape, fast.hit, (double)fast.t.value, (double)fast.edge.value, exact.hit,
                 (double)exact.t.value, (double)exact.edge.value, (double)ray->org.x, (double)ray->org.y,
                 (double)ray->org.z, (double)ray->dir.x, (double)ray->dir.y, (double)ray->dir.z,
                 (double)ray->t_near, (double)ray->t_far);
    }
    ++count->asked, count->hits += fast.hit, count->exact += fast.exact, count->parallel += fast.parallel;
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
        for (int i = 0; i < 4000; ++i) {
            world_instance instance;
            oracle_primitive p = shape_of(&r, f, shapes[s]);
            oracle_ray ray = ray_at(&r, f, &p);
            if (in_instance) place(&r, f, &instance, &ray, &p);
            check(&ray, &p, &count);
        }
        static const char *const names[] = {"sphere", "triangle", "quad", "plane"};
        print_message("%-18s%-10s%-9s asked %d, hits %d, parallel %d, whole numbers needed %.2f %%\n",
                      family_names[f], names[s], in_instance ? "instance" : "", count.asked, count.hits,
                      count.parallel, 100.0 * count.exact / count.asked);
        assert_true(count.hits > 0 || f == WILD || (f == SLIVERS && in_instance)); /* rounding moves it off */
        if (f == PLAIN) assert_true(count.exact < count.asked / 1000); /* the first way has 113 bits for 24 */
        if (f == WHOLE) assert_true(count.exact > 0);
    }
}

static void both_ways_agree(void **state) {
    (void)state;
    for (int f = 0; f < FAMILIES; ++f) {
        run_family((family)f, false);
        run_family((family)f, true);
    }
}

/* Tracers run with denormals flushed; the oracle is asked from the same threads. */
static void a_thread_that_flushes_denormals_gets_the_same_answers(void **state) {
    (void)state;
    random_state r = {77};
    int hits = 0;
    for (int i = 0; i < 4000; ++i) {
        oracle_primitive p = shape_of(&r, TINY, i % 2 ? ORACLE_SPHERE : ORACLE_TRIANGLE);
        oracle_ray ray = ray_at(&r, TINY, &p);
        oracle_answer plain, flushed;
        oracle_ask(&ray, &p, ORACLE_FAST, &plain);
        unsigned mode = trace_thread_begin();
        oracle_ask(&ray, &p, ORACLE_FAST, &flushed);
        volatile float least = 0x1p-149f, sum = least + least;
        uint32_t bits;
        memcpy(&bits, (const void *)&sum, sizeof bits);
        trace_thread_end(mode);
#if defined(__SSE2__)
        assert_int_equal(bits, 0); /* the mode was on, and is on again */
#endif
        assert_true(answers_agree(&plain, &flushed) && plain.exact == flushed.exact);
        hits += plain.hit;
    }
    assert_true(hits > 100);
}

static void pairs_are_ordered_alike(void **state) {
    (void)state;
    random_state r = {5};
    int ties = 0;
    for (int i = 0; i < 20000; ++i) {
        family f = i % 2 ? WHOLE : PLAIN;
        static const oracle_shape shapes[] = {ORACLE_SPHERE, ORACLE_TRIANGLE, ORACLE_PLANE};
        oracle_pair a = {.primitive = shape_of(&r, f, shapes[random_bits(&r) % 3])};
        oracle_pair b = {.primitive = shape_of(&r, f, shapes[random_bits(&r) % 3])};
        oracle_ray ray = ray_at(&r, f, &a.primitive);
        oracle_ask(&ray, &a.primitive, ORACLE_FAST, &a.answer);
        oracle_ask(&ray, &b.primitive, ORACLE_FAST, &b.answer);
        if (!a.answer.line || !b.answer.line) continue;
        int order = oracle_compare(&ray, &a, &b, ORACLE_FAST);
        assert_int_equal(order, oracle_compare(&ray, &a, &b, ORACLE_EXACT));
        assert_int_equal(order, -oracle_compare(&ray, &b, &a, ORACLE_EXACT));
        assert_int_equal(0, oracle_compare(&ray, &a, &a, ORACLE_EXACT));
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

static void rounding_to_float_is_kept(void **state) {
    (void)state;
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
        oracle_ask(&ray, &plane, ORACLE_FAST, &answer);
        assert_true(answer.t.value == 1);
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

/* Both roots of both spheres; both are met. */
static void order_both_ways(const oracle_ray *ray, const oracle_primitive *p, const oracle_primitive *q) {
    oracle_pair a = {.primitive = *p}, b = {.primitive = *q};
    oracle_ask(ray, p, ORACLE_EXACT, &a.answer);
    oracle_ask(ray, q, ORACLE_EXACT, &b.answer);
    assert_true(a.answer.line && b.answer.line && promises_kept(&a.answer) && promises_kept(&b.answer));
    for (unsigned part = 0; part < 4; ++part) {
        a.answer.part = part / 2, b.answer.part = part % 2;
        int order = oracle_compare(ray, &a, &b, ORACLE_EXACT);
        assert_int_equal(order, -oracle_compare(ray, &b, &a, ORACLE_EXACT));
        if (a.answer.part != b.answer.part) assert_int_equal(order, a.answer.part ? 1 : -1);
    }
}

/* The longest numbers there are: both ends of float's range in one scene, in an instance. */
static void extremes_stay_within_the_numbers(void **state) {
    (void)state;
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
}

int main(void) {
    mp_set_memory_functions(no_allocation, no_reallocation, NULL);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(both_ways_agree),
        cmocka_unit_test(a_thread_that_flushes_denormals_gets_the_same_answers),
        cmocka_unit_test(pairs_are_ordered_alike),
        cmocka_unit_test(rounding_to_float_is_kept),
        cmocka_unit_test(extremes_stay_within_the_numbers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
