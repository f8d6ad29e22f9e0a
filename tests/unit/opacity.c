/* Triangles that are opaque, or absent, everywhere: decided once, they have to agree with every lookup. */
#include "material/textured.h"
#include "stage.h"
#include "texture/ranges.h"

#include <stdio.h>

UNIT_OWNS(images, texturing, texturing_destroy)
UNIT_OWNS(cache, texture_cache, texture_cache_close)
UNIT_OWNS(ranges, texture_ranges, texture_ranges_free)

/* ---- images ---- */

enum { ACROSS = 200, DOWN = 152 };

/* Discs of 255 in one of 0, with edges that are neither. */
static fathom_id add_discs(stage *s, fathom_wrap wrap, fathom_texture_filter filter) {
    static unsigned char bytes[ACROSS * DOWN * 3 + 32];
    const int header = snprintf((char *)bytes, 32, "P6\n%d %d\n255\n", ACROSS, DOWN);
    for (int i = 0; i < ACROSS * DOWN; ++i) {
        const double x = (i % ACROSS) % 100 - 50, y = (i / ACROSS) % 76 - 38, r = sqrt(x * x + y * y);
        memset(bytes + header + 3 * i, r < 28 ? 255 : r < 32 ? 100 : 0, 3);
    }
    fathom_texture t = default_texture();
    t.bytes = bytes, t.byte_count = (size_t)header + ACROSS * DOWN * 3, t.name = "discs.ppm";
    t.color_space = FATHOM_COLOR_LINEAR, t.wrap_u = t.wrap_v = wrap, t.filter = filter;
    return new_texture(s->scene, &t);
}

static float look(texture_cache *cache, const float at[2]) {
    const texture_queries q = {.count = 1, .u = {at[0]}, .v = {at[1]}};
    float rgba[4][TEXTURE_BLOCK];
    texture_lookup(cache, &q, rgba);
    return rgba[0][0];
}

/* Looks everywhere in a part, and at its corners. */
static void expect_range(texture_cache *cache, const texture_ranges *r, const float low[2],
                         const float high[2], size_t kinds[3]) {
    const texture_range range = texture_range_over(r, low, high);
    for (int k = 0; k < 40; ++k) {
        float at[2];
        for (int c = 0; c < 2; ++c) {
            const double t = k < 4 ? k >> c & 1 : uniform();
            at[c] = fminf(fmaxf((float)((1 - t) * (double)low[c] + t * (double)high[c]), low[c]), high[c]);
        }
        const float found = look(cache, at);
        if (found < range.least * (1 - 0x1p-22f) || found > range.most * (1 + 0x1p-22f))
            fail_msg("at (%.9g, %.9g): %.9g is not in [%.9g, %.9g]", (double)at[0], (double)at[1],
                     (double)found, (double)range.least, (double)range.most);
    }
    ++kinds[range.least >= 1 ? 1 : range.most <= 0 ? 2 : 0];
}

UNIT_TEST(ranges_hold_all_lookups) {
    for (int k = 0; k < 9; ++k) {
        stage s = stage_open();
        size_t kinds[3] = {0};
        texture_cache *cache;
        texture_ranges *r;
        add_discs(&s, (fathom_wrap)(k / 3), (fathom_texture_filter)(k % 3));
        assert_ok(s.context, texture_cache_open(s.context, s.scene, 1 << 20, &cache));
        own_cache(cache);
        assert_ok(s.context, texture_ranges_find(cache, s.context, 0, 0, &r));
        own_ranges(r);
        for (int i = 0; i < 2000; ++i) {
            const double size = pow(10, between(-4, 0.5));
            float low[2], high[2];
            for (int c = 0; c < 2; ++c) {
                low[c] = (float)between(-3, 3);
                high[c] = low[c] + (float)(size * uniform());
            }
            expect_range(cache, r, low, high, kinds);
        }
        /* A clamped image is constant outside of [0,1). */
        for (int i = 0; i < 3; ++i) assert_true(kinds[i] > 50 || (i == 1 && k / 3 == FATHOM_WRAP_CLAMP));
    }
}

UNIT_TEST(a_range_of_no_place_is_that_of_the_image) {
    stage s = stage_open();
    texture_cache *cache;
    texture_ranges *r;
    const float places[][2] = {{NAN, INFINITY}, {-INFINITY, 0}, {1e30f, 2e30f}};
    add_discs(&s, FATHOM_WRAP_REPEAT, FATHOM_TEXTURE_LINEAR);
    assert_ok(s.context, texture_cache_open(s.context, s.scene, 1 << 20, &cache));
    own_cache(cache);
    assert_ok(s.context, texture_ranges_find(cache, s.context, 0, 0, &r));
    own_ranges(r);
    for (size_t i = 0; i < 3; ++i) {
        const texture_range all = texture_range_over(r, (float[]){places[i][0], places[i][0]},
                                                     (float[]){places[i][1], places[i][1]});
        assert_true(all.least == 0 && all.most == 1);
    }
}

/* ---- triangles ---- */

enum { GRID = 48, VERTICES = (GRID + 1) * (GRID + 1), TRIANGLES = 2 * GRID * GRID };

typedef struct kind {
    const char *name;
    float opacity, cutoff;
    bool image, inverted, alpha, pane;
    int others; /* 1: two instances with another material; 2: one with each of two others */
    size_t least[3];
} kind;

static const kind kinds[] = {
    {"an image", .opacity = 1, .image = true, .least = {100, 100, 100}},
    {"an image of a veil", .opacity = 0.75f, .image = true, .least = {100, 0, 100}},
    {"cut-outs", .opacity = 1, .cutoff = 0.5f, .image = true, .least = {100, 100, 100}},
    {"cut-outs of a veil", .opacity = 0.75f, .cutoff = 0.5f, .image = true, .least = {100, 100, 100}},
    {"an inverted image", .opacity = 0, .image = true, .inverted = true, .least = {100, 100, 100}},
    {"an image on a pane", .opacity = 1, .image = true, .pane = true, .least = {100, 0, 100}},
    {"alpha", .opacity = 1, .alpha = true, .least = {50, 100, 100}},
    {"an image and alpha", .opacity = 1, .image = true, .alpha = true, .least = {100, 50, 100}},
    {"an image, and another material", .opacity = 1, .image = true, .others = 1, .least = {100, 100, 0}},
    {"an image, and two other materials", .opacity = 1, .image = true, .others = 2, .least = {0, 0, 0}},
};

static fathom_material material_of(const kind *k, fathom_id image) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.opacity = k->opacity, m.opacity_cutoff = k->cutoff;
    if (k->pane) m.transmission = 0.5f, m.roughness = 0;
    if (k->image) m.maps[FATHOM_MAP_OPACITY].texture = image;
    m.maps[FATHOM_MAP_OPACITY].inverted = k->inverted;
    return m;
}

static void add_mesh(stage *s, fathom_id group, bool alpha, fathom_id material) {
    static float positions[VERTICES][3], uvs[VERTICES][2], colors[VERTICES][4];
    static uint32_t indices[TRIANGLES][3];
    for (uint32_t i = 0; i < VERTICES; ++i) {
        const float x = (float)(i % (GRID + 1)) / GRID, y = (float)(i / (GRID + 1)) / GRID;
        positions[i][0] = x, positions[i][1] = y;
        uvs[i][0] = 1.5f * x - 0.3f, uvs[i][1] = 2 * y - 0.7f;
        for (int c = 0; c < 4; ++c) colors[i][c] = c < 3 ? 0.5f : fminf(fmaxf(2 * x - 0.5f, 0), 1);
    }
    for (uint32_t i = 0; i < GRID * GRID; ++i) {
        const uint32_t a = i / GRID * (GRID + 1) + i % GRID, c = a + GRID + 1;
        memcpy(indices[2 * i], (uint32_t[]){a, a + 1, c}, sizeof *indices);
        memcpy(indices[2 * i + 1], (uint32_t[]){a + 1, c + 1, c}, sizeof *indices);
    }
    fathom_mesh mesh = default_mesh();
    mesh.positions = positions[0], mesh.vertex_count = VERTICES;
    mesh.indices = indices[0], mesh.triangle_count = TRIANGLES;
    mesh.uvs = uvs[0], mesh.uv_count = VERTICES, mesh.material = material;
    if (alpha) mesh.colors = colors[0], mesh.color_channels = 4;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, group, &mesh, NULL));
}

static void place(stage *s, fathom_id group, double x, fathom_id material) {
    fathom_instance instance = default_instance();
    instance.group = group, instance.material = material, instance.transform[3] = x;
    assert_ok(s->context, fathom_scene_add_instance(s->scene, &instance, NULL));
}

static fathom_id plain(stage *s, const char *name, float opacity) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.opacity = opacity;
    return new_material(s->scene, name, &m);
}

static stage stage_of(const kind *k) {
    stage s = stage_open();
    const fathom_id image = add_discs(&s, FATHOM_WRAP_REPEAT, FATHOM_TEXTURE_TRILINEAR);
    const fathom_material m = material_of(k, image);
    const fathom_id group = k->others ? new_group(s.scene, "grid") : FATHOM_ROOT;
    add_mesh(&s, group, k->alpha, new_material(s.scene, "first", &m));
    const fathom_id second = plain(&s, "second", 1), third = plain(&s, "third", 0.5f);
    if (k->others) place(&s, group, 2, second), place(&s, group, 4, k->others > 1 ? third : second);
    return s;
}

/* Points of a triangle, under all materials that it has. */
static void expect_passes(const world *w, const trace_passing *p, uint32_t triangle, trace_passes expected) {
    for (int k = 0; k < 60; ++k) {
        const bool corner = k < 3;
        float u = corner ? k == 1 : (float)uniform(), v = corner ? k == 2 : (float)uniform();
        if (u + v > 1) u = 1 - u, v = 1 - v;
        for (size_t i = 0; i <= w->instances.count; ++i) {
            const uint32_t instance = i ? (uint32_t)i - 1 : FATHOM_NONE;
            const trace_passes found = p->at(p->user, 0, triangle, instance, u, v);
            if (found != expected)
                fail_msg("triangle %u at (%g, %g): %d, expected %d", triangle, (double)u, (double)v, found,
                         expected);
        }
    }
}

static trace_passing passing_of(stage *s) {
    texturing *t;
    trace_passing p;
    assert_ok(s->context, texturing_create(s->context, stage_world(s), 1 << 20, NULL, &t));
    own_images(t);
    assert_ok(s->context, texturing_find_passing(t, s->context, &p));
    return p;
}

static void expect_kind(const kind *k) {
    stage s = stage_of(k);
    const world *w = stage_world(&s);
    size_t count[3] = {0};
    const trace_passing passing = passing_of(&s);
    const uint8_t *of = passing.triangles[0];
    for (uint32_t i = 0; i < TRIANGLES; ++i) {
        const trace_passes known = of ? of[i] : TRACE_PASSES_SOME;
        ++count[known];
        if (known != TRACE_PASSES_SOME) expect_passes(w, &passing, i, known);
    }
    for (int i = 0; i < 3; ++i)
        if (count[i] < k->least[i] || (i && !k->least[i] && count[i]))
            fail_msg("%s: %zu triangles of kind %d", k->name, count[i], i);
}

UNIT_TEST(triangles_agree_with_all_their_points) {
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; ++k) expect_kind(&kinds[k]);
}

/* ---- points ---- */

/* The discs let this pass at a point; TRACE_PASSES_SOME: an edge is near. */
static trace_passes said_at(double u, double v) {
    const double x = fmod(u * ACROSS + 1000, 100) - 50.5, y = fmod(v * DOWN + 760, 76) - 38.5;
    const double r = sqrt(x * x + y * y);
    return r < 26.5 ? TRACE_PASSES_NONE : r > 33.5 ? TRACE_PASSES_ALL : TRACE_PASSES_SOME;
}

static const kind discs = {.opacity = 1, .image = true};

/* The first corners of triangles. */
UNIT_TEST(points_of_meshes_pass_what_their_image_says) {
    stage s = stage_of(&discs);
    const trace_passing p = passing_of(&s);
    size_t count[3] = {0};
    for (uint32_t i = 0; i < TRIANGLES; ++i) {
        const uint32_t a = i / 2 / GRID * (GRID + 1) + i / 2 % GRID + (i & 1);
        const trace_passes said =
            said_at(1.5 * (a % (GRID + 1)) / GRID - 0.3, 2.0 * (a / (GRID + 1)) / GRID - 0.7);
        if (said != TRACE_PASSES_SOME) assert_int_equal(p.at(p.user, 0, i, FATHOM_NONE, 0, 0), said);
        ++count[said];
    }
    assert_true(count[TRACE_PASSES_NONE] > 100 && count[TRACE_PASSES_ALL] > 100);
}

/* A quad's halves, whose corners are 0, 1, 3 and 2, 3, 1. The image stands upright on it. */
UNIT_TEST(points_of_quads_pass_what_their_image_says) {
    stage s = stage_open();
    fathom_quad q;
    const fathom_id image = add_discs(&s, FATHOM_WRAP_REPEAT, FATHOM_TEXTURE_TRILINEAR);
    const fathom_material m = material_of(&discs, image);
    fathom_quad_from_axes((double[]){0, 0, 0}, (double[]){1, 0, 0}, (double[]){0, 1, 0}, &q);
    q.material = new_material(s.scene, "first", &m);
    for (int i = 0; i < 2; ++i) assert_ok(s.context, fathom_scene_add_quad(s.scene, FATHOM_ROOT, &q, NULL));
    const trace_passing p = passing_of(&s);
    size_t count[3] = {0};
    for (uint32_t i = 0; i < 4000; ++i) {
        const uint32_t triangle = i % 4; /* two of each quad */
        double u = uniform(), v = uniform();
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const trace_passes said = triangle & 1 ? said_at(1 - u, v) : said_at(u, 1 - v);
        if (said != TRACE_PASSES_SOME)
            assert_int_equal(p.at(p.user, 0, triangle, FATHOM_NONE, (float)u, (float)v), said);
        ++count[said];
    }
    assert_true(count[TRACE_PASSES_NONE] > 100 && count[TRACE_PASSES_ALL] > 100);
}

int main(void) { return unit_main(NULL, NULL); }
