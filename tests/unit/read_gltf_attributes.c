/* Version 1 of the attribute codec of KHR_meshopt_compression, and its filter COLOR, against an encoder that
 * is written from the same specification and picks every way to code at random. */
#include "random.h"
#include "read/gltf/gltf_data.h"
#include "unit.h"

#include <stdbool.h>

enum { MOST = 600, WIDEST = 256, ROOM = 2 * MOST * WIDEST };

/* How often the encoder used what; [0]: control mode 0, [1]: 1. */
static unsigned control_uses[4], width_uses[2][4], mode_uses[3], turn_uses[16], follow_uses[3];

typedef struct encoder {
    random_state random;
    unsigned char bytes[ROOM];
    size_t size;
} encoder;

static unsigned below(encoder *e, unsigned limit) { return (unsigned)(random_bits(&e->random) % limit); }

static void put(encoder *e, unsigned byte) { e->bytes[e->size++] = (unsigned char)byte; }

static void put_codes(encoder *e, unsigned bits, const unsigned char d[16]) {
    const unsigned follows = (1u << bits) - 1, each = 8 / bits;
    for (unsigned i = 0; i < 16; i += each) {
        unsigned byte = 0;
        for (unsigned k = 0; k < each; ++k) {
            const unsigned code = d[i + k] < follows ? d[i + k] : follows;
            byte |= code << (bits == 1 ? k : 8 - bits * (k + 1));
        }
        put(e, byte);
    }
    for (unsigned i = 0; i < 16; ++i) {
        if (d[i] < follows) continue;
        ++follow_uses[bits / 2];
        put(e, d[i]);
    }
}

/* One byte of `count` elements; d is padded with zeros to whole groups. */
static void put_bytes(encoder *e, unsigned control, size_t count, const unsigned char *d) {
    static const unsigned bits[2][4] = {{0, 1, 2, 4}, {1, 2, 4, 8}};
    const size_t groups = (count + 15) / 16, header = e->size;
    ++control_uses[control];
    if (control == 3)
        for (size_t i = 0; i < count; ++i) put(e, d[i]);
    if (control >= 2) return;
    for (size_t i = 0; i < (groups + 3) / 4; ++i) put(e, 0);
    for (size_t g = 0; g < groups; ++g, d += 16) {
        static const unsigned char zeros[16];
        const unsigned first = control == 0 && memcmp(d, zeros, 16) != 0, way = first + below(e, 4 - first);
        ++width_uses[control][way];
        e->bytes[header + g / 4] |= (unsigned char)(way << g % 4 * 2);
        if (bits[control][way] == 8)
            for (unsigned i = 0; i < 16; ++i) put(e, d[i]);
        else if (bits[control][way])
            put_codes(e, bits[control][way], d);
    }
}

/* The difference of 4 bytes to the element before, as 4 bytes. */
static void difference(unsigned mode, const unsigned char *now, const unsigned char *before,
                       unsigned char out[4]) {
    if (mode == 0)
        for (int k = 0; k < 4; ++k) {
            const unsigned d = (now[k] - (unsigned)before[k]) & 255;
            out[k] = (unsigned char)(d & 128 ? ~(d << 1) : d << 1);
        }
    if (mode == 1)
        for (int k = 0; k < 4; k += 2) {
            const unsigned d = (now[k] + now[k + 1] * 256u - before[k] - before[k + 1] * 256u) & 65535;
            const unsigned code = d & 32768 ? ~(d << 1) : d << 1;
            out[k] = (unsigned char)code, out[k + 1] = (unsigned char)(code >> 8);
        }
    if (mode >= 2) {
        const unsigned turn = mode >> 4;
        uint32_t d = 0;
        for (int k = 4; k-- > 0;) d = d << 8 | (uint32_t)(now[k] ^ before[k]);
        d = turn ? d << turn | d >> (32 - turn) : d;
        for (int k = 0; k < 4; ++k) out[k] = (unsigned char)(d >> 8 * k);
    }
}

static void put_block(encoder *e, const unsigned char *modes, const unsigned char *before, size_t count,
                      size_t stride, const unsigned char *from) {
    static unsigned char d[WIDEST][272];
    unsigned char controls[WIDEST / 4] = {0};
    memset(d, 0, sizeof d);
    for (size_t i = 0; i < count; before = from + i++ * stride)
        for (size_t k = 0; k < stride; k += 4) {
            unsigned char four[4];
            difference(modes[k / 4], from + i * stride + k, before + k, four);
            for (size_t j = 0; j < 4; ++j) d[k + j][i] = four[j];
        }
    const size_t at = e->size;
    for (size_t k = 0; k < stride / 4; ++k) put(e, 0);
    for (size_t k = 0; k < stride; ++k) {
        static const unsigned char zeros[256];
        unsigned control = below(e, 4);
        if (control == 2 && memcmp(d[k], zeros, count) != 0) control = 3;
        controls[k / 4] |= (unsigned char)(control << k % 4 * 2);
        put_bytes(e, control, count, d[k]);
    }
    memcpy(e->bytes + at, controls, stride / 4);
}

static void encode(encoder *e, size_t count, size_t stride, const unsigned char *elements) {
    unsigned char first[WIDEST], modes[WIDEST / 4];
    const size_t fit = (8192 / stride) & ~(size_t)15, most = fit < 256 ? fit : 256;
    for (size_t k = 0; k < stride; ++k) first[k] = (unsigned char)(elements[k] - (k % 3 ? 1u : 0u));
    for (size_t k = 0; k < stride / 4; ++k) {
        const unsigned mode = below(e, 3), turn = mode == 2 ? below(e, 16) : 0;
        modes[k] = (unsigned char)(mode | turn << 4);
        ++mode_uses[mode];
        if (mode == 2) ++turn_uses[turn];
    }
    e->size = 0;
    put(e, 0xa1);
    for (size_t i = 0; i < count; i += most)
        put_block(e, modes, i ? elements + (i - 1) * stride : first, count - i < most ? count - i : most,
                  stride, elements + i * stride);
    for (size_t k = stride + stride / 4; k < 24; ++k) put(e, 0);
    for (size_t k = 0; k < stride; ++k) put(e, first[k]);
    for (size_t k = 0; k < stride / 4; ++k) put(e, modes[k]);
}

/* Elements whose bytes stay, step or jump. */
static void make_elements(random_state *r, size_t count, size_t stride, unsigned char *out) {
    unsigned kind = 0;
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < stride; ++k) {
            const unsigned before = i ? out[(i - 1) * stride + k] : 128;
            const unsigned step = (unsigned)random_bits(r);
            if (i % 16 == 0 || k % 4 == 0) kind = (unsigned)random_bits(r) % 3;
            out[i * stride + k] = (unsigned char)(before + (kind == 0 ? 0 : kind == 1 ? step % 5 - 2 : step));
        }
}

static encoder coded;
static unsigned char elements[MOST * WIDEST], decoded[MOST * WIDEST];

UNIT_TEST(every_way_to_code_gives_back_the_elements) {
    for (unsigned n = 0; n < 300; ++n) {
        const size_t stride = 4 * (1 + below(&coded, n % 2 ? 64 : 4)), count = 1 + below(&coded, MOST);
        make_elements(&coded.random, count, stride, elements);
        encode(&coded, count, stride, elements);
        const char *wrong = gltf_attributes_decode(coded.bytes, coded.size, count, stride, decoded);
        if (wrong) fail_msg("%zu elements of %zu bytes: %s", count, stride, wrong);
        assert_memory_equal(decoded, elements, count * stride);
    }
    for (int i = 0; i < 4; ++i) assert_true(control_uses[i] && width_uses[0][i] && width_uses[1][i]);
    for (int i = 0; i < 3; ++i) assert_true(mode_uses[i] && follow_uses[i]);
    for (int i = 0; i < 16; ++i) assert_true(turn_uses[i]);
}

/* The specification's example of 4 bits, in byte 0 of 16 elements; the other bytes do not change. */
UNIT_TEST(the_example_of_the_specification_has_its_differences) {
    static const unsigned char stream[37] = {0xa1, 0xa8, 3,    0x17, 0x5f,      0xf0, 0xbc, 0x77, 0xa9,
                                             0x21, 0,    0x34, 0xb5, [32] = 10, 20,   30,   40,   0};
    static const int differences[16] = {-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0};
    int value = 10;
    assert_null(gltf_attributes_decode(stream, sizeof stream, 16, 4, decoded));
    for (size_t i = 0; i < 16; ++i) {
        value += differences[i];
        const unsigned char expected[4] = {(unsigned char)value, 20, 30, 40};
        assert_memory_equal(decoded + 4 * i, expected, 4);
    }
}

/* The specification gives the encoder's rotation, to the left. The stored 0x100 is the difference 0x10. */
UNIT_TEST(exclusive_or_is_rotated_back_to_the_right) {
    static const unsigned char stream[27] = {0xa1, 0xae, 1, [22] = 1, 2, 3, 4, 0x42};
    static const unsigned char expected[4] = {0x11, 2, 3, 4};
    assert_null(gltf_attributes_decode(stream, sizeof stream, 1, 4, decoded));
    assert_memory_equal(decoded, expected, 4);
}

/* Decodes a copy that ends where its memory ends, which AddressSanitizer watches. */
static const char *decode_alone(const unsigned char *bytes, size_t size, size_t count, size_t stride) {
    unsigned char *copy = malloc(size);
    assert_non_null(copy);
    memcpy(copy, bytes, size);
    const char *wrong = gltf_attributes_decode(copy, size, count, stride, decoded);
    free(copy);
    return wrong;
}

UNIT_TEST(a_stream_of_another_length_is_refused) {
    for (unsigned n = 0; n < 40; ++n) {
        const size_t stride = 4 * (1 + below(&coded, 8)), count = 1 + below(&coded, 40);
        make_elements(&coded.random, count, stride, elements);
        encode(&coded, count, stride, elements);
        put(&coded, 0);
        assert_null(decode_alone(coded.bytes, coded.size - 1, count, stride));
        assert_non_null(decode_alone(coded.bytes, coded.size, count, stride));
        for (size_t size = 1; size < coded.size - 1; ++size)
            assert_non_null(decode_alone(coded.bytes, size, count, stride));
    }
}

UNIT_TEST(changed_bytes_do_no_harm) {
    for (unsigned n = 0; n < 2000; ++n) {
        const size_t stride = 4 * (1 + below(&coded, 8)), count = 1 + below(&coded, 40);
        make_elements(&coded.random, count, stride, elements);
        encode(&coded, count, stride, elements);
        coded.bytes[below(&coded, (unsigned)coded.size)] ^= (unsigned char)(1 + below(&coded, 255));
        decode_alone(coded.bytes, coded.size, count, stride);
    }
}

UNIT_TEST(only_the_modes_of_the_specification_are_taken) {
    unsigned char stream[26] = {0xa1, 0xaa, [21] = 1, 2, 3, 4, 0};
    for (unsigned mode = 0; mode < 256; ++mode) {
        stream[25] = (unsigned char)mode;
        const char *wrong = decode_alone(stream, sizeof stream, 1, 4);
        if (mode < 2 || mode % 16 == 2)
            assert_null(wrong);
        else
            assert_string_equal(wrong, "a channel has an unknown mode");
    }
}

/* ---- COLOR ---- */

static void set(unsigned char *to, bool wide, const int in[4]) {
    for (int k = 0; k < 4; ++k) {
        to[wide ? 2 * k : k] = (unsigned char)in[k];
        if (wide) to[2 * k + 1] = (unsigned char)(in[k] >> 8);
    }
}

static void assert_color(bool wide, const int in[4], const long expected[4]) {
    unsigned char e[8];
    set(e, wide, in);
    assert_null(gltf_colors_decode(e, 1, wide ? 8 : 4));
    for (int k = 0; k < 4; ++k) assert_int_equal(wide ? e[2 * k] | e[2 * k + 1] << 8 : e[k], expected[k]);
}

/* Of K bits: red = y + co - cg, green = y + cg, blue = y - co - cg, and alpha, whose lowest bit is doubled,
 * are fractions of 2^K - 1. That is odd, so that none is between two integers, and double tells which is
 * nearer. */
UNIT_TEST(colours_are_the_nearest_integers_to_the_equations) {
    random_state r = {1};
    for (int wide = 0; wide < 2; ++wide)
        for (int bits = 2; bits <= (wide ? 16 : 8); ++bits)
            for (int n = 0; n < 2000; ++n) {
                const int full = (1 << bits) - 1;
                const int low = (int)random_bits(&r) & full >> 1, y = (int)random_bits(&r) & full;
                const int reach = y < full - y ? y / 2 : (full - y) / 2;
                const int co = (int)random_in(&r, -reach, reach), cg = (int)random_in(&r, -reach, reach);
                const int parts[4] = {y + co - cg, y + cg, y - co - cg, low << 1 | (low & 1)};
                long expected[4];
                for (int k = 0; k < 4; ++k)
                    expected[k] = lround((double)parts[k] * (wide ? 65535 : 255) / full);
                assert_color(wide, (const int[]){y, co, cg, low | 1 << (bits - 1)}, expected);
            }
}

UNIT_TEST(colours_outside_become_the_nearest_ones) {
    assert_color(false, (const int[]){255, 127, -128, 255}, (const long[]){255, 127, 255, 255});
    assert_color(false, (const int[]){0, -128, 127, 128}, (const long[]){0, 127, 1, 0});
    assert_color(true, (const int[]){65535, 32767, -32768, 65535},
                 (const long[]){65535, 32767, 65535, 65535});
}

UNIT_TEST(colours_without_their_number_of_bits_are_refused) {
    for (int alpha = 0; alpha < 3; ++alpha) {
        unsigned char e[12];
        set(e, false, (const int[]){1, 0, 0, 128});
        set(e + 4, false, (const int[]){1, 0, 0, alpha});
        set(e + 8, false, (const int[]){1, 0, 0, 128});
        assert_true((gltf_colors_decode(e, 3, 4) == NULL) == (alpha == 2));
    }
}

int main(void) { return unit_main(NULL, NULL); }
