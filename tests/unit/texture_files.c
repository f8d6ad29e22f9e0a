/* Texture files as a cache reads them: level by level, in bands of rows, and closed and opened again. */
#include "textures.h"

#include "ktx2_file.h"

/* A mip-mapped TIFF of floats, grey, of side × side texels: level 0 has the one value, all other levels have
 * the other. Returns the offset of the tile that all levels but the first have. */
static size_t put_levels(const char *name, uint32_t side, float first, float others) {
    enum {
        TILE = 64,
        TILE_BYTES = TILE * TILE * 4,
        ENTRIES = 13,
        IFD = 2 + ENTRIES * 12 + 4,
        FORMAT = 8,
        TEXT = 16
    };
    static unsigned char bytes[2 * TILE_BYTES + 4096];
    const size_t tiles = 2048;
    size_t at = FORMAT + TEXT;
    memset(bytes, 0, sizeof bytes);
    memcpy(bytes, (const unsigned char[]){'I', 'I', 42, 0, FORMAT + TEXT}, 5);
    memcpy(bytes + FORMAT, "Plain Texture", 14);
    for (unsigned level = 0; side >> level; ++level) {
        const uint32_t width = side >> level, across = (width + TILE - 1) / TILE, count = across * across;
        const uint32_t tile = (uint32_t)(tiles + (level ? TILE_BYTES : 0)), lists = (uint32_t)(at + IFD),
                       next = lists + (count > 1 ? 8 * count : 0);
        const struct {
            uint16_t tag, type;
            uint32_t count, value;
        } entries[ENTRIES] = {{254, 4, 1, level > 0},
                              {256, 4, 1, width},
                              {257, 4, 1, width},
                              {258, 3, 1, 32},
                              {259, 3, 1, 1},
                              {262, 3, 1, 1},
                              {277, 3, 1, 1},
                              {322, 4, 1, TILE},
                              {323, 4, 1, TILE},
                              {324, 4, count, count > 1 ? lists : tile},
                              {325, 4, count, count > 1 ? lists + 4 * count : TILE_BYTES},
                              {339, 3, 1, 3},
                              {33302, 2, 14, FORMAT}};
        bytes[at] = ENTRIES;
        memcpy(bytes + at + 2, entries, sizeof entries);
        if (width > 1) memcpy(bytes + at + 2 + sizeof entries, &next, 4);
        for (uint32_t i = 0; count > 1 && i < count; ++i) {
            const uint32_t size = TILE_BYTES;
            memcpy(bytes + lists + 4 * i, &tile, 4);
            memcpy(bytes + lists + 4 * (count + i), &size, 4);
        }
        at = next;
    }
    assert_true(at <= tiles);
    for (size_t i = 0; i < TILE * TILE; ++i) {
        memcpy(bytes + tiles + 4 * i, &first, 4);
        memcpy(bytes + tiles + TILE_BYTES + 4 * i, &others, 4);
    }
    put_file(name, bytes, tiles + 2 * TILE_BYTES, "", 0);
    return tiles + TILE_BYTES;
}

static const char *numbered(unsigned i) {
    static char name[16];
    snprintf(name, sizeof name, "%u.tx", i);
    return name;
}

/* Side 128: level 0 fills one chunk of the store, and all others another. */
UNIT_TEST(more_files_than_stay_open_keep_their_texels) {
    enum { FILES = CACHE_OPEN + 3 };
    opened o = {.scene = new_scene(context)};
    for (unsigned i = 0; i < FILES; ++i) {
        put_levels(numbered(i), 128, (float)i + 0.25f, (float)i + 0.75f);
        const fathom_texture t = texture_of(numbered(i), FATHOM_COLOR_LINEAR);
        assert_ok(context, fathom_scene_add_texture(o.scene, &t, NULL));
    }
    assert_ok(context, texture_cache_open(context, o.scene, ALL, &o.cache));
    own_cache(o.cache);
    for (unsigned pass = 0; pass < 2; ++pass) {
        unsigned open = 0;
        for (unsigned i = 0; i < FILES; ++i) {
            float rgba[4];
            assert_true(o.cache->images[i].info.mipmapped);
            texel(o.cache, i, pass ? 0 : 3, 5, 9, rgba);
            assert_true(rgba[0] == (float)i + (pass ? 0.25f : 0.75f));
        }
        for (unsigned i = 0; i < FILES; ++i) open += o.cache->images[i].source != NULL;
        assert_int_equal(open, CACHE_OPEN);
    }
    assert_ok(context, texture_cache_check(o.cache, context));
}

static void check_lookup_fails(texture_cache *cache, const char *text) {
    float rgba[4];
    assert_ok(context, texture_cache_check(cache, context));
    texel(cache, 0, 0, 0, 0, rgba);
    assert_true(rgba[0] == 1 && rgba[1] == 0 && rgba[2] == 1 && rgba[3] == 1);
    assert_fails(context, texture_cache_check(cache, context), FATHOM_BAD_INPUT, text);
}

/* All levels of 64 × 64 texels are read at once. */
UNIT_TEST(a_number_that_is_not_finite_is_told_with_its_level) {
    const float nan = NAN;
    const size_t tile = put_levels("a.tx", 64, 1, 2);
    FILE *file = fopen(in_folder("a.tx"), "r+b");
    assert_non_null(file);
    /* Texel (5, 3) of the tile: level 3 of 8 × 8 texels is the last that has it, level 1 the first. */
    fseek(file, (long)tile + 4 * (3 * 64 + 5), SEEK_SET);
    fwrite(&nan, sizeof nan, 1, file);
    fclose(file);
    const fathom_texture t = texture_of("a.tx", FATHOM_COLOR_LINEAR);
    opened o = open_textures(&t, 1, ALL);
    check_lookup_fails(o.cache, "texel (5, 3) of mip level 1, counted from the top left, is not finite in "
                                "channel Y; expected numbers");
}

UNIT_TEST(files_that_change_their_size_are_told) {
    static const unsigned char rgb[5 * 4 * 3];
    for (int mipmapped = 0; mipmapped < 2; ++mipmapped) {
        const char *name = mipmapped ? "a.tx" : "a.ppm";
        for (int changed = 0; changed < (mipmapped ? 1 : 2); ++changed) {
            if (mipmapped)
                put_levels(name, 128, 1, 2);
            else
                put_ppm(name, 4, 4, rgb);
            const fathom_texture t = texture_of(name, FATHOM_COLOR_LINEAR);
            opened o = open_textures(&t, 1, ALL);
            if (mipmapped)
                put_levels(name, 64, 1, 2);
            else
                put_ppm(name, changed ? 4 : 5, changed ? 5 : 4, rgb);
            check_lookup_fails(o.cache, "was changed while it was in use");
        }
    }
}

/* More than 4 MiB of rows, so they come in two bands. */
UNIT_TEST(large_images_keep_every_row) {
    enum { WIDTH = 1500, HEIGHT = 1000 };
    unsigned char *rgb = unit_memory(WIDTH * HEIGHT * 3 + 32);
    const int header = snprintf((char *)rgb, 32, "P6\n%d %d\n255\n", WIDTH, HEIGHT);
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        unsigned char *texel = rgb + header + 3 * (size_t)i;
        texel[0] = (unsigned char)(i % WIDTH), texel[1] = (unsigned char)(i / WIDTH),
        texel[2] = (unsigned char)(i >> 16);
    }
    unit_write_file(in_folder("a.ppm"), rgb, (size_t)header + WIDTH * HEIGHT * 3);
    fathom_texture t = texture_of("a.ppm", FATHOM_COLOR_LINEAR);
    t.filter = FATHOM_TEXTURE_NEAREST;
    opened o = open_textures(&t, 1, ALL);
    for (unsigned y = 0; y < HEIGHT; ++y) {
        const unsigned x = y * 7 % WIDTH;
        float rgba[4];
        texel(o.cache, 0, 0, x, y, rgba);
        const unsigned expected[3] = {x & 255, y & 255, (y * WIDTH + x) >> 16};
        for (int c = 0; c < 3; ++c) assert_near(rgba[c], expected[c] / 255.0, 1e-7);
    }
}

/* Every eighth code of 16 bits, by the sRGB curve and linear. */
UNIT_TEST(written_textures_keep_sixteen_bits) {
    enum { WIDTH = 8192 };
    static uint16_t grey[WIDTH];
    for (unsigned i = 0; i < WIDTH; ++i) grey[i] = (uint16_t)(8 * i + 7);
    put_tiff("a.tif", WIDTH, 1, 16, grey);
    static const fathom_color_space spaces[] = {FATHOM_COLOR_SRGB, FATHOM_COLOR_LINEAR};
    for (int k = 0; k < 2; ++k) {
        write_texture("a.tif", spaces[k], "a.tx");
        fathom_texture t[2] = {texture_of("a.tif", spaces[k]), texture_of("a.tx", spaces[k])};
        t[0].filter = t[1].filter = FATHOM_TEXTURE_NEAREST;
        opened o = open_textures(t, 2, ALL);
        for (unsigned i = 0; i < WIDTH; ++i) {
            float expected[4], rgba[4];
            texel(o.cache, 0, 0, i, 0, expected);
            texel(o.cache, 1, 0, i, 0, rgba);
            if (memcmp(expected, rgba, sizeof rgba) != 0)
                fail_msg("code %u becomes %.9g, was %.9g", grey[i], (double)rgba[0], (double)expected[0]);
        }
    }
}

UNIT_TEST(written_textures_keep_every_bit_of_floats) {
    const float planes[3 * 4] = {0.1f,   -2.5f,  1e6f, 3e38f, 1.0000001f, 0,
                                 1e-30f, -1e-3f, 7,    65535, 1e-6f,      0.5f};
    put_image("a.exr", 4, 1, planes, 3, false);
    write_texture("a.exr", FATHOM_COLOR_LINEAR, "a.tx");
    fathom_texture t = texture_of("a.tx", FATHOM_COLOR_LINEAR);
    t.filter = FATHOM_TEXTURE_NEAREST;
    opened o = open_textures(&t, 1, ALL);
    assert_int_equal(o.cache->images[0].info.kept, IMAGE_TEXEL_FLOAT);
    for (unsigned i = 0; i < 4; ++i) {
        float rgba[4];
        texel(o.cache, 0, 0, i, 0, rgba);
        for (unsigned c = 0; c < 3; ++c) assert_true(rgba[c] == planes[4 * c + i]);
    }
}

/* ---- alpha ---- */

/* OpenEXR's colours are multiplied by alpha. */
UNIT_TEST(premultiplied_colors_are_divided_by_alpha) {
    const float planes[4][2] = {{0.25f, 0}, {0.125f, 0}, {0, 0}, {0.5f, 0}};
    put_image("p.exr", 2, 1, planes[0], 4, true);
    const fathom_texture t = texture_of("p.exr", FATHOM_COLOR_LINEAR);
    opened o = open_textures(&t, 1, ALL);
    float rgba[4];
    texel(o.cache, 0, 0, 0, 0, rgba);
    assert_true(rgba[0] == 0.5f && rgba[1] == 0.25f && rgba[2] == 0 && rgba[3] == 0.5f);
    texel(o.cache, 0, 0, 1, 0, rgba);
    assert_true(rgba[0] == 0 && rgba[3] == 0);
}

/* An image of 4 x 2 texels whose display window is made another one than that of its data: texels outside of
 * the data are black and clear, and data outside of the display are not seen. */
UNIT_TEST(a_texture_is_the_display_window_of_an_exr_file) {
    static const int32_t windows[][4] = {{-1, -2, 5, 2}, {1, 0, 2, 1}, {2, 1, 6, 3}, {9, 9, 10, 10}};
    float planes[4 * 8];
    for (int i = 0; i < 32; ++i) planes[i] = i < 24 ? (float)(i + 1) : 1;
    for (size_t k = 0; k < sizeof windows / sizeof *windows; ++k) {
        const int32_t *w = windows[k], width = w[2] - w[0] + 1, height = w[3] - w[1] + 1;
        put_image("w.exr", 4, 2, planes, 4, false);
        FILE *file = fopen(in_folder("w.exr"), "r+b");
        const size_t size = fread(file_bytes, 1, sizeof file_bytes, file);
        const unsigned char *at = memmem(file_bytes, size, "displayWindow", 14);
        assert_true(file && at && memcmp(at + 14, "box2i", 6) == 0);
        assert_int_equal(fseek(file, at + 24 - file_bytes, SEEK_SET), 0);
        assert_int_equal(fwrite(w, sizeof *w, 4, file), 4);
        fclose(file);
        const fathom_texture t = texture_of("w.exr", FATHOM_COLOR_LINEAR);
        opened o = open_textures(&t, 1, ALL);
        const pyramid_level *l = o.cache->images[0].plan.levels;
        assert_true(l->width == (uint32_t)width && l->height == (uint32_t)height);
        for (int i = 0; i < width * height; ++i) {
            const int x = w[0] + i % width, y = w[1] + i / width;
            const bool inside = x >= 0 && x < 4 && y >= 0 && y < 2;
            float rgba[4];
            texel(o.cache, 0, 0, (unsigned)(i % width), (unsigned)(i / width), rgba);
            for (int c = 0; c < 4; ++c) assert_true(rgba[c] == (inside ? planes[8 * c + 4 * y + x] : 0));
        }
        assert_ok(context, texture_cache_check(o.cache, context));
    }
}

/* maketx writes such files. Integers stay integers, so that they are decoded as sRGB; a colour above alpha
 * becomes 1. */
UNIT_TEST(premultiplied_integers_are_divided_as_integers) {
    static const unsigned char bytes[4][4] = {
        {15, 64, 77, 77}, {1, 2, 3, 4}, {255, 128, 0, 255}, {9, 0, 8, 8}};
    static const uint16_t words[2][4] = {{1000, 20000, 0, 40000}, {65535, 7, 1, 65535}};
    put_tiff("a.tif", 4, 4, 8, bytes);
    check_codes(
        "a.tif",
        (const unsigned[][4]){{50, 212, 255, 77}, {64, 128, 191, 4}, {255, 128, 0, 255}, {255, 0, 255, 8}}, 4,
        255);
    put_tiff("a.tif", 2, 4, 16, words);
    check_codes("a.tif", (const unsigned[][4]){{1638, 32768, 0, 40000}, {65535, 7, 1, 65535}}, 2, 65535);
}

/* OpenImageIO gives them as floats: 2^31 as 1/2 exactly. */
UNIT_TEST(integers_of_32_bits_count_as_srgb_as_well) {
    static const uint32_t codes[2][4] = {{1u << 31, 0, UINT32_MAX, UINT32_MAX},
                                         {0, UINT32_MAX, 1u << 31, UINT32_MAX}};
    put_tiff("a.tif", 2, 4, 32, codes);
    check_codes("a.tif", (const unsigned[][4]){{1, 0, 2, 2}, {0, 2, 1, 2}}, 2, 2);
}

static void put_ktx2(const char *name, const ktx2_recipe *r) {
    uint8_t file[KTX2_FILE_MAX];
    put_file(name, file, ktx2_make(r, file), "", 0);
}

UNIT_TEST(ktx2_is_read_as_other_images_are) {
    static const uint8_t texels[8] = {255, 128, 0, 200, 1, 2, 3, 0},
                         premultiplied[8] = {15, 64, 77, 77, 1, 2, 3, 4};
    ktx2_recipe r = {.format = 43,
                     .width = 2,
                     .height = 1,
                     .model = 1,
                     .transfer = 2,
                     .channels = "012?",
                     .level = texels,
                     .level_size = 8};
    put_ktx2("a.ktx2", &r);
    check_codes("a.ktx2", (const unsigned[][4]){{255, 128, 0, 200}, {1, 2, 3, 0}}, 2, 255);
    r.flags = 1, r.level = premultiplied;
    put_ktx2("a.ktx2", &r);
    check_codes("a.ktx2", (const unsigned[][4]){{50, 212, 255, 77}, {64, 128, 191, 4}}, 2, 255);
}

/* Rows that begin at the bottom. */
UNIT_TEST(ktx2_may_have_its_lowest_row_first) {
    static const uint8_t rows[3] = {30, 20, 10};
    put_ktx2("a.ktx2", &(ktx2_recipe){.format = 9,
                                      .width = 1,
                                      .height = 3,
                                      .model = 1,
                                      .transfer = 1,
                                      .channels = "0",
                                      .key = "KTXorientation",
                                      .value = "ru",
                                      .level = rows,
                                      .level_size = 3});
    const fathom_texture t = texture_of("a.ktx2", FATHOM_COLOR_LINEAR);
    opened o = open_textures(&t, 1, ALL);
    for (unsigned y = 0; y < 3; ++y) {
        float rgba[4];
        texel(o.cache, 0, 0, 0, y, rgba);
        assert_true(rgba[0] == (float)((10 + 10 * y) / 255.0));
    }
}

/* The first texel of the file is 100, of sRGB or linear, and reading warns of `told` alone; NULL: of nothing.
 */
static void assert_encoding(const char *file, fathom_color_space space, bool is_srgb, const char *told) {
    const fathom_texture t = texture_of(file, space);
    float rgba[4];
    forget_warnings();
    opened o = open_textures(&t, 1, ALL);
    texel(o.cache, 0, 0, 0, 0, rgba);
    assert_true(rgba[0] == (float)(is_srgb ? srgb(100 / 255.0) : 100 / 255.0));
    assert_int_equal(warning_count, told != NULL);
    if (told) expect_warning(told);
}

/* Another colour space in the scene is followed, with a warning. */
UNIT_TEST(ktx2_files_choose_their_encoding_where_the_scene_does_not) {
    static const uint8_t level[1] = {100};
    static const struct {
        uint8_t transfer;
        fathom_color_space space;
        bool srgb;
        const char *told;
    } cases[] = {{0, FATHOM_COLOR_AUTO, true, NULL},
                 {1, FATHOM_COLOR_AUTO, false, NULL},
                 {2, FATHOM_COLOR_AUTO, true, NULL},
                 {3, FATHOM_COLOR_AUTO, true, "are neither sRGB nor linear; they are taken as sRGB"},
                 {0, FATHOM_COLOR_LINEAR, false, NULL},
                 {1, FATHOM_COLOR_LINEAR, false, NULL},
                 {2, FATHOM_COLOR_LINEAR, false, "are sRGB; they are taken as linear"},
                 {1, FATHOM_COLOR_SRGB, true, "are linear; they are taken as sRGB"},
                 {2, FATHOM_COLOR_SRGB, true, NULL}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        put_ktx2("a.ktx2", &(ktx2_recipe){.format = 9,
                                          .width = 1,
                                          .height = 1,
                                          .model = 1,
                                          .transfer = cases[i].transfer,
                                          .channels = "0",
                                          .level = level,
                                          .level_size = 1});
        assert_encoding("a.ktx2", cases[i].space, cases[i].srgb, cases[i].told);
    }
}

/* `fathom texture` writes how it averaged, and data of levels that were averaged as sRGB are not data. */
UNIT_TEST(mip_mapped_files_say_how_their_levels_were_averaged) {
    static const struct {
        fathom_color_space written, read;
        bool srgb;
        const char *told;
    } cases[] = {
        {FATHOM_COLOR_AUTO, FATHOM_COLOR_AUTO, true, NULL},
        {FATHOM_COLOR_AUTO, FATHOM_COLOR_SRGB, true, NULL},
        {FATHOM_COLOR_AUTO, FATHOM_COLOR_LINEAR, false,
         "a.tx: says that its numbers are sRGB; they are taken as linear, for which its smaller levels "
         "are wrong averages: make it with fathom texture --color linear"},
        {FATHOM_COLOR_LINEAR, FATHOM_COLOR_AUTO, false, NULL},
        {FATHOM_COLOR_LINEAR, FATHOM_COLOR_LINEAR, false, NULL},
        {FATHOM_COLOR_LINEAR, FATHOM_COLOR_SRGB, true, "make it with fathom texture --color srgb"}};
    put_file("a.ppm", "P6 1 1 255\n\144\144\144", 14, "", 0);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        write_texture("a.ppm", cases[i].written, "a.tx");
        assert_encoding("a.tx", cases[i].read, cases[i].srgb, cases[i].told);
    }
}

/* A PNG of one texel, 100, whose gamma is 1; and its copy by `fathom texture`. */
UNIT_TEST(pngs_of_gamma_1_are_linear_unless_the_scene_says_otherwise) {
    static const unsigned char bytes[] = {
        0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00,
        0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00, 0x00, 0x3a, 0x7e, 0x9b, 0x55, 0x00,
        0x00, 0x00, 0x04, 0x67, 0x41, 0x4d, 0x41, 0x00, 0x01, 0x86, 0xa0, 0x31, 0xe8, 0x96, 0x5f, 0x00, 0x00,
        0x00, 0x0a, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x48, 0x01, 0x00, 0x00, 0x66, 0x00, 0x65, 0x7a,
        0xa0, 0xc6, 0x92, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82,
    };
    put_file("a.png", bytes, sizeof bytes, "", 0);
    write_texture("a.png", FATHOM_COLOR_AUTO, "a.tx");
    const fathom_texture t[] = {texture_of("a.png", FATHOM_COLOR_AUTO),
                                texture_of("a.png", FATHOM_COLOR_SRGB),
                                texture_of("a.tx", FATHOM_COLOR_AUTO)};
    opened o = open_textures(t, 3, ALL);
    for (fathom_id i = 0; i < 3; ++i) {
        float rgba[4];
        texel(o.cache, i, 0, 0, 0, rgba);
        const double expected = i == 1 ? srgb(100 / 255.0) : 100 / 255.0;
        assert_true(rgba[0] == (float)expected);
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
