/* Rays that leave surfaces, held against exact geometry: what the unit test and bench/offset.c share.
 *
 * A trial is a world of one shape A and at most one other, B: parallel to A at a gap, crossing it at an
 * angle, or a sphere that rests on it. Rays find points on A or B, the renderer's own functions make surface
 * points of them, and from each point rays leave to both sides, in all directions down to 1e-6 from the
 * surface.
 *
 * With q the point of the true surface nearest to where a ray starts, and `unit` one unit in the last place
 * of the largest number that is rounded on the way (below), the ray from q is followed in double:
 * - it cannot meet again the flat face, or from outside the sphere, that it leaves, and meets a sphere from
 *   within where its chord ends. A traced ray that meets the primitive it left elsewhere is a
 * self-intersection.
 * - it must meet another face or sphere when every ray parallel to it within 64 units does, and q lies at
 * least 64 units from that one's surface; a chord's end always. A traced ray that meets nothing, or what
 * comes later, is a lost contact.
 * - it cannot meet another one when no ray parallel to it within 64 units does. A traced ray that does is a
 *   phantom.
 *
 * A start exactly on the surface is as good as one off it: t = 0 lies outside the interval.
 *
 * Unit: the last place of the largest coordinate of the point; for flat shapes, of the corners if that is
 * larger, for they are what is subtracted; for spheres, of double's last place of centre and radius, which
 * are what is subtracted there; in an instance, also of the largest sum of products |M| (|A| |p| + |T|), A
 * and T the map to object space and M its inverse: those products are what is rounded there. */
#pragma once

#include "defaults.h"
#include "math/affine.h"
#include "random.h"
#include "surface/gather.h"
#include "trace/trace.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum offset_shape { OFFSET_SPHERE, OFFSET_QUAD, OFFSET_TRIANGLE, OFFSET_PLANE } offset_shape;
enum { OFFSET_SHAPES = 4, OFFSET_TRACERS = 2, OFFSET_BINS = 128, OFFSET_POINTS = 64, OFFSET_RAYS = 16 };

typedef struct offset_counts {
    uint64_t rays, contacts, wrong_side;
    uint64_t self[OFFSET_TRACERS], lost[OFFSET_TRACERS], phantom[OFFSET_TRACERS]; /* reference, Embree */
    uint64_t histogram[OFFSET_BINS]; /* of points, by whole units from the surface */
    double most;                     /* units */
} offset_counts;

/* Of the world in which shapes are laid out. */
typedef struct offset_case {
    offset_shape shape;
    double size, away; /* away: from the origin, in sizes */
    bool instance;
    double stretch; /* of the instance's axes: up to this and down to its inverse */
    double thin;    /* faces: how many times shorter than long, at least */
} offset_case;

/* ---- a world by hand: coordinates stay where they are put, for none is moved to a better origin ---- */

typedef struct offset_world {
    world w;
    float corner[2][3][3]; /* of triangles */
} offset_world;

static const uint32_t offset_index[3] = {0, 1, 2};

static inline vec3_f64 offset_direction(random_state *r) {
    double z = random_in(r, -1, 1), phi = random_in(r, 0, 2 * M_PI), s = sqrt(1 - z * z);
    return vec_f64(s * cos(phi), s * sin(phi), z);
}

static inline vec3_f64 offset_across(random_state *r, vec3_f64 n) {
    vec3_f64 d;
    do {
        d = offset_direction(r);
        d = madd_f64(d, -dot_f64(d, n), n);
    } while (dot_f64(d, d) < 1e-2);
    return normalize_f64(d);
}

static inline void offset_add_geometry(offset_world *o, world_kind kind, size_t first) {
    world_geometry g = {
        .kind = kind, .first = (uint32_t)first, .count = 1, .instance = FATHOM_NONE, .material = FATHOM_NONE};
    array_push(&o->w.geometries, g);
}

/* Every other one with twice the digits, wherever it lies. */
static inline void offset_add_sphere(offset_world *o, random_state *r, vec3_f64 c, double radius) {
    world_sphere s = {.center = narrow(c), .radius = (float)radius};
    if (random_bits(r) % 2) {
        s.center_rest = narrow(sub_f64(c, widen(s.center)));
        s.radius_rest = (float)(radius - (double)s.radius);
    }
    offset_add_geometry(o, WORLD_SPHERES, o->w.spheres.count);
    array_push(&o->w.spheres, s);
}

static inline void offset_add_quad(offset_world *o, const vec3_f64 v[4]) {
    world_quad q = {{narrow(v[0]), narrow(v[1]), narrow(v[2]), narrow(v[3])}};
    offset_add_geometry(o, WORLD_QUADS, o->w.quads.count);
    array_push(&o->w.quads, q);
}

static inline void offset_add_triangle(offset_world *o, const vec3_f64 v[3]) {
    float(*p)[3] = o->corner[o->w.meshes.count];
    for (int k = 0; k < 3; ++k) store_f32(p[k], narrow(v[k]));
    fathom_mesh mesh = default_mesh();
    mesh.positions = p[0], mesh.vertex_count = 3, mesh.position_stride = sizeof *p;
    mesh.indices = offset_index, mesh.triangle_count = 1;
    offset_add_geometry(o, WORLD_MESH, o->w.meshes.count);
    array_push(&o->w.meshes, mesh);
}

static inline void offset_add_plane(offset_world *o, vec3_f64 point, vec3_f64 n) {
    double offset = dot_f64(point, n);
    world_plane p = {.offset = (float)offset, .point = narrow(scale_f64(offset, n))};
    world_plane_set_normal(&p, n);
    array_push(&o->w.planes, p);
}

/* The frame of A: a point of it, its normal there; for spheres the centre. */
typedef struct offset_frame {
    vec3_f64 at, n, u, v, center;
    double size, thin;
} offset_frame;

/* Corners around `at` in the plane of u and v. */
static inline void offset_corners(random_state *r, const offset_frame *f, int count, vec3_f64 out[4]) {
    double turn = random_in(r, 0, 2 * M_PI);
    for (int k = 0; k < count; ++k) {
        double a = turn + 2 * M_PI * (k + random_in(r, -0.3, 0.3)) / count,
               l = f->size * random_in(r, 0.5, 1);
        out[k] = madd_f64(madd_f64(f->at, l * cos(a), f->u), l * sin(a) / f->thin, f->v);
    }
}

static inline void offset_add_face(offset_world *o, random_state *r, const offset_frame *f,
                                   offset_shape shape) {
    vec3_f64 v[4];
    if (shape == OFFSET_PLANE) {
        offset_add_plane(o, f->at, f->n);
    } else {
        offset_corners(r, f, shape == OFFSET_QUAD ? 4 : 3, v);
        /* A parallelogram's halves lie in one plane, but for rounding. */
        v[2] = shape == OFFSET_QUAD ? sub_f64(add_f64(v[1], v[3]), v[0]) : v[2];
        if (shape == OFFSET_QUAD) {
            offset_add_quad(o, v);
        } else {
            offset_add_triangle(o, v);
        }
    }
}

static inline void offset_add_other(offset_world *o, random_state *r, offset_shape shape, offset_frame f,
                                    double least) {
    double side = random_unit(r) < 0.5 ? -1 : 1, gap = side * random_log(r, least, f.size), radius = f.size;
    switch (random_bits(r) % 4) {
    case 0: break;
    case 1: /* parallel */
        f.at = madd_f64(f.at, gap, f.n);
        if (shape == OFFSET_SPHERE) {
            offset_add_sphere(o, r, f.center, radius + (gap < -radius / 2 ? -radius / 2 : gap));
        } else {
            offset_add_face(o, r, &f, shape);
        }
        break;
    case 2: { /* a corner */
        double a = random_in(r, 0.1, M_PI - 0.1);
        vec3_f64 n = add_f64(scale_f64(cos(a), f.n), scale_f64(sin(a), f.u));
        f.u = sub_f64(scale_f64(cos(a), f.u), scale_f64(sin(a), f.n)), f.n = n;
        bool quad = shape == OFFSET_SPHERE ? random_unit(r) < 0.5 : shape == OFFSET_QUAD;
        offset_add_face(o, r, &f, shape == OFFSET_PLANE ? shape : (quad ? OFFSET_QUAD : OFFSET_TRIANGLE));
        break;
    }
    default: /* a sphere at rest */
        radius = fmax(f.size * random_log(r, 1e-3, 0.5), 4 * least);
        offset_add_sphere(o, r, madd_f64(f.at, side * radius, f.n), radius);
        break;
    }
}

static inline void offset_add_instance(offset_world *o, random_state *r, const offset_case *c) {
    affine_f64 turn = affine_rotation_axis(offset_direction(r), random_in(r, 0, 2 * M_PI)),
               turned = affine_rotation_axis(offset_direction(r), random_in(r, 0, 2 * M_PI)), map;
    vec3_f64 s = {random_log(r, 1 / c->stretch, c->stretch), random_log(r, 1 / c->stretch, c->stretch),
                  random_log(r, 1 / c->stretch, c->stretch)};
    if (random_unit(r) < 0.5) s.x = -s.x;
    if (random_unit(r) < 0.3) turn = affine_identity();
    affine_f64 stretch = affine_scaling(s);
    map = affine_compose(&stretch, &turned);
    map = affine_compose(&turn, &map);
    affine_f64 move = affine_translation(scale_f64(c->size * c->away, offset_direction(r)));
    map = affine_compose(&move, &map);
    world_instance instance = {.group = 1, .material = FATHOM_NONE, .id = 0};
    world_instance_set(&instance, &map);
    array_push(&o->w.instances, instance);
}

static inline void offset_world_make(offset_world *o, random_state *r, const offset_case *c,
                                     const fathom_scene *scene) {
    memset(o, 0, sizeof *o);
    o->w.scene = scene;
    offset_frame f = {.n = offset_direction(r), .size = c->size, .thin = c->thin};
    /* In an instance half of the distance is the map's, half the object's own. */
    double away = c->instance && random_unit(r) < 0.5 ? 0 : c->away;
    f.at = scale_f64(c->size * away, offset_direction(r));
    f.u = offset_across(r, f.n), f.v = cross_f64(f.n, f.u);
    f.center = madd_f64(f.at, -c->size, f.n);
    if (c->shape == OFFSET_SPHERE) {
        offset_add_sphere(o, r, f.center, c->size);
    } else {
        offset_add_face(o, r, &f, c->shape);
    }
    offset_add_other(o, r, c->shape, f, c->size * fmax(1, c->away) * 64 * 0x1p-23);
    world_group all = {0, (uint32_t)o->w.geometries.count}, none = {0, 0};
    if (c->instance) {
        array_push(&o->w.groups, none);
        offset_add_instance(o, r, c);
    }
    array_push(&o->w.groups, all);
}

static inline void offset_world_free(offset_world *o) {
    array_free(&o->w.spheres);
    array_free(&o->w.quads);
    array_free(&o->w.planes);
    array_free(&o->w.meshes);
    array_free(&o->w.geometries);
    array_free(&o->w.groups);
    array_free(&o->w.instances);
}

/* ---- exact geometry, in double: its roundings are 2^-29 of the float's ---- */

/* A sphere, a triangle (of a quad: one half) or a plane. */
typedef struct offset_face {
    bool sphere, plane;
    vec3_f64 v[3], n; /* v[0]: the centre, or a point; n: unit, of flat faces */
    double radius;
    uint32_t geometry, primitive, instance;
} offset_face;

static inline void offset_face_set(offset_face *f, vec3_f32 a, vec3_f32 b, vec3_f32 c) {
    f->v[0] = widen(a), f->v[1] = widen(b), f->v[2] = widen(c);
    f->n = normalize_f64(cross_f64(sub_f64(f->v[1], f->v[0]), sub_f64(f->v[2], f->v[0])));
}

/* The faces of the world, at most four. */
static inline int offset_faces(const world *w, offset_face out[4]) {
    int n = 0;
    uint32_t instance = w->instances.count ? 0 : FATHOM_NONE;
    for (uint32_t g = 0; g < w->geometries.count; ++g) {
        const world_geometry *geometry = &w->geometries.items[g];
        offset_face face = {.geometry = g, .instance = instance};
        switch (geometry->kind) {
        case WORLD_SPHERES:
            face.sphere = true, face.radius = world_sphere_radius(&w->spheres.items[geometry->first]);
            face.v[0] = world_sphere_center(&w->spheres.items[geometry->first]);
            break;
        case WORLD_QUADS: {
            const vec3_f32 *c = w->quads.items[geometry->first].corner;
            offset_face_set(&face, c[0], c[1], c[3]);
            out[n++] = face;
            offset_face_set(&face, c[2], c[3], c[1]);
            break;
        }
        case WORLD_MESH: {
            const float *p = w->meshes.items[geometry->first].positions;
            offset_face_set(&face, load_f32(p), load_f32(p + 3), load_f32(p + 6));
            break;
        }
        }
        out[n++] = face;
    }
    for (uint32_t k = 0; k < w->planes.count; ++k) {
        vec3_f64 normal = widen(w->planes.items[k].normal);
        offset_face face = {.plane = true, .geometry = TRACE_PLANE, .primitive = k, .instance = FATHOM_NONE};
        face.v[0] = widen(w->planes.items[k].point), face.n = normalize_f64(normal);
        out[n++] = face;
    }
    return n;
}

/* The way from the world to the space of the faces. */
typedef struct offset_space {
    affine_f64 to_object, to_world;
    double norm; /* how much longer to_object can make a vector */
} offset_space;

static inline offset_space offset_space_of(const world *w) {
    offset_space s = {affine_identity(), affine_identity(), 1};
    if (!w->instances.count) return s;
    double sum = 0;
    for (int i = 0; i < 12; ++i) {
        double x = (double)w->instances.items[0].to_object[i / 4][i % 4];
        s.to_object.m[i / 4][i % 4] = x;
        if (i % 4 < 3) sum += x * x;
    }
    affine_invert(&s.to_object, &s.to_world);
    s.norm = sqrt(sum);
    return s;
}

/* Signed distance of a world point from the face's surface, and the unit normal there, in the world. */
static inline double offset_distance(const offset_space *s, const offset_face *f, vec3_f64 p,
                                     vec3_f64 *normal) {
    vec3_f64 from = sub_f64(affine_point(&s->to_object, p), f->v[0]), n = f->n;
    if (f->sphere) n = normalize_f64(from);
    double d = f->sphere ? length_f64(from) - f->radius : dot_f64(from, n);
    vec3_f64 gradient = affine_transposed_vector(&s->to_object, n);
    *normal = normalize_f64(gradient);
    return d / length_f64(gradient);
}

typedef enum offset_verdict { OFFSET_MISSES, OFFSET_DOUBT, OFFSET_MEETS } offset_verdict;

/* How far apart the lines through p along d and through v along e are. */
static inline double offset_apart(vec3_f64 p, vec3_f64 d, vec3_f64 v, vec3_f64 e) {
    vec3_f64 n = cross_f64(d, e);
    return fabs(dot_f64(sub_f64(p, v), n)) / length_f64(n);
}

static inline offset_verdict offset_follow_flat(const offset_face *f, vec3_f64 org, vec3_f64 dir,
                                                double margin, double *t) {
    double above = dot_f64(sub_f64(org, f->v[0]), f->n), along = dot_f64(dir, f->n);
    if (fabs(above) <= margin) return OFFSET_DOUBT;
    *t = -above / along;
    if (!(*t > 0 && isfinite(*t))) return OFFSET_MISSES;
    offset_verdict verdict = OFFSET_MEETS;
    vec3_f64 p = madd_f64(org, *t, dir);
    for (int k = 0; k < 3 && !f->plane; ++k) {
        vec3_f64 e = sub_f64(f->v[(k + 1) % 3], f->v[k]), from = sub_f64(p, f->v[k]);
        bool near = !(offset_apart(org, dir, f->v[k], e) > margin);
        bool outside = dot_f64(cross_f64(e, from), f->n) < 0;
        if (outside && !near) return OFFSET_MISSES;
        if (near) verdict = OFFSET_DOUBT;
    }
    return verdict;
}

static inline offset_verdict offset_follow_sphere(const offset_face *f, vec3_f64 org, vec3_f64 dir,
                                                  double margin, double *t) {
    vec3_f64 from = sub_f64(org, f->v[0]);
    double a = dot_f64(dir, dir), b = -dot_f64(from, dir), far = length_f64(from);
    double l = length_f64(madd_f64(from, b / a, dir));
    if (fabs(far - f->radius) <= margin) return OFFSET_DOUBT;
    if (far > f->radius && (b <= 0 || l > f->radius + margin)) return OFFSET_MISSES;
    if (far > f->radius && l >= f->radius - margin) return OFFSET_DOUBT;
    double s = sqrt((f->radius - l) * (f->radius + l) / a);
    *t = far > f->radius ? b / a - s : b / a + s;
    return OFFSET_MEETS;
}

/* Whether all rays from within `margin` of q meet another face, or none does. */
static inline offset_verdict offset_follow(const offset_space *s, const offset_face *f, vec3_f64 q,
                                           vec3_f64 dir, double margin, double *t) {
    vec3_f64 org = affine_point(&s->to_object, q), d = affine_vector(&s->to_object, dir);
    if (f->sphere) return offset_follow_sphere(f, org, d, margin * s->norm, t);
    return offset_follow_flat(f, org, d, margin * s->norm, t);
}

/* Where the ray from within a sphere leaves it; 0 from outside. */
static inline double offset_chord(const offset_space *s, const offset_face *f, vec3_f64 o, vec3_f64 dir) {
    vec3_f64 org = affine_point(&s->to_object, o), d = affine_vector(&s->to_object, dir);
    vec3_f64 from = sub_f64(org, f->v[0]);
    double a = dot_f64(d, d), b = -dot_f64(from, d), far = length_f64(from);
    double c = (far - f->radius) * (far + f->radius);
    if (!(c < 0)) return 0;
    double root = sqrt(b * b - a * c);
    return b > 0 ? (b + root) / a : c / (b - root);
}

static inline double offset_largest(vec3_f64 p) { return fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))); }
static inline double offset_ulp(double x) {
    int e;
    frexp(x, &e);
    return ldexp(1, e - 24);
}

static inline double offset_unit(const offset_space *s, const offset_face *f, const world *w, vec3_f64 q) {
    double most = offset_largest(q);
    if (w->instances.count) {
        double there[3], p[3] = {fabs(q.x), fabs(q.y), fabs(q.z)};
        for (int i = 0; i < 3; ++i) {
            const double *m = s->to_object.m[i];
            there[i] = fabs(m[0]) * p[0] + fabs(m[1]) * p[1] + fabs(m[2]) * p[2] + fabs(m[3]);
            for (int k = 0; k < 3 && !f->sphere; ++k) there[i] = fmax(there[i], offset_largest(f->v[k]));
        }
        for (int i = 0; i < 3; ++i) {
            const double *m = s->to_world.m[i];
            most = fmax(most, fabs(m[0]) * there[0] + fabs(m[1]) * there[1] + fabs(m[2]) * there[2]);
        }
    } else if (!f->sphere) {
        for (int k = 0; k < (f->plane ? 1 : 3); ++k) most = fmax(most, offset_largest(f->v[k]));
    }
    if (f->sphere) most = fmax(most, 0x1p-29 * (offset_largest(f->v[0]) + f->radius));
    return offset_ulp(most);
}

/* ---- leaving ---- */

typedef struct offset_trial {
    offset_world o;
    offset_face faces[4];
    int face_count;
    offset_space space;
    trace_tracer *tracers[OFFSET_TRACERS];
    random_state *r;
    offset_counts *counts;
    FILE *log; /* failures are told here, or NULL */
} offset_trial;

/* One ray that leaves: from which face, to which of its sides. */
typedef struct offset_ray {
    const offset_face *left;
    vec3_f64 q, n;
    double unit;
} offset_ray;

/* The face that holds the point: of a quad, the half that is nearer in its plane. */
static inline const offset_face *offset_left(const offset_trial *t, const surface_gather *g, unsigned lane,
                                             vec3_f64 p) {
    const offset_face *best = NULL;
    double least = HUGE_VAL;
    vec3_f64 at = affine_point(&t->space.to_object, p);
    for (int i = 0; i < t->face_count; ++i) {
        const offset_face *f = &t->faces[i];
        if (f->geometry != g->geometry[lane] || f->primitive != g->primitive[lane]) continue;
        vec3_f64 middle = scale_f64(1 / 3.0, add_f64(f->v[0], add_f64(f->v[1], f->v[2])));
        double outside = 0;
        for (int k = 0; k < 3 && !f->sphere && !f->plane; ++k) {
            vec3_f64 e = sub_f64(f->v[(k + 1) % 3], f->v[k]), m = cross_f64(f->n, e);
            outside = fmax(outside, -dot_f64(sub_f64(at, f->v[k]), m) / dot_f64(sub_f64(middle, f->v[k]), m));
        }
        if (outside < least) best = f, least = outside;
    }
    return best;
}

static inline void offset_set_ray(trace_rays *r, size_t i, vec3_f32 o, vec3_f32 d) {
    r->org_x[i] = o.x, r->org_y[i] = o.y, r->org_z[i] = o.z;
    r->dir_x[i] = d.x, r->dir_y[i] = d.y, r->dir_z[i] = d.z;
    r->t_near[i] = 0, r->t_far[i] = INFINITY;
}

/* A unit vector on the side of n, evenly or by powers of ten along the surface. */
static inline vec3_f32 offset_away(random_state *r, vec3_f64 n) {
    for (;;) {
        double c = random_unit(r) < 0.5 ? random_unit(r) : random_log(r, 1e-6, 1);
        vec3_f64 d = madd_f64(scale_f64(c, n), sqrt(1 - c * c), offset_across(r, n));
        vec3_f32 out = narrow(d);
        if (dot_f64(widen(out), n) > 5e-7) return out;
    }
}

/* Fills a block with rays that leave the point in this lane to one side. False for the inside of a sphere of
 * less than 128 units, which float cannot tell from its outside. */
static inline bool offset_leave(offset_trial *t, const surface_block *s, int lane, float side,
                                const surface_gather *g, trace_block *block, offset_ray *out) {
    vec3_f32 start;
    float *c[3] = {&start.x, &start.y, &start.z};
    for (int k = 0; k < 3; ++k) *c[k] = surface_start(s->p[k][lane], side * s->offset[lane], s->ng[k][lane]);
    vec3_f64 o = widen(start), n,
             ng = {(double)s->ng[0][lane], (double)s->ng[1][lane], (double)s->ng[2][lane]};
    out->left = offset_left(t, g, (unsigned)lane, o);
    double d = offset_distance(&t->space, out->left, o, &n);
    out->q = madd_f64(o, -d, n);
    out->unit = offset_unit(&t->space, out->left, &t->o.w, out->q);
    if (!finite_f64(n)) return false;
    bool inside = dot_f64(n, ng) * (double)side < 0;
    if (out->left->sphere && !(out->left->radius > 128 * out->unit * t->space.norm)) return false;
    double up = inside ? -1 : 1, units = d * up / out->unit;
    out->n = scale_f64(up, n);
    if (!(units >= 0)) ++t->counts->wrong_side;
    t->counts->most = fmax(t->counts->most, fabs(units));
    ++t->counts->histogram[(int)fmin(fabs(units), OFFSET_BINS - 1)];
    for (size_t i = 0; i < OFFSET_RAYS; ++i) {
        offset_set_ray(&block->rays, i, start, offset_away(t->r, out->n));
    }
    return true;
}

/* What exact geometry says of one ray. */
typedef struct offset_truth {
    double chord;     /* where it leaves the sphere it is in, or 0 */
    double must, may; /* the nearest other face that it must, or may, meet; else infinite */
    bool bent;        /* it meets the other half of a quad that rounding has bent */
    double unit;
} offset_truth;

static inline offset_truth offset_truth_of(const offset_trial *t, const offset_ray *ray, vec3_f64 o,
                                           vec3_f64 d) {
    offset_truth truth = {.must = HUGE_VAL, .may = HUGE_VAL, .unit = ray->unit};
    if (ray->left->sphere) truth.chord = offset_chord(&t->space, ray->left, o, d);
    for (int i = 0; i < t->face_count; ++i) {
        const offset_face *f = &t->faces[i];
        double at = 0;
        if (f == ray->left) continue;
        if (f->geometry == ray->left->geometry && f->primitive == ray->left->primitive) {
            truth.bent = offset_follow(&t->space, f, o, d, 0, &at) == OFFSET_MEETS;
            continue;
        }
        offset_verdict v = offset_follow(&t->space, f, ray->q, d, 64 * ray->unit, &at);
        if (v == OFFSET_MEETS) truth.must = fmin(truth.must, at), truth.may = fmin(truth.may, at);
        if (v == OFFSET_DOUBT) truth.may = 0;
    }
    return truth;
}

static inline void offset_tell(const offset_trial *t, const char *what, int tracer, const offset_ray *ray,
                               const trace_block *b, size_t i, const offset_truth *truth) {
    if (!t->log) return;
    const trace_rays *r = &b->rays;
    double cosine =
        (double)r->dir_x[i] * ray->n.x + (double)r->dir_y[i] * ray->n.y + (double)r->dir_z[i] * ray->n.z;
    fprintf(t->log,
            "%s, tracer %d: cos %g unit %g t %g chord %g must %g may %g, hit %u left %u (%s) instance %d\n",
            what, tracer, cosine, ray->unit, (double)r->t_far[i], truth->chord, truth->must, truth->may,
            b->hits.geometry[i], ray->left->geometry, ray->left->sphere ? "sphere" : "flat",
            t->space.norm != 1);
}

static inline void offset_judge(offset_trial *t, int tracer, const offset_ray *ray, const trace_block *b,
                                size_t i, bool any, const offset_truth *truth) {
    const trace_hits *h = &b->hits;
    double met = h->geometry[i] == FATHOM_NONE ? HUGE_VAL : (double)b->rays.t_far[i];
    bool own =
        h->geometry[i] == ray->left->geometry && h->primitive[i] == ray->left->primitive && met < HUGE_VAL;
    bool fair = own && truth->bent;
    bool chord = own && truth->chord > 0 && met >= truth->chord / 4;
    double must = truth->chord > 0 ? fmin(truth->must, truth->chord) : truth->must;
    if (own && !fair && !chord) {
        ++t->counts->self[tracer];
        offset_tell(t, "self", tracer, ray, b, i, truth);
    } else if (met > must * 2 + 128 * truth->unit || (!any && must < HUGE_VAL)) {
        ++t->counts->lost[tracer];
        offset_tell(t, any ? "lost" : "lost by any", tracer, ray, b, i, truth);
    } else if ((met < HUGE_VAL || any) && !truth->bent && truth->may == HUGE_VAL && !(truth->chord > 0)) {
        ++t->counts->phantom[tracer];
        offset_tell(t, any ? "phantom by any" : "phantom", tracer, ray, b, i, truth);
    }
}

static inline void offset_trace(offset_trial *t, const offset_ray *ray, const trace_block *asked) {
    offset_truth truth[OFFSET_RAYS];
    for (size_t i = 0; i < OFFSET_RAYS; ++i) {
        const trace_rays *r = &asked->rays;
        vec3_f64 o = widen(vec_f32(r->org_x[i], r->org_y[i], r->org_z[i]));
        truth[i] = offset_truth_of(t, ray, o, widen(vec_f32(r->dir_x[i], r->dir_y[i], r->dir_z[i])));
        t->counts->contacts += truth[i].must < HUGE_VAL;
    }
    t->counts->rays += OFFSET_RAYS;
    for (int k = 0; k < OFFSET_TRACERS; ++k) {
        trace_block closest = *asked;
        trace_rays any = asked->rays;
        trace_closest(t->tracers[k], &closest, OFFSET_RAYS, TRACE_INCOHERENT);
        trace_any(t->tracers[k], &any, OFFSET_RAYS, TRACE_INCOHERENT);
        for (size_t i = 0; i < OFFSET_RAYS; ++i) {
            offset_judge(t, k, ray, &closest, i, any.t_far[i] < 0, &truth[i]);
        }
    }
}

/* ---- one trial ---- */

/* Towards a point of A, from up to ten sizes away. */
static inline void offset_aim(offset_trial *t, const offset_case *c, trace_block *block) {
    const offset_face *f = &t->faces[random_bits(t->r) % (uint64_t)t->face_count];
    for (size_t i = 0; i < OFFSET_RAYS; ++i) {
        vec3_f64 p = f->v[0];
        if (f->sphere) {
            p = madd_f64(p, f->radius, offset_direction(t->r));
        } else if (f->plane) {
            p = madd_f64(p, c->size, offset_across(t->r, f->n));
        } else {
            double u = random_unit(t->r), v = (1 - u) * random_unit(t->r);
            p = madd_f64(madd_f64(p, u, sub_f64(f->v[1], p)), v, sub_f64(f->v[2], p));
        }
        p = affine_point(&t->space.to_world, p);
        double far = random_log(t->r, 0.1, 10) * c->size / t->space.norm;
        vec3_f64 o = madd_f64(p, far, offset_direction(t->r));
        offset_set_ray(&block->rays, i, narrow(o), narrow(normalize_f64(sub_f64(p, widen(narrow(o))))));
    }
}

static inline void offset_points(offset_trial *t, const trace_block *block) {
    surface_block s;
    surface_gather g;
    memset(&g, 0, sizeof g);
    surface_gather_begin(&g);
    for (size_t i = 0; i < OFFSET_RAYS; ++i) {
        if (block->hits.geometry[i] == FATHOM_NONE) continue;
        surface_gather_add(&g, &t->o.w, block, i);
    }
    if (!g.count) return;
    surface_gather_end(&g, &t->o.w, surface_kernels_best(), false, true, &s);
    for (unsigned i = 0; i < g.count; ++i) {
        for (int side = -1; side <= 1; side += 2) {
            trace_block leaving;
            offset_ray ray;
            memset(&leaving, 0, sizeof leaving);
            if (offset_leave(t, &s, (int)i, (float)side, &g, &leaving, &ray)) offset_trace(t, &ray, &leaving);
        }
    }
}

static inline fathom_status offset_run(fathom_context *context, const fathom_scene *scene,
                                       const offset_case *c, random_state *r, FILE *log,
                                       offset_counts *counts) {
    offset_trial t = {.r = r, .counts = counts, .log = log};
    fathom_status status = FATHOM_OK;
    offset_world_make(&t.o, r, c, scene);
    t.face_count = offset_faces(&t.o.w, t.faces);
    t.space = offset_space_of(&t.o.w);
    for (int k = 0; k < OFFSET_TRACERS && status == FATHOM_OK; ++k) {
        trace_options options = {
            .words = k ? "embree" : "reference", .width = LANES, .threads = 1, .quality = TRACE_QUALITY_LOW};
        status = trace_create(context, &t.o.w, &options, &t.tracers[k]);
    }
    unsigned mode = trace_thread_begin();
    for (int i = 0; i < OFFSET_POINTS / OFFSET_RAYS && status == FATHOM_OK; ++i) {
        trace_block block;
        memset(&block, 0, sizeof block);
        offset_aim(&t, c, &block);
        trace_closest(t.tracers[i % OFFSET_TRACERS], &block, OFFSET_RAYS, TRACE_INCOHERENT);
        offset_points(&t, &block);
    }
    trace_thread_end(mode);
    for (int k = 0; k < OFFSET_TRACERS; ++k) trace_destroy(t.tracers[k]);
    offset_world_free(&t.o);
    return status;
}

/* Scales 1e-8 to 1e8; 0, 1, 1e3 and 1e6 sizes from the origin. */
static inline offset_case offset_case_of(random_state *r, offset_shape shape, bool instance, double stretch,
                                         double thin) {
    static const double aways[] = {0, 1, 1e3, 1e6};
    offset_case c = {shape, pow(10, random_in(r, -8, 8)), aways[random_bits(r) % 4], instance, stretch, thin};
    return c;
}
