/* No light leaks through the vertices of a closed mesh, where every ray is aimed at one. */
#include "render.h"

#include "math/vec.h"

#define W (SANITIZED ? 72 : 96)
#define H (SANITIZED ? 54 : 72)

/* A closed mesh whose front is a grid of these points and whose back is a fan to the apex. */
static void add_cave_to(stage *s, fathom_id group, const vec3_f64 *points, vec3_f64 apex,
                        fathom_id material) {
    static float p[(W * H + 1) * 3];
    static uint32_t index[(2 * W * H + 4 * (W + H)) * 3];
    uint32_t *t = index, top = W * H;
    for (uint32_t i = 0; i < W * H; ++i) store_f32(&p[3 * i], narrow(points[i]));
    store_f32(&p[3 * top], narrow(apex));
    for (uint32_t y = 0; y + 1 < H; ++y) {
        for (uint32_t x = 0; x + 1 < W; ++x) {
            uint32_t a = y * W + x, b = a + 1, c = a + W, d = c + 1;
            const uint32_t two[6] = {a, b, c, b, d, c};
            memcpy(t, two, sizeof two), t += 6;
        }
    }
    for (uint32_t x = 0; x + 1 < W; ++x) {
        const uint32_t two[6] = {x + 1, x, top, (H - 1) * W + x, (H - 1) * W + x + 1, top};
        memcpy(t, two, sizeof two), t += 6;
    }
    for (uint32_t y = 0; y + 1 < H; ++y) {
        const uint32_t two[6] = {y * W, (y + 1) * W, top, (y + 2) * W - 1, (y + 1) * W - 1, top};
        memcpy(t, two, sizeof two), t += 6;
    }
    fathom_mesh mesh = default_mesh();
    mesh.positions = p, mesh.vertex_count = W * H + 1;
    mesh.indices = index, mesh.triangle_count = (uint32_t)(t - index) / 3, mesh.material = material;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, group, &mesh, NULL));
}

static void add_cave(stage *s, const vec3_f64 *points, vec3_f64 apex, fathom_id material) {
    add_cave_to(s, FATHOM_ROOT, points, apex, material);
}

/* A closed cube around (x, y, z) that casts no shadow. */
static void add_cube(stage *s, double x, double y, double z, double half, fathom_id material) {
    float p[8][3];
    const uint32_t index[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    for (int i = 0; i < 8; ++i) {
        p[i][0] = (float)(x + (i & 1 ? half : -half));
        p[i][1] = (float)(y + (i & 2 ? half : -half));
        p[i][2] = (float)(z + (i & 4 ? half : -half));
    }
    fathom_mesh mesh = default_mesh();
    mesh.positions = p[0], mesh.vertex_count = 8;
    mesh.indices = index, mesh.triangle_count = 12, mesh.material = material;
    mesh.flags = FATHOM_CASTS_NO_SHADOW;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, FATHOM_ROOT, &mesh, NULL));
}

/* Mirrors all of the light, or lets all of it through, as it came. */
static fathom_id add_specular(stage *s, bool glass) {
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0, (glass ? m.k_t : m.k_r)[c] = 1;
    m.ior = 1;
    return stage_material(s, &m);
}

/* Where the middle of each pixel looks, at distance 1 along the axis. The camera stands at 0. */
static void looks(double half_width, vec3_f64 *out) {
    for (int y = 0; y < H; ++y) {
        for (int x = 0; x < W; ++x) {
            double u = (x + 0.5) / W * 2 - 1, v = 1 - (y + 0.5) / H * 2;
            out[y * W + x] = vec_f64(u * half_width, v * half_width * H / W, -1);
        }
    }
}

static void set_camera(stage *s, double half_width) {
    const double eye[3] = {0, 0, 0}, target[3] = {0, 0, -1}, up[3] = {0, 1, 0};
    stage_camera(s, eye, target, up, 2 * atan(half_width * H / W));
}

static size_t bright(stage *s, const char *tracer, uint64_t *repaired) {
    fathom_stats stats = {.size = sizeof stats};
    fathom_film *film;
    s->settings.tracer = tracer;
    assert_ok(s->context, fathom_render(s->context, s->scene, &s->settings, NULL, NULL, &stats, &film));
    const float *red = fathom_film_channel(film, "R");
    size_t count = 0;
    for (size_t i = 0; i < W * H; ++i) count += red[i] != 0;
    fathom_film_destroy(film);
    *repaired = stats.repaired_rays;
    return count;
}

/* Raw answers must leak, or the test shows nothing: robust ones only where rays keep to the vertices within a
 * few roundings. */
static void only_raw_leaks(stage *s, bool robust_too) {
    static const char *const tight[] = {"embree:default", "embree", "embree:high:1", "embree:user", "linear"};
    uint64_t repaired;
    assert_in_range(bright(s, "embree:default:raw", &repaired), 1, W * H);
    if (robust_too) assert_in_range(bright(s, "embree:raw", &repaired), 1, W * H);
    for (size_t i = 0; i < sizeof tight / sizeof *tight; ++i) {
        assert_int_equal(bright(s, tight[i], &repaired), 0);
        if (i < (robust_too ? 2 : 1)) assert_true(repaired > 0);
    }
}

/* A black cave, and a bright world outside. */
UNIT_TEST(no_background_from_inside) {
    static vec3_f64 points[W * H];
    stage s = stage_open(W, H);
    const float white[3] = {1, 1, 1};
    fathom_scene_set_background(s.scene, white);
    looks(0.5, points);
    for (int i = 0; i < W * H; ++i) points[i] = scale_f64(3 + 0.3 * sin(0.7 * i), points[i]);
    add_cave(&s, points, vec_f64(0.1, 0.2, 4), stage_lambert(&s, 0.5f));
    set_camera(&s, 0.5);
    only_raw_leaks(&s, true);
}

/* What stands outside of the cave and shines, wherever rays that leak would go. */
static void add_outside(stage *s) {
    const double behind[3] = {0, 0, -9}, side[3] = {2.6, 0, -2.9}, u[3] = {90, 0, 0}, v[3] = {0, 90, 0};
    const double small_u[3] = {0, 0.3, 0}, small_v[3] = {0, 0, 0.3};
    fathom_id light = stage_emitter(s, 1);
    stage_sphere(s, 0, 0, -60, 45, light);
    stage_quad(s, behind, u, v, light);
    stage_quad(s, side, small_u, small_v, light);
    add_cube(s, 0, 0, -6, 1, light);
}

typedef enum way { STRAIGHT, MIRRORED, THROUGH_GLASS, SKEWED, NESTED } way;

/* A black cave around the camera, whose vertices the rays are aimed at on this way. */
static void add_black_cave(stage *s, way how) {
    static vec3_f64 points[W * H];
    fathom_id black = stage_lambert(s, 0.5f), group = FATHOM_ROOT;
    const double mirror[3] = {0, 0, -1}, u[3] = {3, 0, 0}, v[3] = {0, 3, 0};
    looks(0.5, points);
    for (int i = 0; i < W * H; ++i) points[i] = scale_f64(3 + 0.3 * sin(0.7 * i), points[i]);
    vec3_f64 apex = {0.1, 0.2, 7};
    if (how == MIRRORED) { /* at z = -1: rays go on as if they came from (0, 0, -2) and towards +z */
        for (int i = 0; i < W * H; ++i) points[i].z = -2 - points[i].z;
        for (int i = 0; i < W * H; ++i) points[i].z += i % 2 ? 0.25 : 0;
        apex.z = -9;
        stage_quad(s, mirror, u, v, add_specular(s, false));
    }
    if (how == THROUGH_GLASS) add_cube(s, 0, 0, 0, 1, add_specular(s, true));
    if (how == SKEWED) { /* placed mirrored, skewed and squeezed, so as to be where it was */
        assert_ok(s->context, fathom_scene_add_group(s->scene, "cave", &group));
        for (int i = 0; i < W * H; ++i)
            points[i] = vec_f64(-points[i].x, 2 * points[i].y, points[i].z - 0.5 * points[i].x);
        apex = vec_f64(-apex.x, 2 * apex.y, apex.z - 0.5 * apex.x);
        fathom_instance instance = default_instance();
        const double map[12] = {-1, 0, 0, 0, 0, 0.5, 0, 0, -0.5, 0, 1, 0};
        instance.group = group;
        memcpy(instance.transform, map, sizeof map);
        assert_ok(s->context, fathom_scene_add_instance(s->scene, &instance, NULL));
    }
    add_cave_to(s, group, points, apex, black);
    if (how == NESTED) { /* one around it, whose vertices the same rays pass */
        for (int i = 0; i < W * H; ++i) points[i] = scale_f64(1.5, points[i]);
        add_cave(s, points, vec_f64(0.2, 0.3, 12), stage_emitter(s, 1));
    }
}

UNIT_TEST(nothing_outside_is_seen_from_inside) {
    for (way how = STRAIGHT; how <= NESTED; ++how) {
        stage s = stage_open(W, H);
        const float white[3] = {1, 1, 1};
        fathom_scene_set_background(s.scene, white);
        s.settings.max_depth = 4;
        add_black_cave(&s, how);
        add_outside(&s);
        set_camera(&s, 0.5);
        only_raw_leaks(&s, false);
    }
}

/* A cave with a white floor, and a sun outside: the way from each point seen to the sun is through a vertex
 * of the ceiling. */
static void no_sun(bool alone) {
    static vec3_f64 points[W * H];
    stage s = stage_open(W, H);
    fathom_id white = stage_lambert(&s, 1);
    /* A small one: rays start off it by a part of its size, and pass the vertices by a part of that. */
    const double floor_at[3] = {0, 0, -3}, u[3] = {2, 0, 0}, v[3] = {0, 2, 0};
    stage_quad(&s, floor_at, u, v, white);
    fathom_light sun = default_light();
    sun.type = FATHOM_LIGHT_DIRECTIONAL;
    const vec3_f64 to_sun = {0.1, 0.05, 1};
    for (int c = 0; c < 3; ++c) sun.intensity[c] = 1;
    sun.direction[0] = -to_sun.x, sun.direction[1] = -to_sun.y, sun.direction[2] = -to_sun.z;
    assert_ok(s.context, fathom_scene_add_light(s.scene, &sun, NULL));
    looks(0.5, points);
    for (int i = 0; i < W * H; ++i)
        points[i] = madd_f64(scale_f64(3, points[i]), 5 + 0.2 * sin(0.7 * i), to_sun);
    add_cave(&s, points, vec_f64(-0.4, -0.2, -90), white);
    set_camera(&s, 0.5);
    if (!alone) { /* a cave of black glass that casts no shadow, and one aside */
        add_cube(&s, 0, 0, 0, 300, add_specular(&s, true));
        add_cube(&s, 50, 0, 0, 1, white);
    }
    only_raw_leaks(&s, false);
}

UNIT_TEST(no_sun_from_outside) {
    no_sun(true);
    no_sun(false);
}

int main(void) { return unit_main(NULL, NULL); }
