/* Size and place: the same shapes at any scale, near the origin, and far from it. */
#include "verify/extremes/case.h"

#include <string.h>

static const vec3_f64 middle = {0, 0, 0};

void scale_spheres(extremes_case *c, double scale) {
    case_say(c, "12 spheres in a ball of radius %g", scale);
    put_spheres(c, FATHOM_ROOT, middle, scale);
}

void scale_quads(extremes_case *c, double scale) {
    case_say(c, "12 quads in a ball of radius %g", scale);
    put_quads(c, FATHOM_ROOT, middle, scale);
}

void scale_triangles(extremes_case *c, double scale) {
    case_say(c, "a closed mesh of 168 triangles, radius %g", scale);
    put_ball(c, FATHOM_ROOT, middle, scale);
}

static void put_mixture(extremes_case *c, vec3_f64 at) {
    put_spheres(c, FATHOM_ROOT, at, 1);
    put_quads(c, FATHOM_ROOT, at, 1);
    put_ball(c, FATHOM_ROOT, at, 0.6);
}

static vec3_f64 place_at(double offset) { return scale_f64(offset, vec_f64(0.48, -0.6, 0.64)); }

void offset_near(extremes_case *c, double offset) {
    case_say(c, "all shapes, 1 in size, %g from the origin, the camera beside them", offset);
    vec3_f64 at = place_at(offset);
    put_mixture(c, at);
    put_camera(c, add_f64(at, vec_f64(2, 1, 4)), at);
    c->families |= 1u << RAYS_CAMERA;
}

/* ---- as if nothing were moved near the origin ---- */

static vec3_f32 moved(vec3_f32 p, vec3_f64 by) { return narrow(add_f64(widen(p), by)); }

static void move_mesh(extremes_case *c, fathom_mesh *mesh, vec3_f64 by) {
    float *positions = case_memory(c, mesh->vertex_count * 3 * sizeof *positions);
    if (!positions) return;
    for (uint32_t i = 0; i < mesh->vertex_count; ++i)
        store_f32(positions + 3 * (size_t)i, moved(load_f32(mesh->positions + 3 * (size_t)i), by));
    mesh->positions = positions;
}

static void move_world(extremes_case *c) {
    world *w = c->world;
    vec3_f64 by = place_at(c->number[0]);
    for (size_t i = 0; i < w->spheres.count; ++i)
        w->spheres.items[i].center = moved(w->spheres.items[i].center, by);
    for (size_t i = 0; i < 4 * w->quads.count; ++i) {
        vec3_f32 *corner = &w->quads.items[i / 4].corner[i % 4];
        *corner = moved(*corner, by);
    }
    for (size_t i = 0; i < w->meshes.count && c->status == FATHOM_OK; ++i)
        move_mesh(c, &w->meshes.items[i], by);
}

void offset_raw(extremes_case *c, double offset) {
    case_say(c, "all shapes, 1 in size, %g from the origin in float, not moved", offset);
    put_mixture(c, middle);
    c->number[0] = offset;
    c->patch = move_world;
}
