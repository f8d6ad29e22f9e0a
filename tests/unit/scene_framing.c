/* The automatic camera: what it has in view, how large, and where its up is. */
#include "random.h"
#include "scene/camera/camera.h"
#include "scene/camera/extent.h"
#include "scene/scene.h"
#include "unit_scene.h"

/* ---- scenes of points, told apart from what holds them ---- */

#define POINTS_MOST 64

typedef struct points {
    vec3_f64 items[POINTS_MOST];
    size_t count;
} points;

/* A long, flat, lopsided body. Multiples of 1/8: each is a float, and so is its double. */
static const float body[6][3] = {{-2, -0.5f, 1},         {3, 0.25f, 0},      {0.5f, 2, -4},
                                 {-1.5f, 0.125f, -6.5f}, {2.5f, -1, 2.875f}, {0, 0.75f, 0.5f}};
static const uint32_t faces[12] = {0, 1, 2, 1, 2, 3, 2, 3, 4, 3, 4, 5};

static void add_body(fathom_id group, const double origin[3]) {
    fathom_mesh mesh = default_mesh();
    mesh.positions = body[0], mesh.vertex_count = 6, mesh.indices = faces, mesh.triangle_count = 4;
    for (int i = 0; i < 3; ++i) mesh.origin[i] = origin[i];
    assert_ok(context, fathom_scene_add_mesh(scene, group, &mesh, NULL));
}

static void note_body(points *p, const affine_f64 *map) {
    for (int i = 0; i < 6; ++i) p->items[p->count++] = affine_point(map, widen(load_f32(body[i])));
}

static void shape_image(uint32_t width, uint32_t height) {
    fathom_settings settings;
    fathom_scene_settings(scene, &settings);
    settings.width = width, settings.height = height;
    assert_ok(context, fathom_scene_set_settings(scene, &settings));
}

/* The extent in the image, from -1 (left, bottom) to 1 (right, top). */
typedef struct extent {
    double low[2], high[2];
} extent;

static extent extent_of(const points *p) {
    const fathom_camera *c = &scene->camera;
    const double h = c->h / c->d / 2, w = h * scene->settings.width / scene->settings.height;
    extent out = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    for (size_t i = 0; i < p->count; ++i) {
        const vec3_f64 d = sub_f64(p->items[i], load_f64(c->origin));
        const double depth = -dot_f64(d, load_f64(c->z));
        assert_true(depth > 0);
        const double at[2] = {dot_f64(d, load_f64(c->x)) / depth / w, dot_f64(d, load_f64(c->y)) / depth / h};
        for (int k = 0; k < 2; ++k)
            out.low[k] = fmin(out.low[k], at[k]), out.high[k] = fmax(out.high[k], at[k]);
    }
    return out;
}

/* 90 % of the tighter direction, less of the other, and the middle in the middle. Tolerances: the tighter one
 * is as good as the roundings, tens of 2^-53 over a depth of more than a tenth of the largest coordinate,
 * `reach` times the body's own size from the origin; of the slack one's centring a hundredth of the image is
 * promised. */
static void assert_framed(const points *p, double reach) {
    const extent e = extent_of(p);
    const double tight = 1024 * reach * 0x1p-53;
    const double size[2] = {e.high[0] - e.low[0], e.high[1] - e.low[1]};
    const int across = size[0] > size[1] ? 0 : 1;
    assert_near(e.high[across], 0.9, tight);
    assert_near(e.low[across], -0.9, tight);
    assert_true(size[1 - across] <= 1.8 + tight);
    assert_near(e.high[1 - across] + e.low[1 - across], 0, 0.01);
}

static const uint32_t sizes[][2] = {{1280, 720}, {720, 1280}, {512, 512}, {4000, 100}, {100, 4000}, {3, 2}};
#define SIZES (sizeof sizes / sizeof *sizes)

UNIT_TEST(the_scene_fills_nine_tenths_of_the_tighter_direction) {
    const affine_f64 identity = affine_identity();
    points p = {.count = 0};
    note_body(&p, &identity);
    add_body(FATHOM_ROOT, (double[3]){0, 0, 0});
    for (size_t i = 0; i < SIZES; ++i) {
        shape_image(sizes[i][0], sizes[i][1]);
        scene->has_camera = false;
        assert_ok(context, fathom_scene_complete(scene));
        assert_framed(&p, 1);
    }
}

/* Twenty times as deep, so that near ends look much larger than far ones: seen from a tip that is far
 * narrower than the image, the scene fills less of it, but is in its middle. */
UNIT_TEST(deep_scenes_are_centred) {
    const affine_f64 deep = affine_scaling((vec3_f64){0.5, 0.5, 10});
    points p = {.count = 0};
    fathom_id group = add_group();
    add_body(group, (double[3]){0, 0, 0});
    place_still(group, FATHOM_ROOT, &deep);
    note_body(&p, &deep);
    for (size_t i = 0; i < SIZES; ++i) {
        shape_image(sizes[i][0], sizes[i][1]);
        scene->has_camera = false;
        assert_ok(context, fathom_scene_complete(scene));
        const extent e = extent_of(&p);
        for (int k = 0; k < 2; ++k) {
            assert_near(e.high[k] + e.low[k], 0, 0.01);
            assert_true(e.high[k] <= 0.9 + 1e-9);
        }
    }
}

/* Groups in groups, turned and scaled; one body far from all others' origin. */
UNIT_TEST(placed_copies_are_framed_by_their_vertices) {
    fathom_id inner = add_group(), outer = add_group();
    affine_f64 turned = affine_rotation_axis((vec3_f64){1, 2, 3}, 0.7),
               wide = affine_scaling((vec3_f64){3, 1, 0.5});
    affine_f64 moved = affine_translation((vec3_f64){10, -4, 2}), both = affine_compose(&turned, &wide);
    affine_f64 whole = affine_compose(&moved, &both);
    points p = {.count = 0};
    add_body(inner, (double[3]){0, 0, 0});
    place_still(inner, outer, &both);
    place_still(outer, FATHOM_ROOT, &moved);
    place_still(outer, FATHOM_ROOT, &wide);
    const affine_f64 second = affine_compose(&wide, &both);
    note_body(&p, &whole);
    note_body(&p, &second);
    for (size_t i = 0; i < SIZES; ++i) {
        shape_image(sizes[i][0], sizes[i][1]);
        scene->has_camera = false;
        assert_ok(context, fathom_scene_complete(scene));
        assert_framed(&p, 16);
    }
}

/* ---- motion ---- */

static const double times[3] = {0, 1, 2};

/* The group at three times. */
static void place_moving(fathom_id group, const affine_f64 at[3]) {
    fathom_instance instance = default_instance();
    double maps[3][12];
    for (int k = 0; k < 3; ++k) memcpy(maps[k], at[k].m, sizeof maps[k]);
    instance.group = group;
    instance.key_count = 3, instance.key_times = times, instance.key_transforms = maps[0];
    assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
}

static void complete_with_shutter(double open, double close) {
    scene->camera.shutter[0] = open, scene->camera.shutter[1] = close;
    scene->has_camera = false;
    assert_ok(context, fathom_scene_complete(scene));
}

/* There and back again, next to a body that rests: while the shutter is open all ways to the turning point
 * are in view, and with the shutter shut the place alone where it is then. */
UNIT_TEST(what_moves_is_framed_wherever_it_is_seen) {
    const fathom_id group = add_group();
    const affine_f64 rest = affine_translation((vec3_f64){0, 3, 0}),
                     at[3] = {affine_identity(), affine_translation((vec3_f64){9, 1, 2}), affine_identity()};
    static const struct {
        double open, close, share[3]; /* of the way to the turning point: the outermost ones */
    } cases[] = {{0, 2, {0, 1, 0}},
                 {0.25, 0.5, {0.25, 0.5, 0.5}},
                 {0.75, 1.5, {0.75, 1, 0.5}},
                 {1, 1, {1, 1, 1}},
                 {5, 9, {0, 0, 0}}};
    add_body(group, (double[3]){0, 0, 0});
    place_still(group, FATHOM_ROOT, &rest);
    place_moving(group, at);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        points p = {.count = 0};
        note_body(&p, &rest);
        for (int k = 0; k < 3; ++k) {
            const double u = cases[i].share[k];
            const affine_f64 there = affine_translation((vec3_f64){9 * u, u, 2 * u});
            note_body(&p, &there);
        }
        complete_with_shutter(cases[i].open, cases[i].close);
        assert_framed(&p, 16);
    }
}

/* Between two keys a turn reaches beyond both. Sixteen looks at 80 degrees are 5 apart, which between two of
 * them miss at most 1 - cos 2.5, a thousandth, of the distance from the axis: below 7, at least 3 from the
 * eye. */
UNIT_TEST(turns_stay_in_view) {
    const fathom_id group = add_group();
    const vec3_f64 axis = {0, 0, 1};
    const affine_f64 at[3] = {affine_identity(), affine_rotation_axis(axis, 1.4),
                              affine_rotation_axis(axis, 1.4)};
    points p = {.count = 0};
    add_body(group, (double[3]){0, 0, 0});
    place_moving(group, at);
    complete_with_shutter(0, 1);
    for (int i = 0; i <= 1000; i += 125) {
        const affine_f64 there = affine_rotation_axis(axis, 1.4 * i / 1000);
        note_body(&p, &there);
    }
    assert_framed(&p, 16);
    for (int i = 0; i <= 1000; i += 7) {
        const affine_f64 there = affine_rotation_axis(axis, 1.4 * i / 1000);
        points q = {.count = 0};
        note_body(&q, &there);
        const extent e = extent_of(&q);
        for (int k = 0; k < 2; ++k) assert_true(e.high[k] <= 0.9 + 0.005 && e.low[k] >= -0.9 - 0.005);
    }
}

/* A body that grows to twice its size, and later to a thousand times: at both ends of the shutter's time, or
 * as large as it is half way. The bounds are of that time, too. */
UNIT_TEST(moving_vertices_are_framed_as_they_are_then) {
    const double shutters[2][2] = {{0, 1}, {0.5, 0.5}};
    float keys[3][6][3];
    fathom_mesh mesh = default_mesh();
    for (int i = 0; i < 6; ++i) {
        for (int k = 0; k < 3; ++k)
            keys[0][i][k] = body[i][k], keys[1][i][k] = 2 * body[i][k], keys[2][i][k] = 1000 * body[i][k];
    }
    mesh.positions = body[0], mesh.vertex_count = 6, mesh.indices = faces, mesh.triangle_count = 4;
    mesh.key_count = 3, mesh.key_times = times, mesh.key_positions = keys[0][0];
    assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
    for (int i = 0; i < 2; ++i) {
        points p = {.count = 0};
        scene_bounds bounds;
        const affine_f64 from = affine_scaling(i ? (vec3_f64){1.5, 1.5, 1.5} : (vec3_f64){1, 1, 1}),
                         to = affine_scaling(i ? (vec3_f64){1.5, 1.5, 1.5} : (vec3_f64){2, 2, 2});
        note_body(&p, &from);
        note_body(&p, &to);
        complete_with_shutter(shutters[i][0], shutters[i][1]);
        assert_framed(&p, 16);
        assert_ok(context, scene_world_bounds(scene, &bounds));
        assert_true(bounds.lower.x == (i ? 1.5 : 2) * -2 && bounds.upper.x == (i ? 1.5 : 2) * 3);
        assert_true(bounds.lower.z == (i ? 1.5 : 2) * -6.5 && bounds.upper.z == (i ? 1.5 : 2) * 2.875);
    }
}

/* A mesh whose origin is at Earth's radius. */
UNIT_TEST(far_scenes_are_framed_as_near_ones) {
    const double origin[3] = {6378137, -5e6, 4e6};
    const affine_f64 moved = affine_translation(load_f64(origin));
    points p = {.count = 0};
    note_body(&p, &moved);
    add_body(FATHOM_ROOT, origin);
    assert_ok(context, fathom_scene_complete(scene));
    assert_framed(&p, 6378137);
}

/* A shape that no ray meets is neither in the view nor in the bounds. */
UNIT_TEST(absent_shapes_are_not_framed) {
    const affine_f64 still = affine_identity();
    points p = {.count = 0};
    scene_bounds bounds;
    fathom_material none = default_material();
    fathom_sphere ball = default_sphere();
    none.model = FATHOM_MODEL_METALLIC_ROUGHNESS, none.opacity = 0;
    ball.radius = 50, ball.flags = FATHOM_CASTS_NO_SHADOW;
    assert_ok(context, fathom_scene_add_material(scene, "none", &none, &ball.material));
    assert_ok(context, fathom_scene_add_sphere(scene, FATHOM_ROOT, &ball, NULL));
    note_body(&p, &still);
    add_body(FATHOM_ROOT, (double[3]){0, 0, 0});
    assert_ok(context, fathom_scene_complete(scene));
    assert_framed(&p, 16);
    assert_ok(context, scene_world_bounds(scene, &bounds));
    assert_true(bounds.lower.x == -2 && bounds.upper.x == 3);
}

/* A ball touches the four planes of a square view that is a tenth narrower: its centre is a radius from each.
 */
UNIT_TEST(balls_touch_the_view) {
    fathom_sphere sphere = default_sphere();
    sphere.center[0] = 4, sphere.center[1] = -3, sphere.center[2] = 2, sphere.radius = 0.125;
    assert_ok(context, fathom_scene_add_sphere(scene, FATHOM_ROOT, &sphere, NULL));
    shape_image(64, 64);
    assert_ok(context, fathom_scene_complete(scene));
    const fathom_camera *c = &scene->camera;
    const vec3_f64 to = sub_f64(load_f64(sphere.center), load_f64(c->origin));
    const double slope = 0.9 * c->h / c->d / 2, length = sqrt(1 + slope * slope);
    const vec3_f64 sides[4] = {load_f64(c->x), neg_f64(load_f64(c->x)), load_f64(c->y),
                               neg_f64(load_f64(c->y))};
    for (int i = 0; i < 4; ++i) {
        double outside = dot_f64(to, madd_f64(sides[i], slope, load_f64(c->z))) / length;
        assert_near(outside, -sphere.radius, 64 * 8 * 0x1p-53); /* coordinates below 8 */
    }
}

/* How far a ball stays within the four sides of a framing's view; 0: it touches the side. */
static void room_in(const fathom_framing *f, vec3_f64 center, double radius, double out[4]) {
    const vec3_f64 to = sub_f64(center, load_f64(f->eye)), z = load_f64(f->axes[2]);
    for (int i = 0; i < 4; ++i) {
        const vec3_f64 axis = load_f64(f->axes[i / 2]);
        const double slope = f->slopes[i / 2];
        out[i] =
            -dot_f64(to, madd_f64(i % 2 ? neg_f64(axis) : axis, slope, z)) / sqrt(1 + slope * slope) - radius;
    }
}

/* A camera of one ball, and of another, become the nearest that sees both: none is outside of any of its four
 * sides, and two sides that face each other are touched. Likewise the floor. Coordinates are below 64. */
UNIT_TEST(two_framings_become_one_that_shows_both) {
    random_state r = {26};
    const double rounding = 64 * 64 * 0x1p-53;
    for (int k = 0; k < 200; ++k) {
        fathom_framing f[2] = {{.size = sizeof *f}, {.size = sizeof *f}};
        vec3_f64 center[2];
        double radius[2], room[2][4], least[4];
        for (int i = 0; i < 2; ++i) {
            fathom_sphere ball = default_sphere();
            fathom_scene *own;
            for (int c = 0; c < 3; ++c) ball.center[c] = (float)random_in(&r, -8, 8);
            ball.radius = (float)random_log(&r, 0.1, 8);
            center[i] = load_f64(ball.center), radius[i] = (double)ball.radius;
            assert_ok(context, fathom_scene_create(context, &own));
            assert_ok(context, fathom_scene_add_sphere(own, FATHOM_ROOT, &ball, NULL));
            assert_ok(context, fathom_scene_complete(own));
            assert_ok(context, fathom_scene_framing(own, &f[i]));
            assert_true(f[i].made && f[i].up == FATHOM_UP_Y && f[i].radius == 0);
            store_f64(f[i].foot, madd_f64(center[i], -radius[i], vec_f64(0, 1, 0)));
            f[i].radius = radius[i];
            fathom_scene_destroy(own);
        }
        fathom_framing_unite(&f[0], &f[1]);
        for (int i = 0; i < 2; ++i) {
            room_in(&f[0], center[i], radius[i], room[i]);
            const double x = center[i].x - f[0].foot[0], z = center[i].z - f[0].foot[2];
            assert_true(hypot(x, z) + radius[i] <= f[0].radius + rounding);
        }
        for (int s = 0; s < 4; ++s) {
            least[s] = fmin(room[0][s], room[1][s]);
            assert_true(least[s] >= -rounding);
        }
        assert_true(fmin(fmax(least[0], least[1]), fmax(least[2], least[3])) <= rounding);
        assert_near(f[0].foot[1], fmin(center[0].y - radius[0], center[1].y - radius[1]), rounding);
    }
    fathom_framing none = {.size = sizeof none}, some = none;
    some.made = true, some.eye[0] = 3;
    fathom_framing_unite(&some, &none);
    fathom_framing_unite(&none, &some);
    assert_true(some.eye[0] == 3 && !none.made);
}

UNIT_TEST(any_scale_is_framed_alike) {
    const double scales[] = {1e-8, 1, 1e8};
    for (int i = 0; i < 3; ++i) {
        const affine_f64 map = affine_scaling((vec3_f64){scales[i], scales[i], scales[i]});
        points p = {.count = 0};
        fathom_id group = add_group();
        add_body(group, (double[3]){0, 0, 0});
        note_body(&p, &map);
        place_still(group, FATHOM_ROOT, &map);
        assert_ok(context, fathom_scene_complete(scene));
        assert_true(scene->lights.count > 0);
        assert_framed(&p, 1);
        scene = new_scene(context);
    }
}

/* More copies than are stepped into: those beyond count by their boxes, which hold them. */
UNIT_TEST(too_many_copies_stay_in_view) {
    fathom_id group = add_group();
    add_body(group, (double[3]){0, 0, 0});
    points p = {.count = 0};
    for (int i = 0; i < 70000; ++i) {
        affine_f64 map = affine_translation((vec3_f64){i % 300 * 10, i % 7, i / 300 * 10});
        place_still(group, FATHOM_ROOT, &map);
        if (i == 0 || i == 299 || i == 69600 || i == 69999) note_body(&p, &map);
    }
    assert_ok(context, fathom_scene_complete(scene));
    const extent e = extent_of(&p);
    for (int k = 0; k < 2; ++k) assert_true(e.low[k] >= -0.9 - 1e-9 && e.high[k] <= 0.9 + 1e-9);
}

/* What z-up software wrote, turned by hand to have y up, gives the same image: the camera is the turned one.
 */
UNIT_TEST(up_z_is_the_turned_scene) {
    const fathom_read_options options = {.size = sizeof options, .up = FATHOM_UP_Z};
    add_body(FATHOM_ROOT, (double[3]){0, 0, 0});
    scene->asked = &options;
    assert_ok(context, fathom_scene_complete(scene));
    const fathom_camera z = scene->camera;
    scene = new_scene(context);
    /* (x, y, z) with z up is (x, z, -y) with y up. */
    const affine_f64 turn = {{{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}}};
    fathom_id group = add_group();
    add_body(group, (double[3]){0, 0, 0});
    place_still(group, FATHOM_ROOT, &turn);
    assert_ok(context, fathom_scene_complete(scene));
    const fathom_camera *y = &scene->camera;
    const double *const pairs[4][2] = {{z.origin, y->origin}, {z.x, y->x}, {z.y, y->y}, {z.z, y->z}};
    for (int i = 0; i < 4; ++i) {
        vec3_f64 turned = affine_vector(&turn, load_f64(pairs[i][0])), expected = load_f64(pairs[i][1]);
        /* Roundings of products and sums below 32. */
        assert_near(length_f64(sub_f64(turned, expected)), 0, 32 * 64 * 0x1p-53);
    }
}

static fathom_camera camera_from(fathom_up up, const double *azimuth, const double *elevation) {
    fathom_read_options options = {.size = sizeof options, .up = up};
    options.choose_azimuth = azimuth, options.azimuth = azimuth ? *azimuth : 0;
    options.choose_elevation = elevation, options.elevation = elevation ? *elevation : 0;
    scene = new_scene(context);
    add_body(FATHOM_ROOT, (double[3]){0, 0, 0});
    scene->asked = &options;
    assert_ok(context, fathom_scene_complete(scene));
    return scene->camera;
}

static void expect_axis(const double found[3], double x, double y, double z) {
    assert_near(length_f64(sub_f64(load_f64(found), vec_f64(x, y, z))), 0, 16 * 0x1p-53);
}

/* From the right, from straight above with the front below, and by one angle alone. */
UNIT_TEST(the_camera_goes_around_the_scene) {
    const double none = 0, quarter = acos(0), azimuth = atan(0.45), elevation = atan(0.35 / hypot(0.45, 1));
    fathom_camera c = camera_from(FATHOM_UP_Y, &quarter, &none);
    expect_axis(c.z, 1, 0, 0), expect_axis(c.x, 0, 0, -1);
    c = camera_from(FATHOM_UP_Z, &quarter, &none);
    expect_axis(c.z, 1, 0, 0), expect_axis(c.x, 0, 1, 0);
    c = camera_from(FATHOM_UP_Y, &none, &quarter);
    expect_axis(c.z, 0, 1, 0), expect_axis(c.y, 0, 0, -1);
    c = camera_from(FATHOM_UP_Z, &none, &quarter);
    expect_axis(c.z, 0, 0, 1), expect_axis(c.y, 0, 1, 0);
    const fathom_camera usual = camera_from(FATHOM_UP_Y, NULL, NULL);
    for (int k = 0; k < 2; ++k) {
        c = k ? camera_from(FATHOM_UP_Y, &azimuth, NULL) : camera_from(FATHOM_UP_Y, NULL, &elevation);
        expect_axis(c.x, usual.x[0], usual.x[1], usual.x[2]);
        expect_axis(c.z, usual.z[0], usual.z[1], usual.z[2]);
    }
}

UNIT_TEST(scenes_without_end_are_refused) {
    fathom_sphere sphere = default_sphere();
    sphere.radius = 1e308;
    assert_ok(context, fathom_scene_add_sphere(scene, FATHOM_ROOT, &sphere, NULL));
    assert_fails(context, fathom_scene_complete(scene), FATHOM_BAD_INPUT, "camera: there is none");
}

/* ---- the reach of a mesh ---- */

#define FLOATS_MOST 560000
static float coordinates[FLOATS_MOST];

/* By the definition. */
static void assert_reach(const extent_sides *s, const fathom_mesh *mesh, const double floor[EXTENT_SIDES]) {
    double most[EXTENT_SIDES];
    memcpy(most, floor, sizeof most);
    extent_boxes boxes;
    assert_true(extent_make_boxes(2, mesh, &boxes));
    extent_of_mesh(s, mesh, &boxes, most);
    free(boxes.items);
    for (int i = 0; i < EXTENT_SIDES; ++i) {
        double expected = floor[i];
        for (uint32_t k = 0; k < mesh->vertex_count; ++k) {
            const float *p = mesh->positions + k * (mesh->position_stride / sizeof(float));
            const double reach = s->x[i] * (double)p[0] + s->y[i] * (double)p[1] + s->z[i] * (double)p[2] +
                                 s->origin[i] + s->offset[i];
            if (reach > expected) expected = reach;
        }
        assert_true(most[i] == expected);
    }
}

/* Points along a spiral on a ball, so that runs are apart; some moved by a little, some not finite. */
static void fill_mesh(random_state *r, fathom_mesh *mesh, double odd) {
    static const float odds[] = {NAN, INFINITY, -INFINITY};
    const size_t step = mesh->position_stride / sizeof(float);
    for (size_t i = 0; i < FLOATS_MOST; ++i) coordinates[i] = NAN; /* between the vertices */
    for (uint32_t k = 0; k < mesh->vertex_count; ++k) {
        const double z = 2 * (k + 0.5) / mesh->vertex_count - 1, across = sqrt(1 - z * z), turn = 40 * z;
        const double p[3] = {across * cos(turn), across * sin(turn), z + random_in(r, 0, 0.01)};
        for (int c = 0; c < 3; ++c) coordinates[k * step + (size_t)c] = (float)p[c];
        if (random_unit(r) < odd) coordinates[k * step + random_bits(r) % 3] = odds[random_bits(r) % 3];
    }
    mesh->positions = coordinates;
}

/* Sides of any size, such that products and sums overflow, and along axes. */
static extent_sides random_sides(random_state *r) {
    static const double sizes_of[] = {0, 1, 1e-300, 1e300, 1.7e308, INFINITY};
    extent_sides s;
    double *const terms[5] = {s.x, s.y, s.z, s.origin, s.offset};
    const bool odd = random_unit(r) < 0.5;
    for (int i = 0; i < EXTENT_SIDES; ++i) {
        for (int k = 0; k < 5; ++k)
            terms[k][i] = random_in(r, -1, 1) * (odd ? sizes_of[random_bits(r) % 6] : 1);
    }
    return s;
}

UNIT_TEST(skipped_runs_never_change_the_reach) {
    static const uint32_t counts[] = {1, 2, 7, 127, 128, 129, 255, 1000, 70000};
    static const size_t strides[] = {12, 16, 20, 32};
    const double nowhere[EXTENT_SIDES] = {-INFINITY, -INFINITY, -INFINITY, -INFINITY},
                 some[EXTENT_SIDES] = {0, 0.5, 1, -1};
    random_state r = {1};
    fathom_mesh mesh = default_mesh();
    for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
        for (size_t i = 0; i < sizeof strides / sizeof *strides; ++i) {
            mesh.vertex_count = counts[c], mesh.position_stride = strides[i];
            for (int k = 0; k < 8; ++k) {
                const extent_sides sides = random_sides(&r);
                fill_mesh(&r, &mesh, k % 2 ? 0.002 : 0);
                assert_reach(&sides, &mesh, nowhere);
                assert_reach(&sides, &mesh, some);
            }
        }
    }
}

int main(void) { return unit_main_each(open_scene, NULL); }
