/* What is written is what is read back: EXR to the last bit, 8-bit formats to the nearest code. */
#include "image/image.h"
#include "image/pack.h"
#include "unit_exr.h"
#include "unit_folder.h"

#include <unistd.h>

static fathom_write_options defaults(void) { return (fathom_write_options){.exposure = 0}; }

static float half_value(unsigned half) {
    unsigned exponent = half >> 10 & 31u, mantissa = half & 1023u;
    float magnitude = exponent == 31 ? (mantissa ? NAN : INFINITY)
                      : exponent     ? ldexpf((float)(1024 + mantissa), (int)exponent - 25)
                                     : ldexpf((float)mantissa, -24);
    return half & 0x8000u ? -magnitude : magnitude;
}

/* Every half is a fixed point; between two neighbours the nearer one is taken, and of two equally near ones
 * the one whose last bit is 0. */
UNIT_TEST(halves_round_to_nearest_even) {
    for (unsigned h = 0; h < 0x7c00; ++h) {
        assert_int_equal(half_from_float(half_value(h)), h);
        assert_int_equal(half_from_float(-half_value(h)), h | 0x8000u);
        if (h == 0x7bff) break;
        /* Neighbours have 11 bits, so their middle and its neighbours are exact floats. */
        float middle = 0.5f * (half_value(h) + half_value(h + 1));
        assert_int_equal(half_from_float(middle), h & 1 ? h + 1 : h);
        assert_int_equal(half_from_float(nextafterf(middle, 0)), h);
        assert_int_equal(half_from_float(nextafterf(middle, INFINITY)), h + 1);
    }
    assert_int_equal(half_from_float(INFINITY), 0x7c00);
    assert_int_equal(half_from_float(-INFINITY), 0xfc00);
    assert_int_equal(half_from_float(3e38f), 0x7bff);
    assert_true(isnan(half_value(half_from_float(NAN))));
}

static const image_channel *channel_of(const image *img, const char *name) {
    for (size_t i = 0; i < img->channel_count; ++i) {
        if (strcmp(img->channels[i].name, name) == 0) return &img->channels[i];
    }
    fail_msg("no channel %s", name);
    return NULL;
}

static const image *read_back(const char *path) {
    const image *img = NULL;
    assert_ok(context, image_read(context, path, &img));
    return img;
}

/* 3 × 2 pixels with everything an EXR can be asked to hold. */
static const float color[6][3] = {{0, 0.5f, 1},      {NAN, INFINITY, -INFINITY}, {1e9f, -1e9f, 65504},
                                  {0x1p-24f, 2, -3}, {0.1f, 0.2f, 0.3f},         {1e-9f, 1e-3f, 1e3f}};
static const float depth[6] = {1, 2.000001f, INFINITY, 1e30f, 0.1f, NAN};
static const uint32_t ids[6] = {0, 1, UINT32_MAX, 16777217, 4000000001u, 7};
static const double eye[3] = {0.1, -2, 1e-30}, seconds[1] = {0.123456789};
static const image_channel everything_channels[] = {
    {"R", IMAGE_FLOAT, true, &color[0][0], 12},    {"G", IMAGE_FLOAT, true, &color[0][1], 12},
    {"B", IMAGE_FLOAT, true, &color[0][2], 12},    {"A", IMAGE_FLOAT, true, depth, 4},
    {"Z", IMAGE_FLOAT, false, depth, 4},           {"N.X", IMAGE_FLOAT, false, &color[0][0], 12},
    {"N.Y", IMAGE_FLOAT, false, &color[0][1], 12}, {"id.object", IMAGE_UINT, false, ids, 4},
};
static const image_attribute everything_attributes[] = {
    {"Software", "Fathom 0.1.0", NULL, 0},
    {"fathom:scene", "caf\xc3\xa9", NULL, 0},
    {"fathom:renderTime", NULL, seconds, 1},
    {"fathom:eye", NULL, eye, 3},
};
static const image everything = {3, 2, 10, 20, 64, 48, everything_channels, 8, everything_attributes, 4, 0};

static void assert_same(float a, float b) {
    if (isnan(b))
        assert_true(isnan(a));
    else if (!(a == b))
        fail_msg("%.9g, expected %.9g", (double)a, (double)b);
}

static void check_exr_channels(const image *back, bool half) {
    for (size_t c = 0; c < everything.channel_count; ++c) {
        const image_channel *in = &everything_channels[c], *out = channel_of(back, in->name);
        assert_int_equal(out->type, in->type);
        assert_int_equal(out->color, in->color && half);
        for (size_t i = 0; i < 6; ++i) {
            const char *from = (const char *)in->data + i * in->stride, *to = (const char *)out->data + 4 * i;
            if (in->type == IMAGE_UINT) {
                assert_memory_equal(from, to, 4);
                continue;
            }
            float expected, found;
            memcpy(&expected, from, 4), memcpy(&found, to, 4);
            assert_same(found, in->color && half ? half_value(half_from_float(expected)) : expected);
        }
    }
}

UNIT_TEST(exr_keeps_every_value) {
    for (int half = 0; half < 2; ++half) {
        fathom_write_options options = defaults();
        options.float_color = !half;
        options.exposure = 3; /* not for EXR */
        assert_ok(context, image_write(context, &everything, in_folder("a.exr"), &options));
        const image *back = read_back(in_folder("a.exr"));
        assert_int_equal(back->width, 3);
        assert_int_equal(back->height, 2);
        assert_int_equal(back->x, 10);
        assert_int_equal(back->y, 20);
        assert_int_equal(back->full_width, 64);
        assert_int_equal(back->full_height, 48);
        assert_int_equal(back->channel_count, 8);
        const char *const first[] = {"R", "G", "B", "A"};
        for (size_t i = 0; i < 4; ++i) assert_string_equal(back->channels[i].name, first[i]);
        check_exr_channels(back, half);
        image_release(back);
    }
}

UNIT_TEST(exr_keeps_attributes) {
    static const float primaries[8] = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
    static const char *const types[] = {"double", "v3d"};
    const char *file = in_folder("a.exr");
    fathom_write_options options = defaults();
    assert_ok(context, image_write(context, &everything, file, &options));
    assert_exr_text(file, "Software", "Fathom 0.1.0");
    assert_exr_text(file, "fathom:scene", "caf\xc3\xa9");
    for (size_t i = 2; i < 4; ++i) {
        const image_attribute *in = &everything_attributes[i];
        assert_exr_bytes(file, in->name, types[i - 2], in->numbers, in->count * sizeof(double));
    }
    assert_exr_bytes(file, "chromaticities", "chromaticities", primaries, sizeof primaries);
    assert_exr_bytes(file, "compression", "compression", "\3", 1); /* ZIP */
}

static image rgb_image(uint32_t width, uint32_t height, const float *rgb, image_channel channels[3]) {
    const char *const names[] = {"R", "G", "B"};
    for (size_t c = 0; c < 3; ++c) channels[c] = (image_channel){names[c], IMAGE_FLOAT, true, rgb + c, 12};
    return (image){width, height, 0, 0, width, height, channels, 3, NULL, 0, 0};
}

/* Bytes that come back after writing `count` pixels in a row. */
static void codes_of(const float *rgb, uint32_t count, const char *name, const fathom_write_options *options,
                     int *codes) {
    image_channel channels[3];
    image img = rgb_image(count, 1, rgb, channels);
    assert_ok(context, image_write(context, &img, in_folder(name), options));
    const image *back = read_back(in_folder(name));
    assert_int_equal(back->width, count);
    assert_int_equal(back->channel_count, 3);
    for (size_t i = 0; i < 3 * (size_t)count; ++i) {
        codes[i] = (int)lrintf(255 * ((const float *)back->channels[i % 3].data)[i / 3]);
    }
    image_release(back);
}

/* IEC 61966-2-1. */
static double srgb(double x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055; }
static double srgb_inverse(double v) { return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4); }

UNIT_TEST(srgb_codes_are_exact) {
    enum { COUNT = 30000 };
    static float rgb[3 * COUNT];
    static int codes[3 * COUNT];
    const char *const names[] = {"a.png", "a.tif"};
    fathom_write_options options = defaults();
    for (size_t i = 0; i < 3 * COUNT; ++i) {
        /* Denser towards 0, then each code's own value. */
        double t = (double)i / (3 * COUNT - 1);
        rgb[i] = (float)(i % 4 ? t * t * t : srgb_inverse((double)(i / 4 % 256) / 255));
    }
    for (size_t n = 0; n < 2; ++n) {
        codes_of(rgb, COUNT, names[n], &options, codes);
        for (size_t i = 0; i < 3 * COUNT; ++i) {
            /* Half a code of rounding, and the standard's own rounding of the slope 12.9232 to 12.92: at most
             * 0.0032 · 0.00304 · 255 = 0.00249; 1e-4 for float. */
            assert_near(codes[i], 255 * srgb((double)rgb[i]), 0.5 + 0.0025 + 1e-4);
            if (i % 4 == 0) assert_int_equal(codes[i], i / 4 % 256);
        }
    }
}

UNIT_TEST(odd_values_have_defined_codes) {
    const float rgb[] = {NAN, INFINITY, -INFINITY, -1, 1e30f, 1, 0, 1.0001f, -0.0f};
    const int expected[] = {0, 255, 0, 0, 255, 255, 0, 255, 0};
    int codes[9];
    const char *const views[] = {"sRGB", "Raw"};
    fathom_write_options options = defaults();
    for (size_t v = 0; v < 2; ++v) {
        options.view = views[v];
        codes_of(rgb, 3, "a.png", &options, codes);
        for (size_t i = 0; i < 9; ++i) assert_int_equal(codes[i], expected[i]);
    }
}

/* Exposure is a factor of 2^stops on light: powers of two are exact, so the codes are the same. */
UNIT_TEST(exposure_is_a_factor) {
    float rgb[300], brighter[300];
    int codes[300], expected[300];
    for (size_t i = 0; i < 300; ++i) rgb[i] = (float)i / 900, brighter[i] = 4 * rgb[i];
    fathom_write_options options = defaults();
    codes_of(brighter, 100, "a.png", &options, expected);
    options.exposure = 2;
    codes_of(rgb, 100, "a.png", &options, codes);
    assert_memory_equal(codes, expected, sizeof codes);
    options.exposure = NAN;
    assert_fails(context, image_check(context, in_folder("a.png"), &options), FATHOM_BAD_USAGE,
                 "exposure: nan");
}

UNIT_TEST(the_raw_view_changes_nothing) {
    float rgb[3 * 256];
    int codes[3 * 256];
    for (size_t i = 0; i < 3 * 256; ++i) rgb[i] = (float)i / (3 * 256 - 1);
    fathom_write_options options = defaults();
    options.view = "raw"; /* whatever the case */
    codes_of(rgb, 256, "a.png", &options, codes);
    for (size_t i = 0; i < 3 * 256; ++i) assert_near(codes[i], 255.0 * (double)rgb[i], 0.5 + 1e-4);
}

/* ACES 1.0: grey stays grey, brighter stays brighter, and 18 % grey is shown as 4.8 of 48 nits, above a black
 * of 0.02, with the curve of a dim surround, 0.9811. */
UNIT_TEST(the_aces_view_matches_its_reference) {
    enum { COUNT = 400 };
    float rgb[3 * COUNT];
    int codes[3 * COUNT];
    for (size_t i = 0; i < COUNT; ++i) {
        rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = i ? exp2f(0.1f * (float)i - 20) : 0.18f;
    }
    fathom_write_options options = defaults();
    options.view = "ACES 1.0 SDR";
    codes_of(rgb, COUNT, "a.png", &options, codes);
    double grey = 255 * srgb(pow((4.8 - 0.02) / (48 - 0.02), 0.9811));
    assert_near(codes[0], grey, 1); /* half a code, and the spline's knots have four digits */
    for (size_t i = 0; i < COUNT; ++i) {
        assert_int_equal(codes[3 * i], codes[3 * i + 1]);
        assert_int_equal(codes[3 * i], codes[3 * i + 2]);
        if (i > 1) assert_true(codes[3 * i] >= codes[3 * i - 3]);
    }
    assert_int_equal(codes[3 * COUNT - 1], 255);
}

/* Colours come premultiplied and leave as they are seen through nothing. */
UNIT_TEST(alpha_is_divided_out) {
    const float rgba[3][4] = {{0.25f, 0.125f, 0, 0.5f}, {0.5f, 0.5f, 0.5f, 0}, {0.2f, 1, 2, 1}};
    const char *const names[] = {"R", "G", "B", "A"}, *const files[] = {"a.png", "a.tiff", "a.jpg"};
    image_channel channels[4];
    for (size_t c = 0; c < 4; ++c)
        channels[c] = (image_channel){names[c], IMAGE_FLOAT, true, &rgba[0][c], 16};
    image img = {3, 1, 5, 6, 100, 100, channels, 4, NULL, 0, 0};
    fathom_write_options options = defaults();
    for (size_t f = 0; f < 3; ++f) {
        assert_ok(context, image_write(context, &img, in_folder(files[f]), &options));
        const image *back = read_back(in_folder(files[f]));
        assert_int_equal(back->channel_count, f < 2 ? 4 : 3);
        for (size_t c = 0; f < 2 && c < 4; ++c) {
            for (size_t i = 0; i < 3; ++i) {
                double a = (double)rgba[i][3], v = (double)rgba[i][c];
                double expected = c == 3 ? a : srgb(fmin(1, a > 0 ? v / a : v));
                double found = 255 * (double)((const float *)channel_of(back, names[c])->data)[i];
                assert_near(found, 255 * expected, 0.5 + 0.0026); /* as in srgb_is_exact */
            }
        }
        image_release(back);
    }
}

/* One flat grey: its only coefficient is in steps of 2/8 of a code at quality 95, and rounding twice makes 1.
 */
UNIT_TEST(jpeg_is_close) {
    float rgb[3 * 64];
    int codes[3 * 64];
    for (size_t i = 0; i < 3 * 64; ++i) rgb[i] = 0.3f;
    fathom_write_options options = defaults();
    codes_of(rgb, 64, "a.jpeg", &options, codes);
    for (size_t i = 0; i < 3 * 64; ++i) assert_near(codes[i], 255 * srgb(0.3), 1);
}

UNIT_TEST(small_images_are_written_whole) {
    static float rgb[3 * 200];
    const char *const files[] = {"s.exr", "s.png", "s.jpg", "s.tif"};
    const uint32_t sizes[][2] = {{1, 1}, {200, 1}, {1, 200}, {1, 7}, {17, 11}};
    fathom_write_options options = defaults();
    for (size_t f = 0; f < 4; ++f) {
        for (size_t s = 0; s < 5; ++s) {
            image_channel channels[3];
            image img = rgb_image(sizes[s][0], sizes[s][1], rgb, channels);
            assert_ok(context, image_write(context, &img, in_folder(files[f]), &options));
            const image *back = read_back(in_folder(files[f]));
            assert_int_equal(back->width, sizes[s][0]);
            assert_int_equal(back->height, sizes[s][1]);
            image_release(back);
        }
    }
}

UNIT_TEST(files_do_not_depend_on_thread_count) {
    enum { W = 97, H = 301 };
    static float rgb[3 * W * H];
    for (size_t i = 0; i < 3 * W * H; ++i) rgb[i] = (float)(i * 2654435761u % 65536) / 65536;
    const char *const files[] = {"t.exr", "t.png", "t.jpg"};
    fathom_write_options options = defaults();
    for (size_t f = 0; f < 3; ++f) {
        image_channel channels[3];
        image img = rgb_image(W, H, rgb, channels);
        const image *back[2];
        for (unsigned t = 0; t < 2; ++t) {
            fathom_context_set_threads(context, 1 + 4 * t);
            assert_ok(context, image_write(context, &img, in_folder(files[f]), &options));
            back[t] = read_back(in_folder(files[f]));
        }
        for (size_t c = 0; c < 3; ++c) {
            assert_memory_equal(back[0]->channels[c].data, back[1]->channels[c].data, (size_t)4 * W * H);
        }
        image_release(back[0]), image_release(back[1]);
    }
    fathom_context_set_threads(context, 0);
}

/* ---- FLIP ---- */

/* Rows run from the bottom; three numbers of a pixel lie together. */
static void put_pfm(const char *name, const float *rgb, size_t pixels) {
    FILE *file = fopen(in_folder(name), "wb");
    fprintf(file, "PF\n%zu 1\n-1.0\n", pixels);
    assert_int_equal(fwrite(rgb, sizeof *rgb, 3 * pixels, file), 3 * pixels);
    assert_int_equal(fclose(file), 0);
}

static double flip_between(const char *a, const char *b) {
    const fathom_image *images[2];
    fathom_flip flip = {.size = sizeof flip};
    assert_ok(context, fathom_image_read(context, in_folder(a), &images[0]));
    assert_ok(context, fathom_image_read(context, in_folder(b), &images[1]));
    assert_ok(context, fathom_image_flip(context, images[0], images[1], FATHOM_FLIP_PPD, &flip));
    for (int i = 0; i < 2; ++i) fathom_image_destroy(images[i]);
    return flip.mean;
}

/* The same halfs in both formats. */
UNIT_TEST(flip_takes_pfm_as_linear_like_exr) {
    enum { PIXELS = 16 };
    static const char *const names[2][2] = {{"a.exr", "b.exr"}, {"a.pfm", "b.pfm"}}, *const channels[] = {
                                                                                         "R", "G", "B"};
    const fathom_write_options options = defaults();
    for (int k = 0; k < 2; ++k) {
        float rgb[PIXELS][3];
        image_channel of[3];
        for (int i = 0; i < 3 * PIXELS; ++i) rgb[i / 3][i % 3] = (float)((i * 7 + k * (i % 5)) % 64) / 64;
        for (int c = 0; c < 3; ++c)
            of[c] = (image_channel){channels[c], IMAGE_FLOAT, true, &rgb[0][c], sizeof rgb[0]};
        const image img = {PIXELS, 1, 0, 0, PIXELS, 1, of, 3, NULL, 0, 0};
        assert_ok(context, image_write(context, &img, in_folder(names[0][k]), &options));
        put_pfm(names[1][k], rgb[0], PIXELS);
    }
    const double exr = flip_between("a.exr", "b.exr");
    assert_true(exr > 0 && flip_between("a.pfm", "b.pfm") == exr);
}

UNIT_TEST(a_tolerance_is_a_number) {
    const fathom_image *black;
    fathom_image_difference difference = {.size = sizeof difference};
    put_pfm("a.pfm", (float[3]){0, 0, 0}, 1);
    assert_ok(context, fathom_image_read(context, in_folder("a.pfm"), &black));
    assert_fails(context, fathom_image_compare(context, black, black, NAN, &difference), FATHOM_BAD_USAGE,
                 "tolerance: expected a number >= 0, found nan");
    assert_fails(context, fathom_image_compare(context, black, black, -1, &difference), FATHOM_BAD_USAGE,
                 "tolerance: expected a number >= 0, found -1");
    fathom_image_destroy(black);
}

int main(void) { return unit_main(open_folder, remove_folder); }
