/* The scene as plain arrays and integer handles. */
#pragma once

#include "base/array.h"
#include "base/file.h"
#include "base/status.h"
#include "math/affine.h"
#include "scene/mesh/mesh_facts.h"

#include <fathom/read.h>
#include <fathom/texture.h>

typedef enum scene_kind { SCENE_SPHERE, SCENE_QUAD, SCENE_PLANE, SCENE_MESH } scene_kind;

/* A shape, by its id: item `index` of the array of its kind, in `group`. */
typedef struct scene_object {
    scene_kind kind;
    uint32_t index;
    fathom_id group;
    const char *name; /* owned by the scene; NULL: none */
} scene_object;

#define SCENE_NUMBERED 32
/* Kind and number of a shape without a name, such as "sphere 3". */
const char *scene_numbered(const scene_object *object, char out[SCENE_NUMBERED]);

/* Memory that lives as long as the scene: copied arrays, mapped files. */
typedef struct scene_blob {
    void *data;
    void (*release)(void *data);
    file_map map; /* if `data` owns a mapped file; else zero */
} scene_blob;

/* A camera that a node of the file holds. */
typedef struct scene_camera {
    const char *name;     /* of the node; NULL when it has none */
    const char *own_name; /* of the camera, which several nodes may hold; NULL when it has none */
    bool orthographic;
} scene_camera;

/* Parts of a scene that can turn out to be wrong after reading: an instance that moves, an environment, a
 * texture, its color space, its alpha. */
typedef enum scene_part {
    SCENE_PART_MOVED,
    SCENE_PART_ENVIRONMENT,
    SCENE_PART_TEXTURE,
    SCENE_PART_COLOR_SPACE,
    SCENE_PART_ALPHA
} scene_part;

/* The place in the scene's file that gives a part: for messages. */
typedef struct scene_origin {
    scene_part part;
    fathom_id id;       /* of the instance, environment or texture */
    fathom_place place; /* the scene owns its texts */
} scene_origin;

typedef struct scene_named_material {
    fathom_material value;
    fathom_material classic; /* for the classic integrator; equal to `value` if that is classic */
    const char *name;        /* NULL when it has none */
} scene_named_material;

#define LIGHT_GROUPS 32 /* at most, "rest" included */
#define LIGHT_GROUP_NAME 32
#define LIGHT_GROUP_REST "rest"

typedef struct light_group_names {
    uint32_t count; /* 0: only the group "rest" */
    char names[LIGHT_GROUPS][LIGHT_GROUP_NAME];
} light_group_names;

typedef struct scene_grouped_light {
    fathom_light_source source;
    fathom_id id;
    uint8_t group; /* index into the names */
} scene_grouped_light;

struct fathom_scene {
    fathom_context *context;
    char *name; /* never NULL */
    const char
        *top; /* while it is read: the file that the user gave; all others lie in its folder. Or NULL */
    ARRAY(scene_named_material) materials;
    ARRAY(fathom_light) lights;       /* all but environments */
    ARRAY(fathom_light) environments; /* the scene owns their file names */
    ARRAY(fathom_texture) textures;   /* the scene owns their texts and bytes */
    ARRAY(const char *) groups;       /* names, NULL for none; group 0 is the root */
    ARRAY(scene_object) objects;
    ARRAY(fathom_sphere) spheres;
    ARRAY(fathom_quad) quads;
    ARRAY(fathom_plane) planes;
    ARRAY(fathom_mesh) meshes;
    ARRAY(mesh_facts) mesh_facts; /* parallel to meshes */
    ARRAY(fathom_instance) instances;
    ARRAY(scene_origin) origins; /* of some parts */
    ARRAY(scene_blob) blobs;
    fathom_camera camera;
    bool has_camera;
    double camera_aspect; /* width / height of the images for which the file's camera is made, if the camera
                             itself has no width; 0: any */
    ARRAY(scene_camera) cameras;      /* the cameras of the file */
    uint32_t camera_taken;            /* index of the chosen one; FATHOM_NONE: none */
    const fathom_read_options *asked; /* while the scene is read: the options of the caller; or NULL */
    bool has_animations, has_variants, has_scenes; /* some file has them; scenes: of glTF */
    bool hides; /* a file has shapes that are hidden, or scaled to nothing at this time: none may be left */
    double played[2]; /* the times, with 0, between which the animations that are played move something */
    light_group_names light_groups;
    ARRAY(scene_grouped_light) grouped_lights; /* later ones override earlier ones */
    float background[3], ambient[3];
    /* The file specifies these, even if it specifies none: fathom_scene_complete() then adds nothing. */
    bool has_ambient, has_background, has_lights;
    bool has_shutter; /* scene JSON gives a shutter interval */
    /* fathom_scene_complete() made the lights, the ambient light and the background. Path tracing uses the
     * studio in their place, with studio_up as its up direction. */
    bool in_studio;
    vec3_f64 studio_up;
    struct {
        bool camera, lights, background, ambient;
    } made; /* what fathom_scene_complete() made and no call has replaced; writers leave it out */
    fathom_framing framing;
    bool without_uvs; /* texture coordinates are not kept if no material uses them */
    bool has_maps;    /* some material takes parameters from textures */
    bool uses_uvs;    /* some material uses textures, or anisotropy along u */
    fathom_settings settings;
    char *tracer; /* the text of settings.tracer, owned; NULL: none */
};

/* A view of the same scene for calls on another context, which then gets messages and warnings and sets the
 * number of threads. It owns nothing and is valid as long as the scene. */
fathom_scene scene_through(const fathom_scene *scene, fathom_context *context);

/* Transfers ownership of `data` to the scene, which calls release(data) when it is destroyed, or at once when
 * out of memory. */
fathom_status scene_adopt(fathom_scene *scene, void *data, void (*release)(void *data));
/* The same for data that owns a mapped file. */
fathom_status scene_adopt_file(fathom_scene *scene, void *data, void (*release)(void *data),
                               const file_map *map);

/* Replaces the text, which may be NULL, by a copy that the scene owns. */
fathom_status scene_own_text(fathom_scene *scene, const char **text);

/* Allocates memory that the scene owns. 16 bytes past its end are readable, as Embree requires of a vertex
 * buffer. */
fathom_status scene_allocate(fathom_scene *scene, size_t bytes, void **out);
/* The same for `count` items of `bytes` bytes each. */
fathom_status scene_allocate_items(fathom_scene *scene, size_t count, size_t bytes, void **out);

/* fathom_scene_add_mesh_shared() for readers that have already checked every vertex and index. A file may
 * have many meshes with the same vertices, which would all be checked again for each mesh. */
fathom_status scene_add_mesh_checked(fathom_scene *scene, fathom_id group, const fathom_mesh *mesh,
                                     const mesh_facts *facts, fathom_id *out);
/* Checks the keys of vertices and normals, and extends *facts to all keys. */
fathom_status mesh_check_vertex_keys(fathom_context *context, const fathom_mesh *m, mesh_facts *facts);

/* True when some parameter comes from a texture. */
bool material_has_maps(const fathom_material *material);
/* True when images of this kind of map hold colours. */
bool material_map_is_color(int kind);
/* True if light of point, directional and spot lights should pass what has the material as if it were not
 * there: it covers nothing, or transmits more than half of the light, through its thickness, and does not
 * scatter it. Such light has no other way through smooth glass; through rough glass and past what is covered
 * in part it has. With path tracing it also has one through thin walls: shadow rays pass smooth ones. */
bool material_is_clear(const scene_named_material *material, fathom_integrator integrator);
/* True when the material needs the tangent (direction of u) of the surface. */
bool material_is_directed(const fathom_material *material);
/* True when the vertices of some mesh have opacities. */
bool scene_has_opacities(const fathom_scene *scene);
/* True if the surface neither reflects nor transmits light, as unlit ones of glTF: vertex colours multiply
 * its emission. */
bool material_only_emits(const fathom_material *material);
/* True if the camera looks through the back of the surface. */
bool material_is_one_sided(const fathom_material *material);
/* The opacity; with a cutoff it is 0 or 1. */
float material_opacity(const fathom_material *material);
/* A thin wall that is clear where it is smooth. */
bool material_is_pane(const fathom_material *material);
/* False: no light passes its surfaces straight, unless vertex colours have alpha. */
bool material_may_pass(const fathom_material *material);

/* True when texture coordinates of meshes that are added now are kept. Materials must be added before the
 * shapes that use them. */
static inline bool scene_keeps_uvs(const fathom_scene *scene) {
    return !scene->without_uvs || scene->uses_uvs;
}

/* True when path tracing ignores the lights: fathom_scene_complete() made them, and the studio or an emitting
 * background replaces them. */
bool scene_replaces_lights(const fathom_scene *scene);

/* The material of a shape. */
fathom_id scene_object_material(const fathom_scene *scene, fathom_id object);

typedef struct scene_bounds {
    vec3_f64 lower, upper; /* lower > upper: empty */
} scene_bounds;

scene_bounds bounds_empty(void);
bool bounds_is_empty(const scene_bounds *b);
void bounds_add(scene_bounds *b, vec3_f64 p);
void bounds_join(scene_bounds *b, const scene_bounds *other);
scene_bounds bounds_transformed(const scene_bounds *b, const affine_f64 *map);
vec3_f64 bounds_center(const scene_bounds *b);
/* i in [0, 8). */
vec3_f64 bounds_corner(const scene_bounds *b, int i);
/* Half the diagonal. */
double bounds_radius(const scene_bounds *b);

/* Bounds in the group's own coordinates. Planes have no bounds: the result is empty. Vertices that are not
 * finite do not count. */
scene_bounds scene_object_bounds(const fathom_scene *scene, fathom_id object);
/* The same, but of a cloud without its stray points: what the automatic camera shows. */
scene_bounds scene_framed_bounds(const fathom_scene *scene, fathom_id object);
/* The bounds of everything in the world, including instances. The scene must have no cycle. */
fathom_status scene_world_bounds(const fathom_scene *scene, scene_bounds *out);

/* The numbers of triangles of all meshes, of points of all clouds, and of all primitives that a ray can hit.
 * Instances do not multiply them. */
uint64_t scene_triangles(const fathom_scene *scene);
uint64_t scene_points(const fathom_scene *scene);
uint64_t scene_primitives(const fathom_scene *scene);
/* The number of instances and meshes that move, and of cameras. */
size_t scene_moving(const fathom_scene *scene);

/* The use of mesh arrays: read by tracers, read by shading, read by neither. */
enum { SCENE_TRACED = 1, SCENE_SHADED = 2, SCENE_UNREAD = 4, SCENE_BUFFERS = 7 };

/* The bytes of all mesh arrays of these uses; shared bytes count once. SCENE_TRACED includes the spheres that
 * a world makes from points. */
fathom_status scene_buffer_bytes(const fathom_scene *scene, unsigned which, uint64_t *out);
/* Drops the pages of the scene's mapped files from memory, except those that tracers read of the meshes
 * `traced`. Pages that are read again are loaded again. */
fathom_status scene_rest_files(const fathom_scene *scene, const fathom_mesh *traced, size_t count);
/* Calls fathom_scene_check_files() at most once a second. *next is 0 before the first call. */
fathom_status scene_watch_files(const fathom_scene *scene, double *next);

/* A hash that differs between scenes that may render differently. It covers everything on which pixels may
 * depend: shapes, materials, images, lights and light groups, transforms, camera and surroundings. It leaves
 * out settings and other names, and texture coordinates and tangents that no material uses. Reads all other
 * mesh arrays and all image files, on the context's threads. */
fathom_status scene_fingerprint(const fathom_scene *scene, uint64_t *out);

/* FATHOM_BAD_INPUT when groups contain each other; the message names the groups on the cycle. */
fathom_status scene_check_cycles(const fathom_scene *scene);

/* The pixels that are rendered: the crop, or all. */
typedef struct settings_region {
    uint32_t x, y, width, height;
} settings_region;

static inline settings_region settings_region_of(const fathom_settings *s) {
    const uint32_t *c = s->crop; /* from x0, y0 to x1, y1; all zero: none */
    if (!c[2]) return (settings_region){0, 0, s->width, s->height};
    return (settings_region){c[0], c[1], c[2] - c[0], c[3] - c[1]};
}

static inline uint64_t settings_pixels(const fathom_settings *s) {
    const settings_region r = settings_region_of(s);
    return (uint64_t)r.width * r.height;
}

/* Keeps a copy of the place in the scene's file that gives the part, for messages. */
fathom_status scene_origin_add(fathom_scene *scene, scene_part part, fathom_id id, const fathom_place *place);
/* The place in the scene's file that gives the part; NULL: it is not known. */
const fathom_place *scene_origin_find(const fathom_scene *scene, scene_part part, fathom_id id);

/* FATHOM_BAD_INPUT about an instance: at its field in the file where it has one, else by number and name. */
fathom_status scene_fail_instance(const fathom_scene *scene, fathom_id instance, const char *text);

/* FATHOM_BAD_INPUT: a value is out of range; the message names it. */
fathom_status scene_check_settings(fathom_context *context, const fathom_settings *settings);
/* True if n x n samples can be so many. */
bool settings_spp_is_square(uint32_t spp);
fathom_status scene_check_material(fathom_context *context, const fathom_material *material);

/* Converts a metallic-roughness material to the classic model. */
void metallic_to_classic(const fathom_material *material, fathom_material *out);

/* A textured material as one without textures, for decisions about the whole surface before any lookup: *out
 * reflects, transmits and emits light in every way in which some point of the textured surface does. Each
 * number that an image changes gets a value inside its range, not an end at which a lobe vanishes. An image
 * multiplies a number, or raises it towards 1 (fathom_map.inverted). Without images, *out is the material
 * itself. */
void mapped_between(const fathom_material *material, fathom_material *out);
/* The same by the classic model. */
void mapped_between_classic(const fathom_material *material, fathom_material *out);
