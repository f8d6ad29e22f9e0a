/* EXR files, as OpenImageIO reads them back: images of several blocks, of what cannot be compressed, with
 * long names, and by any number of threads. */
#include "base/file.h"
#include "image/output.h"
#include "unit_folder.h"

#include <sys/stat.h>
#include <unistd.h>

enum { MOST_WIDTH = 700, MOST_HEIGHT = 70 };
static float smooth[MOST_HEIGHT * MOST_WIDTH], noise[MOST_HEIGHT * MOST_WIDTH];
static uint32_t ids[MOST_HEIGHT * MOST_WIDTH];

static void fill_planes(void) {
    for (uint32_t i = 0; i < MOST_HEIGHT * MOST_WIDTH; ++i) {
        const uint32_t random = (i + 1) * 2654435761u ^ i * 2246822519u,
                       bits = (random & 0x7fffffu) | 0x3f800000u;
        smooth[i] = (float)(i / 64) / 512;
        memcpy(&noise[i], &bits, sizeof bits);
        ids[i] = i / 100;
    }
}

/* Longer than 31 letters, which the format has a flag for. */
#define LONG_NAME "light_of_the_large_window_to_the_north.R"

/* Not in the order of the file. */
static const image_channel channels[] = {
    {"R", IMAGE_FLOAT, true, smooth, 4}, {"G", IMAGE_FLOAT, true, smooth, 4},
    {"B", IMAGE_FLOAT, true, noise, 4},  {LONG_NAME, IMAGE_FLOAT, false, smooth, 4},
    {"Z", IMAGE_FLOAT, false, noise, 4}, {"id.object.V", IMAGE_UINT, false, ids, 4}};
enum { CHANNELS = sizeof channels / sizeof *channels };

static image of_size(uint32_t width, uint32_t height) {
    return (image){width, height, 5, 7, 5 + width, 7 + height, channels, CHANNELS, NULL, 0, 0};
}

static void write_with(const image *img, const char *path, const exr_options *options) {
    file_writer *file;
    assert_ok(context, file_writer_open(context, path, &file));
    assert_ok(context, exr_put(context, file, img, options));
    assert_ok(context, file_writer_commit(file));
}

static void check_plane(const image *back, const image_channel *expected, size_t count) {
    const image_channel *found = NULL;
    for (size_t i = 0; i < back->channel_count; ++i) {
        if (strcmp(back->channels[i].name, expected->name) == 0) found = &back->channels[i];
    }
    assert_non_null(found);
    assert_int_equal(found->type, expected->type);
    assert_memory_equal(found->data, expected->data, 4 * count);
}

/* The floats come back bit for bit. */
static void check_file(const char *path, const image *img) {
    const image *back;
    assert_ok(context, image_read(context, path, &back));
    assert_int_equal(back->width, img->width);
    assert_int_equal(back->height, img->height);
    assert_int_equal(back->x, 5);
    assert_int_equal(back->y, 7);
    assert_int_equal(back->channel_count, CHANNELS);
    for (size_t c = 0; c < CHANNELS; ++c) check_plane(back, &channels[c], (size_t)img->width * img->height);
    image_release(back);
}

/* Blocks have 16 rows: one block, whole blocks, and a last block of one row and of fifteen. */
UNIT_TEST(every_size_comes_back) {
    static const uint32_t heights[] = {1, 15, 16, 17, 32, 47, 70}, widths[] = {1, 2, 3, 64, 700};
    const exr_options ways[] = {{.float_color = true, .compressed = true, .threads = 1},
                                {.float_color = true, .compressed = true, .threads = 3},
                                {.float_color = true, .threads = 1}};
    for (size_t i = 0; i < sizeof heights / sizeof *heights; ++i) {
        for (size_t j = 0; j < sizeof widths / sizeof *widths; ++j) {
            const image img = of_size(widths[j], heights[i]);
            for (size_t k = 0; k < sizeof ways / sizeof *ways; ++k) {
                write_with(&img, in_folder("a.exr"), &ways[k]);
                check_file(in_folder("a.exr"), &img);
            }
        }
    }
}

static size_t word_length(const unsigned char *at) { return strlen((const char *)at); }

/* The end of a header, which is a list of attributes: a name, a type, a size and its bytes. */
static const unsigned char *after_header(const unsigned char *at) {
    for (at += 8; *at;) {
        uint32_t size;
        at += word_length(at) + 1;
        at += word_length(at) + 1;
        memcpy(&size, at, sizeof size);
        at += sizeof size + size;
    }
    return at + 1;
}

static unsigned char *bytes_of(const char *path, size_t *size) {
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    *size = (size_t)info.st_size;
    unsigned char *bytes = malloc(*size);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, *size, file), *size);
    assert_int_equal(fclose(file), 0);
    return bytes;
}

/* OpenEXR's library does without the flag of long names and the table of offsets; other readers need them. */
UNIT_TEST(strict_readers_find_all) {
    const exr_options zip = {.compressed = true, .threads = 2};
    image img = of_size(64, 40);
    for (img.channel_count = CHANNELS; img.channel_count >= 3; img.channel_count -= CHANNELS - 3) {
        size_t size;
        uint32_t version, row;
        write_with(&img, in_folder("a.exr"), &zip);
        unsigned char *bytes = bytes_of(in_folder("a.exr"), &size);
        memcpy(&version, bytes + 4, sizeof version);
        assert_int_equal(version, img.channel_count > 3 ? 2 | 0x400 : 2);
        const unsigned char *table = after_header(bytes);
        for (uint32_t block = 0; block < 3; ++block) {
            uint64_t offset;
            memcpy(&offset, table + 8 * block, sizeof offset);
            assert_in_range(offset, table + 24 - bytes, size - 8);
            memcpy(&row, bytes + offset, sizeof row);
            assert_int_equal(row, 7 + 16 * block);
        }
        free(bytes);
    }
}

static off_t size_of(const char *path) {
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    return info.st_size;
}

/* Smooth planes shrink. Noise does not, and its blocks are stored as they are: 8 bytes and an entry of the
 * table for each block, beside the pixels. */
UNIT_TEST(only_what_shrinks_is_compressed) {
    const exr_options zip = {
        .float_color = true, .compressed = true, .threads = 1, .date = "2026:01:01 00:00:00"};
    image img = of_size(MOST_WIDTH, 64);
    const off_t pixels = 4 * MOST_WIDTH * 64;
    img.channels = &channels[0], img.channel_count = 1;
    write_with(&img, in_folder("a.exr"), &zip);
    assert_true(size_of(in_folder("a.exr")) < pixels / 8);
    static uint32_t bits[MOST_WIDTH * 64];
    uint64_t random = 1;
    for (size_t i = 0; i < MOST_WIDTH * 64; ++i) {
        random = random * 6364136223846793005u + 1442695040888963407u;
        bits[i] = (uint32_t)(random >> 32);
    }
    const image_channel hopeless = {"id.object.V", IMAGE_UINT, false, bits, 4};
    img.channels = &hopeless;
    write_with(&img, in_folder("a.exr"), &zip);
    const off_t size = size_of(in_folder("a.exr")), blocks = 4;
    assert_true(size > pixels + 16 * blocks && size < pixels + 16 * blocks + 1000); /* the header */
    const image *back;
    assert_ok(context, image_read(context, in_folder("a.exr"), &back));
    assert_memory_equal(back->channels[0].data, bits, sizeof bits);
    image_release(back);
}

UNIT_TEST(threads_make_the_same_file) {
    const image img = of_size(MOST_WIDTH, MOST_HEIGHT);
    const char *const names[] = {"1.exr", "2.exr"};
    unsigned char *bytes[2];
    size_t sizes[2];
    for (unsigned i = 0; i < 2; ++i) {
        const exr_options options = {.compressed = true, .threads = 1 + 4 * i, .date = "2026:01:01 00:00:00"};
        write_with(&img, in_folder(names[i]), &options);
        bytes[i] = bytes_of(in_folder(names[i]), &sizes[i]);
    }
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(bytes[0], bytes[1], sizes[0]);
    free(bytes[0]), free(bytes[1]);
}

int main(void) {
    fill_planes();
    return unit_main(open_folder, remove_folder);
}
