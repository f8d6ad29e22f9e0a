/* OBJ files: what they mean. Errors are tested in read_obj_errors.c. */
#include "mesh_file.h"

#include "random.h"
#include "read/mesh/strokes.h"
#include "scene/mesh/absent.h"

static const read_mesh_options plain = {.material = FATHOM_NONE};

static fathom_scene *read_with(const char *text, read_mesh_options options) {
    return mesh_read(read_obj, put_text("a.obj", text), options);
}

static fathom_scene *read_text(const char *text) { return read_with(text, plain); }

#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

static void expect_square(const char *text, uint32_t triangles) {
    fathom_scene *scene = read_text(text);
    assert_int_equal(scene->meshes.count, 1);
    const fathom_mesh *mesh = mesh_at(scene, 0);
    const uint32_t expected[6] = {0, 1, 2, 0, 2, 3};
    assert_int_equal(mesh->vertex_count, 4);
    assert_int_equal(mesh->triangle_count, triangles);
    mesh_expect_indices(mesh->indices, expected, 3 * triangles);
    mesh_expect_point(mesh, 2, 1, 1, 0);
    assert_null(mesh->normals);
    assert_null(mesh->uvs);
}

/* One square, written in all the ways the format allows. */
UNIT_TEST(every_way_to_write_a_face_is_read) {
    expect_square(SQUARE "f 1 2 3\nf 1 3 4\n", 2);
    expect_square(SQUARE "f 1 2 3 4\n", 2);
    expect_square(SQUARE "f -4 -3 -2 -1", 2);
    expect_square("# comment\n\n  v 0 0 0 # more\n\tv\t1.0 0e0 -0.0\nv 1 1 0 1.0\nv 0 1 0 0.5 0.5 0.5\no "
                  "x\ng a b\ng\nf 1 2 3 4 # end\n",
                  2);
    expect_square("v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nf 1 2 3 4\r\n", 2);
    expect_square("v 0 0 0\nv 1 \\\n 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 \\\r\n 3 4\n", 2);
    /* A backslash that ends a comment joins nothing. */
    expect_square("# C:\\\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\n", 1);
    /* Faces may come before their vertices. */
    expect_square("f 1 2 3 4\n" SQUARE, 2);
    expect_square(SQUARE "f 1/ 2/ 3/ 4/\n", 2);
    expect_square(SQUARE "f 1// 2// 3// 4//\n", 2);
}

/* What dissolves to nothing is not there, and casts no shadow. */
UNIT_TEST(fully_dissolved_materials_are_absent) {
    for (int i = 0; i < 2; ++i) {
        const char *library =
            i ? "newmtl m\nKd 1 1 1\nKs 1 1 1\nillum 2\nd 0\n" : "newmtl m\nKd 1 1 1\nd 0.25\n";
        put_text("m.mtl", library);
        fathom_scene *scene = read_text("mtllib m.mtl\nusemtl m\n" SQUARE "f 1 2 3 4\n");
        assert_int_equal(absent_object(scene, 0), i);
    }
}

/* The text with its line feeds replaced, behind a byte order mark or not. */
static size_t write_text(const char *text, const char *line_end, bool mark, char *out) {
    char *p = out;
    if (mark) p += sprintf(p, "\xEF\xBB\xBF");
    for (; *text; ++text) {
        if (*text == '\n')
            p += sprintf(p, "%s", line_end);
        else
            *p++ = *text;
    }
    return (size_t)(p - out);
}

static const char *const line_ends[] = {"\n", "\r\n", "\r"};

UNIT_TEST(byte_order_mark_and_line_ends_change_nothing) {
    const char *mtl = "newmtl b\nKd 0 1 0\nnewmtl a\nKd 1 0 0\n";
    const char *obj =
        "v 9 9 9\nmtllib a.mtl\n# a \\\nv 0 0 0\nv 1 0 \\\n 0\nv 0 1 0\nusemtl a\nf 2 3 4\nf 4 3 1\n";
    fathom_scene *scenes[6];
    char text[512];
    for (int i = 0; i < 6; ++i) {
        mesh_write("a.mtl", text, write_text(mtl, line_ends[i / 2], i % 2, text));
        const char *path = mesh_write("a.obj", text, write_text(obj, line_ends[i / 2], i % 2, text));
        scenes[i] = mesh_read(read_obj, path, plain);
        assert_string_equal(warned, "");
        assert_int_equal(mesh_at(scenes[i], 0)->vertex_count, 4);
        mesh_expect_point(mesh_at(scenes[i], 0), 0, 9, 9, 9);
        mesh_expect_equal(mesh_at(scenes[i], 0), mesh_at(scenes[0], 0));
        assert_true(scenes[i]->materials.items[1].value.k_d[0] == 1);
    }
}

/* A fault in such a file stands in the line that an editor shows. */
UNIT_TEST(any_line_end_counts_a_line) {
    char text[128];
    for (int i = 0; i < 6; ++i) {
        fathom_status status;
        size_t size = write_text("v 0 0 0\n\nv 1 0 x\n", line_ends[i / 2], i % 2, text);
        assert_null(mesh_try(read_obj, mesh_write("a.obj", text, size), plain, &status));
        assert_non_null(strstr(fathom_context_message(context), "a.obj:3: v: number 3 of 3"));
    }
}

/* Exporters name texture coordinates and normals that they do not write, or write 0 for none. */
UNIT_TEST(faces_lose_parts_without_data) {
    const char *wrong[] = {"f 1/1/1 2/2/2 3/3/3\n",
                           "f 1//1 2//2 3//3\n",
                           "f 1/-1 2/-1 3/-1\n",
                           "vt 0 0\nvn 0 0 1\nf 1/1/1 2/2/2 3/1/1\n",
                           "vt 0 0\nf 1/1/-1 2/1/-1 3/1/-9\n",
                           "vt 0 0\nf 1/1/0 2/1/0 3/1/0\n",
                           "f 1/0/0 2/0/0 3/0/0\n"};
    const bool has_uv[] = {false, false, false, false, true, true, false};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        fathom_scene *scene = read_text(unit_text(SQUARE "%s", wrong[i]));
        const uint32_t expected[3] = {0, 1, 2};
        mesh_expect_indices(mesh_at(scene, 0)->indices, expected, 3);
        assert_null(mesh_at(scene, 0)->normals);
        assert_int_equal(mesh_at(scene, 0)->uvs != NULL, has_uv[i]);
        expect_warning(strchr(wrong[i], 'v') || i == 0 ? "vn: a face names normals that the file"
                                                       : "the file does not");
    }
}

UNIT_TEST(words_after_a_vertex_are_reported) {
    fathom_scene *scene = read_text("v 0 0 0 1 0 0\nv 1 0 0 1 0 0 1\nv 1 1 0 1.0\nv 0 1 0 0.5\nf 1 2 3\n");
    expect_warning(":4: what follows x y z of a vertex is not read (1 such");
    scene = read_text("v 0 0 0 1 0 0 1\nv 1 0 0 1 0 0 0.5\nv 1 1 0 1 0 0\nf 1 2 3\n");
    expect_warning(":2: the alpha of a vertex is left out");
    assert_true(mesh_at(scene, 0)->colors[0] == 1 && mesh_at(scene, 0)->colors[1] == 0);
}

/* Each vertex has a mask, then sRGB bytes. Other characters end a line; vertices without paint are white. */
UNIT_TEST(polypaint_of_zbrush_is_read) {
    fathom_scene *scene =
        read_text(SQUARE "#MRGB ffff0000FF00bc00 \n# other\n#MRGB 000000ffxx\nf 1 2 3 4\n#MRGB\n");
    const float expected[12] = {1, 0, 0, 0, 0.50288653f, 0, 0, 0, 1, 1, 1, 1};
    for (int i = 0; i < 12; ++i) assert_near(mesh_at(scene, 0)->colors[i], expected[i], 1e-7);
    assert_string_equal(warned, "");
    /* Numbers after the positions count before it; no vertex is painted that is not there. */
    scene = read_text("v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0 1 0 0\n#MRGB ff00ff00\nf 1 2 3\n");
    assert_true(mesh_at(scene, 0)->colors[0] == 1);
    scene = read_text("v 0 0 0\nv 1 0 0\nv 1 1 0\n#MRGB ff0000ffff0000ffff0000ffff0000ff\nf 1 2 3\n");
    assert_true(mesh_at(scene, 0)->colors[8] == 1 && mesh_at(scene, 0)->colors[7] == 0);
}

/* As screens show them, and white where a vertex has none. */
UNIT_TEST(vertex_colours_are_read) {
    fathom_scene *scene = read_text("v 0 0 0 1 0 0.5\nv 1 0 0\nv 1 1 0 0 2 0\nf 1 2 3\n");
    const fathom_mesh *mesh = mesh_at(scene, 0);
    const float expected[9] = {1, 0, 0.21404114f, 1, 1, 1, 0, 1, 0};
    assert_int_equal(mesh->color_channels, 3);
    for (int i = 0; i < 9; ++i) assert_near(mesh->colors[i], expected[i], 1e-7);
    assert_true(scene->materials.items[mesh->material].value.k_d[0] == 1);
    expect_warning("colours of vertices above 1 are read as 1");
    scene = read_text("v 0 0 0 255 0 188\nv 1 0 0\nv 1 1 0 0 255 0\nf 1 2 3\n");
    for (int i = 0; i < 9; ++i)
        assert_near(mesh_at(scene, 0)->colors[i], i == 2 ? 0.50288653f : expected[i], 1e-7);
    expect_warning("colours of vertices are whole numbers up to 255; they are read as bytes");
}

UNIT_TEST(a_library_without_a_name_is_reported) {
    read_text("mtllib\nmtllib \n" SQUARE "usemtl\nf 1 2 3\n");
    expect_warning(":1: mtllib: expected the name of a file");
}

/* Negative indices count back from where they stand. */
UNIT_TEST(negative_indices_count_back) {
    fathom_scene *scene = read_text("v 0 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf -4 -3 -1\n");
    const uint32_t expected[6] = {1, 2, 3, 1, 2, 4};
    mesh_expect_indices(mesh_at(scene, 0)->indices, expected, 6);
}

UNIT_TEST(uvs_and_normals_keep_their_indices) {
    fathom_scene *scene = read_text(SQUARE "vt 0.25 0.5\nvt 0.75\nvt 1 2 3\nvn 0 0 1\nvn 0 0 2\n"
                                           "f 1/1/1 2/2/2 3/3/1\nf 1/-1/-1 3/-2/-2 4/-3/-1\n");
    const fathom_mesh *mesh = mesh_at(scene, 0);
    const uint32_t uv[6] = {0, 1, 2, 2, 1, 0}, normal[6] = {0, 1, 0, 1, 0, 1};
    mesh_expect_indices(mesh->uv_indices, uv, 6);
    mesh_expect_indices(mesh->normal_indices, normal, 6);
    assert_int_equal(mesh->uv_count, 3);
    assert_int_equal(mesh->normal_count, 2);
    assert_true(mesh->uvs[0] == 0.25f && mesh->uvs[1] == 0.5f && mesh->uvs[2] == 0.75f && mesh->uvs[3] == 0);
    assert_true(mesh->normals[5] == 2);
}

/* Indices that equal the vertices' take no memory of their own; too few values for that, and they do. */
UNIT_TEST(equal_indices_are_not_stored) {
    const char *four = SQUARE "vn 0 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\nf 1//1 2//2 3//3 4//4\n";
    fathom_scene *scene = read_text(four);
    assert_null(mesh_at(scene, 0)->normal_indices);
    scene = read_text(SQUARE "vn 0 0 1\nvn 0 0 1\nvn 0 0 1\nf 1//1 2//2 3//3\n");
    const uint32_t expected[3] = {0, 1, 2};
    mesh_expect_indices(mesh_at(scene, 0)->normal_indices, expected, 3);
}

/* One mesh a material and kind of data, over the same vertices, each face in one of them. */
UNIT_TEST(each_material_is_one_mesh) {
    put_text("m.mtl", "newmtl red # skin\nKd 1 0 0\nnewmtl a b\nKd 0 1 0\n");
    fathom_scene *scene = read_text("mtllib m.mtl # colours\n" SQUARE
                                    "vn 0 0 1\nf 1 2 3\nusemtl red\nf 1 2 4\nusemtl a b # cloth\nf 2 3 4\n"
                                    "usemtl red\nf 1 3 4\nf 1//1 2//1 3//1\n");
    assert_int_equal(scene->meshes.count, 4);
    const fathom_mesh *meshes = scene->meshes.items;
    const uint32_t red[6] = {0, 1, 3, 0, 2, 3};
    assert_int_equal(meshes[0].material, 0);
    assert_int_equal(meshes[1].triangle_count, 2);
    mesh_expect_indices(meshes[1].indices, red, 6);
    assert_string_equal(scene->materials.items[meshes[1].material].name, "red");
    assert_string_equal(scene->materials.items[meshes[2].material].name, "a b");
    assert_int_equal(meshes[3].material, meshes[1].material);
    assert_non_null(meshes[3].normals);
    assert_null(meshes[1].normals);
    for (int i = 1; i < 4; ++i) assert_ptr_equal(meshes[i].positions, meshes[0].positions);
    assert_string_equal(warned, "");
}

/* Of six vertices the first mesh uses three, the second all: the first has copies, in the file's order, with
 * uvs whose indices are the positions', and normals by indices of their own. */
static void expect_objects(const char *text, size_t count, const char *const names[]) {
    fathom_scene *scene = read_text(text);
    assert_int_equal(scene->objects.count, count);
    for (size_t i = 0; i < count; ++i) {
        const char *name = scene->objects.items[i].name;
        if (!name || !names[i])
            assert_true(name == names[i]);
        else
            assert_string_equal(name, names[i]);
    }
}

/* For Cryptomatte: a mesh for each object and material in it. */
UNIT_TEST(each_object_is_a_mesh_of_its_name) {
    expect_objects("o two words # no more\n" SQUARE "f 1 2 3 4\n", 1, (const char *[]){"two words"});
    expect_objects("g default\n" SQUARE "g a\nf 1 2 3 4\n" SQUARE "g b\nf 5 6 7 8\n", 2,
                   (const char *[]){"a", "b"});
    /* Groups of objects are none. */
    expect_objects("o a\n" SQUARE "g x\nf 1 2 3\ng y\nf 1 3 4\no b\n" SQUARE "f 5 6 7 8\n", 2,
                   (const char *[]){"a", "b"});
    expect_objects(SQUARE "f 1 2 3 4\no a\n" SQUARE "usemtl m\nf 5 6 7\nusemtl n\nf 5 7 8\n", 2,
                   (const char *[]){NULL, "a"});
    /* Parts of one surface remain one mesh. */
    expect_objects(SQUARE "g a\nf 1 2 3\ng b\nf 1 3 4\n", 1, (const char *[]){NULL});
    expect_objects(SQUARE "g a\nf 1 2 3 4\n" SQUARE "g b\nf 5 6 7 8\ng a\nf 1 2 3\n", 1,
                   (const char *[]){NULL});
}

UNIT_TEST(unused_vertices_are_left_out) {
    put_text("m.mtl", "newmtl rest\nKd 1 0 0\n");
    fathom_scene *scene =
        read_text("mtllib m.mtl\nv 0 0 0\nv 1 0 0 \nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\n"
                  "vt 0 0\nvt 1 0\nvt 2 0\nvt 3 0\nvt 4 0\nvt 5 0\nvn 0 0 1\nvn 0 0 2\nvn 0 0 3\nvn 0 0 4\n"
                  "f 6/6/4 2/2/2 4/4/4\nusemtl rest\nf 1/1/1 2/2/1 3/3/1\nf 4/4/1 5/5/1 6/6/1\n");
    const fathom_mesh *few = mesh_at(scene, 0), *all = mesh_at(scene, 1);
    const uint32_t corners[3] = {2, 0, 1}, normals[3] = {1, 0, 1};
    assert_int_equal(few->vertex_count, 3);
    mesh_expect_indices(few->indices, corners, 3);
    mesh_expect_point(few, 0, 1, 0, 0);
    mesh_expect_point(few, 1, 0, 0, 1);
    mesh_expect_point(few, 2, 0, 1, 1);
    assert_true(!few->uv_indices && few->uv_count == 3);
    for (int i = 0; i < 3; ++i) assert_true(few->uvs[2 * i] == (float)(2 * i + 1));
    assert_int_equal(few->normal_count, 2);
    mesh_expect_indices(few->normal_indices, normals, 3);
    assert_true(few->normals[2] == 2 && few->normals[5] == 4);
    assert_int_equal(all->vertex_count, 6);
    assert_ptr_not_equal(all->positions, few->positions);
    assert_true(scene->mesh_facts.items[0].lower[0] == 0 && scene->mesh_facts.items[0].lower[1] == 0);
    assert_int_equal(all->uv_count, 6);
}

/* The bounds are those of the triangles, at each side of a stray vertex; with two meshes, too. */
UNIT_TEST(stray_vertices_are_left_out) {
    static const char *const strays[] = {"9 0 0", "-9 0 0", "0 9 0", "0 -9 0", "0 0 9", "0 0 -9"};
    for (size_t i = 0; i < 2 * sizeof strays / sizeof *strays; ++i) {
        const bool two = i % 2;
        fathom_scene *scene = read_text(
            unit_text("v 0 0 0\nv 1 0 0\nv %s\nv 0 1 0\nv 0 0 1\nf 1 2 4\nf 1 2 5\n%sf 1 4 5\n",
                      strays[i / 2], two ? "s 1\nvn 0 0 1\nf 2//1 4//1 5//1\nf 1//1 4//1 2//1\n" : ""));
        scene_bounds bounds;
        assert_int_equal(scene->meshes.count, two ? 2 : 1);
        assert_int_equal(mesh_at(scene, 0)->vertex_count, 4);
        assert_ok(context, scene_world_bounds(scene, &bounds));
        assert_true(bounds.lower.x == 0 && bounds.lower.y == 0 && bounds.lower.z == 0);
        assert_true(bounds.upper.x == 1 && bounds.upper.y == 1 && bounds.upper.z == 1);
    }
    /* Inside the bounds, where it does no harm, the file's own list is used. */
    fathom_scene *scene =
        read_text("v 0 0 0\nv 1 0 0\nv 0 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 4\nf 1 2 5\nf 1 4 5\n");
    assert_int_equal(mesh_at(scene, 0)->vertex_count, 5);
}

/* One texel, and one warning for all such meshes; a mesh with uvs keeps them. */
UNIT_TEST(images_without_uvs_are_one_texel) {
    put_text("m.mtl", "newmtl a\nmap_Kd t.ppm\nnewmtl b\nKd 0.5 0.5 0.5\nmap_Kd t.ppm\n");
    mesh_write("t.ppm", "P6 1 1 255\nabc", 14);
    fathom_scene *scene =
        read_text("mtllib m.mtl\n" SQUARE "vt 1 1\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nf 1/1 2/1 3/1\n");
    assert_int_equal(scene->meshes.count, 3);
    for (size_t i = 0; i < 3; ++i) {
        const fathom_mesh *mesh = mesh_at(scene, i);
        assert_non_null(mesh->uvs);
        for (uint32_t k = 0; k < mesh->uv_count; ++k)
            assert_true(mesh_row(mesh->uvs, mesh->uv_stride, k)[0] == (i == 2));
    }
    expect_warning("a.obj: a mesh has a material with images but no texture coordinates; it shows their "
                   "colour at (0, 0) (2 such)");
}

/* Scanning programs write them twice. Fathom's own files mean their product, and other materials have no
 * other colours. */
UNIT_TEST(colours_of_vertices_give_way_to_an_image) {
    put_text("m.mtl", "newmtl a\nmap_Kd t.ppm\nnewmtl b\nKd 1 1 1\n");
    mesh_write("t.ppm", "P6 1 1 255\nabc", 14);
    for (int i = 0; i < 2; ++i) {
        fathom_scene *scene = read_text(
            unit_text("# %s\nmtllib m.mtl\nv 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nvt 1 1\nusemtl a\n"
                      "f 1/1 2/1 3/1\nusemtl b\nf 1/1 2/1 3/1\n",
                      i ? "Fathom 0.1.0" : "by hand"));
        assert_int_equal(mesh_at(scene, 0)->colors != NULL, i);
        assert_non_null(mesh_at(scene, 1)->colors);
        if (!i) expect_warning("colours of vertices are left out where an image has them (1 such)");
    }
}

/* Blender writes its default grey where colours of vertices are linked to the base colour; other greys, other
 * programs and files with vertices of no colour have it for themselves. */
UNIT_TEST(colours_of_vertices_replace_the_grey_of_blender) {
    static const struct {
        const char *head, *kd, *color;
        float base;
    } cases[] = {{"# Blender 3.4.1 MTL File: 'None'", "0.800000", " 1 0 0", 1},
                 {"# Blender 3.4.1 MTL File: 'None'", "0.700000", " 1 0 0", 0.7f},
                 {"# Blender 3.4.1 MTL File: 'None'", "0.800000", "", 0.8f},
                 {"# by hand", "0.800000", " 1 0 0", 0.8f}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const char *kd = cases[i].kd;
        char text[256];
        snprintf(text, sizeof text, "%s\nnewmtl a\nKd %s %s %s\nKs 0.5 0.5 0.5\nPr 0.5\nillum 2\n",
                 cases[i].head, kd, kd, kd);
        put_text("m.mtl", text);
        snprintf(text, sizeof text,
                 "mtllib m.mtl\nv 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0%s\nusemtl a\nf 1 2 3\n",
                 cases[i].color);
        fathom_scene *scene = read_text(text);
        const scene_named_material *m = &scene->materials.items[mesh_at(scene, 0)->material];
        for (int c = 0; c < 3; ++c) assert_near(m->value.base_color[c], cases[i].base, 0);
        assert_int_equal(m->classic.k_d[0] > 0.9f, i == 0); /* 0.96 times the base */
        if (!i)
            expect_warning(
                "Kd 0.8 of Blender with colours of vertices is read as 1: they replace it (1 such)");
    }
}

/* A material that is asked for goes on everything, and the file's own are not looked for. */
UNIT_TEST(a_given_material_replaces_the_files) {
    const read_mesh_options options = {.material = 0, .flags = FATHOM_CASTS_NO_SHADOW};
    fathom_scene *scene =
        read_with("mtllib nowhere.mtl\n" SQUARE "usemtl x\nf 1 2 3\nusemtl y\nf 1 3 4\n", options);
    assert_int_equal(scene->meshes.count, 1);
    assert_int_equal(mesh_at(scene, 0)->flags, FATHOM_CASTS_NO_SHADOW);
    assert_string_equal(warned, "");
}

/* A roof of two slopes that meet in the edge 2-3. */
#define ROOF "v -1 0 0\nv 0 0 1\nv 0 1 1\nv 1 0 0\n"

static void expect_roof(const char *faces, read_mesh_options options, int smooth) {
    fathom_scene *scene = read_with(unit_text("%s%s", ROOF, faces), options);
    const fathom_mesh *mesh = mesh_at(scene, 0);
    assert_int_equal(scene->meshes.count, 1);
    if (smooth < 0) {
        assert_null(mesh->normals);
    } else {
        /* The normal of the first triangle's second corner, on the ridge: upright if smooth across. */
        const uint32_t *indices = mesh->normal_indices ? mesh->normal_indices : mesh->indices;
        const float *n = mesh->normals + 3 * (size_t)indices[1];
        assert_near(n[0], smooth ? 0 : -sqrt(0.5), 0x1p-23);
        assert_near(n[2], smooth ? 1 : sqrt(0.5), 0x1p-23);
    }
}

UNIT_TEST(smoothing_groups_share_normals) {
    const read_mesh_options smooth = {.material = FATHOM_NONE, .smooth = true};
    const read_mesh_options flat = {.material = FATHOM_NONE, .flat = true};
    expect_roof("f 1 2 3\nf 2 4 3\n", plain, -1);
    expect_roof("s off\nf 1 2 3\ns 0\nf 2 4 3\n", plain, -1);
    expect_roof("s\nf 1 2 3\ns \nf 2 4 3\n", plain, -1);
    expect_roof("s 1\nf 1 2 3\nf 2 4 3\n", plain, 1);
    expect_roof("s on\nf 1 2 3\nf 2 4 3\n", plain, 1);
    expect_roof("s 1\nf 1 2 3\ns 2\nf 2 4 3\n", plain, 0);
    expect_roof("s 7\nf 1 2 3\ns 1\nf 2 4 3\ns 7\nf 2 4 3\n", plain, 1);
    expect_roof("f 1 2 3\nf 2 4 3\n", smooth, 1);
    expect_roof("s 1\nf 1 2 3\nf 2 4 3\n", flat, -1);
    expect_roof("vn 1 0 0\nf 1//1 2//1 3//1\nf 2//1 4//1 3//1\n", flat, -1);
    /* Made normals beside the file's own. */
    expect_roof("s 1\nf 1 2 3\nf 2 4 3\nvn 1 0 0\nf 1//1 2//1 4//1\n", plain, 1);
}

/* Polygons of any size; concave ones, whose fan would turn over. */
UNIT_TEST(polygons_are_triangulated) {
    fathom_scene *scene =
        read_text("v 0 0 0\nv 2 -1 0\nv 0.5 0 0\nv 2 1 0\nv 0 3 0\nvt 0 0\nvt 1 0\nvt 2 0\nvt 3 0\n"
                  "f 1/1 2/2 3/3 4/4\nf 4/4 5/1 1/2 2/3 3/4\n");
    const fathom_mesh *mesh = mesh_at(scene, 0);
    assert_int_equal(mesh->triangle_count, 5);
    double area = 0;
    for (uint32_t t = 0; t < 5; ++t) {
        const uint32_t *c = mesh->indices + 3 * t;
        vec3_f64 a = mesh_point(mesh, c[0]);
        vec3_f64 n = cross_f64(sub_f64(mesh_point(mesh, c[1]), a), sub_f64(mesh_point(mesh, c[2]), a));
        assert_true(n.z > 0);
        area += 0.5 * n.z;
    }
    /* The dart: 0.5; with the triangle (1, 4, 5), 3, on top: 3.5. */
    assert_true(area == 0.5 + 3.5);
    /* uvs of the first polygon run as its vertices do. */
    for (int i = 0; i < 6; ++i) assert_int_equal(mesh->uv_indices[i], mesh->indices[i]);
}

/* Earth-sized coordinates with details of a millimetre come back to the last digit that a float of the extent
 * has: 1.5 × 2^-24 of half of it, plus double's own. */
UNIT_TEST(far_meshes_keep_their_digits) {
    const double x = 6378137.123456, y = -6378000.654321, z = 12.3456789;
    char text[512];
    snprintf(text, sizeof text, "v %.9f %.9f %.9f\nv %.9f %.9f %.9f\nv %.9f %.9f %.9f\nf 1 2 3\n", x, y, z,
             x + 2, y, z, x, y + 0.001, z + 2);
    fathom_scene *scene = read_text(text);
    const fathom_mesh *mesh = mesh_at(scene, 0);
    vec3_f64 p = mesh_point(mesh, 2);
    assert_near(p.x, x, 1.5 * 0x1p-24 + 0x1p-30);
    assert_near(p.y, y + 0.001, 1.5 * 0x1p-24 + 0x1p-30);
    assert_near(p.z, z + 2, 1.5 * 0x1p-24 + 0x1p-30);
    assert_true(mesh->origin[0] != 0);
    /* Near enough, 6 <= 16 × 0.5: no origin. */
    scene = read_text("v 5 0 0\nv 6 0 0\nv 5 1 0\nf 1 2 3\n");
    assert_true(mesh_at(scene, 0)->origin[0] == 0);
    /* Floats that are moved lose no bit. */
    snprintf(text, sizeof text, "v %.9g 0 0\nv %.9g 0 0\nv %.9g 1 0\nf 1 2 3\n", 16777215.0, 16777213.0,
             16777211.0);
    scene = read_text(text);
    mesh = mesh_at(scene, 0);
    assert_true(mesh->origin[0] != 0);
    mesh_expect_point(mesh, 0, 16777215, 0, 0);
    mesh_expect_point(mesh, 1, 16777213, 0, 0);
    mesh_expect_point(mesh, 2, 16777211, 1, 0);
}

UNIT_TEST(omissions_are_reported) {
    read_text(SQUARE
              "f 1 2 3\nl 1 2\nl 2 2\np 1\nf 1 2\nl 3\ncurv 0 1 1 2\nmtllib none.mtl\nusemtl x\nusemtl y\n"
              "vt 0 0\nf 1/1 2/1 3\n");
    const char *expected[] = {
        ":6: lines have no width, and are shown as thin rods (2 such)",
        ": lines without length are left out (1 such)",
        ":8: points have no size, and are shown as small spheres (1 such)",
        ":9: faces of less than 3 corners are left out (1 such)",
        ":10: lines of less than 2 corners are left out (1 such)",
        ":11: statements that are not read",
        ":12: mtllib: there is no file \"none.mtl\"",
        ":16: a face has uvs or normals at some corners and not at others; it gets none (1 such)",
        ":13: usemtl: no material \"x\" is defined"};
    for (size_t i = 0; i < sizeof expected / sizeof *expected; ++i) expect_warning(expected[i]);
    size_t lines = 0;
    for (const char *c = warned; (c = strchr(c, '\n')) != NULL; ++c) ++lines;
    assert_int_equal(lines, 9);
}

/* Exporters divide by the length of nothing, and print what comes of it in many ways. */
UNIT_TEST(normals_that_are_no_numbers_become_zeros) {
    fathom_scene *scene = read_text(
        SQUARE "vn nan 0 1\nvn -nan(ind) inf 1.#QNAN\nvn 0 0 1\nvt -1.#IND 1\nf 1/1/1 2/1/2 3/1/3\n");
    const fathom_mesh *mesh = mesh_at(scene, 0);
    assert_true(mesh->normals[0] == 0 && mesh->normals[2] == 1 && mesh->normals[5] == 0);
    assert_true(mesh->uvs[0] == 0 && mesh->uvs[1] == 1);
    expect_warning("a NaN or an infinity in vt or vn is taken as 0 (5 such, the first here: \"nan\")");
}

/* Every vertex of the rods, of `each` vertices, lies at a distance from the line between its two
 * ends.
 */
static void expect_distance(const fathom_mesh *mesh, uint32_t triangles, uint32_t each,
                            const vec3_f64 ends[][2], double distance) {
    assert_int_equal(mesh->triangle_count, triangles);
    for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
        const vec3_f64 *of = ends[i / each], p = sub_f64(widen(load_f32(mesh->positions + 3 * i)), of[0]),
                       along = sub_f64(of[1], of[0]);
        const double whole = dot_f64(along, along), u = whole > 0 ? dot_f64(p, along) / whole : 0;
        assert_near(length_f64(sub_f64(p, scale_f64(fmin(fmax(u, 0), 1), along))), distance, 0x1p-21);
    }
}

/* A line is a rod of a three hundredth of the diagonal (5), whose tips are as far from its ends as its sides
 * from the line. Coordinates up to 4 are rounded by 2^-22. */
/* Whole faces, lines and points are left out with a vertex; the others keep their corners and do not move. */
UNIT_TEST(vertices_that_are_no_numbers_are_left_out) {
    static const char *const odd[] = {"nan", "inf", "1.#QNAN", "1e39"};
    for (int i = 0; i < 4; ++i) {
        const uint32_t square[] = {0, 1, 2, 0, 2, 3};
        fathom_scene *scene =
            read_text(unit_text("f 1 5 6 2\nf 1/1 2/2 3/3 4/4\nf 5 1 2\n" SQUARE
                                "v 0 %s 0\nv 9 9 9\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nl 1 2 5\np 5 1\n",
                                odd[i]));
        assert_int_equal(scene->meshes.count, 3);
        mesh_expect_indices(mesh_at(scene, 0)->indices, square, 6);
        assert_true(mesh_at(scene, 0)->uvs[4] == 1 && mesh_at(scene, 0)->uvs[7] == 1);
        assert_int_equal(mesh_at(scene, 1)->vertex_count, 1);
        assert_int_equal(mesh_at(scene, 2)->triangle_count, ROD_TRIANGLES);
        expect_warning("a.obj:8: a vertex with a NaN, an infinity or a number beyond float is left out, with "
                       "what uses it (1 such)");
    }
    fathom_scene *scene = read_text("v nan 0 0 1 0 0\nv 1e6 0 0 0 0 0\nv 1000001 0 0 0 1 0\n");
    const fathom_mesh *cloud = mesh_at(scene, 0);
    assert_int_equal(cloud->vertex_count, 2);
    mesh_expect_point(cloud, 1, 1000001, 0, 0);
    assert_true(cloud->colors[1] == 0 && cloud->colors[4] == 1);
    expect_warning("(1 such)");
}

UNIT_TEST(lines_are_rods_and_points_are_spheres) {
    static const vec3_f64 lines[][2] = {{{0, 0, 0}, {4, 0, 0}}, {{4, 0, 0}, {4, 3, 0}}};
    const char *const ways[] = {"l 1 2 3\n", "l -3 -2\nl 2 3\n", "vt 0 0\nl 1/1 2/1 3\n"};
    for (size_t i = 0; i < sizeof ways / sizeof *ways; ++i) {
        fathom_scene *scene = read_text(unit_text("v 0 0 0\nv 4 0 0\nv 4 3 0\n%sp 1\n", ways[i]));
        assert_int_equal(scene->meshes.count, 2);
        /* One point alone has no diagonal: its radius is 1. */
        assert_int_equal(mesh_at(scene, 0)->vertex_count, 1);
        assert_true(mesh_at(scene, 0)->point_radius == 1);
        expect_distance(mesh_at(scene, 1), 2 * ROD_TRIANGLES, ROD_VERTICES, lines, 5 / 300.0);
    }
}

/* Programs for scans write no elements at all. */
UNIT_TEST(vertices_alone_are_a_cloud_of_points) {
    fathom_scene *scene = read_text("v 0 0 0 1 0 0\nv 4 0 0 1 1 1\nv 4 3 0 1 1 1\n");
    const fathom_mesh *mesh = mesh_at(scene, 0);
    assert_int_equal(scene->meshes.count, 1);
    assert_int_equal(mesh->vertex_count, 3);
    assert_true(mesh->point_radius == 0.0625f); /* an eightieth of the diagonal, 5 */
    for (uint32_t i = 0; i < 3; ++i) assert_true(mesh->colors[3 * i + 1] == (i >= 1));
    expect_warning(
        "vertices without faces are points; they have no size, and are shown as small spheres (3 such)");
}

/* Points of one material are one mesh, in the file's order, whatever the pieces that it is read in. */
UNIT_TEST(points_keep_their_materials) {
    put_text("a.mtl", "newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0\n");
    fathom_scene *scene =
        read_text("mtllib a.mtl\n" SQUARE "usemtl b\np 1\nusemtl a\np 2 3\nusemtl b\np 4\nl 1 2\n");
    static const char *const names[] = {"b", "a", "b"};
    static const uint32_t triangles[] = {0, 0, ROD_TRIANGLES}, vertices[] = {2, 2, ROD_VERTICES};
    assert_int_equal(scene->meshes.count, 3);
    for (uint32_t i = 0; i < 3; ++i) {
        assert_int_equal(mesh_at(scene, i)->triangle_count, triangles[i]);
        assert_int_equal(mesh_at(scene, i)->vertex_count, vertices[i]);
        assert_string_equal(scene->materials.items[mesh_at(scene, i)->material].name, names[i]);
    }
    mesh_expect_point(mesh_at(scene, 0), 1, 0, 1, 0); /* the fourth vertex of the square */
}

/* However often and under however many names: one warning. */
UNIT_TEST(missing_libraries_are_reported) {
    read_text("mtllib a b\nmtllib c\nmtllib b\nmtllib c\n" SQUARE "f 1 2 3\n");
    const char *text =
        ":1: mtllib: there is no file \"a\"; materials named from it get the default (5 such)\n";
    expect_warning(text);
    assert_ptr_equal(strchr(warned, '\n') + 1, warned + strlen(warned));
}

/* Each search lists a folder: the number of searches has a limit, and so has that of warnings. */
UNIT_TEST(very_many_missing_files_take_little_time) {
    enum { MANY = 3000 };
    static char text[64 * MANY];
    size_t n = 0;
    for (int i = 0; i < MANY; ++i) n += (size_t)sprintf(text + n, "mtllib none%d.mtl\n", i);
    sprintf(text + n, "mtllib m.mtl\n" SQUARE "usemtl a\nf 1 2 3\n");
    mesh_write("m.mtl", "newmtl a\n", 9);
    read_text(text);
    expect_warning(
        ":1: mtllib: there is no file \"none0.mtl\"; materials named from it get the default (3001 such)");
    expect_warning("1000 names of libraries have no file that can be read; no further name was looked for");

    n = 0;
    for (int i = 0; i < 20; ++i) n += (size_t)sprintf(text + n, "newmtl m%d\nmap_Kd none%d.png\n", i, i);
    mesh_write("m.mtl", text, n);
    n = (size_t)sprintf(text, "mtllib m.mtl\n" SQUARE);
    for (int i = 0; i < 20; ++i) n += (size_t)sprintf(text + n, "usemtl m%d\nf 1 2 3\n", i);
    read_text(text);
    expect_warning("material \"m7\": there is no image \"none7.png\" that may be read; it is left out");
    assert_null(strstr(warned, "none8.png"));
    expect_warning("images beyond the first 8 that may not be read or do not exist are left out (12 such)");
}

/* By the last parts of the path, in quotes too, or by the name of the OBJ file, with a warning. */
UNIT_TEST(libraries_elsewhere_are_found) {
    static const char *const named[] = {"mtllib C:\\far\\m n.mtl\n", "mtllib far/m n.mtl\n",
                                        "mtllib \"m n.mtl\"\n", "", "mtllib none.mtl\n"};
    for (size_t i = 0; i < sizeof named / sizeof *named; ++i) {
        const char *path = put_text(i < 3 ? "m n.mtl" : "a.mtl", "newmtl red\nKd 1 0 0\n");
        fathom_scene *scene = read_text(unit_text("%s" SQUARE "usemtl red\nf 1 2 3\n", named[i]));
        assert_true(scene->materials.items[mesh_at(scene, 0)->material].value.k_d[1] == 0);
        if (i < 3)
            assert_string_equal(warned, "");
        else
            expect_warning(
                "no mtllib statement names a file that can be read; a.mtl is read instead (1 such)");
        assert_int_equal(unlink(path), 0);
    }
}

/* The search for the last parts of a path does not take several names for one. */
UNIT_TEST(each_of_several_libraries_is_found) {
    const char *red = "newmtl red\nKd 1 0 0\n", *blue = "newmtl blue\nKd 0 0 1\n";
    put_text("r.mtl", red);
    put_text("b.mtl", blue);
    fathom_scene *scene =
        read_text("mtllib far/r.mtl far/b.mtl\n" SQUARE "usemtl red\nf 1 2 3\nusemtl blue\nf 1 3 4\n");
    assert_string_equal(warned, "");
    for (size_t i = 0; i < 2; ++i)
        assert_true(scene->materials.items[mesh_at(scene, i)->material].value.k_d[2] == (float)i);
}

/* One vertex in each of many smoothing groups has a normal of each; faces that share a group share it. */
UNIT_TEST(many_smoothing_groups_are_read) {
    enum { groups = 100 };
    char text[64 + groups * 40] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n", *p = text + strlen(text);
    for (int i = 0; i < 2 * groups; ++i)
        p += sprintf(p, "s %d\nf 1 2 %d\n", 1 + i % groups, i < groups ? 3 : 4);
    fathom_scene *scene = read_text(text);
    const fathom_mesh *mesh = mesh_at(scene, 0);
    assert_int_equal(mesh->triangle_count, 2 * groups);
    assert_int_equal(mesh->normal_count, 4 * groups);
    for (uint32_t i = 0; i < groups; ++i) {
        const uint32_t *first = mesh->normal_indices + 3 * i,
                       *second = mesh->normal_indices + 3 * (i + groups);
        assert_int_equal(first[0], 3 * i);
        assert_int_equal(second[0], first[0]);
        assert_int_equal(second[1], first[1]);
        assert_int_equal(second[2], 3 * groups + i);
    }
}

/* A strip of quads over many pieces of text. Every index is negative, and materials, groups and normals
 * change on the way: what the pieces make together is what one would. */
static char *big_file(size_t *size) {
    enum { cells = 60000 };
    char *text = malloc((size_t)cells * 160), *p = text;
    random_state random = {6};
    for (int i = 0; i < cells; ++i) {
        if (i % 20011 == 0) p += sprintf(p, "usemtl m%d\n", i % 3);
        if (i % 17011 == 0) p += sprintf(p, "s %d\n", i % 4);
        p += sprintf(p, "v %d 0 %.6f\nv %d 1 %.6f\n", i, random_unit(&random), i, random_unit(&random));
        if (i % 100 == 50) p += sprintf(p, "vn 0 %d 1\n", i % 7);
        if (i < 60) continue;
        if (i % 1000 < 300)
            p += sprintf(p, "f -4//-1 -2//-1 -1//-1 -3//-1\n");
        else
            p += sprintf(p, "f -4 -2 -1 -3\n");
    }
    *size = (size_t)(p - text);
    return text;
}

UNIT_TEST(meshes_do_not_depend_on_thread_count) {
    const unsigned threads[] = {1, 2, 7};
    fathom_scene *scenes[3];
    size_t size;
    char *text = big_file(&size);
    assert_true(size > 3000000);
    const char *path = mesh_write("big.obj", text, size);
    free(text);
    for (int i = 0; i < 3; ++i) {
        fathom_context_set_threads(context, threads[i]);
        scenes[i] = mesh_read(read_obj, path, plain);
    }
    size_t triangles = 0;
    for (size_t m = 0; m < scenes[0]->meshes.count; ++m) {
        mesh_expect_equal(mesh_at(scenes[0], m), mesh_at(scenes[1], m));
        mesh_expect_equal(mesh_at(scenes[0], m), mesh_at(scenes[2], m));
        triangles += scenes[0]->meshes.items[m].triangle_count;
    }
    assert_int_equal(triangles, 2 * (60000 - 60));
    /* Every quad joins neighbours, so every edge is short however far back its indices reach. */
    for (size_t m = 0; m < scenes[0]->meshes.count; ++m) {
        const fathom_mesh *mesh = mesh_at(scenes[0], m);
        for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
            const uint32_t *c = mesh->indices + 3 * (size_t)t;
            assert_true(fabs(mesh_point(mesh, c[0]).x - mesh_point(mesh, c[1]).x) <= 1);
            assert_true(fabs(mesh_point(mesh, c[0]).x - mesh_point(mesh, c[2]).x) <= 1);
        }
    }
    fathom_context_set_threads(context, 0);
}

int main(void) { return unit_main(open_folder, remove_folder); }
