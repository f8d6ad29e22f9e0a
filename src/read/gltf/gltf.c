/* glTF 2.0 and GLB: the whole of it.
 *
 * What is read: the nodes of the default scene (else the first scene, else all root nodes; else every mesh
 * once), triangles of any mode, materials, one perspective camera, and the extensions of gltf_extension.c.
 * Skins, morph targets and animations are left in the rest pose, textures and vertex colours are not used,
 * both sides of a triangle are seen: each is noted. */
#include "read/gltf/gltf.h"

#include <stdlib.h>
#include <string.h>

/* "2.0" and any "2.x": a later minor version stays readable unless minVersion says otherwise. */
static fathom_status check_version(gltf *g) {
    gltf_value asset;
    const char *version = NULL, *least = NULL;
    fathom_status status = gltf_object(g, &g->root, "asset", &asset);
    if (status == FATHOM_OK) status = gltf_text(g, &asset, "version", &version);
    if (status == FATHOM_OK) status = gltf_text(g, &asset, "minVersion", &least);
    if (status != FATHOM_OK) return status;
    if (!version) return gltf_fail(g, &asset, "version", "is missing; expected a glTF file with \"2.0\"");
    if (strncmp(version, "2.", 2) != 0)
        return gltf_fail(g, &asset, "version", "is \"%.40s\"; expected \"2.0\"", version);
    if (least && strcmp(least, "2.0") != 0)
        return gltf_fail(g, &asset, "minVersion", "is \"%.40s\"; 2.0 is what is understood", least);
    return FATHOM_OK;
}

static fathom_status open_arrays(gltf *g) {
    const struct {
        const char *key;
        gltf_value *out;
    } arrays[] = {{"accessors", &g->accessors}, {"bufferViews", &g->views}, {"buffers", &g->buffers},
                  {"materials", &g->materials}, {"meshes", &g->meshes},     {"nodes", &g->nodes},
                  {"scenes", &g->scenes},       {"cameras", &g->cameras}};
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays && status == FATHOM_OK; ++i) {
        status = gltf_array(g, &g->root, arrays[i].key, arrays[i].out);
        if (gltf_count(arrays[i].out) >= GLTF_EMPTY)
            return gltf_fail(g, arrays[i].out, NULL, "has more than 2^32 - 3 entries");
    }
    if (status == FATHOM_OK)
        status = gltf_extension(g, &g->root, "KHR_lights_punctual", &g->extensions, &g->punctual);
    return status == FATHOM_OK ? gltf_array(g, &g->punctual, "lights", &g->lights) : status;
}

static fathom_status make_tables(gltf *g) {
    size_t buffers = gltf_count(&g->buffers), materials = gltf_count(&g->materials) + 1,
           meshes = gltf_count(&g->meshes), accessors = gltf_count(&g->accessors);
    g->buffer_table = calloc(buffers + 1, sizeof *g->buffer_table);
    g->material_table = calloc(materials, sizeof *g->material_table);
    g->mesh_table = calloc(meshes + 1, sizeof *g->mesh_table);
    g->array_table = calloc(accessors + 1, sizeof *g->array_table);
    if (!g->buffer_table || !g->material_table || !g->mesh_table || !g->array_table)
        return fail_memory(g->context, (buffers + materials + meshes + accessors) * sizeof *g->array_table);
    for (size_t i = 0; i < materials; ++i) g->material_table[i].id = FATHOM_NONE;
    for (size_t i = 0; i < meshes; ++i) g->mesh_table[i] = FATHOM_NONE;
    return FATHOM_OK;
}

static void note_animations(gltf *g) {
    const gltf_value animations = gltf_member(&g->root, "animations");
    for (size_t i = 0; i < gltf_count(&animations); ++i) {
        const gltf_value at = {.parent = &animations, .index = i};
        gltf_note(g, &at, NULL, "animations are not followed; everything rests where its node is");
    }
}

static fathom_status close_source(gltf *g, gltf_source *source, fathom_status status) {
    if (!source || source->shared) return status;
    status = file_finish(g->context, &source->map, status);
    free(source);
    return status;
}

/* Sources that the scene took over stay open. */
static fathom_status finish(gltf *g, fathom_status status) {
    for (size_t i = 0; g->buffer_table && i < gltf_count(&g->buffers); ++i) {
        const gltf_buffer *buffer = &g->buffer_table[i];
        if (buffer->owns_source) status = close_source(g, buffer->source, status);
    }
    status = close_source(g, g->source, status);
    free(g->buffer_table);
    free(g->material_table);
    free(g->mesh_table);
    free(g->array_table);
    array_free(&g->seen_cameras);
    json_arena_release(&g->arena);
    return status;
}

fathom_status read_gltf(fathom_scene *scene, fathom_id group, const char *path,
                        const read_mesh_options *options) {
    gltf g = {.scene = scene, .context = scene->context, .group = group, .path = path, .options = options};
    fathom_status status = gltf_open(&g);
    if (status == FATHOM_OK) status = check_version(&g);
    if (status == FATHOM_OK) status = gltf_check_extensions(&g);
    if (status == FATHOM_OK) status = open_arrays(&g);
    if (status == FATHOM_OK) status = make_tables(&g);
    if (status == FATHOM_OK) status = gltf_nodes_place(&g);
    if (status == FATHOM_OK && options->surroundings) status = gltf_camera_take(&g);
    if (status == FATHOM_OK) {
        note_animations(&g);
        gltf_note_extensions(&g);
        gltf_note_images(&g);
        notes_tell(&g.notes, g.context, path);
    }
    return finish(&g, status);
}
