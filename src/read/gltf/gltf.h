/* glTF 2.0: what the gltf*.c files share.
 *
 * gltf.c            versions, extensions, the order of the steps
 * gltf_json.c       typed values with their place in the document
 * gltf_buffer.c     GLB chunks, the JSON text, buffers
 * gltf_view.c       parts of buffers, and what is unpacked of them
 * gltf_accessor.c   typed arrays in buffers, checked, as plain arrays; limits on memory
 * gltf_draco.c      meshes that are compressed
 * gltf_mesh.c       meshes to groups
 * gltf_morph.c      morph targets
 * gltf_skin.c       skins
 * gltf_animation.c  animations, posed at a time
 * gltf_motion.c     poses while the shutter is open
 * gltf_transform.c  where nodes are
 * gltf_variant.c    variants of materials
 * gltf_choice.c     what there is to choose from by name
 * gltf_material.c   materials to the model's
 * gltf_texture.c    images and samplers, as maps of materials
 * gltf_node.c       the hierarchy, its instances
 * gltf_light.c      lights
 * gltf_camera.c     cameras, and which one is taken */
#ifndef READ_GLTF_H
#define READ_GLTF_H

#include "base/file.h"
#include "read/mesh/text.h"
#include "read/read.h"
#include "json/memory.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "glTF buffers are little-endian and used in place");

/* A value and its place in the document, for messages. json is NULL if the file has no such value. The parent
 * must outlive it: places live on the stack of the functions that walk down. */
typedef struct gltf_value {
    json_t *json;
    const struct gltf_value *parent; /* NULL: the document */
    const char *key;                 /* NULL: item `index` of an array */
    size_t index;
} gltf_value;

/* The bytes of one file; given to the scene once it points into them. */
typedef struct gltf_source {
    file_map map;
    bool shared;
} gltf_source;

typedef struct gltf_buffer {
    const unsigned char *bytes; /* NULL: not loaded yet */
    uint64_t size;
    gltf_source *source; /* NULL: memory of the scene */
    bool owns_source;    /* false where source is the main file */
} gltf_buffer;

/* An accessor's elements as an array that a mesh can use: finite floats, or 32-bit indices. */
typedef struct gltf_elements {
    const void *values; /* NULL: not made yet */
    size_t stride;      /* bytes */
    uint32_t count;
    mesh_facts facts; /* the extremes, of floats with three components */
} gltf_elements;

typedef struct gltf_material {
    fathom_id id;   /* FATHOM_NONE: not made yet */
    unsigned flags; /* of the meshes that wear it */
    bool blends;    /* its alpha counts */
} gltf_material;

/* The parts of a node's transform. */
enum { GLTF_TRANSLATION, GLTF_ROTATION, GLTF_SCALE, GLTF_PARTS };
extern const char *const gltf_part_names[GLTF_PARTS];

/* The pose that an animation gives a node. */
typedef struct gltf_pose {
    double parts[GLTF_PARTS][4];
    bool given[GLTF_PARTS];
    double *weights; /* of morph targets; NULL: not animated */
    size_t weight_count;
} gltf_pose;

typedef struct gltf_world {
    bool known;
    affine_f64 to_world;
} gltf_world;

#define GLTF_MOMENTS 65 /* at most */

/* A map at each moment. */
typedef struct gltf_way {
    size_t count;
    affine_f64 at[GLTF_MOMENTS];
} gltf_way;

/* The matrices of a skin's joints, from meshes to the world, less `origin`. */
typedef struct gltf_joints {
    affine_f64 *matrices; /* NULL: not made yet */
    uint32_t count;
    vec3_f64 origin; /* the same at all moments */
} gltf_joints;

/* The nodes at a time. */
typedef struct gltf_moment {
    double time; /* seconds */
    ARRAY(gltf_pose) poses;
    uint32_t *pose_of;  /* for each node its place in poses, counted from 1; NULL: no animation is posed */
    gltf_world *worlds; /* for each node */
    gltf_joints *skins; /* for each skin; NULL: none is made yet */
} gltf_moment;

/* How a node shapes its mesh. */
typedef struct gltf_shape {
    double *weights; /* of morph targets; owned */
    size_t weight_count;
    const gltf_joints *joints; /* NULL: no skin */
} gltf_shape;

/* A camera of a node; one for each of the scene's cameras. */
typedef struct gltf_camera {
    uint32_t node, index; /* of nodes and of cameras */
} gltf_camera;

typedef struct gltf {
    fathom_status status; /* the first failure; from then on all calls below leave things as they are */
    fathom_scene *scene;
    fathom_context *context;
    fathom_id group;
    const char *path;
    const read_mesh_options *options;
    gltf_source *source;
    const unsigned char *binary; /* the GLB's BIN chunk, or NULL */
    uint64_t binary_size;
    const char *text; /* the JSON */
    size_t text_at;   /* the byte of a .glb at which it begins; 0 in .gltf files */
    json_arena arena; /* of all values */
    gltf_value root, accessors, views, buffers, images, textures, samplers, materials, meshes, nodes, scenes,
        cameras, skins, animations;
    gltf_value extensions, punctual, lights, varying, variants; /* of the document */
    gltf_buffer *buffer_table;                                  /* for each buffer */
    gltf_buffer *image_table;        /* for each image that is a data URI: its bytes, once decoded */
    gltf_buffer *view_table;         /* for each buffer view that is compressed: unpacked */
    struct gltf_draco *draco;        /* meshes that are being unpacked; NULL: none was */
    gltf_material *material_table;   /* for each material, then the default one */
    gltf_elements (*array_table)[2]; /* for each accessor: floats, indices */
    fathom_id *mesh_table;           /* for each mesh: the group, FATHOM_NONE (not made) or GLTF_EMPTY */
    uint32_t *parents;               /* for each node; beyond all nodes: a root */
    ARRAY(uint32_t) playing;         /* animations that are posed */
    bool posed;                      /* at one moment already: what there is to note has been */
    size_t keys_inside;              /* the most that a sampler has while the shutter is open */
    uint32_t variant;                /* of materials; GLTF_ABSENT: none */
    ARRAY(gltf_moment) moments;      /* as the shutter opens, at even times, and as it closes; closed: one */
    double *key_times;               /* theirs, in memory of the scene; NULL: one moment */
    uint64_t file_bytes;             /* of the files opened */
    uint64_t charged;                /* bytes: gltf_charge() */
    ARRAY(gltf_camera) seen_cameras;
    note_list notes;
} gltf;

#define GLTF_EMPTY (FATHOM_NONE - 1) /* a mesh without a triangle */
#define GLTF_ABSENT UINT32_MAX       /* no index given */

/* ---- gltf_json.c ----
 * Getters leave *out, which holds the default, if the member is absent or null. They fail with
 * FATHOM_BAD_INPUT and the place: "file:3: meshes[2].name: is a number; expected a string".
 *
 * Failures are kept in g->status: readers go on with the defaults, which are empty, and ask gltf_fine()
 * before they use an index, call the scene or begin a long loop. */

static inline bool gltf_fine(const gltf *g) { return g->status == FATHOM_OK; }

/* A place for messages, with the memory of its path. */
typedef struct gltf_spot {
    fathom_place place;
    char path[256];
} gltf_spot;

/* Fills in *spot: the line in .gltf files and the byte in .glb files. `key` may be NULL: the value `at`
 * itself. */
const fathom_place *gltf_place(const gltf *g, const gltf_value *at, const char *key, gltf_spot *spot);
#define gltf_fail(g, at, key, ...)                                                                           \
    (gltf_fine(g)                                                                                            \
         ? ((g)->status = fail_at((g)->context, FATHOM_BAD_INPUT,                                            \
                                  gltf_place(g, at, key, &(gltf_spot){.place.line = 0}), __VA_ARGS__))       \
         : (g)->status)
fathom_status gltf_fail_memory(gltf *g, size_t bytes);
/* Takes over the status of a call of the scene, and adds the place to its error. */
fathom_status gltf_within(gltf *g, const gltf_value *at, const char *key, fathom_status status);
/* True when the file requires the extension. */
bool gltf_requires(const gltf *g, const char *name);
/* Notes something that is left out or read differently; see notes.h. */
void gltf_note(gltf *g, const gltf_value *at, const char *key, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* The same for all items of an array at once. */
void gltf_note_all(gltf *g, const gltf_value *array, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

fathom_status gltf_object(gltf *g, const gltf_value *parent, const char *key, gltf_value *out);
fathom_status gltf_array(gltf *g, const gltf_value *parent, const char *key, gltf_value *out);
/* Item `index` of an array, which must be an object. */
fathom_status gltf_item(gltf *g, const gltf_value *array, size_t index, gltf_value *out);
/* The object extensions.NAME of `parent`, if there is one. `holder` receives the object between. */
fathom_status gltf_extension(gltf *g, const gltf_value *parent, const char *name, gltf_value *holder,
                             gltf_value *out);
size_t gltf_count(const gltf_value *array);

/* In [lowest, highest]; of another number the nearest one there, which is noted. */
fathom_status gltf_number(gltf *g, const gltf_value *parent, const char *key, double lowest, double highest,
                          double *out);
/* The same for exactly n numbers. */
fathom_status gltf_numbers(gltf *g, const gltf_value *parent, const char *key, size_t n, double lowest,
                           double highest, double *out);
fathom_status gltf_integer(gltf *g, const gltf_value *parent, const char *key, uint64_t lowest,
                           uint64_t highest, uint64_t *out);
/* An index into `into`; -1 is taken as none, which is noted. */
fathom_status gltf_index(gltf *g, const gltf_value *parent, const char *key, const gltf_value *into,
                         uint32_t *out);
/* The same for item i of an array of indices. */
fathom_status gltf_index_item(gltf *g, const gltf_value *array, size_t i, const gltf_value *into,
                              uint32_t *out);
fathom_status gltf_text(gltf *g, const gltf_value *parent, const char *key, const char **out);
fathom_status gltf_flag(gltf *g, const gltf_value *parent, const char *key, bool *out);

/* ---- gltf_buffer.c ---- */

/* Opens the file, finds its chunks and parses its JSON into g->root. */
void gltf_open(gltf *g);
fathom_status gltf_buffer_load(gltf *g, uint32_t index, gltf_buffer **out);
/* Gives the buffer's bytes to the scene. Call before anything of the scene points into them. */
void gltf_buffer_share(gltf *g, gltf_buffer *buffer);
/* True when it is a data URI; its bytes, which belong to the scene. */
bool gltf_is_data(const char *uri);
void gltf_data_uri(gltf *g, const gltf_value *at, const char *uri, gltf_buffer *out);
/* The path of the image that a uri names; release it with free(). NULL: there is none, which is noted. */
char *gltf_image_path(gltf *g, const gltf_value *at, const char *uri);

/* ---- gltf_view.c ---- */

/* The bytes of a buffer view, unpacked where it is compressed, and the buffer that holds them. */
typedef struct gltf_view {
    const unsigned char *bytes;
    uint64_t length;
    gltf_buffer *buffer;
} gltf_view;

/* *at: the view, for messages. */
fathom_status gltf_view_open(gltf *g, uint32_t index, gltf_value *at, gltf_view *out);

/* ---- gltf_accessor.c ---- */

/* Component types that are accepted, as bits. */
enum {
    GLTF_TAKES_FLOAT = 1u << 0,
    GLTF_TAKES_SIGNED = 1u << 1,   /* byte and short */
    GLTF_TAKES_UNSIGNED = 1u << 2, /* ubyte and ushort */
    GLTF_TAKES_UINT = 1u << 3,
    GLTF_TAKES_QUANTIZED = GLTF_TAKES_FLOAT | GLTF_TAKES_SIGNED | GLTF_TAKES_UNSIGNED
};

/* Counts memory (below 2^40 bytes) that a value takes beyond the document and its files. FATHOM_BAD_INPUT
 * when the sum is out of proportion to the files. */
fathom_status gltf_charge(gltf *g, const gltf_value *at, const char *key, uint64_t bytes);
/* scene_allocate() for what is charged to the value. */
fathom_status gltf_allocate(gltf *g, const gltf_value *at, const char *key, uint64_t bytes, void **out);

/* The accessor that member `key` of `user` names, as an array; components and `takes` say what is expected:
 * indices with GLTF_TAKES_UINT, which are not checked, else floats. False, and *out is empty, where there is
 * no such member, or reading has failed. */
bool gltf_array_read(gltf *g, const gltf_value *user, const char *key, unsigned components, unsigned takes,
                     gltf_elements *out);

/* ---- gltf_choice.c ---- */

#define GLTF_LIST 192 /* bytes */
/* 0 "Walk", 1 "Run" and 7 more */
void gltf_print_names(const gltf_value *array, char out[GLTF_LIST]);
/* The item with this name, else this number. FATHOM_BAD_USAGE, with a list of what there is, where there is
 * none such or there are several. what: "animation". */
uint32_t gltf_choose(gltf *g, const gltf_value *array, const char *what, const char *wanted);

/* ---- gltf_variant.c ---- */

/* Sets g->variant by what is asked for. */
void gltf_variant_choose(gltf *g);
/* *material, the primitive's own, becomes that of the variant if it has one for it. */
void gltf_variant_material(gltf *g, const gltf_value *primitive, uint32_t *material);

/* ---- gltf_transform.c ---- */

/* NULL: no animation poses it. */
const gltf_pose *gltf_pose_of(const gltf_moment *m, uint32_t node);
/* g->parents must have no cycle. */
affine_f64 gltf_node_world(gltf *g, gltf_moment *m, uint32_t node);
affine_f64 gltf_compose(double parts[GLTF_PARTS][4]);
/* The last row of an affine matrix: 0 0 0 1, up to rounding. */
void gltf_check_row(gltf *g, const gltf_value *at, const char *key, const double row[4]);
/* True when a quaternion is not zero. */
bool gltf_is_rotation(const double r[4]);

/* ---- gltf_motion.c ---- */

/* How long the shutter is open, in seconds; 0: nothing is animated, or stands. */
double gltf_shutter(const gltf *g);
/* Fills in g->moments and g->key_times. */
void gltf_moments_open(gltf *g);
void gltf_moments_close(gltf *g);
/* True when the `count` shapes of one node at the moments differ. */
bool gltf_shapes_move(const gltf_shape *shapes, size_t count);
/* The node's maps to the world, at all moments. */
void gltf_node_way(gltf *g, uint32_t node, gltf_way *out);
/* The way of a thing that `inner` places inside one that goes `way`. */
void gltf_way_of(const gltf_way *way, const affine_f64 *inner, gltf_way *out);
bool gltf_way_moves(const gltf_way *way);
/* True when it is never flat, nor turned inside out on the way. */
bool gltf_way_can_blur(const gltf_way *way);
/* The scale that cameras and lights follow. */
static inline double gltf_unit(const gltf *g) { return g->options->unit > 0 ? g->options->unit : 1; }
/* For messages; "" where it has none. */
const char *gltf_name(const gltf_value *at);

/* ---- gltf_animation.c ---- */

/* Sets g->playing by what is asked for. */
void gltf_animation_choose(gltf *g);
/* Poses the nodes by g->playing at the moment's time. */
void gltf_animation_pose(gltf *g, gltf_moment *m);
/* The unit quaternion at the part u in [0,1] of the shorter arc from a to b, which become unit. */
void gltf_slerp(double a[4], double b[4], double u, double out[4]);

/* ---- gltf_morph.c, gltf_skin.c ---- */

/* Weights: posed, else the node's, else the mesh's. node may be NULL. */
void gltf_weights_read(gltf *g, const gltf_pose *pose, const gltf_value *node, const gltf_value *mesh,
                       gltf_shape *out);
/* Each replaces the floats of an attribute by new ones, if the shape moves them: in `to`, tightly packed, or
 * where that is NULL in new memory of the scene. */
void gltf_morph(gltf *g, const gltf_value *primitive, const gltf_shape *shape, const char *key,
                unsigned components, gltf_elements *floats, float *to);
typedef enum gltf_kind { GLTF_POINT, GLTF_NORMAL, GLTF_TANGENT } gltf_kind;
void gltf_skin_carry(gltf *g, const gltf_value *attributes, const gltf_joints *joints, gltf_kind kind,
                     gltf_elements *floats, float *to);
/* The joints of skin `index` at a moment of g; they live as long as it. */
const gltf_joints *gltf_skin_read(gltf *g, gltf_moment *m, uint32_t index);

/* Makes a copy of these the elements of the accessor that member `key` of `user` names, which must be
 * described by it. normalized: divided by the largest number of the accessor's type already. */
fathom_status gltf_array_give(gltf *g, const gltf_value *user, const char *key, bool integers,
                              unsigned components, bool normalized, uint32_t count, const void *values);

/* ---- gltf_draco.c ---- */

/* Unpacks a primitive that is compressed, as elements of its accessors. */
fathom_status gltf_draco_read(gltf *g, const gltf_value *primitive);
void gltf_draco_close(gltf *g);

/* The components of the accessor that member `key` of `user` names, 1 to 4; 0: there is no such member. */
unsigned gltf_components(gltf *g, const gltf_value *user, const char *key);

/* ---- what the document holds ---- */

/* The group that holds mesh `index`, made when first asked for, or GLTF_EMPTY. With shapes, one for each
 * moment: a group of its own. */
fathom_id gltf_mesh_group(gltf *g, uint32_t index, const gltf_shape *shapes);
/* The texture that member `key` of `parent` describes; color: its numbers are sRGB. False where there is none
 * or it cannot be read, which is noted. */
bool gltf_map(gltf *g, const gltf_value *parent, const char *key, bool color, fathom_map *out);
/* Material `index`; GLTF_ABSENT is the file format's default one. False: reading has failed. */
bool gltf_material_make(gltf *g, uint32_t index, gltf_material *out);
/* Walks the nodes of the scene. */
void gltf_nodes_place(gltf *g);
void gltf_light_place(gltf *g, const gltf_value *node, const gltf_way *to_world);
void gltf_camera_note(gltf *g, const gltf_value *node);
/* Gives the scene the requested camera, else the first perspective one, of those noted. */
void gltf_camera_take(gltf *g);

#endif
