/* Building scenes: what is refused, and what the world of the tracers becomes. */
#include "scene/world/world.h"
#include "worlds.h"

typedef struct fixture {
    fathom_context *context;
    fathom_scene *scene;
} fixture;

static fixture open_scene(void) {
    fixture f = {.context = new_context()};
    f.scene = new_scene(f.context);
    return f;
}

static fathom_status add_sphere(fixture *f, fathom_id group, double x, double y, double z, double radius) {
    fathom_sphere sphere = default_sphere();
    sphere.center[0] = x, sphere.center[1] = y, sphere.center[2] = z, sphere.radius = radius;
    return fathom_scene_add_sphere(f->scene, group, &sphere, NULL);
}

static fathom_id add_group(fixture *f, const char *name) {
    fathom_id id;
    assert_ok(f->context, fathom_scene_add_group(f->scene, name, &id));
    return id;
}

static fathom_status add_instance(fixture *f, fathom_id group, fathom_id parent, double x, double scale) {
    fathom_instance instance = default_instance();
    instance.group = group, instance.parent = parent;
    instance.transform[0] = instance.transform[5] = instance.transform[10] = scale;
    instance.transform[3] = x;
    return fathom_scene_add_instance(f->scene, &instance, NULL);
}

static const float corners[12 + 4] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}; /* and 16 bytes past the end */
static const uint32_t two_triangles[6] = {0, 1, 2, 2, 1, 3};

static fathom_mesh small_mesh(void) {
    fathom_mesh mesh = default_mesh();
    mesh.positions = corners, mesh.vertex_count = 4;
    mesh.indices = two_triangles, mesh.triangle_count = 2;
    return mesh;
}

UNIT_TEST(bad_shapes) {
    fixture f = open_scene();
    assert_fails(f.context, add_sphere(&f, FATHOM_ROOT, 0, 0, 0, -1), FATHOM_BAD_INPUT, "radius");
    assert_fails(f.context, add_sphere(&f, FATHOM_ROOT, NAN, 0, 0, 1), FATHOM_BAD_INPUT, "center");
    assert_fails(f.context, add_sphere(&f, 7, 0, 0, 0, 1), FATHOM_BAD_INPUT, "group 7");
    fathom_quad quad = default_quad();
    quad.corners[2][2] = 0.1;
    assert_fails(f.context, fathom_scene_add_quad(f.scene, FATHOM_ROOT, &quad, NULL), FATHOM_BAD_INPUT,
                 "one plane");
    fathom_quad_default(&quad);
    quad.corners[2][0] = quad.corners[2][1] = -0.4;
    assert_fails(f.context, fathom_scene_add_quad(f.scene, FATHOM_ROOT, &quad, NULL), FATHOM_BAD_INPUT,
                 "convex");
    fathom_quad_from_axes((double[3]){0, 0, 0}, (double[3]){1, 0, 0}, (double[3]){2, 0, 0}, &quad);
    assert_fails(f.context, fathom_scene_add_quad(f.scene, FATHOM_ROOT, &quad, NULL), FATHOM_BAD_INPUT,
                 "area");
    fathom_mesh mesh = small_mesh();
    mesh.vertex_count = 3;
    assert_fails(f.context, fathom_scene_add_mesh(f.scene, FATHOM_ROOT, &mesh, NULL), FATHOM_BAD_INPUT,
                 "out of range");
    mesh = small_mesh(), mesh.position_stride = 10;
    assert_fails(f.context, fathom_scene_add_mesh(f.scene, FATHOM_ROOT, &mesh, NULL), FATHOM_BAD_INPUT,
                 "stride");
    float bad[12];
    memcpy(bad, corners, sizeof bad);
    bad[7] = INFINITY;
    mesh = small_mesh(), mesh.positions = bad;
    assert_fails(f.context, fathom_scene_add_mesh(f.scene, FATHOM_ROOT, &mesh, NULL), FATHOM_BAD_INPUT,
                 "positions[2]");
    fathom_instance flat = default_instance();
    flat.group = add_group(&f, "g"), flat.transform[0] = 0;
    assert_fails(f.context, fathom_scene_add_instance(f.scene, &flat, NULL), FATHOM_BAD_INPUT, "inverted");
}

UNIT_TEST(wholes_that_cannot_be) {
    fixture f = open_scene();
    assert_fails(f.context, fathom_scene_check(f.scene), FATHOM_BAD_INPUT, "no geometry");
    fathom_id a = add_group(&f, "arm"), b = add_group(&f, "hand");
    assert_ok(f.context, add_instance(&f, a, FATHOM_ROOT, 0, 1));
    assert_ok(f.context, add_instance(&f, b, a, 1, 1));
    assert_fails(f.context, fathom_scene_check(f.scene), FATHOM_BAD_INPUT, "no geometry");
    assert_ok(f.context, add_sphere(&f, b, 0, 0, 0, 1));
    assert_ok(f.context, fathom_scene_check(f.scene));
    assert_ok(f.context, add_instance(&f, a, b, 1, 1));
    assert_fails(f.context, fathom_scene_check(f.scene), FATHOM_BAD_INPUT, "\"arm\" -> \"hand\" -> \"arm\"");
}

static void note_light(void *user, const char *message) {
    if (strstr(message, "lies inside a sphere")) snprintf(user, 300, "%s", message);
}

static const char *warned_of_light(fixture *f) {
    static char message[300];
    message[0] = '\0';
    fathom_context_on_warning(f->context, note_light, message);
    assert_ok(f->context, fathom_scene_check(f->scene));
    world *w = new_world(f->scene);
    assert_ok(f->context, world_check(w));
    return message;
}

/* Wherever the sphere's frames put it, and whatever it is made of; not where the camera is in there too. */
UNIT_TEST(lights_in_spheres_are_warned_of) {
    static const double shifts[] = {0, 1e7};
    for (int k = 0; k < 8; ++k) {
        fixture f = open_scene();
        bool placed = k & 1, shadow = !(k & 2);
        double x = shifts[k / 4];
        fathom_sphere sphere = default_sphere();
        sphere.center[0] = placed ? 0 : x, sphere.center[2] = placed ? -2.5 : -5;
        sphere.radius = placed ? 0.5 : 1;
        sphere.flags = shadow ? 0 : FATHOM_CASTS_NO_SHADOW;
        fathom_id group = placed ? add_group(&f, "ball") : FATHOM_ROOT;
        assert_ok(f.context, fathom_scene_add_sphere(f.scene, group, &sphere, NULL));
        if (placed) assert_ok(f.context, add_instance(&f, group, FATHOM_ROOT, x, 2));
        fathom_light light = default_light();
        light.position[0] = x, light.position[2] = -3.9;
        assert_ok(f.context, fathom_scene_add_light(f.scene, &light, NULL));
        assert_string_equal(warned_of_light(&f), "");
        light.position[2] = -4.1;
        assert_ok(f.context, fathom_scene_add_light(f.scene, &light, NULL));
        assert_int_equal(strncmp(warned_of_light(&f), "lights[1]", 9) == 0, shadow);
        fathom_camera camera = default_camera();
        camera.origin[0] = x, camera.origin[2] = -5;
        assert_ok(f.context, fathom_scene_set_camera(f.scene, &camera));
        assert_string_equal(warned_of_light(&f), "");
    }
}

/* Bulbs of clear walls let light out, and a lamp may be larger than what is in it. */
UNIT_TEST(lights_that_leave_spheres_are_not_warned_of) {
    for (int k = 0; k < 4; ++k) {
        fixture f = open_scene();
        fathom_sphere sphere = default_sphere();
        fathom_material m = default_material();
        fathom_light light = default_light();
        m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.transmission = 1, m.roughness = k == 1 ? 0.5f : 0;
        if (k > 1) m.transmission = 0;
        light.radius = k == 2 ? 2 : 0;
        sphere.center[2] = -5, sphere.radius = 1, light.position[2] = -5;
        assert_ok(f.context, fathom_scene_add_material(f.scene, NULL, &m, &sphere.material));
        assert_ok(f.context, fathom_scene_add_sphere(f.scene, FATHOM_ROOT, &sphere, NULL));
        assert_ok(f.context, fathom_scene_add_light(f.scene, &light, NULL));
        assert_int_equal(warned_of_light(&f)[0] != '\0', k % 2);
    }
}

/* Two levels of frames: scale by 2 at x = 10, in a frame scaled by 3 at x = 100. */
/* A chain of groups, each holding the next: deeper than a stack of calls would hold. */
UNIT_TEST(nests_to_any_depth) {
    fixture f = open_scene();
    fathom_id parent = FATHOM_ROOT;
    for (int depth = 0; depth < 200000; ++depth) {
        fathom_id group = add_group(&f, NULL);
        assert_ok(f.context, add_instance(&f, group, parent, depth == 0 ? 1 : 0, 1));
        parent = group;
    }
    assert_ok(f.context, add_sphere(&f, parent, 0, 0, 0, 1));
    world *w = new_world(f.scene);
    assert_int_equal(w->instances.count, 1);
    assert_near(w->instances.items[0].to_world[0][3], 1, 0);
}

UNIT_TEST(nested_frames_multiply) {
    fixture f = open_scene();
    fathom_id outer = add_group(&f, "outer"), inner = add_group(&f, "inner");
    assert_ok(f.context, add_sphere(&f, inner, 1, 0, 0, 0.5));
    assert_ok(f.context, add_instance(&f, inner, outer, 10, 2));
    assert_ok(f.context, add_instance(&f, outer, FATHOM_ROOT, 100, 3));
    assert_ok(f.context, add_instance(&f, inner, FATHOM_ROOT, -4, 1));
    world *w = new_world(f.scene);
    assert_int_equal(w->instances.count, 2);
    const world_instance *nested = &w->instances.items[0];
    assert_near(nested->to_world[0][0], 6, 0);
    assert_near(nested->to_world[0][3], 130, 0);
    assert_near(nested->to_object[0][0], 1 / 6.0, 0x1p-26);
    assert_near(w->instances.items[1].to_world[0][3], -4, 0);
    scene_bounds bounds;
    assert_ok(f.scene->context, scene_world_bounds(f.scene, &bounds));
    assert_near(bounds.upper.x, 139, 0);
    assert_near(bounds.lower.x, -3.5, 0);
}

/* A group that is placed once, unmoved, needs no frame; its instance is still named. */
UNIT_TEST(needless_frames_are_left_out) {
    fixture f = open_scene();
    fathom_id group = add_group(&f, "model");
    fathom_mesh mesh = small_mesh();
    assert_ok(f.context, fathom_scene_add_mesh_shared(f.scene, group, &mesh, NULL));
    assert_ok(f.context, add_instance(&f, group, FATHOM_ROOT, 0, 1));
    world *w = new_world(f.scene);
    assert_int_equal(w->instances.count, 0);
    assert_int_equal(w->geometries.count, 1);
    assert_int_equal(w->geometries.items[0].instance, 0);
    assert_ptr_equal(w->meshes.items[0].positions, corners);
}

/* A mesh at Earth's radius: its own origin becomes the world's, and nothing is lost to float. */
UNIT_TEST(far_scenes_are_brought_near) {
    fixture f = open_scene();
    fathom_mesh mesh = small_mesh();
    mesh.origin[0] = 6378137.125;
    assert_ok(f.context, fathom_scene_add_mesh_shared(f.scene, FATHOM_ROOT, &mesh, NULL));
    assert_ok(f.context, add_sphere(&f, FATHOM_ROOT, 6378139.375, 0, 0, 0.5));
    fathom_plane plane = default_plane();
    plane.point[0] = 6378136.25, plane.normal[0] = -2, plane.normal[2] = 0;
    assert_ok(f.context, fathom_scene_add_plane(f.scene, FATHOM_ROOT, &plane, NULL));
    world *w = new_world(f.scene);
    double sphere_x = w->origin.x + (double)w->spheres.items[0].center.x;
    assert_near(sphere_x, 6378139.375, 0);
    assert_true(fabsf(w->spheres.items[0].center.x) < 4);
    double mesh_x = w->instances.count ? (double)w->instances.items[0].to_world[0][3] : 0;
    assert_near(w->origin.x + mesh_x, 6378137.125, 0);
    assert_near(w->origin.x - (double)w->planes.items[0].offset, 6378136.25, 0);
}

UNIT_TEST(degenerate_triangles_are_counted) {
    fixture f = open_scene();
    const uint32_t indices[12] = {0, 1, 2, 0, 0, 1, 2, 1, 3, 3, 3, 3};
    fathom_mesh mesh = small_mesh();
    mesh.indices = indices, mesh.triangle_count = 4;
    assert_ok(f.context, fathom_scene_add_mesh(f.scene, FATHOM_ROOT, &mesh, NULL));
    world *w = new_world(f.scene);
    assert_int_equal(w->degenerate_triangles, 2);
}

/* What no tracer of Embree's sees is counted: beyond 1e18, or beyond float. */
UNIT_TEST(shapes_beyond_reach_are_counted) {
    fixture f = open_scene();
    const double places[6] = {0, 9e17, 1.1e18, -3e30, 1e300, 5};
    for (int i = 0; i < 6; ++i) {
        fathom_sphere sphere = default_sphere();
        sphere.center[i % 3] = places[i], sphere.radius = i == 5 ? 1e18 : 1;
        assert_ok(f.context, fathom_scene_add_sphere(f.scene, FATHOM_ROOT, &sphere, NULL));
    }
    const uint32_t indices[6] = {0, 1, 2, 0, 1, 3};
    const float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1e20f, 0};
    fathom_mesh mesh = small_mesh();
    mesh.positions = positions, mesh.vertex_count = 4, mesh.indices = indices, mesh.triangle_count = 2;
    assert_ok(f.context, fathom_scene_add_mesh(f.scene, FATHOM_ROOT, &mesh, NULL));
    world *w = new_world(f.scene);
    assert_int_equal(w->beyond_reach, 4 + 1);
}

int main(void) { return unit_main(NULL, NULL); }
