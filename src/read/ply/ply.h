/* Reads a PLY file as a mesh. The header (ply_header.c, ply_roles.c) describes the rows. Rows of text
 * (ply_ascii.c) or bytes (ply_binary.c) are read in parallel. Polygons are triangulated and joined into one
 * list of triangles (ply_faces.c). Colours become linear (ply_colors.c). Those of faces, their texture
 * coordinates and textures are given to corners (ply_surface.c). ply.c calls these steps. */
#pragma once

#include "base/file.h"
#include "base/threads.h"
#include "read/mesh/polygon.h"
#include "read/mesh/scalar.h"
#include "read/mesh/text.h"
#include "read/read.h"

#include <pthread.h>
#include <stdatomic.h>

typedef enum ply_format { PLY_ASCII, PLY_LITTLE, PLY_BIG } ply_format;

#define PLY_NAME 64

typedef struct ply_property {
    char name[PLY_NAME];
    bool is_list;
    scalar_type count_type; /* of lists */
    scalar_type type;
    int role; /* of a property of a vertex, an edge or a face; -1: none */
} ply_property;

typedef struct ply_element {
    char name[PLY_NAME];
    uint64_t count;
    const char *line; /* where the header declares it */
    ARRAY(ply_property) properties;
} ply_element;

typedef struct ply_header {
    ply_format format;
    ARRAY(ply_element) elements;
    const char *body;
} ply_header;

/* The meaning of a vertex property for the mesh. */
enum {
    PLY_X,
    PLY_Y,
    PLY_Z,
    PLY_NX,
    PLY_NY,
    PLY_NZ,
    PLY_U,
    PLY_V,
    PLY_U1,
    PLY_V1,
    PLY_R,
    PLY_G,
    PLY_B,
    PLY_A,
    PLY_ROLES
};

/* The meaning of an edge's property: its two vertices. */
enum { PLY_FROM, PLY_TO, PLY_ENDS };

/* The meaning of a face's property. */
enum { PLY_FACE_R, PLY_FACE_G, PLY_FACE_B, PLY_FACE_A, PLY_TEXNUMBER, PLY_FACE_ROLES };

/* Colour and texture of a triangle, which its face gives. */
typedef struct ply_look {
    float color[4];   /* as in the file, then linear */
    uint32_t texture; /* number of a TextureFile; their count: none */
} ply_look;

/* The mesh's arrays. */
enum { PLY_POSITIONS, PLY_NORMALS, PLY_UVS, PLY_UVS_1, PLY_COLORS, PLY_ARRAYS };

typedef struct ply_array {
    int first_role, components;
    bool present;
    float *own;          /* converted values; NULL if the file's bytes are used in place */
    const float *values; /* `own`, or an address in the mapped file */
    size_t stride;
} ply_array;

/* The triangles of successive rows. */
typedef struct ply_faces {
    ARRAY(uint32_t) indices;
    ARRAY(polygon_fan) polygons;
    ARRAY(uint32_t) row;        /* the list that is being read; UINT32_MAX ends a strip */
    ARRAY(float) row_uvs;       /* the texture coordinates that are being read */
    ARRAY(float) uvs;           /* of each corner of each face */
    ARRAY(uint32_t) uv_indices; /* of each corner of each triangle; NULL: faces have none */
    ARRAY(ply_look) looks;      /* of each triangle; NULL: faces have none */
    size_t small;               /* faces with fewer than 3 corners */
    size_t bad_uvs;             /* faces with a wrong number of texture coordinates */
    size_t odd;                 /* numbers of faces that are not finite; 0 is taken for them */
    size_t no_texture;          /* faces with a texnumber that no TextureFile has */
    size_t target;              /* index of its first triangle in the mesh */
    size_t uv_target;           /* index of its first texture coordinates */
} ply_faces;

typedef struct ply_reader {
    fathom_scene *scene;
    fathom_id group;
    read_mesh_options options;
    file_map map;
    text_file file;
    text_fault fault;
    note_list notes;
    unsigned threads;
    ply_header header;
    size_t vertex_element, face_element, edge_element; /* SIZE_MAX: no such element with rows */
    bool strips;                                       /* the face element is "tristrips" */
    bool splats;    /* the vertices are Gaussian splats; their colours are spherical harmonics */
    bool by_fathom; /* Fathom wrote the file */
    ARRAY(const char *) textures; /* the names in the header, up to the ends of the lines */
    fathom_id colored;            /* the material of colours without a texture; FATHOM_NONE: not made yet */
    ARRAY(fathom_id) materials;   /* of each of them; FATHOM_NONE: it cannot be shown */
    size_t index_list;            /* property of the face element */
    size_t uv_list;               /* the same; SIZE_MAX: none */
    bool looks_read;              /* faces have colours or numbers of textures */
    int face_color, face_alpha;   /* properties of the face element; -1: none */
    int role[PLY_ROLES];          /* property of the vertex element; -1: none */
    uint32_t vertex_count;
    ply_array arrays[PLY_ARRAYS];
    pthread_mutex_t lock; /* guards the bounds */
    scene_bounds bounds;
    vec3_f64 origin;
    bool moving;       /* vertices are read a second time, and stored from the origin */
    atomic_bool mends; /* some vertex has a number that is not finite */
    atomic_size_t odd; /* such numbers that are no position's; 0 is taken for them */
    bool loses;        /* some vertices have no finite position: NaN instead, until ply_drop_lost() */
    ply_faces *pieces; /* of successive parts of the file */
    size_t piece_count;
    uint32_t *indices; /* owned by the scene */
    size_t triangle_count;
    uint32_t *uv_indices; /* owned by the scene; of each corner, a row of uvs; NULL: none */
    float *uvs;
    ply_look *looks; /* of each triangle; NULL: none */
    uint32_t *edges; /* two vertex indices per edge; NULL: none */
} ply_reader;

/* Opens the file as text. Replaces the line ends of old Macs by line feeds in the header, and in the rows if
 * they are text. */
fathom_status ply_open_text(ply_reader *r, const char *path);
fathom_status ply_read_header(ply_reader *r);
/* Sets the roles of elements and properties. False: r->fault says what is wrong. */
bool ply_find_roles(ply_reader *r);
/* Takes the role of a vertex's property back, if there is such a property. */
void ply_drop_role(ply_reader *r, int role);
/* "element NAME", for messages. Returns `out`. */
const char *ply_element_field(const ply_element *element, char out[52]);
/* Adds a note for the elements and properties that are not read. */
void ply_note_unused(ply_reader *r);

/* Each fills in arrays[], all finite, bounds, origin and the triangles. */
fathom_status ply_read_ascii(ply_reader *r);
fathom_status ply_read_binary(ply_reader *r);

/* Allocates the arrays that are present and have no values yet, and sets their values and strides. */
fathom_status ply_allocate_arrays(ply_reader *r);
/* Adds vertex `i` to the bounds, and stores it in the arrays with memory of their own; if it is moving, only
 * its position, or what was not stored before a number was found that is not finite. */
void ply_put_vertex(ply_reader *r, uint32_t i, double values[PLY_ROLES], scene_bounds *bounds);
/* Reads the vertices by loops of `body`, which calls ply_put_vertex() and ply_join_bounds(): twice if they
 * lie far from the origin, or if some are not finite. */
fathom_status ply_read_vertices(ply_reader *r, size_t count, size_t grain, loop_body body, void *user);
void ply_join_bounds(ply_reader *r, const scene_bounds *bounds);

fathom_status ply_make_pieces(ply_reader *r, size_t count);
/* Adds an index to the row. False: a fault was recorded, or out of memory. */
bool ply_push_checked(ply_reader *r, ply_faces *faces, int64_t index, const void *at);
static inline bool ply_push_index(ply_reader *r, ply_faces *faces, int64_t index, const void *at) {
    if ((uint64_t)index >= r->vertex_count || faces->row.count == faces->row.capacity)
        return ply_push_checked(r, faces, index, at);
    faces->row.items[faces->row.count++] = (uint32_t)index;
    return true;
}
/* Adds a number of the face's texture coordinates. False: out of memory. */
bool ply_push_uv(ply_reader *r, ply_faces *faces, double value);
/* Adds the triangles of the row, and begins a new row. values: by role. False: out of memory. */
bool ply_end_row(ply_reader *r, ply_faces *faces, double values[PLY_FACE_ROLES]);
fathom_status ply_allocate_triangles(ply_reader *r, uint64_t count);
/* Checks the vertices of edge number `i`, and stores them. */
bool ply_put_edge(ply_reader *r, uint64_t i, const double values[PLY_ENDS], const void *at);
/* Leaves out lost vertices (lost.h), and the faces and edges that use them. */
void ply_drop_lost(ply_reader *r);
/* Triangulates the polygons of all pieces, and joins the pieces. */
fathom_status ply_join_faces(ply_reader *r);

/* Adds a material for each texture that the header names and that can be shown. */
fathom_status ply_read_textures(ply_reader *r);
/* The material of faces without a texture. */
fathom_status ply_plain_material(ply_reader *r, bool colored, fathom_id *out);
/* Makes the colours of vertices and faces linear. */
fathom_status ply_decode_colors(ply_reader *r);
/* 3 or 4: opacities that are all 1 are not stored. Opacities that are all 0 are ignored, with a note that
 * names their `places`: some programs never set them. */
unsigned ply_color_channels(ply_reader *r, const float *colors, size_t stride, size_t count,
                            const char *places);
/* Adds the triangles. `mesh` has all else. */
fathom_status ply_add_surface(ply_reader *r, fathom_mesh mesh);
/* Adds a mesh after checks; its arrays may change. */
fathom_status ply_add_mesh(ply_reader *r, fathom_mesh *mesh);
