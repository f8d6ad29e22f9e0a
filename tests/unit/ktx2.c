/* KTX 2.0 files, against the texels of Basis Universal's transcoder. */
#include "helper/ktx2/ktx2.h"

#include "helper/ktx2/uastc.h"
#include "ktx2_data.h"
#include "ktx2_file.h"

#include <zlib.h>

enum { TEXELS_MAX = 62 * 45 * 4 };
static uint8_t texels[TEXELS_MAX];
static ktx2_image img;
static image_message why;

/* Opens a copy that ends where the file ends, so that AddressSanitizer sees a read beyond, and decodes all of
 * it. */
static fathom_status decode(const uint8_t *file, size_t size) {
    uint8_t *copy = malloc(size ? size : 1);
    ktx2_rows *rows = NULL;
    assert_non_null(copy);
    memcpy(copy, file, size);
    why.text[0] = '\0';
    fathom_status status = ktx2_open(copy, size, &img, &why);
    if (status == FATHOM_OK && (uint64_t)img.width * img.height * img.channels > TEXELS_MAX) {
        free(copy);
        return FATHOM_OK;
    }
    if (status == FATHOM_OK) status = ktx2_rows_open(&img, &rows, &why);
    for (uint32_t y = 0; status == FATHOM_OK && y < img.height; ++y)
        status = ktx2_rows_next(rows, texels + (size_t)y * img.width * img.channels, &why);
    ktx2_rows_close(rows);
    free(copy);
    if (status != FATHOM_OK && !why.text[0]) fail_msg("status %d without a reason", status);
    return status;
}

static void decode_well(const uint8_t *file, size_t size) {
    if (decode(file, size) != FATHOM_OK) fail_msg("%s", why.text);
}

static void assert_refused(const ktx2_recipe *r, const char *reason) {
    uint8_t file[KTX2_FILE_MAX];
    assert_int_equal(decode(file, ktx2_make(r, file)), FATHOM_BAD_INPUT);
    if (!strstr(why.text, reason)) fail_msg("\"%s\" does not hold \"%s\"", why.text, reason);
}

static void assert_texels(const ktx2_recipe *r, uint32_t channels, const uint8_t *expected, size_t size) {
    uint8_t file[KTX2_FILE_MAX];
    decode_well(file, ktx2_make(r, file));
    assert_int_equal(img.channels, channels);
    assert_int_equal((size_t)img.width * img.height * channels, size);
    assert_memory_equal(texels, expected, size);
}

/* FNV-1a, of 64 bits */
static uint64_t hash_texels(size_t size) {
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    for (size_t i = 0; i < size; ++i) hash = (hash ^ texels[i]) * UINT64_C(0x100000001b3);
    return hash;
}

/* ---- UASTC ---- */

static void check_texels(const uint8_t *got, const uint32_t *expected, size_t count, const char *what) {
    for (size_t i = 0; i < count; ++i) {
        const uint8_t *t = got + 4 * i;
        const uint32_t word = (uint32_t)t[0] << 24 | (uint32_t)t[1] << 16 | (uint32_t)t[2] << 8 | t[3];
        if (word != expected[i]) fail_msg("%s: texel %zu is %08x; expected %08x", what, i, word, expected[i]);
    }
}

UNIT_TEST(uastc_blocks_of_each_mode_have_the_texels_of_the_reference) {
    for (size_t i = 0; i < sizeof ktx2_blocks / sizeof *ktx2_blocks; ++i) {
        uint8_t block[KTX2_FILE_MAX], got[16][4];
        assert_int_equal(ktx2_from_hex(ktx2_blocks[i].bytes, block), UASTC_BLOCK);
        assert_true(uastc_decode(block, got));
        check_texels(got[0], ktx2_blocks[i].texels, 16, ktx2_blocks[i].bytes);
    }
}

/* The code 1000101 is reserved. Mode 2 has 30 partitions, mode 3 has 11, mode 7 has 19. */
UNIT_TEST(uastc_blocks_without_a_mode_or_a_partition_are_refused) {
    static const struct {
        unsigned code, at, bits, count;
    } cases[] = {{0x1d, 20, 5, 30}, {0x03, 20, 4, 11}, {0x07, 20, 5, 19}, {0x0f, 28, 5, 30}};
    uint8_t got[16][4], block[UASTC_BLOCK] = {0x45};
    assert_false(uastc_decode(block, got));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        for (unsigned pattern = 0; pattern >> cases[i].bits == 0; ++pattern) {
            const uint64_t word = cases[i].code | (uint64_t)pattern << cases[i].at;
            memset(block, 0, sizeof block);
            for (unsigned k = 0; k < 8; ++k) block[k] = (uint8_t)(word >> (8 * k));
            assert_int_equal(uastc_decode(block, got), pattern < cases[i].count);
        }
    }
    memset(block, 0, sizeof block), block[0] = 0x45;
    const ktx2_recipe r = {
        .width = 4, .height = 4, .model = 166, .channels = "0", .level = block, .level_size = 16};
    assert_refused(&r, "the data of level 0 is broken");
}

/* Cut to odd sizes, whose last blocks are only partly seen. */
UNIT_TEST(uastc_images_are_cut_from_their_blocks) {
    uint8_t level[2][KTX2_FILE_MAX], expected[5 * 3 * 4], joined[32];
    for (unsigned i = 0; i < 2; ++i) ktx2_from_hex(ktx2_blocks[9 + i].bytes, level[i]);
    memcpy(joined, level[0], 16), memcpy(joined + 16, level[1], 16);
    for (unsigned i = 0; i < 15; ++i) {
        const uint32_t t = ktx2_blocks[9 + i % 5 / 4].texels[i / 5 * 4 + i % 5 % 4];
        for (unsigned c = 0; c < 4; ++c) expected[4 * i + c] = (uint8_t)(t >> (24 - 8 * c));
    }
    ktx2_recipe r = {
        .width = 5, .height = 3, .model = 166, .channels = "3", .level = joined, .level_size = 32};
    assert_texels(&r, 4, expected, sizeof expected);
    /* Without alpha, red alone, red and alpha. */
    static const struct {
        const char *channel, *swizzle;
        uint32_t channels;
        uint8_t of[4];
    } cases[] = {{"0", NULL, 3, {0, 1, 2}}, {"4", NULL, 1, {0}}, {"5", "rrrg", 2, {0, 3}}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        uint8_t some[sizeof expected];
        const uint32_t n = cases[k].channels;
        for (unsigned i = 0; i < 15 * n; ++i) some[i] = expected[i / n * 4 + cases[k].of[i % n]];
        r.channels = cases[k].channel;
        r.key = cases[k].swizzle ? "KTXswizzle" : NULL, r.value = cases[k].swizzle;
        assert_texels(&r, n, some, 15 * n);
    }
    r.level_size = 31;
    assert_refused(&r, "level 0 has 31 bytes; expected 32");
}

/* ---- ETC1S ---- */

UNIT_TEST(etc1s_has_the_texels_of_the_reference) {
    uint8_t file[KTX2_FILE_MAX];
    decode_well(file, ktx2_from_hex(ktx2_etc1s_small, file));
    assert_int_equal(img.width * 100 + img.height * 10 + img.channels, 564);
    assert_int_equal(img.transfer, IMAGE_TRANSFER_SRGB);
    check_texels(texels, ktx2_etc1s_small_texels, 30, "etc1s_small");
    decode_well(file, ktx2_from_hex(ktx2_etc1s_large, file));
    assert_int_equal(img.width * 100 + img.height, 6245);
    assert_true(hash_texels(TEXELS_MAX) == KTX2_ETC1S_LARGE_HASH);
}

/* ---- packed levels ---- */

UNIT_TEST(zstandard_unpacks_or_is_named_as_missing) {
    uint8_t file[KTX2_FILE_MAX];
    const fathom_status status = decode(file, ktx2_from_hex(ktx2_uastc_zstd, file));
#ifdef FATHOM_ZSTD
    if (status != FATHOM_OK) fail_msg("%s", why.text);
    assert_true(hash_texels(12 * 8 * 4) == KTX2_UASTC_ZSTD_HASH);
#else
    assert_int_equal(status, FATHOM_BAD_INPUT);
    assert_non_null(strstr(why.text, "but this Fathom was built without it; build it with libzstd-dev"));
#endif
}

UNIT_TEST(zlib_unpacks_to_what_was_packed) {
    uint8_t level[48], packed[128];
    uLongf size = sizeof packed;
    for (unsigned i = 0; i < sizeof level; ++i) level[i] = (uint8_t)(i * 5);
    assert_int_equal(compress(packed, &size, level, sizeof level), Z_OK);
    ktx2_recipe r = {.format = 29,
                     .width = 8,
                     .height = 2,
                     .scheme = 3,
                     .model = 1,
                     .channels = "012",
                     .level = packed,
                     .level_size = size,
                     .unpacked_size = sizeof level};
    assert_texels(&r, 3, level, sizeof level);
    r.level_size = size - 5;
    assert_refused(&r, "cannot be unpacked by zlib");
    r.unpacked_size = 47;
    assert_refused(&r, "level 0 has 47 bytes; expected 48");
}

/* ---- plain texels ---- */

UNIT_TEST(plain_texels_are_taken_as_they_are) {
    static const uint8_t level[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    static const struct {
        uint32_t format;
        const char *channels, *swizzle;
        uint32_t sent;
        uint8_t texels[8];
        size_t size; /* of two texels, in the file */
    } cases[] = {{9, "0", NULL, 1, {1, 2}, 2},
                 {15, "0", "rrr1", 1, {1, 2}, 2},
                 {9, "0", "r001", 3, {1, 0, 0, 2, 0, 0}, 2},
                 {16, "01", "rrrg", 2, {1, 2, 3, 4}, 4},
                 {23, "012", NULL, 3, {1, 2, 3, 4, 5, 6}, 6},
                 {30, "012", NULL, 3, {3, 2, 1, 6, 5, 4}, 6},
                 {43, "012?", NULL, 4, {1, 2, 3, 4, 5, 6, 7, 8}, 8},
                 {44, "012?", NULL, 4, {3, 2, 1, 4, 7, 6, 5, 8}, 8},
                 {37, "012?", "bgr1", 3, {3, 2, 1, 7, 6, 5}, 8},
                 {37, "012?", "gggg", 2, {2, 2, 6, 6}, 8}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const ktx2_recipe r = {.format = cases[i].format,
                               .width = 2,
                               .height = 1,
                               .model = 1,
                               .channels = cases[i].channels,
                               .key = cases[i].swizzle ? "KTXswizzle" : NULL,
                               .value = cases[i].swizzle,
                               .level = level,
                               .level_size = cases[i].size};
        assert_texels(&r, cases[i].sent, cases[i].texels, 2 * cases[i].sent);
    }
}

/* ---- refusals ---- */

UNIT_TEST(formats_that_are_not_read_are_named) {
    static const uint8_t level[16] = {0};
    const ktx2_recipe good = {.format = 37,
                              .width = 2,
                              .height = 2,
                              .model = 1,
                              .channels = "012?",
                              .level = level,
                              .level_size = 16};
    ktx2_recipe r = good;
    r.faces = 6;
    assert_refused(&r, "is a cube map; expected one flat image");
    r = good, r.layers = 2;
    assert_refused(&r, "is an array of images; expected one flat image");
    r = good, r.depth = 1;
    assert_refused(&r, "is a 3D texture; expected one flat image");
    r = good, r.height = 0;
    assert_refused(&r, "is no flat image; expected one flat image");
    r = good, r.format = 145;
    assert_refused(&r, "vkFormat is 145 (BC7); expected ETC1S, UASTC LDR 4x4, or plain channels of 8 bits");
    r = good, r.format = 1000066000;
    assert_refused(&r, "(ASTC HDR)");
    r = good, r.format = 0, r.model = 167;
    assert_refused(&r, "the color model is 167 (UASTC HDR); expected 163 (ETC1S) or 166");
    r = good, r.model = 4;
    assert_refused(&r, "the color model is 4; expected 1, for vkFormat 37");
    r = good, r.channels = "012";
    assert_refused(&r, "has 3 channels; expected 4");
    r = good, r.scheme = 9;
    assert_refused(&r, "the supercompression scheme is 9; expected 0 (none), 1 (BasisLZ), 2 (Zstandard)");
    r = good, r.scheme = 1;
    assert_refused(&r, "only ETC1S is packed by BasisLZ");
    r = good, r.format = 0, r.model = 163, r.channels = "0";
    assert_refused(&r, "ETC1S is not packed by BasisLZ");
    r.channels = "0?", r.model = 166;
    assert_refused(&r, "the channels of UASTC are none of");
    r = good, r.format = 16, r.channels = "01", r.level_size = 8;
    assert_refused(&r, "has the channels red and green alone; expected grey");
    r = good, r.key = "KTXorientation", r.value = "ld";
    assert_refused(&r, "KTXorientation is \"ld\"; expected \"rd\" or \"ru\"");
    r.key = "KTXswizzle", r.value = "rgb";
    assert_refused(&r, "KTXswizzle is \"rgb\"; expected four of r, g, b, a, 0, 1");
    r.key = "other";
    uint8_t file[KTX2_FILE_MAX];
    decode_well(file, ktx2_make(&r, file));
}

/* ---- broken files ---- */

static size_t load(unsigned i, uint8_t file[KTX2_FILE_MAX]) {
    static uint8_t level[16] = {0x45};
    static const char *const texts[] = {ktx2_etc1s_small, ktx2_etc1s_large, ktx2_uastc_zstd};
    if (i < 3) return ktx2_from_hex(texts[i], file);
    ktx2_from_hex(ktx2_blocks[3].bytes, file);
    memcpy(level, file, sizeof level);
    return ktx2_make(&(ktx2_recipe){.width = 4,
                                    .height = 3,
                                    .model = 166,
                                    .channels = "0",
                                    .key = "KTXswizzle",
                                    .value = "rgb1",
                                    .level = level,
                                    .level_size = 16},
                     file);
}

UNIT_TEST(cut_files_are_refused) {
    for (unsigned i = 0; i < 4; ++i) {
        uint8_t file[KTX2_FILE_MAX];
        const size_t size = load(i, file);
        for (size_t cut = 0; cut < size; ++cut) assert_int_equal(decode(file, cut), FATHOM_BAD_INPUT);
    }
}

UNIT_TEST(changed_files_are_read_or_refused) {
    for (unsigned i = 0; i < 4; ++i) {
        uint8_t file[KTX2_FILE_MAX];
        const size_t size = load(i, file);
        for (size_t bit = 0; bit < 8 * size; ++bit) {
            file[bit / 8] ^= (uint8_t)(1u << bit % 8);
            const fathom_status status = decode(file, size);
            assert_true(status == FATHOM_OK || status == FATHOM_BAD_INPUT);
            file[bit / 8] ^= (uint8_t)(1u << bit % 8);
        }
    }
}

int main(void) { return unit_main(NULL, NULL); }
