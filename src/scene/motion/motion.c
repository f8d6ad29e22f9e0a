#include "scene/motion/motion.h"

#include <string.h>

/* ---- parts ---- */

/* The quaternion of a rotation matrix, given by its columns (Shepperd 1978): the largest of the four numbers
 * is computed first. */
static void quaternion_of(vec3_f64 x, vec3_f64 y, vec3_f64 z, double q[4]) {
    const double square[4] = {1 + x.x + y.y + z.z, 1 + x.x - y.y - z.z, 1 - x.x + y.y - z.z,
                              1 - x.x - y.y + z.z};
    int most = 0;
    for (int i = 1; i < 4; ++i)
        if (square[i] > square[most]) most = i;
    const double r = y.z - z.y, i = z.x - x.z, j = x.y - y.x, a = y.x + x.y, b = x.z + z.x, c = z.y + y.z;
    const double rows[4][4] = {
        {square[0], r, i, j}, {r, square[1], a, b}, {i, a, square[2], c}, {j, b, c, square[3]}};
    const double scale = 1 / (2 * sqrt(square[most]));
    for (int k = 0; k < 4; ++k) q[k] = rows[most][k] * scale;
}

motion_parts motion_take_apart(const affine_f64 *map) {
    const double(*m)[4] = map->m;
    const vec3_f64 a = {m[0][0], m[1][0], m[2][0]}, b = {m[0][1], m[1][1], m[2][1]},
                   c = {m[0][2], m[1][2], m[2][2]};
    motion_parts out = {.shift = {m[0][3], m[1][3], m[2][3]}};
    const vec3_f64 x = normalize_f64(a), y = normalize_f64(madd_f64(b, -dot_f64(x, b), x)),
                   z = cross_f64(x, y);
    out.scale[0] = dot_f64(x, a), out.scale[1] = dot_f64(y, b), out.scale[2] = dot_f64(z, c);
    out.skew[0] = dot_f64(x, b), out.skew[1] = dot_f64(x, c), out.skew[2] = dot_f64(y, c);
    quaternion_of(x, y, z, out.turn);
    return out;
}

affine_f64 motion_put_together(const motion_parts *p) {
    affine_f64 out = affine_rotation((double[4]){p->turn[1], p->turn[2], p->turn[3], p->turn[0]});
    for (int i = 0; i < 3; ++i) {
        const double x = out.m[i][0], y = out.m[i][1], z = out.m[i][2];
        out.m[i][0] = x * p->scale[0];
        out.m[i][1] = x * p->skew[0] + y * p->scale[1];
        out.m[i][2] = x * p->skew[1] + y * p->skew[2] + z * p->scale[2];
        out.m[i][3] = p->shift[i];
    }
    return out;
}

static double dot_turns(const motion_parts *a, const motion_parts *b) {
    double sum = 0;
    for (int i = 0; i < 4; ++i) sum += a->turn[i] * b->turn[i];
    return sum;
}

double motion_turn_cosine(const motion_parts *a, const motion_parts *b) { return fabs(dot_turns(a, b)); }

/* The sum of both quaternions with these weights, normalised. */
static void mix_turns(const double a[4], const double b[4], const double weights[2], double out[4]) {
    double square = 0;
    for (int i = 0; i < 4; ++i) {
        out[i] = weights[0] * a[i] + weights[1] * b[i];
        square += out[i] * out[i];
    }
    for (int i = 0; i < 4; ++i) out[i] /= sqrt(square);
}

motion_parts motion_on_chord(const motion_parts *a, const motion_parts *b, double u) {
    motion_parts out;
    for (int i = 0; i < 3; ++i) {
        out.scale[i] = (1 - u) * a->scale[i] + u * b->scale[i];
        out.skew[i] = (1 - u) * a->skew[i] + u * b->skew[i];
        out.shift[i] = (1 - u) * a->shift[i] + u * b->shift[i];
    }
    mix_turns(a->turn, b->turn, (const double[]){1 - u, dot_turns(a, b) < 0 ? -u : u}, out.turn);
    return out;
}

/* The cosine of 1e-5 radians. An arc as small and its chord differ by less than 1e-17. */
#define CHORD_COSINE (1 - 0.5e-10)

/* The arc is halved until it is its chord, because roots have the same bits on every processor, and sines do
 * not. Its ends are sums of a and b. */
void motion_slerp(const double a[4], const double b[4], double u, double out[4]) {
    double aa = 0, bb = 0, cosine = 0;
    for (int i = 0; i < 4; ++i) aa += a[i] * a[i], bb += b[i] * b[i], cosine += a[i] * b[i];
    double from[2] = {aa > 0 ? 1 / sqrt(aa) : 0, 0}, to[2] = {0, bb > 0 ? copysign(1 / sqrt(bb), cosine) : 0};
    cosine *= from[0] * to[1];
    while (cosine < CHORD_COSINE) {
        cosine = sqrt(0.5 + 0.5 * cosine);
        const double middle[2] = {(from[0] + to[0]) / (2 * cosine), (from[1] + to[1]) / (2 * cosine)};
        u *= 2;
        memcpy(u < 1 ? to : from, middle, sizeof middle);
        if (u >= 1) u -= 1;
    }
    mix_turns(a, b, (const double[]){(1 - u) * from[0] + u * to[0], (1 - u) * from[1] + u * to[1]}, out);
}

motion_parts motion_between(const motion_parts *a, const motion_parts *b, double u) {
    motion_parts out = motion_on_chord(a, b, u);
    motion_slerp(a->turn, b->turn, u, out.turn);
    return out;
}

/* ---- keys ---- */

uint32_t motion_key(const double *times, uint32_t count, double time, double *u) {
    uint32_t k = 0;
    *u = 0;
    if (!(time > times[0])) return 0;
    if (time >= times[count - 1]) return count - 1;
    while (times[k + 1] <= time) ++k;
    *u = (time - times[k]) / (times[k + 1] - times[k]);
    return k;
}

static affine_f64 place_of_keys(const double *times, const double *maps, uint32_t count, double time) {
    double u;
    const uint32_t k = motion_key(times, count, time, &u);
    affine_f64 a, b;
    affine_load(&a, maps + 12 * (size_t)k);
    if (u == 0 || memcmp(maps + 12 * (size_t)k, maps + 12 * (size_t)(k + 1), 12 * sizeof *maps) == 0)
        return a;
    affine_load(&b, maps + 12 * (size_t)(k + 1));
    const motion_parts from = motion_take_apart(&a), to = motion_take_apart(&b),
                       at = motion_between(&from, &to, u);
    return motion_put_together(&at);
}

affine_f64 motion_place(const fathom_instance *instance, double time) {
    if (instance->key_count)
        return place_of_keys(instance->key_times, instance->key_transforms, instance->key_count, time);
    affine_f64 map;
    affine_load(&map, instance->transform);
    return map;
}

bool motion_keys_differ(const double *times, uint32_t count, const double shutter[2], const void *rows,
                        size_t row_bytes) {
    if (!count || !(shutter[1] > shutter[0])) return false;
    double u;
    const uint32_t first = motion_key(times, count, shutter[0], &u);
    uint32_t last = motion_key(times, count, shutter[1], &u);
    last += u > 0;
    for (uint32_t k = first; k < last; ++k) {
        const char *row = (const char *)rows + k * row_bytes;
        if (memcmp(row, row + row_bytes, row_bytes) != 0) return true;
    }
    return false;
}

bool motion_is_moving(const fathom_instance *instance, const double shutter[2]) {
    return motion_keys_differ(instance->key_times, instance->key_count, shutter, instance->key_transforms,
                              12 * sizeof(double));
}

/* How far a corner of the box may be from the chord of its way. The way is the rotation, by `angle` at
 * constant speed, of a point that moves straight from p to q. So its second derivative is at most
 * angle² |p| + 2 angle |q - p|, and an eighth of that is the distance. */
static double bulge(motion_parts from, motion_parts to, double angle, const scene_bounds *inside) {
    double most = 0;
    for (int i = 0; i < 3; ++i) from.shift[i] = to.shift[i] = 0;
    memcpy(to.turn, from.turn, sizeof to.turn);
    const affine_f64 a = motion_put_together(&from), b = motion_put_together(&to);
    for (int i = 0; i < 8; ++i) {
        const vec3_f64 p = affine_point(&a, bounds_corner(inside, i)),
                       q = affine_point(&b, bounds_corner(inside, i));
        const double far = fmax(length_f64(p), length_f64(q));
        most = fmax(most, angle * (angle * far + 2 * length_f64(sub_f64(q, p))) / 8);
    }
    return most;
}

/* In radians. The bounds of a turn are then too large by at most 2^-13 of its radius. */
#define TURN_STEP 0x1p-5

static void add_around(const affine_f64 *map, double beyond, const scene_bounds *inside, scene_bounds *all) {
    const scene_bounds there = bounds_transformed(inside, map);
    const vec3_f64 around = {beyond, beyond, beyond};
    bounds_add(all, sub_f64(there.lower, around));
    bounds_add(all, add_f64(there.upper, around));
}

/* Adds the bounds of the way between two times that have no key between them. */
static void add_way(const affine_f64 *from, const affine_f64 *to, const scene_bounds *inside,
                    scene_bounds *all) {
    const motion_parts a = motion_take_apart(from), b = motion_take_apart(to);
    const double angle = 2 * acos(fmin(motion_turn_cosine(&a, &b), 1));
    const int steps = 1 + (int)(angle / TURN_STEP);
    motion_parts at = a;
    affine_f64 map = *from;
    for (int k = 1; k <= steps; ++k) {
        const motion_parts next = motion_between(&a, &b, (double)k / steps);
        const double beyond = bulge(at, next, angle / steps, inside);
        add_around(&map, beyond, inside, all);
        map = k < steps ? motion_put_together(&next) : *to;
        add_around(&map, beyond, inside, all);
        at = next;
    }
}

scene_bounds motion_bounds(const fathom_instance *instance, const double shutter[2],
                           const scene_bounds *inside) {
    affine_f64 map = motion_place(instance, shutter[0]);
    scene_bounds all = bounds_transformed(inside, &map);
    if (bounds_is_empty(&all) || !motion_is_moving(instance, shutter)) return all;
    for (uint32_t k = 0; k <= instance->key_count; ++k) {
        const double time = k < instance->key_count ? instance->key_times[k] : shutter[1];
        if (!(time > shutter[0] && time <= shutter[1])) continue;
        const affine_f64 next = motion_place(instance, time);
        add_way(&map, &next, inside, &all);
        map = next;
    }
    return all;
}

void motion_rows(const fathom_mesh *mesh, const float *rows, size_t count, double time, float *out) {
    double u;
    const uint32_t k = motion_key(mesh->key_times, mesh->key_count, time, &u);
    const float *a = rows + k * count, *b = rows + (k + (u > 0)) * count;
    for (size_t i = 0; i < count; ++i)
        out[i] = u > 0 ? (float)((1 - u) * (double)a[i] + u * (double)b[i]) : a[i];
}

/* ---- the camera ---- */

fathom_camera motion_camera(const fathom_camera *camera, double time) {
    fathom_camera out = *camera;
    out.key_count = 0, out.key_times = out.key_frames = NULL;
    if (!camera->key_count) return out;
    const affine_f64 at = place_of_keys(camera->key_times, camera->key_frames, camera->key_count, time);
    for (int i = 0; i < 3; ++i)
        out.x[i] = at.m[i][0], out.y[i] = at.m[i][1], out.z[i] = at.m[i][2], out.origin[i] = at.m[i][3];
    return out;
}

bool motion_camera_moves(const fathom_camera *camera) {
    return motion_keys_differ(camera->key_times, camera->key_count, camera->shutter, camera->key_frames,
                              12 * sizeof(double));
}

fathom_camera motion_camera_shown(const fathom_camera *camera, bool blurred) {
    const double *shutter = camera->shutter;
    fathom_camera out = *camera;
    if (!blurred && motion_camera_moves(camera))
        return motion_camera(camera, shutter[0] + 0.5 * (shutter[1] - shutter[0]));
    out.key_count = 0, out.key_times = out.key_frames = NULL;
    return out;
}

/* ---- checks and copies ---- */

fathom_status motion_check_keys(fathom_context *context, const double *times, uint32_t count) {
    if (!times) return fail_null(context, "key_times");
    for (uint32_t k = 0; k < count; ++k) {
        if (!isfinite(times[k]) || (k && !(times[k] > times[k - 1])))
            return fail_item(context, FATHOM_BAD_INPUT, "key_times", k,
                             "expected finite times, each later than the one before, found %g", times[k]);
    }
    return FATHOM_OK;
}

fathom_status motion_copy_keys(fathom_scene *scene, uint32_t count, size_t numbers_each, const double **times,
                               const double **numbers) {
    void *own;
    const size_t all = count * (1 + numbers_each);
    fathom_status status = scene_allocate_items(scene, all, sizeof(double), &own);
    if (status != FATHOM_OK) return status;
    double *to = own;
    memcpy(to, *times, count * sizeof *to);
    if (numbers) memcpy(to + count, *numbers, count * numbers_each * sizeof *to);
    *times = to;
    if (numbers) *numbers = to + count;
    return FATHOM_OK;
}
