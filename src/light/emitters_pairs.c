/* Pairs of triangles that form a quad. Most emissive meshes are windows, panels and boxes, whose quads
 * were split for a file. Each pair is one emitter: if a light sample had to choose a triangle at random,
 * samples would no longer be a net over the quad. */
#include "light/emitters_inner.h"

#include "trace/search.h"

static bool same(vec3_f32 a, vec3_f32 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/* By positions: both triangles may have vertices of their own. */
bool emitters_join(const vec3_f32 a[3], const vec3_f32 b[3], vec3_f64 out[4]) {
    for (int i = 0; i < 3; ++i) {
        const vec3_f32 first = a[(i + 1) % 3], second = a[(i + 2) % 3];
        for (int k = 0; k < 3; ++k) {
            const vec3_f32 from = b[(k + 1) % 3], to = b[(k + 2) % 3];
            if (!(same(first, to) && same(second, from)) && !(same(first, from) && same(second, to)))
                continue;
            out[0] = widen(a[i]), out[1] = widen(first), out[2] = widen(b[k]), out[3] = widen(second);
            return true;
        }
    }
    return false;
}

/* The triangles lie on different sides of their common side, and in one plane: the fourth corner is no
 * farther from it than the distance that rounding errors may have. */
static bool is_flat(const shape_face *f) {
    const vec3_f64 *c = f->corner, side = sub_f64(c[3], c[1]);
    const vec3_f64 n = cross_f64(sub_f64(c[1], c[0]), sub_f64(c[3], c[0])),
                   m = cross_f64(sub_f64(c[3], c[2]), sub_f64(c[1], c[2]));
    if (!(dot_f64(n, m) > 0) || !(dot_f64(side, side) > 0)) return false;
    return fabs(dot_f64(normalize_f64(n), sub_f64(c[2], c[0]))) <= f->clear;
}

static bool is_pair(const emitters *e, const emitter_run *run, uint32_t index) {
    const fathom_mesh *mesh = &e->w->meshes.items[e->w->geometries.items[run->geometry].first];
    vec3_f32 a[3], b[3];
    vec3_f64 joined[4];
    shape_face face;
    search_corners(mesh, index, a);
    search_corners(mesh, index + 1, b);
    if (!emitters_join(a, b, joined)) return false;
    emitters_face(e, run, index, 0, &face);
    return is_flat(&face);
}

/* Not for moving vertices, which may leave the plane, or varying emission, which is looked up by triangle. */
static bool may_pair(const emitters *e, const emitter_run *run) {
    const world_geometry *g = &e->w->geometries.items[run->geometry];
    if (g->kind != WORLD_MESH || g->moving || run->count % 2 || run->level) return false;
    return !e->texturing ||
           !texturing_varies_emission(e->texturing, world_material(e->w, run->geometry, 0, run->instance));
}

void emitters_pair_runs(emitters *e) {
    for (uint32_t r = 0; r < e->run_count; ++r) {
        emitter_run *run = &e->runs[r];
        if (!run->count || !may_pair(e, run)) continue;
        run->paired = true;
        for (uint32_t i = 0; i < run->count && run->paired; i += 2) run->paired = is_pair(e, run, i);
        if (run->paired) run->count /= 2;
    }
}
