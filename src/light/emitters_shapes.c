/* Emissive primitives seen from a point.
 *
 * A shadow ray must end clear of the emitter. With u = 2^-24, n the unit normal of a face or sphere, S the
 * point on it and D the length of the ray, these are the errors as distances along n (light/light_surfaces.c
 * derives the items):
 * - The primitive's rounding errors u Σ |n_i| |c_i|, for its farthest corner c, or u (Σ |n_i| |C_i| + R); the
 * same again for S, and twice for the start of the ray, which was rounded to float before and after it was
 * moved off its surface. In an instance, the tracer's transforms to object space and back.
 * - The tracer's own error near the surface and, for a moving emitter, its error of the position at a time
 * (surface/gather.c).
 * - The ray: 32 u D, and 4 u D because the start's coordinates may exceed those of S.
 * The first two items make `clear`, the third `slope`. A point no farther than `clear` from an emitter may
 * lie on either side, and most likely on the emitter: it gets no light from it. */
#include "light/emitters_inner.h"

#include "surface/gather.h"
#include "surface/placed.h"
#include "trace/search.h"

static const double unit_round = 0x1p-24;

static vec3_f64 absolute(vec3_f64 v) { return vec_f64(fabs(v.x), fabs(v.y), fabs(v.z)); }
static double larger(double a, double b) { return a > b ? a : b; }
static double largest(vec3_f64 v) { return larger(fabs(v.x), larger(fabs(v.y), fabs(v.z))); }

static double determinant(const float rows[3][4]) {
    const affine_f64 map = affine_widen(rows);
    return affine_determinant(&map);
}

/* ---- faces ---- */

void emitters_corners(const world *w, const emitter_run *run, uint32_t primitive, float time,
                      vec3_f64 out[4]) {
    const world_geometry *g = &w->geometries.items[run->geometry];
    if (g->kind == WORLD_QUADS) {
        const world_quad *q = &w->quads.items[g->first + primitive];
        for (int k = 0; k < 4; ++k) out[k] = widen(q->corner[k]);
        return;
    }
    vec3_f32 c[3], other[3];
    const fathom_mesh *mesh = &w->meshes.items[g->first];
    if (run->paired) {
        search_corners(mesh, primitive & ~1u, c);
        search_corners(mesh, primitive | 1, other);
        emitters_join(c, other, out);
        return;
    }
    if (g->moving)
        world_corners_when(w, g, primitive, time, c, NULL);
    else
        search_corners(mesh, primitive, c);
    out[0] = widen(c[0]), out[1] = widen(c[1]), out[2] = out[3] = widen(c[2]);
}

/* at[k]: the corners in the space of the face's group, to[k]: in world space. bent: the vertices move. */
static void face_bounds(const world_instance *instance, const vec3_f64 at[4], const vec3_f64 to[4], bool bent,
                        shape_face *f) {
    vec3_f64 ab = sub_f64(at[1], at[0]), ac = sub_f64(at[3], at[0]);
    vec3_f64 n = normalize_f64(cross_f64(ab, ac)), across = absolute(n), n_world = n;
    double reach = 0, reach_world = 0, map = 0, moved = 0, length = 1,
           extent = larger(largest(ab), largest(ac));
    extent = larger(extent, largest(sub_f64(at[3], at[1])));
    if (f->quad) extent = larger(extent, largest(sub_f64(at[2], at[0])));
    f->slope = 36 * unit_round;
    if (instance) {
        n_world = placed_normal(instance->to_object, n);
        length = length_f64(n_world);
        n_world = scale_f64(1 / length, n_world);
        f->slope += 8 * unit_round * surface_stretch_along(instance, n) / length;
    }
    for (int k = 0; k < 4; ++k) {
        reach = larger(reach, dot_f64(across, absolute(at[k])));
        reach_world = larger(reach_world, dot_f64(absolute(n_world), absolute(to[k])));
        if (instance) map = larger(map, placed_carried_along(instance, n, to[k]));
        if (instance && instance->moving)
            moved = larger(moved, surface_moved_along(instance, n_world, at[k]));
    }
    if (bent) reach *= 1 + SURFACE_BENT;
    f->clear = (unit_round * reach + LOCAL_FACE_SELF_HIT * extent + map * (4 / 3.0)) / length +
               3 * unit_round * reach_world + moved;
}

void emitters_face(const emitters *e, const emitter_run *run, uint32_t primitive, float time,
                   shape_face *out) {
    const world_geometry *g = &e->w->geometries.items[run->geometry];
    world_instance moved;
    const world_instance *instance =
        run->instance == FATHOM_NONE ? NULL : world_instance_when(e->w, run->instance, time, &moved);
    vec3_f64 at[4];
    out->quad = g->kind == WORLD_QUADS || run->paired;
    emitters_corners(e->w, run, primitive, time, at);
    for (int k = 0; k < 4; ++k) out->corner[k] = instance ? placed_point(instance->to_world, at[k]) : at[k];
    face_bounds(instance, at, out->corner, g->moving, out);
}

static shape_seen see(const shape_face *f, vec3_f64 p, bool second) {
    const vec3_f64 *c = f->corner;
    return second ? shape_see(p, c[2], c[3], c[1], f->clear) : shape_see(p, c[0], c[1], c[3], f->clear);
}

double emitters_face_density(const shape_face *f, vec3_f64 p) {
    double all = see(f, p, false).angle;
    if (f->quad) all += see(f, p, true).angle;
    return shape_inverse(all);
}

/* ---- spheres ---- */

void emitters_ball(const emitters *e, const emitter_run *run, uint32_t primitive, float time,
                   emitter_ball *out) {
    const world_sphere *s = &e->w->spheres.items[e->w->geometries.items[run->geometry].first + primitive];
    out->center = world_sphere_center(s), out->radius = world_sphere_radius(s);
    out->instance =
        run->instance == FATHOM_NONE ? NULL : world_instance_when(e->w, run->instance, time, &out->moved);
    double reach = fabs(out->center.x) + fabs(out->center.y) + fabs(out->center.z) + out->radius;
    double held = world_sphere_is_split(s) ? 0 : unit_round * reach;
    out->clear = held + 8 * unit_round * out->radius + 3 * unit_round * reach;
    out->slope = 36 * unit_round;
    if (!out->instance) return;
    /* The sum is over all axes, because the normal is not known yet. */
    const vec3_f64 all = {1, 1, 1};
    vec3_f64 center = placed_point(out->instance->to_world, out->center);
    vec3_f64 top = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
        const float *m = out->instance->to_world[k];
        double size = out->radius * (fabs((double)m[0]) + fabs((double)m[1]) + fabs((double)m[2]));
        *(k == 0 ? &top.x : (k == 1 ? &top.y : &top.z)) = size;
    }
    vec3_f64 farthest = add_f64(absolute(center), top);
    double stretch = surface_stretch_along(out->instance, all);
    out->clear = held + 8 * unit_round * out->radius +
                 placed_carried_along(out->instance, all, farthest) * (4 / 3.0) +
                 3 * unit_round * stretch * largest(farthest);
    if (out->instance->moving) {
        const vec3_f64 r = {out->radius, out->radius, out->radius};
        out->clear += stretch * surface_moved_along(out->instance, all, add_f64(absolute(out->center), r));
    }
    out->slope = 44 * unit_round * stretch;
}

/* A ball and a point, in the ball's space. */
typedef struct ball_view {
    vec3_f64 from; /* the vector from the centre to the point */
    double square; /* its squared length */
    bool outside;  /* the point is clearly outside; else it is inside or on the surface */
    bool on;       /* the point is on the surface, or within rounding errors of it */
} ball_view;

static ball_view view_of(const emitter_ball *b, vec3_f64 p) {
    if (b->instance) p = placed_point(b->instance->to_object, p);
    ball_view v = {.from = sub_f64(p, b->center)};
    v.square = dot_f64(v.from, v.from);
    double d = sqrt(v.square);
    v.outside = d > b->radius + b->clear;
    v.on = !v.outside && !(d < b->radius - b->clear);
    return v;
}

static vec3_f64 to_world(const emitter_ball *b, vec3_f64 v) {
    return b->instance ? placed_vector(b->instance->to_world, v) : v;
}
static vec3_f64 to_object(const emitter_ball *b, vec3_f64 v) {
    return b->instance ? placed_vector(b->instance->to_object, v) : v;
}

/* A unit direction d in the ball's object space has the length k = |M d| in world space. The density per
 * solid angle in world space is k^3 / |det M| times the density in object space. */
static double turned_density(const emitter_ball *b, double density, double k) {
    return b->instance ? density * (k * k * k / fabs(determinant(b->instance->to_world))) : density;
}

/* For a point outside: samples the cone that the sphere covers. */
static void ask_outside(const emitter_ball *b, const ball_view *v, double s, double t, emitter_answer *out) {
    const shape_cone cone = shape_cone_of(v->from, b->radius);
    vec3_f64 d = shape_cone_sample(&cone, s, t), wide = to_world(b, d);
    double k = sqrt(dot_f64(wide, wide));
    double end = shape_sphere_root(v->from, d, b->radius + b->clear + b->slope * cone.distance * k, -1);
    out->direction = scale_f64(1 / k, wide);
    out->distance = larger(end * k, 0x1p-126);
    out->density = turned_density(b, shape_inverse(shape_cone_angle(&cone)), k);
}

/* For a point inside, light comes from all directions. A point on the surface can only see the inside of the
 * far side: a ray from it starts clear of the surface, on the side to which it goes. */
static void ask_inside(const emitter_ball *b, const ball_view *v, vec3_f64 n, double s, double t,
                       emitter_answer *out) {
    vec3_f64 wide = shape_all_sample(n, s, t), d = to_object(b, wide);
    double reach = 2 * b->radius / sqrt(dot_f64(d, d));
    double inner = b->radius - b->clear - b->slope * reach;
    double end = shape_sphere_root(v->from, d, inner > 0 ? inner : 0, 1);
    out->direction = wide;
    out->density = shape_all_density(n, wide);
    out->dark = v->on && !(dot_f64(v->from, d) < 0);
    out->distance = larger(end, 0x1p-126);
}

bool emitters_ball_is_plain(const emitter_ball *b, vec3_f64 p) {
    return !b->instance && view_of(b, p).outside;
}

void emitters_ask_ball(const emitter_ball *b, vec3_f64 p, vec3_f64 n, double u, double v,
                       emitter_answer *out) {
    const ball_view view = view_of(b, p);
    *out = (emitter_answer){.density = 0};
    if (view.outside)
        ask_outside(b, &view, u, v, out);
    else
        ask_inside(b, &view, n, u, v, out);
}

vec3_f64 emitters_ball_normal(const emitter_ball *b, vec3_f64 p, vec3_f64 direction) {
    const ball_view view = view_of(b, p);
    const vec3_f64 d = to_object(b, direction);
    const double t = shape_sphere_root(view.from, d, b->radius, view.outside ? -1 : 1);
    return normalize_f64(madd_f64(view.from, t, d));
}

double emitters_ball_density(const emitter_ball *b, vec3_f64 p, vec3_f64 n, vec3_f64 direction, bool inside) {
    const ball_view view = view_of(b, p);
    vec3_f64 d = to_object(b, direction);
    if (view.on && !(dot_f64(view.from, d) < 0)) return 0;
    if (view.outside && inside) return 0; /* the ray has passed the near side straight */
    if (!view.outside) return shape_all_density(n, direction);
    const shape_cone cone = shape_cone_of(view.from, b->radius);
    return turned_density(b, shape_inverse(shape_cone_angle(&cone)), 1 / sqrt(dot_f64(d, d)));
}
