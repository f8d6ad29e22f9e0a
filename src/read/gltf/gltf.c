/* glTF 2.0 and GLB.
 *
 * Reads the nodes of the default scene (else the first scene, else all root nodes, else every mesh once),
 * triangles of any mode, materials with their textures and vertex colours, skins, morph targets, animations
 * posed at the requested time or while the shutter is open, one camera, and the extensions that
 * gltf_extensions.c lists. Triangles
 * are visible from both sides; for single-sided materials this adds a note. */
#include "read/gltf/gltf_data.h"
#include "read/gltf/gltf_material.h"
#include "read/gltf/gltf_mesh.h"
#include "read/gltf/gltf_pose.h"
#include "read/gltf/gltf_tree.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* True for glTF 1, which has objects instead of arrays. Its version may be "1.0", 1, 0.8 or missing. */
static bool is_first(const gltf *g, const gltf_value *asset) {
    const json_t *version = json_object_get(asset->json, "version");
    if (json_is_string(version)) return strncmp(json_string_value(version), "1.", 2) == 0;
    if (json_is_number(version)) return json_number_value(version) < 2;
    return json_is_object(json_object_get(g->root.json, "meshes"));
}

unsigned gltf_blender(gltf *g) {
    static const char exporter[] = "Khronos glTF Blender I/O v";
    const char *generator = "";
    unsigned major = 0, minor = 0;
    gltf_value asset;
    gltf_object(g, &g->root, "asset", &asset);
    gltf_text(g, &asset, "generator", &generator);
    if (strncmp(generator, exporter, sizeof exporter - 1) != 0) return 0;
    if (sscanf(generator + sizeof exporter - 1, "%3u.%3u", &major, &minor) != 2) return 0;
    return 1000 * major + minor;
}

/* "2.0" and any "2.x": a later minor version is readable, unless minVersion is above 2.0. */
static void check_version(gltf *g) {
    gltf_value asset;
    const char *version = NULL, *least = NULL;
    gltf_object(g, &g->root, "asset", &asset);
    if (is_first(g, &asset)) {
        gltf_fail(g, &asset, "version",
                  "the file is glTF 1.0, which is not read; expected glTF 2.0: export the model again, or "
                  "convert it, for instance by gltf-pipeline");
        return;
    }
    gltf_text(g, &asset, "version", &version);
    gltf_text(g, &asset, "minVersion", &least);
    if (!version)
        gltf_fail(g, &asset, "version", "is missing; expected a glTF file with \"2.0\"");
    else if (strncmp(version, "2.", 2) != 0)
        gltf_fail(g, &asset, "version", "is \"%.40s\"; expected \"2.0\"", version);
    else if (least && strcmp(least, "2.0") != 0)
        gltf_fail(g, &asset, "minVersion", "is \"%.40s\"; this Fathom reads 2.0", least);
}

static void open_arrays(gltf *g) {
    const struct {
        const char *key;
        gltf_value *out;
    } arrays[] = {{"accessors", &g->accessors},  {"bufferViews", &g->views}, {"buffers", &g->buffers},
                  {"materials", &g->materials},  {"meshes", &g->meshes},     {"nodes", &g->nodes},
                  {"scenes", &g->scenes},        {"cameras", &g->cameras},   {"images", &g->images},
                  {"textures", &g->textures},    {"samplers", &g->samplers}, {"skins", &g->skins},
                  {"animations", &g->animations}};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; ++i) {
        gltf_array(g, &g->root, arrays[i].key, arrays[i].out);
        if (gltf_count(arrays[i].out) >= GLTF_EMPTY)
            gltf_fail(g, arrays[i].out, NULL, "has more than 2^32 - 3 entries");
    }
    gltf_extension(g, &g->root, "KHR_lights_punctual", &g->extensions, &g->punctual);
    gltf_array(g, &g->punctual, "lights", &g->lights);
}

static void make_tables(gltf *g) {
    size_t buffers = gltf_count(&g->buffers), materials = gltf_count(&g->materials) + 1,
           accessors = gltf_count(&g->accessors);
    g->buffer_table = calloc(buffers + 1, sizeof *g->buffer_table);
    g->view_table = calloc(gltf_count(&g->views) + 1, sizeof *g->view_table);
    g->image_table = calloc(gltf_count(&g->images) + 1, sizeof *g->image_table);
    g->material_table = calloc(materials, sizeof *g->material_table);
    g->array_table = calloc(accessors + 1, sizeof *g->array_table);
    if (!g->buffer_table || !g->image_table || !g->material_table || !g->array_table || !g->view_table) {
        gltf_fail_memory(g, (buffers + materials + accessors) * sizeof *g->array_table);
        return;
    }
    for (size_t i = 0; i < materials; ++i) g->material_table[i].id = FATHOM_NONE;
}

static void close_source(gltf *g, gltf_source *source) {
    if (!source || source->shared) return;
    g->status = file_finish(g->context, &source->map, g->status);
    free(source);
}

/* Closes the sources that the scene does not own. */
static void finish(gltf *g) {
    for (size_t i = 0; g->buffer_table && i < gltf_count(&g->buffers); ++i) {
        if (g->buffer_table[i].owns_source) close_source(g, g->buffer_table[i].source);
    }
    close_source(g, g->source);
    gltf_draco_close(g);
    gltf_posed_close(g);
    gltf_moments_close(g);
    array_free(&g->moments);
    array_free(&g->playing);
    free(g->view_table);
    array_free(&g->links);
    free(g->told);
    free(g->buffer_table);
    free(g->image_table);
    free(g->material_table);
    free(g->array_table);
    array_free(&g->seen_cameras);
    json_arena_release(&g->arena);
}

fathom_status read_gltf(fathom_scene *scene, fathom_id group, const char *path,
                        const read_mesh_options *options) {
    gltf g = {.scene = scene, .context = scene->context, .group = group, .path = path, .options = options};
    gltf_open(&g);
    if (gltf_fine(&g)) check_version(&g);
    gltf_extensions_check(&g);
    open_arrays(&g);
    if (gltf_fine(&g)) make_tables(&g);
    if (gltf_fine(&g)) gltf_variant_choose(&g);
    if (gltf_fine(&g)) gltf_nodes_place(&g);
    if (gltf_fine(&g) && options->surroundings) gltf_camera_take(&g);
    if (gltf_fine(&g)) {
        gltf_extensions_note(&g, &g.root);
        notes_tell(&g.notes, g.context, path);
    }
    finish(&g);
    return g.status;
}
