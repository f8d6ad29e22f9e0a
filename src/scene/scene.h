/* The scene as plain arrays and integer handles. */
#ifndef SCENE_SCENE_H
#define SCENE_SCENE_H

#include "base/array.h"
#include "base/file.h"
#include "base/status.h"
#include "math/affine.h"
#include "scene/mesh/mesh_facts.h"

#include <fathom/read.h>
#include <fathom/texture.h>

typedef enum scene_kind { SCENE_SPHERE, SCENE_QUAD, SCENE_PLANE, SCENE_MESH } scene_kind;

/* The meaning of a shape's id: item `index` of the array of its kind, in `group`. */
typedef struct scene_object {
    scene_kind kind;
    uint32_t index;
    fathom_id group;
    const char *name; /* the scene's; NULL: none */
} scene_object;

/* Memory that lives as long as the scene: copied arrays, mapped files. */
typedef struct scene_blob {
    void *data;
    void (*release)(void *data);
    file_map map; /* where data owns one; else zero */
} scene_blob;

/* A camera that a node of the file holds. */
typedef struct scene_camera {
    char *name;     /* of the node; NULL when it has none */
    char *own_name; /* of the camera, which several nodes may hold; NULL when it has none */
    bool orthographic;
} scene_camera;

typedef struct scene_named_material {
    fathom_material value;
    fathom_material classic; /* what the classic integrator takes for it: `value` itself if it is classic */
    char *name;              /* NULL when it has none */
} scene_named_material;

#define LIGHT_GROUPS 32 /* at most, "rest" included */
#define LIGHT_GROUP_NAME 32
#define LIGHT_GROUP_REST "rest"

typedef struct light_group_names {
    uint32_t count; /* 0: only the rest */
    char names[LIGHT_GROUPS][LIGHT_GROUP_NAME];
} light_group_names;

typedef struct scene_grouped_light {
    fathom_light_source source;
    fathom_id id;
    uint8_t group; /* of the names */
} scene_grouped_light;

struct fathom_scene {
    fathom_context *context;
    char *name; /* never NULL */
    const char
        *top; /* while it is read: the file given by the user, in whose folder all others lie; or NULL */
    ARRAY(scene_named_material) materials;
    ARRAY(fathom_light) lights;       /* all but environments */
    ARRAY(fathom_light) environments; /* their files' names belong to the scene */
    ARRAY(fathom_texture) textures;   /* their texts and bytes belong to the scene */
    ARRAY(char *) groups;             /* names, NULL for none; group 0 is the root */
    ARRAY(scene_object) objects;
    ARRAY(fathom_sphere) spheres;
    ARRAY(fathom_quad) quads;
    ARRAY(fathom_plane) planes;
    ARRAY(fathom_mesh) meshes;
    ARRAY(mesh_facts) mesh_facts; /* parallel to meshes */
    ARRAY(fathom_instance) instances;
    ARRAY(scene_blob) blobs;
    fathom_camera camera;
    bool has_camera;
    double camera_aspect; /* the width over the height of the images that the file's camera is made for, where
                             the camera itself has no width; 0: any */
    ARRAY(scene_camera) cameras;       /* that the file has to choose from */
    uint32_t camera_taken;             /* of them; FATHOM_NONE: none */
    const fathom_read_options *asked;  /* while it is read: what was asked for; or NULL */
    bool has_animations, has_variants; /* some file has them */
    light_group_names light_groups;
    ARRAY(scene_grouped_light) grouped_lights; /* later ones go before earlier ones */
    float background[3], ambient[3];
    /* Said by the file, even if it said none: nothing is added by completing. */
    bool has_ambient, has_background, has_lights;
    bool has_shutter; /* scene JSON gives the camera one */
    /* Its lights, ambient light and background were made by fathom_scene_complete(). Under path tracing the
     * studio is there in their place; this is the way up in it. */
    bool in_studio;
    bool lights_made; /* and ambient light, by fathom_scene_complete(); none were added */
    vec3_f64 studio_up;
    struct {
        bool camera, lights, background, ambient;
    } made; /* by fathom_scene_complete(); writers leave it out */
    fathom_framing framing;
    bool without_uvs; /* texture coordinates are not taken where no material has a use for them */
    bool has_maps;    /* some material takes parameters from images */
    bool uses_uvs;    /* or stretches reflections along u */
    fathom_settings settings;
    char *tracer; /* of the settings; NULL: none */
};

/* The same scene for calls on another context: messages and warnings go there, and its number of threads
 * counts. Owns nothing, and is good as long as the scene. */
fathom_scene scene_through(const fathom_scene *scene, fathom_context *context);

/* Gives `data` to the scene, which calls release(data) when it is destroyed, or at once when it is out of
 * memory. */
fathom_status scene_adopt(fathom_scene *scene, void *data, void (*release)(void *data));
/* The same for data that owns a mapped file. */
fathom_status scene_adopt_file(fathom_scene *scene, void *data, void (*release)(void *data),
                               const file_map *map);

/* malloc'ed memory owned by the scene, with 16 readable bytes past the end as Embree wants of a vertex
 * buffer. */
fathom_status scene_allocate(fathom_scene *scene, size_t bytes, void **out);
/* The same for `count` items of so many bytes each. */
fathom_status scene_allocate_items(fathom_scene *scene, size_t count, size_t bytes, void **out);

/* fathom_scene_add_mesh_shared() for readers that have looked at every vertex and index themselves: a file's
 * many meshes over the same vertices would have them all looked at again for each. */
fathom_status scene_add_mesh_checked(fathom_scene *scene, fathom_id group, const fathom_mesh *mesh,
                                     const mesh_facts *facts, fathom_id *out);
/* Checks the keys of vertices and normals; *facts come to hold for every key. */
fathom_status mesh_check_vertex_keys(fathom_context *context, const fathom_mesh *m, mesh_facts *facts);

/* The material with this name, FATHOM_NONE when there is none. */
fathom_id scene_find_material(const fathom_scene *scene, const char *name);

/* True when some parameter comes from an image. */
bool material_has_maps(const fathom_material *material);
/* True when it asks for the way of u on the surface. */
bool material_is_directed(const fathom_material *material);
/* The opacity, or with a cutoff 0 or 1. */
float material_opacity(const fathom_material *material);

/* Texture coordinates of what is added now are kept. Materials come before the shapes that wear them. */
static inline bool scene_keeps_uvs(const fathom_scene *scene) {
    return !scene->without_uvs || scene->uses_uvs;
}

/* True when paths meet none of the lights, because they were made up, and the studio or a shining background
 * replaces them. */
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

/* In the group's own coordinates; planes have no bounds and are left out. Vertices that are not finite do not
 * count. */
scene_bounds scene_object_bounds(const fathom_scene *scene, fathom_id object);
/* The bounds of everything that is placed in the world, instances included. The scene must have no cycle. */
fathom_status scene_world_bounds(const fathom_scene *scene, scene_bounds *out);

/* Triangles of all meshes, points of all clouds, and everything that a ray can meet; each counted once. */
uint64_t scene_triangles(const fathom_scene *scene);
uint64_t scene_points(const fathom_scene *scene);
uint64_t scene_primitives(const fathom_scene *scene);

/* Arrays of meshes: read by tracers, by shading, by nothing. */
enum { SCENE_TRACED = 1, SCENE_SHADED = 2, SCENE_UNREAD = 4, SCENE_BUFFERS = 7 };

/* The bytes of these arrays of all meshes; shared bytes count once. The spheres that a world makes of points
 * are among what is traced. */
fathom_status scene_buffer_bytes(const fathom_scene *scene, unsigned which, uint64_t *out);
/* Releases the memory under the scene's mapped files, except what tracers read of these meshes. Pages that
 * are read again come back. */
fathom_status scene_rest_files(const fathom_scene *scene, const fathom_mesh *traced, size_t count);
/* fathom_scene_check_files(), about once a second of calls: *next is 0 at first. */
fathom_status scene_watch_files(const fathom_scene *scene, double *next);

/* A number that differs between scenes that may render differently. It covers everything that pixels may
 * depend on: shapes, materials, lights, places, camera and surroundings; not names, texture coordinates or
 * settings. Reads all arrays of all meshes, on the context's threads. */
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

/* FATHOM_BAD_INPUT names what is out of range. */
fathom_status scene_check_settings(fathom_context *context, const fathom_settings *settings);
fathom_status scene_check_material(fathom_context *context, const fathom_material *material);

#endif
