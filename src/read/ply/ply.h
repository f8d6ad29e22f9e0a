/* A PLY file becomes a mesh: the header (ply_header.c) says what the rows hold; rows of text (ply_ascii.c) or
 * bytes (ply_binary.c, ply_rows.c) are read in parallel; polygons are split and joined into one list of
 * triangles (ply_faces.c); ply.c puts it together. */
#ifndef READ_PLY_H
#define READ_PLY_H

#include "base/file.h"
#include "read/mesh/notes.h"
#include "read/mesh/polygon.h"
#include "read/read.h"

#include <pthread.h>
#include <string.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "little-endian files are used in place");

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

/* What a vertex property means for the mesh. */
enum { PLY_X, PLY_Y, PLY_Z, PLY_NX, PLY_NY, PLY_NZ, PLY_U, PLY_V, PLY_ROLES };

/* The mesh's arrays. */
enum { PLY_POSITIONS, PLY_NORMALS, PLY_UVS, PLY_ARRAYS };

typedef struct ply_array {
    int first_role, components;
    bool present;
    float *own;          /* converted; NULL if the file's bytes are used in place */
    const float *values; /* own, or inside the mapped file */
    size_t stride;
} ply_array;

/* The triangles of successive rows. */
typedef struct ply_faces {
    ARRAY(uint32_t) indices;
    ARRAY(polygon_fan) polygons;
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
    text_file file; /* the whole file; only the header is text in binary files */
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

/* Records the fault that is first in the file, from any thread; always returns false. field: the statement or
 * property; may be NULL. */
bool ply_wrong(ply_reader *r, const void *at, const char *field, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
void ply_join_bounds(ply_reader *r, const scene_bounds *bounds);
void ply_no_memory(ply_reader *r);
/* The first fault or lack of memory as a status; names the line in text and headers, else the byte. */
fathom_status ply_status(ply_reader *r);

/* Opens the file as text: gives the header, and the rows if they are text, line feeds. */
fathom_status ply_open_text(ply_reader *r, const char *path);
fathom_status ply_read_header(ply_reader *r);
/* Notes the elements and properties that are not read. */
void ply_note_unused(ply_reader *r);
void ply_free_header(ply_header *header);

/* Fills arrays[] (checked: all finite), bounds, origin and the triangles. */
fathom_status ply_read_ascii(ply_reader *r);
fathom_status ply_read_binary(ply_reader *r);

/* Allocates the arrays that are present and have no memory, and sets their values and strides. */
fathom_status ply_allocate_arrays(ply_reader *r);
/* Checks the numbers of vertex `i`, adds it to the bounds, and stores it in the arrays with memory of their
 * own. `at`: its place in the file. */
bool ply_put_vertex(ply_reader *r, uint32_t i, const double values[PLY_ROLES], const void *at,
                    scene_bounds *bounds);
/* Chooses the origin from the bounds. *again: the positions must be stored again, and have memory. */
fathom_status ply_choose_origin(ply_reader *r, bool *again);
void ply_put_position(ply_reader *r, uint32_t i, const double values[PLY_ROLES]);

/* Adds the polygon or strip in faces->row. False after a fault or without memory. */
bool ply_push_row(ply_reader *r, ply_faces *faces, const void *at);
bool ply_check_index(ply_reader *r, int64_t index, const void *at);
/* Splits the polygons of all pieces and joins them. */
fathom_status ply_join_faces(ply_reader *r, ply_faces *faces, size_t count);
void ply_free_faces(ply_faces *faces);

/* ---- binary files ---- */

static inline uint16_t ply_load_16(const unsigned char *p, bool big) {
    uint16_t bits;
    memcpy(&bits, p, sizeof bits);
    return big ? __builtin_bswap16(bits) : bits;
}

static inline uint32_t ply_load_32(const unsigned char *p, bool big) {
    uint32_t bits;
    memcpy(&bits, p, sizeof bits);
    return big ? __builtin_bswap32(bits) : bits;
}

static inline float ply_load_float(const unsigned char *p, bool big) {
    uint32_t bits = ply_load_32(p, big);
    float number;
    memcpy(&number, &bits, sizeof number);
    return number;
}

static inline double ply_load_double(const unsigned char *p, bool big) {
    uint64_t bits;
    double number;
    memcpy(&bits, p, sizeof bits);
    if (big) bits = __builtin_bswap64(bits);
    memcpy(&number, &bits, sizeof number);
    return number;
}

/* `big`: the most significant byte comes first. Every type's numbers are doubles exactly. */
static inline double ply_load(const unsigned char *p, ply_type type, bool big) {
    switch (type) {
    case PLY_INT8: return (int8_t)*p;
    case PLY_UINT8: return *p;
    case PLY_INT16: return (int16_t)ply_load_16(p, big);
    case PLY_UINT16: return ply_load_16(p, big);
    case PLY_INT32: return (int32_t)ply_load_32(p, big);
    case PLY_UINT32: return ply_load_32(p, big);
    case PLY_FLOAT32: return (double)ply_load_float(p, big);
    case PLY_FLOAT64: return ply_load_double(p, big);
    }
    return 0;
}

/* Where the rows of an element of a binary file lie. Rows are read in blocks: rows that differ in size are
 * walked once, which notes where each block begins. */
#ifndef PLY_BLOCK /* fuzzing cuts small files */
#define PLY_BLOCK 4096
#endif

typedef struct ply_rows {
    const ply_element *element;
    const unsigned char *begin, *end;
    size_t row;                   /* bytes of every row, if they are alike; else 0 */
    size_t *offsets;              /* of each property in the row, if they are alike */
    const unsigned char **blocks; /* else where each block begins */
    size_t block_count;
} ply_rows;

/* Finds the rows of `element`, which begin at `begin`. */
fathom_status ply_find_rows(ply_reader *r, const ply_element *element, const unsigned char *begin,
                            ply_rows *out);
void ply_free_rows(ply_rows *rows);

/* A row that is being read. */
typedef struct ply_row {
    const unsigned char *at;
    const size_t *offsets;
    size_t *own_offsets;  /* where rows differ */
    uint64_t number, end; /* of the block */
} ply_row;

/* The first row of a block; ply_free_row() when done with it. */
bool ply_first_row(ply_reader *r, const ply_rows *rows, size_t block, ply_row *row);
/* False after the last row of the block. */
bool ply_next_row(ply_reader *r, const ply_rows *rows, ply_row *row);
void ply_free_row(ply_row *row);

/* The length of the list at `p`, past which it moves; false after a fault: not a whole number, or more than
 * the file holds. */
bool ply_list_count(ply_reader *r, const ply_property *list, const unsigned char **p, uint64_t *out);

#endif
