/* fathom_scene_write_mesh(): which format, and what of the scene it can hold. */
#include "write/write.h"

#include <string.h>

static const struct {
    const char *extension;
    fathom_status (*write)(const fathom_scene *scene, const scene_graph *graph, const char *path);
} formats[] = {{"glb", write_glb}, {"ply", write_ply}, {"obj", write_obj}};

/* Mesh files know triangles; other shapes are left out, and said to be. */
static fathom_status check_shapes(const fathom_scene *scene, const scene_graph *graph, const char *path) {
    size_t placed[4] = {0};
    for (uint32_t k = 0; k < graph->order_count; ++k) {
        uint32_t g = graph->order[k];
        for (uint32_t i = graph->objects.first[g]; i < graph->objects.first[g + 1]; ++i)
            ++placed[scene->objects.items[graph->objects.items[i]].kind];
    }
    const struct {
        scene_kind kind;
        const char *name;
    } others[] = {{SCENE_SPHERE, "spheres"}, {SCENE_QUAD, "quads"}, {SCENE_PLANE, "planes"}};
    for (size_t i = 0; i < sizeof others / sizeof *others; ++i) {
        size_t count = placed[others[i].kind];
        if (count) {
            warn(scene->context, "%s: %s are not triangles and are left out (%zu of them)", path,
                 others[i].name, count);
        }
    }
    if (placed[SCENE_MESH]) return FATHOM_OK;
    return fail_file(scene->context, FATHOM_BAD_USAGE, path, "the scene holds no triangles to write");
}

fathom_status fathom_scene_write_mesh(const fathom_scene *scene, const char *path) {
    if (!scene) return FATHOM_BAD_USAGE;
    if (!path) return fail_null(scene->context, "path");
    char extension[16];
    file_extension(path, extension);
    size_t count = sizeof formats / sizeof *formats, format = 0;
    while (format < count && strcmp(formats[format].extension, extension) != 0) ++format;
    if (format == count) {
        return fail_file(scene->context, FATHOM_BAD_USAGE, path,
                         "meshes are written as .glb, .ply or .obj, found extension \"%s\"", extension);
    }
    scene_graph graph;
    fathom_status status = graph_create(scene, &graph);
    if (status != FATHOM_OK) return status;
    status = check_shapes(scene, &graph, path);
    if (status == FATHOM_OK) status = formats[format].write(scene, &graph, path);
    graph_destroy(&graph);
    return status;
}
