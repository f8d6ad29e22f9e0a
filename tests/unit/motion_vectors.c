/* Motion vectors in closed form: how far the point that a pixel shows moves in the image, by the camera's
 * motion, an instance's and the vertices' own. */
#include "render.h"

#include <math.h>

enum { SIDE = 32 };

/* The camera stands at z = 6 and looks down to the plane z = 0. PER_UNIT: pixels of a length of 1 at
 * distance 1.
 */
#define FOVY 0.7
#define PER_UNIT (SIDE / (2 * tan(FOVY / 2)))

/* Coordinates below 8 are floats, to 2^-22 at most: of the camera's place, of the maps, whose products are of
 * four terms, and of P, Z and the result. Seen from a distance of 4 or more, at two times each. */
#define ROUNDINGS (16 * 0x1p-22 * PER_UNIT / 4 * 2)

static const double key_times[2] = {0, 2};
static const double still[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/* Keys of the camera, where it stands still or moves by (dx, dy) and turns around y. */
static void look(stage *s, double dx, double dy, double angle, double open, double close) {
    const double c = cos(angle), n = sin(angle),
                 frames[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 6, c, 0, n, dx, 0, 1, 0, dy, -n, 0, c, 6};
    fathom_camera camera;
    fathom_camera_look_at((double[3]){0, 0, 6}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, FOVY, &camera);
    camera.shutter[0] = open, camera.shutter[1] = close;
    camera.key_count = 2, camera.key_times = key_times, camera.key_frames = frames;
    assert_ok(s->context, fathom_scene_set_camera(s->scene, &camera));
}

static stage empty(void) {
    stage s = stage_open(SIDE, SIDE);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.target_error = 0, s.settings.spp = 4, s.settings.max_depth = 0;
    s.settings.aovs = FATHOM_AOV_MOTION | FATHOM_AOV_P | FATHOM_AOV_Z;
    return s;
}

/* A ball before the middle, which moves by (dx, dy) while the shutter is open. */
static void flying_ball(stage *s, double dx, double dy) {
    double maps[24];
    memcpy(maps, still, sizeof still), memcpy(maps + 12, still, sizeof still);
    maps[12 + 3] = dx, maps[12 + 7] = dy;
    const fathom_id group = new_group(s->scene, NULL);
    fathom_sphere ball = default_sphere();
    ball.radius = 1, ball.material = stage_emitter(s, 1);
    assert_ok(s->context, fathom_scene_add_sphere(s->scene, group, &ball, NULL));
    fathom_instance instance = default_instance();
    instance.group = group;
    instance.key_count = 2, instance.key_times = key_times, instance.key_transforms = maps;
    assert_ok(s->context, fathom_scene_add_instance(s->scene, &instance, NULL));
}

static const float *channel(const fathom_film *film, const char *name) {
    const float *pixels = fathom_film_channel(film, name);
    assert_non_null(pixels);
    return pixels;
}

/* All four numbers of a pixel: forward by (u, v), backward by (bu, bv). */
static void assert_vectors(const fathom_film *film, int i, const double expected[4]) {
    static const char *const names[4] = {"forward.u", "forward.v", "backward.u", "backward.v"};
    for (int c = 0; c < 4; ++c) assert_near(channel(film, names[c])[i], expected[c], ROUNDINGS);
}

static void assert_all_vectors(const fathom_film *film, const double expected[4]) {
    for (int i = 0; i < SIDE * SIDE; ++i) assert_vectors(film, i, expected);
}

/* Pans to the right and up by (dx, dy): the picture moves to the left and down. */
UNIT_TEST(a_camera_that_moves_along_a_plane_shifts_all_pixels) {
    stage s = empty();
    stage_plane(&s, (double[3]){0, 0, 0}, (double[3]){0, 0, 1}, stage_emitter(&s, 1));
    look(&s, 0.6, 0.2, 0, 0, 2);
    fathom_film *film = stage_render(&s);
    const double u = 0.3 / 6 * PER_UNIT, v = 0.1 / 6 * PER_UNIT;
    assert_all_vectors(film, (double[4]){-u, -v, u, v});
}

/* Half of the keys' time: half of the way. */
UNIT_TEST(vectors_are_of_the_shutter_s_time) {
    stage s = empty();
    stage_plane(&s, (double[3]){0, 0, 0}, (double[3]){0, 0, 1}, stage_emitter(&s, 1));
    look(&s, 0.6, 0.2, 0, 0.5, 1.5);
    fathom_film *film = stage_render(&s);
    const double u = 0.15 / 6 * PER_UNIT, v = 0.05 / 6 * PER_UNIT;
    assert_all_vectors(film, (double[4]){-u, -v, u, v});
}

/* Its points keep their depths: each moves by f d / Z. The sky around it rests. */
UNIT_TEST(a_sphere_that_flies_across_moves_by_its_depth) {
    stage s = empty();
    flying_ball(&s, 0.5, -0.3);
    look(&s, 0, 0, 0, 0, 2);
    fathom_film *film = stage_render(&s);
    const float *z = channel(film, "Z");
    int met = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const bool sky = isinf(z[i]);
        const double u = sky ? 0 : 0.25 / (double)z[i] * PER_UNIT,
                     v = sky ? 0 : -0.15 / (double)z[i] * PER_UNIT;
        assert_vectors(film, i, (double[4]){u, v, -u, -v});
        met += !sky;
    }
    assert_in_range(met, 100, 500);
}

/* A ball and a camera that move together; the floor behind shifts. */
UNIT_TEST(what_moves_with_the_camera_rests) {
    stage s = empty();
    flying_ball(&s, 0.5, -0.3);
    stage_plane(&s, (double[3]){0, 0, -2}, (double[3]){0, 0, 1}, stage_emitter(&s, 1));
    look(&s, 0.5, -0.3, 0, 0, 2);
    fathom_film *film = stage_render(&s);
    const float *z = channel(film, "Z");
    const double u = 0.25 / 8 * PER_UNIT, v = -0.15 / 8 * PER_UNIT;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const bool floor = z[i] > 7;
        assert_vectors(film, i, floor ? (double[4]){-u, -v, u, v} : (double[4]){0, 0, 0, 0});
    }
}

/* Two triangles across the image, from a depth of 6 to one of 5: their points keep x and y. */
UNIT_TEST(vertices_that_come_nearer_part_from_the_middle) {
    stage s = empty();
    static const float from[12] = {-4, -4, 0, 4, -4, 0, 4, 4, 0, -4, 4, 0};
    float keys[24];
    memcpy(keys, from, sizeof from), memcpy(keys + 12, from, sizeof from);
    for (int k = 0; k < 4; ++k) keys[12 + 3 * k + 2] = 1;
    fathom_mesh mesh = default_mesh();
    mesh.positions = from, mesh.vertex_count = 4;
    mesh.indices = (const uint32_t[]){0, 1, 2, 0, 2, 3}, mesh.triangle_count = 2;
    mesh.material = stage_emitter(&s, 1);
    mesh.key_count = 2, mesh.key_times = key_times, mesh.key_positions = keys;
    assert_ok(s.context, fathom_scene_add_mesh(s.scene, FATHOM_ROOT, &mesh, NULL));
    look(&s, 0, 0, 0, 0, 2);
    fathom_film *film = stage_render(&s);
    const float *x = channel(film, "P.X"), *y = channel(film, "P.Y");
    const double nearer = (1 / 5.0 - 1 / 5.5) * PER_UNIT, farther = (1 / 6.0 - 1 / 5.5) * PER_UNIT;
    for (int i = 0; i < SIDE * SIDE; ++i)
        assert_vectors(film, i,
                       (double[4]){(double)x[i] * nearer, (double)y[i] * nearer, (double)x[i] * farther,
                                   (double)y[i] * farther});
}

/* Without blur all rays are of the middle of the time, and with a grid of one sample from the pixels'
 * middles. The camera turns by `angle` in all, so that the sky turns by half of it against the middle, either
 * way: (x, y, -1), turned, and divided by its depth again. */
UNIT_TEST(a_camera_that_turns_moves_the_sky) {
    const double angle = 0.1, c = cos(angle / 2), n = sin(angle / 2);
    stage s = empty();
    s.settings.spp = 1, s.settings.pattern = FATHOM_PATTERN_GRID, s.settings.motion_blur = false;
    stage_sphere(&s, 0, 0, 600, 1, stage_emitter(&s, 1)); /* behind it */
    look(&s, 0, 0, angle, 0, 2);
    fathom_film *film = stage_render(&s);
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const double x = (i % SIDE + 0.5 - SIDE / 2) / PER_UNIT, y = (SIDE / 2 - i / SIDE - 0.5) / PER_UNIT;
        const double forth = c - x * n, back = c + x * n;
        assert_vectors(film, i,
                       (double[4]){((x * c + n) / forth - x) * PER_UNIT, (y / forth - y) * PER_UNIT,
                                   ((x * c - n) / back - x) * PER_UNIT, (y / back - y) * PER_UNIT});
    }
}

/* However long the shutter is open. */
UNIT_TEST(without_blur_an_image_is_of_the_middle_of_the_time) {
    for (int k = 0; k < 2; ++k) {
        fathom_film *films[2];
        for (int half = 0; half < 2; ++half) {
            stage s = empty();
            flying_ball(&s, 0.5, -0.3);
            s.settings.motion_blur = false;
            if (k) s.settings.integrator = FATHOM_INTEGRATOR_REFERENCE, s.settings.aovs = 0;
            look(&s, 0.6, 0.2, 0.1, half ? 0.5 : 0, half ? 1.5 : 2);
            films[half] = stage_render(&s);
        }
        assert_memory_equal(channel(films[0], "R"), channel(films[1], "R"), SIDE * SIDE * sizeof(float));
    }
}

int main(void) { return unit_main(NULL, NULL); }
