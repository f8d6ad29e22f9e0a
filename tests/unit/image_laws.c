/* What must not change an image, and what two ways to it must agree on. */
#include "render.h"

#include <pthread.h>

static const double pi = 3.14159265358979324;

/* How a demonstration scene is laid out. */
typedef struct layout {
    double shift[3];
    bool reversed; /* shapes and lights added in the other order */
    bool turned;   /* the whole scene by 90 degrees about y: (x, y, z) -> (z, y, -x) */
    double scale;  /* of all lengths */
} layout;

static void place(const layout *l, double x, double y, double z, double out[3]) {
    out[0] = (l->turned ? z : x) * l->scale + l->shift[0];
    out[1] = y * l->scale + l->shift[1];
    out[2] = (l->turned ? -x : z) * l->scale + l->shift[2];
}

static void turn(const layout *l, double x, double y, double z, double out[3]) {
    layout still = *l;
    still.shift[0] = still.shift[1] = still.shift[2] = 0;
    place(&still, x, y, z, out);
}

enum { MATTE, SHINY, MIRROR, GLASS, MATERIALS };

static void add_materials(stage *s, fathom_id out[MATERIALS]) {
    fathom_material m = default_material();
    out[MATTE] = stage_material(s, &m);
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0.2f * (float)(c + 1), m.k_s[c] = 0.4f;
    m.specular = FATHOM_SPECULAR_BLINN, m.shininess = 60;
    out[SHINY] = stage_material(s, &m);
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0.05f, m.k_r[c] = 0.8f;
    m.specular = FATHOM_SPECULAR_PHONG;
    out[MIRROR] = stage_material(s, &m);
    fathom_material_default(&m);
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0.02f, m.k_r[c] = 1, m.k_t[c] = 1;
    m.fresnel = true;
    out[GLASS] = stage_material(s, &m);
}

static void add_shape(stage *s, const layout *l, const fathom_id material[MATERIALS], int which) {
    double p[3], u[3], v[3];
    const double ball[4][4] = {
        {-1.2, 0.6, 0.3, 0.6}, {0.2, 0.5, 0.9, 0.5}, {1.3, 0.7, -0.2, 0.7}, {0.1, 0.3, -1.5, 0.3}};
    if (which < 4) {
        place(l, ball[which][0], ball[which][1], ball[which][2], p);
        stage_sphere(s, p[0], p[1], p[2], ball[which][3] * l->scale, material[which]);
    } else if (which == 4) {
        place(l, 0, 0, 0, p), turn(l, 4, 0, 0, u), turn(l, 0, 0, -4, v);
        stage_quad(s, p, u, v, material[MATTE]);
    } else if (which == 5) {
        place(l, 0, 1.5, -3.5, p), turn(l, 2, 0, 0.5, u), turn(l, 0, 1.5, 0, v);
        stage_quad(s, p, u, v, material[MIRROR]);
    }
}

static void add_meshes(stage *s, const layout *l, const fathom_id material[MATERIALS]) {
    const fathom_id group = new_group(s->scene, "ball");
    stage_mesh_sphere(s, group, 12, 24, material[SHINY]);
    for (int k = 0; k < 2; ++k) {
        fathom_instance instance = default_instance();
        instance.group = group;
        double axis[3][3], at[3], scale[3] = {0.4, 0.6, k ? -0.3 : 0.3};
        turn(l, scale[0], 0, 0, axis[0]), turn(l, 0, scale[1], 0, axis[1]), turn(l, 0, 0, scale[2], axis[2]);
        place(l, k ? -0.6 : 0.9, 0.6, k ? 1.6 : 1.7, at);
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c) instance.transform[4 * r + c] = axis[c][r];
            instance.transform[4 * r + 3] = at[r];
        }
        assert_ok(s->context, fathom_scene_add_instance(s->scene, &instance, NULL));
    }
}

static void add_light(stage *s, const layout *l, int which) {
    fathom_light light = default_light();
    for (int c = 0; c < 3; ++c) light.intensity[c] = which == 2 ? 0.3f : (float)(12 * l->scale * l->scale);
    light.type = which == 0 ? FATHOM_LIGHT_POINT : which == 1 ? FATHOM_LIGHT_SPOT : FATHOM_LIGHT_DIRECTIONAL;
    place(l, which ? 3 : -3, 4, 2, light.position);
    turn(l, which == 1 ? -3 : 0.2, -4, -2, light.direction);
    assert_ok(s->context, fathom_scene_add_light(s->scene, &light, NULL));
}

static stage demo(const layout *l) {
    stage s = stage_open(128, 96);
    fathom_id material[MATERIALS];
    add_materials(&s, material);
    for (int i = 0; i < 6; ++i) add_shape(&s, l, material, l->reversed ? 5 - i : i);
    add_meshes(&s, l, material);
    for (int i = 0; i < 3; ++i) add_light(&s, l, i);
    double eye[3], target[3];
    place(l, 0.5, 2.2, 6, eye), place(l, 0, 0.7, 0, target);
    stage_camera(&s, eye, target, (double[3]){0, 1, 0}, pi / 5);
    assert_ok(s.context, fathom_scene_set_ambient(s.scene, (float[3]){0.1f, 0.1f, 0.1f}));
    assert_ok(s.context, fathom_scene_set_background(s.scene, (float[3]){0.2f, 0.3f, 0.5f}));
    s.settings.spp = 4;
    return s;
}

static const layout plain = {{0, 0, 0}, false, false, 1};

static size_t differing(const fathom_film *a, const fathom_film *b, double tolerance) {
    uint32_t w, h;
    size_t count = 0;
    fathom_film_size(a, &w, &h);
    const char *names[3] = {"R", "G", "B"};
    for (size_t i = 0; i < (size_t)w * h; ++i) {
        double worst = 0;
        for (int c = 0; c < 3; ++c) {
            double d = fabs((double)fathom_film_channel(a, names[c])[i] -
                            (double)fathom_film_channel(b, names[c])[i]);
            worst = d >= worst ? d : (d < worst ? worst : (double)INFINITY);
        }
        count += worst > tolerance;
    }
    return count;
}

/* Threads, tiles and block widths are no part of the image: not a bit of it. */
UNIT_TEST(same_bits_however_rendered) {
    stage s = demo(&plain);
    s.settings.pattern = FATHOM_PATTERN_SOBOL;
    fathom_film *first = stage_render(&s);
    const struct {
        unsigned threads, tile, width;
    } ways[] = {{1, 32, 16}, {2, 32, 16}, {7, 64, 16}, {2, 96, 8}, {3, 32, 4}, {1, 128, 1}};
    for (size_t i = 0; i < sizeof ways / sizeof *ways; ++i) {
        fathom_context_set_threads(s.context, ways[i].threads);
        s.settings.tile_size = ways[i].tile;
        s.settings.block_width = ways[i].width;
        fathom_film *other = stage_render(&s);
        assert_int_equal(differing(first, other, 0), 0);
    }
}

/* A crop is a part of the whole image, bit by bit. */
UNIT_TEST(crop_is_a_part) {
    stage s = demo(&plain);
    fathom_film *whole = stage_render(&s);
    const uint32_t crop[4] = {37, 11, 101, 70};
    memcpy(s.settings.crop, crop, sizeof crop);
    fathom_film *part = stage_render(&s);
    for (uint32_t y = crop[1]; y < crop[3]; ++y) {
        for (uint32_t x = crop[0]; x < crop[2]; ++x) {
            assert_near(fathom_film_channel(part, "G")[(y - crop[1]) * 64 + x - crop[0]],
                        fathom_film_channel(whole, "G")[y * 128 + x], 0);
        }
    }
}

/* The order in which shapes are added changes no pixel. */
UNIT_TEST(order_of_shapes) {
    const layout reversed = {{0, 0, 0}, true, false, 1};
    stage a = demo(&plain), b = demo(&reversed);
    fathom_film *fa = stage_render(&a), *fb = stage_render(&b);
    assert_int_equal(differing(fa, fb, 0), 0);
}

/* The whole scene moved rigidly. Coordinates round differently, so that edges, where a sample falls on one
 * side or the other, may move by a rounding: each of the 4 samples a pixel has is within 2^-20 of an edge
 * about once in 2^10 edge pixels, and of a 128 x 96 image fewer than 2^12 pixels hold edges, shadows and
 * mirror images of edges included: at most 16 pixels may differ. Elsewhere roundings of 2^-24 are stretched
 * by highlights (exponent 60) and bent rays: 1e-3. */
UNIT_TEST(rigid_motion) {
    const layout moves[] = {{{0, 0, 0}, false, true, 1},
                            {{3, -5, 7.5}, false, false, 1},
                            {{6378137, 1000, -2000}, false, true, 1},
                            {{-6378137, 6378137, 6378137}, false, false, 1}};
    stage still = demo(&plain);
    fathom_film *expected = stage_render(&still);
    for (size_t i = 0; i < sizeof moves / sizeof *moves; ++i) {
        stage moved = demo(&moves[i]);
        fathom_film *film = stage_render(&moved);
        size_t count = differing(expected, film, 1e-3);
        if (count > 16) fail_msg("move %zu: %zu pixels differ", i, count);
    }
}

/* A scene of another size, its lights' strength grown with the square: powers of two scale every float
 * exactly, so not a bit of the image may change, from a millionth to a hundred million. At a
 * hundred-millionth the sphere's intersector goes on in double, as what it computes falls below 2^-30: the
 * points it finds are others by a rounding, as in a rigid motion. */
UNIT_TEST(any_scale) {
    const struct {
        double scale, tolerance;
        size_t pixels;
    } cases[] = {{0x1p-26, 1e-3, 16}, {0x1p-20, 0, 0}, {0x1p-13, 0, 0}, {0x1p13, 0, 0}, {0x1p26, 0, 0}};
    stage s = demo(&plain);
    fathom_film *expected = stage_render(&s);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        layout sized = plain;
        sized.scale = cases[i].scale;
        stage other = demo(&sized);
        fathom_film *film = stage_render(&other);
        size_t count = differing(expected, film, cases[i].tolerance);
        if (count > cases[i].pixels) fail_msg("scale %g: %zu pixels differ", sized.scale, count);
    }
}

/* Embree and linear search: the renderer computes position and normal from the primitive alone, so that
 * images differ only where a ray meets a mesh's edge and the two choose different sides, or a silhouette
 * within a rounding: at most one pixel in a thousand. */
UNIT_TEST(tracers_agree) {
    stage s = demo(&plain);
    if (SANITIZED) memcpy(s.settings.crop, (uint32_t[4]){32, 24, 96, 72}, sizeof s.settings.crop);
    fathom_film *embree = stage_render(&s);
    s.settings.tracer = "reference";
    fathom_film *reference = stage_render(&s);
    size_t count = differing(embree, reference, 0);
    uint32_t w, h;
    fathom_film_size(embree, &w, &h);
    if (count > w * h / 1000) fail_msg("%zu pixels differ", count);
}

/* A coarse smooth sphere lit from the side. Where its shading normal clearly faces the light it must not be
 * black. */
static size_t black_where_lit(bool fix, fathom_integrator integrator) {
    stage s = stage_open(160, 160);
    fathom_material m = default_material();
    stage_mesh_sphere(&s, FATHOM_ROOT, 10, 20, stage_material(&s, &m));
    stage_camera(&s, (double[3]){0, 0.5, 4}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 0.55);
    fathom_light light = default_light();
    light.type = FATHOM_LIGHT_DIRECTIONAL;
    /* Half a facet off the axis: otherwise the terminator runs along edges, and no facet straddles it. */
    const double half = 3.14159265358979 / 20, l[3] = {cos(half), 0, -sin(half)};
    for (int c = 0; c < 3; ++c) light.direction[c] = -l[c];
    assert_ok(s.context, fathom_scene_add_light(s.scene, &light, NULL));
    s.settings.aovs = FATHOM_AOV_N;
    s.settings.terminator_fix = fix, s.settings.integrator = integrator;
    fathom_film *film = stage_render(&s);
    size_t black = 0;
    for (int i = 0; i < 160 * 160; ++i) {
        double facing = (double)fathom_film_channel(film, "N.X")[i] * l[0] +
                        (double)fathom_film_channel(film, "N.Z")[i] * l[2];
        black += facing > 0.03 && fathom_film_channel(film, "R")[i] == 0;
    }
    return black;
}

UNIT_TEST(shadow_terminator) {
    for (int k = 0; k < 2; ++k) {
        const fathom_integrator integrator = k ? FATHOM_INTEGRATOR_PATH : FATHOM_INTEGRATOR_CLASSIC;
        assert_int_equal(black_where_lit(true, integrator), 0);
        assert_true(black_where_lit(false, integrator) > 100); /* the test sees the defect without the fix */
    }
}

/* The cube [-1,1]x[0,2]x[-1,1] whose corners have the normals of a ball. */
static void add_round_cube(stage *s, fathom_id group, fathom_id material) {
    static const uint32_t face[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                        {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    float p[8][3], n[8][3];
    uint32_t index[36];
    for (uint32_t k = 0; k < 8; ++k) {
        for (uint32_t c = 0; c < 3; ++c) p[k][c] = n[k][c] = k >> c & 1 ? 1 : -1;
        p[k][1] += 1;
    }
    for (uint32_t k = 0; k < 36; ++k) {
        static const uint32_t corner[6] = {0, 1, 2, 0, 2, 3};
        index[k] = face[k / 6][corner[k % 6]];
    }
    fathom_mesh mesh = default_mesh();
    mesh.positions = p[0], mesh.normals = n[0], mesh.vertex_count = mesh.normal_count = 8;
    mesh.indices = index, mesh.triangle_count = 12, mesh.material = material;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, group, &mesh, NULL));
}

/* A round cube, or a ball, on a floor that covers points lifted off near its foot; placed: turned about the
 * vertical, stretched and mirrored, as an instance. */
static stage on_floor(bool ball, bool placed, fathom_light_type type) {
    stage s = stage_open(120, 90);
    const fathom_id material = stage_lambert(&s, 0.8f);
    fathom_id group = FATHOM_ROOT;
    if (placed) {
        fathom_instance instance = default_instance();
        assert_ok(s.context, fathom_scene_add_group(s.scene, NULL, &group));
        const double place[12] = {-0.7, 0, 0.3, 0, 0, 1.3, 0, 0, 0.3, 0, 0.7, 0};
        memcpy(instance.transform, place, sizeof place);
        instance.group = group;
        assert_ok(s.context, fathom_scene_add_instance(s.scene, &instance, NULL));
    }
    if (ball)
        stage_mesh_sphere(&s, group, 7, 10, material);
    else
        add_round_cube(&s, group, material);
    stage_plane(&s, (double[3]){0, ball ? -0.7 : 0, 0}, (double[3]){0, 1, 0}, material);
    fathom_light light = default_light();
    light.type = type, light.direction[0] = -1, light.direction[1] = -0.35, light.direction[2] = -0.2;
    for (int c = 0; c < 3; ++c) light.position[c] = -40 * light.direction[c], light.intensity[c] = 1600;
    assert_ok(s.context, fathom_scene_add_light(s.scene, &light, NULL));
    stage_camera(&s, (double[3]){0.3, 2.2, 5}, (double[3]){0, 0.8, 0}, (double[3]){0, 1, 0}, 0.8);
    return s;
}

/* Pixels that see the light with the fix alone, and those that lose some of it. */
static void count_lifted(stage *s, size_t *more, size_t *less) {
    s->settings.terminator_fix = false;
    fathom_film *flat = stage_render(s);
    s->settings.terminator_fix = true;
    fathom_film *lifted = stage_render(s);
    for (size_t i = 0; i < 120 * 90; ++i) {
        const float a = fathom_film_channel(flat, "R")[i], b = fathom_film_channel(lifted, "R")[i];
        *less += b < a;
        *more += a == 0 && b > 0;
    }
}

UNIT_TEST(the_terminator_fix_only_adds_light) {
    for (int k = 0; k < 8; ++k) {
        stage s = on_floor(k & 1, k & 2, k & 4 ? FATHOM_LIGHT_POINT : FATHOM_LIGHT_DIRECTIONAL);
        for (int tracer = 0; tracer < 2; ++tracer) {
            size_t more = 0, less = 0;
            s.settings.tracer = tracer ? "reference" : "embree";
            count_lifted(&s, &more, &less);
            assert_int_equal(less, 0);
            if (k & 1) assert_true(more > 20); /* or the fix did nothing */
        }
    }
}

typedef struct stopper {
    int calls, stop_at;
    pthread_t caller;
} stopper;

static bool stop_after(void *user, const fathom_progress *progress) {
    stopper *s = user;
    assert_true(progress->fraction >= 0 && progress->fraction <= 1);
    assert_true(pthread_equal(s->caller, pthread_self()));
    return ++s->calls < s->stop_at;
}

/* A stopped render hands over the film as far as it got. */
UNIT_TEST(stopping) {
    stage s = demo(&plain);
    s.settings.width = 640, s.settings.height = 480, s.settings.spp = 1024;
    stopper stop = {0, 3, pthread_self()};
    fathom_film *film = NULL;
    fathom_stats stats = {.size = sizeof stats};
    assert_int_equal(fathom_render(s.context, s.scene, &s.settings, stop_after, &stop, &stats, &film),
                     FATHOM_INTERRUPTED);
    assert_non_null(film);
    assert_true(stats.camera_rays < 640ull * 480 * 1024);
    fathom_film_destroy(film);
}

/* With coverage asked for, the background behind is left out, and what is left is premultiplied: laid over
 * the background it is the plain image, to a rounding of each of the 4 samples. */
UNIT_TEST(coverage) {
    stage s = demo(&plain);
    fathom_film *whole = stage_render(&s);
    s.settings.aovs = FATHOM_AOV_ALPHA;
    fathom_film *cut = stage_render(&s);
    const float *a = fathom_film_channel(cut, "A"), *b = fathom_film_channel(cut, "B");
    size_t partly = 0;
    for (size_t i = 0; i < 128 * 96; ++i) {
        partly += a[i] > 0 && a[i] < 1;
        assert_near((double)b[i] + (1 - (double)a[i]) * 0.5, fathom_film_channel(whole, "B")[i], 8 * 0x1p-24);
    }
    assert_true(partly > 20);
}

/* Settings out of range are refused before anything is allocated. */
UNIT_TEST(bad_settings) {
    stage s = demo(&plain);
    fathom_film *film;
    const fathom_settings good = s.settings;
    s.settings.width = 0;
    assert_fails(s.context, fathom_render(s.context, s.scene, &s.settings, NULL, NULL, NULL, &film),
                 FATHOM_BAD_INPUT, "width");
    s.settings = good, s.settings.height = 1000000000;
    assert_fails(s.context, fathom_render(s.context, s.scene, &s.settings, NULL, NULL, NULL, &film),
                 FATHOM_BAD_INPUT, "65536");
    s.settings = good, s.settings.spp = 5;
    assert_fails(s.context, fathom_render(s.context, s.scene, &s.settings, NULL, NULL, NULL, &film),
                 FATHOM_BAD_INPUT, "square");
    s.settings = good, s.settings.crop[2] = 200, s.settings.crop[3] = 10;
    assert_fails(s.context, fathom_render(s.context, s.scene, &s.settings, NULL, NULL, NULL, &film),
                 FATHOM_BAD_INPUT, "crop");
}

int main(void) { return unit_main(NULL, NULL); }
