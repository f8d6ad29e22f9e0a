/* Light samples of surfaces whose emission is an image. Statistical tests are made once, with fixed numbers,
 * at 5 standard errors (6e-7). */
#include "light/emitters_inner.h"
#include "unit_light.h"

#include <stdio.h>

enum { SIDE = 64, BLOCK = 8, BLOCKS = 2000 };

static const double errors = 5;

static texturing *images;
UNIT_OWNS(images, texturing, texturing_destroy)
static unsigned char texels[SIDE][SIDE][3];
static unsigned char file[SIDE * SIDE * 3 + 64];

static void open_images(void) {
    w = new_world(scene);
    assert_ok(context, texturing_create(context, w, 1 << 20, NULL, &images));
    own_images(images);
    assert_ok(context, emitters_create(context, w, images, NULL, &e));
    own_emitters(e);
}

/* Each block of texels is bright by chance. */
static void make_texels(double chance) {
    random_state r = {5};
    memset(texels, 0, sizeof texels);
    for (int y = 0; y < SIDE; y += BLOCK) {
        for (int x = 0; x < SIDE; x += BLOCK) {
            if (random_in(&r, 0, 1) >= chance) continue;
            for (int i = 0; i < BLOCK * BLOCK; ++i) texels[y + i / BLOCK][x + i % BLOCK][0] = 255;
        }
    }
}

static fathom_id screen(void) {
    fathom_texture t = default_texture();
    fathom_material m = default_material();
    const int header = snprintf((char *)file, sizeof file, "P6\n%d %d\n255\n", SIDE, SIDE);
    memcpy(file + header, texels, sizeof texels);
    t.bytes = file, t.byte_count = (size_t)header + sizeof texels, t.name = "screen.ppm";
    t.color_space = FATHOM_COLOR_LINEAR, t.filter = FATHOM_TEXTURE_NEAREST;
    const fathom_id texture = new_texture(scene, &t);
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0, m.k_e[c] = 1;
    m.maps[FATHOM_MAP_EMISSIVE].texture = texture;
    return new_material(scene, NULL, &m);
}

/* ---- shapes: the square [-1,1]² at z = 1, and a ball ---- */

static void add_quad(void) {
    fathom_quad q;
    fathom_quad_from_axes((double[]){0, 0, 1}, (double[]){1, 0, 0}, (double[]){0, 1, 0}, &q);
    q.material = screen();
    assert_ok(context, fathom_scene_add_quad(scene, FATHOM_ROOT, &q, NULL));
}

/* The same square and image as two triangles, in a group or in the root. */
static void add_mesh(fathom_id group, float size) {
    fathom_mesh mesh = default_mesh();
    mesh.positions =
        (const float[]){-size, -size, size, size, -size, size, size, size, size, -size, size, size};
    mesh.vertex_count = 4, mesh.indices = (const uint32_t[]){0, 1, 2, 0, 2, 3}, mesh.triangle_count = 2;
    mesh.uvs = (const float[]){0, 1, 1, 1, 1, 0, 0, 0}, mesh.uv_count = 4;
    mesh.material = screen();
    assert_ok(context, fathom_scene_add_mesh(scene, group, &mesh, NULL));
}

/* At the time 0 both lie where the others do. */
static void add_placed(bool moving) {
    static const double times[] = {0, 1}, keys[24] = {0.5, 0,    0, 0, 0,   0.5, 0, 0, 0, 0, 0.5, 0,
                                                      0,   -0.5, 0, 4, 0.5, 0,   0, 0, 0, 0, 1,   0};
    fathom_instance instance = default_instance();
    fathom_camera camera = default_camera();
    const fathom_id group = new_group(scene, NULL);
    add_mesh(group, 2);
    instance.group = group;
    memcpy(instance.transform, keys, sizeof instance.transform);
    if (moving) instance.key_count = 2, instance.key_times = times, instance.key_transforms = keys;
    assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
    camera.shutter[1] = moving;
    assert_ok(context, fathom_scene_set_camera(scene, &camera));
}

static const vec3_f64 middle = {0.5, 0, 1};
static const double radius = 0.75;

static void add_ball(void) {
    fathom_sphere s = default_sphere();
    store_f64(s.center, middle), s.radius = radius, s.material = screen();
    assert_ok(context, fathom_scene_add_sphere(scene, FATHOM_ROOT, &s, NULL));
}

/* ---- irradiance over pi, by samples and by sums over the image ---- */

/* Adds what an area of the surface sends whose radiance is that of the texel at u, v. */
static void add_area(double *sum, vec3_f64 p, vec3_f64 n, vec3_f64 at, vec3_f64 outward, double area,
                     double u, double v) {
    const vec3_f64 to = sub_f64(at, p);
    const double square = dot_f64(to, to), here = fmax(dot_f64(n, to), 0),
                 there = fmax(-dot_f64(outward, to), 0);
    const int x = (int)(u * SIDE), y = (int)(v * SIDE);
    *sum += texels[y][x][0] / 255.0 * here * there / (square * square * M_PI) * area;
}

enum { FINE = 4 * SIDE };

static double from_square(vec3_f64 p, vec3_f64 n) {
    double sum = 0;
    for (int i = 0; i < FINE * FINE; ++i) {
        const double u = (i % FINE + 0.5) / FINE, v = (i / FINE + 0.5) / FINE;
        add_area(&sum, p, n, vec_f64(2 * u - 1, 1 - 2 * v, 1), vec_f64(0, 0, p.z > 1 ? 1 : -1),
                 4.0 / (FINE * FINE), u, v);
    }
    return sum;
}

static double from_ball(vec3_f64 p, vec3_f64 n, bool inside) {
    double sum = 0;
    for (int i = 0; i < FINE * FINE; ++i) {
        const double u = (i % FINE + 0.5) / FINE, v = (i / FINE + 0.5) / FINE, phi = 2 * M_PI * u,
                     theta = M_PI * v;
        const vec3_f64 out = {sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)};
        const double area = radius * radius * sin(theta) * (2 * M_PI / FINE) * (M_PI / FINE);
        add_area(&sum, p, n, madd_f64(middle, radius, out), inside ? neg_f64(out) : out, area, u, v);
    }
    return sum;
}

/* The sums are of points in the middle of squares of side h = 1/128, at distances d of 0.7 and more. Each
 * errs by at most h²/24 times the second derivative over the value, which is below 40/d²: 2e-4. */
static const double of_sum = 2e-4;

static void assert_received(vec3_f64 p, vec3_f64 n, double expected) {
    const received got = receive(p, n, BLOCKS);
    assert_near(got.mean, expected, errors * got.error + of_sum * expected);
}

static const vec3_f64 points[] = {{0, 0, 0}, {0.9, -0.8, 0.3}, {3, 1, 0.5}, {-0.4, 0.2, 2}};
static const vec3_f64 normals[] = {{0, 0, 1}, {0.6, 0, 0.8}, {-1, 0, 0}, {0, 0, -1}};

static void assert_square(void) {
    for (int i = 0; i < 4; ++i) assert_received(points[i], normals[i], from_square(points[i], normals[i]));
}

UNIT_TEST(a_divided_quad_sends_its_image) {
    make_texels(0.1);
    add_quad();
    open_images();
    assert_true(e->runs[0].level > 0);
    assert_square();
}

UNIT_TEST(a_divided_mesh_sends_its_image) {
    make_texels(0.1);
    add_mesh(FATHOM_ROOT, 1);
    open_images();
    assert_true(e->runs[0].level > 0);
    assert_square();
}

UNIT_TEST(placed_and_moving_meshes_send_their_images) {
    for (int moving = 0; moving < 2; ++moving) {
        begin_light(state);
        make_texels(0.1);
        add_placed(moving);
        open_images();
        assert_true(e->moving == (bool)moving);
        assert_square();
    }
}

UNIT_TEST(a_ball_sends_its_image) {
    make_texels(0.5);
    add_ball();
    open_images();
    assert_received(points[2], normals[2], from_ball(points[2], normals[2], false));
    assert_received(points[3], normals[3], from_ball(points[3], normals[3], false));
    assert_received(vec_f64(0.5, 0.2, 0.9), normals[1], from_ball(vec_f64(0.5, 0.2, 0.9), normals[1], true));
}

/* A sixteenth of the image is bright: even samples have 15/16 in the dark and 16 times the squared mean.
 * Cells on the border of the bright part see both, as their lookups are filtered. */
UNIT_TEST(samples_go_where_the_image_is_bright) {
    make_texels(0);
    for (int i = 0; i < SIDE * SIDE / 16; ++i) texels[i / (SIDE / 4)][i % (SIDE / 4)][0] = 255;
    add_quad();
    open_images();
    const received got = receive(points[0], normals[0], BLOCKS);
    assert_true(got.dark < 0.25);
    assert_true(got.square < 2 * got.mean * got.mean);
}

UNIT_TEST(an_even_image_is_not_divided) {
    make_texels(1);
    add_quad();
    open_images();
    assert_int_equal(e->runs[0].level, 0);
    assert_square();
}

/* 2^18 cells for all: each of 10,000 screens of two triangles gets 8, and would get 32 alone. */
UNIT_TEST(many_screens_share_the_cells) {
    fathom_instance instance = default_instance();
    make_texels(0.1);
    const fathom_id group = new_group(scene, NULL);
    add_mesh(group, 1);
    instance.group = group;
    for (int k = 0; k < 10000; ++k) {
        instance.transform[3] = 3 * k;
        assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
    }
    open_images();
    assert_int_equal(e->surface_count, 10000 * 8);
}

UNIT_TEST(a_hit_gets_the_density_of_its_sample) {
    make_texels(0.1);
    add_quad();
    open_images();
    random_state r = {3};
    int seen = 0;
    for (int b = 0; b < 200; ++b) {
        const vec3_f64 p = points[b % 4], n = normals[b % 4];
        emitter_query q;
        emitter_sample s;
        _Alignas(64) lanes3 u;
        fill_query(&q, p, n), fill_numbers(&r, u);
        emitters_sample(e, &q, u, &s);
        for (unsigned i = 0; i < LANES; ++i) {
            const emitter_hit hit = {.instance = FATHOM_NONE};
            if (!(s.density[i] > 0)) continue;
            const float density =
                emitters_hit_density(e, lane_f32(q.p, i), lane_f32(q.n, i), lane_f32(s.direction, i), &hit);
            assert_near(density, s.density[i], 1e-5 * (double)s.density[i]);
            ++seen;
        }
    }
    assert_true(seen > 1000);
}

UNIT_TEST(the_middle_of_a_cell_lies_in_it) {
    make_texels(0.1);
    add_quad();
    open_images();
    const emitter_run *run = &e->runs[0];
    assert_true(run->count > 2);
    for (uint32_t i = 0; i < run->count; ++i) {
        vec3_f64 c[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        texturing_place place = emitters_place(e, run, i);
        emitters_divide(c, run, i);
        store_f32(place.weight, narrow(scale_f64(1 / 3.0, add_f64(c[0], add_f64(c[1], c[2])))));
        assert_int_equal(emitters_index_at(e, run, place.primitive, &place), i);
    }
}

int main(void) { return unit_main_each(begin_light, NULL); }
