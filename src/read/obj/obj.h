/* Reads a Wavefront OBJ file as meshes, in five steps over pieces of the text, each in parallel. Scan (obj.c)
 * counts vertices and finds the material and smoothing group at the start of each piece, so that every piece
 * can compute its indices, negative ones too. Parse (obj_parse.c) writes vertices to their final places and
 * triangles to their piece. Then polygons are triangulated, smooth normals are computed (obj_smooth.c), and
 * triangles are sorted into one mesh per material (obj_build.c). Points and lines become meshes of their own
 * (obj_strokes.c). The size of a piece does not depend on the thread count, so no result does. */
#pragma once

#include "base/array.h"
#include "read/mesh/polygon.h"
#include "read/mesh/text.h"
#include "read/read.h"

/* ---- numbers for names (obj_materials.c): the first name is 0, the next new one 1, … ---- */

typedef struct name_entry {
    const char *text; /* owned by the caller, not zero-terminated */
    size_t length;
    uint32_t number;
} name_entry;

/* Zero it before use. It is a balanced tree, so that no set of names makes it slow. */
typedef struct name_table {
    ARRAY(name_entry *) entries; /* by number */
    void *tree;
} name_table;

/* The number of a name; a new name is added. UINT32_MAX when out of memory. The text must outlive the
 * table. */
uint32_t names_add(name_table *table, const char *text, size_t length);
/* UINT32_MAX if the table does not have the name. */
uint32_t names_find(const name_table *table, const char *text, size_t length);
void names_free(name_table *table);

/* ---- materials (mtl.c) ---- */

/* An image that a material names. */
typedef struct mtl_image {
    char *file; /* its path, relative to the library; NULL: none */
    bool clamp;
    double bump;    /* -bm */
    fathom_map map; /* all but its texture */
} mtl_image;

typedef struct mtl_material {
    char *name, *library; /* `library`: the path of its file */
    fathom_material value;
    bool hidden; /* its colour is the one that Blender writes where vertex colours replace it */
    mtl_image images[FATHOM_MAPS];
} mtl_material;

/* Zero it before use; release with mtl_free(). */
typedef struct mtl_library {
    ARRAY(mtl_material) materials;
    name_table names; /* of materials[], in the same order */
} mtl_library;

/* Adds the materials of the file; a later material replaces an earlier one of the same name. Warns about
 * unused values, and about a file that cannot be opened. The message of FATHOM_BAD_INPUT names the line. */
fathom_status mtl_read(fathom_context *context, const char *path, mtl_library *library);
void mtl_free(mtl_library *library);
/* Adds the material's images to the scene as the maps of *out. Missing images are counted in *lost; the first
 * MTL_LOST_IMAGES are named. */
#define MTL_LOST_IMAGES 8
fathom_status mtl_open_images(fathom_scene *scene, const mtl_material *material, size_t *lost,
                              fathom_material *out);

/* ---- meshes ---- */

/* The kinds of data of a corner, in the order of "f v/vt/vn". */
enum { OBJ_POSITION, OBJ_UV, OBJ_NORMAL, OBJ_KINDS };

#define OBJ_ALL_GROUPS UINT32_MAX /* smoothing group of faces that only options.smooth makes smooth */

/* A name that a line of the file mentions. */
typedef struct obj_mention {
    const char *at; /* the name in the file */
    size_t length;
    uint32_t slot; /* usemtl: index into obj_reader.slots; o and g: 1 + index into obj_reader.objects */
} obj_mention;

/* Consecutive triangles of a piece with the same material, object, smoothing group and kinds of data. */
typedef struct obj_run {
    size_t first, count;  /* triangles of the piece */
    uint32_t slot;        /* material */
    uint32_t object;      /* 0: none */
    uint32_t group;       /* smoothing group; 0: not smoothed */
    uint32_t mesh;        /* index of its mesh */
    bool has[OBJ_KINDS];  /* OBJ_UV, OBJ_NORMAL */
    bool same[OBJ_KINDS]; /* the indices of this kind equal those of the positions */
    size_t target;        /* index of its first triangle in its mesh */
} obj_run;

/* The kinds of skipped or changed parts. From OBJ_T_ODD on, the note quotes the word of the first one. */
enum {
    OBJ_T_LINES,  /* l, read as rods */
    OBJ_T_POINTS, /* elements of p, read as spheres */
    OBJ_T_SHORT,  /* l with fewer than 2 corners */
    OBJ_T_SMALL,  /* faces with fewer than 3 corners */
    OBJ_T_MIXED,  /* faces whose corners have different kinds of indices */
    OBJ_T_LOST,   /* vertices that are no finite numbers */
    OBJ_T_ALPHA,  /* colours with an alpha that is not opaque */
    OBJ_T_ODD,    /* numbers of uvs and normals that are not finite numbers */
    OBJ_T_BEHIND, /* extra words after the numbers of a vertex */
    OBJ_T_NO_UV,  /* faces with indices of texture coordinates, in a file without them */
    OBJ_T_NO_NORMAL,
    OBJ_T_UNKNOWN, /* unknown statements, which are skipped */
    OBJ_TALLIES
};

/* The kinds of elements without area. */
enum { OBJ_POINTS, OBJ_LINES, OBJ_STROKES };

/* Consecutive points or lines of a piece with the same material. */
typedef struct obj_stroke_run {
    size_t first, count; /* range of the corners */
    uint32_t slot;
} obj_stroke_run;

typedef struct obj_strokes {
    ARRAY(uint32_t) corners; /* indices of positions: one per point, two per line */
    ARRAY(obj_stroke_run) runs;
} obj_strokes;

/* A count, and the place of the first occurrence. */
typedef struct obj_tally {
    size_t count;
    const char *first;
} obj_tally;

typedef struct obj_piece {
    const char *begin, *end;
    /* From the scan. */
    uint64_t count[OBJ_KINDS], base[OBJ_KINDS];
    ARRAY(obj_mention) materials, libraries, paint, objects;
    bool sets_group;
    uint32_t last_group;                            /* if sets_group */
    uint32_t first_slot, first_object, first_group; /* values at the beginning of the piece */
    /* From the parse. Indices of uvs and normals are stored only once one differs from the index of the
     * position; an empty array means that all are equal. */
    ARRAY(uint32_t) corners[OBJ_KINDS];
    ARRAY(obj_run) runs;
    ARRAY(polygon_fan) polygons;
    obj_strokes strokes[OBJ_STROKES];
    double lower[3], upper[3]; /* of the positions */
    obj_tally tallies[OBJ_TALLIES];
    uint64_t colored; /* vertices that have a colour */
    bool finely;      /* one of its numbers is no whole number from 0 to 255 */
    double brightest; /* of its numbers */
} obj_piece;

/* A material name, or none (slot 0). */
typedef struct obj_slot {
    fathom_id material;
    uint32_t same_as; /* the first slot that has this material */
    bool hidden;      /* as in mtl_material */
} obj_slot;

typedef struct obj_reader {
    fathom_scene *scene;
    fathom_id group;
    read_mesh_options options;
    text_file file;
    text_fault fault;
    note_list notes;
    unsigned threads;
    obj_piece *pieces;
    size_t piece_count;
    uint64_t total[OBJ_KINDS];
    name_table names;
    ARRAY(obj_slot) slots;      /* indexed by 1 + index into names */
    ARRAY(obj_mention) objects; /* o, or g in a file without o; the same name twice in a row is one */
    float *values[OBJ_KINDS];   /* total[] of them, then 16 bytes of padding */
    bool adopted[OBJ_KINDS];    /* the scene owns values[] */
    float *colors;     /* linear RGB of each vertex, white if it has no colour; NULL: no vertex has one */
    double white;      /* the number of the file that means 1 in a colour: 1, or 255 */
    fathom_id colored; /* material of elements without one, in a file with vertex colours */
    vec3_f64 origin;
    bool cloud; /* it has vertices alone */
    bool again; /* second pass: vertices are stored again, relative to the origin and with their colours */
} obj_reader;

/* The kinds of statements. */
typedef enum obj_statement {
    OBJ_S_EMPTY, /* comments too */
    OBJ_S_PAINT, /* the comment in which ZBrush writes colours of vertices */
    OBJ_S_POSITION,
    OBJ_S_UV,
    OBJ_S_NORMAL,
    OBJ_S_FACE,
    OBJ_S_LINE,
    OBJ_S_POINT,
    OBJ_S_OBJECT,
    OBJ_S_GROUP,
    OBJ_S_SMOOTHING,
    OBJ_S_MATERIAL,
    OBJ_S_LIBRARY,
    OBJ_S_UNKNOWN
} obj_statement;

/* The kind of the statement at *p. Moves *p past the keyword. */
obj_statement obj_classify(const char **p);

/* Reads the group of an s statement; `p` is after the keyword. False if it is invalid. */
bool obj_smoothing_group(const char *p, uint32_t *group);

/* True if both have the same name. */
bool obj_same_mention(const obj_mention *a, const obj_mention *b);

/* The start of the next line. A backslash joins lines, but not comments. */
const char *obj_next(obj_statement statement, const char *p, const char *end);

/* Reads the libraries and finds the material of each name. */
fathom_status obj_find_materials(obj_reader *r);
/* Reads vertices and triangles; then triangulates polygons, which needs the vertices. */
fathom_status obj_parse(obj_reader *r);
/* Makes room for the colours of vertices if there are any, and reads those of ZBrush. */
fathom_status obj_begin_colors(obj_reader *r);
/* Leaves out vertices that are no finite numbers, and what uses them. FATHOM_BAD_INPUT when none is left. */
fathom_status obj_drop_lost(obj_reader *r);
/* Extends the piece's indices of this kind to the number of its positions' indices, by copies of the latter.
 * False: out of memory. */
bool obj_keep_indices(obj_piece *piece, int kind);
fathom_status obj_smooth(obj_reader *r);
fathom_status obj_build(obj_reader *r);
/* Sets the mesh's origin, material and flags, and adds it to the scene. facts: of the vertices. */
fathom_status obj_add_mesh(obj_reader *r, uint32_t slot, fathom_mesh *mesh, mesh_facts facts);
/* Adds points and lines as spheres and thin rods. *added: whether there are any. A file with only vertices
 * becomes a point cloud. */
fathom_status obj_add_strokes(obj_reader *r, bool *added);
