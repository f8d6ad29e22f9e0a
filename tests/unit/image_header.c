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

UNIT_TEST(attributes_hold_texts_and_numbers) {
    double numbers[16];
    float floats[16];
    for (int i = 0; i < 16; ++i)
        numbers[i] = i % 2 ? -1.0 / (i + 2) : ldexp(1 + i, 60), floats[i] = (float)numbers[i];
    const image_attribute attributes[] = {{"Software", "Fathom test", NULL, 0},
                                          {"one", NULL, numbers, 1},
                                          {"three", NULL, numbers, 3},
                                          {"matrix", NULL, numbers, 16}};
    const image img = {2, 1, 0, 0, 2, 1, channels, 3, attributes, 4, 0};
    const fathom_write_options options = {.size = sizeof options, .exposure = 0};
    const char *file = in_folder("a.exr");
    for (int plain = 0; plain < 2; ++plain) {
        if (plain)
            assert_ok(context, exr_write_plain(context, &img, file));
        else
            assert_ok(context, image_write(context, &img, file, &options));
        assert_exr_text(file, "Software", "Fathom test");
        assert_exr_bytes(file, "one", "double", numbers, sizeof *numbers);
        assert_exr_bytes(file, "three", "v3d", numbers, 3 * sizeof *numbers);
        assert_exr_bytes(file, "matrix", "m44f", floats, sizeof floats);
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
