/* Scenes from plain arrays.
 *
 * A scene owns plain arrays and hands out integer ids. Lengths share one unit of your choice; angles are
 * radians; colours are linear Rec.709; positions are double, and are moved near the view's origin before
 * they become float. Structs are copied unless a call says `_shared`. Fill them with their
 * `_default` function first, then set what you need: later versions add fields. base.h explains the calls
 * that end in `_sized`.
 *
 * Between renders you may add more, and set the camera, background, ambient light, names and light groups
 * again. You cannot change or remove what you added: build another scene. */
#ifndef FATHOM_SCENE_H
#define FATHOM_SCENE_H

#include <fathom/base.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fathom_scene fathom_scene;
typedef uint32_t fathom_id;

#define FATHOM_NONE UINT32_MAX /* no id */
#define FATHOM_ROOT 0u         /* the group that every scene starts with: the world */

FATHOM_API fathom_status fathom_scene_create(fathom_context *context, fathom_scene **out);
FATHOM_API void fathom_scene_destroy(fathom_scene *scene);

/* ---- materials ---- */

typedef enum fathom_specular {
    FATHOM_SPECULAR_NONE,  /* k_s is not used */
    FATHOM_SPECULAR_PHONG, /* k_s max(0, v·r)^n */
    FATHOM_SPECULAR_BLINN  /* k_s max(0, n·h)^n */
} fathom_specular;

/* Which members a material has. The others have no effect. */
typedef enum fathom_model {
    FATHOM_MODEL_CLASSIC,           /* k_a to lit_from_behind */
    FATHOM_MODEL_METALLIC_ROUGHNESS /* ior, and base_color to double_sided: glTF 2.0 with extensions
                                       of its materials */
} fathom_model;

/* The parameters that an image may vary over a surface: its value there times the material's own. */
typedef enum fathom_map_kind {
    FATHOM_MAP_COLOR,        /* base_color; classic: k_d */
    FATHOM_MAP_OPACITY,      /* opacity; classic: a factor of all but k_t. k_t passes the remaining light */
    FATHOM_MAP_METALLIC,     /* metallic */
    FATHOM_MAP_ROUGHNESS,    /* roughness */
    FATHOM_MAP_EMISSIVE,     /* emissive; classic: k_e */
    FATHOM_MAP_NORMAL,       /* the shading normal: 2 rgb - 1 in the frame of tangent, bitangent and normal */
    FATHOM_MAP_TRANSMISSION, /* transmission */
    FATHOM_MAP_SPECULAR,     /* specular_factor */
    FATHOM_MAP_SPECULAR_COLOR,      /* specular_color; classic: k_s */
    FATHOM_MAP_CLEARCOAT,           /* clearcoat */
    FATHOM_MAP_CLEARCOAT_ROUGHNESS, /* clearcoat_roughness */
    FATHOM_MAP_SHININESS,           /* classic: shininess */
    FATHOM_MAP_SHEEN_COLOR,         /* sheen_color */
    FATHOM_MAP_SHEEN_ROUGHNESS,     /* sheen_roughness */
    FATHOM_MAP_ANISOTROPY, /* 2 rg - 1: direction of the anisotropy in the frame of tangent and bitangent,
                              before anisotropy_rotation; blue: factor of anisotropy */
    FATHOM_MAP_IRIDESCENCE,
    FATHOM_MAP_IRIDESCENCE_THICKNESS, /* from iridescence_thickness_min, at 0, to _max, at 1 */
    FATHOM_MAP_DIFFUSE_TRANSMISSION,
    FATHOM_MAP_DIFFUSE_TRANSMISSION_COLOR,
    FATHOM_MAP_CLEARCOAT_NORMAL, /* as FATHOM_MAP_NORMAL, of the clear coat; without it a coat is flat */
    FATHOM_MAP_BUMP,             /* a height, which tilts the shading normal by its slopes */
    FATHOM_MAPS
} fathom_map_kind;

/* An image on a surface. Texture coordinates are glTF's: u to the right, v down, (0,0) the image's upper left
 * corner. */
typedef struct fathom_map {
    fathom_id texture;  /* of fathom/texture.h; FATHOM_NONE (default): no image */
    uint32_t uv_set;    /* of meshes, 0 (default) or 1; other shapes have one */
    uint32_t channel;   /* of parameters that are one number: 0 (default) red to 3 alpha */
    bool inverted;      /* the image multiplies 1 - parameter: not of normals, directions, heights and
                           thicknesses; default false */
    float transform[6]; /* u' = t0 u + t1 v + t2, v' = t3 u + t4 v + t5; default u' = u, v' = v */
} fathom_map;

typedef struct fathom_material {
    fathom_model model; /* default FATHOM_MODEL_CLASSIC */
    float k_a[3];       /* ambient reflectance; a negative first entry (the default) means: same as k_d */
    float k_d[3];       /* Lambert reflectance, [0,1]; default 0.5 */
    float k_s[3];       /* specular reflectance; default 0 */
    float k_r[3];       /* mirror reflectance; default 0 */
    float k_t[3];       /* transmittance; default 0 */
    float k_e[3]; /* emitted radiance, measured outside any glass around the surface (inside: divided by the
                     squared index there). Lights other surfaces under path tracing; default 0 */
    float shininess;          /* the exponent n, [0, 1e9]; default 32 */
    float ior;                /* inside over outside, > 0; default 1.5. Metallic-roughness also takes 0, which
                                 reflects all of specular_color */
    fathom_specular specular; /* default FATHOM_SPECULAR_NONE */
    bool fresnel; /* k_r *= F and k_t *= 1 - F, F the dielectric Fresnel reflectance, 1 on total internal
                     reflection; without it, total internal reflection mirrors k_r + k_t; default false */
    bool lit_from_behind; /* lights behind the surface count, too, by |n·l|; default false */

    /* Metallic-roughness: colours and factors are in [0,1] unless said otherwise. */
    float base_color[3]; /* default 1 */
    float metallic;      /* default 0 */
    float roughness;     /* GGX's alpha is its square; default 0.5 */
    float
        emissive[3]; /* radiance that both sides emit, times emissive_strength; measured as k_e; default 0 */
    float emissive_strength; /* >= 0; default 1 */
    float specular_factor;   /* of the dielectric's reflectance; default 1 */
    float specular_color[3]; /* of the dielectric's reflectance at normal incidence, >= 0; default 1 */
    float transmission;      /* fraction of the dielectric's base that transmits light; default 0 */
    float thickness;         /* > 0: the mesh bounds a volume, and light refracts; 0: thin walls; default 0 */
    float attenuation_color[3]; /* what is left of white light after attenuation_distance; default 1 */
    float attenuation_distance; /* 0 (default): nothing is absorbed */
    float clearcoat, clearcoat_roughness;  /* of a clear layer over everything; default 0 */
    float sheen_color[3], sheen_roughness; /* of a layer of fibres over everything but the coat; default 0 */
    float anisotropy, anisotropy_rotation; /* stretch of reflections along the tangent; radians by which that
                                              direction is rotated towards the bitangent; default 0 */
    float iridescence;                     /* strength of a thin film; default 0 */
    float iridescence_ior;                 /* its index, [1, 5]; default 1.3 */
    float iridescence_thickness_min,
        iridescence_thickness_max; /* nanometres; without a map, max is the thickness; default 100 and 400 */
    float dispersion;              /* 20 over Abbe's number, >= 0; default 0, at most 40 counts */
    float diffuse_transmission; /* fraction of the diffuse light that leaves on the other side; default 0 */
    float diffuse_transmission_color[3]; /* default 1 */
    uint32_t priority; /* where volumes overlap, the highest priority fills the space, [0, 255]; 0 (default):
                          no priority, and ior is relative to empty space */
    float opacity;     /* coverage: the fraction of rays that hit the surface; default 1 */
    bool multiscatter; /* adds the light that rough lobes would lose without multiple scattering; default true
                        */
    float opacity_cutoff;         /* > 0: an opacity below it counts as 0, any other as 1; default 0: off */
    float normal_scale;           /* either model: factor of the x and y of FATHOM_MAP_NORMAL; default 1 */
    float clearcoat_normal_scale; /* the same of FATHOM_MAP_CLEARCOAT_NORMAL; default 1 */
    float bump_scale; /* either model: the height in units of length where FATHOM_MAP_BUMP is 1; default 1 */
    fathom_map maps[FATHOM_MAPS];
    bool double_sided; /* false: under path tracing the camera looks through the back of the surface, as if it
                          were absent there; to all other rays it has two sides. Without effect on volumes;
                          default true */
} fathom_material;

FATHOM_DEFAULT(fathom_material)

/* name: for messages, mattes (FATHOM_AOV_CRYPTO_MATERIAL) and fathom_scene_write(); may be NULL. Every scene
 * has material 0, the default, unnamed. FATHOM_BAD_INPUT: a number is not finite or out of range; parameters
 * with FATHOM_PARAMETER_SOFT, such as colours, may exceed their range. */
FATHOM_API fathom_status fathom_scene_add_material_sized(fathom_scene *scene, const char *name,
                                                         const fathom_material *material, size_t size,
                                                         fathom_id *out);
static inline fathom_status fathom_scene_add_material(fathom_scene *scene, const char *name,
                                                      const fathom_material *material, fathom_id *out) {
    return fathom_scene_add_material_sized(scene, name, material, sizeof *material, out);
}

/* ---- lights ---- */

typedef enum fathom_light_type {
    FATHOM_LIGHT_POINT,
    FATHOM_LIGHT_DIRECTIONAL,
    FATHOM_LIGHT_SPOT,
    FATHOM_LIGHT_ENVIRONMENT /* light from all directions, given by an image; path integrators only */
} fathom_light_type;

typedef struct fathom_light {
    fathom_light_type type;
    double position[3];  /* point and spot */
    double direction[3]; /* the way the light travels (spot: the cone's axis); need not be unit; default
                            (0,-1,0) */
    /* k_l: the radiance of a white diffuse surface that faces the light; for point and spot lights, at
     * distance 1. So it is 1/pi of the radiant intensity or, for directional lights, of the irradiance. For
     * environments, a factor of the image. Default 1. */
    float intensity[3];
    float
        inner_angle; /* spot: full strength within this angle from the axis; radians, [0, outer); default 0 */
    float outer_angle; /* spot: nothing beyond; radians, (inner, pi/2]; default pi/4 */

    /* The path integrator alone: lights with a size. They send out as much as those without, and the
     * camera does not see them. The classic integrator takes them without size. */
    float radius;         /* point and spot: of a sphere, which scattered rays find, and which blocks no ray;
                             points inside it get the light from its centre; default 0 */
    float angular_radius; /* directional: of the disc it fills in the sky, which scattered rays find; radians,
                             [0, pi/2); default 0 */
    /* Environment: an equirectangular image in any format that OpenImageIO reads, its radiance times
     * `intensity`; or the faces of a cube: a cross (4:3 or 3:4), a strip (6:1 or 1:6), or six files, named by
     * "<FACE>" in `file` for px nx py ny pz nz, posx negx … or right left top bottom front back. Its centre
     * lies towards -z, the up axis is y. `rotation` turns it about y, radians, counter-clockwise from above;
     * default 0. Then the shortest turn takes its top from y to `up`, which need not be unit; default
     * (0,1,0). The text is copied; renders read the image. */
    const char *file;
    double rotation;
    double up[3];
    const char
        *name; /* for files that fathom_scene_write() makes; NULL (default): none. The text is copied */
} fathom_light;

FATHOM_DEFAULT(fathom_light)
FATHOM_API fathom_status fathom_scene_add_light_sized(fathom_scene *scene, const fathom_light *light,
                                                      size_t size, fathom_id *out);
static inline fathom_status fathom_scene_add_light(fathom_scene *scene, const fathom_light *light,
                                                   fathom_id *out) {
    return fathom_scene_add_light_sized(scene, light, sizeof *light, out);
}

/* ---- light groups ---- */

typedef enum fathom_light_source {
    /* The id that fathom_scene_add_light() returned. It counts environments and other lights separately. */
    FATHOM_SOURCE_LIGHT,
    FATHOM_SOURCE_ENVIRONMENT,
    FATHOM_SOURCE_MATERIAL,  /* all emissive surfaces with this material */
    FATHOM_SOURCE_OBJECT,    /* has precedence over its material */
    FATHOM_SOURCE_BACKGROUND /* id 0 */
} fathom_light_source;

/* Puts a source of light into the group `name`, for FATHOM_AOV_LIGHT_GROUPS. Sources without a group are
 * in the group "rest". name: 1 to 31 letters of A-Z, a-z, 0-9 and _; FATHOM_BAD_INPUT: another name, or
 * more than 31 groups besides "rest"; FATHOM_BAD_USAGE: there is no such source. */
FATHOM_API fathom_status fathom_scene_set_light_group(fathom_scene *scene, fathom_light_source source,
                                                      fathom_id id, const char *name);

/* ---- shapes ----
 * Each shape belongs to a group. FATHOM_ROOT is the world; any other group appears where it is instanced. */

enum {
    FATHOM_CASTS_NO_SHADOW = 1u, /* shadow rays pass through; under path tracing only those to point, spot and
                                    directional lights. If the material has k_t 1, ior 1 and all else 0, the
                                    shape is ignored: no ray hits it */
};

/* Texture coordinates are u = phi / 2 pi and v = theta / pi, with theta the angle from +z and phi the one
 * about it, from +x towards +y. */
typedef struct fathom_sphere {
    double center[3];
    double radius; /* > 0 */
    fathom_id material;
    unsigned flags;
} fathom_sphere;

/* A planar convex quad, corners in order around it. The normal is (c1-c0)×(c3-c0). The lower edge of an
 * image is the edge from c0 to c1: texture coordinates are (0,1) at c0, (1,1) at c1, (1,0) at c2 and (0,0)
 * at c3. */
typedef struct fathom_quad {
    double corners[4][3];
    fathom_id material;
    unsigned flags;
} fathom_quad;

/* The infinite plane through `point`. Texture coordinates grow by 1 for each unit of length, from `point` on,
 * along two axes that the normal decides. */
typedef struct fathom_plane {
    double point[3];
    double normal[3]; /* need not be unit */
    fathom_id material;
    unsigned flags;
} fathom_plane;

/* Triangles over float vertices, or points, placed at `origin`: vertex i is at origin + positions[i].
 * Strides are in bytes, multiples of 4; 0 means tightly packed. normal_indices and uv_indices have 3
 * entries a triangle, as indices; NULL means the same as indices. */
typedef struct fathom_mesh {
    const float *positions; /* x y z */
    size_t position_stride;
    uint32_t vertex_count;
    const uint32_t *indices; /* 3 a triangle, tightly packed */
    uint32_t triangle_count;
    const float *normals; /* shading normals, x y z, need not be unit; NULL: flat */
    size_t normal_stride;
    uint32_t normal_count;
    const uint32_t *normal_indices;
    const float *uvs; /* u v; NULL: barycentric */
    size_t uv_stride;
    uint32_t uv_count;
    const uint32_t *uv_indices;
    double origin[3];
    fathom_id material;
    unsigned flags;
    /* An entry a vertex, by `indices`; NULL: none. Strides as above. */
    const float *uvs_1; /* u v: the second uv set */
    size_t uv_1_stride;
    const float *colors; /* linear RGB or RGBA, >= 0: factors of base_color or k_d, and of the opacity */
    size_t color_stride;
    unsigned color_channels; /* 3 (default) or 4; not read without colors */
    const float *tangents; /* x y z w: the direction of u, and the sign w of bitangent = w normal × tangent.
                              NULL: computed from the first uv set of each triangle */
    size_t tangent_stride;
    /* Motion: the vertices at `key_count` times, in ascending order; 0 (default): they do not move.
     * `positions` must be given as well, but has no effect. Between two keys vertices and normals move
     * linearly; before the first and after the last they rest. `tangents` are those of the first key, and
     * move with the triangles. */
    uint32_t key_count;
    const double *key_times;
    const float *key_positions; /* key_count times vertex_count x y z, tightly packed */
    const float *key_normals;   /* key_count times normal_count x y z; needed where there are normals */
    /* A cloud of points: every vertex is a sphere of this radius, in place of triangles. A cloud may have
     * only positions and colours. 0 (default): a mesh of triangles. */
    float point_radius;
} fathom_mesh;

FATHOM_DEFAULT(fathom_sphere)
FATHOM_DEFAULT(fathom_quad)  /* the unit square around the origin, facing +z */
FATHOM_DEFAULT(fathom_plane) /* z = 0 facing +z */
FATHOM_DEFAULT(fathom_mesh)

/* Corners center ± u ± v, facing u×v. */
FATHOM_API void fathom_quad_from_axes_sized(const double center[3], const double u[3], const double v[3],
                                            fathom_quad *out, size_t size);
static inline void fathom_quad_from_axes(const double center[3], const double u[3], const double v[3],
                                         fathom_quad *out) {
    fathom_quad_from_axes_sized(center, u, v, out, sizeof *out);
}

/* FATHOM_BAD_INPUT when a number is not finite, a radius is not positive, a colour is negative, a quad has no
 * area, is not planar or not convex, an index is out of range. FATHOM_BAD_USAGE: unknown flags. Degenerate
 * triangles are kept, counted and warned about when rendering starts. */
FATHOM_API fathom_status fathom_scene_add_sphere_sized(fathom_scene *scene, fathom_id group,
                                                       const fathom_sphere *sphere, size_t size,
                                                       fathom_id *out);
static inline fathom_status fathom_scene_add_sphere(fathom_scene *scene, fathom_id group,
                                                    const fathom_sphere *sphere, fathom_id *out) {
    return fathom_scene_add_sphere_sized(scene, group, sphere, sizeof *sphere, out);
}
FATHOM_API fathom_status fathom_scene_add_quad_sized(fathom_scene *scene, fathom_id group,
                                                     const fathom_quad *quad, size_t size, fathom_id *out);
static inline fathom_status fathom_scene_add_quad(fathom_scene *scene, fathom_id group,
                                                  const fathom_quad *quad, fathom_id *out) {
    return fathom_scene_add_quad_sized(scene, group, quad, sizeof *quad, out);
}
FATHOM_API fathom_status fathom_scene_add_plane_sized(fathom_scene *scene, fathom_id group,
                                                      const fathom_plane *plane, size_t size, fathom_id *out);
static inline fathom_status fathom_scene_add_plane(fathom_scene *scene, fathom_id group,
                                                   const fathom_plane *plane, fathom_id *out) {
    return fathom_scene_add_plane_sized(scene, group, plane, sizeof *plane, out);
}
FATHOM_API fathom_status fathom_scene_add_mesh_sized(fathom_scene *scene, fathom_id group,
                                                     const fathom_mesh *mesh, size_t size, fathom_id *out);
static inline fathom_status fathom_scene_add_mesh(fathom_scene *scene, fathom_id group,
                                                  const fathom_mesh *mesh, fathom_id *out) {
    return fathom_scene_add_mesh_sized(scene, group, mesh, sizeof *mesh, out);
}
/* The caller keeps the arrays. They must outlive the scene and must not change, because they are checked
 * only now. At least 16 bytes past the end of `positions` must be readable. */
FATHOM_API fathom_status fathom_scene_add_mesh_shared_sized(fathom_scene *scene, fathom_id group,
                                                            const fathom_mesh *mesh, size_t size,
                                                            fathom_id *out);
static inline fathom_status fathom_scene_add_mesh_shared(fathom_scene *scene, fathom_id group,
                                                         const fathom_mesh *mesh, fathom_id *out) {
    return fathom_scene_add_mesh_shared_sized(scene, group, mesh, sizeof *mesh, out);
}

/* The name of a shape in mattes (FATHOM_AOV_CRYPTO_OBJECT); the text is copied. Shapes of one name are one
 * matte. Without one, the name of the instance that places the shape counts; without that, the group's name,
 * and in the root the kind and its number: "sphere 3".
 * FATHOM_BAD_USAGE: there is no such shape. */
FATHOM_API fathom_status fathom_scene_name_object(fathom_scene *scene, fathom_id object, const char *name);

/* ---- groups and instances ---- */

/* Places `group` inside `parent` (FATHOM_ROOT, or another group: frames nest). */
typedef struct fathom_instance {
    fathom_id group;
    fathom_id parent;
    double transform[12]; /* group to parent, 3 rows of 4: p' = M p + T. Any invertible affine map. */
    fathom_id material;   /* replaces every material inside; FATHOM_NONE keeps them */
    /* Motion: the transforms at `key_count` times, in ascending order; 0 (default): `transform`, which is
     * not read otherwise. Between two keys the translation and the stretch move linearly, and the rotation
     * by the shorter way (so keys of a spin lie less than half a turn apart); before the first and after
     * the last it rests. Planes cannot move. The arrays are copied. */
    const double *key_times;
    const double *key_transforms; /* 12 numbers each, as `transform` */
    uint32_t key_count;
    const char *name; /* see fathom_scene_name_object(); NULL (default): none. The text is copied */
} fathom_instance;

FATHOM_DEFAULT(fathom_instance) /* identity, in the root */
/* name: for messages; may be NULL. */
FATHOM_API fathom_status fathom_scene_add_group(fathom_scene *scene, const char *name, fathom_id *out);
/* FATHOM_BAD_INPUT when the map cannot be inverted. A cycle of groups is found by fathom_scene_check(). */
FATHOM_API fathom_status fathom_scene_add_instance_sized(fathom_scene *scene, const fathom_instance *instance,
                                                         size_t size, fathom_id *out);
static inline fathom_status fathom_scene_add_instance(fathom_scene *scene, const fathom_instance *instance,
                                                      fathom_id *out) {
    return fathom_scene_add_instance_sized(scene, instance, sizeof *instance, out);
}

/* ---- camera and surroundings ---- */

/* A pinhole or a thin lens looking along -z of its frame. Image plane at distance d, size w × h. */
typedef struct fathom_camera {
    double origin[3];
    double x[3], y[3], z[3]; /* orthonormal, right-handed */
    double d, h;             /* > 0; default d = 1, h = 2 tan(fovy/2) for a fovy of 45 degrees */
    double w; /* > 0, or 0 (default): h times the image's width / height. Pixels are square if w is 0, or if
                 w / h equals the image's width / height */
    double lens_radius;    /* >= 0; what lies off the plane of focus is blurred; default 0: a pinhole */
    double focus_distance; /* of the plane of focus, along the view axis; > 0 if lens_radius is */
    double shutter[2]; /* it opens and closes at these times, in the unit of the keys' times. Moving things
                          are blurred between them; default 0, 0: an instant, without blur */
    /* Motion of the camera: its frames at `key_count` times, as those of instances; 0 (default): it stays. */
    uint32_t key_count;
    const double *key_times;
    const double *key_frames; /* 12 numbers each, camera to world: columns x, y, z and origin, as above */
    uint32_t blades;          /* of the aperture, a regular polygon with this many sides and its corners at
                                 lens_radius; 3 to 64, or 0 (default): round */
    double blade_rotation;    /* of the polygon, counter-clockwise as the image shows it; radians; default 0:
                                 a corner to the right */
    bool orthographic; /* parallel rays along -z from the plane through the origin. The view is h high, and as
                          wide as the image's aspect ratio needs. d has no effect; w and lens_radius must be
                          0. Default false */
    double near_clip, far_clip; /* the camera sees only what lies between planes at these distances along the
                                   view axis; mirrors, light and shadows are not clipped. far_clip >
                                   near_clip >= 0; a far_clip of 0 is none; default 0, 0: all is seen */
} fathom_camera;

FATHOM_DEFAULT(fathom_camera)
/* fovy: vertical field of view, radians, (0, pi). A valid frame comes back even when up is parallel to the
 * view, or target equals eye. */
FATHOM_API void fathom_camera_look_at_sized(const double eye[3], const double target[3], const double up[3],
                                            double fovy, fathom_camera *out, size_t size);
static inline void fathom_camera_look_at(const double eye[3], const double target[3], const double up[3],
                                         double fovy, fathom_camera *out) {
    fathom_camera_look_at_sized(eye, target, up, fovy, out, sizeof *out);
}
/* Replaces the camera. Without this call and fathom_scene_complete(), a scene has the default camera, at the
 * origin. FATHOM_BAD_INPUT: a number is out of range, or the axes are no frame. The arrays are copied. */
FATHOM_API fathom_status fathom_scene_set_camera_sized(fathom_scene *scene, const fathom_camera *camera,
                                                       size_t size);
static inline fathom_status fathom_scene_set_camera(fathom_scene *scene, const fathom_camera *camera) {
    return fathom_scene_set_camera_sized(scene, camera, sizeof *camera);
}
/* Radiance of what lies behind everything, >= 0; default black. Under path tracing it lights the scene. */
FATHOM_API fathom_status fathom_scene_set_background(fathom_scene *scene, const float rgb[3]);
/* Constant light from all directions, times k_a and without shadows, >= 0; default 0. The classic integrator
 * alone uses it. */
FATHOM_API fathom_status fathom_scene_set_ambient(fathom_scene *scene, const float rgb[3]);
/* For the headers of images and for files; default "". The text is copied. */
FATHOM_API fathom_status fathom_scene_set_name(fathom_scene *scene, const char *name);

/* Adds a camera that frames everything, and lights, if the scene has none. Under path tracing, a
 * background counts as a light, and so do emissive materials that give the scene at least a sixteenth of
 * the built-in studio's light. The scene fills 90 % of the image's width or height, whichever is reached
 * first, for the image size in its settings: see fathom_scene_set_settings(). A light that you add later
 * replaces all lights, the background and the ambient light that this call made. */
FATHOM_API fathom_status fathom_scene_complete(fathom_scene *scene);

/* Checks what can only be checked in a complete scene: cycles, absent geometry… Rendering calls it. */
FATHOM_API fathom_status fathom_scene_check(const fathom_scene *scene);

#ifdef __cplusplus
}
#endif
#endif
