/* The studio, which lights models that bring no light. */
#include "light/studio.h"
#include "light/environment.h"
#include "owned.h"
#include "random.h"
#include "scene/camera/camera.h"
#include "unit_folder.h"
#include "written.h"

#include <fathom/fathom.h>

static environment *open_studio(vec3_f64 z, vec3_f64 up) {
    environment *e;
    assert_ok(context, environment_studio(context, z, up, &e));
    return e;
}

/* A texel's corner is at most 0.25 degrees off its centre. The edge of a panel rises by its radiance over 6
 * degrees, at most 1.5 times as fast as evenly: 1/16 of the radiance. */
UNIT_TEST(texels_hold_the_rule) {
    environment *e = open_studio(vec_f64(0, 0, 1), vec_f64(0, 1, 0));
    random_state r = {1};
    studio made;
    studio_open(&made);
    for (int i = 0; i < 20000; ++i) {
        const vec3_f64 d = random_direction(&r);
        float rule[3], texel[3];
        studio_radiance(&made, d, rule);
        environment_radiance(e, d, texel);
        for (int c = 0; c < 3; ++c) {
            assert_true(rule[c] > 0.01f);
            assert_true(fabsf(rule[c] - texel[c]) < 4.2f / 16);
        }
    }
    environment_destroy(e);
}

/* What stands in it looks the same whichever axis is up, and from wherever the viewer looks. */
UNIT_TEST(it_turns_with_the_viewer) {
    environment *y = open_studio(vec_f64(0, 0, 1), vec_f64(0, 1, 0)),
                *z = open_studio(vec_f64(0, -1, 0), vec_f64(0, 0, 1)),
                *below = open_studio(vec_f64(0, -4, 1), vec_f64(0, 1, 0)),
                *side = open_studio(vec_f64(1, 0, 0), vec_f64(0, 1, 0));
    random_state r = {2};
    for (int i = 0; i < 1000; ++i) {
        const vec3_f64 d = random_direction(&r);
        float a[3], b[3];
        environment_radiance(y, d, a);
        environment_radiance(z, vec_f64(d.x, -d.z, d.y), b);
        assert_memory_equal(a, b, sizeof a);
        environment_radiance(below, d, b);
        assert_memory_equal(a, b, sizeof a);
        environment_radiance(side, vec_f64(d.z, d.y, -d.x), b);
        assert_memory_equal(a, b, sizeof a);
    }
    environment_destroy(y), environment_destroy(z), environment_destroy(below), environment_destroy(side);
}

static fathom_scene *open_ball(void) {
    fathom_sphere ball = default_sphere();
    fathom_scene *scene = new_scene(context);
    assert_ok(context, fathom_scene_add_sphere(scene, 0, &ball, NULL));
    return scene;
}

/* *corner: the pixel at the upper left, next to the ball. NULL: not asked for. */
static float look(fathom_scene *scene, float *corner) {
    fathom_settings s = default_settings();
    fathom_film *film;
    float sum = 0;
    fathom_settings_set_integrator(&s, FATHOM_INTEGRATOR_PATH);
    s.width = s.height = 32, s.spp = 4, s.target_error = 0;
    assert_ok(context, fathom_render(context, scene, &s, NULL, NULL, NULL, &film));
    const float *green = fathom_film_channel(film, "G");
    for (int i = 0; i < 32 * 32; ++i) sum += green[i] / (32 * 32);
    if (corner) *corner = green[0];
    fathom_film_destroy(film);
    return sum;
}

static float mean_of(fathom_scene *scene) { return look(scene, NULL); }

/* Those that complete() made for the classic integrator would light the ball from two sides. */
UNIT_TEST(a_background_alone_lights_a_model_without_lights) {
    const float sky[3] = {0.3f, 0.3f, 0.3f};
    float before, after;
    fathom_scene *scene = open_ball();
    assert_ok(context, fathom_scene_set_background(scene, sky));
    assert_ok(context, fathom_scene_complete(scene));
    before = mean_of(scene);
    scene = open_ball();
    assert_ok(context, fathom_scene_complete(scene));
    assert_ok(context, fathom_scene_set_background(scene, sky));
    after = mean_of(scene);
    assert_float_equal(after, before, 0);
}

/* A light, a background or ambient light of the caller's own leaves no studio. */
UNIT_TEST(only_models_without_light_stand_in_it) {
    fathom_scene *scene = open_ball();
    assert_ok(context, fathom_scene_complete(scene));
    const float lit = mean_of(scene);
    assert_true(lit > 0.1f && lit < 1);
    assert_ok(context, fathom_scene_set_background(scene, (float[3]){0, 0, 0}));
    assert_true(mean_of(scene) < lit / 2);

    scene = open_ball();
    assert_ok(context, fathom_scene_set_background(scene, (float[3]){0, 0, 0}));
    assert_ok(context, fathom_scene_complete(scene));
    assert_true(mean_of(scene) < lit / 2);
}

/* A light, a background and a camera that follow complete() replace its own, in the image and in files. */
UNIT_TEST(what_is_added_later_replaces_what_was_made) {
    float seen[3], behind[3];
    fathom_light light = default_light();
    fathom_camera camera = default_camera();
    fathom_scene *scene, *again;
    light.position[2] = camera.origin[2] = 5;
    for (int later = 0; later < 2; ++later) {
        scene = open_ball();
        if (later) assert_ok(context, fathom_scene_complete(scene));
        assert_ok(context, fathom_scene_add_light(scene, &light, NULL));
        assert_ok(context, fathom_scene_set_background(scene, (float[3]){0.1f, 0.2f, 0.3f}));
        assert_ok(context, fathom_scene_set_camera(scene, &camera));
        seen[later] = look(scene, &behind[later]);
    }
    again = written(scene, "later.json");
    seen[2] = look(again, &behind[2]);
    for (int i = 1; i < 3; ++i) assert_true(seen[i] == seen[0] && behind[i] == behind[0]);
    remove(in_folder("later.json"));
}

/* Behind a ball with an emission of 1, which an image may scale by 0. */
static float wall_behind_emissive(bool image) {
    static const char black[] = "P6\n1 1\n255\n\0\0\0";
    const fathom_texture texture = {.size = sizeof texture, .bytes = black, .byte_count = sizeof black - 1};
    fathom_sphere ball = default_sphere();
    fathom_material m = default_material();
    fathom_scene *scene = new_scene(context);
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.emissive[0] = m.emissive[1] = m.emissive[2] = 1;
    if (image)
        assert_ok(context, fathom_scene_add_texture(scene, &texture, &m.maps[FATHOM_MAP_EMISSIVE].texture));
    assert_ok(context, fathom_scene_add_material(scene, "m", &m, &ball.material));
    assert_ok(context, fathom_scene_add_sphere(scene, 0, &ball, NULL));
    assert_ok(context, fathom_scene_complete(scene));
    float corner;
    look(scene, &corner);
    return corner;
}

/* Nor is a body that shines on nothing: both have the wall behind them, and the one that shines is brighter.
 */
UNIT_TEST(an_emission_that_meets_nothing_is_no_lamp) {
    assert_true(wall_behind_emissive(true) > 0.01f);
    assert_true(wall_behind_emissive(false) == wall_behind_emissive(true));
}

/* By 20,000 directions spread evenly; panels have edges of a few degrees. */
UNIT_TEST(its_luminance_is_what_lamps_are_held_against) {
    enum { DIRECTIONS = 20000 };
    studio s;
    double sum = 0;
    studio_open(&s);
    for (int i = 0; i < DIRECTIONS; ++i) {
        const double y = 1 - (2 * i + 1.0) / DIRECTIONS, r = sqrt(1 - y * y), turn = 2.39996322972865332 * i;
        float rgb[3];
        studio_radiance(&s, vec_f64(r * cos(turn), y, r * sin(turn)), rgb);
        sum += 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
    }
    assert_near(sum / DIRECTIONS, STUDIO_LUMINANCE, 1e-3);
}

/* ---- lamps ---- */

static fathom_id add_emission(fathom_scene *scene, float radiance) {
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_e[c] = radiance;
    return new_material(scene, "m", &m);
}

/* A parallelogram. */
static void add_wall(fathom_scene *scene, vec3_f64 c, vec3_f64 u, vec3_f64 v, fathom_id material) {
    fathom_quad q = default_quad();
    const vec3_f64 corner[4] = {c, add_f64(c, u), add_f64(add_f64(c, u), v), add_f64(c, v)};
    for (int k = 0; k < 4; ++k) store_f64(q.corners[k], corner[k]);
    q.material = material;
    assert_ok(context, fathom_scene_add_quad(scene, FATHOM_ROOT, &q, NULL));
}

/* A room of edge s, open at the front, with a lamp of a tenth of its ceiling in the middle of it. */
static bool room_has_studio(double s, float radiance) {
    fathom_scene *scene = new_scene(context);
    const fathom_id lamp = add_emission(scene, radiance);
    const vec3_f64 x = {s, 0, 0}, y = {0, s, 0}, z = {0, 0, s}, o = {0, 0, 0};
    const double part = sqrt(0.1);
    add_wall(scene, o, x, y, 0);
    add_wall(scene, o, x, z, 0);
    add_wall(scene, o, y, z, 0);
    add_wall(scene, x, y, z, 0);
    add_wall(scene, y, x, z, 0);
    add_wall(scene, (vec3_f64){0.5 * (1 - part) * s, 0.999 * s, 0.5 * (1 - part) * s}, scale_f64(part, x),
             scale_f64(part, z), lamp);
    assert_ok(context, fathom_scene_complete(scene));
    const bool out = scene->in_studio;
    return out;
}

/* As a point, the lamp gives 0.1 L / (1 + r^2)^2 to the floor at a distance r from its middle, and
 * 0.1 L z / (2 (z^2 + 1/4)^2) to the middle line of a wall at a depth z below the lamp: at most 0.13 L. So
 * with L = 1.1 only a strip of the walls, and the tenth of the ceiling above the lamp, get the 0.137 of the
 * limit. With L = 3 all of the floor but its corners gets it, and more than half of the walls. */
UNIT_TEST(a_room_is_lit_by_its_lamps_unless_they_are_dim) {
    for (double size = 1e-6; size < 1e7; size *= 1e4) {
        assert_false(room_has_studio(size, 20));
        assert_false(room_has_studio(size, 3));
        assert_true(room_has_studio(size, 1.1f));
        assert_true(room_has_studio(size, 0.05f));
    }
}

/* A floor that only shows its colour lies under a wall: glTF's unlit material. As a lamp of the same
 * radiance, or a brighter one, it lights the wall. */
static bool floor_leaves_studio(float specular, float radiance) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.specular_factor = specular;
    for (int c = 0; c < 3; ++c) m.base_color[c] = 0, m.emissive[c] = radiance;
    fathom_scene *scene = new_scene(context);
    const fathom_id id = new_material(scene, "m", &m);
    add_wall(scene, vec_f64(0, 0, 0), vec_f64(1, 0, 0), vec_f64(0, 0, 1), id);
    add_wall(scene, vec_f64(0, 0, 0), vec_f64(1, 0, 0), vec_f64(0, 1, 0), 0);
    assert_ok(context, fathom_scene_complete(scene));
    const bool out = scene->in_studio;
    return out;
}

UNIT_TEST(what_only_shows_its_colour_is_no_lamp) {
    assert_true(floor_leaves_studio(0, 1));
    assert_false(floor_leaves_studio(1, 1));
    assert_false(floor_leaves_studio(0, 1.5f));
}

/* The faces of a slab, which look outwards. */
static const uint32_t slab[36] = {0, 2, 1, 1, 2, 3, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5,
                                  0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 4, 5, 6, 5, 7, 6};

/* A slab with its corners in the order that lets its faces look outwards, and a display on its front. */
static fathom_scene *open_telephone(float radiance, bool before_wall) {
    static const float corners[8][3] = {{0, 0, 0},   {1, 0, 0},   {0, 2, 0},   {1, 2, 0},
                                        {0, 0, .1f}, {1, 0, .1f}, {0, 2, .1f}, {1, 2, .1f}};
    fathom_mesh mesh = default_mesh();
    fathom_instance instance = default_instance();
    fathom_scene *scene = new_scene(context);
    assert_ok(context, fathom_scene_add_group(scene, "telephone", &instance.group));
    mesh.positions = corners[0], mesh.vertex_count = 8;
    mesh.indices = slab, mesh.triangle_count = 10;
    assert_ok(context, fathom_scene_add_mesh(scene, instance.group, &mesh, NULL));
    mesh.indices = slab + 30, mesh.triangle_count = 2, mesh.material = add_emission(scene, radiance);
    assert_ok(context, fathom_scene_add_mesh(scene, instance.group, &mesh, NULL));
    instance.transform[0] = -1; /* mirrored */
    assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
    if (before_wall) add_wall(scene, (vec3_f64){-2, -1, 1}, vec_f64(3, 0, 0), vec_f64(0, 4, 0), 0);
    assert_ok(context, fathom_scene_complete(scene));
    return scene;
}

UNIT_TEST(a_display_lights_what_it_faces_alone) {
    fathom_scene *scene = open_telephone(1000, false);
    double irradiance;
    assert_ok(context, scene_measure_lamps(scene, &irradiance));
    assert_near(irradiance, 0, 0);
    assert_true(scene->in_studio);
    scene = open_telephone(1000, true);
    assert_false(scene->in_studio);
}

/* A ball with a bright bead next to it: seen from the bead, the horizon at cos a = 1 / 1.1 cuts a cap of
 * (1 - cos a) / 2 = 4.5 % off the ball. However bright the bead is, the rest would be black without the
 * studio. The lamp at a distance of ten radii sees 45 % of the ball; they get up to L pi 0.5^2 / 9^2. */
UNIT_TEST(a_bright_part_alone_lights_no_model) {
    for (int lamp = 0; lamp < 2; ++lamp) {
        fathom_sphere ball = default_sphere();
        fathom_scene *scene = new_scene(context);
        ball.radius = 1;
        assert_ok(context, fathom_scene_add_sphere(scene, FATHOM_ROOT, &ball, NULL));
        ball.center[1] = lamp ? 10 : 1.1, ball.radius = lamp ? 0.5 : 0.1;
        ball.material = add_emission(scene, 1000);
        assert_ok(context, fathom_scene_add_sphere(scene, FATHOM_ROOT, &ball, NULL));
        assert_ok(context, fathom_scene_complete(scene));
        assert_true(scene->in_studio == !lamp);
    }
}

/* A room whose walls face outwards is lit by the lamp in it for whoever stands inside, and not for whoever
 * looks at it from outside. */
UNIT_TEST(a_room_is_lit_for_whoever_stands_in_it) {
    static const float corners[8][3] = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {2, 2, 0},
                                        {0, 0, 2}, {2, 0, 2}, {0, 2, 2}, {2, 2, 2}};
    for (int inside = 0; inside < 2; ++inside) {
        fathom_mesh mesh = default_mesh();
        fathom_camera camera;
        fathom_scene *scene = new_scene(context);
        mesh.positions = corners[0], mesh.vertex_count = 8;
        mesh.indices = slab, mesh.triangle_count = 12;
        assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
        add_wall(scene, vec_f64(0.8, 1.99, 0.8), vec_f64(0.4, 0, 0), vec_f64(0, 0, 0.4),
                 add_emission(scene, 30));
        fathom_camera_look_at((const double[]){1, 1, inside ? 1.9 : 9}, (const double[]){1, 1, 0},
                              (const double[]){0, 1, 0}, 1, &camera);
        assert_ok(context, fathom_scene_set_camera(scene, &camera));
        assert_ok(context, fathom_scene_complete(scene));
        assert_true(scene->in_studio == !inside);
    }
}

/* A mean over an infinite plane says nothing of its part next to the lamp. */
UNIT_TEST(a_lamp_over_a_plane_lights_it) {
    for (int lamp = 0; lamp < 2; ++lamp) {
        fathom_plane plane = default_plane();
        fathom_scene *scene = new_scene(context);
        plane.normal[1] = 1;
        assert_ok(context, fathom_scene_add_plane(scene, FATHOM_ROOT, &plane, NULL));
        add_wall(scene, vec_f64(0, 3, 0), vec_f64(1, 0, 0), vec_f64(0, 0, 1),
                 lamp ? add_emission(scene, 0.01f) : 0);
        assert_ok(context, fathom_scene_complete(scene));
        assert_true(scene->in_studio == !lamp);
    }
}

/* Two small squares at a distance of 1: radiance times area, times the cosine at the receiver. Their sizes
 * change the distance by less than 1e-4 of it. */
UNIT_TEST(irradiance_of_small_squares_has_a_closed_form) {
    const double edge = 0.01, slope = 0.5 * sqrt(3);
    for (int tilted = 0; tilted < 2; ++tilted) {
        double irradiance;
        fathom_scene *scene = new_scene(context);
        add_wall(scene, vec_f64(0, 0, 0), vec_f64(edge, 0, 0), vec_f64(0, edge, 0), add_emission(scene, 3));
        add_wall(scene, vec_f64(0, 0, 1), vec_f64(edge, 0, 0),
                 vec_f64(0, edge * (tilted ? 0.5 : 1), tilted ? edge * slope : 0), 0);
        assert_ok(context, scene_measure_lamps(scene, &irradiance));
        assert_near(irradiance, 3 * edge * edge * (tilted ? 0.5 : 1),
                    (tilted ? 0.03 : 3e-4) * 3 * edge * edge);
    }
}

/* A surface emits as far as it covers. */
UNIT_TEST(irradiance_is_that_of_what_covers) {
    double irradiance[2];
    for (int half = 0; half < 2; ++half) {
        fathom_scene *scene = new_scene(context);
        const fathom_id emission = add_emission(scene, 3);
        fathom_material *m = &scene->materials.items[emission].value;
        *m = (fathom_material){.model = FATHOM_MODEL_METALLIC_ROUGHNESS, .emissive = {3, 3, 3}};
        m->emissive_strength = m->specular_factor = 1, m->opacity = half ? 0.5f : 1;
        for (int k = 0; k < FATHOM_MAPS; ++k) m->maps[k].texture = FATHOM_NONE;
        add_wall(scene, vec_f64(0, 0, 0), vec_f64(1, 0, 0), vec_f64(0, 1, 0), emission);
        add_wall(scene, vec_f64(0, 0, 1), vec_f64(1, 0, 0), vec_f64(0, 1, 0), 0);
        assert_ok(context, scene_measure_lamps(scene, &irradiance[half]));
    }
    assert_true(irradiance[0] > 0 && irradiance[1] == irradiance[0] / 2);
}

/* Black pixels say what the studio could add unseen: its brightest panel is above 4. */
UNIT_TEST(errors_know_how_bright_it_is) {
    fathom_scene *scene = open_ball();
    assert_ok(context, fathom_scene_complete(scene));
    fathom_settings settings = default_settings();
    fathom_film *film;
    settings.width = settings.height = 16, settings.spp = 16, settings.target_error = 0;
    settings.max_depth = 0, settings.aovs = FATHOM_AOV_ERROR;
    assert_ok(context, fathom_render(context, scene, &settings, NULL, NULL, NULL, &film));
    /* The ball itself is black without a bounce. By the rule of three for 16 samples. */
    const size_t middle = 8 * 16 + 8;
    const double share = 1 - pow(0.05, 1 / 16.0);
    assert_true(fathom_film_channel(film, "G")[middle] == 0);
    assert_true(fathom_film_channel(film, "error.doubt")[middle] == 1);
    assert_true((double)fathom_film_channel(film, "error.G")[middle] > share * 4 / 2.1);
    assert_true((double)fathom_film_channel(film, "error.G")[middle] < share * 6 / 2.0);
    fathom_film_destroy(film);
}

int main(void) { return unit_main(open_folder, remove_folder); }
