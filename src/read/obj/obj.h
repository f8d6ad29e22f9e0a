/* A Wavefront OBJ file becomes meshes in five steps over pieces of the text, each in parallel. Scan
 * (obj.c) counts vertices and finds the material and smoothing group that each piece starts with, so
 * that every piece knows its indices, negative ones too. Parse (obj_parse.c) writes vertices to their places
 * and triangles to their piece. Then polygons are split, smooth normals made (obj_smooth.c), and triangles
 * sorted into one mesh for each material (obj_build.c). Points and lines follow, with meshes of their own
 * (obj_strokes.c). Pieces are cut by size, so no result depends on the thread count. */
#ifndef READ_OBJ_H
#define READ_OBJ_H

#include "base/array.h"
#include "read/mesh/polygon.h"
#include "read/mesh/text.h"
#include "read/read.h"

/* ---- names to numbers (obj_materials.c): the first name is 0, the next new one 1, … ---- */

typedef struct name_entry {
    const char *text; /* the caller's, not terminated */
    size_t length;
    uint32_t number;
} name_entry;

/* Zero it to start with. A balanced tree: no choice of names makes it slow. */
typedef struct name_table {
    ARRAY(name_entry *) entries; /* by number */
    void *tree;
} name_table;

/* The number of a name, which is added if it is new; UINT32_MAX when out of memory. The text must outlive the
 * table. */
uint32_t names_add(name_table *table, const char *text, size_t length);
/* UINT32_MAX when there is none. */
uint32_t names_find(const name_table *table, const char *text, size_t length);
void names_free(name_table *table);

/* ---- materials (mtl.c) ---- */

/* An image that a material names. */
typedef struct mtl_image {
    char *file; /* next to the library; NULL: none */
    bool color, clamp;
    double bump;    /* -bm */
    fathom_map map; /* without its texture */
} mtl_image;

typedef struct mtl_material {
    char *name, *library; /* the path of its file */
    fathom_material value;
    mtl_image images[FATHOM_MAPS];
} mtl_material;

/* Zero it to start with; release with mtl_free(). */
typedef struct mtl_library {
    ARRAY(mtl_material) materials;
    name_table names; /* of materials[], in the same order */
} mtl_library;

/* Adds the materials of the file; a later material replaces an earlier one of its name. Warns of values that
 * are not used, and of a file that cannot be opened. FATHOM_BAD_INPUT names the line. */
fathom_status mtl_read(fathom_context *context, const char *path, mtl_library *library);
void mtl_free(mtl_library *library);
/* Adds the material's images to the scene, and makes them its maps. Warns of those that are missing. */
fathom_status mtl_open_images(fathom_scene *scene, const mtl_material *material, fathom_material *out);

/* ---- meshes ---- */

/* The kinds of data of a corner, in the order of "f v/vt/vn". */
enum { OBJ_POSITION, OBJ_UV, OBJ_NORMAL, OBJ_KINDS };

#define OBJ_ALL_GROUPS UINT32_MAX /* the smoothing group of faces that options.smooth makes smooth */

/* A line that names something. */
typedef struct obj_mention {
    const char *at; /* the name in the file */
    size_t length;
    uint32_t slot; /* usemtl: index into obj_reader.slots */
} obj_mention;

/* Successive triangles of a piece with the same material, group and kinds of data. */
typedef struct obj_run {
    size_t first, count;  /* triangles of the piece */
    uint32_t slot;        /* material */
    uint32_t group;       /* smoothing group; 0: not to be smoothed */
    bool has[OBJ_KINDS];  /* OBJ_UV, OBJ_NORMAL */
    bool same[OBJ_KINDS]; /* the indices of this kind equal those of the positions */
    size_t target;        /* where it starts in its mesh */
} obj_run;

/* The kinds of things that are left out. The word of the first one is quoted from OBJ_T_ODD on. */
enum {
    OBJ_T_LINES,  /* l, shown as rods */
    OBJ_T_POINTS, /* of p, shown as balls */
    OBJ_T_SHORT,  /* l of less than 2 corners */
    OBJ_T_SMALL,  /* faces of less than 3 corners */
    OBJ_T_MIXED,  /* faces whose corners have different parts */
    OBJ_T_ODD,    /* numbers of uvs and normals that are none */
    OBJ_T_BEHIND, /* other words after the numbers of a vertex */
    OBJ_T_NO_UV,  /* faces that name texture coordinates the file does not have */
    OBJ_T_NO_NORMAL,
    OBJ_T_UNKNOWN, /* statements that are not read */
    OBJ_TALLIES
};

/* The kinds of elements without an area. */
enum { OBJ_POINTS, OBJ_LINES, OBJ_STROKES };

/* Successive points or lines of a piece with the same material. */
typedef struct obj_stroke_run {
    size_t first, count; /* of the corners */
    uint32_t slot;
} obj_stroke_run;

typedef struct obj_strokes {
    ARRAY(uint32_t) corners; /* indices of positions: one a point, two a line */
    ARRAY(obj_stroke_run) runs;
} obj_strokes;

/* A count, and the first place. */
typedef struct obj_tally {
    size_t count;
    const char *first;
} obj_tally;

typedef struct obj_piece {
    const char *begin, *end;
    /* From the scan. */
    uint64_t count[OBJ_KINDS], base[OBJ_KINDS];
    ARRAY(obj_mention) materials, libraries;
    bool sets_group;
    uint32_t last_group;              /* if sets_group */
    uint32_t first_slot, first_group; /* in force where the piece begins */
    /* From the parse. Indices of uvs and normals are stored from the first that differs from the position's;
     * an empty array means that all are the same. */
    ARRAY(uint32_t) corners[OBJ_KINDS];
    ARRAY(obj_run) runs;
    ARRAY(polygon_fan) polygons;
    obj_strokes strokes[OBJ_STROKES];
    double lower[3], upper[3]; /* of the positions */
    obj_tally tallies[OBJ_TALLIES];
    bool colored; /* some vertex has a colour */
} obj_piece;

/* A material name, or none (slot 0). */
typedef struct obj_slot {
    fathom_id material;
    uint32_t same_as; /* the first slot with this material */
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
    ARRAY(obj_slot) slots;    /* 1 + index into names */
    float *values[OBJ_KINDS]; /* total[] of them, then 16 bytes of padding */
    bool adopted[OBJ_KINDS];  /* values[] belong to the scene */
    float *colors;            /* linear RGB of each vertex, white where it has none; NULL: none has */
    fathom_id colored;        /* the material where vertices have colours and elements no material */
    vec3_f64 origin;
    bool moving; /* vertices are stored a second time, from the origin */
} obj_reader;

/* The kinds of statements. */
typedef enum obj_statement {
    OBJ_S_EMPTY, /* comments too */
    OBJ_S_POSITION,
    OBJ_S_UV,
    OBJ_S_NORMAL,
    OBJ_S_FACE,
    OBJ_S_LINE,
    OBJ_S_POINT,
    OBJ_S_NAME, /* g and o, which change nothing here */
    OBJ_S_SMOOTHING,
    OBJ_S_MATERIAL,
    OBJ_S_LIBRARY,
    OBJ_S_UNKNOWN
} obj_statement;

/* The statement at *p, which moves past its keyword. */
obj_statement obj_classify(const char **p);

/* Reads the group of an s statement from `p`, after the keyword; false when it is invalid. */
bool obj_smoothing_group(const char *p, uint32_t *group);

/* The start of the next line. A backslash joins lines, but not comments. */
const char *obj_next(obj_statement statement, const char *p, const char *end);

/* Reads the libraries and finds the material of each name. */
fathom_status obj_find_materials(obj_reader *r);
/* Vertices and triangles; then polygons, which need the vertices. */
fathom_status obj_parse(obj_reader *r);
/* Gives the piece indices of a kind that equal those of the positions, as far as it has none. False without
 * memory. */
bool obj_keep_indices(obj_piece *piece, int kind);
fathom_status obj_smooth(obj_reader *r);
fathom_status obj_build(obj_reader *r);
/* What a mesh has of its material, the reader's options and the file. facts: of the vertices. */
fathom_status obj_add_mesh(const obj_reader *r, uint32_t slot, fathom_mesh *mesh, mesh_facts facts);
/* Points and lines as spheres and thin rods. *added: whether there are any. A file of vertices alone is
 * a cloud of points. */
fathom_status obj_add_strokes(obj_reader *r, bool *added);

#endif
