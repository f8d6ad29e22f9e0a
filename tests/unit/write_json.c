/* A scene of calls and the scene JSON that it becomes are one scene. */
#include "scene/scene.h"

#include "render.h"
#include "wearing.h"

static fathom_id add_image(fathom_scene *scene, fathom_color_space space) {
    static const char pixels[] = "P6\n2 2\n255\n\x10\x40\x80\xc0\x30\x60\x90\xf0\x20\x50\x70\xb0";
    const fathom_texture texture = {
        .size = sizeof texture, .bytes = pixels, .byte_count = sizeof pixels - 1, .color_space = space};
    fathom_id id;
    assert_ok(context, fathom_scene_add_texture(scene, &texture, &id));
    return id;
}

/* One image for a colour and for numbers, as callers that do not think of color spaces give it. */
UNIT_TEST(images_of_numbers_are_linear_unless_their_space_is_given) {
    static const fathom_map_kind kinds[] = {FATHOM_MAP_ROUGHNESS, FATHOM_MAP_NORMAL, FATHOM_MAP_BUMP,
                                            FATHOM_MAP_ANISOTROPY};
    fathom_material m;
    fathom_id id;
    fathom_material_default(&m);
    fathom_scene *scene = wearing(&m, NULL);
    const fathom_id found = add_image(scene, FATHOM_COLOR_AUTO), srgb = add_image(scene, FATHOM_COLOR_SRGB);
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.maps[FATHOM_MAP_COLOR].texture = found;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) m.maps[kinds[i]].texture = found;
    m.maps[FATHOM_MAP_METALLIC].texture = srgb;
    m.maps[FATHOM_MAP_OPACITY].texture = found, m.maps[FATHOM_MAP_OPACITY].channel = 3;
    assert_ok(context, fathom_scene_add_material(scene, "mapped", &m, &id));
    const fathom_map *maps = scene->materials.items[id].value.maps;
    assert_int_equal(maps[FATHOM_MAP_COLOR].texture, found);
    assert_int_equal(maps[FATHOM_MAP_METALLIC].texture, srgb);
    assert_int_equal(maps[FATHOM_MAP_OPACITY].texture, found); /* alpha is linear in any space */
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i)
        assert_int_equal(scene->textures.items[maps[kinds[i]].texture].color_space, FATHOM_COLOR_LINEAR);
    fathom_scene_destroy(scene);
}

int main(void) { return unit_main(open_folder, remove_folder); }
