/* Motion in uniform steps, as tracers need it, and positions between two steps. */
#include "scene/world/world_build.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

/* ---- steps ---- */

/* Returns the step before the time; *u is the fraction of the way to the next step. The product is rounded as
 * in Embree. */
static uint32_t world_step(uint32_t steps, float time, double *u) {
    const float at = time * (float)(steps - 1);
    float whole = floorf(at);
    if (!(whole > 0)) whole = 0;
    if (whole > (float)(steps - 2)) whole = (float)(steps - 2);
    *u = (double)(at - whole);
    return (uint32_t)whole;
}

/* Numbers of intervals to try, up to Embree's limit. */
static const uint32_t intervals[] = {1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64, 80, 96, 128};
#define INTERVALS (sizeof intervals / sizeof *intervals)
_Static_assert(WORLD_STEPS_MOST == 129, "the last of them");

/* Below 3.6 degrees from one step to the next, Embree interpolates rotations on the chord; above, on an arc
 * that it only approximates, to about 1e-5. So faster motions are matrices. */
#define TURN_COSINE 0.99965732 /* cosine of half of 3 degrees */

/* ---- instances ---- */

typedef struct way {
    world_place_fn place;
    const void *user;
    const scene_bounds *inside;
    double open, close;
    const double *times; /* of keys */
    size_t time_count;
    double slack;
} way;

static float to_float(double x) { return fabs(x) < (double)FLT_MIN ? 0 : (float)x; }

/* Rounded to float, as tracers get them. */
static motion_parts rounded(const motion_parts *p) {
    motion_parts out;
    const double *from = (const double *)p;
    double *to = (double *)&out;
    for (size_t i = 0; i < sizeof *p / sizeof *from; ++i) to[i] = (double)to_float(from[i]);
    return out;
}

static void sample(const way *y, uint32_t steps, world_motion *out) {
    out->steps = steps, out->linear = false;
    for (uint32_t k = 0; k < steps; ++k) {
        const double u = (double)k / (steps - 1);
        const affine_f64 at =
            y->place(y->user, k + 1 == steps ? y->close : y->open + u * (y->close - y->open));
        const motion_parts exact = motion_take_apart(&at);
        out->parts[k] = rounded(&exact);
        out->linear |= k && motion_turn_cosine(&out->parts[k - 1], &out->parts[k]) < TURN_COSINE;
    }
}

affine_f64 world_motion_map(const world_motion *motion, uint32_t step) {
    affine_f64 out = motion_put_together(&motion->parts[step]);
    for (int i = 0; i < 12; ++i) out.m[i / 4][i % 4] = (double)to_float(out.m[i / 4][i % 4]);
    return out;
}

/* Between a step and the next one, as tracers interpolate. */
static affine_f64 map_between(const world_motion *motion, uint32_t step, double u) {
    if (!motion->linear) {
        const motion_parts at = motion_on_chord(&motion->parts[step], &motion->parts[step + 1], u);
        return motion_put_together(&at);
    }
    affine_f64 out = world_motion_map(motion, step);
    const affine_f64 next = world_motion_map(motion, step + 1);
    for (int i = 0; i < 12; ++i)
        out.m[i / 4][i % 4] = (1 - u) * out.m[i / 4][i % 4] + u * next.m[i / 4][i % 4];
    return out;
}

/* The maximum position error of the box's corners at u in [0, 1] of the shutter interval. */
static double off_at(const way *y, const world_motion *motion, double u) {
    const affine_f64 exact = y->place(y->user, y->open + u * (y->close - y->open));
    const double at = u * (motion->steps - 1), whole = fmin(floor(at), motion->steps - 2.0);
    const affine_f64 made = map_between(motion, (uint32_t)whole, at - whole);
    double most = 0;
    for (int i = 0; i < 8; ++i) {
        const vec3_f64 corner = bounds_corner(y->inside, i);
        most = fmax(most, length_f64(sub_f64(affine_point(&made, corner), affine_point(&exact, corner))));
    }
    return most;
}

/* The least number of times to look at. */
#define LOOKS 64

/* The largest error that was found, or the first above `enough`; NaN if there is one. A curve is farthest
 * from its chord near the middle, so each interval is looked at in its middle, and few intervals also beside
 * it. */
static double find_error(const way *y, const world_motion *motion, double enough) {
    const uint32_t spans = motion->steps - 1, looks = spans * ((LOOKS / spans) | 1);
    double most = 0;
    for (size_t i = 0; i < looks + y->time_count && most <= enough; ++i) {
        const double u =
            i < looks ? ((double)i + 0.5) / looks : (y->times[i - looks] - y->open) / (y->close - y->open);
        const double off = u > 0 && u < 1 ? off_at(y, motion, u) : 0;
        if (!(off <= most)) most = off;
    }
    return most;
}

/* The allowed error: 2^-14 of the radius, the same as for far objects (world_place.c), plus some rounding
 * errors of float. */
static double slack_of(const way *y) {
    const affine_f64 at = y->place(y->user, y->open);
    const scene_bounds there = bounds_transformed(y->inside, &at);
    if (bounds_is_empty(&there)) return INFINITY;
    return 0x1p-14 * bounds_radius(&there) +
           0x1p-21 * (length_f64(bounds_center(&there)) + bounds_radius(&there));
}

static void keep_error(world *w, double error, fathom_id id) {
    if (error > w->motion_error) w->motion_error = error, w->motion_error_of = id;
}

fathom_status world_add_motion(world *w, world_place_fn place, const void *user, const scene_bounds *inside,
                               const double *times, size_t time_count, fathom_id id,
                               world_instance *instance) {
    const double *shutter = w->scene->camera.shutter;
    way y = {place, user, inside, shutter[0], shutter[1], times, time_count, 0};
    world_motion motion = {.parts = malloc(WORLD_STEPS_MOST * sizeof *motion.parts)};
    if (!motion.parts || !array_push(&w->motions, motion)) {
        free(motion.parts);
        return fail_memory(w->scene->context, WORLD_STEPS_MOST * sizeof *motion.parts);
    }
    y.slack = slack_of(&y);
    bool fine = false;
    for (size_t i = 0; i < INTERVALS && !fine; ++i) {
        sample(&y, intervals[i] + 1, &motion);
        fine = !motion.linear && find_error(&y, &motion, y.slack) <= y.slack;
    }
    w->motions.items[w->motions.count - 1] = motion;
    w->moves = true;
    const double error = fine ? 0 : find_error(&y, &motion, INFINITY);
    if (!(error <= y.slack)) keep_error(w, error, id);
    instance->moving = (uint32_t)w->motions.count;
    const affine_f64 first = map_between(&motion, 0, 0);
    if (world_instance_set(instance, &first)) return FATHOM_OK;
    return scene_fail_instance(
        w->scene, id, "its frame, with those around it, flattens space or leaves the range of float");
}

void world_move_instance(const world *w, const world_instance *instance, float time, world_instance *moved) {
    const world_motion *motion = &w->motions.items[instance->moving - 1];
    double u;
    const uint32_t step = world_step(motion->steps, time, &u);
    const affine_f64 map = map_between(motion, step, u);
    *moved = *instance;
    world_instance_set(moved, &map);
}

/* ---- vertices ---- */

/* The maximum distance of a key from the nearest step, as a fraction of an interval, 0 to 1/2. The error of a
 * vertex is at most this fraction of the change of its motion at the key. */
static double misses(const fathom_mesh *m, const double shutter[2], uint32_t steps) {
    double most = 0;
    for (uint32_t k = 0; k < m->key_count; ++k) {
        const double u = (m->key_times[k] - shutter[0]) / (shutter[1] - shutter[0]) * (steps - 1);
        if (u > 0 && u < steps - 1) most = fmax(most, fabs(u - round(u)));
    }
    return most;
}

static uint32_t choose_steps(const fathom_mesh *m, const double shutter[2]) {
    for (size_t i = 0; i < INTERVALS; ++i) {
        if (misses(m, shutter, intervals[i] + 1) <= 0x1p-14) return intervals[i] + 1;
    }
    return WORLD_STEPS_MOST;
}

static bool is_still(const fathom_mesh *m, const double shutter[2]) {
    const size_t vector = 3 * sizeof(float);
    return !motion_keys_differ(m->key_times, m->key_count, shutter, m->key_positions,
                               vector * m->vertex_count) &&
           !(m->normals && motion_keys_differ(m->key_times, m->key_count, shutter, m->key_normals,
                                              vector * m->normal_count));
}

/* Floats that Embree may read beyond the last vertex. */
#define BEYOND 4

float *world_new_rows(size_t steps, size_t count) {
    float *rows = malloc((steps * count + BEYOND) * sizeof *rows);
    if (rows) memset(rows + steps * count, 0, BEYOND * sizeof *rows);
    return rows;
}

bool world_add_vertex_motion(world *w, world_geometry *geometry, fathom_mesh *mesh, mesh_facts *facts) {
    const double *shutter = w->scene->camera.shutter;
    const bool still = is_still(mesh, shutter);
    const size_t steps = still ? 1 : choose_steps(mesh, shutter);
    const size_t points = 3 * (size_t)mesh->vertex_count, normals = 3 * (size_t)mesh->normal_count;
    world_vertex_motion made = {.steps = (uint32_t)steps, .positions = world_new_rows(steps, points)};
    if (mesh->normals) made.normals = world_new_rows(steps, normals);
    const bool room = still ? array_room(&w->still_vertices, 2) : array_room(&w->vertex_motions, 1);
    if (!room || !made.positions || (mesh->normals && !made.normals)) {
        free(made.positions);
        free(made.normals);
        return false;
    }
    if (still)
        w->still_vertices.items[w->still_vertices.count++] = made.positions,
        w->still_vertices.items[w->still_vertices.count++] = made.normals;
    else
        w->vertex_motions.items[w->vertex_motions.count++] = made;
    for (size_t k = 0; k < steps; ++k) {
        const double u = still ? 0 : (double)k / (double)(steps - 1);
        const double time = shutter[0] + u * (shutter[1] - shutter[0]);
        motion_rows(mesh, mesh->key_positions, points, time, made.positions + k * points);
        if (made.normals) motion_rows(mesh, mesh->key_normals, normals, time, made.normals + k * normals);
    }
    mesh->positions = made.positions, mesh->position_stride = 3 * sizeof(float);
    if (made.normals) mesh->normals = made.normals, mesh->normal_stride = 3 * sizeof(float);
    if (still) return mesh_look_at_triangles(w->scene->context, "indices", mesh, facts) == FATHOM_OK;
    /* A triangle without area at one time may have an area at another. */
    facts->flat = 0;
    geometry->moving = (uint32_t)w->vertex_motions.count;
    w->moves = true;
    return true;
}

static void fetch(const float *rows, size_t count, const uint32_t index[3], double u, vec3_f32 out[3]) {
    for (int k = 0; k < 3; ++k) {
        const float *a = rows + 3 * (size_t)index[k];
        out[k] = narrow(madd_f64(scale_f64(1 - u, widen(load_f32(a))), u, widen(load_f32(a + count))));
    }
}

void world_corners_when(const world *w, const world_geometry *geometry, uint32_t triangle, float time,
                        vec3_f32 corner[3], vec3_f32 normal[3]) {
    const fathom_mesh *mesh = &w->meshes.items[geometry->first];
    const size_t at = 3 * (size_t)triangle;
    const uint32_t *points = mesh->indices + at,
                   *normals = (mesh->normal_indices ? mesh->normal_indices : mesh->indices) + at;
    if (!geometry->moving) {
        for (int k = 0; k < 3; ++k) {
            corner[k] = load_f32(mesh_vertex(mesh, points[k]));
            const char *n = (const char *)mesh->normals + mesh->normal_stride * normals[k];
            if (normal && mesh->normals) normal[k] = load_f32((const float *)(const void *)n);
        }
        return;
    }
    const world_vertex_motion *m = &w->vertex_motions.items[geometry->moving - 1];
    double u;
    const size_t step = world_step(m->steps, time, &u);
    const size_t rows = 3 * (size_t)mesh->vertex_count, normal_rows = 3 * (size_t)mesh->normal_count;
    fetch(m->positions + step * rows, rows, points, u, corner);
    if (normal && m->normals) fetch(m->normals + step * normal_rows, normal_rows, normals, u, normal);
}

void world_motion_destroy(world *w) {
    for (size_t i = 0; i < w->motions.count; ++i) free(w->motions.items[i].parts);
    for (size_t i = 0; i < w->vertex_motions.count; ++i) {
        free(w->vertex_motions.items[i].positions);
        free(w->vertex_motions.items[i].normals);
    }
    for (size_t i = 0; i < w->still_vertices.count; ++i) free(w->still_vertices.items[i]);
    array_free(&w->motions);
    array_free(&w->vertex_motions);
    array_free(&w->still_vertices);
}
