/* The format of scene JSON as tables: what is allowed where, and which member of a struct it fills.
 *
 * The reader follows these tables. The tests compare scenes/fathom.schema.json with them, key by key. */
#pragma once

#include <fathom/read.h>
#include <jansson.h>

typedef enum form_kind {
    /* The same as in fathom_parameter_type. */
    FORM_BOOL,
    FORM_U32, /* uint32_t, or count of them */
    FORM_U64,
    FORM_F32,    /* float, or count of them */
    FORM_F64,    /* double, or count of them, or rows × count */
    FORM_WORD,   /* int: the index of the word in `words`, "grid|sobol" */
    FORM_WORDS,  /* unsigned: a bit for each word of `words` */
    FORM_TEXT,   /* const char *, borrowed from the document */
    FORM_TAG,    /* the key that selects this variant of a form; its value is the form's name; not stored */
    FORM_OBJECT, /* another form, read into the member itself */
    FORM_ROWS,   /* json_t *: one or more rows of `count` numbers, each checked */
    FORM_LIST,   /* json_t *: an array, whose items the reader reads by `form` */
    FORM_MAP,    /* json_t *: names, each with an object of `form` */
    FORM_MAP_OF_LISTS
} form_kind;

enum { FORM_OPEN_LOW = 1, FORM_OPEN_HIGH = 2, FORM_NO_ZERO = 4 };

/* The range of each number. All zero: any finite number. */
typedef struct form_range {
    double low, high; /* may be infinite */
    unsigned open;    /* ends that are out of range, or 0 */
} form_range;

/* The unit of a key. Magnitudes beyond [low, high] seem to be in another one; 0 is in any. */
typedef struct form_unit {
    const char *name; /* NULL: degrees. A common angle in radians seems to be in radians: telescopes and
                         search lights have angles as small as radians are */
    double low, high;
} form_unit;

typedef struct form form;

typedef struct form_key {
    const char *name; /* NULL ends a table */
    form_kind kind;
    size_t offset; /* of the member it fills */
    form_range range;
    unsigned count, rows; /* 0: a single number; a single row. FORM_LIST: the least number of items */
    bool required;
    bool nonzero;      /* the numbers are not all 0 */
    bool whole;        /* FORM_ROWS: integers */
    const char *words; /* of FORM_TEXT: a pattern that the scene checks, for the schema */
    const form *form;
    const char *meaning; /* for messages, after "a string" or the numbers; NULL: none */
    const form_unit *unit;
} form_key;

typedef enum form_rule_kind {
    FORM_NO_RULE,  /* ends a table */
    FORM_NEEDS,    /* if `key` is present, all others must be */
    FORM_EXCLUDES, /* if `key` is present, none of the others may be */
    FORM_HOLDS,    /* if `key` is present, its items have the others, which must not be next to it */
    FORM_ONE_OF,   /* exactly one of the others is present */
    /* Without these, `key` has no effect: a warning. */
    FORM_WANTS,       /* all others */
    FORM_WANTS_ONE_OF /* one or more of the others */
} form_rule_kind;

/* In a rule of a material: some mesh has opacities. */
#define FORM_OPACITIES "opacities"

typedef struct form_rule {
    form_rule_kind kind;
    const char *key;
    const char *others[7];
} form_rule;

/* An object of the document. If the form has variants, the key "type" or `tag` selects one of them. */
struct form {
    const char *name;
    int id;                      /* which variant this is: a form_light_id, form_object_id or fathom_model */
    const form_key *parts[6];    /* tables of keys */
    const form_rule *rules[4];   /* tables of rules */
    const form *const *variants; /* ended by NULL */
    const char *tag;             /* the selecting key, if not "type"; the first variant needs none */
};

/* The whole document, and its parts. Call form_prepare() before the first use: it fills in form_image and the
 * materials. Their keys are the settings and the material parameters that files may have. */
void form_prepare(void);
extern const form form_scene, form_camera, form_image, form_material, form_texture, form_light, form_object,
    form_frame, form_turn, form_camera_key, form_place_key, form_vertex_key;

/* NULL if the form has no such key. */
const form_key *form_find(const form *f, const char *name);

/* ---- structs that the forms fill ---- */

typedef struct form_frame_values {
    double origin[3], x[3], y[3], z[3];
} form_frame_values;

typedef struct form_camera_values {
    double eye[3], target[3], up[3];
    form_frame_values frame;
    double fovy, d, w, h; /* fovy in degrees */
    double orthographic;  /* height of a parallel projection */
    double lens_radius, f_stop, focal_length, focus_distance;
    uint32_t blades;
    double blade_rotation; /* degrees */
    double near_clip, far_clip;
    double shutter[2], time; /* time: of a key */
    json_t *motion;
} form_camera_values;

/* An image that a material names. */
typedef struct form_texture_values {
    const char *file, *color_space;
    int wrap_u, wrap_v, filter, channel; /* fathom_wrap, fathom_texture_filter */
    uint32_t uv_set;
    bool inverted;
    double scale[2], offset[2], rotation; /* degrees */
} form_texture_values;

/* One kind more than fathom_map has: metalness and roughness in one image, as in glTF. */
#define FORM_METALLIC_ROUGHNESS ((int)FATHOM_MAPS)

typedef struct form_material_values {
    fathom_material material; /* first: its parameters are keys */
    form_texture_values textures[FATHOM_MAPS + 1];
    const char *group;
} form_material_values;

typedef enum form_light_id {
    FORM_POINT,
    FORM_DIRECTIONAL,
    FORM_SPOT,
    FORM_SUN,
    FORM_ENVIRONMENT
} form_light_id;

typedef struct form_light_values {
    const char *name, *file, *group;
    double position[3], direction[3], target[3];
    float color[3], intensity, radiant_intensity, irradiance, radius;
    double inner_angle, outer_angle, angular_diameter, rotation; /* degrees */
    double up[3];
} form_light_values;

typedef struct form_turn_values {
    double axis[3], angle; /* degrees */
} form_turn_values;

typedef struct form_place_values {
    double translation[3], rotation[4], scale[3], matrix[16];
    form_turn_values rotate;
    form_frame_values frame;
    double time; /* of a key */
} form_place_values;

typedef struct form_vertex_values {
    double time;
    json_t *positions, *normals;
} form_vertex_values;

typedef enum form_object_id {
    FORM_SPHERE,
    FORM_QUAD,
    FORM_PLANE,
    FORM_TRIANGLE,
    FORM_MESH,
    FORM_GENERATE,
    FORM_GROUP,
    FORM_INSTANCE
} form_object_id;

typedef enum form_shading { FORM_AS_GIVEN, FORM_FLAT, FORM_SMOOTH } form_shading;

typedef struct form_object_values {
    const char *name, *material, *light_group;
    bool casts_shadow;
    form_place_values place;
    json_t *motion;
    union {
        fathom_sphere sphere;
        fathom_plane plane;
        struct {
            double corners[4][3], center[3], u[3], v[3];
        } quad;
        struct {
            double vertices[3][3], normals[3][3], uvs[3][2];
        } triangle;
        struct {
            const char *file;
            json_t *positions, *indices, *normals, *uvs, *uvs_1, *colors, *opacities, *tangents, *keys;
            int shading; /* form_shading */
            float point_radius;
        } mesh;
        struct {
            int kind; /* fathom_generator */
            uint64_t triangles, seed;
        } generate;
        struct {
            json_t *children;
        } group;
        struct {
            const char *of;
        } instance;
    } as;
} form_object_values;

typedef struct form_scene_values {
    const char *schema, *name, *background_group;
    form_camera_values camera;
    fathom_settings image;
    float background[3], ambient[3];
    json_t *materials, *lights, *groups, *objects;
} form_scene_values;
