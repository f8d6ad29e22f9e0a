/* Meshes that are placed once lie in the world itself: which do, that nothing of them changes, and that they
 * look as they do in a frame. */
#include "scene/world/world.h"
#include "worlds.h"

#include "render.h"

static const float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.25f},
                   normals[12] = {0, 0, 1, 0, 0.6f, 0.8f, 0.6f, 0, 0.8f, 0, 0, 3},
                   tangents[16] = {1, 0, 0, 1, 0, 0.8f, -0.6f, -1, 0.8f, 0, -0.6f, 1, 1, 0, 0, -1};
static const uint32_t indices[9] = {0, 1, 2, 1, 3, 2, 0, 1, 4};

static fathom_mesh two_triangles(void) {
    fathom_mesh mesh = default_mesh();
    mesh.positions = positions, mesh.normals = normals, mesh.tangents = tangents;
    mesh.vertex_count = mesh.normal_count = 4;
    mesh.indices = indices, mesh.triangle_count = 2;
    return mesh;
}

static void place(stage *s, fathom_instance *instance, fathom_id group, fathom_id parent,
                  const affine_f64 *map, fathom_id *id) {
    instance->group = group, instance->parent = parent;
    for (int i = 0; i < 12; ++i) instance->transform[i] = map->m[i / 4][i % 4];
    assert_ok(s->context, fathom_scene_add_instance(s->scene, instance, id));
}

static fathom_id add_group(stage *s) {
    const fathom_id id = new_group(s->scene, NULL);
    return id;
}

static affine_f64 turned(double scale, vec3_f64 to) {
    const affine_f64 turn = affine_rotation_axis((vec3_f64){1, 2, -3}, 1),
                     larger = affine_scaling((vec3_f64){scale, scale, scale}), move = affine_translation(to);
    const affine_f64 both = affine_compose(&larger, &turn);
    return affine_compose(&move, &both);
}

/* Half a unit in the last place of what is rounded, and some of double. */
static void assert_vector(const float *found, vec3_f64 expected) {
    const double e[3] = {expected.x, expected.y, expected.z};
    for (int k = 0; k < 3; ++k) assert_near((double)found[k], e[k], 0x1.01p-24 * fmax(fabs(e[k]), 0x1p-20));
}

UNIT_TEST(a_mesh_placed_once_is_carried) {
    stage s = stage_open(8, 8);
    const fathom_id outer = add_group(&s), inner = add_group(&s), red = stage_lambert(&s, 0.5f);
    fathom_mesh mesh = two_triangles();
    mesh.origin[0] = 0.5, mesh.origin[2] = -2;
    assert_ok(s.context, fathom_scene_add_mesh(s.scene, inner, &mesh, NULL));
    const affine_f64 first = turned(2, (vec3_f64){3, 0, 1}), second = turned(0.75, (vec3_f64){-1, 4, 0}),
                     origin = affine_translation(load_f64(mesh.origin));
    fathom_instance instance = default_instance();
    fathom_id ids[2];
    place(&s, &instance, inner, outer, &first, &ids[0]);
    instance.material = red;
    place(&s, &instance, outer, FATHOM_ROOT, &second, &ids[1]);
    world *w = new_world(s.scene);
    assert_int_equal(w->instances.count, 0);
    assert_int_equal(w->geometries.count, 1);
    assert_int_equal(w->geometries.items[0].instance, ids[0]);
    assert_int_equal(world_material(w, 0, 1, FATHOM_NONE), red);
    assert_int_equal(w->carried_bytes, 4 * (3 + 3 + 4) * sizeof(float));
    const fathom_mesh *made = world_mesh(w, 0);
    const affine_f64 both = affine_compose(&second, &first), map = affine_compose(&both, &origin);
    for (size_t i = 0; i < 4; ++i) {
        const vec3_f64 n = widen(load_f32(normals + 3 * i)), t = widen(load_f32(tangents + 4 * i));
        assert_vector(mesh_vertex(made, i), affine_point(&map, widen(load_f32(positions + 3 * i))));
        assert_vector(mesh_row(made->normals, made->normal_stride, i),
                      scale_f64(1 / 1.5, affine_vector(&map, n)));
        const float *tangent = mesh_row(made->tangents, made->tangent_stride, i);
        assert_vector(tangent, scale_f64(1 / 1.5, affine_vector(&map, t)));
        assert_true(tangent[3] == tangents[4 * i + 3]);
    }
}

/* Normals go by the inverse map transposed: across the surface as before. */
UNIT_TEST(normals_of_stretched_meshes_stay_across) {
    stage s = stage_open(8, 8);
    const fathom_id group = add_group(&s);
    fathom_mesh mesh = two_triangles();
    static const float across[12] = {0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 2};
    mesh.normals = across;
    assert_ok(s.context, fathom_scene_add_mesh(s.scene, group, &mesh, NULL));
    const affine_f64 turn = turned(1.5, (vec3_f64){0.5, 0, 1});
    affine_f64 uneven = affine_identity();
    uneven.m[0][0] = 3, uneven.m[0][2] = 0.7, uneven.m[1][0] = -0.4;
    const affine_f64 map = affine_compose(&turn, &uneven);
    fathom_instance instance = default_instance();
    place(&s, &instance, group, FATHOM_ROOT, &map, NULL);
    world *w = new_world(s.scene);
    assert_int_equal(w->instances.count, 0);
    const fathom_mesh *made = world_mesh(w, 0);
    const vec3_f64 p = widen(load_f32(mesh_vertex(made, 0))),
                   side = sub_f64(widen(load_f32(mesh_vertex(made, 1))), p),
                   other = sub_f64(widen(load_f32(mesh_vertex(made, 2))), p);
    const vec3_f64 flat = normalize_f64(cross_f64(side, other));
    for (size_t i = 0; i < 3; ++i) {
        const vec3_f64 n = widen(load_f32(mesh_row(made->normals, made->normal_stride, i))),
                       t = widen(load_f32(mesh_row(made->tangents, made->tangent_stride, i)));
        assert_near(dot_f64(normalize_f64(n), flat), 1, 1e-6);
        if (i == 0) assert_near(dot_f64(normalize_f64(t), normalize_f64(side)), 1, 1e-6);
    }
}

/* ---- what keeps its frame ---- */

enum {
    MIRRORED = 1,
    TWICE = 2,
    MOVING = 4,
    SPHERE = 8,
    POINTS = 16,
    KEYS = 32,
    SHARED = 64,
    SLIVER = 128,
    MAPPED = 256, /* has texture coordinates and no tangents */
    SECOND = 512, /* and a second set */
    FLAT = 1024,  /* the normals of a triangle are one */
};

typedef struct trial {
    unsigned what;
    double scale, far;    /* far: where the group stands */
    double stretch, skew; /* of the map, from an even one */
    bool carried;
} trial;

static void add_trial_mesh(stage *s, const trial *t, fathom_id group) {
    static const double times[2] = {0, 1};
    static const float flat[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    float many[30];
    fathom_mesh mesh = two_triangles();
    if (t->what & (POINTS | KEYS | SHARED | SLIVER))
        mesh.normals = mesh.tangents = NULL, mesh.normal_count = 0;
    if (t->what & (MAPPED | SECOND)) mesh.uvs = positions, mesh.uv_count = 4;
    if (t->what & MAPPED) mesh.tangents = NULL;
    if (t->what & FLAT) mesh.normals = flat;
    if (t->what & SECOND) mesh.uvs_1 = positions;
    if (t->what & POINTS) mesh.indices = NULL, mesh.triangle_count = 0, mesh.point_radius = 0.1f;
    for (int i = 0; i < 30; ++i) many[i] = positions[i % 12] + (i < 12 ? 0 : 0.5f);
    if (t->what & KEYS) mesh.key_count = 2, mesh.key_times = times, mesh.key_positions = many;
    if (t->what & SHARED) mesh.positions = many, mesh.vertex_count = t->carried ? 8 : 9;
    if (t->what & SLIVER) {
        many[12] = 0.5f, many[13] = t->carried ? 1e-3f : 1e-9f, many[14] = 0;
        mesh.positions = many, mesh.vertex_count = 5, mesh.triangle_count = 3;
    }
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, group, &mesh, NULL));
}

static void place_trial(stage *s, const trial *t, fathom_id group) {
    static const double times[2] = {0, 1};
    affine_f64 map = turned(t->scale, (vec3_f64){t->far, 0, 0}), uneven = affine_identity();
    if (t->what & MIRRORED) uneven.m[1][1] = -1;
    uneven.m[2][2] += t->stretch, uneven.m[0][1] = t->skew;
    map = affine_compose(&map, &uneven);
    fathom_instance instance = default_instance();
    double keys[24];
    for (int i = 0; i < 24; ++i) keys[i] = map.m[i / 4 % 3][i % 4] + (i == 15);
    if (t->what & MOVING) instance.key_count = 2, instance.key_times = times, instance.key_transforms = keys;
    place(s, &instance, group, FATHOM_ROOT, &map, NULL);
    if (t->what & TWICE) place(s, &instance, group, FATHOM_ROOT, &uneven, NULL);
}

static void run_trial(const trial *t) {
    stage s = stage_open(8, 8);
    const fathom_id group = add_group(&s);
    s.scene->camera.shutter[1] = 1;
    add_trial_mesh(&s, t, group);
    fathom_sphere sphere = default_sphere();
    if (t->what & SPHERE) assert_ok(s.context, fathom_scene_add_sphere(s.scene, group, &sphere, NULL));
    place_trial(&s, t, group);
    world *w;
    const vec3_f64 zero = {0, 0, 0};
    assert_ok(s.context, world_create_from(s.scene, &zero, &w));
    if ((w->instances.count == 0) != t->carried || (w->carried_bytes > 0) != t->carried)
        fail_msg("what %u scale %g far %g stretch %g skew %g: carried %d", t->what, t->scale, t->far,
                 t->stretch, t->skew, !t->carried);
    assert_int_equal(w->geometries.count, t->what & SPHERE ? 2 : 1);
    assert_int_equal(w->meshes.count, 1);
    world_destroy(w);
}

/* The mesh has a radius of 0.72, and a farthest corner at 1.4. */
UNIT_TEST(some_meshes_keep_their_frames) {
    static const trial trials[] = {{0, 1, 0, 0, 0, true},
                                   {0, 4000, 0, 0, 0, true},
                                   {0, 4200, 0, 0, 0, false},
                                   {0, 1 / 4000.0, 0, 0, 0, true},
                                   {0, 1 / 4200.0, 0, 0, 0, false},
                                   {0, 1, 42, 0, 0, true},
                                   {0, 1, 50, 0, 0, false},
                                   {FLAT, 1, 0, 3, 0, true},
                                   {FLAT, 1, 0, -0.9, 0, true},
                                   {FLAT, 1, 0, 0, 2, true},
                                   {FLAT, 1, 0, 0, 80, false},
                                   {FLAT, 1, 20, -0.9, 0, false},
                                   {FLAT, 100, 0, 50, 0, false},
                                   {0, 1, 0, 0x1p-20, 0, true},
                                   {0, 1, 0, 0x1p-16, 0, false},
                                   {FLAT | MAPPED, 1, 0, 0x1p-20, 0, true},
                                   {FLAT | MAPPED, 1, 0, 0x1p-16, 0, false},
                                   {FLAT | MAPPED, 1, 0, 0, 0x1p-20, true},
                                   {FLAT | MAPPED, 1, 0, 0, 0x1p-16, false},
                                   {SECOND, 1, 0, 0, 0, true},
                                   {FLAT | SECOND, 1, 0, 1, 0, false},
                                   {MIRRORED, 1, 0, 0, 0, false},
                                   {TWICE, 1, 0, 0, 0, false},
                                   {MOVING, 1, 0, 0, 0, false},
                                   {SPHERE, 1, 0, 0, 0, false},
                                   {POINTS, 1, 0, 0, 0, false},
                                   {KEYS, 1, 0, 0, 0, false},
                                   {SHARED, 1, 0, 0, 0, true},
                                   {SHARED, 1, 0, 0, 0, false},
                                   {SLIVER, 1, 0, 0, 0, true},
                                   {SLIVER, 1, 0, 0, 0, false}};
    for (size_t i = 0; i < sizeof trials / sizeof *trials; ++i) run_trial(&trials[i]);
}

/* ---- as in a frame ---- */

/* A glossy ball over a floor, and a light that is a mesh, each placed once. A point far behind the camera
 * keeps a group's frame. */
static stage still_life(bool framed) {
    stage s = stage_open(48, 32);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.spp = 16, s.settings.target_error = 0, s.settings.aovs = FATHOM_AOV_N | FATHOM_AOV_ID;
    const fathom_id grey = stage_lambert(&s, 0.6f), glow = stage_emitter(&s, 4);
    stage_plane(&s, (double[]){0, -1, 0}, (double[]){0, 1, 0}, grey);
    stage_camera(&s, (double[]){0, 1, 5}, (double[]){0, 0, 0}, (double[]){0, 1, 0}, 0.7);
    for (int i = 0; i < 2; ++i) {
        const fathom_id group = add_group(&s);
        stage_mesh_sphere(&s, group, 24, 48, i ? glow : grey);
        fathom_sphere point = default_sphere();
        point.center[2] = 300, point.radius = 1e-3, point.material = grey;
        if (framed) assert_ok(s.context, fathom_scene_add_sphere(s.scene, group, &point, NULL));
        fathom_instance instance = default_instance();
        const affine_f64 map = turned(i ? 0.4 : 0.9, i ? (vec3_f64){1.5, 1.5, 0.5} : (vec3_f64){-0.3, 0, 0});
        place(&s, &instance, group, FATHOM_ROOT, &map, NULL);
    }
    return s;
}

/* A path that meets an edge differently gives another sample. */
UNIT_TEST(carried_meshes_look_as_in_their_frames) {
    stage framed = still_life(true), carried = still_life(false);
    fathom_film *a = stage_render(&framed), *b = stage_render(&carried);
    static const char *const names[] = {"R", "G", "B", "N.X", "N.Y", "N.Z"};
    size_t far = 0, others = 0;
    for (size_t k = 0; k < sizeof names / sizeof *names; ++k) {
        const float *x = fathom_film_channel(a, names[k]), *y = fathom_film_channel(b, names[k]);
        for (size_t i = 0; i < 48 * 32; ++i) far += fabsf(x[i] - y[i]) > 1e-5f * (1 + fabsf(x[i]));
    }
    const uint32_t *x = fathom_film_channel_id(a, "id.instance"),
                   *y = fathom_film_channel_id(b, "id.instance");
    for (size_t i = 0; i < 48 * 32; ++i) others += x[i] != y[i];
    if (far > 60 || others > 2) fail_msg("%zu numbers and %zu instances differ", far, others);
}

int main(void) { return unit_main(NULL, NULL); }
