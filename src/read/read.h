/* The readers, a folder for each format. Each adds the contents of a file to a scene. */
#ifndef READ_READ_H
#define READ_READ_H

#include "scene/scene.h"

/* How a mesh file is to be read. */
typedef struct read_mesh_options {
    fathom_id material; /* for everything in the file; FATHOM_NONE: the file's own */
    unsigned flags;     /* of every mesh: FATHOM_CASTS_NO_SHADOW… */
    bool flat;          /* ignore the file's normals and smoothing groups */
    bool smooth;        /* make smooth vertex normals where the file has none */
    bool surroundings;  /* take the file's camera and lights too; only into the root */
    double unit;        /* scale of the group's instance, which cameras and lights follow; 0: none */
} read_mesh_options;

/* The path of a file that the file `base` names. `base` may come from Windows: backslashes separate folders,
 * and case does not count. Release it with free(). FATHOM_BAD_INPUT when it is outside the allowed folder;
 * the caller adds the place to the message. */
fathom_status read_beside(fathom_scene *scene, const char *base, const char *name, char **out);

/* The same for an image. If `name` is no readable file, tries its trailing path components next to `base`,
 * the longest first, because a path may come from another computer. FATHOM_OK with *out NULL: no such file.
 */
fathom_status read_image_beside(fathom_scene *scene, const char *base, const char *name, char **out);

/* The curve of sRGB, for a number in [0,1] of a vertex colour: files hold what screens show. */
static inline float read_linear(double srgb) {
    return (float)(srgb <= 0.04045 ? srgb / 12.92 : pow((srgb + 0.055) / 1.055, 2.4));
}

/* A material for a file that has colours and no materials: its diffuse reflectance is 1, times the colours.
 */
fathom_status read_colored_material(fathom_scene *scene, fathom_id *out);

/* The integrator that the scene is read for; `own`: the file's. */
fathom_integrator read_integrator(const fathom_scene *scene, fathom_integrator own);

/* The origin of a mesh's float positions: zero, unless the vertices lie so far out for their extent that
 * float would lose digits that the file has.
 *
 * A float coordinate of size M is rounded by up to 2^-24 M. The widest image, 65536 pixels, of a mesh with
 * half-extent e has pixels of e 2^-15, so up to M = 16 e the error stays below 2^-20 e, a thirty-second of
 * its pixels. Beyond that the origin moves to the centre, and M becomes at most 1.5 e again.
 * It moves by a multiple of a power of two not above e: coordinates that were floats in the file then keep
 * every bit, since their differences from it are multiples of their own last bit and no larger than they. */
vec3_f64 origin_for(const scene_bounds *bounds);

/* Each adds its meshes to `group`. FATHOM_BAD_INPUT names the file with its line (text) or byte offset
 * (binary) and the field. After a failure the scene may hold a part of the file and can only be destroyed. */
fathom_status read_obj(fathom_scene *scene, fathom_id group, const char *path,
                       const read_mesh_options *options);
fathom_status read_ply(fathom_scene *scene, fathom_id group, const char *path,
                       const read_mesh_options *options);
fathom_status read_gltf(fathom_scene *scene, fathom_id group, const char *path,
                        const read_mesh_options *options);

/* Scene JSON: adds to the root, and sets camera, background, settings and name. */
fathom_status read_json(fathom_scene *scene, const char *path);

/* Any mesh file, by its extension: .obj, .ply, .gltf, .glb. */
fathom_status read_mesh(fathom_scene *scene, fathom_id group, const char *path,
                        const read_mesh_options *options);

#endif
