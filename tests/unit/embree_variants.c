/* Embree every way it can answer: shapes of its own and ours, flags, qualities and widths. */
#include "specs.h"
#include "stage.h"

#include <sys/wait.h>
#include <unistd.h>

typedef struct visit {
    stage *s;
    const ray_set *rays;
    ray_set closest; /* the linear search's */
    unsigned char *any;
    size_t tracers, allowed;
} visit;

/* ---- no call hangs: first, because a child wants no threads in its parent ---- */

static void trace_coherent(void *user, const char *text) {
    visit *v = user;
    if (!strstr(text, ":medium:") && !strstr(text, ":triangles:robust:")) return;
    trace_tracer *tracer = stage_spec(v->s, text);
    occluded(tracer, v->rays, TRACE_COHERENT);
    traced(tracer, v->rays, TRACE_COHERENT);
}

/* Debian 12's Embree has kernels for coherent shadow rays that may never return. In a child with a time
 * limit: 40,000 triangles alone, and every shape behind instances. */
UNIT_TEST(no_call_hangs) {
    for (int i = 0; i < 2; ++i) {
        fflush(NULL);
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            alarm(100);
            stage s = stage_open();
            if (i)
                add_everything(&s);
            else
                add_ball(&s, FATHOM_ROOT, 101, 0.05, 1, 0, 0);
            stage_world(&s);
            ray_set set = random_rays(2000);
            visit v = {.s = &s, .rays = &set};
            specs_each(trace_coherent, &v);
            _exit(0);
        }
        int status = -1;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    }
}

/* ---- the listed ones ---- */

/* A ray may differ where Embree's float comes within reach of an edge or a silhouette: `allowed` of them. */
static void agrees(void *user, const char *text) {
    visit *v = user;
    trace_tracer *tracer = stage_spec(v->s, text);
    for (trace_coherence c = TRACE_INCOHERENT; c <= TRACE_COHERENT; ++c) {
        ray_set got = traced(tracer, v->rays, c);
        unsigned char *any = occluded(tracer, v->rays, c);
        size_t differ = 0, far = 0;
        for (size_t i = 0; i < v->rays->count; ++i) {
            bool same = same_hit(&got, &v->closest, i);
            differ += !same || any[i] != v->any[i];
            float t = hit_t(&got, i), right = hit_t(&v->closest, i);
            far += same && right < INFINITY && fabsf(t - right) > 0x1p-14f * right;
        }
        /* The window of embree_settle.c, in which every t lies but of rays that graze: as rare as edges. */
        if (differ > v->allowed || far > v->allowed) {
            fail_msg("%s, coherence %d: %zu hits and %zu distances of %zu differ", text, c, differ, far,
                     v->rays->count);
        }
    }
    ++v->tracers;
}

/* Random rays come within float's reach of an edge or a silhouette once in some 10^4. */
UNIT_TEST(all_agree_with_linear) {
    stage s = stage_open();
    add_everything(&s);
    trace_tracer *linear = stage_spec(&s, "linear");
    ray_set set = random_rays(fewer(1203));
    visit v = {.s = &s, .rays = &set, .allowed = 2};
    v.closest = traced(linear, &set, TRACE_COHERENT), v.any = occluded(linear, &set, TRACE_COHERENT);
    specs_each(agrees, &v);
    assert_int_equal(v.tracers, 2 * 3 * 3 * 4 * 2);
}

/* ---- user geometry ---- */

/* Our intersectors in Embree's robust traversal miss nothing and settle every tie: linear search, bit by bit,
 * also where rays are aimed at edges and vertices. (Behind instances Embree carries the rays, in arithmetic
 * of its own.) */
UNIT_TEST(user_geometry_is_linear_search) {
    static const char *const specs[] = {"embree:user", "embree:user:1:high", "embree:user:8:low"};
    stage s = stage_open();
    add_ball(&s, FATHOM_ROOT, 20, 0.05, 0.9, 0, 0);
    add_ball(&s, FATHOM_ROOT, 20, 0.05, 0.9, 0, 0);
    add_grid(&s, 20, -0.5);
    for (int i = 0; i < 12; ++i) {
        const double c[3] = {between(-2, 2), between(-2, 2), between(-2, 2)}, a = between(0, 6);
        const double u[3] = {0.4 * cos(a), 0.4 * sin(a), 0}, v[3] = {0, 0, between(0.1, 0.5)};
        add_sphere(&s, FATHOM_ROOT, c[1], c[2], c[0], between(0.05, 0.5), 0);
        add_quad(&s, FATHOM_ROOT, c, u, v, 0);
    }
    trace_tracer *linear = stage_spec(&s, "linear");
    ray_set sets[] = {random_rays(fewer(2000)), edge_rays(s.world, fewer(6000)), camera_rays(60)};
    for (size_t k = 0; k < 3; ++k) {
        trace_tracer *user = stage_spec(&s, specs[k]);
        for (size_t r = 0; r < 3; ++r) {
            ray_set u = traced(user, &sets[r], TRACE_COHERENT), l = traced(linear, &sets[r], TRACE_COHERENT);
            unsigned char *ua = occluded(user, &sets[r], TRACE_COHERENT);
            unsigned char *la = occluded(linear, &sets[r], TRACE_COHERENT);
            size_t differ = 0;
            for (size_t i = 0; i < sets[r].count; ++i) {
                differ += !same_hit(&u, &l, i) || hit_t(&u, i) != hit_t(&l, i) || ua[i] != la[i];
            }
            assert_int_equal(differ, 0);
        }
    }
}

/* Triangle 0 is good, the others hold a NaN, an infinity, or no area. */
UNIT_TEST(damaged_user_triangles_are_left_out) {
    static float p[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 0};
    static const uint32_t t[] = {0, 1, 2, 0, 1, 3, 1, 2, 4, 0, 0, 1};
    stage s = stage_open();
    fathom_mesh mesh = default_mesh();
    mesh.positions = p, mesh.vertex_count = 5, mesh.indices = t, mesh.triangle_count = 4;
    assert_ok(s.context, fathom_scene_add_mesh_shared(s.scene, FATHOM_ROOT, &mesh, NULL));
    p[9] = NAN, p[13] = INFINITY;
    trace_tracer *tracer = stage_spec(&s, "embree:user:16");
    ray_set set = rays_new(2);
    const double org[2][3] = {{0.5, 0.25, 5}, {-0.9, 0.9, 5}}, dir[3] = {0, 0, -1};
    for (size_t i = 0; i < 2; ++i) ray_set_to(&set, i, org[i], dir, INFINITY);
    ray_set got = traced(tracer, &set, TRACE_COHERENT);
    assert_true(hit_t(&got, 0) == 5 && got.blocks[0].hits.primitive[0] == 0);
    assert_int_equal(got.blocks[0].hits.geometry[1], FATHOM_NONE);
}

/* ---- raw answers ---- */

/* Away from ties, raw answers are the settled ones to the last bit. */
UNIT_TEST(raw_is_settled_but_for_ties) {
    static const char *const specs[] = {
        "embree:medium:raw:1",
        "embree:medium:raw:8",
        "embree:medium:raw:16",
    };
    stage s = stage_open();
    add_ball(&s, FATHOM_ROOT, 20, 0.05, 1, 0, 0);
    const fathom_id group = new_group(s.scene, "group");
    add_ball(&s, group, 8, 0.1, 0.5, 0, 0);
    const double move[12] = {-0.5, 0, 0, 2, 0, 1.5, 0, 0, 0, 0, 0.2, 0.5};
    add_instance(&s, group, move);
    trace_tracer *settled = stage_spec(&s, "embree:medium:1");
    ray_set set = random_rays(10007);
    ray_set right = traced(settled, &set, TRACE_INCOHERENT);
    unsigned char *any = occluded(settled, &set, TRACE_INCOHERENT);
    for (size_t k = 0; k < sizeof specs / sizeof *specs; ++k) {
        trace_tracer *raw = stage_spec(&s, specs[k]);
        for (trace_coherence c = TRACE_INCOHERENT; c <= TRACE_COHERENT; ++c) {
            ray_set got = traced(raw, &set, c);
            unsigned char *got_any = occluded(raw, &set, c);
            for (size_t i = 0; i < set.count; ++i) {
                assert_true(same_hit(&got, &right, i) && hit_t(&got, i) == hit_t(&right, i));
                assert_int_equal(got_any[i], any[i]);
            }
        }
    }
}

/* Lanes past the count keep every bit, and rays that are not finite miss. */
UNIT_TEST(lanes_are_apart) {
    static const char *const specs[] = {"embree:1",  "embree:4",      "embree:8",
                                        "embree:16", "embree:raw:16", "embree:user:4"};
    stage s = stage_open();
    add_ball(&s, FATHOM_ROOT, 10, 0, 1, 0, 0);
    for (size_t k = 0; k < sizeof specs / sizeof *specs; ++k) {
        trace_tracer *tracer = stage_spec(&s, specs[k]);
        for (size_t count = 0; count <= 16; ++count) {
            ray_set set = rays_new(16);
            memset(set.blocks, 0xa5, sizeof *set.blocks);
            const double org[3] = {0.1, 0.2, 5}, dir[3] = {0, 0, -1};
            for (size_t i = 0; i < count; ++i) ray_set_to(&set, i, org, dir, INFINITY);
            if (count > 2) set.blocks->rays.org_y[1] = NAN, set.blocks->rays.t_far[count - 1] = -1;
            if (count > 3) set.blocks->rays.dir_z[2] = INFINITY;
            trace_block before = *set.blocks;
            unsigned mode = trace_thread_begin();
            trace_closest(tracer, set.blocks, count, TRACE_COHERENT);
            trace_rays shadows = before.rays;
            trace_any(tracer, &shadows, count, TRACE_COHERENT);
            trace_thread_end(mode);
            for (size_t row = 0; row < sizeof before / sizeof(float) / 16; ++row) {
                size_t past = 16 * row + count;
                assert_memory_equal((float *)(void *)&before + past, (float *)(void *)set.blocks + past,
                                    (16 - count) * sizeof(float));
            }
            for (size_t i = 0; i < count; ++i) {
                bool none = count > 2 && (i == 1 || i == count - 1 || i == 2);
                assert_int_equal(set.blocks->hits.geometry[i], none ? FATHOM_NONE : 0);
                assert_true(shadows.t_far[i] == (none ? before.rays.t_far[i] : -INFINITY));
            }
        }
    }
}

/* The instruction set asked for is told. */
UNIT_TEST(instruction_sets) {
#if defined(__x86_64__)
    stage s = stage_open();
    add_ball(&s, FATHOM_ROOT, 10, 0, 1, 0, 0);
    trace_tracer *tracer = stage_spec(&s, "embree:16:sse2");
    assert_non_null(strstr(trace_name(tracer), ", SSE2"));
    ray_set set = random_rays(1000), got = traced(tracer, &set, TRACE_COHERENT);
    tracer = stage_spec(&s, "embree:16");
    ray_set best = traced(tracer, &set, TRACE_COHERENT);
    for (size_t i = 0; i < set.count; ++i) assert_true(same_hit(&got, &best, i));
#endif
}

int main(void) { return unit_main(NULL, NULL); }
