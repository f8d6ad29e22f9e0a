/* How a PLY file becomes a mesh. The header (ply_header.c) says what the rows hold; the rows are read from
 * text (ply_ascii.c) or bytes (ply_binary.c), in parallel; polygons are split and joined into one list of
 * triangles (ply_faces.c); ply.c puts it all together. */
#ifndef READ_PLY_H
#define READ_PLY_H

#include "base/file.h"
#include "read/mesh/notes.h"
#include "read/read.h"

#include <pthread.h>

typedef enum ply_format { PLY_ASCII, PLY_LITTLE, PLY_BIG } ply_format;

typedef enum ply_type {
    PLY_INT8,
    PLY_UINT8,
    PLY_INT16,
    PLY_UINT16,
    PLY_INT32,
    PLY_UINT32,
    PLY_FLOAT32,
    PLY_FLOAT64
} ply_type;

size_t ply_size(ply_type type);

#define PLY_NAME 64

typedef struct ply_property {
    char name[PLY_NAME];
    bool is_list;
    ply_type count_type; /* of lists */
    ply_type type;
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

/* What a property of a vertex is to the mesh. */
enum { PLY_X, PLY_Y, PLY_Z, PLY_NX, PLY_NY, PLY_NZ, PLY_U, PLY_V, PLY_ROLES };

/* The arrays those make up. */
enum { PLY_POSITIONS, PLY_NORMALS, PLY_UVS, PLY_ARRAYS };

typedef struct ply_array {
    int first_role, components;
    bool present;
    float *own;          /* as converted; NULL if the file's bytes are used as they are */
    const float *values; /* own, or inside the mapped file */
    size_t stride;
} ply_array;

/* A polygon written as a fan. */
typedef struct ply_polygon {
    size_t first; /* triangle */
    uint32_t corners;
} ply_polygon;

/* The triangles of successive rows. */
typedef struct ply_faces {
    ARRAY(uint32_t) indices;
    ARRAY(ply_polygon) polygons;
    ARRAY(int64_t) row; /* the list being read */
    size_t small;       /* faces of less than 3 corners */
    size_t target;      /* first triangle in the mesh */
    bool out_of_memory;
} ply_faces;

typedef struct ply_reader {
    fathom_scene *scene;
    fathom_id group;
    read_mesh_options options;
    file_map map;
    text_file file; /* text as far as it is text, and what follows */
    note_list notes;
    unsigned threads;
    ply_header header;
    size_t vertex_element, face_element;
    bool strips;         /* the face element is tristrips */
    size_t index_list;   /* the face element's property */
    int role[PLY_ROLES]; /* the vertex element's property; -1: none */
    uint32_t vertex_count;
    ply_array arrays[PLY_ARRAYS];
    scene_bounds bounds;
    vec3_f64 origin;
    uint32_t *indices; /* the scene's */
    size_t triangle_count, small;
    pthread_mutex_t lock; /* of fault, bounds and out_of_memory */
    text_fault fault;     /* the first in the file */
    bool out_of_memory;
} ply_reader;

/* Keeps the fault that is first in the file, from any thread; always returns false. field: the statement or
 * property; may be NULL. */
bool ply_wrong(ply_reader *r, const void *at, const char *field, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
/* Joins what a thread found to the reader's. */
void ply_join_bounds(ply_reader *r, const scene_bounds *bounds);
void ply_no_memory(ply_reader *r);
/* FATHOM_OK if there is neither fault nor lack of memory. Names the line of text and headers, else the byte.
 */
fathom_status ply_status(ply_reader *r);

/* Makes the file's header, and its rows if they are text, into text with line feeds. */
fathom_status ply_open_text(ply_reader *r, const char *path);
fathom_status ply_read_header(ply_reader *r);
/* Notes what of the file is not read. */
void ply_note_unused(ply_reader *r);
void ply_free_header(ply_header *header);

/* Fills arrays[] (checked: all finite), bounds, origin and the triangles. */
fathom_status ply_read_ascii(ply_reader *r);
fathom_status ply_read_binary(ply_reader *r);

/* Memory for the arrays that are present and have none; values and strides follow. */
fathom_status ply_allocate_arrays(ply_reader *r);
/* Checks the numbers of vertex `i`, adds it to the bounds, and stores what has memory of its own. `at`: where
 * it is in the file. */
bool ply_put_vertex(ply_reader *r, uint32_t i, const double values[PLY_ROLES], const void *at,
                    scene_bounds *bounds);
/* Chooses the origin from the bounds. True: the positions are to be stored again (arrays[] has memory). */
fathom_status ply_choose_origin(ply_reader *r, bool *again);
void ply_put_position(ply_reader *r, uint32_t i, const double values[PLY_ROLES]);

/* Adds the polygon, or the strip, in faces->row. False after a fault or without memory. */
bool ply_push_row(ply_reader *r, ply_faces *faces, const void *at);
bool ply_check_index(ply_reader *r, int64_t index, const void *at);
/* Splits the polygons of all pieces and joins them. */
fathom_status ply_join_faces(ply_reader *r, ply_faces *faces, size_t count);
void ply_free_faces(ply_faces *faces);

#endif
