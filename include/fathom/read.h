/* Scenes from files, and heavy meshes from nothing. */
#ifndef FATHOM_READ_H
#define FATHOM_READ_H

#include <fathom/render.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Reads scene JSON, .glb, .gltf, .obj or .ply, told apart by the extension. The scene is completed with a
 * camera and lights where the file has none, and checked.
 * FATHOM_BAD_INPUT names the file with its line, field or byte offset. */
FATHOM_API fathom_status fathom_scene_read(fathom_context *context, const char *path, fathom_scene **out);

typedef enum fathom_generator {
    FATHOM_GENERATE_SPHERE,  /* a displaced sphere, closed, smooth normals */
    FATHOM_GENERATE_TERRAIN, /* a fractal height field over a square */
    FATHOM_GENERATE_SPONGE,  /* a Menger sponge of instanced cells */
    FATHOM_GENERATE_FOREST   /* a terrain with instanced trees */
} fathom_generator;

typedef struct fathom_generate_options {
    fathom_generator kind;
    uint64_t
        triangles; /* asked for; what comes is the nearest count the kind allows, counted with instances */
    uint64_t seed;
    fathom_id material;
} fathom_generate_options;

FATHOM_API void fathom_generate_options_default(fathom_generate_options *options);
/* Adds the generated geometry to a group, about 2 units across around the origin, y up. Same options, same
 * mesh, on any thread count. */
FATHOM_API fathom_status fathom_scene_generate(fathom_scene *scene, fathom_id group,
                                               const fathom_generate_options *options);
/* Writes all triangles of the scene, instances placed (.glb keeps them as nodes), to .glb, .ply (binary) or
 * .obj. */
FATHOM_API fathom_status fathom_scene_write_mesh(const fathom_scene *scene, const char *path);

#ifdef __cplusplus
}
#endif
#endif
