/* Images of so many bytes that their rows are handed to the file in chunks: every row is in its place. */
#include "defaults.h"
#include "image/image.h"
#include "unit_folder.h"

#include <unistd.h>

/* Three floats a pixel: a row is three quarters of a megabyte, and a chunk is 64 of them. */
#define WIDTH 65536u
#define HEIGHT 70u

/* A half holds it as it is. */
static float value_at(uint32_t x, uint32_t y) { return (float)((x + 131 * y) % 1024) / 1024; }

UNIT_TEST(rows_keep_their_place_across_chunks) {
    fathom_write_options options = default_write_options();
    options.float_color = true;
    float *values = unit_memory((size_t)WIDTH * HEIGHT * sizeof *values);
    for (uint32_t y = 0; y < HEIGHT; ++y) {
        for (uint32_t x = 0; x < WIDTH; ++x) values[(size_t)y * WIDTH + x] = value_at(x, y);
    }
    const image_channel channels[] = {{"R", IMAGE_FLOAT, true, values, sizeof *values},
                                      {"G", IMAGE_FLOAT, true, values, sizeof *values},
                                      {"B", IMAGE_FLOAT, true, values, sizeof *values}};
    const image img = {WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT, channels, 3, NULL, 0, 0};
    assert_ok(context, image_write(context, &img, in_folder("a.exr"), &options));
    const image *back;
    assert_ok(context, image_read(context, in_folder("a.exr"), &back));
    assert_true(back->width == WIDTH && back->height == HEIGHT && back->channel_count == 3);
    for (size_t c = 0; c < 3; ++c) {
        const float *read = back->channels[c].data;
        for (uint32_t y = 0; y < HEIGHT; ++y) {
            for (uint32_t x = 0; x < WIDTH; ++x) {
                if (read[(size_t)y * WIDTH + x] != value_at(x, y)) fail_msg("channel %zu at %u,%u", c, x, y);
            }
        }
    }
    image_release(back);
}

int main(void) { return unit_main(open_folder, remove_folder); }
