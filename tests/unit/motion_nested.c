/* Moving instances inside moving ones: what tracers are given is the product of both motions at every time,
 * and an automatic camera sees all of it. */
#include "scene/scene.h"
#include "scene/world/world.h"
#include "unit_scene.h"
#include "worlds.h"

static const float body[3][3] = {{-1, -0.5f, 0}, {1, 0, 0.25f}, {0, 1, -0.5f}};
static const double apart[3] = {8, 0, 0}; /* an origin that is not that of the group */

static void add_body(fathom_id group, const double origin[3]) {
    fathom_mesh mesh = default_mesh();
    mesh.positions = body[0], mesh.vertex_count = 3, mesh.indices = (const uint32_t[]){0, 1, 2};
    mesh.triangle_count = 1;
    memcpy(mesh.origin, origin, sizeof mesh.origin);
    assert_ok(context, fathom_scene_add_mesh(scene, group, &mesh, NULL));
}

/* Grows, turns by `angle` about z, then moves. */
static affine_f64 map_of(double angle, double size, vec3_f64 shift) {
    const affine_f64 turn = affine_rotation_axis((vec3_f64){0, 0, 1}, angle),
                     grow = affine_scaling((vec3_f64){size, size, size}), move = affine_translation(shift),
                     turned = affine_compose(&turn, &grow);
    return affine_compose(&move, &turned);
}

/* Keys give angle, size and shift, each of which changes evenly between them. */
typedef struct path {
    double times[2], angle[2], size[2];
    vec3_f64 shift[2];
} path;

static affine_f64 path_at(const path *p, double time) {
    const double u = fmin(fmax((time - p->times[0]) / (p->times[1] - p->times[0]), 0), 1);
    return map_of((1 - u) * p->angle[0] + u * p->angle[1], (1 - u) * p->size[0] + u * p->size[1],
                  madd_f64(scale_f64(1 - u, p->shift[0]), u, p->shift[1]));
}

static void place(fathom_id group, fathom_id parent, const path *p) {
    fathom_instance instance = default_instance();
    double maps[2][12];
    for (int k = 0; k < 2; ++k) {
        const affine_f64 map = path_at(p, p->times[k]);
        memcpy(maps[k], map.m, sizeof maps[k]);
    }
    instance.group = group, instance.parent = parent;
    instance.key_count = 2, instance.key_times = p->times, instance.key_transforms = maps[0];
    assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
}

/* The keys of the inner motion lie between those of the outer one. */
static const path outer = {{0, 1}, {0, 1.2}, {1, 1}, {{0, 0, 0}, {3, 0, 0}}},
                  inner = {{0.25, 0.75}, {0.5, 0}, {1, 2}, {{2, 0, 0}, {2, 4, 1}}};

/* outer(t) · middle · inner(t): root > outer > middle, at rest > inner > body. */
static affine_f64 build_chain(const double origin[3]) {
    const fathom_id a = add_group(), b = add_group(), c = add_group();
    const affine_f64 middle = affine_rotation_axis((vec3_f64){1, 0, 0}, 1.5707963267948966);
    add_body(c, origin);
    place(a, FATHOM_ROOT, &outer);
    place_still(b, a, &middle);
    place(c, b, &inner);
    return middle;
}

static affine_f64 chain_at(const affine_f64 *middle, double time) {
    const affine_f64 first = path_at(&outer, time), last = path_at(&inner, time),
                     both = affine_compose(middle, &last);
    return affine_compose(&first, &both);
}

/* The world gives even steps, off by at most 2^-14 of the radius of what moves and 2^-21 of how far it is,
 * both below 32, at 64 times and at the keys (world_motion.c); no more than twice that between. */
static void expect_products(const double origin[3]) {
    const affine_f64 middle = build_chain(origin);
    scene->camera.shutter[0] = 0, scene->camera.shutter[1] = 1;
    world *w = new_world(scene);
    assert_int_equal(w->instances.count, 1);
    const double off = 2 * (0x1p-14 + 0x1p-21) * 32;
    for (int t = 0; t <= 100; ++t) {
        world_instance at;
        const float time = (float)t / 100;
        world_move_instance(w, &w->instances.items[0], time, &at);
        const affine_f64 exact = chain_at(&middle, (double)time);
        for (int i = 0; i < 3; ++i) {
            const vec3_f64 p = widen(load_f32(body[i])),
                           expected = affine_point(&exact, add_f64(load_f64(origin), p));
            vec3_f64 found = w->origin;
            double *to[3] = {&found.x, &found.y, &found.z};
            for (int r = 0; r < 3; ++r) {
                const float *m = at.to_world[r];
                *to[r] += (double)m[0] * p.x + (double)m[1] * p.y + (double)m[2] * p.z + (double)m[3];
            }
            if (!(length_f64(sub_f64(found, expected)) <= off))
                fail_msg("at %g: (%g, %g, %g), expected (%g, %g, %g)", (double)time, found.x, found.y,
                         found.z, expected.x, expected.y, expected.z);
        }
    }
}

UNIT_TEST(motions_of_motions_are_products) { expect_products((double[3]){0, 0, 0}); }

UNIT_TEST(motions_of_motions_of_meshes_apart_are_products) { expect_products(apart); }

/* Nine tenths of the image in one direction, and no more in either. Sixteen looks at 1.2 radians are 0.075
 * apart; between two, they miss at most 1 - cos 0.0375, 7e-4, of a distance below 10, from an eye further
 * away than 1. */
UNIT_TEST(an_automatic_camera_sees_all_motions) {
    const affine_f64 middle = build_chain((double[3]){0, 0, 0});
    fathom_settings settings;
    fathom_scene_settings(scene, &settings);
    settings.width = settings.height = 64;
    assert_ok(context, fathom_scene_set_settings(scene, &settings));
    scene->camera.shutter[0] = 0, scene->camera.shutter[1] = 1;
    assert_ok(context, fathom_scene_complete(scene));
    const fathom_camera *c = &scene->camera;
    const double half = c->h / c->d / 2;
    double most = 0;
    for (int t = 0; t <= 400; ++t) {
        const affine_f64 at = chain_at(&middle, t / 400.0);
        for (int i = 0; i < 3; ++i) {
            const vec3_f64 d = sub_f64(affine_point(&at, widen(load_f32(body[i]))), load_f64(c->origin));
            const double depth = -dot_f64(d, load_f64(c->z));
            assert_true(depth > 1);
            most = fmax(most, fabs(dot_f64(d, load_f64(c->x))) / depth / half);
            most = fmax(most, fabs(dot_f64(d, load_f64(c->y))) / depth / half);
        }
    }
    assert_near(most, 0.9, 0.01);
}

int main(void) { return unit_main_each(open_scene, NULL); }
