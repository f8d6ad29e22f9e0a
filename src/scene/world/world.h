/* The world as tracers see it: float, near the origin, one level of instances.
 *
 * world_create() subtracts the view's origin in double before anything becomes float, gives every mesh that
 * lies elsewhere a frame of its own, and flattens nested groups. Embree's ids follow from the order here:
 * geometry i of a group is geomID i of its Embree scene; in the root, instance k is geomID groups[0].count +
 * k. */
#ifndef SCENE_WORLD_H
#define SCENE_WORLD_H

#include "math/affine.h"
#include "scene/motion/motion.h"
#include "scene/scene.h"

/* Coordinates of what is traced, and of where rays start, must be smaller: Embree leaves those beyond 1.8e18
 * out. */
#define WORLD_REACH 1e18

/* The largest of its coordinates, as a magnitude; NaN for a NaN. */
static inline float world_reach_of(vec3_f32 p) {
    float x = fabsf(p.x), y = fabsf(p.y), z = fabsf(p.z), larger = y > z ? y : z;
    return (x > larger ? x : larger) + (p.x * 0 + p.y * 0 + p.z * 0);
}

/* A sphere that passes close by the origin, where coordinates are finer than its own, is center + center_rest
 * and radius + radius_rest: twice the digits of float (world.c). The rest of others is 0. */
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

/* The bytes of a point as a sphere, in a world. */
#define WORLD_POINT_BYTES (sizeof(world_sphere) + sizeof(fathom_id))

/* Corners in order. Split as Embree splits its QUAD: triangles (0,1,3) and (2,3,1). */
typedef struct world_quad {
    vec3_f32 corner[4];
} world_quad;

/* normal is unit; the plane holds the points P with normal·P = offset. Every hit needs the square of the
 * rounded normal and its direction, which are found once. */
typedef struct world_plane {
    double square;
    vec3_f64 unit;
    vec3_f32 normal;
    float offset;
    vec3_f32 point, u, v; /* a point on it and two unit tangents */
    fathom_id object, material;
    unsigned flags;
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
    uint32_t first,
        count; /* spheres, quads: where the run lies; mesh: first = index into meshes, count = triangles */
    unsigned flags;     /* FATHOM_CASTS_NO_SHADOW… of every primitive in it */
    bool smooth;        /* a mesh with shading normals */
    float largest;      /* of the coordinates within WORLD_REACH; see world_survey() */
    uint32_t flat;      /* primitives without area: never met */
    fathom_id instance; /* the instance that placed it, where its frame was left out; else FATHOM_NONE */
    fathom_id material; /* override of that instance, or FATHOM_NONE */
    uint32_t moving;    /* a mesh whose vertices move: 1 + index into vertex_motions; else 0 */
    uint32_t cloud;     /* spheres that are the points of a mesh: 1 + index into meshes; else 0 */
} world_geometry;

/* Motion is `steps` states at even times of the shutter, which is open from 0 to 1: what tracers take. */
typedef struct world_motion {
    uint32_t steps;      /* >= 2 */
    motion_parts *parts; /* of each step, the rotations less than 3 degrees apart */
} world_motion;

typedef struct world_vertex_motion {
    uint32_t steps;
    float *positions; /* vertex_count x y z for each step, and some bytes to read beyond the last */
    float *normals;   /* normal_count x y z for each step; NULL: none */
} world_vertex_motion;

#define WORLD_STEPS_MOST 129u /* Embree's */

typedef struct world_group {
    uint32_t first, count; /* geometries */
} world_group;

typedef struct world_instance {
    uint32_t group;
    fathom_id material; /* override, or FATHOM_NONE */
    fathom_id id;       /* the scene's instance that placed the group (the innermost where frames nest), or
                           FATHOM_NONE for a frame that world_create() made for a mesh of the root group */
    float to_world[3][4];
    float to_object[3][4];
    uint32_t moving;             /* 1 + index into motions, and the maps are those of time 0; else 0 */
    float to_object_error[3][3]; /* bounds how far the linear part differs from that of a tracer which inverts
                                    to_world itself, in float */
} world_instance;

typedef struct world {
    const fathom_scene *scene;
    vec3_f64 origin; /* world coordinates minus this are the tracer's */
    ARRAY(world_sphere) spheres;
    ARRAY(fathom_id) sphere_objects; /* parallel to spheres */
    ARRAY(world_quad) quads;
    ARRAY(fathom_id) quad_objects; /* parallel to quads */
    ARRAY(world_plane) planes;
    ARRAY(fathom_mesh)
    meshes;                        /* as in the scene; origins are already in the instances, and the points of
                                      clouds in the spheres, too */
    ARRAY(mesh_facts) mesh_facts;  /* parallel to meshes */
    ARRAY(fathom_id) mesh_objects; /* parallel to meshes */
    ARRAY(world_geometry) geometries;
    ARRAY(world_group) groups; /* 0: what is placed in the root itself */
    ARRAY(world_instance) instances;
    ARRAY(world_motion) motions;
    ARRAY(world_vertex_motion) vertex_motions;
    ARRAY(float *)
    still_vertices;                /* owned: of meshes with keys that rest while the shutter is open, and of
                                      those that were carried into the world */
    uint64_t carried_bytes;        /* of the latter */
    bool moves;                    /* some geometry or instance does */
    bool *absent;                  /* by object of the scene: in no geometry; see absent.h */
    uint64_t degenerate_triangles; /* without area: stored, never hit */
    uint64_t beyond_reach; /* primitives with a coordinate not below WORLD_REACH, in their group's space:
                              stored; Embree leaves them out */
} world;

/* The mesh of a geometry of the kind WORLD_MESH. */
static inline const fathom_mesh *world_mesh(const world *w, uint32_t geometry) {
    return &w->meshes.items[w->geometries.items[geometry].first];
}

/* The scene must have passed fathom_scene_check() and must outlive the world. */
fathom_status world_create(const fathom_scene *scene, world **out);
/* The same with the root's coordinates counted from `origin`, wherever the scene lies: to show what float
 * makes of a scene that is not moved near it. NULL: where world_create() counts from. */
fathom_status world_create_from(const fathom_scene *scene, const vec3_f64 *origin, world **out);
void world_destroy(world *w);

/* ---- motion: what is where at a time in [0, 1] of the shutter ---- */

/* Sets `moved` to an instance that moves, as it is at a time. */
void world_move_instance(const world *w, const world_instance *instance, float time, world_instance *moved);
/* The instance at a time, its maps in `moved` if it moves. */
static inline const world_instance *world_instance_when(const world *w, uint32_t instance, float time,
                                                        world_instance *moved) {
    const world_instance *at = &w->instances.items[instance];
    if (!at->moving) return at;
    world_move_instance(w, at, time, moved);
    return moved;
}
/* The corners of a triangle of a mesh, and its normals unless NULL or there are none. */
void world_corners_when(const world *w, const world_geometry *geometry, uint32_t triangle, float time,
                        vec3_f32 corner[3], vec3_f32 normal[3]);

/* Call after changing a world's numbers: reads its meshes again and repeats the counts of world_create().
 * Indices must stay in range. */
fathom_status world_survey(world *w);

/* Sets the three maps of an instance from its place in the world. False when there is no inverse. */
bool world_instance_set(world_instance *instance, const affine_f64 *to_world);

/* True when a tracer that inverts to_world itself, in float, gets what to_object_error says. */
bool world_instance_fits_float(const world_instance *instance);

/* FATHOM_BAD_INPUT when the scene's camera could not see anything of it: nothing has an area, or the camera
 * is out of reach. Warns of lights inside spheres. */
fathom_status world_check(const world *w);
/* No shape is FATHOM_CASTS_NO_SHADOW. */
bool world_casts_all_shadows(const world *w);

/* Object and material of a primitive. geometry: index into geometries. */
fathom_id world_object(const world *w, uint32_t geometry, uint32_t primitive);
/* A primitive's number within its object: of a mesh the triangle or the point, else 0. */
uint32_t world_primitive(const world *w, uint32_t geometry, uint32_t primitive);
fathom_id world_material(const world *w, uint32_t geometry, uint32_t primitive, uint32_t instance);

#endif
