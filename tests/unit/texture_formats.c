/* Peculiarities of formats of images: channels, the order of rows, how a format is found. */
#include "textures.h"

/* Texels (20, 200) and (255, 0): OpenImageIO gives no name to the alpha of a grey TGA. */
UNIT_TEST(a_grey_tga_has_alpha) {
    static const unsigned char header[18] = {[2] = 3, [12] = 2, [14] = 1, [16] = 16, [17] = 0x28};
    static const unsigned char body[4] = {20, 200, 255, 0};
    put_file("a.tga", header, sizeof header, body, sizeof body);
    check_codes("a.tga", (const unsigned[][4]){{20, 20, 20, 200}, {255, 255, 255, 0}}, 2, 255);
}

/* Radiance's +Y: the first row is the lowest one. */
UNIT_TEST(radiance_files_may_have_their_lowest_row_first) {
    static const char header[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n+Y 2 +X 1\n";
    static const unsigned char rows[8] = {32, 32, 32, 128, 64, 64, 64, 128};
    put_file("a.hdr", header, sizeof header - 1, rows, sizeof rows);
    const fathom_texture t = texture_of("a.hdr", FATHOM_COLOR_LINEAR);
    const image *img;
    float upper[4], lower[4];
    opened o = open_textures(&t, 1, ALL);
    texel(o.cache, 0, 0, 0, 0, upper);
    texel(o.cache, 0, 0, 0, 1, lower);
    assert_true(upper[0] == 2 * lower[0] && lower[0] > 0);
    assert_ok(context, image_read(context, in_folder("a.hdr"), &img));
    assert_memory_equal(img->channels[0].data, upper, sizeof(float));
    image_release(img);
}

/* WebP without loss, of the texels (255, 0, 255, 128) and (0, 255, 0, 255). OpenImageIO 2 multiplies WebP's
 * colours by alpha. */
UNIT_TEST(webp_keeps_its_colors_below_alpha) {
    static const unsigned char bytes[] = {'R',  'I',  'F',  'F',  32,   0,    0,    0,    'W',  'E',
                                          'B',  'P',  'V',  'P',  '8',  'L',  20,   0,    0,    0,
                                          0x2f, 0x01, 0x00, 0x00, 0x10, 0x0f, 0x30, 0xff, 0xfb, 0xbf,
                                          0xff, 0xff, 0x03, 0x0c, 0x0f, 0x54, 0x20, 0xa2, 0xff, 0x01};
    put_file("a.webp", bytes, sizeof bytes, "", 0);
    check_codes("a.webp", (const unsigned[][4]){{255, 0, 255, 128}, {0, 255, 0, 255}}, 2, 255);
}

static const unsigned char sgi[512] = {1, 218, 0, 1, 0, 3, 0, 2, 0, 1, 0, 3, [19] = 255};

/* Planes of red, green and blue. The name says nothing, or something wrong. */
UNIT_TEST(the_content_tells_an_sgi_file) {
    static const char *const names[] = {"a.sgi", "a", "a.png"};
    static const unsigned char planes[6] = {10, 20, 30, 40, 50, 60};
    for (int i = 0; i < 3; ++i) {
        put_file(names[i], sgi, sizeof sgi, planes, sizeof planes);
        check_codes(names[i], (const unsigned[][4]){{10, 30, 50, 255}, {20, 40, 60, 255}}, 2, 255);
    }
}

/* OpenImageIO names only one of its channels. Some of its versions begin a row too late. */
UNIT_TEST(fits_has_three_channels) {
    static const char *const cards[] = {"SIMPLE  =                    T",
                                        "BITPIX  =                    8",
                                        "NAXIS   =                    3",
                                        "NAXIS1  =                    3",
                                        "NAXIS2  =                    2",
                                        "NAXIS3  =                    2",
                                        "END"};
    static const unsigned char body[2880] = {10, 30, 50, 20, 40, 60, 10, 30, 50,
                                             20, 40, 60, 10, 30, 50, 20, 40, 60};
    char header[2880];
    memset(header, ' ', sizeof header);
    for (size_t i = 0; i < sizeof cards / sizeof *cards; ++i)
        memcpy(header + 80 * i, cards[i], strlen(cards[i]));
    put_file("a.fits", header, sizeof header, body, sizeof body);
    check_codes("a.fits", (const unsigned[][4]){{10, 30, 50, 255}, {20, 40, 60, 255}}, 2, 255);
}

/* A reader that allocated the whole image first would run out of memory. OpenImageIO 3 has limits of its own,
 * and words; either names the size. */
UNIT_TEST(images_larger_than_the_limits_are_refused) {
    static const char *const sizes[][2] = {
        {"65537 1", "65537"}, {"1 65537", "65537"}, {"4000000 4000000", "4000000"}};
    for (int i = 0; i < 3; ++i) {
        char header[64];
        const int length = snprintf(header, sizeof header, "P6\n%s\n255\n", sizes[i][0]);
        put_file("a.ppm", header, (size_t)length, "abc", 3);
        const fathom_texture t = texture_of("a.ppm", FATHOM_COLOR_AUTO);
        assert_fails(context, fathom_texture_write(context, &t, in_folder("b.tx")), FATHOM_BAD_INPUT,
                     "a.ppm: cannot be read as a texture: ");
        assert_non_null(strstr(fathom_context_message(context), sizes[i][1]));
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
