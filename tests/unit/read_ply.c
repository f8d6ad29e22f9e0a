/* PLY files: every flavour of the same thing gives the same mesh. Errors are tested in
 * read_ply_errors.c. */
#include "ply_file.h"
#include "read/mesh/strokes.h"

#include "random.h"

/* All formats, at all alignments. */
UNIT_TEST(triangles_and_quads_are_read) {
    for (int i = 0; i < 4 * FLAVOURS; ++i) {
        ply_maker m;
        ply_header(&m, (ply_flavour)(i / 4), XYZ FACES(2), (size_t)i);
        ply_square(&m);
        ROW(&m, "biii biii", 3, 0, 1, 2, 3, 0, 2, 3);
        fathom_scene *scene = ply_read(&m);
        ply_expect_square(scene);
        ply_header(&m, (ply_flavour)(i / 4), XYZ FACES(1), (size_t)i);
        ply_square(&m);
        ROW(&m, "biiii", 4, 0, 1, 2, 3);
        scene = ply_read(&m);
        ply_expect_square(scene);
    }
}

/* The scene keeps a file whose vertices it can use as they are: aligned, little endian, floats side by side.
 */
UNIT_TEST(aligned_floats_are_used_in_place) {
    for (size_t shift = 0; shift < 2; ++shift) {
        ply_maker m;
        ply_header(
            &m, LITTLE,
            "element vertex 4\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float x\n"
            "property float y\nproperty float z\nproperty uchar a\nproperty ushort b\nproperty uchar "
            "c\n" FACES(1),
            shift);
        for (int i = 0; i < 4; ++i) ROW(&m, "ffffffbsb", 0, 0, i + 1, i % 2, i / 2, 0, 1, 2, 3);
        ROW(&m, "biiii", 4, 0, 1, 3, 2);
        fathom_scene *scene = ply_read(&m);
        const fathom_mesh *mesh = mesh_at(scene, 0);
        assert_int_equal(mesh->position_stride, shift ? 12 : 28);
        assert_int_equal(mesh->normal_stride, shift ? 12 : 28);
        for (uint32_t i = 0; i < 4; ++i) {
            mesh_expect_point(mesh, i, i % 2, i / 2, 0);
            assert_true(mesh_row(mesh->normals, mesh->normal_stride, i)[2] == (float)i + 1);
        }
    }
}

/* Every type and both of its names, for coordinates and for indices. */
UNIT_TEST(all_number_types_are_read) {
    static const struct {
        const char *names[2];
        char code;
    } types[] = {{{"char", "int8"}, 'b'},     {{"uchar", "uint8"}, 'b'},    {{"short", "int16"}, 's'},
                 {{"ushort", "uint16"}, 's'}, {{"int", "int32"}, 'i'},      {{"uint", "uint32"}, 'i'},
                 {{"float", "float32"}, 'f'}, {{"double", "float64"}, 'd'}, {{"int64", "int64"}, 'l'},
                 {{"uint64", "uint64"}, 'l'}};
    for (int i = 0; i < 10 * 2 * FLAVOURS; ++i) {
        ply_maker m;
        char codes[32];
        const char *name = types[i % 10].names[i / 10 % 2], code = types[i % 10].code;
        ply_header(&m, (ply_flavour)(i / 20),
                   unit_text("element vertex 4\nproperty %s x\nproperty %s y\nproperty %s z\n"
                             "element face 2\nproperty list %s %s vertex_index\n",
                             name, name, name, name, name),
                   0);
        memset(codes, code, sizeof codes);
        codes[3] = codes[7] = codes[11] = ' ', codes[15] = '\0';
        ply_row(&m, codes, (const double[]){0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
        codes[3] = code, codes[4] = ' ', codes[7] = code, codes[9] = '\0';
        ply_row(&m, codes, (const double[]){3, 0, 1, 2, 3, 0, 2, 3});
        fathom_scene *scene = ply_read(&m);
        ply_expect_square(scene);
    }
}

/* Some programs write names in upper case. */
UNIT_TEST(names_of_properties_have_no_case) {
    for (ply_maker m = {0};
         ply_each(&m, "element vertex 4\nproperty float X\nproperty float Y\nproperty float Z\n"
                      "property float Nx\nproperty float Ny\nproperty float Nz\n"
                      "property uchar Red\nproperty uchar Green\nproperty uchar Blue\n"
                      "element face 2\nproperty list uchar int Vertex_Indices\n");) {
        for (int i = 0; i < 4; ++i) ROW(&m, "ffffffbbb", i == 1 || i == 2, i / 2, 0, 0, 0, 1, 255, 0, 0);
        ROW(&m, "biii biii", 3, 0, 1, 2, 3, 0, 2, 3);
        const fathom_scene *scene = ply_read(&m);
        ply_expect_square(scene);
        assert_true(mesh_at(scene, 0)->normals && mesh_at(scene, 0)->colors[0] == 1);
        assert_int_equal(warning_count, 0);
    }
}

/* Signs are kept: characters and shorts below zero, indices above 127 and 32767. */
UNIT_TEST(signed_and_unsigned_numbers_differ) {
    for (ply_maker m = {0};
         ply_each(&m, "element vertex 201\nproperty char x\nproperty short y\nproperty int z\n"
                      "element face 1\nproperty list uchar uchar vertex_indices\n");) {
        for (int i = 0; i < 201; ++i) ROW(&m, "bsi", -i / 2, -i * 100, -i * 100000);
        ROW(&m, "bbbb", 3, 0, 128, 200);
        fathom_scene *scene = ply_read(&m);
        const uint32_t expected[3] = {0, 1, 2}; /* the used ones alone */
        mesh_expect_indices(mesh_at(scene, 0)->indices, expected, 3);
        mesh_expect_point(mesh_at(scene, 0), 1, -64, -12800, -12800000);
        mesh_expect_point(mesh_at(scene, 0), 2, -100, -20000, -20000000);
    }
}

/* Properties in any order, lists among the vertex's, faces before vertices, elements between and behind. */
UNIT_TEST(elements_may_come_in_any_order) {
    const char *lines =
        "comment made by hand\nobj_info x\nCreated by Blender3D 247\nelement camera 1\nproperty list uchar "
        "float view\nproperty int id\n"
        "element face 3\nproperty uchar red\nproperty list uint float weights\n"
        "property list short ushort vertex_indices\nproperty double area\n"
        "element edge 2\nproperty int vertex1\nproperty int vertex2\n"
        "element vertex 5\nproperty float z\nproperty uchar red\nproperty list uchar short neighbours\n"
        "property float y\nproperty float t\nproperty double x\nproperty float s\n"
        "element rest 1\nproperty float a\n";
    for (ply_maker m = {0}; ply_each(&m, lines);) {
        ROW(&m, "bffi", 2, 0.5, 0.25, 7);
        ROW(&m, "bisssssd", 1, 0, 4, 0, 1, 2, 3, 1.5);
        ROW(&m, "bifssssd", 1, 1, 0.5, 3, 0, 1, 4, 2.5);
        ROW(&m, "biffssssd", 1, 2, 0.5, 0.5, 3, 4, 1, 2, 2.5);
        ROW(&m, "ii ii", 0, 1, 1, 2);
        for (int i = 0; i < 5; ++i) {
            ply_row(&m, i % 2 ? "fbbffdf" : "fbbsffdf",
                    i % 2 ? (const double[]){0.5 * i, 9, 0, i / 2, i * 10, i % 2, i}
                          : (const double[]){0.5 * i, 9, 1, 77, i / 2, i * 10, i % 2, i});
        }
        ROW(&m, "f", 1);
        fathom_scene *scene = ply_read(&m);
        const fathom_mesh *mesh = mesh_at(scene, 0);
        assert_int_equal(mesh->triangle_count, 4);
        for (uint32_t i = 0; i < 5; ++i) {
            mesh_expect_point(mesh, i, i % 2, i / 2, 0.5 * i);
            assert_true(mesh->uvs[2 * i] == (float)i && mesh->uvs[2 * i + 1] == 10 * (float)i);
        }
        const uint32_t expected[6] = {0, 1, 4, 4, 1, 2};
        mesh_expect_indices(mesh->indices + 6, expected, 6);
    }
}

UNIT_TEST(all_names_of_uvs_are_known) {
    const char *names[3][2] = {{"u", "v"}, {"s", "t"}, {"texture_u", "texture_v"}};
    for (int i = 0; i < 3; ++i) {
        ply_maker m;
        ply_header(&m, ASCII,
                   unit_text(VERTICES(3) "property float %s\nproperty float %s\n" FACES(1), names[i][0],
                             names[i][1]),
                   0);
        ROW(&m, "fffff fffff fffff biii", 0, 0, 0, 0, 1, 1, 0, 0, 2, 3, 0, 1, 0, 4, 5, 3, 0, 1, 2);
        fathom_scene *scene = ply_read(&m);
        for (int k = 0; k < 6; ++k) assert_true(mesh_at(scene, 0)->uvs[k] == (float)k);
    }
}

/* Concave polygons of different sizes in one file, faces too small to be any. */
UNIT_TEST(polygons_are_triangulated) {
    for (ply_maker m = {0}; ply_each(&m, VERTICES(6) FACES(4));) {
        ROW(&m, "fff fff fff fff fff fff", 0, 0, 0, 2, 0, 0, 2, 1, 0, 1, 1, 0, 1, 2, 0, 0, 2, 0);
        ROW(&m, "biiiiii bii biii biiii", 6, 1, 2, 3, 4, 5, 0, 2, 0, 1, 3, 0, 1, 2, 4, 2, 4, 3, 1);
        fathom_scene *scene = ply_read(&m);
        const fathom_mesh *mesh = mesh_at(scene, 0);
        double area = 0;
        for (uint32_t t = 0; t < 4; ++t) {
            const uint32_t *c = mesh->indices + 3 * t;
            vec3_f64 a = mesh_point(mesh, c[0]);
            vec3_f64 n = cross_f64(sub_f64(mesh_point(mesh, c[1]), a), sub_f64(mesh_point(mesh, c[2]), a));
            assert_true(n.z > 0);
            area += 0.5 * n.z;
        }
        assert_true(area == 3);
        assert_int_equal(mesh->triangle_count, 7);
        expect_warning("faces of less than 3 corners are left out (1 such)");
    }
}

/* A strip zigzags: every other triangle is turned round. -1 starts again. */
UNIT_TEST(strips_keep_their_winding) {
    for (ply_maker m = {0};
         ply_each(&m, VERTICES(5) "element tristrips 1\nproperty list int int vertex_indices\n");) {
        ROW(&m, "fff fff fff fff fff", 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0);
        ROW(&m, "iiiiiiiiii", 9, 0, 1, 2, 3, 4, -1, 1, 3, 2);
        const uint32_t expected[12] = {0, 1, 2, 2, 1, 3, 2, 3, 4, 1, 3, 2};
        fathom_scene *scene = ply_read(&m);
        assert_int_equal(mesh_at(scene, 0)->triangle_count, 4);
        mesh_expect_indices(mesh_at(scene, 0)->indices, expected, 12);
    }
}

/* Doubles far out keep what a float of their extent can hold; floats are moved without losing a bit. */
UNIT_TEST(far_meshes_keep_their_digits) {
    for (int i = 0; i < 2 * FLAVOURS; ++i) {
        bool wide = i % 2;
        ply_maker m;
        ply_header(
            &m, (ply_flavour)(i / 2),
            wide ? "element vertex 3\nproperty double x\nproperty double y\nproperty double z\n" FACES(1)
                 : VERTICES(3) FACES(1),
            0);
        const double x = wide ? 6378137.123456789 : 8388607;
        ply_row(&m, wide ? "ddd ddd ddd biii" : "fff fff fff biii",
                (const double[]){x, -x, 0, x - 3, -x, 0, x, 1 - x, 0, 3, 0, 1, 2});
        fathom_scene *scene = ply_read(&m);
        const fathom_mesh *mesh = mesh_at(scene, 0);
        assert_true(mesh->origin[0] != 0);
        vec3_f64 p = mesh_point(mesh, 1), q = mesh_point(mesh, 2);
        /* 1.5 × 2^-24 of half the extent of 3, and double's own. */
        double tolerance = wide ? 1.5 * 1.5 * 0x1p-24 + 0x1p-30 : 0;
        assert_near(p.x, x - 3, tolerance);
        assert_near(p.y, -x, tolerance);
        assert_near(q.y, 1 - x, tolerance);
    }
}

UNIT_TEST(options_are_applied) {
    ply_maker m;
    ply_header(&m, LITTLE, XYZ NORMALS FACES(1), 0);
    for (int i = 0; i < 4; ++i) ROW(&m, "ffffff", i % 2, i / 2, 0, 1, 0, 0);
    ROW(&m, "biiii", 4, 0, 1, 3, 2);
    const char *path = mesh_write("a.ply", m.bytes, m.size);
    fathom_scene *scene =
        mesh_read(read_ply, path, (read_mesh_options){.material = 0, .flat = true, .flags = 1});
    assert_null(mesh_at(scene, 0)->normals);
    assert_int_equal(mesh_at(scene, 0)->flags, 1);
    /* The file's normals are kept. */
    scene = mesh_read(read_ply, path, (read_mesh_options){.material = 0, .smooth = true});
    assert_true(mesh_at(scene, 0)->normals[0] == 1);
    ply_header(&m, BIG, XYZ FACES(1), 0);
    ply_square(&m);
    ROW(&m, "biiii", 4, 0, 1, 2, 3);
    scene = mesh_read(read_ply, mesh_write("a.ply", m.bytes, m.size),
                      (read_mesh_options){.material = FATHOM_NONE, .smooth = true});
    assert_true(mesh_at(scene, 0)->normals[11] == 1);
}

/* Blank lines, tabs and \r\n are no rows; rows beyond those promised are warned about. */
UNIT_TEST(blanks_in_text_change_nothing) {
    const char *text = "ply\r\nformat ascii 1.0\r\n" XYZ FACES(
        2) "end_header\r\n"
           "\r\n0 0 0\r\n\t1 0\t0 \r\n\n1 1 0\n0 1 0\n\n3 0 1 2\n3 0 2 3\n\n5 5\n";
    fathom_scene *scene = mesh_read(read_ply, put_text("a.ply", text), plain);
    ply_expect_square(scene);
    expect_warning("rows after the 6 that the header promises are left out (1 such)");
}

/* The header's lines may end in any way, behind a byte order mark or not; so may rows of text. */
UNIT_TEST(byte_order_mark_and_line_ends_change_nothing) {
    static const char *const ends[] = {"\n", "\r\n", "\r"};
    for (int i = 0; i < 6 * FLAVOURS; ++i) {
        const char *line_end = ends[i / 2 % 3];
        ply_maker plain_file, m = {.flavour = (ply_flavour)(i / 6)};
        ply_header(&plain_file, m.flavour, XYZ FACES(1), 0);
        size_t header = plain_file.size;
        ply_square(&plain_file);
        ROW(&plain_file, "biiii", 4, 0, 1, 2, 3);
        if (i % 2) ply_text(&m, "\xEF\xBB\xBF");
        for (size_t k = 0; k < plain_file.size; ++k) {
            bool text = k < header || m.flavour == ASCII;
            if (text && plain_file.bytes[k] == '\n')
                ply_text(&m, line_end);
            else
                ply_bytes(&m, &plain_file.bytes[k], 1);
        }
        fathom_scene *scene = ply_read(&m);
        ply_expect_square(scene);
        assert_string_equal(warned, "");
    }
}

UNIT_TEST(unused_properties_are_reported) {
    for (ply_maker m = {0};
         ply_each(&m, "comment TextureFile a.png\nelement camera 1\nproperty float view\n" XYZ
                      "property uchar red\nproperty uchar green\nproperty float quality\n" FACES(
                          1) "property uchar blue\n");) {
        ROW(&m, "f", 0);
        const double corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        for (int i = 0; i < 4; ++i) ROW(&m, "fffbbf", corners[i][0], corners[i][1], 0, 1, 2, 3);
        ROW(&m, "biiiib", 4, 0, 1, 2, 3, 9);
        fathom_scene *scene = ply_read(&m);
        ply_expect_square(scene);
        expect_warning(":3: a texture is left out: there is no such image that may be read (1 such");
        expect_warning(":4: element camera is not read (1 such)");
        expect_warning(":6: vertex colours are not used (4 such)");
        expect_warning(":6: element vertex: the property quality is not used (4 such)");
        expect_warning("face colours are not used (1 such)");
    }
}

UNIT_TEST(a_property_of_one_letter_is_no_colour) {
    ply_maker m;
    ply_header(&m, LITTLE, XYZ "property float r\n" FACES(1) "property float a\n", 0);
    ROW(&m, "ffff ffff", 0, 0, 0, 5, 1, 0, 0, 5);
    ROW(&m, "ffff ffff", 1, 1, 0, 5, 0, 1, 0, 5);
    ROW(&m, "biiiif", 4, 0, 1, 2, 3, 7);
    ply_read(&m);
    expect_warning("element vertex: the property r is not used (4 such)");
    expect_warning("element face: the property a is not used (1 such)");
}

/* Without faces each vertex is a point, in its colour. */
UNIT_TEST(clouds_of_points_are_spheres) {
    for (ply_maker m = {0}; ply_each(&m, XYZ RGB("float"));) {
        const double corners[4][2] = {{0, 0}, {4, 0}, {4, 3}, {0, 3}};
        for (int i = 0; i < 4; ++i) ROW(&m, "ffffff", corners[i][0], corners[i][1], 0, i / 4.0, 0, 1);
        fathom_scene *scene = ply_read(&m);
        const fathom_mesh *mesh = mesh_at(scene, 0);
        assert_int_equal(mesh->triangle_count, 0);
        assert_int_equal(mesh->vertex_count, 4);
        assert_true(mesh->point_radius == 0.0625f); /* an eightieth of the diagonal, 5 */
        for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
            mesh_expect_point(mesh, i, corners[i][0], corners[i][1], 0);
            const float *c = mesh_row(mesh->colors, mesh->color_stride, i);
            assert_true(c[0] == (float)i / 4 && c[2] == 1);
        }
        expect_warning("points have no size, and are shown as small spheres (4 such)");
    }
}

/* Vertices without a place: the second row of each file. `far` moves all others, as scans of the ground are.
 */
UNIT_TEST(points_without_a_place_are_left_out) {
    for (int k = 0; k < 2 * FLAVOURS; ++k) {
        const double far = k < FLAVOURS ? 0 : 1e6;
        ply_maker m;
        ply_header(&m, (ply_flavour)(k % FLAVOURS), XYZ RGB("float"), 0);
        ROW(&m, "ffffff", far, 0, 0, 0, 0, 1);
        ROW(&m, "ffffff", (double)NAN, 0, (double)INFINITY, 0.25, 0, 1);
        ROW(&m, "ffffff", far + 4, 3, 0, 0.5, 0, (double)NAN);
        ROW(&m, "ffffff", far, 3, 0, 0.75, 0, 1);
        fathom_scene *scene = ply_read(&m);
        const fathom_mesh *mesh = mesh_at(scene, 0);
        assert_int_equal(mesh->vertex_count, 3);
        assert_true(mesh->point_radius == 0.0625f);
        for (uint32_t i = 0; i < 3; ++i)
            assert_true(mesh_row(mesh->colors, mesh->color_stride, i)[0] ==
                        (i ? 0.25f + 0.25f * (float)i : 0));
        assert_true(mesh_row(mesh->colors, mesh->color_stride, 1)[2] == 0);
        expect_warning("a vertex with a NaN, an infinity or a number beyond float is left out, with what "
                       "uses it (1 such)");
        expect_warning("a NaN or an infinity of a vertex, not in x, y or z, is taken as 0 (1 such)");
    }
}

/* A polygon goes with any of its corners; the bounds, and so the camera, do not know the lost vertex. */
UNIT_TEST(faces_of_lost_vertices_are_left_out) {
    for (ply_maker m = {0}; ply_each(&m, VERTICES(5) FACES(3));) {
        ROW(&m, "fff fff fff fff fff", 0, 0, 0, 1, 0, 0, 1, 1, 0, (double)NAN, 9, 9, 0, 1, 0);
        ROW(&m, "biii biiii biii", 3, 0, 1, 2, 4, 0, 1, 2, 3, 3, 0, 2, 4);
        fathom_scene *scene = ply_read(&m);
        const fathom_mesh *mesh = mesh_at(scene, 0);
        scene_bounds bounds;
        assert_int_equal(mesh->triangle_count, 2);
        for (uint32_t i = 0; i < 6; ++i) assert_true(mesh->indices[i] != 3);
        assert_ok(context, scene_world_bounds(scene, &bounds));
        assert_true(bounds.upper.x == 1 && bounds.upper.y == 1 && bounds.lower.x == 0);
    }
}

/* One warning, and colours as other sRGB colours: 0.5 + f / sqrt(4 pi), clamped. Opacities are logits. */
UNIT_TEST(splats_are_points) {
    for (ply_maker m = {0};
         ply_each(&m, VERTICES(2) "property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\n"
                                  "property float f_rest_0\nproperty float opacity\nproperty float scale_0\n"
                                  "property float rot_0\n");) {
        ROW(&m, "ffffffffff", 0, 0, 0, 0, 9, -9, 0, 0, 0, 0);
        ROW(&m, "ffffffffff", 1, 0, 0, 1, 0, 0, 0, -9, 0, 0);
        fathom_scene *scene = ply_read(&m);
        const fathom_mesh *mesh = mesh_at(scene, 0);
        const float *first = mesh_row(mesh->colors, mesh->color_stride, 0),
                    *second = mesh_row(mesh->colors, mesh->color_stride, 1);
        assert_true(mesh->point_radius > 0 && mesh->vertex_count == 2);
        assert_near(first[0], 0.21404114048223255, 1e-6);
        assert_true(first[1] == 1 && first[2] == 0);
        assert_near(second[0], 0.57392247541874, 1e-6);
        assert_int_equal(mesh->color_channels, 4);
        assert_true(first[3] == 0.5f);
        assert_near(second[3], 1 / (1 + exp(9)), 1e-10);
        expect_warning("Gaussian splats are shown as points of their mean colours and opacities, without "
                       "their sizes and directions (2 such)");
        assert_ptr_equal(strchr(warned, '\n') + 1, warned + strlen(warned));
    }
}

#define LOOK_FACES(count) FACES(count) "property list uchar float texcoord\n"

static const char *image(const char *name) { return mesh_write(name, "P6 1 1 255\nabc", 14); }

/* u or v of a corner of a triangle. */
static float uv_at(const fathom_mesh *mesh, size_t corner, int k) {
    const uint32_t *indices = mesh->uv_indices ? mesh->uv_indices : mesh->indices;
    assert_true(indices[corner] < mesh->uv_count);
    return mesh_row(mesh->uvs, mesh->uv_stride, indices[corner])[k];
}

/* The first triangle, and a concave polygon whose fan is split anew, have different uvs at shared vertices:
 * they are x and y, and 10 more on the polygon. Equal uvs at a vertex are stored once. */
UNIT_TEST(corners_have_uvs_of_their_own) {
    image("t.ppm");
    for (ply_maker m = {0};
         ply_each(&m, "comment TextureFile t.ppm\nelement vertex 5\nproperty float x\nproperty float y\n"
                      "property float z\nproperty float s\nproperty float t\n" LOOK_FACES(2));) {
        ROW(&m, "fffff fffff fffff", 0, 0, 0, 7, 7, 4, 0, 0, 7, 7, 1, 1, 0, 7, 7);
        ROW(&m, "fffff fffff", 0, 4, 0, 7, 7, -4, -4, 0, 7, 7);
        ROW(&m, "biiibffffff", 3, 0, 1, 4, 6, 0, 0, 4, 0, -4, -4);
        ROW(&m, "biiiibffffffff", 4, 3, 0, 1, 2, 8, 10, 14, 10, 10, 14, 10, 11, 11);
        fathom_scene *scene = ply_read(&m);
        const fathom_mesh *mesh = mesh_at(scene, 0);
        assert_int_equal(mesh->triangle_count, 3);
        assert_int_equal(mesh->vertex_count, 5);
        assert_int_equal(mesh->uv_count, 7);
        for (size_t i = 0; i < 9; ++i) {
            const vec3_f64 p = mesh_point(mesh, mesh->indices[i]);
            assert_true((double)uv_at(mesh, i, 0) == p.x + (i < 3 ? 0 : 10));
            assert_true((double)uv_at(mesh, i, 1) == p.y + (i < 3 ? 0 : 10));
        }
        assert_true(scene->materials.items[mesh->material].value.maps[FATHOM_MAP_COLOR].texture == 0);
        expect_warning("element vertex: the property s is not used (5 such)");
        assert_null(strstr(warned, "texcoord"));
    }
}

/* A mesh for each texture; -1, or a number without an image, is no texture. */
UNIT_TEST(each_texture_is_one_mesh) {
    image("t.ppm");
    image("s.ppm");
    for (ply_maker m = {0};
         ply_each(&m, "comment TextureFile t.ppm\ncomment TextureFile none.ppm\ncomment TextureFile "
                      "s.ppm\n" XYZ LOOK_FACES(6) "property int texnumber\n");) {
        ply_square(&m);
        static const int numbers[6] = {2, 0, -1, 2, 1, 9};
        for (int i = 0; i < 6; ++i)
            ROW(&m, "biiibffffffi", 3, 0, 1 + i % 2, 2 + i % 2, 6, i, 1, i, 2, i, 3, numbers[i]);
        fathom_scene *scene = ply_read(&m);
        assert_int_equal(scene->meshes.count, 3);
        static const int expected[3][3] = {{1}, {0, 3}, {2, 4, 5}}, counts[3] = {1, 2, 3};
        for (size_t k = 0; k < 3; ++k) {
            const fathom_mesh *mesh = mesh_at(scene, k);
            assert_int_equal(mesh->triangle_count, counts[k]);
            for (size_t t = 0; t < mesh->triangle_count; ++t) {
                assert_true(uv_at(mesh, 3 * t, 0) == (float)expected[k][t]);
                assert_true(uv_at(mesh, 3 * t + 2, 1) == 3);
            }
            const fathom_map *map = &scene->materials.items[mesh->material].value.maps[FATHOM_MAP_COLOR];
            assert_true(map->texture == (k < 2 ? (fathom_id)k : FATHOM_NONE));
        }
        expect_warning(":4: a texture is left out: there is no such image that may be read (1 such");
        expect_warning("texnumber: a face with the number of no TextureFile gets no texture (1 such)");
    }
    ply_maker m;
    ply_header(&m, ASCII, "comment TextureFile t.ppm\ncomment TextureFile s.ppm\n" XYZ LOOK_FACES(1), 0);
    ply_square(&m);
    ROW(&m, "biiibffffff", 3, 0, 1, 2, 6, 0, 0, 1, 0, 0, 1);
    ply_read(&m);
    expect_warning(":4: textures after the first one are left out, because faces have no texnumber (1 such");
}

/* Lists of another length, and numbers that are none, are 0; faces of a lost vertex take theirs along. */
UNIT_TEST(odd_uvs_of_corners_are_zero) {
    for (ply_maker m = {0}; ply_each(&m, XYZ LOOK_FACES(4));) {
        ROW(&m, "fff fff fff fff", (double)NAN, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0);
        ROW(&m, "biiibffffff", 3, 0, 1, 2, 6, 9, 9, 9, 9, 9, 9);
        ROW(&m, "biiibffffff", 3, 1, 2, 3, 6, 5, 5, 5, 5, 5, (double)NAN);
        ROW(&m, "biiib", 3, 1, 2, 3, 0);
        ROW(&m, "biiibffffff", 3, 1, 2, 3, 6, 6, 6, 6, 6, 6, 6);
        fathom_scene *scene = ply_read(&m);
        const fathom_mesh *mesh = mesh_at(scene, 0);
        static const float expected[3] = {5, 0, 6};
        assert_int_equal(mesh->triangle_count, 3);
        for (size_t i = 0; i < 9; ++i) {
            assert_true(uv_at(mesh, i, 0) == expected[i / 3]);
            assert_true(uv_at(mesh, i, 1) == (i == 2 ? 0 : expected[i / 3]));
        }
        expect_warning("texcoord: a face without 2 numbers for each corner gets 0 for all of them (1 such)");
        expect_warning("a NaN or an infinity of a face is taken as 0 (1 such)");
    }
}

/* Vertices between two colours are doubled, and keep their normals and uvs. */
UNIT_TEST(colours_of_faces_are_shown) {
    for (int k = 0; k < 2 * FLAVOURS; ++k) {
        const bool alpha = k >= FLAVOURS;
        ply_maker m;
        const char *lines = unit_text(
            XYZ "property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty "
                "float t\nproperty float s1\nproperty float t1\n" FACES(
                    3) "property uchar red\nproperty uchar green\nproperty uchar blue\n%s",
            alpha ? "property uchar alpha\n" : "property uchar quality\n");
        ply_header(&m, (ply_flavour)(k % FLAVOURS), lines, 0);
        for (int i = 0; i < 4; ++i)
            ROW(&m, "ffffffffff", (i + 1) / 2 % 2, i / 2, 0, 0, 0, i + 1, i, 2 * i, 3 * i, 4 * i);
        ROW(&m, "biiibbbb", 3, 0, 1, 2, 255, 0, 188, 51);
        ROW(&m, "biiibbbb", 3, 0, 2, 3, 0, 255, 0, 255);
        ROW(&m, "biiibbbb", 3, 0, 3, 2, 0, 255, 0, 255);
        fathom_scene *scene = ply_read(&m);
        const fathom_mesh *mesh = mesh_at(scene, 0);
        static const uint32_t old[9] = {0, 1, 2, 0, 2, 3, 0, 3, 2};
        assert_int_equal(mesh->vertex_count, 6);
        assert_int_equal(mesh->color_channels, alpha ? 4 : 3);
        assert_true(scene->materials.items[mesh->material].value.k_d[0] == 1);
        for (size_t i = 0; i < 9; ++i) {
            const float *c = mesh_row(mesh->colors, mesh->color_stride, mesh->indices[i]),
                        *s1 = mesh_row(mesh->uvs_1, mesh->uv_1_stride, mesh->indices[i]),
                        *n = mesh_row(mesh->normals, mesh->normal_stride, mesh->normal_indices[i]);
            const uint32_t v = old[i];
            mesh_expect_point(mesh, mesh->indices[i], (v + 1) / 2 % 2, v / 2, 0);
            assert_true(c[0] == (i < 3) && c[1] == (i >= 3));
            assert_near(c[2], i < 3 ? 0.50288653 : 0, 1e-7);
            if (alpha) assert_true(c[3] == (i < 3 ? 0.2f : 1));
            assert_true(n[2] == (float)v + 1 && uv_at(mesh, i, 0) == (float)v && s1[1] == 4 * (float)v);
        }
        assert_null(strstr(warned, "colours"));
    }
}

/* Colours of vertices are finer, and go first. */
UNIT_TEST(colours_of_vertices_go_before_those_of_faces) {
    ply_maker m;
    ply_header(&m, LITTLE, XYZ RGB("uchar") FACES(1) RGB("uchar"), 0);
    ROW(&m, "fffbbb fffbbb", 0, 0, 0, 255, 0, 0, 1, 0, 0, 255, 0, 0);
    ROW(&m, "fffbbb fffbbb", 1, 1, 0, 255, 0, 0, 0, 1, 0, 255, 0, 0);
    ROW(&m, "biiiibbb", 4, 0, 1, 2, 3, 0, 0, 255);
    fathom_scene *scene = ply_read(&m);
    assert_true(mesh_at(scene, 0)->colors[0] == 1 && mesh_at(scene, 0)->colors[2] == 0);
    expect_warning("face colours are not used (1 such)");
}

/* A material that a scene gives to the file may have images. */
UNIT_TEST(images_without_uvs_are_one_texel) {
    ply_maker m;
    ply_header(&m, LITTLE, XYZ FACES(1), 0);
    ply_square(&m);
    ROW(&m, "biiii", 4, 0, 1, 2, 3);
    read_mesh_options options = plain;
    fathom_texture texture = default_texture();
    fathom_material material = default_material();
    texture.file = mesh_write("t.ppm", "P6 1 1 255\nabc", 14);
    forget_warnings();
    fathom_scene *scene = new_scene(context);
    assert_ok(context, fathom_scene_add_texture(scene, &texture, &material.maps[FATHOM_MAP_COLOR].texture));
    assert_ok(context, fathom_scene_add_material(scene, "m", &material, &options.material));
    assert_ok(context, read_ply(scene, FATHOM_ROOT, mesh_write("a.ply", m.bytes, m.size), &options));
    for (int i = 0; i < 8; ++i) assert_true(mesh_at(scene, 0)->uvs[i] == 0);
    expect_warning("a mesh has a material with images but no texture coordinates; it shows their colour at "
                   "(0, 0) (1 such)");
}

/* Scanning programs write them twice. Fathom's own files mean their product. */
UNIT_TEST(colours_of_vertices_give_way_to_an_image) {
    image("t.ppm");
    for (int i = 0; i < 3; ++i) { /* of a scanning program, of Fathom, without texture coordinates */
        char file[1024];
        const char *uv = i < 2 ? " 0 1" : "";
        const int size = snprintf(
            file, sizeof file,
            "ply\nformat ascii 1.0\ncomment %s\ncomment TextureFile t.ppm\nelement vertex 3\nproperty "
            "float x\nproperty float y\nproperty float z\n%sproperty uchar red\nproperty uchar "
            "green\nproperty uchar blue\nelement face 1\nproperty list uchar int vertex_indices\n"
            "end_header\n0 0 0%s 255 0 0\n1 0 0%s 255 0 0\n0 1 0%s 255 0 0\n3 0 1 2\n",
            i == 1 ? "Fathom 0.1.0" : "by hand", *uv ? "property float s\nproperty float t\n" : "", uv, uv,
            uv);
        forget_warnings();
        fathom_scene *scene = mesh_read(read_ply, mesh_write("a.ply", file, (size_t)size), plain);
        assert_int_equal(mesh_at(scene, 0)->colors != NULL, i > 0);
        if (!i) expect_warning("colours of vertices are left out where an image has them (1 such)");
    }
}

/* No face uses the third vertex, so that the bounds do not have it. */
UNIT_TEST(stray_vertices_are_left_out) {
    for (ply_maker m = {0}; ply_each(&m, VERTICES(5) FACES(2));) {
        ROW(&m, "fff fff fff fff fff", 0, 0, 0, 1, 0, 0, 9, 0, -9, 1, 1, 0, 0, 1, 0);
        ROW(&m, "biii biii", 3, 0, 1, 3, 3, 0, 3, 4);
        fathom_scene *scene = ply_read(&m);
        const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
        scene_bounds bounds;
        assert_int_equal(mesh_at(scene, 0)->vertex_count, 4);
        mesh_expect_indices(mesh_at(scene, 0)->indices, corners, 6);
        assert_ok(context, scene_world_bounds(scene, &bounds));
        assert_true(bounds.upper.x == 1 && bounds.upper.y == 1 && bounds.lower.z == 0);
    }
}

/* With faces or without: a rod of a three hundredth of the diagonal, 5, in its ends' colours. */
UNIT_TEST(edges_are_rods) {
    for (int flavour = 0; flavour < 2 * FLAVOURS; ++flavour) {
        const bool faces = flavour < FLAVOURS;
        ply_maker m;
        ply_header(&m, (ply_flavour)(flavour % FLAVOURS),
                   unit_text("%selement edge 2\nproperty %s\nproperty ushort vertex2\nproperty %s\n%s", XYZ,
                             faces ? "int vertex1" : "uchar quality", faces ? "uchar quality" : "int vertex1",
                             faces ? FACES(1) : ""),
                   0);
        const double corners[4][2] = {{0, 0}, {4, 0}, {4, 3}, {0, 3}};
        for (int i = 0; i < 4; ++i) ROW(&m, "fff", corners[i][0], corners[i][1], 0);
        if (faces)
            ROW(&m, "isb isb", 0, 1, 7, 1, 2, 7);
        else
            ROW(&m, "bsi bsi", 7, 1, 0, 7, 2, 1);
        if (faces) ROW(&m, "biiii", 4, 0, 1, 2, 3);
        fathom_scene *scene = ply_read(&m);
        assert_int_equal(scene->meshes.count, faces ? 2 : 1);
        const fathom_mesh *mesh = mesh_at(scene, faces);
        assert_int_equal(mesh->triangle_count, 2 * ROD_TRIANGLES);
        for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
            const vec3_f64 p = widen(load_f32(mesh->positions + 3 * i));
            const double x = fmin(fmax(p.x, 0), 4), y = fmin(fmax(p.y, 0), 3);
            /* From the first edge, then from the second. Coordinates up to 4 are rounded by 2^-22. */
            assert_near(i < ROD_VERTICES ? length_f64((vec3_f64){p.x - x, p.y, p.z})
                                         : length_f64((vec3_f64){p.x - 4, p.y - y, p.z}),
                        5 / 300.0, 0x1p-21);
        }
        expect_warning("edges have no width, and are shown as thin rods (2 such)");
        expect_warning("element edge: the property quality is not used (2 such)");
    }
}

/* Whole numbers are as screens show them; floats are linear. */
UNIT_TEST(vertex_colours_are_read) {
    for (int flavour = 0; flavour < 2 * FLAVOURS; ++flavour) {
        const bool whole = flavour < FLAVOURS;
        ply_maker m;
        ply_header(&m, (ply_flavour)(flavour % FLAVOURS),
                   whole ? XYZ RGB("uchar") FACES(1) : XYZ RGB("float") FACES(1), 0);
        const double corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        for (int i = 0; i < 4; ++i) {
            if (whole)
                ROW(&m, "fffbbb", corners[i][0], corners[i][1], 0, 255, 0, 188);
            else
                ROW(&m, "ffffff", corners[i][0], corners[i][1], 0, 1, 0, 0.5);
        }
        ROW(&m, "biiii", 4, 0, 1, 2, 3);
        fathom_scene *scene = ply_read(&m);
        const fathom_mesh *mesh = mesh_at(scene, 0);
        for (uint32_t i = 0; i < 4; ++i) {
            const float *rgb = mesh_row(mesh->colors, mesh->color_stride, i);
            assert_true(rgb[0] == 1 && rgb[1] == 0);
            assert_near(rgb[2], whole ? 0.50288653 : 0.5, 1e-7);
        }
        assert_true(scene->materials.items[mesh->material].value.k_d[0] == 1);
    }
}

/* Floats are bytes if all are whole numbers up to 255, and one is above 2; but Fathom's own are light. */
UNIT_TEST(float_colours_of_bytes_are_decoded) {
    static const struct {
        const char *comment;
        double red, alpha;
        bool bytes;
    } cases[] = {{"", 255, 51, true},  {"", 255, 0.2, true}, {"", 254.5, 51, false},
                 {"", 256, 51, false}, {"", 2, 0.2, false},  {"comment Fathom 1\n", 255, 0.2, false},
                 {"", -255, 51, false}};
    for (size_t k = 0; k < FLAVOURS * sizeof cases / sizeof *cases; ++k) {
        const bool bytes = cases[k / FLAVOURS].bytes;
        const double red = cases[k / FLAVOURS].red, alpha = cases[k / FLAVOURS].alpha;
        ply_maker m;
        ply_header(
            &m, (ply_flavour)(k % FLAVOURS),
            unit_text(
                "%selement vertex 2\nproperty float x\nproperty float y\nproperty float z\nproperty float "
                "red\nproperty float green\nproperty float blue\nproperty float alpha\n",
                cases[k / FLAVOURS].comment),
            0);
        ROW(&m, "fffffff fffffff", 0, 0, 0, red, 0, 2, alpha, 1, 0, 0, 0, 0, 1, alpha);
        fathom_scene *scene = ply_read(&m);
        const fathom_mesh *mesh = mesh_at(scene, 0);
        assert_true(mesh->colors[0] == (bytes ? 1 : (float)red));
        assert_near(mesh->colors[2], bytes ? 2 / 255.0 / 12.92 : 2, 1e-7);
        if (bytes) assert_near(mesh->colors[3], 0.2, 1e-7);
        if (bytes)
            expect_warning("vertex colours are floats, but whole numbers up to 255; they are read as "
                           "sRGB bytes (2 such)");
        if (!bytes) assert_null(strstr(warned, "bytes"));
    }
}

/* The same of faces. */
UNIT_TEST(float_face_colours_of_bytes_are_decoded) {
    for (int k = 0; k < 3 * FLAVOURS; ++k) {
        const bool bytes = k < 2 * FLAVOURS, alpha = k < FLAVOURS;
        ply_maker m;
        ply_header(&m, (ply_flavour)(k % FLAVOURS),
                   unit_text("%s" XYZ FACES(2) RGB("float") "property float alpha\n",
                             k % 2 ? "" : "comment from a scanner\n"),
                   0);
        for (int i = 0; i < 4; ++i) ROW(&m, "fff", (i + 1) / 2 % 2, i / 2, 0);
        ROW(&m, "biiiiffff", 4, 0, 1, 2, 3, 255, 0, bytes ? 2 : 2.5, alpha ? 51 : 0.2);
        ROW(&m, "biiiffff", 3, 0, 2, 3, 0, 0, 0, alpha ? 51 : 0.2);
        fathom_scene *scene = ply_read(&m);
        const fathom_mesh *mesh = mesh_at(scene, 0);
        const float *c = mesh_row(mesh->colors, mesh->color_stride, mesh->indices[0]);
        assert_true(c[0] == (bytes ? 1 : 255));
        assert_near(c[2], bytes ? 2 / 255.0 / 12.92 : 2.5, 1e-7);
        if (bytes) assert_near(c[3], 0.2, 1e-7);
        if (bytes)
            expect_warning(
                "face colours are floats, but whole numbers up to 255; they are read as sRGB bytes (2 such)");
        if (!bytes) assert_null(strstr(warned, "bytes"));
    }
}

/* Opacity is a part of its type's range; 0 at all vertices is what some programs write for none. So is a
 * second uv set kept. */
UNIT_TEST(opacities_and_second_uvs_are_read) {
    for (int flavour = 0; flavour < 4 * FLAVOURS; ++flavour) {
        const bool whole = flavour / FLAVOURS % 2, clear = flavour / FLAVOURS / 2;
        ply_maker m;
        ply_header(
            &m, (ply_flavour)(flavour % FLAVOURS),
            whole ? XYZ RGB("uchar") "property uchar alpha\nproperty float s1\nproperty float t1\n" FACES(1)
                  : XYZ RGB("float") "property float alpha\nproperty float s1\nproperty float t1\n" FACES(1),
            0);
        const double corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, most = whole ? 255 : 1;
        for (int i = 0; i < 4; ++i)
            ROW(&m, whole ? "fffbbbbff" : "fffffffff", corners[i][0], corners[i][1], 0, most, 0, most,
                clear || i ? 0 : most / 5, 0.25 * i, 0.5);
        ROW(&m, "biiii", 4, 0, 1, 2, 3);
        fathom_scene *scene = ply_read(&m);
        const fathom_mesh *mesh = mesh_at(scene, 0);
        assert_int_equal(mesh->color_channels, clear ? 3 : 4);
        if (!clear) assert_near(mesh->colors[3], 0.2, 1e-7);
        if (clear) expect_warning("alpha is 0 at all vertices, and left out (4 such)");
        const float *second = mesh_row(mesh->uvs_1, mesh->uv_1_stride, 1);
        assert_true(second[0] == 0.25f && second[1] == 0.5f);
    }
}

/* Behind the last row, and behind the last number of a row of text. */
UNIT_TEST(extra_rows_are_reported) {
    for (ply_maker m = {0}; ply_each(&m, XYZ FACES(1));) {
        ply_square(&m);
        ROW(&m, "biiii", 4, 0, 1, 2, 3);
        ply_text(&m, "1 2\n3 4\n");
        fathom_scene *scene = ply_read(&m);
        ply_expect_square(scene);
        expect_warning(m.flavour == ASCII
                           ? "rows after the 5 that the header promises are left out (2 such)"
                           : "bytes after the rows that the header promises are left out (8 such)");
    }
    ply_maker m = {.flavour = ASCII};
    ply_text(
        &m, "ply\nformat ascii 1.0\n" XYZ FACES(1) "end_header\n0 0 0\n1 0 0 7\n1 1 0\n0 1 0\n4 0 1 2 3 4\n");
    fathom_scene *scene = ply_read(&m);
    ply_expect_square(scene);
    expect_warning(
        ":11: numbers beyond the properties of the header are left out (2 such, the first here: \"7\")");
}

/* Many blocks and pieces; rows all alike (7 corners) or of 3 to 7. */
static size_t big_file(char **out, ply_flavour flavour, bool alike) {
    enum { vertices = 70000, faces = 50000 };
    static ply_maker m;
    char *text = malloc(8 << 20), lines[256];
    size_t size = 0;
    random_state random = {8};
    snprintf(lines, sizeof lines,
             "element vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
             "element face %d\nproperty list uchar int vertex_indices\n",
             vertices, faces);
    ply_header(&m, flavour, lines, 0);
    for (int i = 0; i < vertices + faces; ++i) {
        double values[8];
        int n = alike ? 7 : 3 + (int)(random_bits(&random) % 5);
        for (int k = 0; k < 8; ++k)
            values[k] = i < vertices ? (double)(float)random_unit(&random) : i % 60000 + k * k;
        values[0] = i < vertices ? values[0] : n;
        const char *types = "biiiiiii";
        char row[9];
        snprintf(row, sizeof row, "%.*s", n + 1, types);
        ply_row(&m, i < vertices ? "fff" : row, values);
        memcpy(text + size, m.bytes, m.size);
        size += m.size;
        m.size = 0;
    }
    *out = text;
    return size;
}

/* All flavours of a file, on any number of threads, are one mesh. */
static void expect_one_mesh(bool alike) {
    fathom_scene *first = NULL;
    for (int flavour = 0; flavour < FLAVOURS; ++flavour) {
        char *bytes;
        size_t size = big_file(&bytes, (ply_flavour)flavour, alike);
        const char *path = mesh_write("big.ply", bytes, size);
        free(bytes);
        for (unsigned threads = 1; threads <= 7; threads += SANITIZED ? 6 : 3) {
            fathom_context_set_threads(context, threads);
            fathom_scene *scene = mesh_read(read_ply, path, plain);
            if (first)
                mesh_expect_equal(mesh_at(first, 0), mesh_at(scene, 0));
            else
                first = scene;
        }
    }
    if (alike) assert_int_equal(mesh_at(first, 0)->triangle_count, 5 * 50000);
    fathom_context_set_threads(context, 0);
}

UNIT_TEST(meshes_do_not_depend_on_thread_count) {
    expect_one_mesh(true);
    expect_one_mesh(false);
}

int main(void) { return unit_main(open_folder, remove_folder); }
