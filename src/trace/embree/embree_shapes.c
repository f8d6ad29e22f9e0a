/* Our shapes in Embree's BVH: bounds and callbacks over the hand-written intersectors. */
#include "reference/reference.h"
#include "trace/embree/embree.h"
#include "trace/search.h"

#include <string.h>

/* ---- bounds ----
 * A box must hold every point at which the intersector can report a hit, or Embree skips the primitive where
 * the linear search meets it. With u = 2^-24, |f| the distance from the ray's origin and S the primitive's
 * size:
 *
 * Sphere, S = R: hit or miss is decided as double decides it, so the line of a reported hit meets the true
 * sphere, and Embree's own slack covers the rest. The point on it does stray: where the float form is sure,
 * |δD| <= 36 u |f| √(R² + l²) <= 51 u |f| R, so |P - C|² <= R² + |δD| and P lies within 26 u |f| of the
 * sphere.
 *
 * Quad and triangle, S = the longest side: the edge functions are exact on sheared corners, and a sheared
 * coordinate is off by at most u |f| from the difference, 2 u |f| from the shear's ratio, u |f| each from
 * product and difference: 5 u |f| along each of two axes, 8 u |f| together, and no more along the third.
 *
 * The margin S 2^-12 + |c| 2^-19, |c| the largest coordinate, is at least 26 u |f| as long as |f| is below
 * 157 S or below 1.2 |c|: rays from where the shape shows at more than a third of a degree, or from within
 * its own distance from the world's origin. Beyond, a sphere's point strays along the ray by |δ√D| <= √|δD|,
 * at most 7.2 √(u R / |f|) |f| / 5 = 1.44 √(u / 157) |f| < 2^-15 |f|: half the window in which
 * embree_settle.c keeps every candidate, so the closest hit is right all the same. */
static float margin(float size, float coordinate) { return size * 0x1p-12f + coordinate * 0x1p-19f; }

static void bounds_set(struct RTCBounds *out, vec3_f32 lower, vec3_f32 upper, float m) {
    out->lower_x = nextafterf(lower.x - m, -INFINITY), out->upper_x = nextafterf(upper.x + m, INFINITY);
    out->lower_y = nextafterf(lower.y - m, -INFINITY), out->upper_y = nextafterf(upper.y + m, INFINITY);
    out->lower_z = nextafterf(lower.z - m, -INFINITY), out->upper_z = nextafterf(upper.z + m, INFINITY);
}

/* C - R and C + R round by u (|C| + R), a 32nd of the margin; the second part of a split sphere is less. */
static void sphere_bounds(const struct RTCBoundsFunctionArguments *args) {
    const world_sphere *s = (const world_sphere *)args->geometryUserPtr + args->primID;
    vec3_f32 r = {s->radius, s->radius, s->radius};
    bounds_set(args->bounds_o, sub_f32(s->center, r), add_f32(s->center, r),
               margin(s->radius, largest_f32(s->center)));
}

/* A shape with a corner that is not finite is never met; a box that is none leaves it out. */
static void flat_bounds(const vec3_f32 *v, int corners, struct RTCBounds *out) {
    const vec3_f32 none = {NAN, NAN, NAN};
    vec3_f32 lower = v[0], upper = v[0];
    float coordinate = 0;
    bool finite = true;
    for (int i = 0; i < corners; ++i) {
        lower = vec_f32(fminf(lower.x, v[i].x), fminf(lower.y, v[i].y), fminf(lower.z, v[i].z));
        upper = vec_f32(fmaxf(upper.x, v[i].x), fmaxf(upper.y, v[i].y), fmaxf(upper.z, v[i].z));
        coordinate = fmaxf(coordinate, largest_f32(v[i]));
        finite &= finite_f32(v[i]);
    }
    if (finite)
        bounds_set(out, lower, upper, margin(largest_f32(sub_f32(upper, lower)), coordinate));
    else
        bounds_set(out, none, none, 0);
}

static void quad_bounds(const struct RTCBoundsFunctionArguments *args) {
    flat_bounds(((const world_quad *)args->geometryUserPtr + args->primID)->corner, 4, args->bounds_o);
}

static void triangle_bounds(const struct RTCBoundsFunctionArguments *args) {
    vec3_f32 v[3];
    search_corners(args->geometryUserPtr, args->primID, v);
    flat_bounds(v, 3, args->bounds_o);
}

/* ---- callbacks ---- */

/* The rays of a callback: rows of N numbers. */
typedef struct packet {
    float *ray;
    unsigned n;
} packet;

static vec3_f32 packet_vector(packet p, unsigned row, unsigned i) {
    return vec_f32(p.ray[row * p.n + i], p.ray[(row + 1) * p.n + i], p.ray[(row + 2) * p.n + i]);
}

static uint32_t packet_lane(packet p, unsigned i) {
    return ((const uint32_t *)(const void *)p.ray)[EMBREE_ROW_ID * p.n + i];
}

static void packet_record(const struct RTCIntersectFunctionNArguments *args, packet p, unsigned i,
                          const reference_hit_f32 *hit, vec3_f32 normal) {
    embree_call *call = (embree_call *)args->context;
    float *row = p.ray + EMBREE_RAY_ROWS * p.n + i;
    uint32_t *id = (uint32_t *)(void *)row;
    row[EMBREE_ROW_NG * p.n] = normal.x, row[(EMBREE_ROW_NG + 1) * p.n] = normal.y,
                        row[(EMBREE_ROW_NG + 2) * p.n] = normal.z;
    row[EMBREE_ROW_U * p.n] = hit->u, row[EMBREE_ROW_V * p.n] = hit->v;
    id[EMBREE_ROW_PRIMITIVE * p.n] = args->primID;
    id[EMBREE_ROW_GEOMETRY * p.n] = args->geomID;
    id[EMBREE_ROW_INSTANCE * p.n] = call->context.instID[0];
    p.ray[EMBREE_ROW_T_FAR * p.n + i] =
        call->raw ? hit->t : embree_offer(call, packet_lane(p, i), row, p.n, hit->t);
}

/* The open end of the ray's interval: t_far as Embree has it is the last float inside. */
static float packet_end(packet p, unsigned i) {
    uint32_t bits;
    memcpy(&bits, &p.ray[EMBREE_ROW_T_FAR * p.n + i], sizeof bits);
    bits += bits < 0x7f800000u;
    float end;
    memcpy(&end, &bits, sizeof end);
    return end;
}

/* One primitive of a user geometry. */
typedef struct shape {
    world_kind kind;
    const world_sphere *sphere;
    vec3_f32 corner[4]; /* of a quad or a triangle */
} shape;

/* `kind` is a constant in each callback, so that only one shape's code is left in it. */
#define ALWAYS_INLINE static inline __attribute__((always_inline))

ALWAYS_INLINE shape shape_of(world_kind kind, const void *first, uint32_t primitive) {
    shape s = {.kind = kind};
    switch (kind) {
    case WORLD_SPHERES: s.sphere = (const world_sphere *)first + primitive; break;
    case WORLD_QUADS: memcpy(s.corner, ((const world_quad *)first)[primitive].corner, sizeof s.corner); break;
    case WORLD_MESH: search_corners(first, primitive, s.corner); break;
    }
    return s;
}

ALWAYS_INLINE bool shape_met(const shape *s, packet p, unsigned i, reference_hit_f32 *hit) {
    const vec3_f32 org = packet_vector(p, EMBREE_ROW_ORG, i), dir = packet_vector(p, EMBREE_ROW_DIR, i);
    const float t_near = p.ray[EMBREE_ROW_T_NEAR * p.n + i], t_far = packet_end(p, i);
    const vec3_f32 *v = s->corner;
    switch (s->kind) {
    case WORLD_SPHERES:
        hit->u = hit->v = 0;
        return search_sphere_robust_f32(s->sphere, org, dir, t_near, t_far, &hit->t);
    case WORLD_QUADS: return quad_robust_f32(v[0], v[1], v[2], v[3], org, dir, t_near, t_far, hit);
    case WORLD_MESH: break;
    }
    return triangle_robust_f32(v[0], v[1], v[2], org, dir, t_near, t_far, hit);
}

ALWAYS_INLINE vec3_f32 shape_normal(const shape *s, packet p, unsigned i, float t) {
    const vec3_f32 *v = s->corner;
    if (s->kind == WORLD_SPHERES)
        return madd_f32(sub_f32(packet_vector(p, EMBREE_ROW_ORG, i), s->sphere->center), t,
                        packet_vector(p, EMBREE_ROW_DIR, i));
    return cross_f32(sub_f32(v[1], v[0]), sub_f32(v[s->kind == WORLD_QUADS ? 3 : 2], v[0]));
}

ALWAYS_INLINE void packet_closest(const struct RTCIntersectFunctionNArguments *args, world_kind kind) {
    const shape s = shape_of(kind, args->geometryUserPtr, args->primID);
    packet p = {(float *)(void *)args->rayhit, args->N};
    reference_hit_f32 hit;
    for (unsigned i = 0; i < p.n; ++i)
        if (args->valid[i] && shape_met(&s, p, i, &hit))
            packet_record(args, p, i, &hit, shape_normal(&s, p, i, hit.t));
}

ALWAYS_INLINE void packet_any(const struct RTCOccludedFunctionNArguments *args, world_kind kind) {
    const shape s = shape_of(kind, args->geometryUserPtr, args->primID);
    packet p = {(float *)(void *)args->ray, args->N};
    reference_hit_f32 hit;
    for (unsigned i = 0; i < p.n; ++i)
        if (args->valid[i] && shape_met(&s, p, i, &hit)) p.ray[EMBREE_ROW_T_FAR * p.n + i] = -INFINITY;
}

#define CALLBACKS(name, kind)                                                                                \
    static void name##_closest(const struct RTCIntersectFunctionNArguments *args) {                          \
        packet_closest(args, kind);                                                                          \
    }                                                                                                        \
    static void name##_any(const struct RTCOccludedFunctionNArguments *args) { packet_any(args, kind); }

CALLBACKS(sphere, WORLD_SPHERES)
CALLBACKS(quad, WORLD_QUADS)
CALLBACKS(triangle, WORLD_MESH)

/* ---- geometries ---- */

static RTCGeometry user_geometry(RTCDevice device, const void *first, uint32_t count,
                                 RTCBoundsFunction bounds, RTCIntersectFunctionN closest,
                                 RTCOccludedFunctionN any) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    if (!geometry) return NULL;
    rtcSetGeometryUserPrimitiveCount(geometry, count);
    rtcSetGeometryUserData(geometry, (void *)(uintptr_t)first);
    rtcSetGeometryBoundsFunction(geometry, bounds, NULL);
    rtcSetGeometryIntersectFunction(geometry, closest);
    rtcSetGeometryOccludedFunction(geometry, any);
    return geometry;
}

RTCGeometry embree_user_geometry(RTCDevice device, const world *w, const world_geometry *geometry) {
    switch (geometry->kind) {
    case WORLD_SPHERES:
        return user_geometry(device, &w->spheres.items[geometry->first], geometry->count, sphere_bounds,
                             sphere_closest, sphere_any);
    case WORLD_QUADS:
        return user_geometry(device, &w->quads.items[geometry->first], geometry->count, quad_bounds,
                             quad_closest, quad_any);
    case WORLD_MESH: break;
    }
    return user_geometry(device, &w->meshes.items[geometry->first], geometry->count, triangle_bounds,
                         triangle_closest, triangle_any);
}
