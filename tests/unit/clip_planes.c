/* The camera's clip planes, by closed form: walls at depths 1, 3 and 5 shine red, green and blue. */
#include "render.h"

enum { SIDE = 8, PIXELS = SIDE * SIDE };

typedef enum camera_kind { PINHOLE, LENS, ORTHOGRAPHIC, FAR_AWAY, MOVING, KINDS } camera_kind;

static const fathom_integrator integrators[] = {FATHOM_INTEGRATOR_CLASSIC, FATHOM_INTEGRATOR_PATH,
                                                FATHOM_INTEGRATOR_REFERENCE};

/* Depth 0 lies at the origin. The camera looks along -z from `behind` behind it. */
static fathom_camera look(camera_kind kind, double near, double far) {
    static const double times[] = {0, 1};
    static const double frames[] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0};
    const double behind = kind == FAR_AWAY ? 1e6 : 0;
    fathom_camera camera = default_camera();
    camera.near_clip = near + behind, camera.far_clip = far > 0 ? far + behind : 0;
    camera.orthographic = kind == ORTHOGRAPHIC;
    camera.origin[2] = behind;
    if (kind == FAR_AWAY) camera.d = 1e6;
    if (kind == LENS) camera.lens_radius = 0.25, camera.focus_distance = 2;
    if (kind == MOVING) {
        camera.key_count = 2, camera.key_times = times, camera.key_frames = frames;
        camera.shutter[1] = 1;
    }
    return camera;
}

static stage open_stage(fathom_integrator integrator, const fathom_camera *camera) {
    stage s = stage_open(SIDE, SIDE);
    fathom_settings_set_integrator(&s.settings, integrator);
    s.settings.target_error = 0, s.settings.spp = 4;
    if (integrator != FATHOM_INTEGRATOR_REFERENCE) s.settings.aovs = FATHOM_AOV_Z;
    assert_ok(s.context, fathom_scene_set_camera(s.scene, camera));
    assert_ok(s.context, fathom_scene_set_background(s.scene, (const float[3]){0.25f, 0.25f, 0.25f}));
    return s;
}

/* A wall that faces the camera. */
static void add_wall(stage *s, double depth, fathom_id material) {
    stage_quad(s, (double[3]){0, 0, -depth}, (double[3]){50, 0, 0}, (double[3]){0, 50, 0}, material);
}

static fathom_id add_color(stage *s, const float ke[3]) {
    fathom_material material = default_material();
    memset(material.k_d, 0, sizeof material.k_d), memcpy(material.k_e, ke, sizeof material.k_e);
    return stage_material(s, &material);
}

static void assert_all(stage *s, const float rgb[3], double depth) {
    static const char *const names[] = {"R", "G", "B"};
    fathom_film *film = stage_render(s);
    for (int k = 0; k < 3 * PIXELS; ++k)
        assert_true(fathom_film_channel(film, names[k % 3])[k / 3] == rgb[k % 3]);
    const float *z = fathom_film_channel(film, "Z");
    for (int k = 0; z && k < PIXELS; ++k) {
        /* Float rounds the place of a hit and its depth, both below 8 without the camera's distance. */
        if (isfinite(depth))
            assert_near(z[k], depth, 8 * 0x1p-23 + depth * 0x1p-23);
        else
            assert_true(isinf(z[k]));
    }
}

UNIT_TEST(the_camera_sees_what_lies_between_the_planes) {
    static const float colors[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.25f, 0.25f, 0.25f}};
    static const struct {
        double near, far;
        int shown;
    } cases[] = {{0, 0, 0}, {2, 0, 1},     {4, 0, 2},   {6, 0, 3},
                 {2, 4, 1}, {1.5, 2.5, 3}, {0, 0.5, 3}, {3.5, 5.5, 2}};
    for (unsigned i = 0; i < 3 * KINDS * sizeof cases / sizeof *cases; ++i) {
        const camera_kind kind = (camera_kind)(i / 3 % KINDS);
        const fathom_camera camera = look(kind, cases[i / 3 / KINDS].near, cases[i / 3 / KINDS].far);
        const int shown = cases[i / 3 / KINDS].shown;
        if (kind == MOVING && integrators[i % 3] == FATHOM_INTEGRATOR_CLASSIC) continue;
        stage s = open_stage(integrators[i % 3], &camera);
        for (int k = 0; k < 3; ++k) add_wall(&s, 1 + 2 * k, add_color(&s, colors[k]));
        assert_all(&s, colors[shown], shown < 3 ? 1 + 2 * shown + camera.origin[2] : (double)INFINITY);
    }
}

/* A mirror between the planes shows the wall that faces it from before the near plane. */
UNIT_TEST(mirrors_are_not_clipped) {
    static const float green[3] = {0, 1, 0};
    for (int i = 0; i < 3; ++i) {
        const fathom_camera camera = look(PINHOLE, 2, 4);
        stage s = open_stage(integrators[i], &camera);
        fathom_material mirror = default_material();
        for (int c = 0; c < 3; ++c) mirror.k_d[c] = 0, mirror.k_r[c] = 1;
        add_wall(&s, 3, stage_material(&s, &mirror));
        add_wall(&s, 1, add_color(&s, green));
        assert_all(&s, green, 3);
    }
}

/* Behind a wall that is all hole, the far plane still counts. */
UNIT_TEST(the_far_plane_hides_what_is_behind_holes) {
    static const float green[3] = {0, 1, 0}, background[3] = {0.25f, 0.25f, 0.25f};
    for (int i = 0; i < 2 * 2 * KINDS; ++i) {
        const bool hidden = i & 1;
        const fathom_camera camera = look((camera_kind)(i / 4), 2, hidden ? 4.5 : 5.5);
        stage s = open_stage(integrators[1 + i / 2 % 2], &camera);
        fathom_material hole = default_material();
        hole.model = FATHOM_MODEL_METALLIC_ROUGHNESS, hole.opacity = 0;
        add_wall(&s, 3, stage_material(&s, &hole));
        add_wall(&s, 4, stage_material(&s, &hole));
        add_wall(&s, 5, add_color(&s, green));
        assert_all(&s, hidden ? background : green, hidden ? (double)INFINITY : 5 + camera.origin[2]);
    }
}

/* The near plane cuts a ball of glass open. It contains the starts of rays, which leave it once; so an even
 * sky shines with what one surface lets pass, and the absorption of the way in the ball. */
UNIT_TEST(rays_start_in_the_volumes_at_the_near_plane) {
    for (int i = 1; i < 3; ++i) {
        fathom_camera camera = look(ORTHOGRAPHIC, 3, 0);
        camera.h = 1e-3;
        stage s = open_stage(integrators[i], &camera);
        fathom_material glass = default_material();
        glass.model = FATHOM_MODEL_METALLIC_ROUGHNESS, glass.metallic = 0, glass.roughness = 0;
        glass.transmission = 1, glass.thickness = 1, glass.ior = 1, glass.specular = 0;
        glass.attenuation_distance = 1;
        for (int c = 0; c < 3; ++c) glass.attenuation_color[c] = 0.5f;
        stage_sphere(&s, 0, 0, -3, 1, stage_material(&s, &glass));
        fathom_film *film = stage_render(&s);
        /* 0.25 of the sky times half for the radius of 1, less 1.2e-7 for the rays beside the middle. */
        for (int k = 0; k < PIXELS; ++k) assert_near(fathom_film_channel(film, "R")[k], 0.125, 0.125 * 1e-6);
    }
}

/* A closed mesh is not mended where a plane cuts it. The rays meet the unit sphere within 0.1 of its axis,
 * where it is 0.005 less deep. The mesh lies within 1 - cos(2 pi / 48) = 0.0086 of it. */
UNIT_TEST(planes_cut_closed_meshes) {
    static const float black[3] = {0, 0, 0};
    static const struct {
        double z, near, far;
        bool hit;
    } cases[] = {
        {2, 2.9, 0, true}, {2, 1.5, 2.5, false}, {0, 0, 0.5, false}, {2, 0, 0.95, false}, {2, 0, 0, true}};
    for (unsigned i = 0; i < 2 * sizeof cases / sizeof *cases; ++i) {
        fathom_camera camera = look(PINHOLE, cases[i / 2].near, cases[i / 2].far);
        camera.origin[2] = cases[i / 2].z, camera.h = 0.05;
        stage s = open_stage(integrators[i % 2], &camera);
        const float shown = cases[i / 2].hit ? 1 : 0;
        const bool front = cases[i / 2].near == 0;
        assert_ok(s.context, fathom_scene_set_background(s.scene, black));
        stage_mesh_sphere(&s, FATHOM_ROOT, 24, 48, stage_emitter(&s, 1));
        fathom_film *film = stage_render(&s);
        for (int k = 0; k < PIXELS; ++k) {
            assert_true(fathom_film_channel(film, "R")[k] == shown);
            if (cases[i / 2].hit) assert_near(fathom_film_channel(film, "Z")[k], front ? 1 : 3, 0.02);
        }
    }
}

UNIT_TEST(planes_out_of_order_are_refused) {
    static const double wrong[][2] = {{-1, 0},  {0, -1},  {2, 2},        {2, 1},
                                      {NAN, 0}, {0, NAN}, {INFINITY, 0}, {0, INFINITY}};
    stage s = stage_open(8, 8);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        const fathom_camera camera = look(PINHOLE, wrong[i][0], 0);
        fathom_camera bad = camera;
        bad.far_clip = wrong[i][1];
        assert_fails(s.context, fathom_scene_set_camera(s.scene, &bad), FATHOM_BAD_INPUT,
                     "a far plane behind it");
    }
}

int main(void) { return unit_main(NULL, NULL); }
