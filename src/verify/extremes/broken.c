/* Invalid primitives among good ones: without area, not finite, or duplicated. Invalid ones are never hit and
 * occlude nothing. Primitives that a scene refuses are put directly into the world. */
#include "verify/extremes/case.h"

#define BROKEN 24u

static vec3_f64 corner_at(unsigned i, unsigned k) {
    /* Multiples of 1/64 add without rounding. */
    return vec_f64(floor(case_scattered(i, k, -64, 64)) / 64, floor(case_scattered(i, k + 3, -64, 64)) / 64,
                   floor(case_scattered(i, k + 6, -64, 64)) / 64);
}

/* ---- primitives that a scene accepts ---- */

/* Corners a, a + p s, a + q s. */
static void put_lines(judged_scene *c, double p, double q) {
    vec3_f64 corners[3 * BROKEN];
    for (unsigned i = 0; i < BROKEN; ++i) {
        vec3_f64 a = corner_at(i, 0), s = scale_f64(0.25, corner_at(i, 9));
        corners[3 * i] = a, corners[3 * i + 1] = madd_f64(a, p, s), corners[3 * i + 2] = madd_f64(a, q, s);
    }
    case_triangles(c, vec_f64(0, 0, 0), corners, BROKEN);
}

static void put_collinear(judged_scene *c) { put_lines(c, 1, 3); }
static void put_points(judged_scene *c) { put_lines(c, 0, 0); }
static void put_doubled_corners(judged_scene *c) { put_lines(c, 2, 2); }
static void put_twice(judged_scene *c) { case_ball(c, vec_f64(0, 0, 0), 0.6); }

static void put_whole(judged_scene *c) {
    vec3_f64 corners[3 * BROKEN];
    for (unsigned i = 0; i < BROKEN; ++i) {
        for (unsigned k = 0; k < 3; ++k) corners[3 * i + k] = corner_at(i, 3 * k);
    }
    case_triangles(c, vec_f64(0, 0, 0), corners, BROKEN);
}

/* ---- primitives that it refuses ---- */

static void set_one(vec3_f32 *p, unsigned axis, float to) {
    *(axis % 3 == 0 ? &p->x : axis % 3 == 1 ? &p->y : &p->z) = to;
}

/* Replaces one coordinate of each triangle of the second mesh. */
static void break_mesh(judged_scene *c) {
    const float to = (float)c->number[0];
    fathom_mesh *mesh = &c->world->meshes.items[1];
    float *positions = case_memory(c, mesh->vertex_count * 3 * sizeof *positions);
    if (!positions) return;
    for (uint32_t i = 0; i < 3 * mesh->vertex_count; ++i)
        positions[i] = i % 9 == i / 9 % 9 ? to : mesh->positions[i];
    mesh->positions = positions;
}

/* Breaks every second quad. */
static void break_quads(judged_scene *c) {
    const float to = (float)c->number[0];
    for (uint32_t i = 0; i < c->world->quads.count; i += 2)
        set_one(&c->world->quads.items[i].corner[i / 2 % 4], i, to);
}

static void flat_quads(judged_scene *c) {
    for (uint32_t i = 0; i < c->world->quads.count; i += 2) {
        vec3_f32 *corner = c->world->quads.items[i].corner;
        if (i % 4)
            corner[1] = corner[2] = corner[3] = corner[0];
        else
            corner[2] = corner[1], corner[3] = corner[0];
    }
}

static void break_radii(judged_scene *c) {
    const float to = (float)c->number[0];
    for (uint32_t i = 0; i < c->world->spheres.count; i += 2) c->world->spheres.items[i].radius = to;
}

static void break_centers(judged_scene *c) {
    const float to = (float)c->number[0];
    for (uint32_t i = 0; i < c->world->spheres.count; i += 2)
        set_one(&c->world->spheres.items[i].center, i / 2, to);
}

static const struct {
    const char *words;
    void (*put)(judged_scene *c);
    void (*patch)(judged_scene *c);
    float to; /* value for the patch, passed in number[0] */
} kinds[] = {
    {"triangles with corners on a line", put_collinear, NULL, 0},
    {"triangles that are a point", put_points, NULL, 0},
    {"triangles with two equal corners", put_doubled_corners, NULL, 0},
    {"every triangle twice", put_twice, NULL, 0},
    {"triangles with a NaN", put_whole, break_mesh, NAN},
    {"triangles with infinite coordinates", put_whole, break_mesh, -INFINITY},
    {"quads with a NaN", NULL, break_quads, NAN},
    {"quads with infinite coordinates", NULL, break_quads, INFINITY},
    {"quads that are a line or a point", NULL, flat_quads, 0},
    {"spheres of radius NaN", NULL, break_radii, NAN},
    {"spheres of infinite radius", NULL, break_radii, INFINITY},
    {"spheres of radius 0", NULL, break_radii, 0},
    {"spheres of negative radius", NULL, break_radii, -0.3f},
    {"spheres with a NaN in the centre", NULL, break_centers, NAN},
    {"spheres with an infinite centre", NULL, break_centers, -INFINITY},
};

void broken_make(judged_scene *c, double kind) {
    size_t k = (size_t)kind - 1;
    case_say(c, "%s", kinds[k].words);
    case_ball(c, vec_f64(0, 0, 0), 0.6);
    if (kinds[k].put) {
        kinds[k].put(c);
    } else {
        case_spheres(c, vec_f64(0, 0, 0), 1);
        case_quads(c, vec_f64(0, 0, 0), 1);
    }
    c->patch = kinds[k].patch, c->number[0] = (double)kinds[k].to;
}
