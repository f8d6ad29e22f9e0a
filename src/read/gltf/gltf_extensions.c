/* Which extensions are supported, and what the image shows in place of the others. */
#include "read/gltf/gltf.h"

#include "base/text.h"

#include <string.h>

static bool is_in(const char *words, const char *name) { return words_find(words, name, strlen(name)) >= 0; }

static bool is_supported(const char *name) {
    return is_in("KHR_lights_punctual|KHR_materials_ior|KHR_materials_transmission|KHR_materials_specular|"
                 "KHR_materials_unlit|KHR_materials_emissive_strength|KHR_materials_volume|"
                 "KHR_materials_clearcoat|KHR_materials_sheen|KHR_materials_anisotropy|"
                 "KHR_materials_iridescence|KHR_materials_dispersion|KHR_materials_diffuse_transmission|"
                 "KHR_materials_variants|KHR_materials_pbrSpecularGlossiness|KHR_mesh_quantization|"
                 "KHR_meshopt_compression|EXT_meshopt_compression|KHR_draco_mesh_compression|"
                 "EXT_mesh_gpu_instancing|KHR_node_visibility|KHR_animation_pointer|KHR_texture_transform|"
                 "KHR_texture_basisu|EXT_texture_webp|EXT_texture_avif|MSFT_texture_dds",
                 name);
}

/* Metadata, sound, physics, what a user does with the model, and data that a file has twice: an image is
 * right without them. The finest level of detail is shown. */
static bool is_invisible(const char *name) {
    return is_in("KHR_xmp|KHR_xmp_json_ld|KHR_node_selectability|KHR_node_hoverability|KHR_interactivity|"
                 "KHR_audio_emitter|KHR_audio_graph|KHR_physics_rigid_bodies|KHR_collision_shapes|"
                 "KHR_implicit_shapes|EXT_mesh_features|EXT_instance_features|EXT_structural_metadata|"
                 "EXT_feature_metadata|EXT_mesh_manifold|EXT_mesh_primitive_restart|FB_geometry_metadata|"
                 "FB_ngon_encoding|AGI_articulations|AGI_stk_metadata|GODOT_single_root|GRIFFEL_bim_data|"
                 "MPEG_audio_spatial|MPEG_viewport_recommended|MSFT_lod|"
                 "MSFT_packing_normalRoughnessMetallic|MSFT_packing_occlusionRoughnessMetallic|VRMC_vrm|"
                 "VRMC_springBone",
                 name);
}

static bool is_known(const char *name) { return is_supported(name) || is_invisible(name); }

/* Names the substitute that the image shows for an extension; NULL: unknown. */
static const char *find_instead(const char *name) {
    static const struct {
        const char *names, *instead;
    } table[] = {
        {"KHR_gaussian_splatting", "splats are shown as points"},
        {"KHR_materials_volume_scatter|KHR_materials_subsurface|KHR_materials_sss",
         "volumes absorb light, but do not scatter it"},
        {"KHR_texture_procedurals|EXT_texture_procedurals_mx_1_39", "procedural textures are left out"},
        {"KHR_texture_video|MPEG_texture_video", "a texture shows its own image, not the video"},
        {"EXT_lights_image_based|KHR_lights_environment",
         "the file's surroundings do not light the scene; --environment takes an image that does"},
        {"EXT_lights_ies", "lights with an IES profile are left out"},
        {"CESIUM_primitive_outline|EXT_mesh_primitive_edge_visibility", "outlines are not drawn"},
        {"ADOBE_materials_clearcoat_specular|ADOBE_materials_clearcoat_tint",
         "clearcoats are clear and have an index of refraction of 1.5"},
        {"ADOBE_materials_thin_transparency|NV_materials_mdl|VRM|VRMC_materials_mtoon",
         "materials have glTF's own parameters alone"},
        {"VRMC_node_constraint", "nodes stand where the file has them"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; ++i)
        if (is_in(table[i].names, name)) return table[i].instead;
    return NULL;
}

void gltf_extensions_check(gltf *g) {
    gltf_value required;
    gltf_array(g, &g->root, "extensionsRequired", &required);
    for (size_t i = 0; i < gltf_count(&required); ++i) {
        const gltf_value at = gltf_entry(&required, i);
        const char *name = json_string_value(at.json);
        if (!name) gltf_fail(g, &at, NULL, "is not a string; expected the name of an extension");
        if (name && !is_known(name))
            gltf_fail(g, &at, NULL,
                      "the file cannot be read without the extension \"%.80s\", which is not supported; "
                      "export it without",
                      name);
    }
}

bool gltf_requires(const gltf *g, const char *name) {
    const json_t *required = json_object_get(g->root.json, "extensionsRequired");
    for (size_t i = 0; i < json_array_size(required); ++i) {
        const char *item = json_string_value(json_array_get(required, i));
        if (item && strcmp(item, name) == 0) return true;
    }
    return false;
}

static void note_of(gltf *g, const gltf_value *v, json_t *extensions) {
    const char *name;
    json_t *value;
    json_object_foreach(extensions, name, value) {
        const char *instead = find_instead(name);
        if (!is_known(name))
            gltf_note(g, v, NULL, "the extension %.80s is ignored%s%s", name, instead ? ": " : "",
                      instead ? instead : "");
    }
}

void gltf_extensions_note(gltf *g, const gltf_value *v) {
    if (json_is_object(v->json)) {
        const char *key;
        json_t *value;
        json_object_foreach(v->json, key, value) {
            const gltf_value member = {value, {gltf_steps(v), key, 0}};
            if (strcmp(key, "extensions") == 0) note_of(g, v, value);
            if (json_is_null(value))
                gltf_note(g, &member, NULL, "null, which is against the format, is taken as nothing");
            if (strcmp(key, "extras") != 0) gltf_extensions_note(g, &member);
        }
    }
    for (size_t i = 0; i < gltf_count(v); ++i) {
        const gltf_value item = gltf_entry(v, i);
        gltf_extensions_note(g, &item);
    }
}
