/* Shared by the writers of mesh files. */
#pragma once

#include "base/file.h"
#include "read/mesh/text.h"
#include "scene/graph.h"
#include "scene/mesh/mesh_array.h"

#include <fathom/parameter.h>

#include <locale.h>

/* The binary formats are little-endian, as are all machines that Embree supports. */
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "arrays are written as they lie in memory");

/* Each call writes the whole file or none, and adds notes on data that the format cannot hold. `graph` is the
 * graph of `scene`. */
fathom_status write_glb(const fathom_scene *scene, const scene_graph *graph, const char *path,
                        note_list *notes);
fathom_status write_ply(const fathom_scene *scene, const scene_graph *graph, const char *path,
                        note_list *notes);
/* The one image that a PLY file can have: the colours, or the emission, of all triangles. NULL: they do not
 * share one, or PLY cannot hold it. */
const fathom_map *write_ply_image(const fathom_scene *scene, const scene_graph *graph);
/* Number of points that PLY cannot hold; ways: from write_count_ways(). */
size_t write_ply_lost_points(const fathom_scene *scene, const size_t *ways);
fathom_status write_obj(const fathom_scene *scene, const scene_graph *graph, const char *path,
                        note_list *notes);
fathom_status write_json(const fathom_scene *scene, const scene_graph *graph, const char *path,
                         note_list *notes);

/* ---- meshes with one index for each vertex ---- */

/* A fathom_mesh for formats with one index for position, normal and uv. Vertex i has the mesh's position
 * positions[i], and likewise for normals and uvs; a NULL array means index i. `facets`: each corner is a
 * separate vertex with the facet's normal. `flips` is false after write_mesh_prepare(). */
typedef struct write_mesh {
    const fathom_mesh *mesh; /* NULL: not prepared */
    uint32_t vertex_count;
    uint32_t *positions, *normals, *uvs, *indices; /* owned */
    bool facets;
    bool flips; /* the file has 1 - v */
} write_mesh;

/* FATHOM_OUT_OF_RESOURCES, also for more than 2^32 - 1 vertices. */
fathom_status write_mesh_prepare(fathom_context *context, const fathom_mesh *mesh, bool facets,
                                 write_mesh *out);
void write_mesh_free(write_mesh *m);

/* Item i of an array of a mesh. */
static inline vec3_f32 write_item(const float *base, size_t stride, size_t i) {
    return load_f32(mesh_row(base, stride, i));
}

/* Numbers per entry of an array; 0 if the mesh does not have it. */
unsigned write_mesh_width(const fathom_mesh *mesh, mesh_kind kind);
/* The entry of this kind for a vertex. */
void write_mesh_entry(const write_mesh *m, mesh_kind kind, uint32_t vertex, float out[4]);

vec3_f32 write_mesh_position(const write_mesh *m, uint32_t vertex);
vec3_f32 write_mesh_normal(const write_mesh *m, uint32_t vertex); /* the mesh has normals, or facets is set */
uint32_t write_mesh_index(const write_mesh *m, size_t corner);

/* The unit vector along v; v itself if its length is 0, or as near to 1 as the glTF validator wants it. */
vec3_f32 write_unit(vec3_f32 v);
/* True if write_unit() changes one of the mesh's normals or tangents. False for other kinds. */
bool write_has_lengths(const fathom_mesh *mesh, mesh_kind kind);

/* ---- quads and spheres ---- */

/* A view of the scene in which quads and spheres are meshes; ids of objects differ. The scene must outlive
 * it. Release with write_shapes_free(), even after a failure. */
fathom_status write_shapes_as_meshes(const fathom_scene *scene, fathom_scene *view);
void write_shapes_free(fathom_scene *view);

/* ---- placed meshes ---- */

/* An instance of a mesh in the world. */
typedef struct write_placement {
    fathom_id object;
    const fathom_mesh *mesh;
    uint32_t mesh_index; /* in the scene's array */
    fathom_id material;
    bool plain;     /* `map` is the identity */
    bool mirrored;  /* the winding must be reversed, so that normals stay on the same side */
    affine_f64 map; /* mesh to world, including the mesh's origin */
    affine_f64 inverse;
} write_placement;

vec3_f32 write_placed_position(const write_placement *p, vec3_f32 position);
vec3_f32 write_placed_normal(const write_placement *p, vec3_f32 normal);

/* Calls visit() for each placed mesh, in a fixed order, until one call fails. */
typedef fathom_status (*write_visit)(void *user, const write_placement *p);
fathom_status write_each_placement(const fathom_scene *scene, const scene_graph *graph, write_visit visit,
                                   void *user);

/* True if a mesh with these bounds is so far from the origin that readers give it its own origin. */
bool write_is_far(const scene_bounds *bounds);

/* How readers group the points of a file: one cloud for each mesh, for each material, or for the whole
 * file. */
typedef enum write_clouds { WRITE_CLOUDS_EACH, WRITE_CLOUDS_BY_MATERIAL, WRITE_CLOUDS_ALL } write_clouds;
/* Counts the clouds whose radius differs from the one that readers would choose. */
fathom_status write_count_radii(const fathom_scene *scene, const scene_graph *graph, write_clouds how,
                                size_t *out);

/* Counts the places of smooth meshes that are stretched. The normals of their vertices, which become unit
 * vectors, are mixed otherwise than those of the mesh itself. */
fathom_status write_count_stretched(const fathom_scene *scene, const scene_graph *graph, size_t *out);

/* The number of instances of each group; SIZE_MAX if it overflows. Release with free(). */
fathom_status write_count_ways(const fathom_scene *scene, const scene_graph *graph, size_t **out);
size_t write_add(size_t a, size_t b); /* SIZE_MAX on overflow */
size_t write_multiply(size_t a, size_t b);

/* ---- streams ---- */

/* A file written by all threads: pieces are made in parallel and written in order. */
typedef struct write_stream {
    fathom_context *context;
    file_writer *file;
    char *buffer;
    size_t *sizes; /* sizes of the pieces in the buffer */
    size_t pieces;
    locale_t locale; /* the C locale, for numbers */
} write_stream;

/* Writes the bytes of items [begin,end) to `out`, and returns their number. */
typedef size_t (*write_format)(const void *user, size_t begin, size_t end, char *out);

fathom_status write_stream_open(fathom_context *context, const char *path, write_stream *out);
/* most: maximum bytes of one item, a few hundred at most. */
void write_items(write_stream *s, size_t count, size_t most, write_format format, const void *user);
/* Ends the stream: commits the file if status is FATHOM_OK, else removes it and returns status. */
fathom_status write_stream_close(write_stream *s, fathom_status status);

/* ---- text ---- */

/* Maximum bytes of a number, without a terminator. */
#define WRITE_NUMBER_BYTES 32
/* Decimal text that reads back as the same value, in the C locale. Each returns the length. */
size_t write_float(char *out, float value);
size_t write_integer(char *out, uint64_t value);
/* Writes the text in quotes, escaped for JSON; bytes that are not UTF-8 become '?'. */
void write_quoted(file_writer *file, const char *text);

/* ---- materials ---- */

/* The exponent of the Blinn lobe. A Phong lobe around the mirrored direction is as wide as a Blinn lobe with
 * four times its exponent. 0: no highlight. */
double write_blinn_exponent(const fathom_material *m);

static inline bool write_is_black(const float c[3]) { return c[0] == 0 && c[1] == 0 && c[2] == 0; }

/* A unique name for each material, or for each group; `words`: names without blanks. Notes which are not the
 * scene's. Release *out with write_names_free() even after a failure. */
fathom_status write_names(const fathom_scene *scene, bool groups, bool words, note_list *notes, char ***out);
void write_names_free(char **names, size_t count);

/* ---- settings ---- */

/* The settings that scene JSON with the same integrator has by default. */
fathom_settings write_usual_settings(const fathom_scene *scene);

/* ---- texture coordinates ---- */

/* A texture transform as a scale, then a rotation about the origin with glTF's sign, then an offset. */
typedef struct write_turn {
    bool plain, sheared; /* plain: the identity; sheared: not such a product */
    double radians, scale[2];
} write_turn;

write_turn write_turn_of(const float m[6]);

/* True if a file in which v grows upwards stores 1 - v, so that images are upright. The first map says so: in
 * scenes from OBJ and PLY files it flips v. Without a map, the first mesh does. */
bool write_flips(const fathom_scene *scene);
/* True if a file in which v grows downwards stores 1 - v of this mesh. Where materials use texture
 * coordinates, the maps flip them. */
bool write_flips_back(const fathom_scene *scene, uint32_t mesh);
