/* Groups of scenes: sizes and positions, coinciding shapes, nested groups, shapes at the end of float's
 * range. */
#include "verify/extremes/case.h"

static const vec3_f64 middle = {0, 0, 0};

void scale_make(judged_scene *c, double scale) {
    static const char *const words[] = {"12 spheres in a ball of", "12 quads in a ball of",
                                        "a closed mesh of 168 triangles,"};
    case_say(c, "%s radius %g", words[c->shape], scale);
    case_shapes(c, scale);
}

static void put_mixture(judged_scene *c, vec3_f64 at) {
    case_spheres(c, at, 1);
    case_quads(c, at, 1);
    case_ball(c, at, 0.6);
}

static vec3_f64 place_at(double offset) { return scale_f64(offset, vec_f64(0.48, -0.6, 0.64)); }

void offset_near(judged_scene *c, double offset) {
    case_say(c, "all shapes, 1 in size, %g from the origin, the camera next to them", offset);
    vec3_f64 at = place_at(offset);
    put_mixture(c, at);
    build_camera(&c->b, build_view(add_f64(at, vec_f64(2, 1, 4)), at, 0.7));
    c->families |= 1u << RAYS_CAMERA;
}

/* ---- far from the origin in float, without the world's own shift of coordinates ---- */

static vec3_f32 moved(vec3_f32 p, vec3_f64 by) { return narrow(add_f64(widen(p), by)); }

static void move_mesh(judged_scene *c, fathom_mesh *mesh, vec3_f64 by) {
    float *positions = case_memory(c, mesh->vertex_count * 3 * sizeof *positions);
    if (!positions) return;
    for (uint32_t i = 0; i < mesh->vertex_count; ++i)
        store_f32(positions + 3 * (size_t)i, moved(load_f32(mesh->positions + 3 * (size_t)i), by));
    mesh->positions = positions;
}

static void move_world(judged_scene *c) {
    world *w = c->world;
    vec3_f64 by = place_at(c->number[0]);
    for (size_t i = 0; i < w->spheres.count; ++i)
        w->spheres.items[i].center = moved(w->spheres.items[i].center, by);
    for (size_t i = 0; i < 4 * w->quads.count; ++i) {
        vec3_f32 *corner = &w->quads.items[i / 4].corner[i % 4];
        *corner = moved(*corner, by);
    }
    for (size_t i = 0; i < w->meshes.count && c->b.status == FATHOM_OK; ++i)
        move_mesh(c, &w->meshes.items[i], by);
}

void offset_raw(judged_scene *c, double offset) {
    case_say(c, "all shapes, 1 in size, %g from the origin in float, not moved", offset);
    put_mixture(c, middle);
    c->number[0] = offset;
    c->patch = move_world;
}

/* ---- coinciding surfaces: which of them is hit is a tie ---- */

/* Reduces the rays, because the oracle tests every copy. */
static void thin_out(judged_scene *c, double copies) { c->thin = (unsigned)fmax(1, copies / 500); }

void copies_make(judged_scene *c, double count) {
    static const char *const words[] = {"sphere", "quad", "triangle"};
    const uint32_t n = (uint32_t)count;
    const vec3_f64 at = {0.1, 0.2, -0.1}, triangle[3] = {{-1, -0.7, 0.1}, {1.1, -0.4, -0.3}, {0.2, 1.3, 0.2}};
    case_say(c, "one %s %u times", words[c->shape], n);
    thin_out(c, count);
    for (uint32_t i = 0; i < n && c->shape == CASE_SPHERES; ++i) build_sphere(&c->b, at, 0.7, 0);
    for (uint32_t i = 0; i < n && c->shape == CASE_QUADS; ++i)
        build_quad(&c->b, at, vec_f64(0.9, 0.1, 0.2), vec_f64(-0.2, 1, 0.3), 0);
    if (c->shape != CASE_TRIANGLES) return;
    vec3_f64 *corners = case_memory(c, n * 3 * sizeof *corners);
    for (size_t i = 0; corners && i < 3 * (size_t)n; ++i) corners[i] = triangle[i % 3];
    if (corners) case_triangles(c, middle, corners, n);
}

/* ---- overlapping ---- */

/* Triangles and quads in one plane with irregular corners. No two sides coincide, because surfaces without
 * shared corners would leak there. */
static void put_layer(judged_scene *c, double count, vec3_f64 x, vec3_f64 y) {
    uint32_t n = (uint32_t)count;
    thin_out(c, 10 * count);
    vec3_f64 *corners = case_memory(c, n * 3 * sizeof *corners);
    for (uint32_t i = 0; corners && i < 3 * n; ++i)
        corners[i] =
            add_f64(scale_f64(case_scattered(i, 0, -1, 1), x), scale_f64(case_scattered(i, 1, -1, 1), y));
    if (corners) case_triangles(c, middle, corners, n);
    for (uint32_t i = 0; i < n; ++i) {
        double size = case_scattered(i, 4, 0.02, 0.5);
        vec3_f64 at =
            add_f64(scale_f64(case_scattered(i, 2, -1, 1), x), scale_f64(case_scattered(i, 3, -1, 1), y));
        build_quad(&c->b, at, scale_f64(size, x), scale_f64(size / 2, y), 0);
    }
}

void overlap_level(judged_scene *c, double count) {
    case_say(c, "%g triangles and as many quads over each other in the plane z = 0", count);
    put_layer(c, count, vec_f64(1, 0, 0), vec_f64(0, 1, 0));
}

void overlap_tilted(judged_scene *c, double count) {
    case_say(c, "%g triangles and as many quads over each other in a tilted plane, as float has it", count);
    put_layer(c, count, vec_f64(0.8, 0.13, 0.57), vec_f64(-0.3, 0.9, 0.31));
}

/* ---- nested groups: scaled up and down, stretched and mirrored ---- */

static fathom_id put_things(judged_scene *c, double size) {
    const fathom_id group = c->b.group = build_group(&c->b);
    case_ball(c, vec_f64(0, 0, 0), 0.6 * size);
    case_spheres(c, vec_f64(0, 0, 0), size);
    case_quads(c, vec_f64(0, 0, 0), size);
    c->b.group = FATHOM_ROOT;
    return group;
}

static affine_f64 turned(double angle) { return affine_rotation_axis(vec_f64(0.3, 1, -0.4), angle); }

/* Scale, then rotation, then translation. */
static affine_f64 placing(vec3_f64 scale, double angle, vec3_f64 shift) {
    affine_f64 s = affine_scaling(scale), r = turned(angle), t = affine_translation(shift);
    affine_f64 rs = affine_compose(&r, &s);
    return affine_compose(&t, &rs);
}

/* Puts `things` by `inner` into a group, and this group twice into the root: by `outer`, and by `outer` moved
 * aside. */
static void nest(judged_scene *c, fathom_id things, const affine_f64 *inner, const affine_f64 *outer) {
    fathom_id group = build_group(&c->b);
    build_place(&c->b, things, group, inner);
    affine_f64 aside = affine_translation(vec_f64(2.5, 0.3, 0));
    affine_f64 second = affine_compose(&aside, outer);
    build_place(&c->b, group, FATHOM_ROOT, outer);
    build_place(&c->b, group, FATHOM_ROOT, &second);
}

void nested_back(judged_scene *c, double ratio) {
    case_say(c, "groups scaled by %g within groups scaled back", ratio);
    fathom_id things = put_things(c, 1);
    affine_f64 inner = placing(vec_f64(ratio, ratio, ratio), 0.7, vec_f64(ratio, 0, 0));
    double back = 0.9 / ratio;
    affine_f64 outer = placing(vec_f64(back, back, back), -1.1, vec_f64(0.2, 0.1, -0.3));
    nest(c, things, &inner, &outer);
}

void nested_grow(judged_scene *c, double ratio) {
    case_say(c, "groups scaled by %g in two steps, contents as much smaller", ratio);
    fathom_id things = put_things(c, 1 / ratio);
    double step = sqrt(ratio), size = 1 / step;
    affine_f64 inner = placing(vec_f64(step, step, step), 0.7, vec_f64(size, 0, 0));
    affine_f64 outer = placing(vec_f64(step, step, step), -1.1, vec_f64(0.2, 0.1, -0.3));
    nest(c, things, &inner, &outer);
}

void nested_stretch(judged_scene *c, double ratio) {
    case_say(c, "groups stretched by %g along one axis between two turns", ratio);
    c->thin = ratio < 1e-5 || ratio > 1e5 ? 4 : 1; /* so flat that few primitives can be distinguished */
    fathom_id things = put_things(c, 1);
    affine_f64 inner = placing(vec_f64(1, 1, 1), 0.7, vec_f64(0.3, 0, 0.1));
    affine_f64 outer = placing(vec_f64(1, ratio, 1), -1.1, vec_f64(0.2, 0.1, -0.3));
    nest(c, things, &inner, &outer);
}

void nested_mirror(judged_scene *c, double ratio) {
    case_say(c, "groups mirrored along x and scaled by %g within groups mirrored along z, scaled back",
             ratio);
    fathom_id things = put_things(c, 1);
    affine_f64 inner = placing(vec_f64(-ratio, ratio, ratio), 0.7, vec_f64(ratio, 0, 0));
    double back = 0.9 / ratio;
    affine_f64 outer = placing(vec_f64(back, 2 * back, -back), -1.1, vec_f64(0.2, 0.1, -0.3));
    nest(c, things, &inner, &outer);
}

/* ---- shapes at the end of float's range and beyond, next to good ones ----
 * Embree leaves out shapes with a coordinate beyond 1.8e18; the world counts these. */

static void put_far_triangles(judged_scene *c, double at) {
    vec3_f64 corners[24];
    for (unsigned i = 0; i < 24; ++i) {
        corners[i] = case_scattered_point(i, 0, 1);
        if (i % 3 == i / 3 % 3) corners[i] = scale_f64(at, normalize_f64(corners[i]));
    }
    case_triangles(c, middle, corners, 8);
}

void beyond_triangles(judged_scene *c, double at) {
    case_say(c, "among good triangles: some with a corner %g away", at);
    c->thin = 8; /* the oracle's integers are slow with such exponents */
    case_ball(c, middle, 0.3);
    put_far_triangles(c, at);
}

void beyond_quads(judged_scene *c, double at) {
    case_say(c, "among good quads: some with sides of %g", at);
    c->thin = 4;
    case_quads(c, middle, 1);
    for (unsigned i = 0; i < 6; ++i) {
        vec3_f64 u = case_scattered_point(i, 0, 1), v = cross_f64(u, vec_f64(0.3, 1, -0.2));
        build_quad(&c->b, scale_f64(3, u), scale_f64(at, u), scale_f64(at, v), 0);
    }
}

void beyond_spheres(judged_scene *c, double at) {
    case_say(c, "among good spheres: one of radius %g around all, and one as far away", at);
    case_spheres(c, middle, 1);
    build_sphere(&c->b, middle, at, 0);
    build_sphere(&c->b, vec_f64(0.6 * at, -1.2 * at, 0), 0.5 * at, 0);
}
