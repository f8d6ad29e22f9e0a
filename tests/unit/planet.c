/* A part of a millimetre on a planet: its shadow lies where a flat ground would have it, and the ground is
 * lit all around it.
 *
 * The ground is a sphere of Earth's radius, a number of metres that is no float; within a centimetre it sinks
 * by (1e-2)² / 2 R = 8e-12 m below its tangent plane. The camera looks down from half a metre. A pixel is
 * judged when the ray that the model sends through its middle, and from where it meets the plane to the
 * light, passes the outline of what it meets or misses by more than `slack`: the camera's ray is rounded in
 * origin and direction, by 2^-24 of half a metre and of 1 on each axis, 1e-7 m at the ground; centre and
 * radius are good to 2^-48 of R, 2e-8 m each, and a coordinate on the planet's far side of the scene's origin
 * to 2^-53 of R, 1e-9 m. The start is within 32 units of numbers up to 5 mm, 1e-8 m. Together 1.6e-7 m; a
 * pixel is 4e-5 m wide. */
#include "render.h"

#include "math/frame.h"

static const double radius = 6371000.3, slack = 2e-7, part = 1e-3;
enum { SIDE = 256 };
#define EYE 0.5
#define WIDTH 0.01

static const vec3_f64 to_light = {0.6, 0, 0.8}; /* in the ground's frame, z up */

static vec3_f64 frame_vector_to_world(const frame_f64 *f, vec3_f64 v) {
    return madd_f64(madd_f64(scale_f64(v.x, f->x), v.y, f->y), v.z, f->z);
}

static vec3_f64 frame_point_to_world(const frame_f64 *f, vec3_f64 p) {
    return add_f64(f->origin, frame_vector_to_world(f, p));
}

static void place(const frame_f64 *ground, double x, double y, double z, double out[3]) {
    store_f64(out, frame_point_to_world(ground, vec_f64(x, y, z)));
}

/* The planet touches the frame's origin from below. */
static void set_ground(stage *s, const frame_f64 *ground, fathom_id material) {
    double c[3], eye[3], up[3], target[3], light[3];
    place(ground, 0, 0, -radius, c);
    stage_sphere(s, c[0], c[1], c[2], radius, material);
    place(ground, 0, 0, EYE, eye);
    place(ground, 0, 0, 0, target);
    store_f64(up, ground->y);
    stage_camera(s, eye, target, up, 2 * atan(WIDTH / 2 / EYE));
    fathom_light l = default_light();
    l.type = FATHOM_LIGHT_DIRECTIONAL;
    store_f64(light, frame_vector_to_world(ground, to_light));
    for (int k = 0; k < 3; ++k) l.direction[k] = -light[k], l.intensity[k] = 1;
    assert_ok(s->context, fathom_scene_add_light(s->scene, &l, NULL));
}

/* A square of two triangles, a part wide, half a part above the ground. */
static void add_square(stage *s, const frame_f64 *ground, fathom_id material) {
    float p[12];
    const uint32_t index[6] = {0, 1, 2, 0, 2, 3};
    for (int k = 0; k < 4; ++k) {
        double x = k == 1 || k == 2 ? part / 2 : -part / 2, y = k >= 2 ? part / 2 : -part / 2;
        vec3_f64 v = frame_vector_to_world(ground, vec_f64(x, y, part / 2));
        store_f32(p + 3 * k, narrow(v));
    }
    fathom_mesh mesh = default_mesh();
    mesh.positions = p, mesh.vertex_count = 4, mesh.indices = index, mesh.triangle_count = 2;
    mesh.material = material;
    store_f64(mesh.origin, ground->origin);
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, FATHOM_ROOT, &mesh, NULL));
}

/* How far within the outline of the part the line through p along d passes: negative without. */
static double within_ball(vec3_f64 p, vec3_f64 d) {
    vec3_f64 from = sub_f64(p, vec_f64(0, 0, part));
    return part - length_f64(madd_f64(from, -dot_f64(from, d) / dot_f64(d, d), d));
}
static double within_square(vec3_f64 p, vec3_f64 d) {
    vec3_f64 q = madd_f64(p, (part / 2 - p.z) / d.z, d);
    return part / 2 - fmax(fabs(q.x), fabs(q.y));
}

typedef struct tally {
    int lit, dark, unsure;
} tally;

static void judge(const fathom_film *film, double (*within)(vec3_f64 p, vec3_f64 d), tally *out) {
    const float *pixels = fathom_film_channel(film, "R");
    assert_non_null(pixels);
    for (int row = 0; row < SIDE; ++row) {
        for (int column = 0; column < SIDE; ++column) {
            double x = ((column + 0.5) / SIDE - 0.5) * WIDTH, y = (0.5 - (row + 0.5) / SIDE) * WIDTH;
            vec3_f64 p = {x, y, 0};
            double seen = within(p, vec_f64(x, y, -EYE)), shaded = within(p, to_light);
            if (seen > -slack) continue; /* the part itself */
            float value = pixels[row * SIDE + column];
            if (fabs(shaded) <= slack) {
                ++out->unsure;
            } else if (shaded > 0) {
                ++out->dark;
                if (value != 0) fail_msg("%d %d: %g in the shadow", column, row, (double)value);
            } else {
                ++out->lit;
                /* k_d n·l, by a dozen roundings of float. */
                if (!(fabs((double)value - 0.8) < 1e-6))
                    fail_msg("%d %d: %g in the light", column, row, (double)value);
            }
        }
    }
}

static void check(const frame_f64 *ground, const char *tracer, bool ball) {
    stage s = stage_open(SIDE, SIDE);
    fathom_id white = stage_lambert(&s, 1);
    s.settings.tracer = tracer;
    set_ground(&s, ground, white);
    if (ball) {
        double c[3];
        place(ground, 0, 0, part, c);
        stage_sphere(&s, c[0], c[1], c[2], part, white);
    } else {
        add_square(&s, ground, white);
    }
    fathom_film *film = stage_render(&s);
    tally t = {0};
    judge(film, ball ? within_ball : within_square, &t);
    print_message("lit %d, dark %d, unsure %d\n", t.lit, t.dark, t.unsure);
    assert_true(t.lit > 50000 && t.dark > 200 && t.unsure < 100);
}

static void check_all(const frame_f64 *ground) {
    for (int ball = 0; ball < 2; ++ball) {
        check(ground, "reference", ball);
        check(ground, "embree", ball);
    }
}

UNIT_TEST(the_part_at_the_origin) {
    frame_f64 ground = frame_from(vec_f64(0, 0, 0), vec_f64(0.3, 0.2, 1), vec_f64(0, 1, 0));
    check_all(&ground);
}

UNIT_TEST(the_planet_at_the_origin) {
    vec3_f64 up = normalize_f64(vec_f64(0.6, -0.64, 0.48));
    frame_f64 ground = frame_from(scale_f64(radius, up), up, vec_f64(0, 1, 0));
    check_all(&ground);
}

int main(void) { return unit_main(NULL, NULL); }
