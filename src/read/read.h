/* The readers, one folder per format. Each reader adds the contents of a file to a scene.
 *
 * read.c      files by their extensions; completes scenes
 * gltf/ json/ obj/ ply/
 * mesh/       what formats share
 *   text        lines and words of text files, faults at a line, notes for warnings
 *   number      decimal numbers; scalar: binary ones
 *   polygon     triangulates; normals: smooth ones; weld: joins corners; strokes: points and lines
 *   lost        vertices without finite numbers; compact: unused vertices */
#pragma once

#include "scene/scene.h"

/* How to read a mesh file. */
typedef struct read_mesh_options {
    fathom_id material; /* material of all meshes of the file; FATHOM_NONE: the file's own */
    unsigned flags;     /* of every mesh: FATHOM_CASTS_NO_SHADOW… */
    bool flat;          /* ignore the file's normals and smoothing groups */
    bool smooth;        /* make smooth vertex normals where the file has none */
    bool surroundings;  /* also read the file's camera and lights; only if the group is the root */
    double unit; /* scale of the group's instance, applied to cameras, lights and volumes too; 0: none */
} read_mesh_options;

/* The path of a file that the file `base` names. `base` may come from Windows: backslashes separate folders,
 * and letter case is ignored. Release it with free(). FATHOM_BAD_INPUT when it is outside the allowed folder;
 * the caller adds the place to the message. */
fathom_status read_beside(fathom_scene *scene, const char *base, const char *name, char **out);

/* The same for an image or an MTL library. If `name` is not a file, tries the trailing components of
 * its path next to `base`, the longest first, because the path may come from another computer. FATHOM_OK with
 * *out NULL: no file was found. */
fathom_status read_image_beside(fathom_scene *scene, const char *base, const char *name, char **out);

/* True if read_image_beside() found no file because the one that `name` names is outside the allowed folder.
 */
bool read_is_outside(fathom_scene *scene, const char *base, const char *name);
#define READ_OUTSIDE "is outside the folder that may be read, and left out; --allow-outside reads it"

/* If the mesh has no texture coordinates, but its material has images, all its vertices get (0, 0), as in
 * Blender and WebGL. Otherwise each triangle would show half of the image. *bytes: the memory added; 0: the
 * mesh is unchanged, as points are always. */
fathom_status read_missing_uvs(fathom_scene *scene, fathom_mesh *mesh, uint64_t *bytes);
#define READ_MISSING_UVS                                                                                     \
    "a mesh has a material with images but no texture coordinates; it shows their colour at (0, 0)"

struct note_list; /* mesh/text.h */
/* Adds a mesh of an OBJ or PLY file. facts: of its vertices. */
fathom_status read_add_mesh(fathom_scene *scene, fathom_id group, const char *path, fathom_mesh *mesh,
                            mesh_facts facts, struct note_list *notes);

/* OBJ and PLY: scanning programs write the colours of an image again as colours of vertices. */
#define READ_COLORS_TWICE "colours of vertices are left out where an image has them"

/* Gives a material a plausible uniform value in place of an image of this kind of map that cannot be read. */
void read_without_image(int kind, fathom_material *m);

/* Adds a material for a file with vertex colours but no materials: its diffuse reflectance is 1, multiplied
 * by the colours. */
fathom_status read_colored_material(fathom_scene *scene, fathom_id *out);

/* How long the shutter stays open: as requested, or else as long as the scene's camera says. */
double read_shutter(const fathom_scene *scene);

/* The integrator that the scene is read for; `own`: the integrator that the file names. */
fathom_integrator read_integrator(const fathom_scene *scene, fathom_integrator own);

/* The origin of a mesh's float positions: zero, unless the vertices lie so far from the origin, compared with
 * their extent, that float would lose digits of the file.
 *
 * A float coordinate of size M has a rounding error of at most 2^-24 M. In the widest image, 65536 pixels, a
 * mesh with half-extent e has pixels of size e 2^-15. So up to M = 16 e the error is below 2^-20 e, 1/32 of a
 * pixel. Above that the origin moves to the centre, and M is then at most 1.5 e. The origin moves by a
 * multiple of a power of two not above e. Coordinates that were floats in the file then keep every bit,
 * because their differences from the origin are multiples of their own last bit and no larger than they. */
vec3_f64 origin_for(const scene_bounds *bounds);

/* Each call adds its meshes to `group`. The message of FATHOM_BAD_INPUT names the file, the line (text) or
 * byte offset (binary), and the field. After a failure the scene may hold a part of the file: only destroy
 * it. */
fathom_status read_obj(fathom_scene *scene, fathom_id group, const char *path,
                       const read_mesh_options *options);
fathom_status read_ply(fathom_scene *scene, fathom_id group, const char *path,
                       const read_mesh_options *options);
fathom_status read_gltf(fathom_scene *scene, fathom_id group, const char *path,
                        const read_mesh_options *options);

/* Reads scene JSON: adds its objects to the root, and sets camera, background, settings and name. */
fathom_status read_json(fathom_scene *scene, const char *path);

/* Reads any mesh file; the extension selects the format: .obj, .ply, .gltf, .glb. */
fathom_status read_mesh(fathom_scene *scene, fathom_id group, const char *path,
                        const read_mesh_options *options);

/* Removes unused vertices. In a file, many meshes may share one list of vertices: an OBJ file has one list
 * for all its materials. Code that loops over the vertices of each mesh, or writes them, would then process
 * the whole list for each mesh. So a mesh that uses at most half of its vertices gets copies of the used
 * ones, in the same order, in memory of the scene. So does a mesh with unused vertices outside the bounds of
 * the used ones, because bounds are those of all vertices. The same is done for normals and uvs with indices
 * of their own. Other meshes, points, meshes with keys and those with more than 12 corners per vertex are
 * unchanged. in_place: the mesh's indices may be overwritten; otherwise they are copied, too. facts: those
 * that mesh_look_at_vertices() sets. *copied: whether the mesh was changed; its facts are then others. All
 * indices must be in range. */
fathom_status mesh_compact(fathom_scene *scene, bool in_place, const mesh_facts *facts, fathom_mesh *mesh,
                           bool *copied);
