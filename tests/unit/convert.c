/* Writers keep what readers read: parameters, images and whole renders that go through a file. */
#include "scene/scene.h"

#include "render.h"
#include "wearing.h"

#include <fathom/parameter.h>

/* ---- parameters ---- */

/* glTF has no place for these; the slopes' factor stands at their image there. */
static bool in_format(int format, const char *name) {
    static const char *const lacking[] = {"priority", "multiscatter", "normal_scale",
                                          "clearcoat_normal_scale", "bump_scale"};
    for (size_t i = 0; i < sizeof lacking / sizeof *lacking; ++i) {
        if (format == GLB && strcmp(name, lacking[i]) == 0) return false;
    }
    return true;
}

/* A number that is not the default and that few bits do not hold. */
static double unusual(const fathom_parameter *p) {
    static const double candidates[] = {0.3, 0.7, 1.7, 3};
    if (p->type == FATHOM_PARAMETER_BOOL) return p->fallback == 0;
    if (p->type == FATHOM_PARAMETER_U32) return 3;
    if (strcmp(p->name, "ior") == 0) return 1.7; /* glTF's begins at 1 */
    for (size_t i = 0; i < 4; ++i) {
        if (candidates[i] >= p->low && candidates[i] <= p->high && candidates[i] != p->fallback)
            return candidates[i];
    }
    fail_msg("no number for %s", p->name);
    return 0;
}

static void *member(const fathom_parameter *p, const fathom_material *m) {
    return (char *)(uintptr_t)m + p->offset;
}

static size_t width(const fathom_parameter *p) {
    return p->type == FATHOM_PARAMETER_BOOL ? 1 : 4 * (size_t)(p->count ? p->count : 1);
}

/* All layers of a material, a volume and, in scene JSON, images of slopes: without these some parameters have
 * no effect, and are not written. */
static fathom_material layered(int format) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.thickness = 1, m.transmission = 0.4f;
    m.attenuation_distance = 2, m.attenuation_color[1] = 0.4f, m.emissive[0] = 0.4f, m.sheen_color[0] = 0.4f;
    m.clearcoat = m.anisotropy = m.iridescence = m.diffuse_transmission = m.opacity = 0.4f;
    static const fathom_map_kind kinds[] = {FATHOM_MAP_NORMAL, FATHOM_MAP_CLEARCOAT_NORMAL, FATHOM_MAP_BUMP,
                                            FATHOM_MAP_IRIDESCENCE_THICKNESS};
    for (size_t i = 0; format == JSON && i < sizeof kinds / sizeof *kinds; ++i) m.maps[kinds[i]].texture = 0;
    return m;
}

/* Each alone has an unusual value. */
UNIT_TEST(every_material_parameter_reads_back) {
    const fathom_texture image = {.size = sizeof image, .bytes = "\x89PNG\r\n of no use", .byte_count = 16};
    size_t count;
    const fathom_parameter *rows = fathom_material_parameters(FATHOM_MODEL_METALLIC_ROUGHNESS, &count);
    for (size_t i = 0; i < FORMATS * count; ++i) {
        const fathom_parameter *p = &rows[i / FORMATS];
        const int format = (int)(i % FORMATS);
        fathom_material given = layered(format);
        float numbers[3] = {(float)unusual(p), (float)unusual(p) / 2, (float)unusual(p) / 3};
        const bool flag = numbers[0] != 0;
        const uint32_t number = 3;
        memcpy(member(p, &given),
               p->type == FATHOM_PARAMETER_BOOL  ? (const void *)&flag
               : p->type == FATHOM_PARAMETER_U32 ? (const void *)&number
                                                 : numbers,
               width(p));
        if (!in_format(format, p->name)) continue;
        fathom_scene *back = through(wearing(&given, format == JSON ? &image : NULL), format);
        unlink(in_folder("a-0.png"));
        for (size_t k = 0; k < count; ++k) {
            if (memcmp(member(&rows[k], &given), member(&rows[k], worn(back)), width(&rows[k])) != 0)
                fail_msg("%s: %s changes with an unusual %s", formats[format], rows[k].name, p->name);
        }
    }
}

UNIT_TEST(every_setting_reads_back_from_json) {
    static const char *const values[][2] = {
        {"integrator", "classic"}, {"integrator", "reference"}, {"width", "333"},        {"spp", "64"},
        {"pattern", "stratified"}, {"filter", "gaussian"},      {"filter_width", "1.7"}, {"seed", "77"},
        {"crop", "1,2,300,400"},   {"target_error", "0.3"},     {"min_spp", "8"},        {"max_depth", "3"},
        {"min_weight", "0.001"},   {"aovs", "Z,albedo"}};
    for (size_t i = 0; i < sizeof values / sizeof *values; ++i) {
        fathom_settings given = default_settings(), got;
        fathom_material plain = default_material();
        char text[2][256];
        size_t count;
        if (strcmp(values[i][0], "pattern") == 0) given.target_error = 0;
        assert_ok(context, fathom_settings_set_text(context, &given, values[i][0], values[i][1]));
        if (strcmp(values[i][0], "integrator") == 0) fathom_settings_set_integrator(&given, given.integrator);
        fathom_scene *scene = wearing(&plain, NULL);
        assert_ok(context, fathom_scene_set_settings(scene, &given));
        fathom_scene *back = through(scene, JSON);
        fathom_scene_settings(back, &got);
        const fathom_parameter *rows = fathom_settings_parameters(&count);
        for (size_t k = 0; k < count; ++k) {
            if (!(rows[k].flags & FATHOM_PARAMETER_FILE)) continue;
            assert_ok(context, fathom_settings_get_text(context, &given, rows[k].name, text[0], 256));
            assert_ok(context, fathom_settings_get_text(context, &got, rows[k].name, text[1], 256));
            if (strcmp(text[0], text[1]) != 0)
                fail_msg("%s %s: %s is %s, was %s", values[i][0], values[i][1], rows[k].name, text[1],
                         text[0]);
        }
    }
}

/* ---- images ---- */

/* The channel that glTF gives an image; -1: it has no image of this alone. */
static int channel_of(int kind) {
    switch (kind) {
    case FATHOM_MAP_SPECULAR:
    case FATHOM_MAP_SHEEN_ROUGHNESS:
    case FATHOM_MAP_DIFFUSE_TRANSMISSION: return 3;
    case FATHOM_MAP_CLEARCOAT_ROUGHNESS:
    case FATHOM_MAP_IRIDESCENCE_THICKNESS: return 1;
    case FATHOM_MAP_METALLIC:
    case FATHOM_MAP_ROUGHNESS:
    case FATHOM_MAP_OPACITY:
    case FATHOM_MAP_BUMP:
    case FATHOM_MAP_SHININESS: return -1;
    default: return 0;
    }
}

static void check_map(const fathom_scene *back, const fathom_map *given, int kind,
                      const fathom_texture *texture) {
    const fathom_map *map = &worn(back)->maps[kind];
    assert_int_not_equal(map->texture, FATHOM_NONE);
    const fathom_texture *got = &back->textures.items[map->texture];
    assert_true(map->uv_set == given->uv_set && map->channel == given->channel &&
                map->inverted == given->inverted);
    /* A turn and a scale have four numbers, too, but a turn is no float: each is rounded twice. All are below
     * 1. */
    for (int i = 0; i < 6; ++i) assert_near(map->transform[i], given->transform[i], 2 * 0x1p-24);
    assert_true(got->wrap_u == texture->wrap_u && got->wrap_v == texture->wrap_v &&
                got->filter == texture->filter);
    if (got->bytes) assert_memory_equal(got->bytes, texture->bytes, texture->byte_count);
}

/* Scaled, turned and moved, in the second set; of every kind that a format has. */
UNIT_TEST(every_image_reads_back) {
    const fathom_texture texture = {.size = sizeof texture,
                                    .bytes = "\x89PNG\r\n of no use",
                                    .byte_count = 16,
                                    .wrap_u = FATHOM_WRAP_CLAMP,
                                    .wrap_v = FATHOM_WRAP_MIRROR,
                                    .filter = FATHOM_TEXTURE_NEAREST};
    for (int i = 0; i < FORMATS * FATHOM_MAPS; ++i) {
        const int kind = i / FORMATS, format = i % FORMATS, channel = channel_of(kind);
        if (kind == FATHOM_MAP_SHININESS || (format == GLB && channel < 0)) continue;
        fathom_texture image = texture;
        image.color_space = kind == FATHOM_MAP_COLOR ? FATHOM_COLOR_AUTO : FATHOM_COLOR_LINEAR;
        fathom_material given = layered(GLB);
        given.metallic = given.clearcoat_roughness = given.sheen_roughness = 0.4f;
        fathom_map *map = &given.maps[kind];
        *map = (fathom_map){.texture = 0, .uv_set = 1, .transform = {0.4f, 0.36f, 0.1f, -0.3f, 0.48f, 0.2f}};
        map->channel = channel < 0 ? 2 : (uint32_t)channel, map->inverted = format == JSON;
        fathom_scene *back = through(wearing(&given, &image), format);
        check_map(back, map, kind, &texture);
        unlink(in_folder("a-0.png"));
    }
}

/* So do the parameters that have an effect only with this one. */
UNIT_TEST(images_that_raise_a_parameter_from_0_read_back) {
    static const int kinds[] = {FATHOM_MAP_METALLIC,    FATHOM_MAP_TRANSMISSION,
                                FATHOM_MAP_CLEARCOAT,   FATHOM_MAP_IRIDESCENCE,
                                FATHOM_MAP_SHEEN_COLOR, FATHOM_MAP_DIFFUSE_TRANSMISSION};
    const fathom_texture texture = {
        .size = sizeof texture, .bytes = "\x89PNG\r\n", .byte_count = 6, .color_space = FATHOM_COLOR_LINEAR};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) {
        fathom_material given = default_material();
        given.model = FATHOM_MODEL_METALLIC_ROUGHNESS, given.metallic = 0;
        given.clearcoat_roughness = kinds[i] == FATHOM_MAP_CLEARCOAT ? 0.4f : 0;
        given.maps[kinds[i]] = (fathom_map){.texture = 0, .inverted = true, .transform = {1, 0, 0, 0, 1, 0}};
        forget_warnings();
        const fathom_scene *back = through(wearing(&given, &texture), JSON);
        check_map(back, &given.maps[kinds[i]], kinds[i], &texture);
        assert_true(worn(back)->clearcoat_roughness == given.clearcoat_roughness);
        assert_null(strstr(warned, "no effect"));
        unlink(in_folder("a-0.png"));
    }
}

/* The material of the scene that comes back from .obj. */
static const fathom_material *through_obj(const fathom_scene *scene, fathom_scene **back) {
    *back = written(scene, "a.obj");
    return &(*back)->materials.items[find_material(*back, "material_1")].value;
}

/* The file's v is one minus the scene's, so that an image that lies as glTF's do needs no options. */
UNIT_TEST(mtl_keeps_metal_and_its_images) {
    const fathom_texture texture = {.size = sizeof texture,
                                    .bytes = "\x89PNG\r\n",
                                    .byte_count = 6,
                                    .wrap_u = FATHOM_WRAP_CLAMP,
                                    .wrap_v = FATHOM_WRAP_CLAMP};
    static const fathom_map_kind kinds[] = {FATHOM_MAP_COLOR, FATHOM_MAP_ROUGHNESS, FATHOM_MAP_NORMAL,
                                            FATHOM_MAP_BUMP};
    enum { KINDS = sizeof kinds / sizeof *kinds };
    fathom_material m = default_material();
    fathom_scene *back;
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.roughness = 0.3f, m.metallic = 0.7f, m.clearcoat = 0.2f;
    m.clearcoat_roughness = 0.1f, m.anisotropy = 0.6f, m.opacity = 0.9f, m.ior = 1.7f, m.normal_scale = 0.3f;
    m.bump_scale = 0.02f, m.sheen_roughness = 0.5f;
    for (int c = 0; c < 3; ++c) m.sheen_color[c] = 0.4f;
    for (size_t i = 0; i < KINDS; ++i)
        m.maps[kinds[i]] = (fathom_map){.texture = 0, .transform = {2, 0, 0.25f, 0, 3, -0.5f}};
    m.maps[FATHOM_MAP_ROUGHNESS].channel = 1;
    fathom_scene *scene = wearing(&m, &texture);
    const fathom_material *got = through_obj(scene, &back);
    assert_true(got->roughness == m.roughness && got->metallic == m.metallic &&
                got->clearcoat == m.clearcoat);
    assert_true(got->anisotropy == m.anisotropy && got->opacity == m.opacity && got->ior == m.ior);
    assert_true(got->clearcoat_roughness == m.clearcoat_roughness && got->normal_scale == m.normal_scale);
    assert_true(got->bump_scale == m.bump_scale && got->sheen_color[1] == 0.4f &&
                got->sheen_roughness == 0.5f);
    for (size_t i = 0; i < KINDS; ++i) {
        const fathom_map *map = &got->maps[kinds[i]];
        const float *t = map->transform;
        assert_int_not_equal(map->texture, FATHOM_NONE);
        assert_true(back->textures.items[map->texture].wrap_u == FATHOM_WRAP_CLAMP);
        assert_int_equal(map->channel, m.maps[kinds[i]].channel);
        assert_true(t[0] == 2 && t[2] == 0.25f && -t[4] == 3 && t[4] + t[5] == -0.5f);
    }
    for (int i = 0; i < 3; ++i) assert_true(back->meshes.items[0].uvs[2 * i + 1] == 1 - uvs[2 * i + 1]);
    unlink(in_folder("a-0.png"));
}

/* MTL repeats or clamps images in both directions, PLY repeats them. Most texture coordinates lie inside. */
UNIT_TEST(images_of_other_wrapping_are_kept_and_reported) {
    for (int i = 0; i < 2 * 9; ++i) {
        const char *file = i < 9 ? "a.obj" : "a.ply";
        const fathom_texture texture = {.size = sizeof texture,
                                        .bytes = "\x89PNG\r\n",
                                        .byte_count = 6,
                                        .wrap_u = (fathom_wrap)(i % 3),
                                        .wrap_v = (fathom_wrap)(i / 3 % 3)};
        const bool equal = texture.wrap_u == texture.wrap_v,
                   clamps = equal && texture.wrap_u == FATHOM_WRAP_CLAMP,
                   same = (equal && texture.wrap_u == FATHOM_WRAP_REPEAT) || (clamps && i < 9);
        fathom_material m = default_material();
        m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
        m.maps[FATHOM_MAP_COLOR] = (fathom_map){.texture = 0, .transform = {1, 0, 0, 0, 1, 0}};
        forget_warnings();
        const fathom_scene *back = written(wearing(&m, &texture), file);
        const fathom_texture *got = &back->textures.items[0];
        assert_int_equal(back->textures.count, 1);
        assert_int_equal(got->wrap_u, same ? texture.wrap_u : FATHOM_WRAP_REPEAT);
        assert_int_equal(got->wrap_v, same ? texture.wrap_v : FATHOM_WRAP_REPEAT);
        assert_int_equal(strstr(warned, "repeats outside of itself") == NULL, same);
        assert_null(strstr(warned, "an image on"));
        assert_null(strstr(warned, "an image that MTL"));
        unlink(in_folder("a-0.png"));
    }
}

/* Scene JSON has opacity, and one minus an older workflow's glossiness, as an image of its own, and linear.
 * In glTF they are the alpha of the colour's image. */
UNIT_TEST(glb_keeps_the_alpha_of_a_colour_image) {
    fathom_texture texture = {.size = sizeof texture, .bytes = "\x89PNG\r\n", .byte_count = 6};
    for (int k = 0; k < 6; ++k) {
        const int other = k % 3, color = k < 3 ? FATHOM_MAP_COLOR : FATHOM_MAP_SPECULAR_COLOR,
                  alpha = k < 3 ? FATHOM_MAP_OPACITY : FATHOM_MAP_ROUGHNESS;
        fathom_material m = default_material();
        m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
        if (k >= 3) m.ior = 0, m.metallic = 0;
        m.maps[color] = (fathom_map){.texture = 0, .transform = {2, 0, 0, 0, 2, 0}};
        m.maps[alpha] =
            (fathom_map){.texture = 1, .channel = 3, .inverted = k >= 3, .transform = {2, 0, 0, 0, 2, 0}};
        if (other == 1) m.maps[alpha].transform[0] = 1;
        texture.color_space = FATHOM_COLOR_AUTO, texture.bytes = "\x89PNG\r\n";
        fathom_scene *scene = new_scene(context);
        assert_ok(context, fathom_scene_add_texture(scene, &texture, NULL));
        texture.color_space = FATHOM_COLOR_LINEAR;
        if (other == 2) texture.bytes = "\x89PNG\r\a";
        assert_ok(context, fathom_scene_add_texture(scene, &texture, NULL));
        const fathom_id id = new_material(scene, "two words", &m);
        const fathom_mesh mesh = triangle(id);
        assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
        scene = through(scene, GLB);
        const fathom_map *maps = worn(scene)->maps;
        if (k < 3 || !other) assert_int_not_equal(maps[color].texture, FATHOM_NONE);
        assert_int_equal(maps[alpha].texture, other ? FATHOM_NONE : maps[color].texture);
        if (!other) assert_true(maps[alpha].channel == 3 && maps[alpha].inverted == (k >= 3));
    }
}

/* MTL has no thin walls among the keys of metals, but has glass. */
UNIT_TEST(mtl_keeps_solid_transmission_and_makes_glass_of_thin_walls) {
    for (int solid = 0; solid < 2; ++solid) {
        fathom_material m = default_material();
        fathom_scene *back;
        m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.transmission = 0.75f, m.roughness = 0, m.ior = 1.7f;
        m.thickness = (float)solid;
        fathom_scene *scene = wearing(&m, NULL);
        const fathom_material *got = through_obj(scene, &back);
        if (solid)
            assert_true(got->model == m.model && got->transmission == 0.75f && got->thickness > 0);
        else
            assert_true(got->model == FATHOM_MODEL_CLASSIC && got->k_t[0] == 0.75f && got->fresnel);
        assert_true(got->ior == 1.7f);
    }
}

/* An unlit surface has no highlight, and what has no effect is not written. */
UNIT_TEST(mtl_keeps_unlit_materials) {
    const fathom_texture texture = {.size = sizeof texture, .bytes = "\x89PNG\r\n", .byte_count = 6};
    const float color[3] = {0.25f, 0.5f, 0.75f};
    fathom_material m = default_material();
    fathom_scene *back;
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.specular_factor = 0, m.emissive_strength = 4;
    for (int c = 0; c < 3; ++c) m.base_color[c] = 0, m.emissive[c] = color[c];
    m.maps[FATHOM_MAP_COLOR] = m.maps[FATHOM_MAP_EMISSIVE] =
        (fathom_map){.texture = 0, .transform = {1, 0, 0, 0, 1, 0}};
    fathom_scene *scene = wearing(&m, &texture);
    const fathom_material *got = through_obj(scene, &back);
    assert_int_equal(got->model, FATHOM_MODEL_CLASSIC);
    assert_int_equal(got->specular, FATHOM_SPECULAR_NONE);
    for (int c = 0; c < 3; ++c)
        assert_true(got->k_d[c] == 0 && got->k_r[c] == 0 && got->k_t[c] == 0 && got->k_e[c] == 4 * color[c]);
    assert_int_equal(got->maps[FATHOM_MAP_COLOR].texture, FATHOM_NONE);
    assert_int_not_equal(got->maps[FATHOM_MAP_EMISSIVE].texture, FATHOM_NONE);
    unlink(in_folder("a-0.png"));
}

/* v grows upwards in OBJ, with and without images. The bitangent turns with it. */
UNIT_TEST(rotations_of_brushed_metal_turn_with_v) {
    const fathom_texture texture = {.size = sizeof texture, .bytes = "\x89PNG\r\n", .byte_count = 6};
    for (int image = 0; image < 2; ++image) {
        fathom_material m = default_material();
        fathom_scene *back;
        m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.anisotropy = 0.5f, m.anisotropy_rotation = 0.75f;
        if (image) m.maps[FATHOM_MAP_COLOR] = (fathom_map){.texture = 0, .transform = {1, 0, 0, 0, 1, 0}};
        fathom_scene *scene = wearing(&m, image ? &texture : NULL);
        const fathom_material *got = through_obj(scene, &back);
        /* Nine digits of a fraction of a turn: two roundings. */
        assert_near(got->anisotropy_rotation, -0.75, 2 * 0x1p-24);
    }
    unlink(in_folder("a-0.png"));
}

/* glTF's factor of emission is 0 by default, whatever the image. */
UNIT_TEST(images_of_no_effect_have_none_in_mtl) {
    const fathom_texture texture = {.size = sizeof texture, .bytes = "\x89PNG\r\n", .byte_count = 6};
    for (int model = 0; model < 2; ++model) {
        fathom_material m = default_material();
        fathom_scene *back;
        m.model = (fathom_model)model;
        m.maps[FATHOM_MAP_EMISSIVE] = (fathom_map){.texture = 0, .transform = {1, 0, 0, 0, 1, 0}};
        fathom_scene *scene = wearing(&m, &texture);
        const fathom_material *got = through_obj(scene, &back);
        for (int c = 0; c < 3; ++c) assert_true(got->k_e[c] == 0 && got->emissive[c] == 0);
        assert_int_equal(got->maps[FATHOM_MAP_EMISSIVE].texture, FATHOM_NONE);
        unlink(in_folder("a-0.png"));
    }
}

/* ---- renders ---- */

/* The bits of red, green and blue. */
static void check_same_render(fathom_scene *a, fathom_scene *b, const char *what) {
    fathom_film *films[2];
    fathom_settings settings;
    for (int i = 0; i < 2; ++i) {
        fathom_scene_settings(i ? b : a, &settings);
        settings.width = 40, settings.height = 30, settings.spp = 4, settings.target_error = 0;
        assert_ok(context, fathom_render(context, i ? b : a, &settings, NULL, NULL, NULL, &films[i]));
    }
    double sum = 0;
    for (const char *c = "RGB"; *c; ++c) {
        const char name[] = {*c, 0};
        const float *x = fathom_film_channel(films[0], name), *y = fathom_film_channel(films[1], name);
        for (int k = 0; k < 40 * 30; ++k) sum += (double)x[k];
        if (memcmp(x, y, sizeof(float) * 40 * 30) != 0) fail_msg("%s: channel %s differs", what, name);
    }
    assert_true(sum > 0);
    for (int i = 0; i < 2; ++i) fathom_film_destroy(films[i]);
}

static void add_lights(fathom_scene *scene) {
    for (int i = 0; i < 3; ++i) {
        static const double at[3][3] = {{1, 2, 3}, {0, 0, 0}, {-1, 1, 2}},
                            along[3][3] = {{0, -1, 0}, {-0.3, -1, -0.2}, {0.6, -0.5, -1.1}};
        fathom_light light = default_light();
        light.type = (fathom_light_type)i;
        memcpy(light.position, at[i], sizeof light.position);
        memcpy(light.direction, along[i], sizeof light.direction);
        light.intensity[0] = 3.3f, light.intensity[1] = 0.7f, light.intensity[2] = 1.1f + (float)i;
        light.inner_angle = 0.2f, light.outer_angle = 0.6f;
        assert_ok(context, fathom_scene_add_light(scene, &light, NULL));
    }
}

/* Two groups in three places, coloured vertices, both uv sets, unit normals and tangents, an image, lights, a
 * camera. */
static fathom_scene *rich_scene(bool parallel) {
    static const float second[6] = {0.1f, 0.2f, 0.9f, 0.3f, 0.4f, 1.7f},
                       colors[12] = {1, 0.5f, 0.2f, 0.9f, 0.3f, 1, 0.4f, 0.5f, 0.7f, 0.8f, 1, 1},
                       normals[9] = {0, 0.1f, 0.995f, 0.2f, 0, 0.98f, 0, -0.1f, 0.995f},
                       tangents[12] = {1, 0, 0, 1, 0.993f, 0.11f, 0, 1, 1, 0, 0, -1};
    static const char picture[] = "P6\n2 2\n255\n\xff\x20\x10\x40\xf0\x70\x20\x30\xe0\xb0\xa0\x90";
    const fathom_texture texture = {
        .size = sizeof texture, .bytes = picture, .byte_count = sizeof picture - 1};
    fathom_material m = default_material();
    fathom_id group;
    fathom_scene *scene = new_scene(context);
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.roughness = 0.3f, m.clearcoat = 0.4f, m.metallic = 0.2f;
    assert_ok(context, fathom_scene_add_texture(scene, &texture, &m.maps[FATHOM_MAP_COLOR].texture));
    m.maps[FATHOM_MAP_OPACITY] = m.maps[FATHOM_MAP_COLOR];
    m.maps[FATHOM_MAP_OPACITY].channel = 3;
    m.anisotropy = 0.6f;
    const fathom_id id = new_material(scene, "m", &m);
    for (int i = 0; i < 3; ++i) {
        fathom_mesh mesh = triangle(id);
        mesh.normals = normals, mesh.normal_count = 3, mesh.tangents = tangents;
        mesh.uvs_1 = second, mesh.colors = colors, mesh.color_channels = 4;
        fathom_instance instance = default_instance();
        if (i < 2) assert_ok(context, fathom_scene_add_group(scene, "same name", &group));
        if (i < 2) assert_ok(context, fathom_scene_add_mesh(scene, group, &mesh, NULL));
        instance.group = group;
        instance.transform[1] = 0.2, instance.transform[3] = i - 1.3, instance.transform[7] = 0.1 * i;
        assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
    }
    add_lights(scene);
    fathom_camera camera;
    fathom_camera_look_at((double[]){0.4, 0.6, 3}, (double[]){0.1, 0.4, 0}, (double[]){0, 1, 0}, 0.9,
                          &camera);
    camera.orthographic = parallel;
    assert_ok(context, fathom_scene_set_camera(scene, &camera));
    return scene;
}

/* Only normalised directions and axes are rebuilt, in double: the rays, which are float, stay. */
static void check_conversion(bool parallel) {
    fathom_scene *made = rich_scene(parallel), *glb;
    glb = written(made, "first.glb");
    for (int format = 0; format < FORMATS; ++format) {
        fathom_scene *source, *back;
        source = scene_of_file(context, in_folder("first.glb"));
        back = written(source, formats[format]);
        check_same_render(glb, back, formats[format]);
        unlink(in_folder("a-0"));
    }
    check_same_render(made, glb, "first.glb");
}

UNIT_TEST(renders_survive_conversion) {
    check_conversion(false);
    check_conversion(true);
}

UNIT_TEST(scene_json_survives_conversion) {
    static const char *const files[] = {"light/cornell-box.json", "light/moving-balls.json",
                                        "tour/08-spot-lights.json", "tour/20-camera.json",
                                        "tour/21-instances.json"};
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
        fathom_scene *scene, *back;
        scene = scene_of_file(context, unit_text("%s/scenes/%s", SOURCE_DIR, files[i]));
        back = written(scene, "a.json");
        check_same_render(scene, back, files[i]);
    }
}

/* Arrays can replace materials by material 0, which has no name, and give tangents without normals. */
UNIT_TEST(scenes_of_arrays_survive_conversion_to_json) {
    static const float tangents[12] = {0.6f, 0.8f, 0, 1, 0.6f, 0.8f, 0, 1, 0.6f, 0.8f, 0, -1};
    fathom_material usual = default_material();
    fathom_scene *scene = wearing(&usual, NULL);
    fathom_instance instance = default_instance();
    assert_ok(context, fathom_scene_add_group(scene, NULL, &instance.group));
    fathom_mesh flat = triangle(1);
    flat.tangents = tangents;
    assert_ok(context, fathom_scene_add_mesh(scene, instance.group, &flat, NULL));
    instance.material = 0;
    assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
    fathom_scene *back = through(scene, JSON);
    const fathom_mesh *mesh = &back->meshes.items[0];
    assert_null(mesh->normals);
    assert_non_null(mesh->tangents);
    assert_memory_equal(mesh->tangents, tangents, sizeof tangents);
    const fathom_id id = back->instances.items[0].material;
    assert_in_range(id, 1, back->materials.count - 1);
    assert_true(back->materials.items[id].value.model == FATHOM_MODEL_CLASSIC);
    assert_memory_equal(back->materials.items[id].value.k_d, usual.k_d, sizeof usual.k_d);
}

/* ---- vertex colours and images of mesh files ---- */

/* One of two meshes has colours and one has none; one of the colours is black, one above 1. PLY has opacities
 * and a second uv set too, and includes the k_d of the default material, 0.5, as it has no materials. OBJ has
 * two objects, PLY one mesh. */
UNIT_TEST(mesh_files_keep_vertex_colours) {
    static const float colors[12] = {0.001f, 0.5f, 0.2f, 1, 0, 0, 0, 1, 0.4f, 2.5f, 0.7f, 0.8f};
    static const char *const names[] = {"a.ply", "a.obj"};
    fathom_scene *scene = new_scene(context);
    for (int i = 0; i < 2; ++i) {
        fathom_mesh mesh = triangle(0);
        mesh.colors = i ? NULL : colors, mesh.color_channels = 4;
        mesh.uvs_1 = i ? NULL : positions, mesh.uv_1_stride = 3 * sizeof(float);
        assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
    }
    for (int format = 0; format < 2; ++format) {
        fathom_scene *back = written(scene, names[format]);
        assert_int_equal(back->meshes.count, format ? 2 : 1);
        for (uint32_t v = 0; v < 6; ++v) {
            const fathom_mesh *got = &back->meshes.items[format ? v / 3 : 0];
            assert_non_null(got->colors);
            assert_int_equal(got->vertex_count, format ? 3 : 6);
            assert_int_equal(got->color_channels, format ? 3 : 4);
            if (!format) assert_true(got->uvs_1 && *mesh_row(got->uvs_1, got->uv_1_stride, 1) == 1);
            const float *c = mesh_row(got->colors, got->color_stride, format ? v % 3 : v);
            /* OBJ: two roundings to float, about a curve whose slope is at most 2.4. */
            for (uint32_t k = 0; k < got->color_channels; ++k) {
                const float own = v < 3 ? fminf(colors[4 * v + k], format ? 1 : 4) : 1;
                assert_near(c[k], format || k == 3 ? own : 0.5f * own, format ? 4 * 0x1p-24 : 0);
            }
        }
    }
}

/* v grows upwards in OBJ and PLY, and downwards in the others: an image that is added later is upright. */
UNIT_TEST(v_grows_as_it_does_in_the_format) {
    static const char *const names[] = {"a.obj", "b.json", "c.ply",  "d.glb",
                                        "e.obj", "f.glb",  "g.json", "h.ply"};
    put_text(names[0], "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nf 1/1 2/1 3/1\n");
    for (int i = 0; i < 8; ++i) {
        fathom_scene *scene = scene_of_file(context, in_folder(names[i]));
        const bool upwards = strstr(names[i], ".obj") || strstr(names[i], ".ply");
        assert_true(scene->meshes.items[0].uvs[1] == (upwards ? 0.25f : 0.75f));
        if (i < 7) assert_ok(context, fathom_scene_write(scene, in_folder(names[i + 1])));
    }
}

/* Wherever it lies: turned, scaled and moved. The reader's v is one minus the file's. */
UNIT_TEST(ply_keeps_an_image_of_all_triangles) {
    static const char pixel[] = "P6\n1 1\n255\n\x80\x80\x80";
    const fathom_texture texture = {.size = sizeof texture, .bytes = pixel, .byte_count = sizeof pixel - 1};
    static const float turned[6] = {0.5f, 0.25f, 0.125f, -0.25f, 2, 0.75f};
    fathom_material m = default_material();
    m.maps[FATHOM_MAP_COLOR].texture = 0;
    memcpy(m.maps[FATHOM_MAP_COLOR].transform, turned, sizeof turned);
    fathom_scene *scene = wearing(&m, &texture);
    fathom_scene *back = written(scene, "a.ply");
    const fathom_mesh *mesh = &back->meshes.items[0];
    const fathom_map *map = &back->materials.items[mesh->material].value.maps[FATHOM_MAP_COLOR];
    assert_int_not_equal(map->texture, FATHOM_NONE);
    for (uint32_t i = 0; i < 3; ++i) {
        const float *t = map->transform, *in = uvs + 2 * i, *uv = mesh_row(mesh->uvs, mesh->uv_stride, i);
        for (int k = 0; k < 2; ++k) {
            const float *from = turned + 3 * k;
            assert_true(t[3 * k] * uv[0] + t[3 * k + 1] * uv[1] + t[3 * k + 2] ==
                        from[0] * in[0] + from[1] * in[1] + from[2]);
        }
    }
    /* Another material, and it is no longer that of all. */
    fathom_mesh other = triangle(0);
    assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &other, NULL));
    back = written(scene, "a.ply");
    assert_int_equal(back->textures.count, 0);
    unlink(in_folder("a-0")), unlink(in_folder("a-0.png"));
}

/* ---- what is left out ---- */

/* A colour image that is linear, not filtered, and whose alpha does not count. */
static void add_odd_image(fathom_scene *scene) {
    static const char pixel[] = "P6\n1 1\n255\n\x80\x80\x80";
    const fathom_texture texture = {.size = sizeof texture,
                                    .bytes = pixel,
                                    .byte_count = sizeof pixel - 1,
                                    .color_space = FATHOM_COLOR_LINEAR,
                                    .filter = FATHOM_TEXTURE_NEAREST};
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.opacity = 0.5f;
    assert_ok(context, fathom_scene_add_texture(scene, &texture, &m.maps[FATHOM_MAP_COLOR].texture));
    assert_ok(context, fathom_scene_add_material(scene, "odd", &m, NULL));
}

UNIT_TEST(what_a_format_lacks_is_told) {
    const struct {
        const char *name, *lacks;
    } cases[] = {
        {"a.ply", "the camera is left out"},
        {"a.ply", "a light is left out (3 such)"},
        {"a.ply", "a material is left out (2 such)"},
        {"a.obj", "a place of a group that is placed several times has triangles of its own (2 such)"},
        {"a.obj", "the second uv set of a mesh is left out (2 such)"},
        {"a.obj", "the opacity of a vertex is left out (4 such)"},
        {"a.ply", "an image on a surface is left out (2 such)"},
        {"a.obj", "the filter of an image is left out (2 such)"},
        {"a.glb", "the color space of an image is left out"},
        {"a.glb", "the alpha of a material's colour image, if it has one, counts as opacity (1 such)"},
        {"a.glb", "the background is left out (1 such)"}};
    const float grey[3] = {0.1f, 0.1f, 0.1f};
    fathom_scene *scene = rich_scene(false);
    add_odd_image(scene);
    assert_ok(context, fathom_scene_set_background(scene, grey));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        forget_warnings();
        assert_ok(context, fathom_scene_write(scene, in_folder(cases[i].name)));
        expect_warning(cases[i].lacks);
        unlink(in_folder("a-0")), unlink(in_folder("a-1"));
    }
    forget_warnings();
    assert_ok(context, fathom_scene_write(scene, in_folder("a.json")));
    assert_string_equal(strstr(warned, ": "), ": the name of a group is replaced: another has it (1 such)\n");
    unlink(in_folder("a-0")), unlink(in_folder("a-1"));
}

int main(void) { return unit_main(open_folder, remove_folder); }
