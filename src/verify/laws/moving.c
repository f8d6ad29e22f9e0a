/* Laws of motion while the shutter is open. */
#include "verify/laws/common.h"

/* ---- an edge that moves at constant speed ----
 * The image is the square of side 1 around 0; a black half plane hides the sky right of x(t) = from + t (to -
 * from). Its fraction of the image at a time is clamp(1/2 - x). The mean over time is the area of a trapezoid
 * in x, divided by to - from. */

/* ∫ clamp(1/2 - y, 0, 1) dy from -1/2 to x. */
static double trapezoid(double x) {
    if (x < -0.5) return x + 0.5;
    if (x > 0.5) return 0.5;
    return 0.5 * (x + 0.5) - 0.5 * (x * x - 0.25);
}

static const double from = -0.8, to = 0.35;

/* Sets a camera that looks down on the square from height 4, with the shutter open from 2 to 3. */
static void look_at_edge(law_room *room, const double *key_times, const double *key_frames) {
    fathom_camera camera = build_view(vec_f64(0, 0, 4), origin, 1);
    camera.d = 1, camera.h = 0.25, camera.shutter[0] = 2, camera.shutter[1] = 3;
    camera.key_count = key_times ? 2 : 0, camera.key_times = key_times, camera.key_frames = key_frames;
    build_camera(&room->b, camera);
    build_background(&room->b, white);
    law_value(room, gray(1 - (trapezoid(to) - trapezoid(from)) / (to - from)));
}

/* Keys are at 0 and 4. The edge is at `from` at time 2 and at `to` at time 3. */
static const double times[2] = {0, 4};
static double start(void) { return from - 2 * (to - from); }
static double end(void) { return to + (to - from); }

/* Adds an instance of the group with two key transforms at the times above. */
static void move_group(law_room *room, fathom_id group, const double maps[24]) {
    fathom_instance instance;
    fathom_instance_default(&instance);
    instance.group = group;
    instance.key_count = 2, instance.key_times = times, instance.key_transforms = maps;
    build_instance(&room->b, &instance);
}

/* Adds a quad of two triangles whose four corners have two positions each, at the times above. */
static void move_corners(law_room *room, const float keys[24], fathom_material m) {
    fathom_mesh mesh;
    fathom_mesh_default(&mesh);
    mesh.positions = keys, mesh.vertex_count = 4;
    mesh.indices = (const uint32_t[]){0, 1, 2, 0, 2, 3}, mesh.triangle_count = 2;
    mesh.key_count = 2, mesh.key_times = times, mesh.key_positions = keys;
    build_mesh(&room->b, mesh, build_material(&room->b, m));
}

static void add_half_plane(law_room *room) {
    paint_quad(&room->b, vec_f64(10, 0, 0), vec_f64(10, 0, 0), vec_f64(0, 10, 0), build_black());
}

static void moving_edge(law_room *room) {
    const double maps[24] = {1, 0, 0, start(), 0, 1, 0, 0, 0, 0, 1, 0,
                             1, 0, 0, end(),   0, 1, 0, 0, 0, 0, 1, 0};
    const fathom_id group = room->b.group = build_group(&room->b);
    add_half_plane(room);
    move_group(room, group, maps);
    look_at_edge(room, NULL, NULL);
}

static void moving_camera(law_room *room) {
    const double frames[24] = {1, 0, 0, -start(), 0, 1, 0, 0, 0, 0, 1, 4,
                               1, 0, 0, -end(),   0, 1, 0, 0, 0, 0, 1, 4};
    add_half_plane(room);
    look_at_edge(room, times, frames);
}

/* The corners on the edge move, the others do not. */
static void moving_corners(law_room *room) {
    const float a = (float)start(), b = (float)end();
    const float keys[24] = {a, -10, 0, 20, -10, 0, 20, 10, 0, a, 10, 0,
                            b, -10, 0, 20, -10, 0, 20, 10, 0, b, 10, 0};
    move_corners(room, keys, build_black());
    look_at_edge(room, NULL, NULL);
}

/* ---- a convex body that moves, rotates and is scaled under a uniform sky: ρ L ----
 * No ray that leaves the body hits it again. */

/* A ball (1) or a box (0). */
static void moving_body(law_room *room) {
    const bool ball = room->number == 1;
    const double albedo = 0.5, half = sqrt(0.5);
    const double maps[24] = {1,     0,           0, -0.25, 0,    1,           0, 0,   0, 0, 1, 0,
                             -half, -1.5 * half, 0, 0.25,  half, -1.5 * half, 0, 0.1, 0, 0, 2, 0.25};
    const fathom_id group = room->b.group = build_group(&room->b);
    const fathom_id material = build_material(&room->b, build_lambert(gray(albedo)));
    if (ball) build_sphere(&room->b, origin, 1, material);
    for (int i = 0; !ball && i < 6; ++i) {
        double axis[3][3] = {{0}};
        for (int k = 0; k < 3; ++k) axis[k][(i / 2 + k) % 3] = k || i % 2 ? 1 : -1;
        build_quad(&room->b, load_f64(axis[0]), load_f64(axis[1]), load_f64(axis[2]), material);
    }
    move_group(room, group, maps);
    fathom_camera camera = build_view(vec_f64(3, -2, 4), origin, 0.1);
    camera.shutter[1] = 4;
    build_camera(&room->b, camera);
    build_background(&room->b, white);
    law_value(room, gray(albedo));
}

/* ---- a lamp moves over a floor while the shutter is open, from 0 to 4 ---- */

static void floor_under(law_room *room, double share) {
    const vec3_f64 albedo = {1, 0.5, 0.2};
    fathom_camera camera = build_view(vec_f64(-1, -0.8, 0.7), origin, 1);
    camera.d = 1, camera.h = 1.0 / 4096, camera.shutter[1] = 4;
    build_camera(&room->b, camera);
    room->b.group = FATHOM_ROOT;
    paint_plane(&room->b, origin, up, build_lambert(albedo));
    room->depth = 2;
    law_value(room, scale_f64(share, albedo));
}

/* (R/d)² cos θ = R² h / (a² + h²)^3/2, over heights from `low` to `high`. */
static void rising_lamp(law_room *room) {
    const double R = 0.2, a = 0.5, low = 0.4, high = 2;
    const double maps[24] = {1, 0, 0, a, 0, 1, 0, 0, 0, 0, 1, low, 1, 0, 0, a, 0, 1, 0, 0, 0, 0, 1, high};
    const fathom_id group = room->b.group = build_group(&room->b);
    paint_sphere(&room->b, origin, R, build_emitter(white));
    move_group(room, group, maps);
    floor_under(room, R * R * (1 / hypot(a, low) - 1 / hypot(a, high)) / (high - low));
}

static const vec3_f64 panel[4] = {{-0.5, -0.4, 0}, {0.5, -0.3, 0}, {0.6, 0.5, 0}, {-0.4, 0.4, 0}};

/* Mean irradiance of the panel over time, by Simpson's rule. */
static double mean_polygon(void (*when)(double time, vec3_f64 corners[4])) {
    enum { PARTS = 256 };
    double sum = 0;
    for (int i = 0; i <= PARTS; ++i) {
        vec3_f64 corners[4];
        when((double)i / PARTS, corners);
        sum += law_polygon(corners, 4) * (i == 0 || i == PARTS ? 1 : (i % 2 ? 4 : 2));
    }
    return sum / (3 * PARTS);
}

/* The panel rotates around x while it moves. */
static const double tilt = 1.1;

static void tilted(double time, vec3_f64 corners[4]) {
    const double c = cos(tilt * time), s = sin(tilt * time);
    for (int k = 0; k < 4; ++k)
        corners[k] = vec_f64(panel[k].x + 0.6 * time, c * panel[k].y, s * panel[k].y + 0.7 + 0.3 * time);
}

static void turning_panel(law_room *room) {
    const double c = cos(tilt), s = sin(tilt);
    const double maps[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.7, 1, 0, 0, 0.6, 0, c, -s, 0, 0, s, c, 1};
    const fathom_id group = room->b.group = build_group(&room->b);
    law_fan(room, panel, 4, build_emitter(white));
    move_group(room, group, maps);
    floor_under(room, mean_polygon(tilted));
}

/* Two corners of the panel move down, and all move sideways. */
static void bent(double time, vec3_f64 corners[4]) {
    for (int k = 0; k < 4; ++k)
        corners[k] = vec_f64(panel[k].x + 0.3 * time, panel[k].y, k < 2 ? 1.2 - 0.9 * time : 1.2);
}

static void bending_panel(law_room *room) {
    float keys[24];
    for (int key = 0; key < 2; ++key) {
        vec3_f64 corners[4];
        bent(key, corners);
        for (int k = 0; k < 4; ++k) build_rgb(keys + 12 * key + 3 * k, corners[k]);
    }
    move_corners(room, keys, build_emitter(white));
    floor_under(room, mean_polygon(bent));
}

const law laws_of_motion[] = {{"edge that moves across", "1 - trapezoid/(x₁-x₀)", moving_edge, 0},
                              {"edge that its corners move", "1 - trapezoid/(x₁-x₀)", moving_corners, 0},
                              {"edge before a moving camera", "1 - trapezoid/(x₁-x₀)", moving_camera, 0},
                              {"ball that flies and turns", "ρ L", moving_body, 1},
                              {"box that flies and turns", "ρ L", moving_body, 0},
                              {"lamp that rises over a floor", "∫ (R/d)² cos θ dt", rising_lamp, 0},
                              {"panel that flies and turns", "∫ Lambert's edge sum dt", turning_panel, 0},
                              {"panel that its corners move", "∫ Lambert's edge sum dt", bending_panel, 0},
                              {NULL, NULL, NULL, 0}};
