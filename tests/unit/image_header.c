/* Headers of EXR files: the same entries by both writers, the module's and the plain one; and images that no
 * format holds. */
#include "image/image.h"
#include "unit_exr.h"
#include "unit_folder.h"

#include <unistd.h>

static const float pixels[6] = {0.25f, 0.5f, 1, 2, 4, 8};
static const image_channel channels[3] = {{"R", IMAGE_FLOAT, true, pixels, 12},
                                          {"G", IMAGE_FLOAT, true, pixels + 1, 12},
                                          {"B", IMAGE_FLOAT, true, pixels + 2, 12}};

enum { MOST = 17 };
static char names[MOST + 1][8];
static double numbers[MOST];

/* 1, 2, 3, 9 and 16 numbers have a type of their own; any other count is a text of numbers. */
static void check_numbers(const char *file, size_t count) {
    static const char *const types[MOST + 1] = {
        [1] = "double", [2] = "v2d", [3] = "v3d", [9] = "m33d", [16] = "m44d"};
    if (types[count]) {
        assert_exr_bytes(file, names[count], types[count], numbers, count * sizeof *numbers);
        return;
    }
    const exr_entry e = exr_entry_of(file, names[count]);
    const char *at = (const char *)e.bytes;
    assert_string_equal(e.type, "string");
    for (size_t i = 0; i < count; ++i) {
        char *end;
        assert_true(strtod(at, &end) == numbers[i]);
        assert_true(end > at && *end == (i + 1 < count ? ' ' : '\0'));
        at = end + 1;
    }
}

UNIT_TEST(attributes_hold_any_count_of_numbers) {
    image_attribute attributes[MOST + 1] = {{"Software", "Fathom test", NULL, 0}};
    for (size_t i = 0; i < MOST; ++i) numbers[i] = i % 2 ? -1.0 / (double)(i + 2) : ldexp(1 + (double)i, 300);
    for (size_t count = 1; count <= MOST; ++count) {
        snprintf(names[count], sizeof names[count], "n%zu", count);
        attributes[count] = (image_attribute){names[count], NULL, numbers, count};
    }
    const image img = {2, 1, 0, 0, 2, 1, channels, 3, attributes, MOST + 1, 0};
    const fathom_write_options options = {.size = sizeof options, .exposure = 0};
    for (int plain = 0; plain < 2; ++plain) {
        if (plain)
            assert_ok(context, exr_write_plain(context, &img, in_folder("a.exr")));
        else
            assert_ok(context, image_write(context, &img, in_folder("a.exr"), &options));
        assert_exr_text(in_folder("a.exr"), "Software", "Fathom test");
        for (size_t count = 1; count <= MOST; ++count) check_numbers(in_folder("a.exr"), count);
        assert_int_equal(unlink(in_folder("a.exr")), 0);
    }
}

UNIT_TEST(impossible_images_are_refused) {
    const fathom_write_options options = {.size = sizeof options, .exposure = 0};
    image img = {2, 1, 0, 0, 2, 1, channels, 3, NULL, 0, 0};
    img.width = 0;
    assert_fails(context, image_write(context, &img, in_folder("a.png"), &options), FATHOM_INTERNAL, "empty");
    img.width = 2, img.height = 0;
    assert_fails(context, image_write(context, &img, in_folder("a.png"), &options), FATHOM_INTERNAL, "empty");
    img.height = 1, img.channel_count = 0;
    assert_fails(context, image_write(context, &img, in_folder("a.png"), &options), FATHOM_INTERNAL, "empty");
    img.channel_count = 3, img.height = 65501;
    assert_fails(context, image_write(context, &img, in_folder("a.jpg"), &options), FATHOM_BAD_USAGE,
                 "2 x 65501 pixels; JPEG holds at most 65500 x 65500");
    img.height = 1, img.width = 65501;
    assert_fails(context, image_write(context, &img, in_folder("a.jpg"), &options), FATHOM_BAD_USAGE,
                 "65501 x 1 pixels");
}

int main(void) { return unit_main(open_folder, remove_folder); }
