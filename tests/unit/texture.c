/* Textures: what lookups give, for files of every kind, under any limit and on any threads. */
#include "defaults.h"
#include "textures.h"
#include "variants.h"

#include <pthread.h>

VARIANTS(texture_kernels)

/* ---- files that a test writes itself ---- */

/* ---- formats ---- */

/* 4 × 2 texels of these bytes in every format. */
static const unsigned char colors[2][4][3] = {{{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 255, 255}},
                                              {{128, 128, 128}, {64, 32, 16}, {10, 20, 30}, {200, 100, 50}}};

static void put_bmp(const char *name) {
    unsigned char header[54] = {'B', 'M', 78, [10] = 54, [14] = 40, [18] = 4, [22] = 2, [26] = 1, [28] = 24};
    unsigned char body[24];
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 4; ++x)
            for (int c = 0; c < 3; ++c) body[(y * 4 + x) * 3 + c] = colors[1 - y][x][2 - c];
    put_file(name, header, sizeof header, body, sizeof body);
}

static void put_tga(const char *name) {
    const unsigned char header[18] = {[2] = 2, [12] = 4, [14] = 2, [16] = 24, [17] = 0x20};
    unsigned char body[24];
    for (int i = 0; i < 8; ++i)
        for (int c = 0; c < 3; ++c) body[i * 3 + c] = colors[i / 4][i % 4][2 - c];
    put_file(name, header, sizeof header, body, sizeof body);
}

static void put_pfm(const char *name) {
    static const char header[] = "PF\n4 2\n-1.0\n";
    float body[24];
    for (int i = 0; i < 8; ++i)
        for (int c = 0; c < 3; ++c) body[i * 3 + c] = (float)srgb(colors[1 - i / 4][i % 4][c] / 255.0);
    put_file(name, header, sizeof header - 1, body, sizeof body);
}

/* Radiance: a common exponent of three bytes, without compression. */
static void put_hdr(const char *name) {
    static const char header[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n";
    unsigned char body[32];
    for (int i = 0; i < 8; ++i) {
        double rgb[3], most = 1e-9;
        int exponent;
        for (int c = 0; c < 3; ++c) rgb[c] = srgb(colors[i / 4][i % 4][c] / 255.0);
        for (int c = 0; c < 3; ++c) most = fmax(most, rgb[c]);
        frexp(most, &exponent);
        for (int c = 0; c < 3; ++c) body[i * 4 + c] = (unsigned char)(ldexp(rgb[c], 8 - exponent));
        body[i * 4 + 3] = (unsigned char)(exponent + 128);
    }
    put_file(name, header, sizeof header - 1, body, sizeof body);
}

static void put_format(const char *name) {
    float planes[24];
    for (int i = 0; i < 8; ++i)
        for (int c = 0; c < 3; ++c) planes[c * 8 + i] = (float)srgb(colors[i / 4][i % 4][c] / 255.0);
    const char *extension = strrchr(name, '.');
    if (strcmp(extension, ".ppm") == 0)
        put_ppm(name, 4, 2, &colors[0][0][0]);
    else if (strcmp(extension, ".bmp") == 0)
        put_bmp(name);
    else if (strcmp(extension, ".tga") == 0)
        put_tga(name);
    else if (strcmp(extension, ".pfm") == 0)
        put_pfm(name);
    else if (strcmp(extension, ".hdr") == 0)
        put_hdr(name);
    else
        put_image(name, 4, 2, planes, 3, true);
}

typedef struct format {
    const char *name, *format;
    fathom_color_space space;
    double tolerance;
} format;

/* Bytes are exact as floats but for the rounding of the table, 2^-24. A half of values up to 1 is off by at
 * most 2^-12, and RGBE, cut off, by 2^-7 of the largest channel, which is at most 1. JPEG loses what it
 * likes: only its size and channels count here. */
static const format formats[] = {
    {"a.ppm", "pnm", FATHOM_COLOR_SRGB, 0x1p-24},     {"a.bmp", "bmp", FATHOM_COLOR_SRGB, 0x1p-24},
    {"a.tga", "targa", FATHOM_COLOR_AUTO, 0x1p-24},   {"a.png", "png", FATHOM_COLOR_SRGB, 0x1p-24},
    {"a.tif", "tiff", FATHOM_COLOR_AUTO, 0x1p-24},    {"a.jpg", "jpeg", FATHOM_COLOR_SRGB, 1},
    {"a.pfm", "pnm", FATHOM_COLOR_AUTO, 0x1p-24},     {"a.hdr", "hdr", FATHOM_COLOR_LINEAR, 0x1p-7},
    {"a.exr", "openexr", FATHOM_COLOR_AUTO, 0x1p-12},
};
#define FORMATS (sizeof formats / sizeof *formats)

static void check_colors(texture_cache *cache, fathom_id id, double tolerance) {
    uint32_t width, height;
    texture_size(cache, id, &width, &height);
    assert_true(width == 4 && height == 2);
    for (unsigned i = 0; i < 8; ++i) {
        float rgba[4];
        texel(cache, id, 0, i % 4, i / 4, rgba);
        for (int c = 0; c < 3; ++c) assert_near(rgba[c], srgb(colors[i / 4][i % 4][c] / 255.0), tolerance);
        assert_true(rgba[3] == 1);
    }
    assert_ok(context, texture_cache_check(cache, context));
}

UNIT_TEST(every_format_gives_the_texels_of_its_file) {
    for (size_t i = 0; i < FORMATS; ++i) {
        put_format(formats[i].name);
        const fathom_texture t = texture_of(formats[i].name, formats[i].space);
        opened o = open_textures(&t, 1, ALL);
        assert_string_equal(o.cache->images[0].info.format, formats[i].format);
        check_colors(o.cache, 0, formats[i].tolerance);
    }
}

UNIT_TEST(content_decides_the_format_of_files_and_of_bytes) {
    put_format("a.tif");
    assert_int_equal(rename(in_folder("a.tif"), in_folder("a.png")), 0);
    FILE *file = fopen(in_folder("a.png"), "rb");
    const size_t size = fread(file_bytes, 1, sizeof file_bytes, file);
    fclose(file);
    fathom_texture t[2] = {texture_of("a.png", FATHOM_COLOR_SRGB), texture_of("", FATHOM_COLOR_SRGB)};
    forget_warnings();
    t[1].file = NULL, t[1].bytes = file_bytes, t[1].byte_count = size, t[1].mime = "image/jpeg",
    t[1].name = "wood";
    opened o = open_textures(t, 2, ALL);
    memset(file_bytes, 0, size); /* they were copied */
    check_colors(o.cache, 0, 0x1p-24);
    check_colors(o.cache, 1, 0x1p-24);
    assert_string_equal(warned, "wood: is declared as image/jpeg, and read as tiff, which it is\n");
}

/* ---- numbers ---- */

UNIT_TEST(bytes_follow_the_srgb_curve_or_stay_linear) {
    unsigned char ramp[256][3];
    for (int i = 0; i < 256; ++i) memset(ramp[i], i, 3);
    put_ppm("ramp.ppm", 256, 1, ramp[0]);
    const fathom_texture t[2] = {texture_of("ramp.ppm", FATHOM_COLOR_SRGB),
                                 texture_of("ramp.ppm", FATHOM_COLOR_LINEAR)};
    opened o = open_textures(t, 2, ALL);
    for (unsigned i = 0; i < 256; ++i) {
        float rgba[4];
        texel(o.cache, 0, 0, i, 0, rgba);
        assert_true(rgba[1] == (float)srgb(i / 255.0));
        texel(o.cache, 1, 0, i, 0, rgba);
        assert_true(rgba[2] == (float)(i / 255.0));
    }
}

UNIT_TEST(sixteen_bits_halves_and_floats_keep_every_digit) {
    uint16_t grey[1024];
    float planes[3 * 1024];
    for (unsigned i = 0; i < 1024; ++i) grey[i] = (uint16_t)(i * 64 + 3);
    for (unsigned i = 0; i < 3 * 1024; ++i)
        planes[i] = (float)(i + 1) * 0x1p-24f * (float)(1 + i % 7) + (float)(i % 5);
    put_tiff("g.tif", 1024, 1, 16, grey);
    put_image("f.exr", 1024, 1, planes, 3, false);
    for (unsigned i = 0; i < 3 * 1024; ++i) planes[i] = ldexpf((float)(1024 + i % 1024), -24 + (int)(i % 29));
    put_image("h.exr", 1024, 1, planes, 3, true);
    const fathom_texture t[4] = {
        texture_of("g.tif", FATHOM_COLOR_LINEAR), texture_of("g.tif", FATHOM_COLOR_SRGB),
        texture_of("f.exr", FATHOM_COLOR_LINEAR), texture_of("h.exr", FATHOM_COLOR_LINEAR)};
    opened o = open_textures(t, 4, ALL);
    assert_int_equal(o.cache->images[3].plan.levels[0].type, IMAGE_TEXEL_HALF);
    for (unsigned i = 0; i < 1024; ++i) {
        float rgba[4];
        texel(o.cache, 0, 0, i, 0, rgba);
        assert_true(rgba[0] == (float)(grey[i] / 65535.0) && rgba[2] == rgba[0] && rgba[3] == 1);
        texel(o.cache, 1, 0, i, 0, rgba);
        assert_true(rgba[0] == (float)srgb(grey[i] / 65535.0));
        texel(o.cache, 2, 0, i, 0, rgba);
        const unsigned k = 2048 + i;
        assert_true(rgba[2] == (float)(k + 1) * 0x1p-24f * (float)(1 + k % 7) + (float)(k % 5));
        texel(o.cache, 3, 0, i, 0, rgba);
        assert_true(rgba[1] == planes[1024 + i]);
    }
}

UNIT_TEST(alpha_is_linear_and_opaque_images_are_told) {
    float planes[4][4] = {{1, 1, 1, 1}, {0, 0, 0, 0}, {1, 0, 1, 0}, {1, 1, 1, 1}};
    put_image("opaque.png", 2, 2, planes[0], 4, true);
    planes[3][2] = 128 / 255.0f;
    put_image("leaf.png", 2, 2, planes[0], 4, true);
    const fathom_texture t[2] = {texture_of("opaque.png", FATHOM_COLOR_SRGB),
                                 texture_of("leaf.png", FATHOM_COLOR_SRGB)};
    opened o = open_textures(t, 2, ALL);
    bool opaque;
    assert_ok(context, texture_is_opaque(o.cache, context, 0, &opaque));
    assert_true(opaque);
    assert_ok(context, texture_is_opaque(o.cache, context, 1, &opaque));
    assert_false(opaque);
    float rgba[4];
    texel(o.cache, 1, 0, 0, 1, rgba);
    assert_true(rgba[3] == (float)(128 / 255.0) && rgba[0] == 1 && rgba[1] == 0);
    texel(o.cache, 1, 1, 0, 0, rgba);
    assert_near(rgba[3], (3 + 128 / 255.0) / 4, 0x1p-12 + 0x1p-23); /* a half of at most 1, two roundings */
    assert_true(rgba[0] == 1 && rgba[2] == 0.5f);
}

UNIT_TEST(named_color_spaces_become_linear_rec709) {
    /* ACEScg's white is D60: its (1, 1, 1) is white in Rec.709 too, after Bradford's adaptation. */
    const float planes[3] = {0.5f, 0.5f, 0.5f};
    put_image("white.exr", 1, 1, planes, 3, false);
    fathom_texture t = texture_of("white.exr", FATHOM_COLOR_NAMED);
    t.color_space_name = "acescg";
    opened o = open_textures(&t, 1, ALL);
    float rgba[4];
    texel(o.cache, 0, 0, 0, 0, rgba);
    /* The matrices of OpenColorIO are floats made of products of three. */
    for (int c = 0; c < 3; ++c) assert_near(rgba[c], 0.5, 1e-5);
}

/* ---- filters ---- */

enum { W = 8, H = 4 };

static void put_noise(const char *name, unsigned width, unsigned height, unsigned seed) {
    static unsigned char rgb[300 * 300 * 3];
    assert_true(width * height <= 300 * 300);
    for (size_t i = 0; i < (size_t)width * height * 3; ++i) {
        seed = seed * 1664525u + 1013904223u;
        rgb[i] = (unsigned char)(seed >> 24);
    }
    put_ppm(name, width, height, rgb);
}

/* The place that a wrap mode takes u to, in exact arithmetic. */
static unsigned expected_texel(double u, unsigned size, fathom_wrap mode) {
    double at = floor(u * size);
    if (mode == FATHOM_WRAP_CLAMP) return (unsigned)fmin(fmax(at, 0), size - 1);
    at = fmod(fmod(at, 2.0 * size) + 2.0 * size, 2.0 * size);
    if (at < size) return (unsigned)at;
    return mode == FATHOM_WRAP_REPEAT ? (unsigned)at - size : 2 * size - 1 - (unsigned)at;
}

UNIT_TEST(wrap_modes_repeat_mirror_and_clamp) {
    put_noise("n.ppm", W, H, 1);
    fathom_texture t[9];
    for (unsigned i = 0; i < 9; ++i) {
        t[i] = texture_of("n.ppm", FATHOM_COLOR_SRGB);
        t[i].filter = FATHOM_TEXTURE_NEAREST, t[i].wrap_u = i % 3, t[i].wrap_v = i / 3;
    }
    opened o = open_textures(t, 9, ALL);
    assert_int_equal(o.cache->image_count, 1);
    for (unsigned i = 0; i < 9; ++i) {
        for (unsigned k = 0; k < 4000; ++k) {
            /* Multiples of 1/64 and half of that again: never on the edge of a texel, and exact. */
            const float u = (float)(k % 397) / 64 - 3 + 1 / 128.0f,
                        v = (float)(k % 389) / 64 - 3 + 1 / 128.0f;
            float found[4], expected[4];
            look(o.cache, i, u, v, 0, found);
            const unsigned x = expected_texel((double)u, W, t[i].wrap_u),
                           y = expected_texel((double)v, H, t[i].wrap_v);
            look(o.cache, i, ((float)x + 0.5f) / W, ((float)y + 0.5f) / H, 0, expected);
            assert_memory_equal(found, expected, sizeof found);
        }
    }
}

/* Across an edge too: the neighbour is the one that the wrap mode says. */
UNIT_TEST(linear_filters_lie_between_the_four_texels_around) {
    put_noise("n.ppm", W, H, 2);
    fathom_texture t[3];
    for (unsigned i = 0; i < 3; ++i) {
        t[i] = texture_of("n.ppm", FATHOM_COLOR_LINEAR);
        t[i].filter = FATHOM_TEXTURE_LINEAR, t[i].wrap_u = t[i].wrap_v = i;
    }
    opened o = open_textures(t, 3, ALL);
    for (unsigned i = 0; i < 3; ++i) {
        for (unsigned k = 0; k < 1000; ++k) {
            const double u = (k % 97) / 32.0 - 1 + 1 / 256.0, v = (k % 89) / 32.0 - 1 + 1 / 256.0;
            const double x = u * W - 0.5, y = v * H - 0.5, a = x - floor(x), b = y - floor(y);
            float corners[4][4], found[4];
            for (unsigned j = 0; j < 4; ++j)
                texel(o.cache, i, 0, expected_texel((floor(x) + j % 2 + 0.5) / W, W, i),
                      expected_texel((floor(y) + j / 2 + 0.5) / H, H, i), corners[j]);
            look(o.cache, i, (float)u, (float)v, 9, found);
            for (int c = 0; c < 3; ++c) {
                const double expected =
                    (1 - b) * ((1 - a) * (double)corners[0][c] + a * (double)corners[1][c]) +
                    b * ((1 - a) * (double)corners[2][c] + a * (double)corners[3][c]);
                assert_near(found[c], expected, 8 * 0x1p-24); /* nine roundings of numbers below 1 */
            }
        }
    }
}

static void check_means(opened *o, double tolerance) {
    const pyramid *p = &o->cache->images[0].plan;
    double mean[4];
    for (unsigned level = 0; level < p->count; ++level) {
        const pyramid_level *l = &p->levels[level];
        double sum[4] = {0};
        for (unsigned i = 0; i < l->width * l->height; ++i) {
            float rgba[4];
            texel(o->cache, 0, level, i % l->width, i / l->width, rgba);
            for (int c = 0; c < 4; ++c) sum[c] += (double)rgba[c];
        }
        for (int c = 0; c < 4; ++c) {
            if (!level) mean[c] = sum[c] / (l->width * l->height);
            assert_near(sum[c] / (l->width * l->height), mean[c], tolerance);
        }
    }
    assert_true(p->levels[p->count - 1].width == 1 && p->levels[p->count - 1].height == 1);
}

/* Sizes that halve without rest and others, below, at and above a tile. */
UNIT_TEST(the_mean_of_each_level_is_the_mean_of_the_image) {
    static const unsigned sizes[][2] = {{1, 1},   {2, 3},   {7, 5},    {64, 64},   {65, 63},
                                        {129, 1}, {1, 200}, {128, 64}, {300, 200}, {255, 257}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        put_noise("n.ppm", sizes[i][0], sizes[i][1], (unsigned)i);
        const fathom_texture t = texture_of("n.ppm", FATHOM_COLOR_SRGB);
        opened o = open_textures(&t, 1, ALL);
        /* Texels of smaller levels are halves of at most 1, each off by up to 2^-12; a lookup at the centre
         * of a texel moves by at most 2^-16 of a texel, as u and v are floats, and so may the value. */
        check_means(&o, 0x1p-12 + 0x1p-14);
    }
}

UNIT_TEST(trilinear_filters_lie_between_two_levels) {
    put_noise("n.ppm", 64, 64, 3);
    const fathom_texture t = texture_of("n.ppm", FATHOM_COLOR_SRGB);
    opened o = open_textures(&t, 1, ALL);
    for (unsigned k = 0; k < 500; ++k) {
        const float u = (float)(k % 71) / 71, v = (float)(k % 67) / 67, share = (float)(k % 8) / 8;
        const unsigned level = k % 6;
        const float width = (float)(1u << level) / 64;
        float fine[4], coarse[4], found[4];
        look(o.cache, 0, u, v, width, fine);
        look(o.cache, 0, u, v, 2 * width, coarse);
        look(o.cache, 0, u, v, width * (1 + share), found);
        for (int c = 0; c < 4; ++c)
            assert_near(found[c], fine[c] + share * (coarse[c] - fine[c]), 4 * 0x1p-24);
    }
}

/* Images of 4096 texels; places and widths are exact. */
UNIT_TEST(a_footprint_reads_the_level_whose_texels_have_its_area) {
    static const unsigned sizes[][2] = {{64, 64}, {256, 16}, {16, 256}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        put_noise("n.ppm", sizes[i][0], sizes[i][1], 5);
        const fathom_texture t = texture_of("n.ppm", FATHOM_COLOR_SRGB);
        opened o = open_textures(&t, 1, ALL);
        for (unsigned level = 0; level <= 4; ++level) {
            const pyramid_level *l = &o.cache->images[0].plan.levels[level];
            for (unsigned k = 0; k < l->width * l->height; ++k) {
                const unsigned x = k % l->width, y = k / l->width;
                float expected[4], found[4];
                assert_true(o.cache->kernels->texel(o.cache, &o.cache->slots[0], level, x, y, expected));
                look(o.cache, 0, ((float)x + 0.5f) / (float)l->width, ((float)y + 0.5f) / (float)l->height,
                     (float)(1u << level) / 64, found);
                for (int c = 0; c < 4; ++c) assert_near(found[c], expected[c], 0);
            }
        }
    }
}

/* Means over places so near to each other that hashes alone choose among their texels. Both filters average
 * the same places, so their means differ by what N choices among values in [0,1] leave: a standard deviation
 * of at most 1 / (2 sqrt(N)). One in 10^5 runs exceeds 5.6 of these in any of the 400 comparisons. */
UNIT_TEST(filters_by_chance_keep_the_expectation) {
    enum { N = SANITIZED ? 256 : 4096 };
    put_noise("n.ppm", 65, 33, 4);
    fathom_texture t[2] = {texture_of("n.ppm", FATHOM_COLOR_SRGB), texture_of("n.ppm", FATHOM_COLOR_SRGB)};
    t[1].filter = FATHOM_TEXTURE_STOCHASTIC;
    opened o = open_textures(t, 2, ALL);
    for (unsigned k = 0; k < 100; ++k) {
        double mean[2][4] = {{0}};
        for (unsigned i = 0; i < N; ++i) {
            const float u = (float)k / 41 + (float)i * 0x1p-22f, v = (float)k / 37, width = (float)k / 400;
            const texture_queries q = {
                .count = 2, .texture = {0, 1}, .u = {u, u}, .v = {v, v}, .width = {width, width}};
            float found[4][TEXTURE_BLOCK];
            texture_lookup(o.cache, &q, found);
            for (int c = 0; c < 4; ++c)
                for (int f = 0; f < 2; ++f) mean[f][c] += (double)found[c][f] / N;
        }
        for (int c = 0; c < 4; ++c) assert_near(mean[1][c], mean[0][c], 5.6 / (2 * sqrt(N)));
    }
}

UNIT_TEST(bump_maps_are_not_read_by_chance) {
    fathom_texture t = texture_of("n.ppm", FATHOM_COLOR_LINEAR);
    fathom_scene *scene = new_scene(context);
    fathom_material m = default_material();
    put_noise("n.ppm", 2, 2, 4);
    t.filter = FATHOM_TEXTURE_STOCHASTIC;
    assert_ok(context, fathom_scene_add_texture(scene, &t, &m.maps[FATHOM_MAP_BUMP].texture));
    assert_fails(context, fathom_scene_add_material(scene, "m", &m, NULL), FATHOM_BAD_INPUT,
                 "found stochastic");
}

/* Lane i alone gets what it got among others. */
static void check_alone(texture_cache *cache, const texture_queries *q, unsigned i,
                        float among[4][TEXTURE_BLOCK]) {
    texture_queries one = {.count = 1};
    one.texture[0] = q->texture[i];
    one.u[0] = q->u[i], one.v[0] = q->v[i], one.width[0] = q->width[i];
    for (unsigned set = 0; texture_kernels_at(set); ++set) {
        float found[4][TEXTURE_BLOCK];
        texture_kernels_at(set)->look_up(cache, &one, found);
        for (int c = 0; c < 4; ++c) assert_memory_equal(&found[c][0], &among[c][i], sizeof(float));
    }
}

/* Bytes and the halves of smaller levels, by each filter, in blocks and alone. */
UNIT_TEST(blocks_and_instruction_sets_look_up_the_same_bits) {
    fathom_texture t[4];
    put_noise("n.ppm", 200, 131, 6);
    for (unsigned i = 0; i < 4; ++i) {
        t[i] = texture_of("n.ppm", i % 2 ? FATHOM_COLOR_SRGB : FATHOM_COLOR_LINEAR);
        t[i].wrap_u = t[i].wrap_v = i % 3, t[i].filter = i;
    }
    opened o = open_textures(t, 4, ALL);
    for (unsigned k = 0; k < 400; ++k) {
        texture_queries q = {.count = TEXTURE_BLOCK};
        for (unsigned i = 0; i < TEXTURE_BLOCK; ++i) {
            const float x = (float)(k * TEXTURE_BLOCK + i);
            q.texture[i] = i % 4;
            q.u[i] = x * 0.137f - 300, q.v[i] = x * 0.071f - 200, q.width[i] = x * 0x1p-14f;
        }
        float plain[4][TEXTURE_BLOCK], found[4][TEXTURE_BLOCK];
        texture_kernels_at(0)->look_up(o.cache, &q, plain);
        for (unsigned set = 1; texture_kernels_at(set); ++set) {
            texture_kernels_at(set)->look_up(o.cache, &q, found);
            assert_memory_equal(found, plain, sizeof plain);
        }
        check_alone(o.cache, &q, k % TEXTURE_BLOCK, plain);
    }
}

UNIT_TEST(places_that_are_not_finite_give_some_texel) {
    put_noise("n.ppm", 3, 3, 5);
    fathom_texture t[3];
    for (unsigned i = 0; i < 3; ++i)
        t[i] = texture_of("n.ppm", FATHOM_COLOR_SRGB), t[i].wrap_u = t[i].wrap_v = i;
    opened o = open_textures(t, 3, ALL);
    const float wrong[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f, 1e-45f, -1e-45f};
    for (unsigned i = 0; i < 3 * 7 * 7; ++i) {
        float rgba[4];
        look(o.cache, i % 3, wrong[i / 3 % 7], wrong[i / 21], wrong[i % 7], rgba);
        for (int c = 0; c < 4; ++c) assert_true(rgba[c] >= 0 && rgba[c] <= 1);
    }
}

/* ---- mip-mapped files ---- */

UNIT_TEST(mip_mapped_files_keep_texels_and_means) {
    put_noise("n.ppm", 300, 200, 7);
    write_texture("n.ppm", FATHOM_COLOR_SRGB, "n.tx");
    const fathom_texture t[2] = {texture_of("n.tx", FATHOM_COLOR_SRGB),
                                 texture_of("n.ppm", FATHOM_COLOR_SRGB)};
    opened o = open_textures(t, 2, ALL);
    assert_true(o.cache->images[0].info.mipmapped && !o.cache->images[1].info.mipmapped);
    assert_int_equal(o.cache->images[0].plan.count, o.cache->images[1].plan.count);
    for (unsigned i = 0; i < 300 * 200; ++i) {
        float ours[4], expected[4];
        texel(o.cache, 0, 0, i % 300, i / 300, ours);
        texel(o.cache, 1, 0, i % 300, i / 300, expected);
        assert_memory_equal(ours, expected, sizeof ours);
    }
    /* A byte is off by half a level, and the curve is nowhere steeper than 2.4 / 1.055. */
    check_means(&o, 0.5 / 255 * 2.4 / 1.055);
}

UNIT_TEST(mip_mapped_files_are_read_in_parts) {
    put_noise("n.ppm", 300, 300, 8);
    write_texture("n.ppm", FATHOM_COLOR_SRGB, "n.tx");
    const fathom_texture t = texture_of("n.tx", FATHOM_COLOR_SRGB);
    opened o = open_textures(&t, 1, ALL);
    float rgba[4];
    uint64_t filled = 0;
    look(o.cache, 0, 0.01f, 0.01f, 0, rgba);
    for (uint64_t i = 0; i < o.cache->store.size >> PYRAMID_CHUNK_SHIFT; ++i)
        filled += o.cache->store.filled[i];
    assert_int_equal(filled, 1);
}

/* Halves, 16 bits and alpha, with texels of colour that alpha hides. */
UNIT_TEST(mip_mapped_files_keep_the_type_and_what_alpha_hides) {
    uint16_t grey[70];
    float planes[4 * 70];
    for (unsigned i = 0; i < 70; ++i) grey[i] = (uint16_t)(i * 900 + 1);
    for (unsigned i = 0; i < 4 * 70; ++i) planes[i] = (float)(i % 19) / 255;
    put_tiff("g.tif", 70, 1, 16, grey);
    put_image("a.png", 70, 1, planes, 4, true);
    put_image("h.exr", 70, 1, planes, 3, true);
    static const char *const names[][2] = {{"g.tif", "g.tx"}, {"a.png", "a.tx"}, {"h.exr", "h.tx"}};
    static const image_texel types[] = {IMAGE_TEXEL_U16, IMAGE_TEXEL_U8, IMAGE_TEXEL_HALF};
    for (unsigned k = 0; k < 3; ++k) {
        write_texture(names[k][0], FATHOM_COLOR_LINEAR, names[k][1]);
        const fathom_texture t[2] = {texture_of(names[k][0], FATHOM_COLOR_LINEAR),
                                     texture_of(names[k][1], FATHOM_COLOR_LINEAR)};
        opened o = open_textures(t, 2, ALL);
        assert_int_equal(o.cache->images[1].info.kept, types[k]);
        for (unsigned i = 0; i < 70; ++i) {
            float ours[4], expected[4];
            texel(o.cache, 0, 0, i, 0, expected);
            texel(o.cache, 1, 0, i, 0, ours);
            assert_memory_equal(ours, expected, sizeof ours);
        }
    }
    put_noise("n.ppm", 2, 2, 9);
    const fathom_texture t = texture_of("n.ppm", FATHOM_COLOR_SRGB);
    assert_fails(context, fathom_texture_write(context, &t, in_folder("n.png")), FATHOM_BAD_USAGE,
                 "expected a name that ends in .tx, .tif or .tiff");
}

/* ---- limits and threads ---- */

enum { IMAGES = 16, LOOKUPS = SANITIZED ? 15000 : 60000 };

static const char *image_name(unsigned i) {
    static const char *const names[IMAGES] = {"0.ppm",  "1.ppm",  "2.ppm",  "3.ppm", "4.ppm",  "5.ppm",
                                              "6.ppm",  "7.ppm",  "8.ppm",  "9.ppm", "10.ppm", "11.ppm",
                                              "12.ppm", "13.ppm", "14.ppm", "15.ppm"};
    return names[i];
}

/* 16 images of about 0.6 MB each, under limits that hold all, or one and a few chunks. */
static void put_images(void) {
    for (unsigned i = 0; i < IMAGES; ++i) put_noise(image_name(i), 300, 290 + i % 10, i);
}

static opened open_images(uint64_t limit) {
    opened o = {.scene = new_scene(context)};
    for (unsigned i = 0; i < IMAGES; ++i) {
        const fathom_texture t = texture_of(image_name(i), FATHOM_COLOR_SRGB);
        assert_ok(context, fathom_scene_add_texture(o.scene, &t, NULL));
    }
    assert_ok(context, texture_cache_open(context, o.scene, limit, &o.cache));
    own_cache(o.cache);
    return o;
}

static uint64_t lookups_hash(texture_cache *cache, unsigned seed) {
    uint64_t hash = 0;
    texture_queries q = {.count = TEXTURE_BLOCK};
    for (unsigned i = 0; i < LOOKUPS / TEXTURE_BLOCK; ++i) {
        for (unsigned k = 0; k < TEXTURE_BLOCK; ++k) {
            seed = seed * 1664525u + 1013904223u;
            q.texture[k] = (seed >> 20) % IMAGES;
            q.u[k] = (float)(seed >> 8) * 0x1p-24f, q.v[k] = (float)(seed * 40503u >> 8) * 0x1p-24f;
            q.width[k] = (float)(seed >> 28) / 256;
        }
        float found[4][TEXTURE_BLOCK];
        texture_lookup(cache, &q, found);
        for (unsigned c = 0; c < 4 * TEXTURE_BLOCK; ++c) {
            uint32_t bits;
            memcpy(&bits, &found[c / TEXTURE_BLOCK][c % TEXTURE_BLOCK], sizeof bits);
            hash = (hash ^ bits) * 1099511628211u;
        }
    }
    return hash;
}

UNIT_TEST(no_result_depends_on_what_was_dropped) {
    put_images();
    opened all = open_images(ALL), few = open_images(1000000);
    assert_true(lookups_hash(all.cache, 1) == lookups_hash(few.cache, 1));
    assert_true(all.cache->store.size == all.cache->store.kept && all.cache->store.dropped == 0);
    assert_true(few.cache->store.dropped > IMAGES);
    assert_true(few.cache->store.kept + few.cache->store.resident <= 1000000);
    assert_ok(context, texture_cache_check(few.cache, context));
}

/* Whole levels are in memory, from the smallest on, of all images alike; where no texture filters between
 * levels, the first goes before the others. */
UNIT_TEST(memory_has_the_levels_that_are_looked_up_most) {
    put_images();
    opened o = open_images(1000000);
    uint64_t kept = 0, least = UINT64_MAX;
    for (unsigned i = 0; i < IMAGES; ++i) {
        const pyramid *p = &o.cache->images[i].plan;
        for (unsigned k = 0; k <= p->tail; ++k) {
            const uint64_t bytes = pyramid_part_bytes(p, k);
            if (p->levels[k].offset < o.cache->store.kept)
                kept = bytes > kept ? bytes : kept;
            else
                least = bytes < least ? bytes : least;
        }
    }
    assert_true(kept > 0 && least < UINT64_MAX && kept <= least);
    fathom_texture t[2] = {texture_of(image_name(0), FATHOM_COLOR_SRGB),
                           texture_of(image_name(1), FATHOM_COLOR_SRGB)};
    t[0].filter = FATHOM_TEXTURE_LINEAR;
    o = open_textures(t, 2, ALL);
    const pyramid *linear = &o.cache->images[0].plan, *trilinear = &o.cache->images[1].plan;
    assert_true(linear->tail > 0 && linear->levels[0].offset < linear->levels[linear->tail].offset);
    assert_true(trilinear->levels[0].offset > trilinear->levels[trilinear->tail].offset);
}

typedef struct looking {
    pthread_t thread;
    texture_cache *cache;
    unsigned seed;
    uint64_t hash;
} looking;

static void *look_on(void *user) {
    looking *l = user;
    l->hash = lookups_hash(l->cache, l->seed);
    return NULL;
}

UNIT_TEST(no_result_depends_on_threads) {
    enum { THREADS = 4 };
    put_images();
    opened alone = open_images(ALL), shared = open_images(1000000);
    shared.cache->helpers = 3; /* as many texels would have it */
    looking threads[THREADS];
    for (unsigned i = 0; i < THREADS; ++i) {
        threads[i] = (looking){.cache = shared.cache, .seed = i / 2};
        assert_int_equal(pthread_create(&threads[i].thread, NULL, look_on, &threads[i]), 0);
    }
    for (unsigned i = 0; i < THREADS; ++i) {
        pthread_join(threads[i].thread, NULL);
        assert_true(threads[i].hash == lookups_hash(alone.cache, i / 2));
    }
    assert_true(shared.cache->store.dropped > 0);
}

/* ---- what is refused ---- */

static void check_opening_fails(const fathom_texture *t, fathom_status status, const char *text) {
    fathom_scene *scene = new_scene(context);
    texture_cache *cache;
    assert_ok(context, fathom_scene_add_texture(scene, t, NULL));
    assert_fails(context, texture_cache_open(context, scene, ALL, &cache), status, text);
    assert_non_null(strstr(fathom_context_message(context), t->name ? t->name : t->file));
    assert_null(cache);
}

UNIT_TEST(files_that_are_no_textures_are_named) {
    static const char wide[] = "P6\n65537 1\n255\n", many[] = "P6\n65536 65537\n255\n";
    put_file("text.png", "this is no image", 16, "", 0);
    put_file("wide.ppm", wide, sizeof wide - 1, "", 0);
    put_file("many.ppm", many, sizeof many - 1, "", 0);
    fathom_texture t = texture_of("text.png", FATHOM_COLOR_SRGB);
    check_opening_fails(&t, FATHOM_BAD_INPUT, "cannot be read as a texture");
    t.bytes = "this is no image", t.byte_count = 16, t.file = NULL, t.name = "inner";
    check_opening_fails(&t, FATHOM_BAD_INPUT, "inner: cannot be read as a texture");
    assert_null(strstr(fathom_context_message(context), "/proc/")); /* how the helper gets the bytes */
    t = texture_of("wide.ppm", FATHOM_COLOR_SRGB);
    check_opening_fails(&t, FATHOM_BAD_INPUT, "65537"); /* some versions of OpenImageIO refuse it first */
    t = texture_of("many.ppm", FATHOM_COLOR_SRGB);
    check_opening_fails(&t, FATHOM_BAD_INPUT, "65537");
    put_format("a.ppm");
    t = texture_of("a.ppm", FATHOM_COLOR_NAMED), t.color_space_name = "Mauve";
    check_opening_fails(&t, FATHOM_BAD_USAGE,
                        "no color space \"Mauve\"; expected srgb, linear or one of: \"Linear Rec.709\"");
    put_image("two.exr", 1, 1, (const float[]){0, 0}, 2, false);
    t = texture_of("two.exr", FATHOM_COLOR_LINEAR);
    check_opening_fails(&t, FATHOM_BAD_INPUT, "or one, three or four, or grey and A; found R, G");
}

/* 8 × 8 grey texels: tables of ones and of one code, a scan of means. Without the last two bytes another scan
 * could follow. */
UNIT_TEST(a_progressive_jpeg_has_all_of_its_scans) {
    static unsigned char file[] = {0xff, 0xd8, 0xff, 0xdb, 0, 67, 0,         [71] = 0xff, 0xc2, 0,
                                   11,   8,    0,    8,    0, 8,  1,         1,           0x11, 0,
                                   0xff, 0xc4, 0,    20,   0, 1,  [105] = 2, 0xff,        0xda, 0,
                                   8,    1,    1,    0,    0, 0,  1,         0x3f,        0xff, 0xd9};
    memset(file + 7, 1, 64);
    put_file("whole.jpg", file, sizeof file, "", 0);
    put_file("cut.jpg", file, sizeof file - 2, "", 0);
    fathom_texture t = texture_of("whole.jpg", FATHOM_COLOR_SRGB);
    opened o = open_textures(&t, 1, ALL);
    float rgba[4];
    texel(o.cache, 0, 0, 0, 0, rgba);
    assert_ok(context, texture_cache_check(o.cache, context));
    t = texture_of("cut.jpg", FATHOM_COLOR_SRGB);
    check_opening_fails(&t, FATHOM_BAD_INPUT, "cut.jpg: cannot be read as a texture: ");
}

/* Lookups go on; the failure is kept. */
static void check_lookup_fails(const char *name, const char *text) {
    const fathom_texture t = texture_of(name, FATHOM_COLOR_LINEAR);
    opened o = open_textures(&t, 1, ALL);
    float rgba[4];
    assert_ok(context, texture_cache_check(o.cache, context));
    look(o.cache, 0, 0.5f, 0.5f, 0, rgba);
    assert_true(rgba[0] == 1 && rgba[1] == 0 && rgba[2] == 1 && rgba[3] == 1);
    assert_fails(context, texture_cache_check(o.cache, context), FATHOM_BAD_INPUT, text);
    assert_non_null(strstr(fathom_context_message(context), t.file));
}

UNIT_TEST(broken_data_is_reported_after_the_lookup) {
    float planes[3 * 6] = {0};
    put_noise("cut.ppm", 100, 100, 6);
    assert_int_equal(truncate(in_folder("cut.ppm"), 9000), 0);
    planes[6 + 5] = NAN;
    put_image("nan.exr", 3, 2, planes, 3, false);
    planes[6 + 5] = INFINITY;
    put_image("inf.exr", 3, 2, planes, 3, true);
    check_lookup_fails("cut.ppm", "cannot be read as a texture: ");
    check_lookup_fails("nan.exr", "texel (2, 1), counted from the top left, is not finite in channel G");
    check_lookup_fails("inf.exr", "texel (2, 1), counted from the top left, is not finite in channel G");
}

UNIT_TEST(wrong_descriptions_are_refused) {
    fathom_scene *scene = new_scene(context);
    fathom_texture t = texture_of("absent.png", FATHOM_COLOR_SRGB);
    assert_fails(context, fathom_scene_add_texture(scene, &t, NULL), FATHOM_BAD_INPUT, "absent.png: ");
    t.file = folder;
    assert_fails(context, fathom_scene_add_texture(scene, &t, NULL), FATHOM_BAD_INPUT, "folder");
    put_file("empty.png", "", 0, "", 0);
    t = texture_of("empty.png", FATHOM_COLOR_SRGB);
    assert_fails(context, fathom_scene_add_texture(scene, &t, NULL), FATHOM_BAD_INPUT, "empty");
    put_format("a.ppm");
    t = texture_of("a.ppm", FATHOM_COLOR_SRGB), t.bytes = "a", t.byte_count = 1;
    assert_fails(context, fathom_scene_add_texture(scene, &t, NULL), FATHOM_BAD_USAGE,
                 "either a file or bytes");
    t.file = NULL, t.byte_count = 0;
    assert_fails(context, fathom_scene_add_texture(scene, &t, NULL), FATHOM_BAD_INPUT, "found no bytes");
    t = texture_of("a.ppm", (fathom_color_space)7);
    assert_fails(context, fathom_scene_add_texture(scene, &t, NULL), FATHOM_BAD_USAGE, "color space 7");
    t = texture_of("a.ppm", FATHOM_COLOR_NAMED);
    assert_fails(context, fathom_scene_add_texture(scene, &t, NULL), FATHOM_BAD_USAGE,
                 "name of a color space");
    t = texture_of("a.ppm", FATHOM_COLOR_SRGB), t.wrap_v = 9;
    assert_fails(context, fathom_scene_add_texture(scene, &t, NULL), FATHOM_BAD_USAGE, "wrap mode 9");
    t = texture_of("a.ppm", FATHOM_COLOR_SRGB), t.filter = 4;
    assert_fails(context, fathom_scene_add_texture(scene, &t, NULL), FATHOM_BAD_USAGE, "filter 4");
    t = texture_of("a.ppm", FATHOM_COLOR_SRGB), t.size = 0;
    assert_fails(context, fathom_scene_add_texture(scene, &t, NULL), FATHOM_BAD_USAGE, "its size is 0 bytes");
}

UNIT_TEST(equal_textures_get_one_id) {
    put_format("a.ppm");
    fathom_scene *scene = new_scene(context);
    fathom_id ids[4];
    fathom_texture t = texture_of("a.ppm", FATHOM_COLOR_SRGB);
    assert_ok(context, fathom_scene_add_texture(scene, &t, &ids[0]));
    t.name = "another name";
    assert_ok(context, fathom_scene_add_texture(scene, &t, &ids[1]));
    t.wrap_u = FATHOM_WRAP_CLAMP;
    assert_ok(context, fathom_scene_add_texture(scene, &t, &ids[2]));
    t.color_space = FATHOM_COLOR_LINEAR;
    assert_ok(context, fathom_scene_add_texture(scene, &t, &ids[3]));
    assert_true(ids[0] == 0 && ids[1] == 0 && ids[2] == 1 && ids[3] == 2);
}

int main(void) { return unit_main(open_folder, remove_folder); }
