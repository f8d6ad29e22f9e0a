/* Shared by the writers of mesh files. */
#ifndef READ_WRITE_H
#define READ_WRITE_H

#include "base/file.h"
#include "read/mesh/text.h"
#include "scene/graph.h"
#include "scene/mesh/mesh_array.h"

#include <fathom/parameter.h>

#include <locale.h>

/* The binary formats are little-endian, as is every machine that Embree runs on. */
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "arrays are written as they lie in memory");

/* Each writes the whole file or none, and notes what it cannot hold. The graph is the scene's. */
fathom_status write_glb(const fathom_scene *scene, const scene_graph *graph, const char *path,
                        note_list *notes);
fathom_status write_ply(const fathom_scene *scene, const scene_graph *graph, const char *path,
                        note_list *notes);
/* The one image that a PLY file can have: the colour of all triangles. NULL: they have none in common, or one
 * that PLY has no place for. */
const fathom_map *write_ply_image(const fathom_scene *scene, const scene_graph *graph);
/* Points that PLY has no place for; ways: as write_count_ways() has them. */
size_t write_ply_lost_points(const fathom_scene *scene, const size_t *ways);
fathom_status write_obj(const fathom_scene *scene, const scene_graph *graph, const char *path,
                        note_list *notes);
fathom_status write_json(const fathom_scene *scene, const scene_graph *graph, const char *path,
                         note_list *notes);

/* ---- meshes with one number for each vertex ---- */

/* A fathom_mesh for formats with one index for position, normal and uv. Vertex i has position positions[i] of
 * the mesh, and so on; NULL means position i. `facets`: every corner is a vertex of its own with the facet's
 * normal. */
typedef struct write_mesh {
    const fathom_mesh *mesh; /* NULL: not prepared */
    uint32_t vertex_count;
    uint32_t *positions, *normals, *uvs, *indices; /* owned */
    bool facets;
} write_mesh;

/* FATHOM_OUT_OF_RESOURCES, also for more than 2^32 - 1 vertices. */
fathom_status write_mesh_prepare(fathom_context *context, const fathom_mesh *mesh, bool facets,
                                 write_mesh *out);
void write_mesh_free(write_mesh *m);

/* Item i of an array of a mesh. */
static inline vec3_f32 write_item(const float *base, size_t stride, size_t i) {
    return load_f32((const float *)(const void *)((const char *)base + stride * i));
}

/* Numbers of an entry, 0 where the mesh has none. */
unsigned write_mesh_width(const fathom_mesh *mesh, mesh_kind kind);
/* The entry of a vertex. */
void write_mesh_entry(const write_mesh *m, mesh_kind kind, uint32_t vertex, float out[4]);

vec3_f32 write_mesh_position(const write_mesh *m, uint32_t vertex);
vec3_f32 write_mesh_normal(const write_mesh *m, uint32_t vertex); /* the mesh has normals, or facets is set */
void write_mesh_uv(const write_mesh *m, uint32_t vertex, float uv[2]); /* 0 0 where the mesh has none */
uint32_t write_mesh_index(const write_mesh *m, size_t corner);

/* ---- placing ---- */

/* A mesh placed in the world. */
typedef struct write_placement {
    fathom_id object;
    const fathom_mesh *mesh;
    uint32_t mesh_index; /* in the scene's array */
    fathom_id material;
    bool plain;     /* the map is the identity */
    bool mirrored;  /* the winding is reversed, so that normals keep their side */
    affine_f64 map; /* mesh to world, the mesh's origin included */
    affine_f64 inverse;
} write_placement;

vec3_f32 write_placed_position(const write_placement *p, vec3_f32 position);
vec3_f32 write_placed_normal(const write_placement *p, vec3_f32 normal);

/* Calls visit for each placed mesh, in a fixed order, until it fails. */
typedef fathom_status (*write_visit)(void *user, const write_placement *p);
fathom_status write_each_placement(const fathom_scene *scene, const scene_graph *graph, write_visit visit,
                                   void *user);

/* The clouds that readers make of the points of a file. */
typedef enum write_clouds { WRITE_CLOUDS_EACH, WRITE_CLOUDS_BY_MATERIAL, WRITE_CLOUDS_ALL } write_clouds;
/* Counts the clouds whose radius is not the one that readers give their points. */
fathom_status write_count_radii(const fathom_scene *scene, const scene_graph *graph, write_clouds how,
                                size_t *out);

/* How often each group is placed; SIZE_MAX when too often to count. Release with free(). */
fathom_status write_count_ways(const fathom_scene *scene, const scene_graph *graph, size_t **out);
size_t write_add(size_t a, size_t b); /* SIZE_MAX when they overflow */
size_t write_multiply(size_t a, size_t b);

/* ---- streams ---- */

/* A file written by all threads: pieces are made in parallel and written in order. */
typedef struct write_stream {
    fathom_context *context;
    file_writer *file;
    char *buffer;
    size_t *sizes; /* of the pieces that are in the buffer */
    size_t pieces;
    locale_t locale; /* of the numbers */
} write_stream;

/* Makes the bytes of items [begin,end) at `out` and returns how many. */
typedef size_t (*write_format)(const void *user, size_t begin, size_t end, char *out);

fathom_status write_stream_open(fathom_context *context, const char *path, write_stream *out);
/* most: bytes that one item can take, at most a few hundred. */
void write_items(write_stream *s, size_t count, size_t most, write_format format, const void *user);
/* Ends the stream: commits when status is FATHOM_OK, else removes what was written and returns status. */
fathom_status write_stream_close(write_stream *s, fathom_status status);

/* ---- text ---- */

/* The most bytes that a number takes, without a terminator. */
#define WRITE_NUMBER_BYTES 32
/* Decimal text that reads back as the same value, in the C locale. Each returns the length. */
size_t write_float(char *out, float value);
size_t write_integer(char *out, uint64_t value);
/* In quotes, escaped for JSON; bytes that are not UTF-8 become '?'. */
void write_quoted(file_writer *file, const char *text);

/* ---- materials ---- */

/* The exponent of Blinn's lobe; a Phong lobe around the mirrored ray is as wide as a Blinn lobe with four
 * times its exponent. 0: no highlight. */
double write_blinn_exponent(const fathom_material *m);

/* A unique name for each material, or for each group; of one word if `words`. Release *out with
 * write_names_free() even after a failure. */
fathom_status write_names(const fathom_scene *scene, bool groups, bool words, char ***out);
void write_names_free(char **names, size_t count);

/* ---- settings ---- */

/* Those that scene JSON of the same integrator has where it gives none. */
fathom_settings write_usual_settings(const fathom_scene *scene);

/* ---- texture coordinates ---- */

/* The map of an image as a scale, then a turn about the origin as glTF counts it, then an offset. */
typedef struct write_turn {
    bool plain, sheared; /* it is the identity; it is no such product */
    double radians, scale[2];
} write_turn;

write_turn write_turn_of(const float m[6]);

#endif
