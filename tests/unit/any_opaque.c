/* Any-hit queries that tell opaque surfaces from those that light may pass straight. */
#include "stage.h"

enum { SQUARES = 120 };

static const double as_it_is[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

typedef struct things {
    double center[SQUARES][3], u[SQUARES][3], v[SQUARES][3];
} things;

static void random_things(things *out) {
    for (int i = 0; i < SQUARES; ++i) {
        for (int k = 0; k < 3; ++k) {
            out->center[i][k] = between(-2, 2);
            out->u[i][k] = between(-0.4, 0.4), out->v[i][k] = between(-0.4, 0.4);
        }
    }
}

static fathom_id glassy(stage *s) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.opacity = 0.5f;
    return new_material(s->scene, "glassy", &m);
}

/* A mesh, because quads of one group are one geometry, and told together. */
static void put(stage *s, fathom_id group, const things *t, int i, fathom_id material) {
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    float corners[4][3];
    for (int k = 0; k < 3; ++k) {
        const double at = t->center[i][k], u = t->u[i][k], v = t->v[i][k];
        corners[0][k] = (float)(at - u - v), corners[1][k] = (float)(at + u - v);
        corners[2][k] = (float)(at + u + v), corners[3][k] = (float)(at - u + v);
    }
    fathom_mesh mesh = default_mesh();
    mesh.positions = corners[0], mesh.vertex_count = 4, mesh.indices = indices, mesh.triangle_count = 2;
    mesh.material = material;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, group, &mesh, NULL));
}

/* A third is opaque, a third is not, and a third is in a group, which is placed once as it is, and once with
 * a material that is not opaque. */
static stage all_of(const things *t, bool placed) {
    const double there[12] = {0.6, -0.8, 0, 0.1, 0.8, 0.6, 0, 0.2, 0, 0, 1, 0};
    stage s = stage_open();
    const fathom_id clear = glassy(&s), group = placed ? new_group(s.scene, "things") : FATHOM_ROOT;
    for (int i = 0; i < SQUARES; ++i)
        put(&s, i % 3 == 2 ? group : FATHOM_ROOT, t, i, i % 3 == 1 || (i % 3 && !placed) ? clear : 0);
    fathom_instance instance = default_instance();
    instance.group = group, instance.material = clear;
    memcpy(instance.transform, there, sizeof there);
    if (placed) assert_ok(s.context, fathom_scene_add_instance(s.scene, &instance, NULL));
    return s;
}

static stage opaque_of(const things *t) {
    stage s = stage_open();
    for (int i = 0; i < SQUARES; i += 3) put(&s, FATHOM_ROOT, t, i, 0);
    return s;
}

static trace_tracer *telling(stage *s, unsigned width) {
    const trace_options options = {.words = "embree", .width = width, .threads = 2, .tell_opaque = true};
    trace_tracer *tracer;
    assert_ok(s->context, trace_create(s->context, stage_world(s), &options, &tracer));
    return own_tracer(tracer);
}

static float *ends_of(const trace_tracer *tracer, const ray_set *set, trace_coherence coherence) {
    const size_t blocks = (set->count + 15) / 16;
    trace_rays *rays = aligned_alloc(64, blocks * sizeof *rays);
    float *ends = unit_memory(set->count * sizeof *ends);
    assert_non_null(rays);
    for (size_t b = 0; b < blocks; ++b) rays[b] = set->blocks[b].rays;
    const unsigned state = trace_thread_begin();
    trace_any(tracer, rays, set->count, coherence);
    trace_thread_end(state);
    for (size_t i = 0; i < set->count; ++i) ends[i] = rays[i / 16].t_far[i % 16];
    free(rays);
    return ends;
}

/* stopped, met: by rays, what stops all light, and what lets some pass. */
static void expect_ends(const trace_tracer *tracer, const ray_set *set, trace_coherence coherence,
                        const unsigned char *stopped, const unsigned char *met) {
    const float *ends = ends_of(tracer, set, coherence);
    size_t count[3] = {0};
    for (size_t i = 0; i < set->count; ++i) {
        const float expected = stopped[i] ? -INFINITY : met[i] ? TRACE_NOT_OPAQUE : INFINITY;
        if (ends[i] != expected) fail_msg("ray %zu: %g, expected %g", i, (double)ends[i], (double)expected);
        ++count[stopped[i] ? 0 : met[i] ? 1 : 2];
    }
    for (int k = 0; k < 3; ++k) assert_true(count[k] > set->count / 60);
}

static void expect_told(bool placed) {
    static things t;
    seed = 88172645463325252u;
    random_things(&t);
    stage whole = all_of(&t, placed), opaque = opaque_of(&t);
    const ray_set set = random_rays(fewer(20003));
    const unsigned char *stopped = occluded(stage_embree(&opaque, 1), &set, TRACE_INCOHERENT),
                        *met = occluded(stage_embree(&whole, 1), &set, TRACE_INCOHERENT);
    for (unsigned width = 1; width <= 16; width *= width == 1 ? 4 : 2) {
        const trace_tracer *tracer = telling(&whole, width);
        assert_true(trace_tells_opaque(tracer));
        for (int k = 0; k < 2; ++k)
            expect_ends(tracer, &set, k ? TRACE_COHERENT : TRACE_INCOHERENT, stopped, met);
    }
}

/* Embree traces packets over instances by other kernels. */
UNIT_TEST(opaque_surfaces_are_told_from_others) {
    expect_told(false);
    expect_told(true);
}

/* ---- where light passes ---- */

/* By i % 4: opaque, passes some, none, all; the latter two are known by triangle, or only by point. */
enum { OPAQUE, SOME, NONE, EVERYTHING };
static const uint8_t by_kind[4] = {TRACE_PASSES_SOME, TRACE_PASSES_SOME, TRACE_PASSES_NONE, TRACE_PASSES_ALL};

/* By geometry, since each square is a mesh. */
static trace_passes at(const void *user, uint32_t geometry, uint32_t triangle, uint32_t instance, float u,
                       float v) {
    const world *w = user;
    const bool in_group = geometry >= w->groups.items[0].count;
    const uint32_t square = world_object(w, geometry, 0);
    const bool right =
        triangle < 2 && in_group == (instance != FATHOM_NONE) && u >= 0 && v >= 0 && u + v <= 1.001f;
    return right ? by_kind[square % 4] : TRACE_PASSES_SOME;
}

static stage kinds_of(const things *t, unsigned kinds, bool placed) {
    stage s = stage_open();
    const fathom_id clear = glassy(&s), group = placed ? new_group(s.scene, "things") : FATHOM_ROOT;
    for (int i = 0; i < SQUARES; ++i)
        if (kinds >> i % 4 & 1)
            put(&s, i < SQUARES / 2 ? FATHOM_ROOT : group, t, i, i % 4 == OPAQUE ? 0 : clear);
    if (placed) add_instance(&s, group, as_it_is);
    return s;
}

static void expect_known(bool placed, bool triangles) {
    static things t;
    static const uint8_t *known[SQUARES];
    static uint8_t of[SQUARES][2];
    seed = 88172645463325252u;
    random_things(&t);
    stage whole = kinds_of(&t, 15, placed), stops = kinds_of(&t, 1 << OPAQUE | 1 << NONE, placed),
          some = kinds_of(&t, 1 << SOME, placed);
    const ray_set set = random_rays(fewer(20003));
    const unsigned char *stopped = occluded(stage_embree(&stops, 1), &set, TRACE_INCOHERENT),
                        *met = occluded(stage_embree(&some, 1), &set, TRACE_INCOHERENT);
    const world *w = stage_world(&whole);
    for (uint32_t g = 0; g < SQUARES; ++g) {
        of[g][0] = of[g][1] = by_kind[world_object(w, g, 0) % 4];
        known[g] = g % 8 ? of[g] : NULL;
    }
    for (unsigned width = 1; width <= 16; width *= width == 1 ? 4 : 2) {
        trace_tracer *tracer = telling(&whole, width);
        trace_know_passing(tracer, &(trace_passing){triangles ? known : NULL, at, w});
        expect_ends(tracer, &set, TRACE_INCOHERENT, stopped, met);
    }
}

UNIT_TEST(surfaces_stop_rays_where_no_light_passes_and_are_skipped_where_all_does) {
    for (int k = 0; k < 4; ++k) expect_known(k & 1, k & 2);
}

/* ---- spheres, quads and planes ---- */

/* Spheres and quads, some of them opaque, and a plane that is not. opaque, clear: whether these are there.
 * placed: in a group. */
static stage shapes_of(const things *t, unsigned spheres, bool opaque, bool clear, bool placed) {
    stage s = stage_open();
    const fathom_id group = placed ? new_group(s.scene, "shapes") : FATHOM_ROOT;
    const fathom_id pane = glassy(&s);
    fathom_sphere sphere = default_sphere();
    fathom_plane plane = default_plane();
    sphere.radius = 0.3, plane.material = pane, plane.point[2] = -4;
    for (unsigned i = 0; i < SQUARES; ++i) {
        fathom_quad quad = default_quad();
        fathom_quad_from_axes(t->center[i], t->u[i], t->v[i], &quad);
        quad.material = sphere.material = i % 4 ? 0 : pane;
        memcpy(sphere.center, t->center[SQUARES - 1 - i], sizeof sphere.center);
        if (!(i % 4 ? opaque : clear)) continue;
        if (i < spheres) assert_ok(s.context, fathom_scene_add_sphere(s.scene, group, &sphere, NULL));
        if (i < 20) assert_ok(s.context, fathom_scene_add_quad(s.scene, group, &quad, NULL));
    }
    if (clear) assert_ok(s.context, fathom_scene_add_plane(s.scene, FATHOM_ROOT, &plane, NULL));
    if (placed) add_instance(&s, group, as_it_is);
    return s;
}

/* A plane, and one of few spheres, may end a ray before an opaque surface that lies behind. */
static void expect_shapes(unsigned spheres, bool placed) {
    static things t;
    seed = 88172645463325252u;
    random_things(&t);
    stage whole = shapes_of(&t, spheres, true, true, placed),
          opaque = shapes_of(&t, spheres, true, false, placed),
          clear = shapes_of(&t, spheres, false, true, placed);
    const ray_set set = random_rays(fewer(20003));
    const unsigned char *stopped = occluded(stage_embree(&opaque, 1), &set, TRACE_INCOHERENT),
                        *met = occluded(stage_embree(&clear, 1), &set, TRACE_INCOHERENT);
    for (unsigned width = 1; width <= 16; width *= 4) {
        const trace_tracer *tracer = telling(&whole, width);
        const float *ends = ends_of(tracer, &set, TRACE_INCOHERENT);
        size_t count[4] = {0};
        assert_true(trace_tells_opaque(tracer));
        for (size_t i = 0; i < set.count; ++i) {
            const bool either = stopped[i] && met[i] && ends[i] == TRACE_NOT_OPAQUE;
            const float expected = either || (met[i] && !stopped[i]) ? TRACE_NOT_OPAQUE
                                   : stopped[i]                      ? -INFINITY
                                                                     : INFINITY;
            if (ends[i] != expected)
                fail_msg("ray %zu: %g, expected %g", i, (double)ends[i], (double)expected);
            ++count[2 * stopped[i] + met[i]];
        }
        for (int k = 0; k < 4; ++k) assert_true(count[k] > set.count / 60);
    }
}

/* Few spheres are not in Embree's trees, many are. */
UNIT_TEST(shapes_are_told_apart) {
    expect_shapes(9, false);
    expect_shapes(40, false);
    expect_shapes(40, true);
}

/* Hand-written intersectors of quads do not tell; neither does a tracer that nobody asks. */
UNIT_TEST(quads_that_are_not_embrees_own_are_not_told_apart) {
    for (int k = 0; k < 2; ++k) {
        stage s = stage_open();
        fathom_quad quad = default_quad();
        const trace_options options = {.words = "embree:user", .threads = 2, .tell_opaque = true};
        trace_tracer *tracer;
        if (k) quad.material = glassy(&s);
        assert_ok(s.context, fathom_scene_add_quad(s.scene, FATHOM_ROOT, &quad, NULL));
        assert_ok(s.context, trace_create(s.context, stage_world(&s), &options, &tracer));
        assert_true(trace_tells_opaque(own_tracer(tracer)) == (k == 0));
        assert_false(trace_tells_opaque(stage_embree(&s, 1)));
    }
}

int main(void) { return unit_main(NULL, NULL); }
