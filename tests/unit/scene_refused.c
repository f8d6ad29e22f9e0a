/* What a scene refuses: every value out of its range, with a message that names it, and the scene as it was.
 * The ends of each range are taken. */
#include "materials.h"
#include "scene/scene.h"
#include "unit_scene.h"

/* How much a scene holds: what a refused call must not change. */
static size_t content(void) {
    return scene->materials.count + scene->lights.count + scene->groups.count + scene->objects.count +
           scene->spheres.count + scene->quads.count + scene->planes.count + scene->meshes.count +
           scene->mesh_facts.count + scene->instances.count;
}

#define REFUSED(call, words)                                                                                 \
    do {                                                                                                     \
        const size_t before = content();                                                                     \
        assert_fails(context, call, FATHOM_BAD_INPUT, words);                                                \
        assert_int_equal(content(), before);                                                                 \
    } while (0)

/* ---- settings ---- */

#define SETTINGS(...)                                                                                        \
    fathom_settings s;                                                                                       \
    fathom_settings_default(&s);                                                                             \
    fathom_settings_set_integrator(&s, FATHOM_INTEGRATOR_CLASSIC);                                           \
    __VA_ARGS__

#define WRONG(words, ...)                                                                                    \
    do {                                                                                                     \
        SETTINGS(__VA_ARGS__);                                                                               \
        s.terminator_fix = false; /* a mark: nothing of these is kept */                                     \
        assert_fails(context, fathom_scene_set_settings(scene, &s), FATHOM_BAD_INPUT, words);                \
        fathom_scene_settings(scene, &s);                                                                    \
        assert_true(s.terminator_fix);                                                                       \
    } while (0)

#define RIGHT(...)                                                                                           \
    do {                                                                                                     \
        SETTINGS(__VA_ARGS__);                                                                               \
        assert_ok(context, fathom_scene_set_settings(scene, &s));                                            \
    } while (0)

UNIT_TEST(sizes_and_samples) {
    WRONG("width", s.width = 0);
    WRONG("width", s.width = 65537);
    WRONG("height", s.height = 0);
    WRONG("height", s.height = 65537);
    RIGHT(s.width = 1, s.height = 65536);
    WRONG("found 0", s.spp = 0);
    WRONG("found 65537", s.spp = 65537);
    WRONG("a square number such as 4 or 9, found 8", s.spp = 8);
    RIGHT(s.spp = 65536);
    RIGHT(s.pattern = FATHOM_PATTERN_SOBOL, s.spp = 8);
    WRONG("tile size", s.tile_size = 31);
    WRONG("tile size", s.tile_size = 48);
    WRONG("tile size", s.tile_size = 65568);
    RIGHT(s.tile_size = 65536);
    for (uint32_t width = 0; width < 20; ++width) {
        if (width == 1 || width == 4 || width == 8 || width == 16)
            RIGHT(s.block_width = width);
        else
            WRONG("block width", s.block_width = width);
    }
}

UNIT_TEST(crops) {
    const uint32_t wrong[][4] = {{5, 0, 5, 9}, {0, 9, 5, 9},   {6, 0, 5, 9},  {0, 10, 5, 9},
                                 {0, 0, 0, 9}, {0, 0, 101, 9}, {0, 0, 5, 51}, {0, 0, 5, 0}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i)
        WRONG("crop: expected x0 < x1 <= 100 and y0 < y1 <= 50", s.width = 100, s.height = 50,
              memcpy(s.crop, wrong[i], sizeof s.crop));
    RIGHT(s.width = 100, s.height = 50, s.crop[0] = 99, s.crop[1] = 49, s.crop[2] = 100, s.crop[3] = 50);
}

UNIT_TEST(weights_and_losses) {
    WRONG("max depth", s.max_depth = 1025);
    RIGHT(s.max_depth = 1024);
    WRONG("min weight", s.min_weight = -0.1f);
    WRONG("min weight", s.min_weight = 1);
    WRONG("min weight", s.min_weight = NAN);
    RIGHT(s.min_weight = 0);
    WRONG("max loss", s.max_loss = -1e-9f);
    WRONG("max loss", s.max_loss = 1.1f);
    WRONG("max relative loss", s.max_relative_loss = -1e-9f);
    WRONG("max relative loss", s.max_relative_loss = NAN);
    RIGHT(s.max_loss = 1, s.max_relative_loss = 1);
    WRONG("epsilon", s.epsilon = -1e-300);
    WRONG("epsilon", s.epsilon = INFINITY);
}

#define SOBOL s.pattern = FATHOM_PATTERN_SOBOL, s.spp = 64

UNIT_TEST(goals) {
    WRONG("target error", SOBOL, s.target_error = -1);
    WRONG("target error", SOBOL, s.target_error = NAN);
    WRONG("max time", SOBOL, s.max_time = INFINITY);
    WRONG("needs the pattern sobol", s.spp = 64, s.target_error = 0.1);
    WRONG("found 2", SOBOL, s.spp = 2, s.target_error = 0.1);
    WRONG("found 48", SOBOL, s.spp = 48, s.max_time = 1);
    WRONG("min spp", SOBOL, s.min_spp = 2, s.target_error = 0.1);
    WRONG("min spp", SOBOL, s.min_spp = 128, s.target_error = 0.1);
    WRONG("min spp", SOBOL, s.min_spp = 24, s.target_error = 0.1);
    RIGHT(SOBOL, s.min_spp = 64, s.target_error = 0.1, s.max_time = 1);
    RIGHT(SOBOL, s.min_spp = 24); /* without a goal it means nothing */
}

/* A setting can be given back as it was got: its text is the scene's own. */
UNIT_TEST(settings_of_the_scene_itself) {
    RIGHT(s.tracer = "bvh");
    fathom_settings own;
    fathom_scene_settings(scene, &own);
    assert_ok(context, fathom_scene_set_settings(scene, &own));
    fathom_scene_settings(scene, &own);
    assert_string_equal(own.tracer, "bvh");
    RIGHT(s.tracer = NULL);
    fathom_scene_settings(scene, &own);
    assert_null(own.tracer);
    fathom_settings fallback;
    fathom_settings_default(&own);
    fathom_scene_settings(NULL, &fallback);
    assert_true(fallback.width == own.width && fallback.spp == own.spp && !fallback.tracer);
}

/* ---- materials, lights, the camera ---- */

UNIT_TEST(materials) {
#define MATERIAL(words, ...)                                                                                 \
    do {                                                                                                     \
        fathom_material m;                                                                                   \
        fathom_material_default(&m);                                                                         \
        __VA_ARGS__;                                                                                         \
        REFUSED(fathom_scene_add_material(scene, "m", &m, NULL), words);                                     \
        assert_int_equal(find_material(scene, "m"), FATHOM_NONE);                                            \
    } while (0)
    MATERIAL("ka", m.k_a[0] = 1, m.k_a[1] = -1);
    MATERIAL("kd", m.k_d[2] = -0.1f);
    MATERIAL("ks", m.k_s[1] = NAN);
    MATERIAL("kr", m.k_r[0] = INFINITY);
    MATERIAL("kt", m.k_t[2] = -1);
    MATERIAL("ke", m.k_e[0] = -1);
    MATERIAL("shininess", m.shininess = -1);
    MATERIAL("shininess", m.shininess = 2e9f);
    MATERIAL("shininess", m.shininess = NAN);
    MATERIAL("ior", m.ior = 0);
    MATERIAL("ior", m.ior = INFINITY);
    MATERIAL("anisotropy rotation: expected a finite number, found inf",
             m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.anisotropy_rotation = INFINITY);
    /* Either sign turns, and raises or sinks. */
    fathom_material m = default_material();
    m.bump_scale = -1;
    assert_ok(context, fathom_scene_add_material(scene, "sunk", &m, NULL));
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.anisotropy_rotation = -7;
    assert_ok(context, fathom_scene_add_material(scene, "turned", &m, NULL));
}

UNIT_TEST(lights) {
#define LIGHT(words, kind, ...)                                                                              \
    do {                                                                                                     \
        fathom_light l;                                                                                      \
        fathom_light_default(&l);                                                                            \
        l.type = FATHOM_LIGHT_##kind, __VA_ARGS__;                                                           \
        REFUSED(fathom_scene_add_light(scene, &l, NULL), words);                                             \
    } while (0)
    LIGHT("intensity", POINT, l.intensity[1] = -1);
    LIGHT("position", POINT, l.position[2] = NAN);
    LIGHT("position", SPOT, l.position[0] = INFINITY);
    LIGHT("direction", DIRECTIONAL, l.direction[0] = NAN);
    LIGHT("direction", DIRECTIONAL, l.direction[1] = 0);
    LIGHT("direction", SPOT, l.direction[1] = 0);
    LIGHT("spot angles", SPOT, l.inner_angle = -0.1f);
    LIGHT("spot angles", SPOT, l.inner_angle = l.outer_angle);
    LIGHT("spot angles", SPOT, l.outer_angle = 1.6f);
    /* Each kind has fields that it does not look at. */
    fathom_light l = default_light();
    l.direction[1] = 0, l.inner_angle = 9;
    assert_ok(context, fathom_scene_add_light(scene, &l, NULL));
    fathom_light_default(&l);
    l.type = FATHOM_LIGHT_DIRECTIONAL, l.position[0] = NAN;
    assert_ok(context, fathom_scene_add_light(scene, &l, NULL));
}

UNIT_TEST(cameras) {
#define CAMERA(words, ...)                                                                                   \
    do {                                                                                                     \
        fathom_camera c;                                                                                     \
        fathom_camera_default(&c);                                                                           \
        __VA_ARGS__;                                                                                         \
        REFUSED(fathom_scene_set_camera(scene, &c), words);                                                  \
        assert_false(scene->has_camera);                                                                     \
    } while (0)
    CAMERA("frame", c.origin[1] = NAN);
    CAMERA("frame", c.x[0] = 1.1);
    CAMERA("frame", c.y[1] = 0.9);
    CAMERA("frame", c.z[2] = 1.1);
    CAMERA("frame", c.x[1] = 0.002);               /* not at right angles to y */
    CAMERA("frame", c.x[2] = 0.002);               /* not to z */
    CAMERA("frame", c.y[2] = 0.002);               /* y not to z */
    CAMERA("frame", c.z[2] = -1);                  /* left-handed */
    CAMERA("frame", c.x[0] = c.y[1] = c.z[2] = 0); /* no axes at all */
    CAMERA("d > 0", c.d = 0);
    CAMERA("h > 0", c.h = -1);
    CAMERA("w >= 0", c.w = -1);
    CAMERA("d > 0", c.d = INFINITY);
    fathom_camera c = default_camera();
    c.x[1] = 0.00005, c.w = 0;
    assert_ok(context, fathom_scene_set_camera(scene, &c));
    /* Meant as a frame, and made one. */
    assert_near(scene->camera.x[0] * scene->camera.y[0] + scene->camera.x[1] * scene->camera.y[1], 0, 1e-15);
}

UNIT_TEST(surroundings) {
    REFUSED(fathom_scene_set_background(scene, (float[3]){0, -1, 0}), "background");
    REFUSED(fathom_scene_set_ambient(scene, (float[3]){0, 0, INFINITY}), "ambient");
    assert_false(scene->has_background || scene->has_ambient);
}

/* ---- shapes ---- */

static const double bad[] = {(double)NAN, (double)INFINITY, -(double)INFINITY};

/* Sets each of `count` numbers to each bad value in turn. `number` is number i of the item; `add` is of a
 * default item. */
#define REFUSED_NUMBERS(type, number, count, add, words)                                                     \
    for (int i = 0; i < (count); ++i) {                                                                      \
        for (int k = 0; k < 3; ++k) {                                                                        \
            type item;                                                                                       \
            type##_default(&item);                                                                           \
            number = bad[k];                                                                                 \
            REFUSED(add, words);                                                                             \
        }                                                                                                    \
    }

UNIT_TEST(numbers_of_shapes_that_are_not_finite) {
    REFUSED_NUMBERS(fathom_sphere, item.center[i], 3,
                    fathom_scene_add_sphere(scene, FATHOM_ROOT, &item, NULL), "center");
    REFUSED_NUMBERS(fathom_sphere, item.radius, 1, fathom_scene_add_sphere(scene, FATHOM_ROOT, &item, NULL),
                    "radius");
    REFUSED_NUMBERS(fathom_quad, item.corners[i / 3][i % 3], 12,
                    fathom_scene_add_quad(scene, FATHOM_ROOT, &item, NULL), "corners");
    REFUSED_NUMBERS(fathom_plane, item.point[i], 3, fathom_scene_add_plane(scene, FATHOM_ROOT, &item, NULL),
                    "point");
    REFUSED_NUMBERS(fathom_plane, item.normal[i], 3, fathom_scene_add_plane(scene, FATHOM_ROOT, &item, NULL),
                    "normal");
    const fathom_id group = new_group(scene, "g");
    REFUSED_NUMBERS(fathom_instance, item.transform[i], 12,
                    (item.group = group, fathom_scene_add_instance(scene, &item, NULL)), "transform");
}

UNIT_TEST(unknown_flags_of_shapes) {
#define FLAGS(shape)                                                                                         \
    do {                                                                                                     \
        fathom_##shape item;                                                                                 \
        fathom_##shape##_default(&item);                                                                     \
        item.flags = FATHOM_CASTS_NO_SHADOW | 4;                                                             \
        assert_fails(context, fathom_scene_add_##shape(scene, FATHOM_ROOT, &item, NULL), FATHOM_BAD_USAGE,   \
                     "flags: expected 0 or FATHOM_CASTS_NO_SHADOW, found 5");                                \
        item.flags = FATHOM_CASTS_NO_SHADOW;                                                                 \
        assert_ok(context, fathom_scene_add_##shape(scene, FATHOM_ROOT, &item, NULL));                       \
    } while (0)
    FLAGS(sphere);
    FLAGS(quad);
    FLAGS(plane);
}

UNIT_TEST(shapes_without_an_area) {
    fathom_sphere sphere = default_sphere();
    for (int k = 0; k < 2; ++k) {
        sphere.radius = -k;
        REFUSED(fathom_scene_add_sphere(scene, FATHOM_ROOT, &sphere, NULL), "radius");
    }
    fathom_quad quad = default_quad();
    memset(quad.corners, 0, sizeof quad.corners);
    REFUSED(fathom_scene_add_quad(scene, FATHOM_ROOT, &quad, NULL), "area");
    for (int k = 0; k < 4; ++k) quad.corners[k][0] = k;
    REFUSED(fathom_scene_add_quad(scene, FATHOM_ROOT, &quad, NULL), "area");
}

UNIT_TEST(shapes) {
    fathom_sphere sphere = default_sphere();
    sphere.radius = INFINITY;
    REFUSED(fathom_scene_add_sphere(scene, FATHOM_ROOT, &sphere, NULL), "radius");
    sphere.radius = 1, sphere.material = 9;
    REFUSED(fathom_scene_add_sphere(scene, FATHOM_ROOT, &sphere, NULL), "no material 9");
    fathom_quad quad = default_quad();
    quad.corners[3][1] = NAN;
    REFUSED(fathom_scene_add_quad(scene, FATHOM_ROOT, &quad, NULL), "corners[3]");
    fathom_quad_default(&quad);
    REFUSED(fathom_scene_add_quad(scene, 7, &quad, NULL), "no group 7");
    fathom_plane plane = default_plane();
    plane.point[1] = INFINITY;
    REFUSED(fathom_scene_add_plane(scene, FATHOM_ROOT, &plane, NULL), "point");
    fathom_plane_default(&plane);
    plane.normal[0] = NAN;
    REFUSED(fathom_scene_add_plane(scene, FATHOM_ROOT, &plane, NULL), "normal");
    plane.normal[0] = plane.normal[2] = 0;
    REFUSED(fathom_scene_add_plane(scene, FATHOM_ROOT, &plane, NULL), "normal");
    fathom_plane_default(&plane);
    REFUSED(fathom_scene_add_plane(scene, 7, &plane, NULL), "no group 7");
}

static const float corners[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
static const uint32_t triangles[6] = {0, 1, 2, 2, 1, 3}, beyond[6] = {0, 1, 2, 2, 1, 4};

/* The scene keeps nothing of what it refuses: only the name of its root group, as before. */
UNIT_TEST(meshes) {
    const float odd[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, NAN, 1};
#define MESH(words, ...)                                                                                     \
    do {                                                                                                     \
        fathom_mesh m;                                                                                       \
        fathom_mesh_default(&m);                                                                             \
        m.positions = corners, m.vertex_count = 4, m.indices = triangles, m.triangle_count = 2;              \
        __VA_ARGS__;                                                                                         \
        REFUSED(fathom_scene_add_mesh(scene, FATHOM_ROOT, &m, NULL), words);                                 \
        REFUSED(fathom_scene_add_mesh_shared(scene, FATHOM_ROOT, &m, NULL), words);                          \
        assert_int_equal(scene->blobs.count, 1);                                                             \
    } while (0)
    MESH("no vertices", m.positions = NULL);
    MESH("no vertices", m.vertex_count = 0);
    MESH("no triangles", m.indices = NULL);
    MESH("no triangles", m.triangle_count = 0);
    MESH("origin", m.origin[0] = NAN);
    MESH("positions: the stride is 14", m.position_stride = 14);
    MESH("positions: the stride is 8", m.position_stride = 8);
    MESH("positions[3]", m.positions = odd);
    for (int k = 0; k < 36; ++k) {
        float p[12];
        memcpy(p, corners, sizeof p);
        p[k / 3] = (float)bad[k % 3];
        MESH(unit_text("positions[%d]", k / 9), m.positions = p);
    }
    MESH("indices[5]: 4, of triangle 1, is out of range; there are 4", m.indices = beyond);
    MESH("normals: expected one for each of the 4 vertices, or normal_indices; found 3", m.normals = corners,
         m.normal_count = 3);
    MESH("normals: the stride is 8", m.normals = corners, m.normal_count = 4, m.normal_stride = 8);
    MESH("normals[3]", m.normals = odd, m.normal_count = 4);
    const float dark[16] = {0, 0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 1};
    MESH("colors[3]: expected numbers >= 0, found -1", m.colors = dark);
    MESH("colors[2]: expected numbers >= 0, found -1", m.colors = dark, m.color_channels = 4);
    MESH("normal_indices[5]", m.normals = corners, m.normal_count = 4, m.normal_indices = beyond);
    MESH("uvs: expected one for each of the 4 vertices, or uv_indices; found 3", m.uvs = corners,
         m.uv_count = 3);
    MESH("uvs: the stride is 6", m.uvs = corners, m.uv_count = 4, m.uv_stride = 6);
    MESH("uvs[5]", m.uvs = odd, m.uv_count = 6);
    MESH("uv_indices[5]", m.uvs = corners, m.uv_count = 4, m.uv_indices = beyond);
}

/* Long arrays are checked by several threads: told is the first fault, whoever finds one first. */
UNIT_TEST(the_first_fault_is_told) {
    enum { VERTICES = 400000, INDICES = 3 * 400000 };
    float *positions = unit_memory(VERTICES * 3 * sizeof *positions);
    uint32_t *indices = unit_memory(INDICES * sizeof *indices);
    assert_true(positions && indices);
    fathom_context_set_threads(context, 4);
    fathom_mesh m = default_mesh();
    m.positions = m.normals = positions, m.vertex_count = m.normal_count = VERTICES;
    m.indices = indices, m.triangle_count = INDICES / 3, m.normal_indices = indices;
    positions[3 * 70001] = NAN, positions[3 * 399999 + 2] = INFINITY;
    REFUSED(fathom_scene_add_mesh_shared(scene, FATHOM_ROOT, &m, NULL), "positions[70001]");
    m.positions = corners, m.vertex_count = 4;
    REFUSED(fathom_scene_add_mesh_shared(scene, FATHOM_ROOT, &m, NULL), "normals[70001]");
    m.normals = corners, m.normal_count = 4;
    indices[300001] = 4, indices[1199999] = 9;
    m.indices = triangles, m.triangle_count = 2;
    m.normal_indices = indices;
    uint32_t *good = unit_memory(INDICES * sizeof *good);
    m.indices = good, m.triangle_count = INDICES / 3;
    REFUSED(fathom_scene_add_mesh_shared(scene, FATHOM_ROOT, &m, NULL),
            "normal_indices[300001]: 4, of triangle 100000, is out of range");
}

UNIT_TEST(instances) {
    const fathom_id group = new_group(scene, "g");
#define INSTANCE(words, ...)                                                                                 \
    do {                                                                                                     \
        fathom_instance i;                                                                                   \
        fathom_instance_default(&i);                                                                         \
        i.group = group, __VA_ARGS__;                                                                        \
        REFUSED(fathom_scene_add_instance(scene, &i, NULL), words);                                          \
    } while (0)
    INSTANCE("other than the world", i.group = FATHOM_ROOT);
    INSTANCE("other than the world, found id 9", i.group = 9);
    INSTANCE("no group 9", i.parent = 9);
    INSTANCE("no material 9", i.material = 9);
    INSTANCE("transform", i.transform[5] = 0);
    INSTANCE("transform", i.transform[3] = NAN);
}

/* ---- sizes ---- */

UNIT_TEST(sizes_that_cannot_be) {
    void *out = scene;
    assert_int_equal(scene_allocate(scene, SIZE_MAX - 8, &out), FATHOM_OUT_OF_RESOURCES);
    assert_null(out);
    assert_int_equal(scene_allocate(scene, SIZE_MAX / 4, &out), FATHOM_OUT_OF_RESOURCES);
    assert_null(out);
    assert_int_equal(scene_allocate_items(scene, SIZE_MAX / 8, 9, &out), FATHOM_OUT_OF_RESOURCES);
    assert_null(out);
    assert_int_equal(scene->blobs.count, 1);
}

int main(void) { return unit_main_each(open_scene, NULL); }
