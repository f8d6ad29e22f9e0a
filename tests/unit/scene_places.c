/* Where shapes come to lie: whatever origins and frames the world takes for its floats, each point stays
 * where the scene has it; and what cannot be placed is told. */
#include "scene/world/world.h"
#include "unit_scene.h"
#include "worlds.h"

static void add_sphere(fathom_id group, vec3_f64 center, double radius) {
    fathom_sphere sphere = default_sphere();
    store_f64(sphere.center, center), sphere.radius = radius;
    assert_ok(context, fathom_scene_add_sphere(scene, group, &sphere, NULL));
}

static const float corners[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};

static void add_mesh(fathom_id group, vec3_f64 origin) {
    static const uint32_t triangles[6] = {0, 1, 2, 2, 1, 3};
    fathom_mesh mesh = default_mesh();
    mesh.positions = corners, mesh.vertex_count = 4, mesh.indices = triangles, mesh.triangle_count = 2;
    store_f64(mesh.origin, origin);
    assert_ok(context, fathom_scene_add_mesh(scene, group, &mesh, NULL));
}

static fathom_status place(fathom_id group, fathom_id parent, double scale, fathom_id material) {
    fathom_instance instance = default_instance();
    instance.group = group, instance.parent = parent, instance.material = material;
    instance.transform[0] = instance.transform[5] = instance.transform[10] = scale;
    return fathom_scene_add_instance(scene, &instance, NULL);
}

static vec3_f64 along(int axis, double distance) {
    double p[3] = {0, 0, 0};
    p[axis] = distance;
    return load_f64(p);
}

/* Of group g of the world, which has no other frame than an instance of its own, or none. */
static vec3_f64 moved_by(const world *w, uint32_t group) {
    vec3_f64 at = w->origin;
    for (size_t i = 0; i < w->instances.count; ++i) {
        const world_instance *instance = &w->instances.items[i];
        if (instance->group != group) continue;
        vec3_f64 shift = {(double)instance->to_world[0][3], (double)instance->to_world[1][3],
                          (double)instance->to_world[2][3]};
        at = add_f64(at, shift);
    }
    return at;
}

static uint32_t group_of(const world *w, uint32_t geometry) {
    for (size_t g = 0; g < w->groups.count; ++g) {
        if (geometry - w->groups.items[g].first < w->groups.items[g].count) return (uint32_t)g;
    }
    fail_msg("geometry %u lies in no group", geometry);
    return 0;
}

static const world_geometry *geometry_of(const world *w, world_kind kind, uint32_t *index) {
    for (*index = 0; *index < w->geometries.count; ++*index)
        if (w->geometries.items[*index].kind == kind) return &w->geometries.items[*index];
    fail_msg("there is no geometry of kind %d", (int)kind);
    return NULL;
}

static void assert_at(vec3_f64 found, vec3_f64 expected) {
    assert_near(found.x, expected.x, 0);
    assert_near(found.y, expected.y, 0);
    assert_near(found.z, expected.z, 0);
}

/* Two far spheres in a group: the world's origin is the middle of both, the group's own the first of them. */
UNIT_TEST(groups_far_away) {
    for (int axis = 0; axis < 3; ++axis) {
        const vec3_f64 first = along((axis + 1) % 3, 1 << 20), second = add_f64(first, along(axis, 64));
        fathom_id group = add_group();
        add_sphere(group, first, 1);
        add_sphere(group, second, 1);
        assert_ok(context, place(group, FATHOM_ROOT, 1, FATHOM_NONE));
        world *w = new_world(scene);
        uint32_t at;
        const world_geometry *spheres = geometry_of(w, WORLD_SPHERES, &at);
        vec3_f64 origin = moved_by(w, group_of(w, at));
        assert_at(add_f64(origin, widen(w->spheres.items[spheres->first].center)), first);
        assert_at(add_f64(origin, widen(w->spheres.items[spheres->first + 1].center)), second);
        open_scene(NULL);
    }
}

/* A mesh keeps the origin that it came with, beside shapes that have another: along each axis. */
UNIT_TEST(meshes_with_origins_of_their_own) {
    for (int k = 0; k < 6; ++k) {
        const vec3_f64 origin = along(k % 3, 5 << 20);
        fathom_id group = k < 3 ? FATHOM_ROOT : add_group();
        add_sphere(group, (vec3_f64){1, 2, 3}, 1);
        add_mesh(group, origin);
        add_mesh(group, (vec3_f64){0, 0, 0});
        if (k >= 3) assert_ok(context, place(group, FATHOM_ROOT, 1, FATHOM_NONE));
        world *w = new_world(scene);
        uint32_t at;
        assert_int_equal(w->meshes.count, 2);
        for (at = 0; at < w->geometries.count; ++at) {
            const world_geometry *g = &w->geometries.items[at];
            vec3_f64 moved = moved_by(w, group_of(w, at));
            if (g->kind == WORLD_MESH)
                assert_at(moved, load_f64(w->meshes.items[g->first].origin));
            else
                assert_at(add_f64(moved, widen(w->spheres.items[g->first].center)), (vec3_f64){1, 2, 3});
        }
        open_scene(NULL);
    }
}

/* An instance's material stands for those of all it holds, planes too; the outermost wins. */
UNIT_TEST(materials_of_instances) {
    fathom_material red = default_material(), blue;
    blue = red;
    const fathom_id red_id = new_material(scene, "red", &red);
    const fathom_id blue_id = new_material(scene, "blue", &blue);
    fathom_id inner = add_group(), outer = add_group();
    fathom_plane plane = default_plane();
    assert_ok(context, fathom_scene_add_plane(scene, inner, &plane, NULL));
    add_sphere(inner, (vec3_f64){0, 0, 0}, 1);
    const fathom_id given[3][2] = {{FATHOM_NONE, FATHOM_NONE}, {red_id, FATHOM_NONE}, {FATHOM_NONE, blue_id}};
    const fathom_id seen[3] = {0, red_id, blue_id};
    assert_ok(context, place(inner, outer, 1, FATHOM_NONE));
    for (int i = 0; i < 3; ++i) {
        scene->instances.count = 0; /* placed anew */
        assert_ok(context, place(inner, outer, 1, given[i][0]));
        assert_ok(context, place(outer, FATHOM_ROOT, 1, given[i][1]));
        world *w = new_world(scene);
        assert_int_equal(w->planes.items[0].material, seen[i]);
        assert_int_equal(w->instances.count, 0);
        assert_int_equal(world_material(w, 0, 0, FATHOM_NONE), seen[i]);
    }
    scene->instances.count = 0;
    assert_ok(context, place(inner, outer, 1, red_id));
    assert_ok(context, place(outer, FATHOM_ROOT, 1, blue_id));
    world *w = new_world(scene);
    assert_int_equal(w->planes.items[0].material, blue_id);
}

/* Frames that can be inverted each, and not together. */
UNIT_TEST(frames_that_vanish) {
    for (int kind = 0; kind < 2; ++kind) {
        fathom_id inner = add_group(), outer = add_group();
        fathom_plane plane = default_plane();
        if (kind == 0)
            add_sphere(inner, (vec3_f64){0, 0, 0}, 1);
        else
            assert_ok(context, fathom_scene_add_plane(scene, inner, &plane, NULL));
        assert_ok(context, place(inner, outer, 1e-170, FATHOM_NONE));
        assert_ok(context, place(outer, FATHOM_ROOT, 1e-170, FATHOM_NONE));
        world *w;
        assert_fails(context, world_create(scene, &w), FATHOM_BAD_INPUT,
                     "instance 0: its frame, with those around it, flattens space");
        assert_null(w);
        open_scene(NULL);
    }
}

/* A mesh in the root has no instance that a message could name. */
UNIT_TEST(meshes_beyond_float) {
    world *w;
    add_mesh(FATHOM_ROOT, along(1, 0));
    add_mesh(FATHOM_ROOT, along(1, 1e100));
    assert_fails(context, world_create(scene, &w), FATHOM_BAD_INPUT,
                 "a mesh lies farther from the camera than float reaches");
    assert_null(w);
}

/* Each group holds the next one twice: 2^31 ways to the innermost, in a few hundred bytes. */
UNIT_TEST(more_instances_than_can_be) {
    fathom_id inner = add_group();
    add_sphere(inner, (vec3_f64){0, 0, 0}, 1);
    for (int i = 0; i < 31; ++i) {
        fathom_id outer = i == 30 ? FATHOM_ROOT : add_group();
        for (int k = 0; k < 2; ++k) assert_ok(context, place(inner, outer, 1 + k, FATHOM_NONE));
        inner = outer;
    }
    world *w;
    assert_fails(context, world_create(scene, &w), FATHOM_OUT_OF_RESOURCES,
                 "nested instances place 4.29e+09");
    assert_null(w);
}

static fathom_status check_world(void) {
    world *w;
    fathom_status status = world_create(scene, &w);
    if (status == FATHOM_OK) status = world_check(w);
    world_destroy(w);
    return status;
}

UNIT_TEST(cameras_too_far) {
    add_sphere(FATHOM_ROOT, (vec3_f64){0, 0, 0}, 1);
    fathom_camera camera;
    for (int axis = 0; axis < 3; ++axis) {
        fathom_camera_default(&camera);
        camera.origin[axis] = 9e17;
        assert_ok(context, fathom_scene_set_camera(scene, &camera));
        assert_ok(context, check_world());
        camera.origin[axis] = -2e18;
        assert_ok(context, fathom_scene_set_camera(scene, &camera));
        assert_fails(context, check_world(), FATHOM_BAD_INPUT, "camera: it stands 2e+18 from the scene");
    }
}

UNIT_TEST(nothing_but_degenerate_triangles) {
    const uint32_t indices[6] = {0, 1, 1, 2, 2, 2};
    fathom_mesh mesh = default_mesh();
    mesh.positions = corners, mesh.vertex_count = 4, mesh.indices = indices, mesh.triangle_count = 2;
    assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
    assert_fails(context, check_world(), FATHOM_BAD_INPUT, "its triangles (2) are all degenerate");
    fathom_plane plane = default_plane();
    assert_ok(context, fathom_scene_add_plane(scene, FATHOM_ROOT, &plane, NULL));
    assert_ok(context, check_world());
}

static void quad_of(double corner, int index, fathom_quad *out) {
    static const double square[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    fathom_quad_default(out);
    for (int i = 0; i < 4; ++i)
        out->corners[i][0] = square[i][0], out->corners[i][1] = square[i][1], out->corners[i][2] = 0;
    out->corners[index][0] = out->corners[index][1] = corner;
}

/* A quad is traced as two triangles: in float a corner can come to lie on the diagonal between its
 * neighbours. */
UNIT_TEST(quads_that_float_flattens) {
    fathom_quad quad;
    const struct {
        double corner;
        int index;
        uint32_t flat;
    } cases[] = {{0.5 + 1e-12, 2, 1}, {0.5 + 1e-6, 2, 1}, {0.5 - 1e-12, 0, 2}, {0, 0, 2}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        quad_of(cases[i].corner, cases[i].index, &quad);
        assert_ok(context, fathom_scene_add_quad(scene, FATHOM_ROOT, &quad, NULL));
        world *w = new_world(scene);
        assert_int_equal(w->geometries.items[0].flat, cases[i].flat);
    }
    /* Corners beyond float. */
    for (int i = 0; i < 4; ++i)
        for (int k = 0; k < 3; ++k) quad.corners[i][k] *= 1e39;
    assert_ok(context, fathom_scene_add_quad(scene, FATHOM_ROOT, &quad, NULL));
    world *w = new_world(scene);
    assert_int_equal(w->beyond_reach, 1);
}

/* What is there is kept; a scene that is a point is looked at from a distance of 1. */
UNIT_TEST(completing_keeps_what_is_set) {
    const float dark[3] = {0, 0.25f, 0}, dim[3] = {0.5f, 0, 0};
    fathom_mesh mesh = default_mesh();
    const float point[6] = {1, 1, 0, 1, 1, 0};
    mesh.positions = point, mesh.vertex_count = 2, mesh.indices = (const uint32_t[3]){0, 1, 0};
    mesh.triangle_count = 1;
    assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
    scene->settings.integrator = FATHOM_INTEGRATOR_CLASSIC; /* paths are lit by the background */
    assert_ok(context, fathom_scene_set_background(scene, dark));
    assert_ok(context, fathom_scene_set_ambient(scene, dim));
    assert_ok(context, fathom_scene_complete(scene));
    assert_memory_equal(scene->background, dark, sizeof dark);
    assert_memory_equal(scene->ambient, dim, sizeof dim);
    assert_int_equal(scene->lights.count, 2);
    vec3_f64 to = sub_f64((vec3_f64){1, 1, 0}, load_f64(scene->camera.origin));
    assert_near(length_f64(to), 1, 1e-15);
    assert_near(dot_f64(to, load_f64(scene->camera.z)), -1, 1e-15);
    fathom_camera camera = scene->camera;
    assert_ok(context, fathom_scene_complete(scene));
    assert_memory_equal(&scene->camera, &camera, sizeof camera);
    assert_int_equal(scene->lights.count, 2);
}

int main(void) { return unit_main_each(open_scene, NULL); }
