/* The scene as tracers need it: float coordinates near the origin, and one level of instances.
 *
 * world_create() subtracts an origin near the view in double before it rounds to float, makes an instance for
 * every mesh with another origin, and flattens nested groups. Embree's ids follow from the order here:
 * geometry i of a group is geomID i of its Embree scene; in the root, instance k is geomID groups[0].count +
 * k. */
#pragma once

#include "math/affine.h"
#include "scene/motion/motion.h"
#include "scene/scene.h"

/* Coordinates of primitives and of ray origins must be smaller: Embree leaves out primitives beyond
 * 1.8e18. */
#define WORLD_REACH 1e18

/* The largest magnitude of a coordinate; NaN if a coordinate is not finite. */
static inline float world_reach_of(vec3_f32 p) {
    float x = fabsf(p.x), y = fabsf(p.y), z = fabsf(p.z), larger = y > z ? y : z;
    return (x > larger ? x : larger) + (p.x * 0 + p.y * 0 + p.z * 0);
}

/* If the surface of a large sphere passes near the origin, float coordinates there are finer than those of
 * its centre and its radius. The sphere is then center + center_rest and radius + radius_rest, with twice the
 * digits of float (world.c). For other spheres the rests are 0. */
typedef struct world_sphere {
    vec3_f32 center;
    float radius;
    vec3_f32 center_rest;
    float radius_rest;
} world_sphere;

/* Exact: the sums fit in double. */
static inline vec3_f64 world_sphere_center(const world_sphere *s) {
    return add_f64(widen(s->center), widen(s->center_rest));
}
static inline double world_sphere_radius(const world_sphere *s) {
    return (double)s->radius + (double)s->radius_rest;
}
static inline bool world_sphere_is_split(const world_sphere *s) {
    return (s->radius_rest != 0) | (s->center_rest.x != 0) | (s->center_rest.y != 0) |
           (s->center_rest.z != 0);
}

/* The bytes that a point of a cloud takes in a world, as a sphere. */
#define WORLD_POINT_BYTES (sizeof(world_sphere) + sizeof(fathom_id))

/* Corners in order. Split as Embree splits its QUAD: triangles (0,1,3) and (2,3,1). */
typedef struct world_quad {
    vec3_f32 corner[4];
} world_quad;

/* normal is a unit vector; the plane consists of the points P with normal·P = offset. Every hit needs the
 * squared length of the normal rounded to float, and the direction of that normal; these are computed
 * once. */
typedef struct world_plane {
    double square;
    vec3_f64 unit;
    vec3_f32 normal;
    float offset;
    vec3_f32 point, u, v; /* a point on it and two unit tangents */
    fathom_id object, material;
    unsigned flags;
    bool passes; /* light may pass it straight */
} world_plane;

static inline void world_plane_set_normal(world_plane *plane, vec3_f64 normal) {
    const vec3_f64 rounded = widen(narrow(normal));
    plane->normal = narrow(normal);
    plane->square = dot_f64(rounded, rounded);
    plane->unit = scale_f64(1 / sqrt(plane->square), rounded);
}

typedef enum world_kind { WORLD_SPHERES, WORLD_QUADS, WORLD_MESH } world_kind;

/* One Embree geometry: a run of spheres or quads, a cloud of points as spheres, or a mesh. */
typedef struct world_geometry {
    world_kind kind;
    uint32_t first, count; /* spheres, quads: the run in their array; mesh: first = index into meshes, count =
                              triangles */
    unsigned flags;        /* FATHOM_CASTS_NO_SHADOW… of every primitive in it */
    bool smooth;           /* a mesh with shading normals */
    float largest;         /* the largest magnitude of a coordinate within WORLD_REACH; see world_survey() */
    uint32_t flat;         /* number of primitives without area: never hit */
    fathom_id instance;    /* the scene's instance that placed it, if it joined the root's geometries; else
                              FATHOM_NONE */
    fathom_id material;    /* override of that instance, or FATHOM_NONE */
    uint32_t moving;       /* a mesh whose vertices move: 1 + index into vertex_motions; else 0 */
    uint32_t cloud;        /* spheres that are the points of a mesh: 1 + index into meshes; else 0 */
} world_geometry;

/* Motion as tracers need it: `steps` states at uniform times of the shutter interval [0, 1]. */
typedef struct world_motion {
    uint32_t steps;      /* >= 2 */
    motion_parts *parts; /* one per step */
    bool linear;         /* some neighbours turn by more than 3 degrees: matrices are interpolated */
} world_motion;

typedef struct world_vertex_motion {
    uint32_t steps;
    float *positions; /* vertex_count x y z for each step, then readable padding */
    float *normals;   /* normal_count x y z for each step; NULL: none */
} world_vertex_motion;

#define WORLD_STEPS_MOST 129u /* Embree's limit */

typedef struct world_group {
    uint32_t first, count; /* geometries */
} world_group;

typedef struct world_instance {
    uint32_t group;
    fathom_id material; /* override, or FATHOM_NONE */
    fathom_id id; /* the scene's instance that placed the group (the innermost of nested ones); FATHOM_NONE
                     for an instance that world_create() made for a mesh of the root group */
    float to_world[3][4];
    float to_object[3][4];
    uint32_t moving;             /* 1 + index into motions, and the maps are those at time 0; else 0 */
    float to_object_error[3][3]; /* upper bound of the difference from the linear part of a tracer that
                                    inverts to_world itself in float */
} world_instance;

typedef struct world {
    const fathom_scene *scene;
    vec3_f64 origin; /* the tracer's coordinates are world coordinates minus this */
    ARRAY(world_sphere) spheres;
    ARRAY(fathom_id) sphere_objects; /* parallel to spheres */
    ARRAY(world_quad) quads;
    ARRAY(fathom_id) quad_objects; /* parallel to quads */
    ARRAY(world_plane) planes;
    ARRAY(fathom_mesh)
    meshes; /* as in the scene, but the instances already contain the origins; points of clouds are also in
               spheres */
    ARRAY(mesh_facts) mesh_facts;  /* parallel to meshes */
    ARRAY(fathom_id) mesh_objects; /* parallel to meshes */
    ARRAY(world_geometry) geometries;
    ARRAY(world_group) groups; /* 0: the geometries of the root itself */
    ARRAY(world_instance) instances;
    ARRAY(world_motion) motions;
    ARRAY(world_vertex_motion) vertex_motions;
    ARRAY(float *)
    still_vertices; /* owned arrays: of meshes with keys that do not move while the shutter is open, and of
                       meshes that were carried into the world (world_carry.c) */
    uint64_t carried_bytes;        /* of the carried meshes in still_vertices */
    bool moves;                    /* some geometry or instance moves */
    bool one_sided;                /* some material is, so tracers prefer sides that face the ray; see
                                      search_rank(). Cleared where the nearest hit is wanted */
    double motion_error;           /* the largest error of motions that need too many steps; 0: none */
    fathom_id motion_error_of;     /* the scene's instance */
    bool *absent;                  /* by object of the scene: true if it is in no geometry; see absent.h */
    uint64_t degenerate_triangles; /* without area: stored, never hit */
    uint64_t beyond_reach; /* primitives with a coordinate whose magnitude is not below WORLD_REACH, in their
                              group's space: stored, but Embree leaves them out */
} world;

/* The mesh of a geometry of the kind WORLD_MESH. */
static inline const fathom_mesh *world_mesh(const world *w, uint32_t geometry) {
    return &w->meshes.items[w->geometries.items[geometry].first];
}

/* The scene must have passed fathom_scene_check() and must outlive the world. */
fathom_status world_create(const fathom_scene *scene, world **out);
/* The same with the root's coordinates relative to `origin`, wherever the scene lies. Shows the rounding
 * errors of float for a scene that is not moved near the origin. NULL: the origin that world_create()
 * chooses. */
fathom_status world_create_from(const fathom_scene *scene, const vec3_f64 *origin, world **out);
void world_destroy(world *w);

/* ---- motion: positions at a time of the shutter interval [0, 1] ---- */

/* The matrix of a step, rounded to float. */
affine_f64 world_motion_map(const world_motion *motion, uint32_t step);
/* Sets *moved to a moving instance as it is at a time. */
void world_move_instance(const world *w, const world_instance *instance, float time, world_instance *moved);
/* The instance at a time: *moved, which is set, if it moves. */
static inline const world_instance *world_instance_when(const world *w, uint32_t instance, float time,
                                                        world_instance *moved) {
    const world_instance *at = &w->instances.items[instance];
    if (!at->moving) return at;
    world_move_instance(w, at, time, moved);
    return moved;
}
/* The corners of a triangle of a mesh, and their normals unless `normal` is NULL or the mesh has none. */
void world_corners_when(const world *w, const world_geometry *geometry, uint32_t triangle, float time,
                        vec3_f32 corner[3], vec3_f32 normal[3]);

/* Call after changing numbers in a world. Reads its meshes again and repeats the counts of world_create().
 * Indices must stay in range. */
fathom_status world_survey(world *w);

/* Sets to_world, to_object and to_object_error of an instance. False when the map has no inverse. */
bool world_instance_set(world_instance *instance, const affine_f64 *to_world);

/* True when the bound to_object_error holds for a tracer that inverts to_world itself in float. */
bool world_instance_fits_float(const world_instance *instance);

/* FATHOM_BAD_INPUT when the camera cannot see anything of the scene: no primitive has an area, or the camera
 * is not within WORLD_REACH. Warns about lights inside spheres. */
fathom_status world_check(const world *w);
/* No shape is FATHOM_CASTS_NO_SHADOW. */
bool world_casts_all_shadows(const world *w);

/* Object and material of a primitive. geometry: index into geometries. instance: index into instances, or
 * FATHOM_NONE. */
fathom_id world_object(const world *w, uint32_t geometry, uint32_t primitive);
/* The index of a primitive within its object: the triangle or the point of a mesh, else 0. */
uint32_t world_primitive(const world *w, uint32_t geometry, uint32_t primitive);
fathom_id world_material(const world *w, uint32_t geometry, uint32_t primitive, uint32_t instance);
/* True if light may pass surfaces of the material, or FATHOM_NONE, straight. */
bool world_material_passes(const world *w, fathom_id material);
/* By geometry, 1: light may pass some of its surfaces straight, in its group or in an instance of that. NULL:
 * out of memory. Release with free(). */
uint8_t *world_passing(const world *w);
