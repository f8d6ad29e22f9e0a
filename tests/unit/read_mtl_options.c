/* MTL: options of images in any order, and materials whose images are lost. */
#include "mesh_file.h"

#include "read/obj/obj.h"

/* An OBJ file with this library. */
static fathom_scene *scene_of(const char *body) {
    const char *text = unit_text("newmtl m\n%s", body);
    put_text("m.mtl", text);
    const read_mesh_options options = {.material = FATHOM_NONE};
    return mesh_read(
        read_obj,
        put_text("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n"),
        options);
}

static fathom_material material_of(const char *body) {
    fathom_scene *scene = scene_of(body);
    return scene->materials.items[mesh_at(scene, 0)->material].value;
}

static void write_image(const char *name) { mesh_write(name, "P6\n1 1\n255\n\0\0\0", 14); }

/* The image's channel and transform do not depend on the order of the options, nor on options that are not
 * read, whatever they are followed by. */
UNIT_TEST(options_of_images_may_be_in_any_order) {
    static const char *const options[] = {
        "-s 2 3 -o 0.5 0.25 -imfchan b",
        "-imfchan b -o 0.5 0.25 0 -s 2 3 1",
        "-blendu on -blendv off -imfchan b -cc off -o 0.5 0.25 -boost 2 -s 2 3 -texres 512",
        "-mm 0 1 -s 2 3 -t 0.1 0.2 0.3 -o 0.5 0.25 -type sphere -imfchan b",
        "-t 0.1 -imfchan b -mm 0.5 2 -o 0.5 0.25 -s 2 3",
    };
    const float transform[6] = {2, 0, 0.5f, 0, -3, 0.75f};
    write_image("1.ppm");
    for (size_t i = 0; i < sizeof options / sizeof *options; ++i) {
        char body[160];
        snprintf(body, sizeof body, "map_Ns %s 1.ppm\n", options[i]);
        const fathom_map map = material_of(body).maps[FATHOM_MAP_SHININESS];
        assert_int_not_equal(map.texture, FATHOM_NONE);
        assert_int_equal(map.channel, 2);
        for (int k = 0; k < 6; ++k) assert_true(map.transform[k] == transform[k]);
        assert_true(!strstr(warned, "-mm and -t") == (i < 3));
    }
    static const char *const channels[] = {"r", "g", "b", "m"};
    for (uint32_t c = 0; c < 4; ++c) {
        const char *body = unit_text("map_d -imfchan %s 1.ppm\nmap_Kd 1.ppm\n", channels[c]);
        assert_int_equal(material_of(body).maps[FATHOM_MAP_OPACITY].channel, c);
    }
    assert_int_equal(material_of("map_d 1.ppm\nmap_Kd 1.ppm\n").maps[FATHOM_MAP_OPACITY].channel, 3);
}

/* Ps is a number, although the sheen of other formats is a colour. */
UNIT_TEST(images_of_numbers_are_linear) {
    static const char *const colors[] = {"map_Kd", "map_Ks", "map_Ke"}, *const numbers[] = {
                                                                            "map_Ns", "map_d",  "map_Pr",
                                                                            "map_Pm", "map_Pc", "map_Pcr",
                                                                            "map_Ps", "norm",   "bump"};
    write_image("1.ppm");
    for (size_t i = 0; i < sizeof colors / sizeof *colors + sizeof numbers / sizeof *numbers; ++i) {
        fathom_scene *scene = scene_of(unit_text("%s 1.ppm\n", i < 3 ? colors[i] : numbers[i - 3]));
        assert_int_equal(scene->textures.count, 1);
        assert_int_equal(scene->textures.items[0].color_space,
                         i < 3 ? FATHOM_COLOR_AUTO : FATHOM_COLOR_LINEAR);
    }
}

/* An image alone means a factor of 1. Without the image, that would be a lamp, a mirror, a coat or a sheen
 * all over. */
UNIT_TEST(lost_images_leave_no_layer) {
    fathom_material m = material_of("Kd 0.5 0.5 0.5\nmap_Ke no.png\nmap_Ks no.png\nillum 3\nNs 9\n");
    for (int c = 0; c < 3; ++c) assert_true(m.k_e[c] == 0 && m.k_s[c] == 0 && m.k_r[c] == 0);
    assert_int_equal(material_of("map_Kd .\nmap_Ks ..\\\n").maps[FATHOM_MAP_COLOR].texture, FATHOM_NONE);
    expect_warning("there is no image \".\" that may be read");
    m = material_of(
        "map_Kd no.png\nmap_Pm no.png\nmap_Pr no.png\nmap_Pc no.png\nmap_Ps no.png\nmap_Ke no.png\n");
    assert_int_equal(m.model, FATHOM_MODEL_METALLIC_ROUGHNESS);
    assert_true(m.metallic == 0 && m.roughness == 1 && m.clearcoat == 0);
    for (int c = 0; c < 3; ++c)
        assert_true(m.base_color[c] == 0.5f && m.sheen_color[c] == 0 && m.emissive[c] == 0);
}

/* Any of the keys selects the model. */
UNIT_TEST(every_pbr_key_selects_the_model) {
    static const char *const keys[] = {"Pr", "Pm", "Pc", "Ps", "aniso"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i) {
        const fathom_material m = material_of(unit_text("Kd 1 1 1\n%s 0.25\n", keys[i]));
        assert_int_equal(m.model, FATHOM_MODEL_METALLIC_ROUGHNESS);
        const float found[] = {m.roughness, m.metallic, m.clearcoat, m.sheen_color[1], m.anisotropy};
        assert_true(found[i] == 0.25f);
    }
    assert_int_equal(material_of("Pcr 0.5\nanisor 0.5\n").model, FATHOM_MODEL_CLASSIC);
}

/* A NaN leaves what was before it. */
UNIT_TEST(a_nan_changes_nothing) {
    assert_true(material_of("Pr 0.5\nd 0.25\nTr nan\n").opacity == 0.25f);
    assert_true(material_of("Pr 0.5\nd 0.25\nd nan\n").opacity == 0.25f);
    assert_true(material_of("Pr 0.5\nTr nan\n").opacity == 1);
}

int main(void) { return unit_main(open_folder, remove_folder); }
