/* What mesh files are made of: texts, names, welded vertices, and materials that a format cannot hold as they
 * are. */
#include "base/file.h"
#include "materials.h"
#include "owned.h"
#include "unit_folder.h"
#include "write/write.h"

#include <fathom/parameter.h>
#include <fathom/read.h>

#include <jansson.h>
#include <unistd.h>

/* ---- texts ---- */

/* The text as written, parsed again; to be freed. */
static char *written_and_parsed(const char *text) {
    file_writer *t;
    unsigned char *bytes;
    size_t size;
    assert_ok(context, file_writer_open_memory(context, "text", &t));
    write_quoted(t, text);
    assert_ok(context, file_writer_take(t, &bytes, &size));
    json_t *back = json_loadb((const char *)bytes, size, JSON_DECODE_ANY, NULL);
    if (!json_is_string(back)) fail_msg("\"%.*s\" is no JSON", (int)size, (const char *)bytes);
    char *copy = strdup(json_string_value(back));
    assert_non_null(copy);
    json_decref(back);
    free(bytes);
    return copy;
}

/* Jansson judges what UTF-8 is: such text comes back as it was, any other as some text. */
static void check_text(const char *text) {
    char *back = written_and_parsed(text);
    json_t *judged = json_string(text);
    if (judged)
        assert_string_equal(back, text);
    else
        assert_non_null(strchr(back, '?'));
    json_decref(judged);
    free(back);
}

UNIT_TEST(any_text_becomes_json) {
    char text[8] = {0};
    for (unsigned first = 1; first < 256; ++first) {
        for (unsigned second = 0; second < 256; ++second) {
            text[0] = (char)first, text[1] = (char)second, text[2] = 0;
            check_text(text);
        }
    }
    /* Longer sequences: every beginning with continuations at the ends of what is allowed and just past them.
     */
    static const unsigned char ends[] = {0x7f, 0x80, 0x8f, 0x90, 0x9f, 0xa0, 0xbf, 0xc0};
    for (unsigned first = 0xdf; first < 256; ++first) {
        for (unsigned i = 0; i < 8 * 8 * 8; ++i) {
            text[0] = (char)first, text[1] = (char)ends[i % 8], text[2] = (char)ends[i / 8 % 8];
            text[3] = (char)ends[i / 64], text[4] = 'x', text[5] = 0;
            check_text(text);
            text[3] = 0;
            check_text(text);
        }
    }
    check_text("a \"name\" with \\ and \n in it");
}

/* One wrong byte becomes one mark; what is around it stays. */
UNIT_TEST(invalid_utf8_becomes_question_marks) {
    const char *const cases[][2] = {{"a\xff"
                                     "b",
                                     "a?b"},
                                    {"\xc3\xa9\xc3", "\xc3\xa9?"},
                                    {"\xed\xa0\x80", "???"},
                                    {"\xf4\x90\x80\x80.", "????."},
                                    {"\xe2\x82\xac\xe2\x82", "\xe2\x82\xac??"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char *back = written_and_parsed(cases[i][0]);
        assert_string_equal(back, cases[i][1]);
        free(back);
    }
}

/* ---- names ---- */

/* Each material gets a name of its own, in OBJ one that every reader takes whole: the scene's if there is
 * one. */
UNIT_TEST(names_are_words_and_differ) {
    const char *const given[] = {"red",       "two words",        "red", "", NULL, "material_3", "a#b",
                                 "tab\there", "\xc3\xa9t\xc3\xa9"};
    const char *const expected[][9] = {{"red", "two words", "material_13", "material_4", "material_5",
                                        "material_3", "a#b", "tab\there", "\xc3\xa9t\xc3\xa9"},
                                       {"red", "material_2", "material_13", "material_4", "material_5",
                                        "material_3", "material_7", "material_8", "\xc3\xa9t\xc3\xa9"}};
    fathom_material material = default_material();
    fathom_scene *scene = new_scene(context);
    for (size_t i = 0; i < sizeof given / sizeof *given; ++i)
        assert_ok(context, fathom_scene_add_material(scene, given[i], &material, NULL));
    for (int words = 0; words < 2; ++words) {
        note_list notes = {.count = 0};
        char **names;
        assert_int_equal(write_names(scene, false, words, &notes, &names), FATHOM_OK);
        for (size_t i = 0; i < sizeof given / sizeof *given; ++i)
            assert_string_equal(names[i + 1], expected[words][i]);
        write_names_free(names, scene->materials.count);
        assert_int_equal(notes.items[0].count, words ? 4 : 1);
    }
}

/* ---- vertices ---- */

static const float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0},
                   normals[9] = {0, 0, 1, 0, 1, 0, 1, 0, 0}, uvs[10] = {0, 0, 1, 0, 0, 1, 1, 1, 0.5f, 0.5f};
static const uint32_t triangles[6] = {0, 1, 2, 2, 1, 3};

static fathom_mesh two_triangles(void) {
    fathom_mesh mesh = default_mesh();
    mesh.positions = positions, mesh.vertex_count = 4, mesh.indices = triangles, mesh.triangle_count = 2;
    mesh.position_stride = mesh.normal_stride = 12, mesh.uv_stride = 8;
    return mesh;
}

/* Every corner is what it was. */
static void check_corners(const fathom_mesh *mesh, const write_mesh *out) {
    for (uint32_t c = 0; c < 6; ++c) {
        uint32_t v = write_mesh_index(out, c), p = mesh->indices[c];
        assert_true(v < out->vertex_count);
        vec3_f32 position = write_mesh_position(out, v);
        assert_memory_equal(&position, mesh->positions + (size_t)3 * p, sizeof position);
        if (mesh->normals && !out->facets) {
            uint32_t n = mesh->normal_indices ? mesh->normal_indices[c] : p;
            vec3_f32 normal = write_mesh_normal(out, v);
            assert_memory_equal(&normal, mesh->normals + (size_t)3 * n, sizeof normal);
        }
        float uv[4];
        uint32_t t = mesh->uv_indices ? mesh->uv_indices[c] : p;
        if (!mesh->uvs) continue;
        write_mesh_entry(out, MESH_UVS, v, uv);
        assert_memory_equal(uv, mesh->uvs + (size_t)2 * t, 2 * sizeof *uv);
    }
}

/* Corners that agree in all are one vertex: the two triangles share two positions. */
UNIT_TEST(equal_corners_share_a_vertex) {
    static const uint32_t same[6] = {0, 0, 0, 0, 0, 0}, one_each[6] = {0, 0, 0, 1, 1, 1},
                          seam[6] = {0, 1, 2, 4, 1, 3};
    const struct {
        const uint32_t *normal_indices, *uv_indices;
        uint32_t vertices;
    } cases[] = {{same, NULL, 4}, {one_each, NULL, 6}, {NULL, seam, 5}, {same, seam, 5}, {one_each, seam, 6}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        fathom_mesh mesh = two_triangles();
        mesh.normals = cases[i].normal_indices ? normals : NULL, mesh.normal_count = 3;
        mesh.uvs = cases[i].uv_indices ? uvs : NULL, mesh.uv_count = 5;
        mesh.normal_indices = cases[i].normal_indices, mesh.uv_indices = cases[i].uv_indices;
        write_mesh out;
        assert_ok(context, write_mesh_prepare(context, &mesh, false, &out));
        assert_int_equal(out.vertex_count, cases[i].vertices);
        check_corners(&mesh, &out);
        write_mesh_free(&out);
    }
}

/* Facets have corners of their own, which keep their texture coordinates, and the facet's normal. */
UNIT_TEST(facets_keep_texture_coordinates) {
    static const uint32_t seam[6] = {0, 1, 2, 4, 1, 3};
    for (int i = 0; i < 3; ++i) {
        fathom_mesh mesh = two_triangles();
        if (i > 0) mesh.uvs = uvs, mesh.uv_count = 5;
        if (i > 1) mesh.uv_indices = seam;
        write_mesh out;
        assert_ok(context, write_mesh_prepare(context, &mesh, true, &out));
        assert_int_equal(out.vertex_count, 6);
        check_corners(&mesh, &out);
        for (uint32_t v = 0; v < 6; ++v) assert_true(write_mesh_normal(&out, v).z == 1);
        write_mesh_free(&out);
    }
    fathom_mesh large = two_triangles();
    large.triangle_count = UINT32_MAX / 3 + 1;
    write_mesh out;
    assert_fails(context, write_mesh_prepare(context, &large, true, &out), FATHOM_OUT_OF_RESOURCES,
                 "too many corners");
}

/* ---- materials ---- */

/* The warnings are the writer's. */
static scene_named_material through(const char *name, const fathom_material *material) {
    fathom_scene *scene, *back;
    forget_warnings();
    scene = new_scene(context);
    fathom_id id = new_material(scene, "m", material);
    fathom_mesh mesh = two_triangles();
    mesh.material = id;
    assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
    assert_ok(context, fathom_scene_write(scene, in_folder(name)));
    fathom_context_on_warning(context, NULL, NULL);
    back = scene_of_file(context, in_folder(name));
    fathom_context_on_warning(context, note_warning, NULL);
    id = find_material(back, "m");
    assert_int_not_equal(id, FATHOM_NONE);
    scene_named_material out = back->materials.items[id];
    return out;
}

static fathom_material through_file(const char *name, const fathom_material *material) {
    return through(name, material).classic;
}

/* Neither format has Phong's lobe: Blinn's of four times the exponent is as wide. MTL keeps the exponent as
 * it is written, glTF as a roughness r with 2 / r^4 - 2 for it. */
UNIT_TEST(phong_becomes_blinn) {
    fathom_material phong = default_material();
    phong.specular = FATHOM_SPECULAR_PHONG, phong.shininess = 5;
    for (int k = 0; k < 3; ++k) phong.k_s[k] = 0.125f;
    fathom_material m = through_file("m.obj", &phong);
    assert_true(m.specular == FATHOM_SPECULAR_BLINN && m.shininess == 20);
    assert_memory_equal(m.k_s, phong.k_s, sizeof m.k_s);
    m = through_file("m.glb", &phong);
    assert_int_equal(m.specular, FATHOM_SPECULAR_BLINN);
    assert_near(m.shininess, 20, 22 * 8 * 0x1p-24);
}

/* What MTL alone has: reflected ambient light; glass that lets light straight on; a mirror by Fresnel's law.
 */
UNIT_TEST(mtl_has_every_material_value) {
    fathom_material given = default_material();
    given.k_a[0] = 0.25f, given.k_a[1] = 0.5f, given.k_a[2] = 0;
    fathom_material m = through_file("m.obj", &given);
    assert_memory_equal(m.k_a, given.k_a, sizeof m.k_a);
    fathom_material_default(&given);
    given.ior = 1;
    for (int k = 0; k < 3; ++k) given.k_t[k] = 0.5f, given.k_d[k] = 0.25f;
    m = through_file("m.obj", &given);
    assert_true(m.ior == 1 && !m.fresnel && m.k_t[1] == 0.5f && m.k_r[0] == 0);
    fathom_material_default(&given);
    given.fresnel = true, given.ior = 1.75f;
    for (int k = 0; k < 3; ++k) given.k_r[k] = 1;
    m = through_file("m.obj", &given);
    assert_true(m.fresnel && m.ior == 1.75f && m.k_r[2] == 1 && m.k_t[2] == 0);
}

/* MTL has a place for all of this. */
enum { SHINY, GLASS, METAL, KINDS };

static fathom_material for_mtl(int kind) {
    fathom_material m = default_material();
    m.model = kind == METAL ? FATHOM_MODEL_METALLIC_ROUGHNESS : FATHOM_MODEL_CLASSIC;
    if (kind == SHINY) m.specular = FATHOM_SPECULAR_BLINN, m.k_s[0] = 0.3f;
    if (kind == GLASS) m.fresnel = true, m.k_r[0] = m.k_t[0] = 0.5f;
    m.metallic = m.transmission = m.clearcoat = m.anisotropy = m.emissive[0] = 0.4f, m.thickness = 1;
    m.sheen_color[0] = m.sheen_color[1] = m.sheen_color[2] = 0.4f, m.sheen_roughness = 0.5f;
    return m;
}

static bool has_effect(int kind, const char *name) {
    static const char *const without[KINDS][11] = {
        [SHINY] = {"ior", "fresnel", "normal_scale", "bump_scale"},
        [GLASS] = {"k_s", "shininess", "normal_scale", "bump_scale"},
        [METAL] = {"normal_scale", "clearcoat_normal_scale", "bump_scale", "iridescence_ior",
                   "iridescence_thickness_min", "iridescence_thickness_max", "attenuation_color",
                   "attenuation_distance", "diffuse_transmission_color", "emissive_strength", "thickness"}};
    for (int i = 0; i < 11 && without[kind][i]; ++i) {
        if (strcmp(name, without[kind][i]) == 0) return false;
    }
    return true;
}

static void set_unusual(const fathom_parameter *p, fathom_material *m) {
    void *at = (char *)m + p->offset;
    if (p->type == FATHOM_PARAMETER_BOOL)
        *(bool *)at = !*(bool *)at;
    else if (p->type != FATHOM_PARAMETER_F32)
        *(uint32_t *)at = 1;
    else
        for (unsigned c = 0; c < p->count || !c; ++c)
            ((float *)at)[c] = (p->low > 0.3 || p->fallback > 1 ? 1.75f : 0.3f) / (float)(c + 1);
}

static double number_of(const fathom_parameter *p, const fathom_material *m) {
    return (double)*(const float *)(const void *)((const char *)m + p->offset);
}

/* Each alone. Decimal numbers and turns lose a rounding or two. */
UNIT_TEST(mtl_keeps_every_parameter_or_tells) {
    for (int kind = 0; kind < KINDS; ++kind) {
        size_t count;
        const fathom_parameter *rows = fathom_material_parameters(for_mtl(kind).model, &count);
        for (size_t i = 0; i <= count; ++i) {
            fathom_material given = for_mtl(kind);
            if (i < count && !has_effect(kind, rows[i].name)) continue;
            if (i < count) set_unusual(&rows[i], &given);
            const fathom_material got = through("m.obj", &given).value;
            if (i == count) assert_string_equal(warned, "");
            for (size_t k = 0; k < count && !warned[0]; ++k) {
                if (rows[k].type != FATHOM_PARAMETER_F32 || !has_effect(kind, rows[k].name)) continue;
                const double was = number_of(&rows[k], &given), is = number_of(&rows[k], &got);
                if (fabs(was - is) > 0x1p-22 * fabs(was))
                    fail_msg("%s: %g becomes %g with another %s", rows[k].name, was, is,
                             i < count ? rows[i].name : "name");
            }
            if (got.lit_from_behind != given.lit_from_behind || got.double_sided != given.double_sided ||
                got.multiscatter != given.multiscatter || got.priority != given.priority)
                assert_string_not_equal(warned, "");
        }
    }
}

static fathom_material grey(float k_d, float k_r, float k_t, bool fresnel) {
    fathom_material m = default_material();
    m.fresnel = fresnel;
    for (int k = 0; k < 3; ++k) m.k_d[k] = k_d, m.k_r[k] = k_r, m.k_t[k] = k_t;
    return m;
}

/* A note names each parameter that the reader finds changed, and no other one. */
UNIT_TEST(mtl_names_what_it_changes) {
    fathom_material m = grey(0.5f, 0, 0, false);
    m.k_a[0] = m.k_a[1] = m.k_a[2] = 1;
    through("m.obj", &m);
    expect_warning("\"ka\"");
    m = grey(0.5f, 0, 0, false);
    m.specular = FATHOM_SPECULAR_BLINN, m.shininess = 0.5f, m.k_s[0] = 0.5f;
    through("m.obj", &m);
    expect_warning("\"specular\"");
    m = grey(0.1f, 0.75f, 0.5f, false);
    through("m.obj", &m);
    expect_warning("\"kr\"");
    assert_null(strstr(warned, "\"kd\""));
    m = grey(0, 1, 1, false);
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.transmission = m.thickness = 1, m.attenuation_distance = 0.5f, m.attenuation_color[1] = 0.5f;
    through("m.obj", &m);
    expect_warning("\"attenuationColor\"");
    /* By Fresnel's law there is no mirror at an index of 1. */
    m = grey(0, 1, 0.5f, true), m.ior = 1;
    assert_true(through("m.obj", &m).value.k_r[0] == 0);
    assert_string_equal(warned, "");
    m = grey(0.25f, 0.75f, 0, false), m.specular = FATHOM_SPECULAR_BLINN;
    memcpy(m.k_s, m.k_r, sizeof m.k_s);
    assert_int_equal(through("m.obj", &m).value.specular, FATHOM_SPECULAR_BLINN);
    assert_string_equal(warned, "");
}

/* Scene JSON shows half of an image on each triangle of such a mesh, and lights nothing. by_instance: the
 * mesh has no images of its own, and is placed by an instance whose material has. */
static void write_without_coordinates(bool by_instance) {
    static const char *const names[] = {"m.obj", "m.glb", "m.json"};
    const fathom_texture image = {.size = sizeof image, .bytes = "\x89PNG\r\n", .byte_count = 6};
    fathom_material m = default_material();
    fathom_mesh mesh = two_triangles();
    fathom_instance instance = default_instance();
    fathom_id id, outer, group = FATHOM_ROOT;
    fathom_scene *scene = new_scene(context);
    assert_ok(context, fathom_scene_add_texture(scene, &image, &m.maps[FATHOM_MAP_COLOR].texture));
    assert_ok(context, fathom_scene_add_material(scene, "m", &m, &id));
    if (by_instance) {
        assert_ok(context, fathom_scene_add_group(scene, "inner", &group));
        assert_ok(context, fathom_scene_add_group(scene, "outer", &outer));
        instance.group = group, instance.parent = outer;
        assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
        instance.group = outer, instance.parent = FATHOM_ROOT, instance.material = id;
        assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
    } else {
        mesh.material = id;
    }
    assert_ok(context, fathom_scene_add_mesh(scene, group, &mesh, NULL));
    scene->has_lights = true;
    for (int k = 0; k < 3; ++k) {
        forget_warnings();
        assert_ok(context, fathom_scene_write(scene, in_folder(names[k])));
        assert_int_equal(strstr(warned, "a mesh with images has no texture coordinates") != NULL, k < 2);
        assert_int_equal(strstr(warned, "an empty list of lights is left out") != NULL, k < 2);
        unlink(in_folder("m-0.png"));
    }
}

UNIT_TEST(images_without_coordinates_and_scenes_without_lights_are_told) {
    write_without_coordinates(false);
    write_without_coordinates(true);
}

int main(void) { return unit_main(open_folder, remove_folder); }
