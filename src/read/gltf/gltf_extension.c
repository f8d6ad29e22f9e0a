/* Extensions: which are followed, and what is said of the others. */
#include "read/gltf/gltf.h"

#include <string.h>

/* Those that are followed; and those that only change how textures, which are not read, are stored. */
static const char *const known_extensions[] = {
    "KHR_lights_punctual",    "KHR_materials_ior",       "KHR_materials_transmission",
    "KHR_materials_specular", "KHR_materials_unlit",     "KHR_materials_emissive_strength",
    "KHR_mesh_quantization",  "EXT_mesh_gpu_instancing", "KHR_materials_pbrSpecularGlossiness",
    "KHR_node_visibility",    "KHR_texture_transform",   "KHR_texture_basisu",
    "EXT_texture_webp",       "EXT_texture_avif",
};

static bool is_known(const char *name) {
    for (size_t i = 0; i < sizeof known_extensions / sizeof *known_extensions; ++i) {
        if (strcmp(known_extensions[i], name) == 0) return true;
    }
    return false;
}

fathom_status gltf_check_extensions(gltf *g) {
    gltf_value required;
    fathom_status status = gltf_array(g, &g->root, "extensionsRequired", &required);
    for (size_t i = 0; i < gltf_count(&required) && status == FATHOM_OK; ++i) {
        const char *name = json_string_value(json_array_get(required.json, i));
        if (name && is_known(name)) continue;
        gltf_value at = {.parent = &required, .index = i};
        if (!name) return gltf_fail(g, &at, NULL, "is not a string; expected the name of an extension");
        status = gltf_fail(g, &at, NULL,
                           "the file cannot be read without the extension \"%.80s\", which is not supported; "
                           "export it without",
                           name);
    }
    return status;
}

static void note_of(gltf *g, const gltf_value *holder) {
    const char *name;
    json_t *value;
    json_object_foreach(holder->json, name, value) {
        if (!is_known(name)) gltf_note(g, holder->parent, NULL, "the extension %.80s is not followed", name);
    }
}

/* Looks through everything but what is no part of the format. The parser limits the depth. */
static void look_through(gltf *g, const gltf_value *v) {
    if (json_is_object(v->json)) {
        const char *key;
        json_t *value;
        json_object_foreach(v->json, key, value) {
            const gltf_value member = {.json = value, .parent = v, .key = key};
            if (strcmp(key, "extensions") == 0) note_of(g, &member);
            if (strcmp(key, "extras") != 0) look_through(g, &member);
        }
    }
    for (size_t i = 0; i < gltf_count(v); ++i) {
        const gltf_value item = {.json = json_array_get(v->json, i), .parent = v, .index = i};
        look_through(g, &item);
    }
}

void gltf_note_extensions(gltf *g) { look_through(g, &g->root); }
