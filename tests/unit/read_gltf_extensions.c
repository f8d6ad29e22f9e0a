/* Extensions that are not supported: silent if no image changes, else a note, and refused if required. */
#include "gltf_build.h"

/* Extensions that say nothing about how things look may be required. */
UNIT_TEST(facts_may_be_required) {
    read_triangle(WITH_DATA(TRIANGLE_MESH ",'extensionsRequired':['KHR_xmp_json_ld','EXT_mesh_features']"));
    assert_int_equal(warning_count, 0);
}

/* A triangle whose material uses this extension, which the file does not require. */
static unsigned notes_on(const char *extension) {
    read_triangle(
        unit_text(WITH_DATA(TRIANGLE_MESH ",'extensionsUsed':['%s'],'materials':[{'extensions':{'%s':{}}}]"),
                  extension, extension));
    return warning_count;
}

UNIT_TEST(extensions_that_change_no_image_add_no_note) {
    static const char *const names[] = {"KHR_xmp_json_ld",
                                        "KHR_node_selectability",
                                        "KHR_node_hoverability",
                                        "KHR_interactivity",
                                        "KHR_audio_emitter",
                                        "KHR_physics_rigid_bodies",
                                        "KHR_implicit_shapes",
                                        "EXT_structural_metadata",
                                        "EXT_mesh_manifold",
                                        "FB_ngon_encoding",
                                        "AGI_stk_metadata",
                                        "GODOT_single_root",
                                        "MSFT_lod",
                                        "MSFT_packing_normalRoughnessMetallic",
                                        "VRMC_vrm"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
        if (notes_on(names[i])) fail_msg("%s", warned);
}

/* One note, which names the extension and says what is shown in its place. */
UNIT_TEST(extensions_that_change_an_image_say_what_is_shown) {
    static const struct {
        const char *name, *shown;
    } cases[] = {{"KHR_gaussian_splatting", "splats are shown as points"},
                 {"KHR_materials_volume_scatter", "volumes absorb light, but do not scatter it"},
                 {"EXT_lights_image_based", "do not light the scene; --environment takes an image that does"},
                 {"CESIUM_primitive_outline", "outlines are not drawn"},
                 {"VRMC_materials_mtoon", "materials have glTF's own parameters alone"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const char *expected = unit_text("materials[0]: the extension %s is ignored: ", cases[i].name);
        assert_int_equal(notes_on(cases[i].name), 1);
        if (!strstr(warned, expected) || !strstr(warned, cases[i].shown)) fail_msg("%s", warned);
    }
}

UNIT_TEST(extensions_that_change_an_image_are_refused_by_name_when_required) {
    static const char *const names[] = {"KHR_gaussian_splatting", "KHR_texture_procedurals",
                                        "KHR_accessor_float64", "EXT_texture_astc", "A_b"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        const char *json = unit_text(WITH_DATA(TRIANGLE_MESH ",'extensionsRequired':['%s']"), names[i]);
        const char *expected = unit_text(
            "extensionsRequired[0]: the file cannot be read without the extension \"%s\", which is not "
            "supported; export it without",
            names[i]);
        write_triangle(json);
        assert_bad_input(expected);
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
