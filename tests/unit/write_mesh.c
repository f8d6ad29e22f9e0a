/* Mesh files: what is written reads back as the same triangles, bit for bit. */
#include "base/file.h"
#include "materials.h"
#include "owned.h"
#include "unit_folder.h"
#include "write/write.h"
#include "written.h"

#include <fathom/read.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- triangles of a scene, as they lie in the world ---- */

typedef struct corner {
    float position[3], normal[3], uv[2];
} corner;

typedef struct triangle {
    corner corners[3];
    float color[3]; /* k_d */
    bool has_normals, has_uvs;
} triangle;

typedef struct soup {
    ARRAY(triangle) triangles;
} soup;

/* v grows upwards, whatever the file has. */
static corner make_corner(const fathom_mesh *m, bool upwards, size_t i, const affine_f64 *map,
                          const affine_f64 *inverse) {
    corner c = {{0}, {0}, {0}};
    vec3_f64 p = widen(load_f32(mesh_vertex(m, m->indices[i])));
    store_f32(c.position, narrow(affine_point(map, p)));
    if (m->normals) {
        uint32_t k = m->normal_indices ? m->normal_indices[i] : m->indices[i];
        vec3_f64 n = widen(load_f32(mesh_row(m->normals, m->normal_stride, k)));
        if (!affine_is_identity(map)) n = normalize_f64(affine_transposed_vector(inverse, n));
        store_f32(c.normal, narrow(n));
    }
    if (m->uvs)
        memcpy(c.uv, mesh_row(m->uvs, m->uv_stride, m->uv_indices ? m->uv_indices[i] : m->indices[i]), 8);
    if (m->uvs && !upwards) c.uv[1] = 1 - c.uv[1];
    return c;
}

static void add_mesh(const fathom_scene *scene, uint32_t index, const affine_f64 *to_world,
                     fathom_id material, soup *out) {
    const fathom_mesh *m = &scene->meshes.items[index];
    const bool upwards = scene->mesh_facts.items[index].upwards;
    affine_f64 origin = affine_translation(load_f64(m->origin)), map = affine_compose(to_world, &origin),
               inverse;
    assert_true(affine_invert(&map, &inverse));
    double(*r)[4] = map.m;
    bool mirrored = r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1]) -
                        r[0][1] * (r[1][0] * r[2][2] - r[1][2] * r[2][0]) +
                        r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0]) <
                    0;
    for (size_t t = 0; t < m->triangle_count; ++t) {
        triangle tri = {.has_normals = m->normals != NULL, .has_uvs = m->uvs != NULL};
        for (size_t k = 0; k < 3; ++k)
            tri.corners[mirrored && k ? 3 - k : k] = make_corner(m, upwards, 3 * t + k, &map, &inverse);
        memcpy(tri.color,
               scene->materials.items[material != FATHOM_NONE ? material : m->material].classic.k_d, 12);
        assert_true(array_push(&out->triangles, tri));
    }
}

static void add_group(const fathom_scene *scene, uint32_t group, const affine_f64 *to_world,
                      fathom_id material, soup *out) {
    for (size_t i = 0; i < scene->objects.count; ++i) {
        scene_object o = scene->objects.items[i];
        if (o.group == group && o.kind == SCENE_MESH) add_mesh(scene, o.index, to_world, material, out);
    }
    for (size_t i = 0; i < scene->instances.count; ++i) {
        const fathom_instance *in = &scene->instances.items[i];
        if (in->parent != group) continue;
        affine_f64 map;
        affine_load(&map, in->transform);
        map = affine_compose(to_world, &map);
        add_group(scene, in->group, &map, material != FATHOM_NONE ? material : in->material, out);
    }
}

/* By the positions of the corners, whatever order files keep their triangles in. */
static int by_position(const void *a, const void *b) {
    const triangle *s = a, *t = b;
    for (int k = 0; k < 9; ++k) {
        float x = s->corners[k / 3].position[k % 3], y = t->corners[k / 3].position[k % 3];
        if (fabsf(x - y) > 0x1p-20f) return x < y ? -1 : 1; /* see check_next() */
    }
    return 0;
}

static soup make_soup(const fathom_scene *scene) {
    soup out = {.triangles = {0}};
    affine_f64 identity = affine_identity();
    add_group(scene, FATHOM_ROOT, &identity, FATHOM_NONE, &out);
    qsort(out.triangles.items, out.triangles.count, sizeof *out.triangles.items, by_position);
    return out;
}

/* A flat mesh among smooth ones comes back with its facets' normals: unit vectors off by a few roundings of
 * float positions of about 1, over edges of more than 0.05. */
static void check_facet_normals(const triangle *t) {
    vec3_f64 p[3];
    for (int k = 0; k < 3; ++k) p[k] = widen(load_f32(t->corners[k].position));
    vec3_f64 n = normalize_f64(cross_f64(sub_f64(p[1], p[0]), sub_f64(p[2], p[0])));
    for (int k = 0; k < 3; ++k)
        assert_near(dot_f64(n, widen(load_f32(t->corners[k].normal))), 1, 8 * 0x1p-24 / 0.05);
}

static bool same_floats(const float *a, const float *b, int count) {
    for (int k = 0; k < count; ++k)
        if (a[k] != b[k]) return false;
    return true;
}

/* A transform that shears becomes two nodes in .glb. Their product is rounded in double, so a float may
 * become the next one. */
static void check_next(const float *a, const float *b, double unit) {
    const double most = fmax(fmax(fabs((double)a[0]), fabs((double)a[1])), fabs((double)a[2]));
    for (int k = 0; k < 3; ++k) assert_near(a[k], b[k], unit * most);
}

static void check_same(const triangle *a, const triangle *b, bool colors, double unit) {
    for (int k = 0; k < 3; ++k) {
        check_next(a->corners[k].position, b->corners[k].position, unit);
        if (a->has_normals) check_next(a->corners[k].normal, b->corners[k].normal, unit);
        if (a->has_uvs) assert_true(same_floats(a->corners[k].uv, b->corners[k].uv, 2));
    }
    if (a->has_normals) assert_true(b->has_normals);
    if (a->has_uvs) assert_true(b->has_uvs);
    if (!a->has_normals && b->has_normals) check_facet_normals(b);
    /* Colours pass through the nine digits of a text or through the layer model: a few roundings. */
    for (int k = 0; k < 3 && colors; ++k) assert_near(a->color[k], b->color[k], 8 * 0x1p-24);
}

/* Writes, reads back and compares as soups. */
static void check_round_trip(const fathom_scene *scene, const char *name, bool colors) {
    fathom_scene *back = written(scene, name);
    soup a = make_soup(scene), b = make_soup(back);
    assert_int_equal(a.triangles.count, b.triangles.count);
    const double unit = strstr(name, ".glb") ? 0x1p-23 : 0;
    for (size_t i = 0; i < a.triangles.count; ++i)
        check_same(&a.triangles.items[i], &b.triangles.items[i], colors, unit);
    array_free(&a.triangles);
    array_free(&b.triangles);
}

static void check_all_formats(const fathom_scene *scene) {
    check_round_trip(scene, "mesh.glb", true);
    check_round_trip(scene, "mesh.ply", false);
    check_round_trip(scene, "mesh.obj", true);
}

static fathom_scene *generate(fathom_generator kind, uint64_t triangles) {
    fathom_scene *scene = new_scene(context);
    fathom_generate_options options = default_generate_options();
    options.kind = kind, options.triangles = triangles;
    assert_ok(context, fathom_scene_generate(scene, FATHOM_ROOT, &options));
    return scene;
}

/* ---- round trips ---- */

/* One mesh comes back as the same arrays, order and all; in PLY and OBJ v grows upwards. */
UNIT_TEST(one_mesh_keeps_its_arrays) {
    const fathom_generator kinds[] = {FATHOM_GENERATE_SPHERE, FATHOM_GENERATE_TERRAIN};
    const char *const names[] = {"mesh.glb", "mesh.ply", "mesh.obj"};
    for (size_t i = 0; i < 6; ++i) {
        fathom_scene *scene = generate(kinds[i / 3], 50000);
        const char *name = names[i % 3];
        fathom_scene *back = written(scene, name);
        assert_int_equal(back->meshes.count, 1);
        const fathom_mesh *a = &scene->meshes.items[0], *b = &back->meshes.items[0];
        assert_int_equal(a->vertex_count, b->vertex_count);
        assert_int_equal(a->triangle_count, b->triangle_count);
        assert_memory_equal(a->indices, b->indices, (size_t)a->triangle_count * 12);
        for (uint32_t v = 0; v < a->vertex_count; ++v) {
            assert_true(
                same_floats(mesh_row(a->positions, 12, v), mesh_row(b->positions, b->position_stride, v), 3));
            assert_true(
                same_floats(mesh_row(a->normals, 12, v), mesh_row(b->normals, b->normal_stride, v), 3));
            const float *own = mesh_row(a->uvs, 8, v), flipped[2] = {own[0], 1 - own[1]};
            assert_true(same_floats(i % 3 ? flipped : own, mesh_row(b->uvs, b->uv_stride, v), 2));
        }
    }
}

UNIT_TEST(instances_are_placed) {
    fathom_scene *scene = generate(FATHOM_GENERATE_FOREST, 20000);
    check_all_formats(scene);
    scene = generate(FATHOM_GENERATE_SPONGE, 12 * 400);
    check_all_formats(scene);
}

static const float tetra_positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
static const uint32_t tetra_indices[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
/* One normal a face: indices of their own, and positions that have several. */
static const float tetra_normals[] = {0, 0, -1, 0, -1, 0, -1, 0, 0, 0.6f, 0.64f, 0.48f};
static const uint32_t tetra_normal_indices[] = {0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3};
static const float tetra_uvs[] = {0.1f, 0.2f, 0.3f, 0.7f, 1, 0};
static const uint32_t tetra_uv_indices[] = {0, 1, 2, 0, 1, 2, 2, 1, 0, 0, 0, 1};

enum { PLAIN, SPLIT_NORMALS, SPLIT_BOTH };

static fathom_id add_tetra(fathom_scene *scene, fathom_id group, int kind, const double origin[3]) {
    fathom_mesh mesh = default_mesh();
    mesh.positions = tetra_positions, mesh.vertex_count = 4;
    mesh.indices = tetra_indices, mesh.triangle_count = 4;
    if (kind != PLAIN) {
        mesh.normals = tetra_normals, mesh.normal_count = 4, mesh.normal_indices = tetra_normal_indices;
    }
    if (kind == SPLIT_BOTH) mesh.uvs = tetra_uvs, mesh.uv_count = 3, mesh.uv_indices = tetra_uv_indices;
    memcpy(mesh.origin, origin, sizeof mesh.origin);
    fathom_id id;
    assert_ok(context, fathom_scene_add_mesh(scene, group, &mesh, &id));
    return id;
}

static fathom_id add_color(fathom_scene *scene, const char *name, float r, float g, float b) {
    fathom_material material = default_material();
    material.k_d[0] = r, material.k_d[1] = g, material.k_d[2] = b;
    return new_material(scene, name, &material);
}

static void add_placed(fathom_scene *scene, fathom_id group, fathom_id parent, const double rows[12],
                       fathom_id material) {
    fathom_instance instance = default_instance();
    instance.group = group, instance.parent = parent, instance.material = material;
    memcpy(instance.transform, rows, sizeof instance.transform);
    assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
}

/* Split indices, flat beside smooth, an origin of its own, mirrors, shear, nested groups and materials that
 * override each other. */
static fathom_scene *make_hard_scene(void) {
    fathom_scene *scene = new_scene(context);
    fathom_id inner, outer, red = add_color(scene, "red", 0.8f, 0.1f, 0.1f);
    fathom_id blue = add_color(scene, "a name, with \"marks\" #1", 0.1f, 0.2f, 0.7f);
    assert_ok(context, fathom_scene_add_group(scene, "inner", &inner));
    assert_ok(context, fathom_scene_add_group(scene, NULL, &outer));
    add_tetra(scene, inner, SPLIT_BOTH, (const double[3]){0, 0, 0});
    add_tetra(scene, inner, PLAIN, (const double[3]){5, 0.25, 0});
    add_tetra(scene, outer, SPLIT_NORMALS, (const double[3]){0, 0, 3});
    add_tetra(scene, FATHOM_ROOT, PLAIN, (const double[3]){-3, 0, 0});
    const double mirror[12] = {-1, 0, 0, 10, 0, 0.3, 0.1, 0.7, 0, -0.2, 1.1, 0};
    const double turn[12] = {0.6, -0.8, 0, 0, 0.8, 0.6, 0, 20, 0, 0, 2, 1.0 / 3};
    const double away[12] = {1, 0, 0, 0, 0, 1, 0, -30, 0, 0, 1, 0};
    add_placed(scene, inner, outer, mirror, FATHOM_NONE);
    add_placed(scene, inner, outer, turn, red);
    add_placed(scene, outer, FATHOM_ROOT, turn, FATHOM_NONE);
    add_placed(scene, outer, FATHOM_ROOT, mirror, blue);
    add_placed(scene, inner, FATHOM_ROOT, away, blue);
    return scene;
}

UNIT_TEST(hard_scenes_are_read_back) {
    fathom_scene *scene = make_hard_scene();
    check_all_formats(scene);
}

/* The vertices' normals are unit vectors in the world and in the mesh: between them, both are mixed
 * otherwise. */
UNIT_TEST(stretched_smooth_meshes_are_told) {
    static const double rows[][12] = {{0, 3, 0, 1, -3, 0, 0, 2, 0, 0, -3, 0},
                                      {1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0}};
    for (int k = 0; k < 4; ++k) {
        const bool stretched = k % 2, smooth = k / 2;
        fathom_scene *scene = new_scene(context);
        const fathom_id group = new_group(scene, NULL);
        add_tetra(scene, group, smooth ? SPLIT_NORMALS : PLAIN, (const double[3]){0, 0, 0});
        add_placed(scene, group, FATHOM_ROOT, rows[stretched], FATHOM_NONE);
        forget_warnings();
        assert_ok(context, fathom_scene_write(scene, in_folder("a.ply")));
        assert_int_equal(warning_count, smooth && stretched);
    }
}

/* glTF forbids other lengths. Renders normalise normals before they mix them, but mix tangents as they are.
 */
UNIT_TEST(glb_has_unit_normals_and_tangents) {
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0},
                       normals[9] = {0, 0, 4, 0, 3, 4, 0.6f, 0, 0.8f},
                       tangents[12] = {2, 0, 0, 1, 1, 0, 0, 1, 0, 1, 0, -1};
    static const uint32_t indices[3] = {0, 1, 2};
    for (int k = 0; k < 2; ++k) {
        fathom_scene *scene = new_scene(context);
        fathom_mesh mesh = default_mesh();
        mesh.positions = positions, mesh.vertex_count = 3, mesh.indices = indices, mesh.triangle_count = 1;
        mesh.normals = normals, mesh.normal_count = 3, mesh.tangents = k ? tangents : NULL;
        assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
        forget_warnings();
        assert_ok(context, fathom_scene_write(scene, in_folder("a.glb")));
        assert_int_equal(warning_count, k);
        fathom_scene *back = scene_of_file(context, in_folder("a.glb"));
        const float expected[9] = {0, 0, 1, 0, 0.6f, 0.8f, 0.6f, 0, 0.8f};
        assert_memory_equal(back->meshes.items[0].normals, expected, sizeof expected);
        if (k) assert_true(back->meshes.items[0].tangents[0] == 1 && back->meshes.items[0].tangents[3] == 1);
    }
}

/* Far from the origin .glb keeps the mesh's own numbers: a node moves it there in double. OBJ has the digits
 * of double, of which the reader makes floats below 2 around its own origin: each is off by at most 2^-24.
 * PLY has floats alone, and tells. */
UNIT_TEST(far_meshes_keep_their_digits_or_tell) {
    static const char *const names[] = {"far.glb", "far.obj", "far.ply"};
    const double far[3] = {4.5e6 + 0x1p-20, -5.2e6, 1.0 / 3};
    for (int k = 0; k < 3; ++k) {
        fathom_scene *scene = new_scene(context);
        add_tetra(scene, FATHOM_ROOT, PLAIN, far);
        forget_warnings();
        assert_ok(context, fathom_scene_write(scene, in_folder(names[k])));
        assert_int_equal(warning_count, k == 2);
        fathom_scene *back = scene_of_file(context, in_folder(names[k]));
        scene_bounds a, b;
        assert_ok(context, scene_world_bounds(scene, &a));
        assert_ok(context, scene_world_bounds(back, &b));
        if (k == 0) assert_memory_equal(&a, &b, sizeof a);
        if (k == 1) assert_true(length_f64(sub_f64(a.lower, b.lower)) < 4 * 0x1p-24);
        if (k == 1) assert_true(length_f64(sub_f64(a.upper, b.upper)) < 4 * 0x1p-24);
    }
}

/* ---- materials ---- */

static const fathom_material *read_back(fathom_scene *scene, const char *name, const char *material,
                                        fathom_scene **back) {
    *back = written(scene, name);
    fathom_id id = find_material(*back, material);
    assert_int_not_equal(id, FATHOM_NONE);
    return &(*back)->materials.items[id].classic;
}

static fathom_scene *scene_with(const char *name, const fathom_material *material) {
    fathom_scene *scene = new_scene(context);
    const fathom_id id = new_material(scene, name, material);
    fathom_id mesh = add_tetra(scene, FATHOM_ROOT, PLAIN, (const double[3]){0, 0, 0});
    scene->meshes.items[scene->objects.items[mesh].index].material = id;
    return scene;
}

static void check_color(const float a[3], const float b[3], double tolerance) {
    for (int k = 0; k < 3; ++k) assert_near(a[k], b[k], tolerance);
}

static void fill(float rgb[3], float r, float g, float b) { rgb[0] = r, rgb[1] = g, rgb[2] = b; }

static void check_colors(const fathom_material *m, const fathom_material *expected, double tolerance) {
    check_color(m->k_d, expected->k_d, tolerance);
    check_color(m->k_r, expected->k_r, tolerance);
    check_color(m->k_t, expected->k_t, tolerance);
    check_color(m->k_e, expected->k_e, tolerance);
}

/* A lamp, a highlight, a mirror, glass and a filter, without what each format has its own limits for. */
static void common_cases(fathom_material cases[5]) {
    for (int i = 0; i < 5; ++i) fathom_material_default(&cases[i]);
    fill(cases[0].k_d, 0.1f, 0.25f, 0.7f);
    fill(cases[0].k_e, 3, 0, 1);
    cases[1].specular = FATHOM_SPECULAR_BLINN;
    fill(cases[1].k_s, 0.3f, 0.2f, 0.1f);
    fill(cases[2].k_r, 0.9f, 0.8f, 0.2f);
    fill(cases[3].k_t, 1, 1, 1);
    fill(cases[3].k_r, 1, 1, 1);
    fill(cases[3].k_d, 0, 0, 0);
    cases[3].fresnel = true, cases[3].ior = 1.33f;
}

/* What the format can say comes back; numbers pass through a few operations of float or double. */
UNIT_TEST(mtl_keeps_materials) {
    fathom_material cases[5];
    common_cases(cases);
    cases[1].shininess = 77;
    fill(cases[2].k_d, 0.05f, 0, 0);
    fill(cases[4].k_t, 0.5f, 0.25f, 0.5f);
    cases[4].ior = 1.7f;
    for (int i = 0; i < 5; ++i) {
        fathom_scene *scene = scene_with("m", &cases[i]), *back;
        const fathom_material *m = read_back(scene, "m.obj", "m", &back);
        check_colors(m, &cases[i], 4 * 0x1p-24);
        if (i == 1) check_color(m->k_s, cases[i].k_s, 0);
        if (i == 1) assert_true(m->shininess == 77 && m->specular == FATHOM_SPECULAR_BLINN);
        assert_int_equal(m->fresnel, cases[i].fresnel);
        if (cases[i].k_t[0] > 0) assert_true(m->ior == cases[i].ior);
    }
}

UNIT_TEST(glb_keeps_materials) {
    fathom_material cases[5];
    common_cases(cases);
    /* A highlight too broad to be a mirror as well. */
    cases[1].shininess = 20;
    fill(cases[2].k_d, 0, 0, 0);
    fill(cases[4].k_t, 0.75f, 0.75f, 0.75f);
    fill(cases[4].k_d, 0.125f, 0.0625f, 0.25f);
    cases[4].ior = 1;
    for (int i = 0; i < 5; ++i) {
        fathom_scene *scene = scene_with("m", &cases[i]), *back;
        const fathom_material *m = read_back(scene, "m.glb", "m", &back);
        check_colors(m, &cases[i], 8 * 0x1p-24);
        if (i == 1) check_color(m->k_s, cases[i].k_s, 8 * 0x1p-24);
        /* The exponent is 2 / r^4 - 2 there. */
        if (i == 1) assert_near(m->shininess, 20, 22 * 8 * 0x1p-24);
        /* Where nothing is mirrored or refracted Fresnel's law has nothing to say. */
        if (i >= 2) assert_int_equal(m->fresnel, cases[i].fresnel);
        if (cases[i].k_t[0] > 0) assert_near(m->ior, cases[i].ior, 0x1p-23);
    }
}

/* ---- form ---- */

static void *whole_file(const char *name, size_t *size) {
    file_map map;
    assert_ok(context, file_open(context, in_folder(name), &map));
    void *copy = malloc(map.size);
    assert_non_null(copy);
    memcpy(copy, map.bytes, map.size);
    *size = map.size;
    file_close(&map);
    return copy;
}

UNIT_TEST(threads_change_no_byte) {
    const char *const names[] = {"a.glb", "a.ply", "a.obj"};
    fathom_scene *scene = generate(FATHOM_GENERATE_SPHERE, 100000);
    for (size_t i = 0; i < 3; ++i) {
        size_t size, other;
        fathom_context_set_threads(context, 1);
        assert_ok(context, fathom_scene_write(scene, in_folder(names[i])));
        void *one = whole_file(names[i], &size);
        fathom_context_set_threads(context, 5);
        assert_ok(context, fathom_scene_write(scene, in_folder(names[i])));
        void *five = whole_file(names[i], &other);
        assert_int_equal(size, other);
        assert_memory_equal(one, five, size);
        free(one);
        free(five);
    }
    fathom_context_set_threads(context, 0);
}

/* The chunks fill the file, and the arrays begin on multiples of 16 bytes. */
UNIT_TEST(glb_is_laid_out_for_mapping) {
    fathom_scene *scene = make_hard_scene();
    assert_ok(context, fathom_scene_write(scene, in_folder("a.glb")));
    size_t size;
    unsigned char *bytes = whole_file("a.glb", &size);
    uint32_t head[5], binary[2];
    memcpy(head, bytes, sizeof head);
    assert_memory_equal(bytes, "glTF", 4);
    assert_int_equal(head[1], 2);
    assert_int_equal(head[2], size);
    memcpy(binary, bytes + 20 + head[3], sizeof binary);
    assert_int_equal(28 + head[3] + binary[0], size);
    assert_int_equal((28 + head[3]) % 16, 0);
    char *json = strndup((const char *)bytes + 20, head[3]);
    int views = 0;
    for (const char *at = json; (at = strstr(at, "\"byteOffset\":")); ++views) {
        at += strlen("\"byteOffset\":");
        assert_int_equal(strtoul(at, NULL, 10) % 16, 0);
    }
    assert_int_equal(views, 4 + 2 + 3 + 2);
    free(json);
    free(bytes);
}

/* Every bit pattern of a float, in steps of a prime. */
UNIT_TEST(floats_read_back) {
    for (uint64_t bits = 0; bits < UINT64_C(1) << 32; bits += 4099) {
        uint32_t pattern = (uint32_t)bits;
        float value, back;
        memcpy(&value, &pattern, sizeof value);
        if (!isfinite(value)) continue;
        char text[WRITE_NUMBER_BYTES + 1];
        size_t length = write_float(text, value);
        assert_true(length < WRITE_NUMBER_BYTES);
        text[length] = 0;
        char *end;
        back = strtof(text, &end);
        assert_true(end == text + length && back == value);
    }
}

/* The last floats before the powers of ten, where rounding up would carry farthest. */
UNIT_TEST(floats_below_powers_of_ten) {
    for (int power = -6; power <= 9; ++power) {
        const float ten = (float)pow(10, power);
        for (float value = nextafterf(nextafterf(ten, 0), 0); value <= ten;
             value = nextafterf(value, INFINITY)) {
            char text[WRITE_NUMBER_BYTES + 1];
            text[write_float(text, value)] = 0;
            assert_true(strtof(text, NULL) == value);
            assert_true(strlen(text) <= 16);
        }
    }
}

UNIT_TEST(numbers_are_short) {
    const struct {
        float value;
        const char *text;
    } cases[] = {{0, "0"},
                 {1, "1"},
                 {-0.5f, "-0.5"},
                 {0.1f, "0.100000001"},
                 {1234.5f, "1234.5"},
                 {1e7f, "10000000"},
                 {0.001953125f, "0.001953125"},
                 {99999992, "99999992"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char text[WRITE_NUMBER_BYTES + 1];
        text[write_float(text, cases[i].value)] = 0;
        assert_string_equal(text, cases[i].text);
    }
}

/* ---- failures ---- */

UNIT_TEST(spheres_are_told_and_empty_scenes_refused) {
    fathom_scene *scene = new_scene(context);
    assert_fails(context, fathom_scene_write(scene, in_folder("a.stl")), FATHOM_BAD_USAGE,
                 ".glb, .json, .obj or .ply");
    assert_fails(context, fathom_scene_write(scene, in_folder("a")), FATHOM_BAD_USAGE,
                 ".glb, .json, .obj or .ply");
    assert_fails(context, fathom_scene_write(scene, in_folder("a.ply")), FATHOM_BAD_USAGE,
                 "no shape to write");
    fathom_sphere sphere = default_sphere();
    assert_ok(context, fathom_scene_add_sphere(scene, FATHOM_ROOT, &sphere, NULL));
    add_tetra(scene, FATHOM_ROOT, PLAIN, (const double[3]){0, 0, 0});
    forget_warnings();
    assert_ok(context, fathom_scene_write(scene, in_folder("a.ply")));
    assert_int_equal(warning_count, 1);
    expect_warning("a sphere becomes triangles with smooth normals");
    assert_fails(context, fathom_scene_write(scene, in_folder("none/a.obj")), FATHOM_OUT_OF_RESOURCES,
                 "none/a.obj");
}

UNIT_TEST(too_many_triangles_are_refused) {
    fathom_scene *scene = generate(FATHOM_GENERATE_SPONGE, UINT64_C(100000000000));
    assert_fails(context, fathom_scene_write(scene, in_folder("a.ply")), FATHOM_BAD_USAGE, "107642880000");
    assert_fails(context, fathom_scene_write(scene, in_folder("a.obj")), FATHOM_BAD_USAGE, ".glb");
    /* 2^30 nodes in a chain of groups that each hold the next one twice. */
    scene = new_scene(context);
    fathom_id parent = FATHOM_ROOT, group;
    fathom_instance instance = default_instance();
    for (int level = 0; level < 30; ++level, parent = group) {
        assert_ok(context, fathom_scene_add_group(scene, NULL, &group));
        add_placed(scene, group, parent, instance.transform, FATHOM_NONE);
        add_placed(scene, group, parent, instance.transform, FATHOM_NONE);
    }
    add_tetra(scene, parent, PLAIN, (const double[3]){0, 0, 0});
    assert_fails(context, fathom_scene_write(scene, in_folder("a.glb")), FATHOM_BAD_USAGE, "2147483647");
}

int main(void) { return unit_main(open_folder, remove_folder); }
