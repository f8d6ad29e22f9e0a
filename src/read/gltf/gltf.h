/* glTF 2.0: the document, the state of its reader, and the values of its JSON.
 *
 * gltf.h            what all files share
 *   gltf.c            versions, the order of the steps
 *   gltf_extensions.c which extensions are supported
 *   gltf_json.c       typed values with their place in the document
 *   gltf_choice.c     choice of an item by its name or number
 *   gltf_memory.c     limits on memory
 * gltf_data.h       arrays of numbers
 *   gltf_buffer.c     GLB chunks, the JSON text, buffers
 *   gltf_view.c       buffer views
 *   gltf_packed.c     compressed buffer views
 *   gltf_attributes.c the codec that meshoptimizer does not have
 *   gltf_accessor.c   accessors, checked, as plain arrays
 *   gltf_draco.c      compressed meshes
 * gltf_mesh.h       meshes
 *   gltf_mesh.c       converts meshes to groups
 *   gltf_shape.c      how nodes deform meshes; posed meshes that nodes share
 *   gltf_morph.c      morph targets
 *   gltf_skin.c       skins
 * gltf_material.h   materials
 *   gltf_material.c   converts materials
 *   gltf_keys.c       the keys of materials, for the reader and the writer
 *   gltf_variant.c    variants of materials
 *   gltf_texture.c    converts images and samplers to maps of materials
 *   gltf_image.c      images, and whether they can be read
 * gltf_pose.h       transforms and motion
 *   gltf_transform.c  transforms of nodes
 *   gltf_animation.c  animations, posed at a time
 *   gltf_pointer.c    animated values that are not of nodes
 *   gltf_motion.c     poses while the shutter is open
 * gltf_tree.h       nodes
 *   gltf_tree.c       the tree of nodes
 *   gltf_node.c       walks the tree; adds instances
 *   gltf_light.c      lights
 *   gltf_camera.c     cameras, and the choice of one */
#pragma once

#include "read/json/json_where.h"
#include "read/mesh/text.h"
#include "read/read.h"
#include "json/memory.h"

/* A value and its place in the document, for messages. json is NULL if the file has no such value. The value
 * that holds it must outlive it: both are local variables of the functions that walk the document. */
typedef struct gltf_value {
    json_t *json;
    where at; /* of the document itself: all 0 */
} gltf_value;

/* gltf_data.h */
typedef struct gltf_source gltf_source;
typedef struct gltf_buffer gltf_buffer;
typedef struct gltf_arrays gltf_arrays;
/* gltf_mesh.h, gltf_material.h */
typedef struct gltf_joints gltf_joints;
typedef struct gltf_shape gltf_shape;
typedef struct gltf_posed gltf_posed; /* a mesh in the shapes of one or more nodes */
typedef struct gltf_image gltf_image;
typedef struct gltf_material gltf_material;
/* gltf_pose.h, gltf_tree.h */
typedef struct gltf_moment gltf_moment;
typedef struct gltf_way gltf_way;
typedef struct gltf_link gltf_link;
typedef struct gltf_camera gltf_camera;

#define GLTF_LOST_IMAGES 8

typedef struct gltf {
    fathom_status status; /* the first failure; after it, the calls below change nothing */
    fathom_scene *scene;
    fathom_context *context;
    fathom_id group;
    const char *path;
    const read_mesh_options *options;
    gltf_source *source;
    const unsigned char *binary; /* the GLB's BIN chunk, or NULL */
    uint64_t binary_size;
    const char *text; /* the JSON */
    size_t text_at;   /* byte offset of `text` in a .glb; 0 in .gltf files */
    json_arena arena; /* memory of all values */
    gltf_value root, accessors, views, buffers, images, textures, samplers, materials, meshes, nodes, scenes,
        cameras, skins, animations;
    gltf_value extensions, punctual, lights, varying, variants; /* of the document */
    gltf_buffer *buffer_table;                                  /* for each buffer */
    gltf_image *image_table;                                    /* for each image */
    gltf_buffer *view_table;       /* for each buffer view: the decompressed bytes, if it is compressed */
    struct gltf_draco *draco;      /* meshes that are being decompressed; NULL: there are none */
    gltf_material *material_table; /* one for each material, then the default material */
    gltf_arrays *array_table;      /* one for each accessor */
    uint32_t unpacked;             /* 1 + the view that the primitive is unpacked from; 0: it is not packed */
    ARRAY(gltf_posed) posed_meshes;
    uint32_t *posed_table;      /* the hash table of posed_meshes; NULL: it is empty */
    ARRAY(gltf_link) links;     /* one for each node, in their order, then copies */
    ARRAY(uint32_t) playing;    /* animations that are posed */
    bool posed;                 /* one moment has been posed already, and its notes were added */
    size_t keys_inside;         /* maximum number of keys of a sampler while the shutter is open */
    uint32_t variant;           /* of materials; GLTF_ABSENT: none */
    ARRAY(gltf_moment) moments; /* uniform, from shutter open to close; or one */
    double *key_times;          /* the times of the moments, owned by the scene; NULL: one moment */
    uint64_t file_bytes;        /* size of the opened files */
    uint64_t charged[2];        /* bytes counted by gltf_charge(): of poses in [1], of all else in [0] */
    bool posing;                /* gltf_charge() counts bytes of poses */
    ARRAY(gltf_camera) seen_cameras;
    uint32_t lost_images[GLTF_LOST_IMAGES]; /* the first images without a file, each of which gets a note */
    unsigned lost_image_count;
    note_list notes;
    bool quiet; /* gltf_note() adds nothing, because what is read now was read for another moment */
    bool *told; /* for each node: the notes on its transform were added */
} gltf;

#define GLTF_ABSENT UINT32_MAX /* no index given */

/* ---- gltf_json.c ----
 * If a member is absent or null, getters leave *out unchanged: it holds the default. They fail with
 * FATHOM_BAD_INPUT and the place: "file:3: meshes[2].name: is a number; expected a string".
 *
 * g->status keeps the first failure. Readers then continue with the defaults, which are empty. They check
 * gltf_fine() before they use an index, call the scene or begin a long loop. */

static inline bool gltf_fine(const gltf *g) { return g->status == FATHOM_OK; }
/* The scale of the group's instance, which lengths outside meshes need too: those of cameras, lights and
 * volumes. */
static inline double gltf_unit(const gltf *g) { return g->options->unit > 0 ? g->options->unit : 1; }

/* Fills in *spot: the line in .gltf files and the byte in .glb files. `key` may be NULL: the value `at`
 * itself. */
const fathom_place *gltf_place(const gltf *g, const gltf_value *at, const char *key, where_spot *spot);
/* The same without the line or byte, which takes a search of the text. */
const fathom_place *gltf_field(const gltf *g, const gltf_value *at, where_spot *spot);
#define gltf_fail(g, at, key, ...)                                                                           \
    (gltf_fine(g)                                                                                            \
         ? ((g)->status = fail_at((g)->context, FATHOM_BAD_INPUT,                                            \
                                  gltf_place(g, at, key, &(where_spot){.place.line = 0}), __VA_ARGS__))      \
         : (g)->status)
fathom_status gltf_fail_memory(gltf *g, size_t bytes);
/* Stores the status of a call on the scene in g->status, and adds the place to its error. */
fathom_status gltf_within(gltf *g, const gltf_value *at, const char *key, fathom_status status);
/* Adds a note about a value that is skipped or read differently; see text.h. */
void gltf_note(gltf *g, const gltf_value *at, const char *key, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* The same for a node; the place has the node's name, if any. */
void gltf_note_node(gltf *g, uint32_t node, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* 1000 major + minor of the version of Blender's exporter that wrote the file ("Khronos glTF Blender I/O
 * v3.4.50"); 0: another program did. */
unsigned gltf_blender(gltf *g);

fathom_status gltf_object(gltf *g, const gltf_value *parent, const char *key, gltf_value *out);
fathom_status gltf_array(gltf *g, const gltf_value *parent, const char *key, gltf_value *out);
/* Item `index` of an array, which must be an object. */
fathom_status gltf_item(gltf *g, const gltf_value *array, size_t index, gltf_value *out);
/* The object extensions.NAME of `parent`, if it exists. `holder` receives the object `extensions`. */
fathom_status gltf_extension(gltf *g, const gltf_value *parent, const char *name, gltf_value *holder,
                             gltf_value *out);
size_t gltf_count(const gltf_value *array);
/* The steps to a value; NULL: to the document. */
static inline const where *gltf_steps(const gltf_value *v) {
    return v->at.parent || v->at.key ? &v->at : NULL;
}
/* Item `index` of an array, of any kind. */
static inline gltf_value gltf_entry(const gltf_value *array, size_t index) {
    return (gltf_value){json_array_get(array->json, index), {gltf_steps(array), NULL, index}};
}
/* The name of a node, a mesh…; NULL: none. */
static inline const char *gltf_name(const json_t *of) {
    return json_string_value(json_object_get(of, "name"));
}

/* A number in [lowest, highest]. Any other number is clamped to the range, with a note. */
fathom_status gltf_number(gltf *g, const gltf_value *parent, const char *key, double lowest, double highest,
                          double *out);
/* The same for exactly n numbers. */
fathom_status gltf_numbers(gltf *g, const gltf_value *parent, const char *key, size_t n, double lowest,
                           double highest, double *out);
fathom_status gltf_integer(gltf *g, const gltf_value *parent, const char *key, uint64_t lowest,
                           uint64_t highest, uint64_t *out);
/* An index into `into`; -1 means none, and adds a note. */
fathom_status gltf_index(gltf *g, const gltf_value *parent, const char *key, const gltf_value *into,
                         uint32_t *out);
/* The same for item i of an array of indices. */
fathom_status gltf_index_item(gltf *g, const gltf_value *array, size_t i, const gltf_value *into,
                              uint32_t *out);
fathom_status gltf_text(gltf *g, const gltf_value *parent, const char *key, const char **out);
/* The index of a text among "a|b|c". Fails with "expected `expected`" if it is none of them, or missing while
 * `missing` is -1. */
int gltf_word(gltf *g, const gltf_value *parent, const char *key, const char *words, const char *expected,
              int missing);
fathom_status gltf_flag(gltf *g, const gltf_value *parent, const char *key, bool *out);

/* ---- gltf_extensions.c ---- */

/* FATHOM_BAD_INPUT if the file requires an extension that is not supported. */
void gltf_extensions_check(gltf *g);
/* True when the file requires the extension. */
bool gltf_requires(const gltf *g, const char *name);
/* Adds notes on null values inside v and on extensions that are not supported but change the image. The
 * parser limits the depth. */
void gltf_extensions_note(gltf *g, const gltf_value *v);

/* ---- gltf_memory.c ---- */

/* Counts memory (below 2^40 bytes) that a value takes beyond the document and its files: as that of poses
 * while g->posing. FATHOM_BAD_INPUT if the sum is too large compared with the size of the files. */
fathom_status gltf_charge(gltf *g, const gltf_value *at, const char *key, uint64_t bytes);
/* scene_allocate(), after gltf_charge() for the same bytes. */
fathom_status gltf_allocate(gltf *g, const gltf_value *at, const char *key, uint64_t bytes, void **out);

/* ---- gltf_choice.c ---- */

#define GLTF_LIST 192 /* bytes */
/* 0 "Walk", 1 "Run" and 7 more */
void gltf_print_names(const gltf_value *array, char out[GLTF_LIST]);
/* The item with this name, or else with this number. FATHOM_BAD_USAGE, with a list of the names, if there is
 * no such item or there are several. what: "animation". */
uint32_t gltf_choose(gltf *g, const gltf_value *array, const char *what, const char *wanted);
