/* What PNG files hold beside their pixels, chunk by chunk, and what goes wrong in writing them. */
#include "base/file.h"
#include "image/output.h"
#include "unit_folder.h"

#include <unistd.h>

static const fathom_write_options usual = {.size = sizeof usual};

static unsigned char file[1 << 16];
static size_t file_size;

static void load(const char *path) {
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    file_size = fread(file, 1, sizeof file, f);
    assert_int_equal(fclose(f), 0);
    assert_in_range(file_size, 8, sizeof file - 1);
    assert_memory_equal(file, "\x89PNG\r\n\x1a\n", 8);
}

static uint32_t big_endian(const unsigned char *at) {
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

/* The data of the n-th chunk of a type, NULL when there are fewer. */
static const unsigned char *chunk(const char *type, size_t n, size_t *size) {
    for (size_t at = 8; at + 12 <= file_size; at += 12 + big_endian(file + at)) {
        if (memcmp(file + at + 4, type, 4) != 0 || n--) continue;
        *size = big_endian(file + at);
        return file + at + 8;
    }
    return NULL;
}

static void assert_chunk(const char *type, size_t n, const void *expected, size_t expected_size) {
    size_t size = 0;
    const unsigned char *data = chunk(type, n, &size);
    assert_non_null(data);
    assert_int_equal(size, expected_size);
    assert_memory_equal(data, expected, size);
}

#define ASSERT_CHUNK(type, n, text) assert_chunk(type, n, text, sizeof(text) - 1)

static const float pixels[2][4] = {{0, 0.25f, 0.5f, 0.5f}, {1, 1, 1, 1}};
static const double number[1] = {3};
static const image_attribute attributes[] = {{"Software", "Fathom test", NULL, 0},
                                             {"fathom:spp", NULL, number, 1},
                                             {"fathom:scene", "caf\xc3\xa9", NULL, 0},
                                             {"fathom:empty", "", NULL, 0}};

static image small(image_channel channels[4], size_t channel_count) {
    const char *const names[] = {"R", "G", "B", "A"};
    for (size_t c = 0; c < 4; ++c)
        channels[c] = (image_channel){names[c], IMAGE_FLOAT, true, &pixels[0][c], 16};
    return (image){2, 1, 7, 8, 100, 100, channels, channel_count, attributes, 4, 0};
}

/* Sizes and kind, sRGB with its intent, and for those who do not know sRGB the gamma 1/2.2 and BT.709; texts
 * as Latin-1, or as UTF-8 where they need it. */
UNIT_TEST(srgb_files_have_srgb_chunks) {
    image_channel channels[4];
    image img = small(channels, 3);
    assert_ok(context, image_write(context, &img, in_folder("a.png"), &usual));
    load(in_folder("a.png"));
    ASSERT_CHUNK("IHDR", 0, "\0\0\0\2\0\0\0\1\10\2\0\0\0");
    ASSERT_CHUNK("sRGB", 0, "\3");
    ASSERT_CHUNK("gAMA", 0, "\0\0\xb1\x8f");
    size_t size;
    const unsigned char *xy = chunk("cHRM", 0, &size);
    const uint32_t rec709[8] = {31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000};
    assert_non_null(xy);
    for (size_t i = 0; i < 8; ++i) assert_int_equal(big_endian(xy + 4 * i), rec709[i]);
    ASSERT_CHUNK("tEXt", 0, "Software\0Fathom test");
    ASSERT_CHUNK("tEXt", 1, "fathom:empty\0");
    ASSERT_CHUNK("iTXt", 0, "fathom:scene\0\0\0\0\0caf\xc3\xa9");
    assert_null(chunk("tEXt", 2, &size));
    assert_non_null(chunk("IEND", 0, &size));

    img.channel_count = 4;
    assert_ok(context, image_write(context, &img, in_folder("a.png"), &usual));
    load(in_folder("a.png"));
    ASSERT_CHUNK("IHDR", 0, "\0\0\0\2\0\0\0\1\10\6\0\0\0");
}

/* Colours of another kind are not called sRGB. */
UNIT_TEST(raw_files_have_no_srgb_chunk) {
    image_channel channels[4];
    image img = small(channels, 3);
    fathom_write_options raw = usual;
    raw.view = "Raw";
    assert_ok(context, image_write(context, &img, in_folder("a.png"), &raw));
    load(in_folder("a.png"));
    size_t size;
    ASSERT_CHUNK("IHDR", 0, "\0\0\0\2\0\0\0\1\10\2\0\0\0");
    assert_null(chunk("sRGB", 0, &size));
    assert_null(chunk("gAMA", 0, &size));
    assert_null(chunk("cHRM", 0, &size));
    ASSERT_CHUNK("tEXt", 0, "Software\0Fathom test");
}

/* libpng has a limit of its own, a million a side, which is lifted. */
UNIT_TEST(long_rows_are_written) {
    image_channel channels[4];
    image img = small(channels, 3);
    for (size_t c = 0; c < 3; ++c) channels[c].stride = 0;
    img.width = img.full_width = 1100000;
    assert_ok(context, image_write(context, &img, in_folder("a.png"), &usual));
    load(in_folder("a.png"));
    assert_int_equal(big_endian(file + 16), 1100000);
}

/* PNG's own limit: libpng's error arrives as a status, and the file that was there stays. */
UNIT_TEST(too_many_rows_are_refused) {
    image_channel channels[4];
    image img = small(channels, 3);
    for (size_t c = 0; c < 3; ++c) channels[c].stride = 0;
    assert_ok(context, image_write(context, &img, in_folder("a.png"), &usual));
    img.width = 1, img.height = 1u << 31;
    assert_fails(context, image_write(context, &img, in_folder("a.png"), &usual), FATHOM_OUT_OF_RESOURCES,
                 "a.png: cannot be written: libpng: ");
    load(in_folder("a.png"));
    assert_int_equal(big_endian(file + 16), 2);
}

/* Given up after its rows: nothing is said, and nothing is kept. */
UNIT_TEST(an_abandoned_file_leaves_nothing) {
    image_channel channels[4];
    const image img = small(channels, 3);
    image_message message = {""};
    image_writer *writer;
    file_writer *out;
    assert_ok(context, file_writer_open_memory(context, "a.png", &out));
    const image_target target = {
        .path = "a.png", .file = out, .format = IMAGE_PNG, .threads = 1, .img = &img};
    assert_int_equal(write_png_calls.open(&target, &writer, &message), FATHOM_OK);
    assert_int_equal(write_png_calls.rows(writer, 1, "abcdef", &message), FATHOM_OK);
    assert_int_equal(write_png_calls.close(writer, false, &message), FATHOM_OK);
    assert_string_equal(message.text, "");
    file_writer_abort(out);
}

int main(void) { return unit_main(open_folder, remove_folder); }
