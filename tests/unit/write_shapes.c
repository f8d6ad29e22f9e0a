/* Quads and spheres in formats that hold triangles alone. */
#include "base/file.h"
#include "materials.h"
#include "owned.h"
#include "unit_folder.h"
#include "write/write.h"
#include "written.h"

#include <fathom/read.h>

static const double pi = 3.14159265358979323846;

/* Directed: brushed along u, so that texture coordinates matter. */
static fathom_scene *scene_with(bool directed) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.metallic = 1, m.roughness = 0.5f;
    m.anisotropy = directed ? 0.5f : 0;
    fathom_scene *scene = new_scene(context);
    assert_ok(context, fathom_scene_add_material(scene, "m", &m, NULL));
    return scene;
}

static fathom_id material_of(const fathom_scene *scene) { return find_material(scene, "m"); }

static void add_sphere(fathom_scene *scene, fathom_id group, double x, double radius) {
    fathom_sphere sphere = default_sphere();
    sphere.center[0] = x, sphere.radius = radius, sphere.material = material_of(scene);
    assert_ok(context, fathom_scene_add_sphere(scene, group, &sphere, NULL));
}

/* A trapezoid, whose texture coordinates bend at the diagonal, far from the origin. */
static const double corners[4][3] = {{1000, 1, 2}, {1002, 1, 2}, {1001.5, 2, 2}, {1000.5, 2, 2}};

static void add_quad(fathom_scene *scene, fathom_id group) {
    fathom_quad quad = default_quad();
    memcpy(quad.corners, corners, sizeof corners);
    quad.material = material_of(scene);
    assert_ok(context, fathom_scene_add_quad(scene, group, &quad, NULL));
}

static vec3_f64 corner_at(const fathom_mesh *m, size_t corner) {
    return widen(load_f32(mesh_vertex(m, m->indices[corner])));
}

/* The texture coordinates of a normal, as fathom_sphere defines them. */
static void check_uv(const float n[3], const float uv[2]) {
    assert_near(uv[1], acos((double)n[2]) / pi, 1e-6);
    if (fabsf(n[2]) > 0.9999f) return;
    const double turn = (double)uv[0] - atan2((double)n[1], (double)n[0]) / (2 * pi);
    assert_near(turn, rint(turn), 1e-6);
}

static void check_vertices(const fathom_mesh *m, double radius) {
    for (uint32_t i = 0; i < m->vertex_count; ++i) {
        const vec3_f64 at = widen(load_f32(mesh_vertex(m, i))),
                       n = widen(load_f32(mesh_row(m->normals, 12, i)));
        /* Floats below 1 are at most 2^-24 apart, and those below 4 at most 2^-22. */
        assert_near(length_f64(n), 1, sqrt(3) * 0x1p-25);
        assert_near(length_f64(sub_f64(at, scale_f64(radius, n))), 0, sqrt(3) * 0x1p-23);
    }
}

/* Each edge runs once in each direction, and none is wider than a column, across the seam neither. */
static void check_triangles(const fathom_mesh *m, double radius) {
    double volume = 0;
    int64_t balance = 0;
    for (size_t t = 0; t < m->triangle_count; ++t) {
        float least = 2, largest = -1;
        for (size_t k = 0; k < 3; ++k) {
            const uint32_t a = m->indices[3 * t + k], b = m->indices[3 * t + (k + 1) % 3];
            const float *uv = &m->uvs[2 * (size_t)m->uv_indices[3 * t + k]];
            check_uv(&m->normals[3 * (size_t)a], uv);
            least = fminf(least, uv[0]), largest = fmaxf(largest, uv[0]);
            const uint64_t low = a < b ? a : b, high = a < b ? b : a;
            const int64_t edge = (int64_t)((low * 2654435761u ^ high * 2246822519u) >> 8);
            balance += a < b ? edge : -edge;
        }
        assert_true(largest - least <= 1 / 128.0f + 1e-6f);
        volume +=
            dot_f64(corner_at(m, 3 * t), cross_f64(corner_at(m, 3 * t + 1), corner_at(m, 3 * t + 2))) / 6;
    }
    assert_int_equal(balance, 0);
    /* Seen from the centre, facets lie between 0 and 0.0006 of the radius below the sphere. */
    const double whole = 4 * pi / 3 * radius * radius * radius;
    assert_true(volume < whole && volume > whole * (1 - 3 * 0.0006));
}

UNIT_TEST(spheres_become_closed_meshes) {
    fathom_scene *scene = scene_with(true), view;
    add_sphere(scene, FATHOM_ROOT, 1e6, 3);
    assert_ok(context, write_shapes_as_meshes(scene, &view));
    assert_int_equal(view.objects.count, 1);
    const fathom_mesh *m = &view.meshes.items[0];
    assert_int_equal(m->triangle_count, 4 * 64 * 63);
    assert_true(m->origin[0] == 1e6 && m->origin[1] == 0 && m->origin[2] == 0);
    check_vertices(m, 3);
    check_triangles(m, 3);
    write_shapes_free(&view);
}

UNIT_TEST(many_spheres_get_fewer_triangles) {
    static const struct {
        size_t spheres;
        uint32_t rows;
    } cases[] = {{249, 32}, {1009, 16}, {4167, 8}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        fathom_scene *scene = scene_with(false), view;
        for (size_t k = 0; k < cases[i].spheres; ++k) add_sphere(scene, FATHOM_ROOT, (double)k, 0.5);
        assert_ok(context, write_shapes_as_meshes(scene, &view));
        assert_int_equal(view.meshes.count, cases[i].spheres);
        assert_int_equal(view.meshes.items[7].triangle_count, 4 * cases[i].rows * (cases[i].rows - 1));
        assert_null(view.meshes.items[7].uvs);
        write_shapes_free(&view);
    }
}

UNIT_TEST(quads_become_two_triangles) {
    static const float uvs[4][2] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    fathom_scene *scene = scene_with(true), view;
    add_quad(scene, FATHOM_ROOT);
    assert_ok(context, write_shapes_as_meshes(scene, &view));
    const fathom_mesh *m = &view.meshes.items[0];
    assert_int_equal(m->vertex_count, 4);
    assert_int_equal(m->triangle_count, 2);
    for (uint32_t k = 0; k < 4; ++k) {
        for (uint32_t c = 0; c < 3; ++c)
            assert_true(m->origin[c] + (double)m->positions[3 * k + c] == corners[k][c]);
        assert_memory_equal(&m->uvs[2 * k], uvs[k], sizeof uvs[k]);
    }
    double area = 0;
    for (size_t t = 0; t < 2; ++t) {
        const vec3_f64 a = corner_at(m, 3 * t), b = corner_at(m, 3 * t + 1), c = corner_at(m, 3 * t + 2);
        area += cross_f64(sub_f64(b, a), sub_f64(c, a)).z / 2; /* both face +z */
    }
    assert_true(area == 1.5);
    write_shapes_free(&view);
}

/* In every model format, in a group that is placed twice. */
UNIT_TEST(shapes_are_read_back) {
    static const char *const names[] = {"a.glb", "a.ply", "a.obj"};
    fathom_scene *scene = scene_with(false);
    fathom_instance instance = default_instance();
    const fathom_id group = new_group(scene, "both");
    add_sphere(scene, group, 1001, 1), add_quad(scene, group);
    instance.group = group;
    assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
    instance.transform[11] = 8;
    assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        scene_bounds box;
        fathom_scene *back = written(scene, names[i]);
        assert_int_equal(scene_triangles(back), (i ? 2 : 1) * (4 * 64 * 63 + 2));
        assert_ok(context, scene_world_bounds(back, &box));
        /* A file's floats near 1000 are 2^-14 apart. */
        assert_near(box.lower.x, 1000, 0x1p-14);
        assert_near(box.upper.x, 1002, 0x1p-14);
        assert_near(box.lower.y, -1, 0x1p-14);
        assert_near(box.upper.y, 2, 0x1p-14);
        assert_near(box.lower.z, -1, 0x1p-14);
        assert_near(box.upper.z, 10, 0x1p-14);
    }
}

UNIT_TEST(planes_alone_are_refused) {
    fathom_scene *scene = scene_with(false);
    fathom_plane plane = default_plane();
    assert_ok(context, fathom_scene_add_plane(scene, FATHOM_ROOT, &plane, NULL));
    assert_fails(context, fathom_scene_write(scene, in_folder("a.glb")), FATHOM_BAD_USAGE,
                 "a.glb: the scene holds no shape to write but planes without end");
}

int main(void) { return unit_main(open_folder, remove_folder); }
