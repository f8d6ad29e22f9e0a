/* The readers: one file a format. Each adds what a file holds to a scene. */
#ifndef READ_READ_H
#define READ_READ_H

#include "scene/scene.h"

/* What the one who asks for a mesh file wants of it. */
typedef struct read_mesh_options {
    fathom_id material; /* for everything in the file; FATHOM_NONE: the file's own */
    unsigned flags;     /* of every mesh: FATHOM_CASTS_NO_SHADOW… */
    bool flat;          /* normals and smoothing groups of the file are ignored */
    bool smooth;        /* smooth vertex normals are made where the file has none */
    bool surroundings;  /* the file's camera and lights are taken too; into the root alone */
} read_mesh_options;

/* The path of a file that the file `base` names, to be released with free(). FATHOM_BAD_INPUT when it is not
 * in the folder it has to be in; the message has no place yet. */
fathom_status read_beside(fathom_scene *scene, const char *base, const char *name, char **out);

/* Each adds its meshes to `group`. FATHOM_BAD_INPUT names the file with its line (text) or byte offset
 * (binary) and the field. After a failure the scene may hold a part of the file and is good for nothing but
 * to be destroyed. */
fathom_status read_obj(fathom_scene *scene, fathom_id group, const char *path,
                       const read_mesh_options *options);
fathom_status read_ply(fathom_scene *scene, fathom_id group, const char *path,
                       const read_mesh_options *options);
fathom_status read_gltf(fathom_scene *scene, fathom_id group, const char *path,
                        const read_mesh_options *options);

/* Scene JSON; adds to the root and sets camera, background, settings and name as the file says. */
fathom_status read_json(fathom_scene *scene, const char *path);

/* Any mesh file, told apart by the extension: .obj, .ply, .gltf, .glb. */
fathom_status read_mesh(fathom_scene *scene, fathom_id group, const char *path,
                        const read_mesh_options *options);

#endif
