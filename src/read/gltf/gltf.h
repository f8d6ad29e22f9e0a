/* glTF 2.0: what the gltf*.c files share.
 *
 * gltf.c            versions, the order of the steps
 * gltf_extensions.c which extensions are supported
 * gltf_json.c       typed values with their place in the document
 * gltf_buffer.c     GLB chunks, the JSON text, buffers
 * gltf_view.c       buffer views
 * gltf_packed.c     compressed buffer views
 * gltf_attributes.c the codec that meshoptimizer does not have
 * gltf_memory.c     limits on memory
 * gltf_accessor.c   accessors, checked, as plain arrays
 * gltf_draco.c      compressed meshes
 * gltf_mesh.c       converts meshes to groups
 * gltf_shape.c      how nodes deform meshes; posed meshes that nodes share
 * gltf_morph.c      morph targets
 * gltf_skin.c       skins
 * gltf_animation.c  animations, posed at a time
 * gltf_pointer.c    animated values that are not of nodes
 * gltf_motion.c     poses while the shutter is open
 * gltf_transform.c  transforms of nodes
 * gltf_variant.c    variants of materials
 * gltf_choice.c     choice of an item by its name or number
 * gltf_material.c   converts materials
 * gltf_image.c      images, and whether they can be read
 * gltf_texture.c    converts images and samplers to maps of materials
 * gltf_tree.c       the tree of nodes
 * gltf_node.c       walks the tree; adds instances
 * gltf_light.c      lights
 * gltf_camera.c     cameras, and the choice of one */
#pragma once

#include "base/file.h"
#include "read/mesh/text.h"
#include "read/read.h"
#include "json/memory.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "glTF buffers are little-endian and used in place");

/* A value and its path in the document, for messages. json is NULL if the file has no such value. The parent
 * must outlive the value: both are local variables of the functions that walk the document. */
typedef struct gltf_value {
    json_t *json;
    const struct gltf_value *parent; /* NULL: the document */
    const char *key;                 /* NULL: item `index` of an array */
    size_t index;
} gltf_value;

/* The bytes of one file; the scene owns them once it uses pointers into them. */
typedef struct gltf_source {
    file_map map;
    bool shared;
} gltf_source;

typedef struct gltf_buffer {
    const unsigned char *bytes; /* NULL: not loaded yet */
    uint64_t size;
    gltf_source *source; /* NULL: the scene owns the bytes */
    bool owns_source;    /* false if `source` is the main file */
} gltf_buffer;

typedef struct gltf_image {
    gltf_buffer data;   /* the bytes of a data URI, once decoded */
    bool tried, broken; /* tried: `broken` tells that it cannot be read */
} gltf_image;

/* An accessor's elements as an array that a mesh can use: finite floats, or 32-bit indices. */
typedef struct gltf_elements {
    const void *values; /* NULL: not made yet */
    size_t stride;      /* bytes */
    uint32_t count;
    mesh_facts facts;     /* the extremes, for floats with three components */
    uint32_t unpacked_of; /* 1 + the view that Draco unpacked them from; 0: the accessor's own elements */
} gltf_elements;

typedef struct gltf_material {
    fathom_id id;   /* FATHOM_NONE: not made yet */
    unsigned flags; /* flags of the meshes that have it */
    bool blends;    /* its alpha mode is BLEND or MASK */
} gltf_material;

/* The components of a node's transform. */
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

/* A transform at each moment. */
typedef struct gltf_way {
    size_t count;
    affine_f64 at[GLTF_MOMENTS];
} gltf_way;

/* The matrices of a skin's joints, from mesh to world space, minus `origin`. */
typedef struct gltf_joints {
    affine_f64 *matrices; /* NULL: not made yet */
    uint32_t count;
    vec3_f64 origin; /* the same at all moments */
} gltf_joints;

/* The state of the nodes at one time. */
typedef struct gltf_moment {
    double time; /* seconds */
    ARRAY(gltf_pose) poses;
    uint32_t *pose_of;  /* for each node, its index in poses plus 1; NULL: no animation is posed */
    gltf_world *worlds; /* for each link */
    gltf_joints *skins; /* one for each skin; NULL: none is made yet */
} gltf_moment;

/* How a node deforms its mesh. */
typedef struct gltf_shape {
    double *weights; /* of morph targets; owned */
    size_t weight_count;
    const gltf_joints *joints; /* NULL: no skin */
} gltf_shape;

typedef struct gltf_posed gltf_posed; /* a mesh in the shapes of one or more nodes */

/* A place of a node in the tree. Links to others are GLTF_ABSENT if there are none. */
typedef struct gltf_link {
    uint32_t node; /* its index */
    uint32_t parent;
    uint32_t child; /* the last one */
    uint32_t next;  /* the sibling before it */
} gltf_link;

/* The place and the index of a camera; one for each camera of the scene. */
typedef struct gltf_camera {
    uint32_t link, index; /* `link` into links, `index` into cameras */
} gltf_camera;

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
    /* For each accessor its own elements, then those that Draco unpacked: a compressed primitive and another
     * one may name the same accessor. Floats, then indices. */
    gltf_elements (*array_table)[2][2];
    uint32_t unpacked; /* 1 + the view that the primitive is unpacked from; 0: it is not packed */
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

#define GLTF_EMPTY (FATHOM_NONE - 1) /* a mesh without a triangle */
#define GLTF_ABSENT UINT32_MAX       /* no index given */

/* ---- gltf_json.c ----
 * If a member is absent or null, getters leave *out unchanged: it holds the default. They fail with
 * FATHOM_BAD_INPUT and the place: "file:3: meshes[2].name: is a number; expected a string".
 *
 * g->status keeps the first failure. Readers then continue with the defaults, which are empty. They check
 * gltf_fine() before they use an index, call the scene or begin a long loop. */

static inline bool gltf_fine(const gltf *g) { return g->status == FATHOM_OK; }

/* A place for messages, with a buffer for its path. */
typedef struct gltf_spot {
    fathom_place place;
    char path[256];
} gltf_spot;

/* Fills in *spot: the line in .gltf files and the byte in .glb files. `key` may be NULL: the value `at`
 * itself. */
const fathom_place *gltf_place(const gltf *g, const gltf_value *at, const char *key, gltf_spot *spot);
/* The same without the line or byte, which takes a search of the text. */
const fathom_place *gltf_field(const gltf *g, const gltf_value *at, gltf_spot *spot);
#define gltf_fail(g, at, key, ...)                                                                           \
    (gltf_fine(g)                                                                                            \
         ? ((g)->status = fail_at((g)->context, FATHOM_BAD_INPUT,                                            \
                                  gltf_place(g, at, key, &(gltf_spot){.place.line = 0}), __VA_ARGS__))       \
         : (g)->status)
fathom_status gltf_fail_memory(gltf *g, size_t bytes);
/* Stores the status of a call on the scene in g->status, and adds the place to its error. */
fathom_status gltf_within(gltf *g, const gltf_value *at, const char *key, fathom_status status);
/* Adds a note about a value that is skipped or read differently; see text.h. */
void gltf_note(gltf *g, const gltf_value *at, const char *key, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* The same for `times` items of an array, as one note. */
void gltf_note_all(gltf *g, size_t times, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* The same for a node; the place has the node's name, if any. */
void gltf_note_node(gltf *g, uint32_t node, const char *format, ...) __attribute__((format(printf, 3, 4)));

fathom_status gltf_object(gltf *g, const gltf_value *parent, const char *key, gltf_value *out);
fathom_status gltf_array(gltf *g, const gltf_value *parent, const char *key, gltf_value *out);
/* Item `index` of an array, which must be an object. */
fathom_status gltf_item(gltf *g, const gltf_value *array, size_t index, gltf_value *out);
/* The object extensions.NAME of `parent`, if it exists. `holder` receives the object `extensions`. */
fathom_status gltf_extension(gltf *g, const gltf_value *parent, const char *name, gltf_value *holder,
                             gltf_value *out);
size_t gltf_count(const gltf_value *array);

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
fathom_status gltf_flag(gltf *g, const gltf_value *parent, const char *key, bool *out);

/* ---- gltf_extensions.c ---- */

/* FATHOM_BAD_INPUT if the file requires an extension that is not supported. */
void gltf_extensions_check(gltf *g);
/* True when the file requires the extension. */
bool gltf_requires(const gltf *g, const char *name);
/* Adds notes on null values inside v and on extensions that are not supported but change the image. The
 * parser limits the depth. */
void gltf_extensions_note(gltf *g, const gltf_value *v);

/* ---- gltf_buffer.c ---- */

/* Opens the file, finds its chunks and parses its JSON into g->root. */
void gltf_open(gltf *g);
fathom_status gltf_buffer_load(gltf *g, uint32_t index, gltf_buffer **out);
/* Transfers ownership of the buffer's bytes to the scene. Call it before the scene gets pointers into
 * them. */
void gltf_buffer_share(gltf *g, gltf_buffer *buffer);
/* gltf_is_data(): true if `uri` is a data URI. gltf_data_uri(): its bytes, owned by the scene. */
bool gltf_is_data(const char *uri);
void gltf_data_uri(gltf *g, const gltf_value *at, const char *uri, gltf_buffer *out);
/* The path of the image that a uri names; release it with free(). NULL: there is no such file, which adds a
 * note. */
char *gltf_image_path(gltf *g, const gltf_value *at, const char *uri);

/* ---- gltf_view.c ---- */

/* The bytes of a buffer view, decompressed if necessary, and the buffer that holds them. */
typedef struct gltf_view {
    const unsigned char *bytes;
    uint64_t length;
    gltf_buffer *buffer;
} gltf_view;

/* The bytes that the members `buffer`, `byteOffset` and `byteLength` of `at` describe. */
void gltf_view_part(gltf *g, const gltf_value *at, gltf_view *out);
/* *at receives the view, for messages. */
fathom_status gltf_view_open(gltf *g, uint32_t index, gltf_value *at, gltf_view *out);
/* *stride: that of elements side by side, if the view has none; 0 means none to programs that write it. */
void gltf_view_stride(gltf *g, const gltf_value *view, uint64_t *stride);

/* ---- gltf_packed.c ---- */

/* Decompresses view `index` once and opens the result. False: the view is not compressed. */
bool gltf_packed_open(gltf *g, const gltf_value *view, uint32_t index, gltf_view *out);

/* ---- gltf_memory.c ---- */

/* Counts memory (below 2^40 bytes) that a value takes beyond the document and its files: as that of poses
 * while g->posing. FATHOM_BAD_INPUT if the sum is too large compared with the size of the files. */
fathom_status gltf_charge(gltf *g, const gltf_value *at, const char *key, uint64_t bytes);
/* scene_allocate(), after gltf_charge() for the same bytes. */
fathom_status gltf_allocate(gltf *g, const gltf_value *at, const char *key, uint64_t bytes, void **out);

/* ---- gltf_accessor.c ---- */

/* Component types that are accepted, as bits. */
enum {
    GLTF_TAKES_FLOAT = 1u << 0,
    GLTF_TAKES_SIGNED = 1u << 1,   /* byte and short */
    GLTF_TAKES_UNSIGNED = 1u << 2, /* ubyte and ushort */
    GLTF_TAKES_UINT = 1u << 3,
    GLTF_TAKES_QUANTIZED = GLTF_TAKES_FLOAT | GLTF_TAKES_SIGNED | GLTF_TAKES_UNSIGNED
};

/* The accessor that member `key` of `user` names, as an array with this number of components. `takes` has the
 * accepted component types: with GLTF_TAKES_UINT the elements are indices, whose range is not checked,
 * otherwise floats. False, with *out empty, if there is no such member or reading has failed. */
bool gltf_array_read(gltf *g, const gltf_value *user, const char *key, unsigned components, unsigned takes,
                     gltf_elements *out);

/* ---- gltf_choice.c ---- */

#define GLTF_LIST 192 /* bytes */
/* 0 "Walk", 1 "Run" and 7 more */
void gltf_print_names(const gltf_value *array, char out[GLTF_LIST]);
/* The item with this name, or else with this number. FATHOM_BAD_USAGE, with a list of the names, if there is
 * no such item or there are several. what: "animation". */
uint32_t gltf_choose(gltf *g, const gltf_value *array, const char *what, const char *wanted);

/* ---- gltf_variant.c ---- */

/* Sets g->variant to the requested variant. */
void gltf_variant_choose(gltf *g);
/* Replaces *material, the primitive's own, by the material of the variant, if the primitive has one. */
void gltf_variant_material(gltf *g, const gltf_value *primitive, uint32_t *material);

/* ---- gltf_transform.c ---- */

/* The pose of a node; NULL: no animation poses it. */
const gltf_pose *gltf_pose_of(const gltf_moment *m, uint32_t node);
affine_f64 gltf_node_world(gltf *g, gltf_moment *m, uint32_t link);
/* True if the node's matrix replaces the components of its transform. */
bool gltf_has_matrix(const gltf_value *node);
affine_f64 gltf_compose(double parts[GLTF_PARTS][4]);
/* Checks that the last row of a matrix is 0 0 0 1, up to rounding error. */
void gltf_check_row(gltf *g, const gltf_value *at, const char *key, const double row[4]);
/* True when a quaternion is not zero. */
bool gltf_is_rotation(const double r[4]);

/* ---- gltf_motion.c ---- */

/* How long the shutter is open, in seconds; 0 if no animation is posed. */
double gltf_shutter(const gltf *g);
/* Fills in g->moments and g->key_times. */
void gltf_moments_open(gltf *g);
void gltf_moments_close(gltf *g);
/* True when the `count` shapes of one node at the moments differ. */
bool gltf_shapes_move(const gltf_shape *shapes, size_t count);
/* The link's transforms to the world, at all moments. */
void gltf_node_way(gltf *g, uint32_t link, gltf_way *out);
/* The motion of an object with the transform `inner` inside a parent with the motion `way`. */
void gltf_way_of(const gltf_way *way, const affine_f64 *inner, gltf_way *out);
bool gltf_way_moves(const gltf_way *way);
/* True if no transform after the first is singular, and all have the same handedness. */
bool gltf_way_can_blur(const gltf_way *way);
/* The scale that applies to cameras and lights. */
static inline double gltf_unit(const gltf *g) { return g->options->unit > 0 ? g->options->unit : 1; }

/* ---- gltf_animation.c ---- */

/* Sets g->playing to the requested animations. */
void gltf_animation_choose(gltf *g);
/* Poses the nodes by g->playing at the moment's time. */
void gltf_animation_pose(gltf *g, gltf_moment *m);
/* The unit quaternion at the fraction u in [0,1] of the shorter arc from a to b. Normalises a and b. */
void gltf_slerp(double a[4], double b[4], double u, double out[4]);

/* The value of samplers[index], `components` numbers, at a time. False: reading has failed. */
bool gltf_sampler_value(gltf *g, const gltf_value *samplers, uint32_t index, unsigned components, double time,
                        double out[4]);

/* ---- gltf_pointer.c ---- */

/* Replaces the value that a JSON pointer names by the sampler's, as the shutter opens. Adds a note if no
 * reader would use the value. */
void gltf_pointer_pose(gltf *g, const gltf_value *target, const char *pointer, const gltf_value *samplers,
                       uint32_t sampler);

/* ---- gltf_shape.c ---- */

/* The group that holds mesh `mesh` as the node deforms it at all moments, or GLTF_EMPTY. Nodes that deform it
 * alike share the group. node NULL: the mesh's own weights. *joints: at the opening of the shutter; NULL: no
 * skin. */
fathom_id gltf_shape_mesh(gltf *g, const gltf_value *node, uint32_t mesh, const gltf_joints **joints);
/* Call it before gltf_moments_close(). */
void gltf_posed_close(gltf *g);

/* ---- gltf_morph.c, gltf_skin.c ---- */

/* Reads the weights: from the pose, else from the node, else from the mesh. node may be NULL. */
void gltf_weights_read(gltf *g, const gltf_pose *pose, const gltf_value *node, const gltf_value *mesh,
                       gltf_shape *out);
/* Each call replaces the floats of an attribute by deformed ones, if the shape changes them. They are tightly
 * packed in `to`, or in new memory of the scene if `to` is NULL. */
void gltf_morph(gltf *g, const gltf_value *primitive, const gltf_shape *shape, const char *key,
                unsigned components, gltf_elements *floats, float *to);
/* Adds a note for each attribute that is not deformed of the targets that a shape uses at any moment. */
void gltf_morph_note(gltf *g, const gltf_value *primitive, const gltf_shape *shapes, size_t moments);
typedef enum gltf_kind { GLTF_POINT, GLTF_NORMAL, GLTF_TANGENT } gltf_kind;
void gltf_skin_carry(gltf *g, const gltf_value *attributes, const gltf_joints *joints, gltf_kind kind,
                     gltf_elements *floats, float *to);
/* The joints of skin `index` at a moment of g; valid as long as the moment. */
const gltf_joints *gltf_skin_read(gltf *g, gltf_moment *m, uint32_t index);

/* Elements for an accessor, unpacked from a view. */
typedef struct gltf_given {
    uint32_t view, count;
    unsigned components;
    bool integers, normalized; /* normalized: already divided by the maximum of the accessor's type */
    const void *values;
} gltf_given;

/* Stores a copy of `given` as the unpacked elements of the accessor that member `key` of `user` names, until
 * elements of another view are given: primitives may share an accessor of compressed elements, since it only
 * has their type and count. Count and components must be those of the accessor. */
fathom_status gltf_array_give(gltf *g, const gltf_value *user, const char *key, const gltf_given *given);

/* ---- gltf_draco.c ---- */

/* Sets g->unpacked. Decompresses the primitive if it is compressed, and stores the result as elements of its
 * accessors. */
fathom_status gltf_draco_read(gltf *g, const gltf_value *primitive);
void gltf_draco_close(gltf *g);

/* The components of the accessor that member `key` of `user` names, 1 to 4; 0: there is no such member. */
unsigned gltf_components(gltf *g, const gltf_value *user, const char *key);

/* ---- contents of the document ---- */

/* Makes a group with mesh `index`; GLTF_EMPTY if it has no triangle. moves: there is a shape for each moment,
 * else there is one. */
fathom_id gltf_mesh_group(gltf *g, uint32_t index, const gltf_shape *shapes, bool moves);
/* Sets the image's file or bytes in *out. If there is none, adds a note. The caller frees *path. */
void gltf_image_open(gltf *g, const gltf_value *at, fathom_texture *out, char **path);
/* False, with a note that another image is used, if the image helper cannot read the image. */
bool gltf_image_opens(gltf *g, uint32_t index);
/* The texture that member `key` of `parent` describes; color: its values are sRGB. False if there is no
 * texture, or it cannot be read; the latter adds a note. */
bool gltf_map(gltf *g, const gltf_value *parent, const char *key, bool color, fathom_map *out);
/* Material `index`; GLTF_ABSENT: glTF's default material. False: reading has failed. */
bool gltf_material_make(gltf *g, uint32_t index, gltf_material *out);
/* Fills in g->links, which then have no cycle. */
void gltf_tree_open(gltf *g);
/* Walks the nodes of the scene. */
void gltf_nodes_place(gltf *g);
void gltf_light_place(gltf *g, const gltf_value *node, const gltf_way *to_world);
void gltf_camera_note(gltf *g, const gltf_value *node, uint32_t link);
/* Sets the scene's camera to the requested one of the noted cameras, else to the first perspective one. */
void gltf_camera_take(gltf *g);
