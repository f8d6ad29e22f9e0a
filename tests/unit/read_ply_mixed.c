/* PLY files whose properties are of rare types, or only part of what belongs together. */
#include "ply_file.h"

#include "read/mesh/strokes.h"

/* Bytes in wider integers: the value that means white is 255, as long as no channel is above. */
UNIT_TEST(whole_colours_of_bytes_are_decoded) {
    static const struct {
        const char *type;
        char code;
        double red, blue, expected;
        const char *told;
    } cases[] = {
        {"int", 'i', 255, 51, 1, "sRGB bytes"},          {"uint", 'i', 255, 51, 1, "sRGB bytes"},
        {"short", 's', 255, 51, 1, "sRGB bytes"},        {"ushort", 's', 255, 51, 1, "sRGB bytes"},
        {"ushort", 's', 65535, 13107, 1, NULL},          {"uchar", 'b', 255, 51, 1, NULL},
        {"uint", 'i', 4294967295.0, 858993459, 1, NULL},
    };
    for (size_t k = 0; k < 2 * FLAVOURS * sizeof cases / sizeof *cases; ++k) {
        const size_t i = k / (2 * FLAVOURS);
        const bool faces = k / FLAVOURS % 2;
        ply_maker m;
        const char *colors = unit_text("property %s red\nproperty %s green\nproperty %s blue\n",
                                       cases[i].type, cases[i].type, cases[i].type);
        ply_header(&m, (ply_flavour)(k % FLAVOURS),
                   unit_text(VERTICES(3) "%s" FACES(1) "%s", faces ? "" : colors, faces ? colors : ""), 0);
        const char row[] = {cases[i].code, cases[i].code, cases[i].code, 0};
        const double color[] = {cases[i].red, 0, cases[i].blue};
        for (int v = 0; v < 3; ++v) {
            char types[8];
            snprintf(types, sizeof types, "fff%s", faces ? "" : row);
            const double values[] = {v % 2, v / 2, 0, color[0], color[1], color[2]};
            ply_row(&m, types, values);
        }
        const char *types = unit_text("biii%s", faces ? row : "");
        const double face[] = {3, 0, 1, 2, color[0], color[1], color[2]};
        ply_row(&m, types, face);
        fathom_scene *scene = ply_read(&m);
        const float *c = mesh_at(scene, 0)->colors;
        /* A fifth of the range of sRGB: ((0.2 + 0.055) / 1.055)^2.4. */
        if (fabs((double)c[0] - cases[i].expected) > 0 || fabs((double)c[2] - 0.0331047666) > 1e-7)
            fail_msg("%s of %s: (%g, %g, %g)", cases[i].type, faces ? "faces" : "vertices", (double)c[0],
                     (double)c[1], (double)c[2]);
        if (cases[i].told)
            expect_warning(cases[i].told);
        else
            assert_null(strstr(warned, "bytes"));
    }
}

/* Opacities have a type of their own. */
UNIT_TEST(opacities_follow_their_own_type) {
    static const struct {
        const char *colors, *alphas, *row;
        double red, alpha;
    } cases[] = {{"uchar", "ushort", "bbbs", 255, 13107}, {"uchar", "ushort", "bbbs", 255, 51},
                 {"float", "ushort", "fffs", 1, 13107},   {"ushort", "uchar", "sssb", 65535, 51},
                 {"int", "float", "iiif", 255, 0.2},      {"ushort", "ushort", "ssss", 65535, 13107}};
    for (size_t k = 0; k < 2 * sizeof cases / sizeof *cases; ++k) {
        const size_t i = k / 2;
        const bool faces = k % 2;
        char types[16];
        ply_maker m;
        const char *colors = unit_text("property %s r\nproperty %s g\nproperty %s b\nproperty %s a\n",
                                       cases[i].colors, cases[i].colors, cases[i].colors, cases[i].alphas);
        ply_header(&m, BIG,
                   unit_text(VERTICES(3) "%s" FACES(1) "%s", faces ? "" : colors, faces ? colors : ""), 0);
        const double red = cases[i].red, alpha = cases[i].alpha;
        snprintf(types, sizeof types, "fff%s", faces ? "" : cases[i].row);
        for (int v = 0; v < 3; ++v) ROW(&m, types, v % 2, v / 2, 0, red, 0, 0, alpha);
        snprintf(types, sizeof types, "biii%s", faces ? cases[i].row : "");
        ROW(&m, types, 3, 0, 1, 2, red, 0, 0, alpha);
        fathom_scene *scene = ply_read(&m);
        const float *c = mesh_at(scene, 0)->colors;
        assert_int_equal(mesh_at(scene, 0)->color_channels, 4);
        if (c[0] != 1 || c[1] != 0 || fabs((double)c[3] - 0.2) > 0x1p-24)
            fail_msg("%s with %s: (%g, %g), alpha %g", cases[i].colors, cases[i].alphas, (double)c[0],
                     (double)c[1], (double)c[3]);
    }
}

/* Of a face without an alpha nothing odd is told, whatever the vertices before it hold. */
UNIT_TEST(odd_normals_say_nothing_about_faces) {
    for (ply_maker m = {0}; ply_each(&m, XYZ NORMALS FACES(1) RGB("uchar"));) {
        for (int i = 0; i < 4; ++i)
            ROW(&m, "ffffff", (i + 1) / 2 % 2, i / 2, 0, (double)NAN, (double)NAN, (double)NAN);
        ROW(&m, "biiiibbb", 4, 0, 1, 2, 3, 255, 0, 0);
        ply_read(&m);
        expect_warning("a NaN or an infinity of a vertex");
        assert_null(strstr(warned, "of a face"));
    }
}

/* Lists whose lengths and indices have any type, next to lists that nothing reads. */
UNIT_TEST(lists_of_every_type_are_read) {
    static const char *const names[] = {"char", "uchar", "short",  "ushort", "int",
                                        "uint", "int64", "uint64", "float",  "double"};
    static const char codes[] = "bbssiillfd";
    for (size_t k = 0; k < 10 * 10 * FLAVOURS; ++k) {
        const size_t length = k / FLAVOURS % 10, index = k / FLAVOURS / 10;
        const ply_flavour flavour = (ply_flavour)(k % FLAVOURS);
        char types[32];
        ply_maker m;
        ply_header(&m, flavour,
                   unit_text(XYZ
                             "element face 2\nproperty list %s %s other\nproperty list %s %s vertex_index\n"
                             "property %s flags\n",
                             names[length], names[index], names[length], names[index], names[index]),
                   k);
        ply_square(&m);
        const char n = codes[length], i = codes[index];
        /* Rows of different sizes, so that none is found by its number alone. */
        snprintf(types, sizeof types, "%c%c%c%c%c%c%c", n, i, n, i, i, i, i);
        ROW(&m, types, 1, 9, 3, 0, 1, 2, 7);
        snprintf(types, sizeof types, "%c%c%c%c%c%c", n, n, i, i, i, i);
        ROW(&m, types, 0, 3, 0, 2, 3, 7);
        fathom_scene *scene = ply_read(&m);
        ply_expect_square(scene);
    }
}

/* What is lost takes its edges and, of a cloud, its colour along. */
UNIT_TEST(edges_and_colours_go_with_lost_vertices) {
    for (ply_maker m = {0};
         ply_each(&m, XYZ "element edge 3\nproperty int vertex1\nproperty int vertex2\n");) {
        ROW(&m, "fff fff fff fff", 0, 0, 0, (double)NAN, 0, 0, 1, 1, 0, 0, 1, 0);
        ROW(&m, "ii ii ii", 0, 1, 1, 2, 2, 3);
        fathom_scene *scene = ply_read(&m);
        assert_int_equal(mesh_at(scene, 0)->triangle_count, ROD_TRIANGLES);
        ply_header(&m, m.flavour, XYZ RGB("float"), 0);
        for (int i = 0; i < 4; ++i) ROW(&m, "ffffff", i == 1 ? (double)INFINITY : i, 0, 0, 0.25 * i, 0, 0);
        scene = ply_read(&m);
        assert_int_equal(mesh_at(scene, 0)->vertex_count, 3);
        mesh_expect_point(mesh_at(scene, 0), 1, 2, 0, 0);
        const float *second = mesh_row(mesh_at(scene, 0)->colors, mesh_at(scene, 0)->color_stride, 1);
        assert_true(second[0] == 0.5f);
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
