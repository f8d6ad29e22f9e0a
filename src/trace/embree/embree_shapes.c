/* Our shapes in Embree's BVH: bounds, and callbacks that call the hand-written intersectors. */
#include "trace/embree/embree.h"
#include "trace/search.h"

#include <string.h>

/* ---- bounds ----
 * A box must contain every point at which the intersector can report a hit; otherwise Embree skips a
 * primitive that linear search hits. With u = 2^-24, |f| the distance from the ray's origin and S the
 * primitive's size:
 *
 * Sphere, S = R: hit or miss is decided as in double, so the line of a reported hit intersects the true
 * sphere, and Embree's own slack covers the rest. But the hit point has an error: if sphere_plain() is sure
 * in float, |δD| <= 36 u |f| √(R² + l²) <= 51 u |f| R, so |P - C|² <= R² + |δD| and P lies within 26 u |f| of
 * the sphere.
 *
 * Quad and triangle, S = the longest side: the edge functions are exact on sheared corners. A sheared
 * coordinate has an error of at most u |f| from the difference, 2 u |f| from the shear's ratio and u |f| each
 * from product and difference: 5 u |f| along each of two axes, 8 u |f| together, and no more along the third.
 *
 * The margin S 2^-12 + |c| 2^-19, |c| the largest coordinate, is at least 26 u |f| if |f| is below 157 S or
 * below 1.2 |c|: the shape subtends more than a third of a degree, or the ray starts closer to it than the
 * world's origin is. Beyond, the error of a sphere's point along the ray is |δ√D| <= √|δD|, at most 7.2 √(u R
 * / |f|) |f| / 5 = 1.44 √(u / 157) |f| < 2^-15 |f|. This is half the window in which embree_settle.c keeps
 * every candidate, so the closest hit is still right. */
static float margin(float size, float coordinate) { return size * 0x1p-12f + coordinate * 0x1p-19f; }

static void bounds_set(struct RTCBounds *out, vec3_f32 lower, vec3_f32 upper, float m) {
    out->lower_x = nextafterf(lower.x - m, -INFINITY), out->upper_x = nextafterf(upper.x + m, INFINITY);
    out->lower_y = nextafterf(lower.y - m, -INFINITY), out->upper_y = nextafterf(upper.y + m, INFINITY);
    out->lower_z = nextafterf(lower.z - m, -INFINITY), out->upper_z = nextafterf(upper.z + m, INFINITY);
}

/* Rounding C - R and C + R costs u (|C| + R), a 32nd of the margin. The second part of a split sphere is
 * smaller. */
static void cluster_bounds(const struct RTCBoundsFunctionArguments *args) {
    const sphere_clusters *all = args->geometryUserPtr;
    const sphere_cluster *c = &all->items[args->primID];
    vec3_f32 lower = {INFINITY, INFINITY, INFINITY}, upper = {-INFINITY, -INFINITY, -INFINITY};
    for (int k = 0; k < CLUSTER; ++k) {
        const vec3_f32 at = {c->x[k], c->y[k], c->z[k]};
        const float r = c->radius[k] + margin(c->radius[k], largest_f32(at));
        lower = vec_f32(fminf(lower.x, at.x - r), fminf(lower.y, at.y - r), fminf(lower.z, at.z - r));
        upper = vec_f32(fmaxf(upper.x, at.x + r), fmaxf(upper.y, at.y + r), fmaxf(upper.z, at.z + r));
    }
    bounds_set(args->bounds_o, lower, upper, 0);
}

/* A shape with a corner that is not finite can never be hit. Embree skips it because its box is invalid. */
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

static void packet_record(const struct RTCIntersectFunctionNArguments *args, uint32_t primitive, packet p,
                          unsigned i, const reference_hit_f32 *hit, vec3_f32 normal) {
    embree_call *call = (embree_call *)args->context;
    float *row = p.ray + EMBREE_RAY_ROWS * p.n + i;
    uint32_t *id = (uint32_t *)(void *)row;
    row[EMBREE_ROW_NG * p.n] = normal.x, row[(EMBREE_ROW_NG + 1) * p.n] = normal.y,
                        row[(EMBREE_ROW_NG + 2) * p.n] = normal.z;
    row[EMBREE_ROW_U * p.n] = hit->u, row[EMBREE_ROW_V * p.n] = hit->v;
    id[EMBREE_ROW_PRIMITIVE * p.n] = primitive;
    id[EMBREE_ROW_GEOMETRY * p.n] = args->geomID;
    id[EMBREE_ROW_INSTANCE * p.n] = call->context.instID[0];
    p.ray[EMBREE_ROW_T_FAR * p.n + i] =
        call->raw ? hit->t : embree_offer(call, packet_lane(p, i), row, p.n, hit->t);
}

/* The open end of the ray's interval: Embree's t_far is the last float inside. */
static float packet_end(packet p, unsigned i) {
    uint32_t bits;
    memcpy(&bits, &p.ray[EMBREE_ROW_T_FAR * p.n + i], sizeof bits);
    bits += bits < 0x7f800000u;
    float end;
    memcpy(&end, &bits, sizeof end);
    return end;
}

/* A quad or a triangle. */
typedef struct shape {
    bool quad;
    vec3_f32 corner[4];
} shape;

/* `quad` is a constant in each callback, so that each contains only one shape's code. */
#define ALWAYS_INLINE static inline __attribute__((always_inline))

ALWAYS_INLINE shape shape_of(bool quad, const void *first, uint32_t primitive) {
    shape s = {.quad = quad};
    if (quad)
        memcpy(s.corner, ((const world_quad *)first)[primitive].corner, sizeof s.corner);
    else
        search_corners(first, primitive, s.corner);
    return s;
}

ALWAYS_INLINE bool shape_met(const shape *s, packet p, unsigned i, reference_hit_f32 *hit) {
    const vec3_f32 org = packet_vector(p, EMBREE_ROW_ORG, i), dir = packet_vector(p, EMBREE_ROW_DIR, i);
    const float t_near = p.ray[EMBREE_ROW_T_NEAR * p.n + i], t_far = packet_end(p, i);
    const vec3_f32 *v = s->corner;
    return s->quad ? quad_robust_f32(v[0], v[1], v[2], v[3], org, dir, t_near, t_far, hit)
                   : triangle_robust_f32(v[0], v[1], v[2], org, dir, t_near, t_far, hit);
}

ALWAYS_INLINE vec3_f32 shape_normal(const shape *s) {
    const vec3_f32 *v = s->corner;
    return cross_f32(sub_f32(v[1], v[0]), sub_f32(v[s->quad ? 3 : 2], v[0]));
}

ALWAYS_INLINE void packet_closest(const struct RTCIntersectFunctionNArguments *args, bool quad) {
    const shape s = shape_of(quad, args->geometryUserPtr, args->primID);
    packet p = {(float *)(void *)args->rayhit, args->N};
    reference_hit_f32 hit;
    for (unsigned i = 0; i < p.n; ++i)
        if (args->valid[i] && shape_met(&s, p, i, &hit))
            packet_record(args, args->primID, p, i, &hit, shape_normal(&s));
}

ALWAYS_INLINE void packet_any(const struct RTCOccludedFunctionNArguments *args, bool quad) {
    const shape s = shape_of(quad, args->geometryUserPtr, args->primID);
    packet p = {(float *)(void *)args->ray, args->N};
    reference_hit_f32 hit;
    for (unsigned i = 0; i < p.n; ++i)
        if (args->valid[i] && shape_met(&s, p, i, &hit)) p.ray[EMBREE_ROW_T_FAR * p.n + i] = -INFINITY;
}

#define CALLBACKS(name, quad)                                                                                \
    static void name##_closest(const struct RTCIntersectFunctionNArguments *args) {                          \
        packet_closest(args, quad);                                                                          \
    }                                                                                                        \
    static void name##_any(const struct RTCOccludedFunctionNArguments *args) { packet_any(args, quad); }

CALLBACKS(quad, true)
CALLBACKS(triangle, false)

/* ---- clusters of spheres ---- */

/* One ray of a packet and the spheres of a cluster that it may hit, by the reference intersector. */
typedef struct meeting {
    const sphere_clusters *all;
    const sphere_cluster *cluster;
    packet p;
    unsigned i;
    vec3_f32 org, dir;
    cluster_roots roots;
    uint32_t left; /* bits: spheres still to test */
} meeting;

static inline void meet(meeting *m, const void *all, uint32_t primitive, packet p, unsigned i) {
    m->all = all, m->cluster = &m->all->items[primitive], m->p = p, m->i = i;
    m->org = packet_vector(p, EMBREE_ROW_ORG, i), m->dir = packet_vector(p, EMBREE_ROW_DIR, i);
    m->all->kernels->cluster(m->cluster, p.ray + i, p.n, &m->roots);
    m->left = (m->roots.met | m->roots.doubt) & m->cluster->lanes;
}

/* Finds the next hit in the ray's present interval. False: none. */
static inline bool next_hit(meeting *m, const world_sphere **sphere, uint32_t *primitive, float *t) {
    const float t_near = m->p.ray[EMBREE_ROW_T_NEAR * m->p.n + m->i], t_far = packet_end(m->p, m->i);
    while (m->left) {
        const unsigned k = (unsigned)__builtin_ctz(m->left);
        const float both[2] = {m->roots.near[k], m->roots.far[k]};
        m->left &= m->left - 1;
        *primitive = m->cluster->primitive[k], *sphere = &m->all->spheres[*primitive];
        if (m->roots.doubt >> k & 1 ? search_sphere_robust_f32(*sphere, m->org, m->dir, t_near, t_far, t)
                                    : sphere_choose_f32(both, t_near, t_far, t))
            return true;
    }
    return false;
}

static void cluster_closest(const struct RTCIntersectFunctionNArguments *args) {
    const packet p = {(float *)(void *)args->rayhit, args->N};
    for (unsigned i = 0; i < p.n; ++i) {
        const world_sphere *sphere;
        uint32_t primitive;
        reference_hit_f32 hit = {0, 0, 0};
        meeting m;
        if (!args->valid[i]) continue;
        meet(&m, args->geometryUserPtr, args->primID, p, i);
        while (next_hit(&m, &sphere, &primitive, &hit.t))
            packet_record(args, primitive, p, i, &hit,
                          madd_f32(sub_f32(m.org, sphere->center), hit.t, m.dir));
    }
}

static void cluster_any(const struct RTCOccludedFunctionNArguments *args) {
    const embree_context *context = (const embree_context *)args->context;
    const packet p = {(float *)(void *)args->ray, args->N};
    for (unsigned i = 0; i < p.n; ++i) {
        const world_sphere *sphere;
        uint32_t primitive;
        float t;
        meeting m;
        if (!args->valid[i]) continue;
        meet(&m, args->geometryUserPtr, args->primID, p, i);
        while (next_hit(&m, &sphere, &primitive, &t)) {
            if (m.all->passing && embree_lets_pass(m.all->passing, primitive, context->instID[0])) {
                ((uint32_t *)(void *)p.ray)[EMBREE_ROW_FLAGS * p.n + i] |= TRACE_PASSED_SOME;
                continue;
            }
            p.ray[EMBREE_ROW_T_FAR * p.n + i] = -INFINITY;
            break;
        }
    }
}

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

RTCGeometry embree_user_geometry(const embree_tracer *tracer, uint32_t index) {
    const world *w = tracer->base.world;
    const world_geometry *geometry = &w->geometries.items[index];
    switch (geometry->kind) {
    case WORLD_SPHERES: {
        const sphere_clusters *clusters = &tracer->clusters[index];
        return user_geometry(tracer->device, clusters, clusters->count, cluster_bounds, cluster_closest,
                             cluster_any);
    }
    case WORLD_QUADS:
        return user_geometry(tracer->device, &w->quads.items[geometry->first], geometry->count, quad_bounds,
                             quad_closest, quad_any);
    case WORLD_MESH: break;
    }
    return user_geometry(tracer->device, &w->meshes.items[geometry->first], geometry->count, triangle_bounds,
                         triangle_closest, triangle_any);
}
