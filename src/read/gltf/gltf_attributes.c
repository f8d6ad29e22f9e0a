/* A stream of version 1 is a header byte, blocks of up to 256 elements, and a tail: padding, the element
 * before the first one, and a mode for each channel of 4 bytes. A block stores the differences between
 * elements, byte 0 of all its elements first, then byte 1, and so on; each byte in groups of 16 elements. */
#include "read/gltf/gltf_data.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

enum { GROUP = 16, BLOCK_ELEMENTS = 256, BLOCK_BYTES = 8192, CHANNEL = 4, TAIL_LEAST = 24 };

/* How the differences of a channel are coded: the low 4 bits of its mode. */
enum { MODE_BYTES, MODE_WORDS, MODE_XOR };

static const char cut_short[] = "the data ends too early";

/* ---- differences ---- */

typedef struct stream {
    const unsigned char *at, *end;
} stream;

/* The next `size` bytes; NULL if fewer remain. */
static const unsigned char *take(stream *s, size_t size) {
    const unsigned char *bytes = s->at;
    if ((size_t)(s->end - bytes) < size) return NULL;
    s->at += size;
    return bytes;
}

/* A group with 1, 2 or 4 bits for each byte. All bits set mean that the byte follows the group. Codes of 1
 * bit begin at the lowest bit, longer ones at the highest. */
static bool read_codes(stream *s, unsigned bits, unsigned char out[GROUP]) {
    const unsigned char *codes = take(s, GROUP * bits / 8);
    const unsigned follows = (1u << bits) - 1;
    if (!codes) return false;
    for (unsigned i = 0; i < GROUP; ++i) {
        const unsigned at = i * bits % 8, shift = bits == 1 ? at : 8 - bits - at;
        unsigned code = (unsigned)codes[i * bits / 8] >> shift & follows;
        if (code == follows) {
            if (s->at == s->end) return false;
            code = *s->at++;
        }
        out[i] = (unsigned char)code;
    }
    return true;
}

static bool read_group(stream *s, unsigned bits, unsigned char out[GROUP]) {
    if (bits != 0 && bits != 8) return read_codes(s, bits, out);
    const unsigned char *bytes = take(s, bits ? GROUP : 0);
    if (!bytes) return false;
    if (bits)
        memcpy(out, bytes, GROUP);
    else
        memset(out, 0, GROUP);
    return true;
}

/* The differences of one byte of `count` elements; `out` has room for whole groups. */
static bool read_bytes(stream *s, unsigned control, size_t count, unsigned char *out) {
    static const unsigned char bits[2][4] = {{0, 1, 2, 4}, {1, 2, 4, 8}};
    const size_t groups = (count + GROUP - 1) / GROUP;
    if (control >= 2) {
        const unsigned char *bytes = take(s, control == 3 ? count : 0);
        if (!bytes) return false;
        if (control == 3)
            memcpy(out, bytes, count);
        else
            memset(out, 0, count);
        return true;
    }
    const unsigned char *header = take(s, (groups + 3) / 4);
    if (!header) return false;
    for (size_t i = 0; i < groups; ++i)
        if (!read_group(s, bits[control][header[i / 4] >> i % 4 * 2 & 3], out + i * GROUP)) return false;
    return true;
}

/* ---- elements ---- */

/* Adds differences that are zigzag-coded integers of `size` bytes, 1 or 2, with wraparound. Byte k of element
 * i has its difference at deltas[k * pitch + i]. `before`: the same bytes of the element before the first. */
static void add(unsigned size, const unsigned char *deltas, size_t pitch, const unsigned char *before,
                size_t count, size_t stride, unsigned char *to) {
    const bool wide = size == 2;
    unsigned value = before[0] | (wide ? (unsigned)before[1] << 8 : 0);
    for (size_t i = 0; i < count; ++i, to += stride) {
        const unsigned code = deltas[i] | (wide ? (unsigned)deltas[pitch + i] << 8 : 0);
        value += code >> 1 ^ (0u - (code & 1));
        to[0] = (unsigned char)value;
        if (wide) to[1] = (unsigned char)(value >> 8);
    }
}

/* Differences by exclusive or of 32 bits, which the encoder rotated to the left by `turn` bits. */
static void flip(unsigned turn, const unsigned char *deltas, size_t pitch, const unsigned char *before,
                 size_t count, size_t stride, unsigned char *to) {
    uint32_t value;
    memcpy(&value, before, sizeof value);
    for (size_t i = 0; i < count; ++i, to += stride) {
        const uint32_t code = deltas[i] | (uint32_t)deltas[pitch + i] << 8 |
                              (uint32_t)deltas[2 * pitch + i] << 16 | (uint32_t)deltas[3 * pitch + i] << 24;
        value ^= code >> turn | code << ((32 - turn) & 31);
        memcpy(to, &value, sizeof value);
    }
}

static void restore_channel(unsigned mode, const unsigned char *deltas, size_t pitch,
                            const unsigned char *before, size_t count, size_t stride, unsigned char *to) {
    if ((mode & 15) == MODE_XOR) {
        flip(mode >> 4, deltas, pitch, before, count, stride, to);
        return;
    }
    const unsigned size = mode == MODE_WORDS ? 2 : 1;
    for (unsigned k = 0; k < CHANNEL; k += size)
        add(size, deltas + k * pitch, pitch, before + k, count, stride, to + k);
}

static bool decode_block(stream *s, const unsigned char *modes, const unsigned char *before, size_t count,
                         size_t stride, unsigned char *to) {
    unsigned char deltas[BLOCK_BYTES];
    const size_t pitch = (count + GROUP - 1) / GROUP * GROUP; /* pitch * stride <= BLOCK_BYTES */
    const unsigned char *controls = take(s, stride / CHANNEL);
    if (!controls) return false;
    for (size_t k = 0; k < stride; ++k)
        if (!read_bytes(s, controls[k / 4] >> k % 4 * 2 & 3, count, deltas + k * pitch)) return false;
    for (size_t k = 0; k < stride; k += CHANNEL)
        restore_channel(modes[k / CHANNEL], deltas + k * pitch, pitch, before + k, count, stride, to + k);
    return true;
}

/* Only exclusive or has a parameter, in the high 4 bits. */
static bool are_modes(const unsigned char *modes, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (modes[i] > MODE_WORDS && (modes[i] & 15) != MODE_XOR) return false;
    return true;
}

const char *gltf_attributes_decode(const unsigned char *bytes, size_t size, size_t count, size_t stride,
                                   unsigned char *to) {
    const size_t kept = stride + stride / CHANNEL, tail = kept < TAIL_LEAST ? TAIL_LEAST : kept;
    if (size < 1 + tail) return cut_short;
    stream s = {.at = bytes + 1, .end = bytes + size - tail};
    const unsigned char *before = bytes + size - kept, *modes = before + stride;
    const size_t fit = BLOCK_BYTES / stride / GROUP * GROUP,
                 most = fit < BLOCK_ELEMENTS ? fit : BLOCK_ELEMENTS;
    if (!are_modes(modes, stride / CHANNEL)) return "a channel has an unknown mode";
    while (count) {
        const size_t block = count < most ? count : most;
        if (!decode_block(&s, modes, before, block, stride, to)) return cut_short;
        before = to + (block - 1) * stride;
        to += block * stride, count -= block;
    }
    return s.at == s.end ? NULL : "the data has more bytes than its elements need";
}

/* ---- colours ---- */

/* The integer nearest to most * value / full, with value in [0, full] and full odd. The product has 32 bits.
 */
static unsigned scaled(int value, unsigned full, unsigned most) {
    const unsigned inside = value < 0 ? 0 : (unsigned)value > full ? full : (unsigned)value;
    return (inside * most + full / 2) / full;
}

/* Luma y, chroma co and cg, and alpha as integers of K bits to colours in [0, most]. The highest bit of alpha
 * is bit K - 1; the lower ones are its value, which has one bit less. False if there is no such bit. */
static bool to_rgb(int y, int co, int cg, unsigned alpha, unsigned most, unsigned out[4]) {
    if (alpha < 2) return false;
    const unsigned full = (2u << (31 - __builtin_clz(alpha))) - 1, low = alpha & full >> 1;
    out[0] = scaled(y + co - cg, full, most);
    out[1] = scaled(y + cg, full, most);
    out[2] = scaled(y - co - cg, full, most);
    out[3] = scaled((int)(low << 1 | (low & 1)), full, most);
    return true;
}

const char *gltf_colors_decode(unsigned char *elements, size_t count, size_t stride) {
    const bool wide = stride == 8;
    for (size_t i = 0; i < count; ++i) {
        unsigned char *e = elements + i * stride;
        uint16_t in[4];
        unsigned out[4];
        for (size_t k = 0; k < 4; ++k) in[k] = (uint16_t)(wide ? e[2 * k] | e[2 * k + 1] << 8 : e[k]);
        const int co = wide ? (int16_t)in[1] : (int8_t)in[1], cg = wide ? (int16_t)in[2] : (int8_t)in[2];
        if (!to_rgb(in[0], co, cg, in[3], wide ? 65535 : 255, out))
            return "the alpha of a colour is 0 or 1, without the bit that says how many bits the colour has";
        for (size_t k = 0; k < 4; ++k) {
            if (wide) e[2 * k] = (unsigned char)out[k], e[2 * k + 1] = (unsigned char)(out[k] >> 8);
            if (!wide) e[k] = (unsigned char)out[k];
        }
    }
    return NULL;
}
