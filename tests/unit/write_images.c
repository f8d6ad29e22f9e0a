/* Images beside files that are written: each keeps its bytes, whatever their names are. */
#include "wearing.h"

#include <sys/stat.h>

/* A material with two images: the colour's is in memory, and the roughness's a file of this name, or of the
 * other order. */
static fathom_scene *wearing_two(const char *file, bool file_first) {
    fathom_id id, ids[2];
    fathom_material m = default_material();
    fathom_texture inner = default_texture(), outer = default_texture();
    inner.bytes = "\x89PNG\r\n inner", inner.byte_count = 12;
    outer.file = in_folder(file), outer.color_space = FATHOM_COLOR_LINEAR;
    fathom_scene *scene = new_scene(context);
    for (int i = 0; i < 2; ++i) {
        const bool is_file = (i == 0) == file_first;
        assert_ok(context, fathom_scene_add_texture(scene, is_file ? &outer : &inner, &ids[is_file]));
    }
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.maps[FATHOM_MAP_COLOR] = (fathom_map){.texture = ids[0], .transform = {1, 0, 0, 0, 1, 0}};
    m.maps[FATHOM_MAP_ROUGHNESS] =
        (fathom_map){.texture = ids[1], .transform = {1, 0, 0, 0, 1, 0}, .channel = 1};
    assert_ok(context, fathom_scene_add_material(scene, "two words", &m, &id));
    const fathom_mesh mesh = triangle(id);
    assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
    return scene;
}

static void assert_file(const char *path, const char *expected) {
    char bytes[64];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    assert_int_equal(size, strlen(expected));
    assert_memory_equal(bytes, expected, size);
}

static const char *file_of(const fathom_scene *scene, int kind) {
    const fathom_id texture = worn(scene)->maps[kind].texture;
    assert_int_not_equal(texture, FATHOM_NONE);
    assert_non_null(scene->textures.items[texture].file);
    return scene->textures.items[texture].file;
}

/* A file that stays in its place may have the very name that a copy would get. */
UNIT_TEST(copies_replace_no_image_of_the_scene) {
    static const char *const names[] = {"a-0.png", "a-1.png", "b.png"};
    for (int k = 0; k < 6; ++k) {
        const char *name = names[k / 2];
        unit_write_file(in_folder(name), "\x89PNG\r\n outer", 12);
        fathom_scene *back = through(wearing_two(name, k % 2), JSON);
        assert_file(in_folder(name), "\x89PNG\r\n outer");
        assert_file(file_of(back, FATHOM_MAP_ROUGHNESS), "\x89PNG\r\n outer");
        assert_file(file_of(back, FATHOM_MAP_COLOR), "\x89PNG\r\n inner");
        assert_string_equal(file_of(back, FATHOM_MAP_ROUGHNESS), in_folder(name));
        unlink(file_of(back, FATHOM_MAP_COLOR));
    }
}

/* Files elsewhere are copied; what is below the folder stays, by its relative name. */
UNIT_TEST(files_below_the_folder_stay_and_others_are_copied) {
    assert_int_equal(mkdir(in_folder("below"), 0700), 0);
    unit_write_file(in_folder("below/x.png"), "\x89PNG\r\n below", 12);
    fathom_scene *back = through(wearing_two("below/x.png", false), JSON);
    assert_string_equal(file_of(back, FATHOM_MAP_ROUGHNESS), in_folder("below/x.png"));
    unlink(file_of(back, FATHOM_MAP_COLOR));
    assert_int_equal(mkdir(in_folder("below-2"), 0700), 0);
    unit_write_file(unit_text("%s", in_folder("below-2/y.png")), "\x89PNG\r\n above", 12);
    fathom_scene *scene = wearing_two("below-2/y.png", true);
    assert_ok(context, fathom_scene_write(scene, in_folder("below/a.json")));
    assert_file(in_folder("below/a-0.png"), "\x89PNG\r\n above");
    assert_file(in_folder("below/a-1.png"), "\x89PNG\r\n inner");
}

/* MTL takes what begins with a minus sign for an option; a line of text ends, and so do its blanks. */
UNIT_TEST(obj_and_ply_name_images_whatever_they_are_called) {
    static const char *const names[] = {"-s 1 b.png", " b.png", "b.png ", "a\nb.png",
                                        "b b#.png",   "-",      "b.",     "a # b.png"};
    for (size_t i = 0; i < 2 * sizeof names / sizeof *names; ++i) {
        const char *name = names[i / 2], *out = i % 2 ? "a.obj" : "a.ply";
        fathom_texture file = default_texture();
        fathom_material m = default_material();
        m.maps[FATHOM_MAP_COLOR].texture = 0;
        file.file = in_folder(name);
        unit_write_file(in_folder(name), "\x89PNG\r\n outer", 12);
        fathom_scene *scene = wearing(&m, &file);
        fathom_scene *back = written(scene, out);
        assert_int_equal(back->textures.count, 1);
        assert_file(back->textures.items[0].file, "\x89PNG\r\n outer");
        unlink(back->textures.items[0].file);
    }
}

/* JSON is UTF-8, and names of files need not be. */
UNIT_TEST(json_names_images_whatever_they_are_called) {
    static const char *const names[] = {"b\xff.png", "b.\xff", "b.png"}, *const outs[] = {"a.json",
                                                                                          "a\xff.json"};
    for (size_t i = 0; i < 6; ++i) {
        const char *name = names[i / 2], *out = outs[i % 2];
        unit_write_file(in_folder(name), "\x89PNG\r\n outer", 12);
        fathom_scene *scene = wearing_two(name, false);
        fathom_scene *back = written(scene, out);
        assert_file(file_of(back, FATHOM_MAP_ROUGHNESS), "\x89PNG\r\n outer");
        assert_file(file_of(back, FATHOM_MAP_COLOR), "\x89PNG\r\n inner");
        unlink(unit_text("%s", file_of(back, FATHOM_MAP_ROUGHNESS))), unlink(file_of(back, FATHOM_MAP_COLOR));
    }
}

static const char *face_path(const char *pattern, unsigned face) {
    static const char *const words[] = {"px", "nx", "py", "ny", "pz", "nz"};
    return in_folder(unit_text(pattern, words[face]));
}

static void add_sky(fathom_scene *scene, const char *pattern) {
    fathom_light light = default_light();
    light.type = FATHOM_LIGHT_ENVIRONMENT, light.file = in_folder(pattern);
    assert_ok(context, fathom_scene_add_light(scene, &light, NULL));
}

/* The same for environments of six files. */
UNIT_TEST(copies_replace_no_faces_of_the_scene) {
    fathom_material m = default_material();
    assert_int_equal(mkdir(in_folder("below"), 0700), 0);
    for (unsigned i = 0; i < 6; ++i) {
        char text[16];
        snprintf(text, sizeof text, "above %u", i);
        unit_write_file(face_path("s-%s.hdr", i), text, strlen(text));
        snprintf(text, sizeof text, "below %u", i);
        unit_write_file(face_path("below/a-sky-0-%s.hdr", i), text, strlen(text));
    }
    fathom_scene *scene = wearing(&m, NULL);
    add_sky(scene, "s-<FACE>.hdr");
    add_sky(scene, "below/a-sky-0-<FACE>.hdr");
    assert_ok(context, fathom_scene_write(scene, in_folder("below/a.json")));
    for (unsigned i = 0; i < 6; ++i) {
        char text[16];
        snprintf(text, sizeof text, "below %u", i);
        assert_file(face_path("below/a-sky-0-%s.hdr", i), text);
        snprintf(text, sizeof text, "above %u", i);
        assert_file(face_path("below/a-sky-1-%s.hdr", i), text);
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
