/* KHR_animation_pointer: a value that an animation gives is read as if the document had it. */
#include "read/gltf/gltf.h"
#include "read/gltf/gltf_keys.h"

#include "gltf_build.h"

#include <math.h>

/* A triangle in front of a camera and a light, and one channel. */
static void write_pointer(build *b, const char *pointer, const char *way, int input, int output,
                          const char *materials) {
    const int positions = PUT_FLOATS(b, "VEC3", 3, 0, 0, 0, 1, 0, 0, 0, 1, 0),
              uvs = PUT_FLOATS(b, "VEC2", 3, 0, 0, 1, 0, 0, 1);
    build_write(
        b,
        "'meshes':[{'primitives':[{'attributes':{'POSITION':%d,'TEXCOORD_0':%d},'material':0}]}],'materials':"
        "[%s],'textures':[{'source':0}],'images':[{'uri':'data:image/png;base64,"
        "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=='}],"
        "'nodes':[{'mesh':0,'extensions':{'KHR_node_visibility':{}}},{'mesh':0},{'camera':0,'extensions':{"
        "'KHR_lights_punctual':{'light':0}}}],'cameras':[{'type':'perspective','perspective':{'yfov':1}}],"
        "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'spot','spot':{}}]}},'animations':[{'name':"
        "'go','samplers':[{'input':%d,'output':%d,'interpolation':'%s'}],'channels':[{'sampler':0,'target':{"
        "'path':'pointer','extensions':{'KHR_animation_pointer':{'pointer':'%s'}}}}]}]",
        positions, uvs, materials, input, output, way, pointer);
}

/* The value is `middle` at 2 s, halfway between its keys. */
static fathom_scene *read_animated(const char *pointer, unsigned count, double middle,
                                   const char *materials) {
    static const char *const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    build b = {.size = 0};
    float values[8];
    for (unsigned i = 0; i < 2 * count; ++i) values[i] = (float)(i < count ? middle / 2 : 1.5 * middle);
    const int times = PUT_FLOATS(&b, "SCALAR", 2, 1, 3),
              output = put_typed(&b, 5126, types[count - 1], 2, values, 2 * count * sizeof *values, "");
    write_pointer(&b, pointer, "LINEAR", times, output, materials);
    fathom_scene *scene = read_at(2);
    if (warning_count) fail_msg("%s: %s", pointer, warned);
    return scene;
}

static const fathom_material *first_material(const fathom_scene *scene) {
    return &scene->materials.items[scene->meshes.items[0].material].value;
}

/* "KHR_materials_sheen":{} of each extension. */
#define EMPTY_EXTENSIONS                                                                                     \
    "'KHR_materials_ior':{},'KHR_materials_specular':{},'KHR_materials_transmission':{},"                    \
    "'KHR_materials_volume':{},'KHR_materials_clearcoat':{},'KHR_materials_sheen':{},"                       \
    "'KHR_materials_anisotropy':{},'KHR_materials_iridescence':{},'KHR_materials_dispersion':{},"            \
    "'KHR_materials_diffuse_transmission':{},'KHR_materials_emissive_strength':{}"

UNIT_TEST(every_number_of_a_material_follows_its_pointer) {
    for (size_t i = 0; i < gltf_key_count; ++i) {
        const gltf_key *key = &gltf_keys[i];
        if (!key->count || key->of == GLTF_GLOSSINESS) continue;
        const double expected = key->high > 2 && key->low >= 0 ? 1.25 : 0.25;
        const bool core = key->of == GLTF_CORE, extension = !core && key->of != GLTF_PBR;
        const char *pointer = unit_text("/materials/0/%s%s%s%s", extension ? "extensions/" : "",
                                        core ? "" : gltf_holder_names[key->of], core ? "" : "/", key->name);
        fathom_scene *scene = read_animated(
            pointer, key->count, expected,
            "{'pbrMetallicRoughness':{},'doubleSided':true,'extensions':{" EMPTY_EXTENSIONS "}}");
        const float *found = (const float *)(const void *)((const char *)first_material(scene) + key->offset);
        for (unsigned c = 0; c < key->count; ++c) {
            if (!(fabs((double)found[c] - expected) < 1e-6)) fail_msg("%s: %g", pointer, (double)found[c]);
        }
    }
}

UNIT_TEST(colours_with_alpha_and_cutoffs_follow_their_pointer) {
    static const char masked[] = "{'alphaMode':'MASK','pbrMetallicRoughness':{'baseColorFactor':[1,1,1,1]}}";
    fathom_scene *scene = read_animated("/materials/0/pbrMetallicRoughness/baseColorFactor", 4, 0.25, masked);
    for (int c = 0; c < 3; ++c) assert_near((double)first_material(scene)->base_color[c], 0.25, 1e-7);
    assert_near((double)first_material(scene)->opacity, 0.25, 1e-7);
    scene = read_animated("/materials/0/alphaCutoff", 1, 0.25, masked);
    assert_near((double)first_material(scene)->opacity_cutoff, 0.25, 1e-7);
}

/* offset · rotation · scale: the first row is cos·sx, sin·sy, ox. */
UNIT_TEST(places_of_textures_follow_their_pointer) {
    static const char textured[] =
        "{'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':{'KHR_texture_transform':{}}}}}";
    static const struct {
        const char *name;
        unsigned count;
        double row[3];
    } parts[] = {{"offset", 2, {1, 0, 0.25}},
                 {"rotation", 1, {0.96891242171064478, 0.24740395925452293, 0}},
                 {"scale", 2, {0.25, 0, 0}}};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i) {
        fathom_scene *scene = read_animated(
            unit_text(
                "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/%s",
                parts[i].name),
            parts[i].count, 0.25, textured);
        const float *row = first_material(scene)->maps[FATHOM_MAP_COLOR].transform;
        for (int c = 0; c < 3; ++c) assert_near((double)row[c], parts[i].row[c], 1e-7);
    }
}

UNIT_TEST(cameras_and_lights_follow_their_pointer) {
    fathom_scene *scene = read_animated("/cameras/0/perspective/yfov", 1, 0.5, "{}");
    assert_near(scene->camera.h, 2 * tan(0.25), 1e-7);
    scene = read_animated("/extensions/KHR_lights_punctual/lights/0/color", 3, 0.5, "{}");
    for (int c = 0; c < 3; ++c)
        assert_near((double)scene->lights.items[0].intensity[c], 0.5 / 3.14159265358979324, 1e-7);
    scene = read_animated("/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle", 1, 0.5, "{}");
    assert_near((double)scene->lights.items[0].outer_angle, 0.5, 1e-7);
}

/* Two nodes have a mesh; the first is hidden from 1 s to 2 s. */
UNIT_TEST(nodes_are_seen_while_their_visibility_says_so) {
    const double at[][2] = {{0.5, 2}, {1, 1}, {1.5, 1}, {2, 2}};
    build b = {.size = 0};
    const int times = PUT_FLOATS(&b, "SCALAR", 3, 0, 1, 2), output = PUT_BYTES(&b, "SCALAR", 3, 1, 0, 1);
    write_pointer(&b, "/nodes/0/extensions/KHR_node_visibility/visible", "STEP", times, output, "{}");
    for (size_t i = 0; i < sizeof at / sizeof *at; ++i) {
        fathom_scene *scene = read_at(at[i][0]);
        assert_int_equal(scene->instances.count, (int)at[i][1]);
    }
}

/* Values that nothing reads, that the file has not, that have too few numbers, and that change while the
 * shutter is open. */
UNIT_TEST(pointers_that_are_not_followed_are_told_by_name) {
    static const struct {
        const char *pointer, *told;
    } cases[] = {
        {"/materials/0/occlusionTexture/index", "\"/materials/*/occlusionTexture/index\" is ignored"},
        {"/materials/7/alphaCutoff", "\"/materials/*/alphaCutoff\" is ignored"},
        {"/materials/0/emissiveFactor",
         "\"/materials/*/emissiveFactor\" is ignored: expected 3 numbers a key"},
        {"/nodes/9/translation", "\"/nodes/*/translation\" is ignored"},
        {"/cameras/0/perspective/yfov", "\"/cameras/*/perspective/yfov\" is not blurred"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        build b = {.size = 0};
        fathom_read_options asked = default_read_options();
        const int times = PUT_FLOATS(&b, "SCALAR", 2, 0, 1), values = PUT_FLOATS(&b, "SCALAR", 2, 0.5, 1);
        write_pointer(&b, cases[i].pointer, "LINEAR", times, values, "{}");
        asked.choose_time = true, asked.shutter = 0.5;
        forget_warnings();
        fathom_scene *scene = read_as(&asked);
        expect_warning(cases[i].told);
        /* It has its value of the middle: 0.625 radians. */
        if (strstr(cases[i].told, "blurred")) assert_near(scene->camera.h, 2 * tan(0.3125), 1e-7);
    }
}

/* Two animations of one value: the first counts, and the other is told. */
UNIT_TEST(only_the_first_animation_of_a_value_is_played) {
    build b = {.size = 0};
    const int positions = PUT_FLOATS(&b, "VEC3", 3, 0, 0, 0, 1, 0, 0, 0, 1, 0),
              time = PUT_FLOATS(&b, "SCALAR", 1, 0), first = PUT_FLOATS(&b, "SCALAR", 1, 0.25),
              second = PUT_FLOATS(&b, "SCALAR", 1, 0.75);
#define ROUGHNESS                                                                                            \
    "{'samplers':[{'input':%d,'output':%d}],'channels':[{'sampler':0,'target':{'path':'pointer',"            \
    "'extensions':{'KHR_animation_pointer':{'pointer':"                                                      \
    "'/materials/0/pbrMetallicRoughness/roughnessFactor'}}}}]}"
    build_write(&b,
                "'meshes':[{'primitives':[{'attributes':{'POSITION':%d},'material':0}]}],'nodes':[{'mesh':0}]"
                ",'materials':[{'pbrMetallicRoughness':{}}],'animations':[" ROUGHNESS "," ROUGHNESS "]",
                positions, time, first, time, second);
    fathom_scene *scene = read_at(0);
    assert_near((double)first_material(scene)->roughness, 0.25, 1e-7);
    assert_int_equal(warning_count, 1);
    expect_warning("an animation that moves what an earlier one moves is left out");
}

int main(void) { return unit_main(open_folder, remove_folder); }
