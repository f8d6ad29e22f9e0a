/* The built-in sRGB view is that of OpenColorIO's config, to the last bit; files in it need no image module.
 */
#include "image/helper/helper.h"
#include "image/pack.h"
#include "unit.h"

static fathom_context *context;
static image_view *view;
static srgb_codes codes;

enum { COUNT = 4096 };

/* Codes of `count` values, at most COUNT, by the module. */
static void expect(const float *values, size_t count, unsigned char *out) {
    static float rgba[4 * COUNT];
    image_message message = {""};
    for (size_t i = 0; i < count; ++i) {
        for (size_t c = 0; c < 4; ++c) rgba[4 * i + c] = values[i];
    }
    assert_int_equal(image_calls.view_apply(view, 1, rgba, count, &message), FATHOM_OK);
    for (size_t i = 0; i < count; ++i) out[i] = byte_from_float(rgba[4 * i]);
}

static unsigned char expect_one(float value) {
    unsigned char out;
    expect(&value, 1, &out);
    return out;
}

static float from_bits(uint32_t bits) {
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* The least float whose code by the module is above `code`, as bits: positive floats are ordered like them.
 */
static uint32_t step_of_module(unsigned code) {
    uint32_t below = 0, above = 0x3f800000u;
    while (above - below > 1) {
        uint32_t middle = below + (above - below) / 2;
        if (expect_one(from_bits(middle)) > code)
            above = middle;
        else
            below = middle;
    }
    return above;
}

/* Between two steps the code does not change: with the steps the same, all is. */
UNIT_TEST(every_step_agrees_with_opencolorio) {
    for (unsigned code = 0; code < 255; ++code) {
        uint32_t step = step_of_module(code);
        assert_int_equal(srgb_code(&codes, from_bits(step)), code + 1);
        assert_int_equal(srgb_code(&codes, from_bits(step - 1)), code);
        /* Powers in float may step back and forth: not here. */
        float around[64];
        unsigned char expected[64];
        for (uint32_t i = 0; i < 64; ++i) around[i] = from_bits(step - 32 + i);
        expect(around, 64, expected);
        for (size_t i = 0; i < 64; ++i) assert_int_equal(srgb_code(&codes, around[i]), expected[i]);
    }
}

/* Values from all over the floats, and of each bucket the ends. */
UNIT_TEST(all_floats_agree_with_opencolorio) {
    static float values[COUNT];
    static unsigned char expected[COUNT];
    for (uint32_t i = 0; i < SRGB_BUCKETS; ++i) {
        uint32_t first = (SRGB_FIRST_BUCKET + i) << 16;
        values[2 * i] = from_bits(first), values[2 * i + 1] = from_bits(first - 1);
    }
    expect(values, (size_t)2 * SRGB_BUCKETS, expected);
    for (size_t i = 0; i < (size_t)2 * SRGB_BUCKETS; ++i)
        assert_int_equal(srgb_code(&codes, values[i]), expected[i]);
    uint32_t bits = 0;
    for (unsigned round = 0; round < 256; ++round) {
        for (size_t i = 0; i < COUNT; ++i, bits += 0xfffu) {
            values[i] = from_bits(bits);
            if (!(fabsf(values[i]) <= 65504)) values[i] = 0.5f; /* not for views; see below */
        }
        expect(values, COUNT, expected);
        for (size_t i = 0; i < COUNT; ++i) assert_int_equal(srgb_code(&codes, values[i]), expected[i]);
    }
}

/* Rows through both, with what no view is given as it is: infinities, NaN, 1e38; gains, and alphas to divide
 * by. */
UNIT_TEST(rows_agree_with_opencolorio) {
    enum { WIDTH = 512 };
    static float rgba[WIDTH][4], scratch[4 * WIDTH];
    const float odd[] = {NAN, INFINITY, -INFINITY, 1e38f, -1e38f, -0.0f, 65504, 1, 0, -0.25f, 0x1p-149f};
    const float alphas[] = {1, 0, 0.5f, 1e-30f, 2, NAN, -1, INFINITY, 0.7f};
    uint32_t random = 1;
    for (size_t i = 0; i < WIDTH; ++i) {
        for (size_t c = 0; c < 3; ++c) {
            random = random * 1664525u + 1013904223u;
            float light = (float)(random >> 8) * 0x1p-24f;
            rgba[i][c] = random % 5 ? light * light : odd[random / 5 % 11];
        }
        rgba[i][3] = alphas[i % 9];
    }
    const char *const names[] = {"R", "G", "B", "A"};
    image_channel channels[4];
    for (size_t c = 0; c < 4; ++c)
        channels[c] = (image_channel){names[c], IMAGE_FLOAT, true, &rgba[0][c], 16};
    image img = {WIDTH, 1, 0, 0, WIDTH, 1, channels, 4, NULL, 0, 0};
    for (img.channel_count = 3; img.channel_count <= 4; ++img.channel_count) {
        for (int stops = -8; stops <= 8; ++stops) {
            image_packing packing = {&img, exp2f((float)stops * 0.7f), &codes};
            unsigned char ours[4 * WIDTH], theirs[4 * WIDTH];
            image_message message = {""};
            pack_row_srgb(&packing, 0, ours);
            pack_row_for_view(&packing, 0, scratch);
            assert_int_equal(image_calls.view_apply(view, 2, scratch, WIDTH, &message), FATHOM_OK);
            pack_row_from_view(&packing, 0, scratch, theirs);
            assert_memory_equal(ours, theirs, WIDTH * img.channel_count);
        }
    }
}

/* Decided by the names alone. */
UNIT_TEST(only_exr_and_srgb_png_need_no_helper) {
    fathom_write_options options = {.size = sizeof options};
    assert_false(image_needs_module("a.png", &options));
    assert_false(image_needs_module("a.txt", &options)); /* nor can it be written */
    assert_false(image_needs_module("a.exr", &options));
    assert_true(image_needs_module("a.jpg", &options));
    options.display = "srgb", options.view = "SRGB";
    assert_false(image_needs_module("a.PNG", &options));
    options.view = "Raw";
    assert_true(image_needs_module("a.png", &options));
    options.view = NULL, options.display = "P3";
    assert_true(image_needs_module("a.png", &options));
    options.display = NULL, options.ocio = "any.ocio";
    assert_true(image_needs_module("a.png", &options));
    options.ocio = NULL;
    setenv("OCIO", "any.ocio", 1);
    assert_true(image_needs_module("a.png", &options));
    setenv("OCIO", "", 1);
    assert_false(image_needs_module("a.png", &options));
    unsetenv("OCIO");
}

static int open_view(void **state) {
    (void)state;
    unsetenv("OCIO");
    if (fathom_context_create(&context) != FATHOM_OK) return -1;
    image_view_request request = {NULL, NULL, NULL};
    image_message message = {""};
    bool srgb = false;
    srgb_codes_fill(&codes);
    return image_calls.view_open(&request, &view, &srgb, &message) == FATHOM_OK && srgb ? 0 : -1;
}

static int close_view(void **state) {
    (void)state;
    image_calls.view_close(view);
    fathom_context_destroy(context);
    return 0;
}

int main(void) { return unit_main(open_view, close_view); }
