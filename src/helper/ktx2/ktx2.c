/* Header, data format descriptor and key/value data of KTX 2.0 (KTX File Format Specification 2.0, sections 3
 * to 5; Khronos Data Format Specification 1.4, chapters 4 and 5). */
#include "helper/ktx2/ktx2.h"
#include "helper/ktx2/bits.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { HEAD = 80, LEVEL = 24, DESCRIPTOR_HEAD = 28, SAMPLE = 16, LEVELS_MAX = 32 };
enum { MODEL_RGBSDA = 1, MODEL_ETC1S = 163, MODEL_UASTC = 166, MODEL_UASTC_HDR = 167 };
enum { RED, GREEN, BLUE, ALPHA };

static const uint8_t identifier[12] = {0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n', 0x1a, '\n'};

bool ktx2_is(const uint8_t *bytes, size_t size) {
    return size >= sizeof identifier && memcmp(bytes, identifier, sizeof identifier) == 0;
}

fathom_status ktx2_refuse(image_message *why, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(why->text, sizeof why->text, format, arguments);
    va_end(arguments);
    return FATHOM_BAD_INPUT;
}

fathom_status ktx2_no_memory(image_message *why) {
    ktx2_refuse(why, "out of memory");
    return FATHOM_OUT_OF_RESOURCES;
}

static uint64_t u64_at(const uint8_t *bytes) { return u32_at(bytes) | (uint64_t)u32_at(bytes + 4) << 32; }

static bool is_within(uint64_t at, uint64_t length, size_t size) { return at <= size && length <= size - at; }

/* ---- formats ---- */

/* The formats of Vulkan that are bytes in the order of their channels. */
static const struct plain {
    uint32_t format;
    uint8_t bytes;
    bool blue_first;
} plains[] = {{9, 1, false}, {15, 1, false}, {16, 2, false}, {22, 2, false}, {23, 3, false}, {29, 3, false},
              {30, 3, true}, {36, 3, true},  {37, 4, false}, {43, 4, false}, {44, 4, true},  {50, 4, true}};

/* Names formats that are not read, for messages. */
static const char *name_of(uint32_t format) {
    static const struct {
        uint32_t first, last;
        const char *name;
    } table[] = {{70, 76, "16 bits, one channel"},
                 {77, 83, "16 bits, two channels"},
                 {84, 90, "16 bits, three channels"},
                 {91, 97, "16 bits, four channels"},
                 {98, 109, "32 bits"},
                 {131, 134, "BC1"},
                 {135, 136, "BC2"},
                 {137, 138, "BC3"},
                 {139, 140, "BC4"},
                 {141, 142, "BC5"},
                 {143, 144, "BC6H"},
                 {145, 146, "BC7"},
                 {147, 152, "ETC2"},
                 {153, 156, "EAC"},
                 {157, 184, "ASTC"},
                 {1000054000, 1000054007, "PVRTC"},
                 {1000066000, 1000066013, "ASTC HDR"}};
    for (size_t i = 0; i < sizeof table / sizeof *table; ++i)
        if (format >= table[i].first && format <= table[i].last) return table[i].name;
    return "another format";
}

static fathom_status find_format(uint32_t format, uint8_t model, ktx2_image *out, image_message *why) {
    if (format == 0 && (model == MODEL_ETC1S || model == MODEL_UASTC)) {
        out->format = model == MODEL_ETC1S ? KTX2_ETC1S : KTX2_UASTC;
        return FATHOM_OK;
    }
    out->format = KTX2_PLAIN;
    for (size_t i = 0; i < sizeof plains / sizeof *plains; ++i) {
        if (plains[i].format != format) continue;
        out->plain_bytes = plains[i].bytes, out->blue_first = plains[i].blue_first;
        if (model == MODEL_RGBSDA) return FATHOM_OK;
        return ktx2_refuse(why, "the color model is %u; expected 1, for vkFormat %u", model, format);
    }
    if (format == 0)
        return ktx2_refuse(why, "the color model is %u%s; expected 163 (ETC1S) or 166 (UASTC LDR 4x4)", model,
                           model == MODEL_UASTC_HDR ? " (UASTC HDR)" : "");
    return ktx2_refuse(
        why,
        "vkFormat is %u (%s); expected ETC1S, UASTC LDR 4x4, or plain channels of 8 bits: encode the "
        "image with Basis Universal",
        format, name_of(format));
}

/* ---- channels ---- */

static void set_sources(ktx2_image *out, uint8_t r, uint8_t g, uint8_t b, uint8_t a) {
    const uint8_t sources[4] = {r, g, b, a};
    memcpy(out->sources, sources, sizeof sources);
}

/* Sets which channels the decoded texels have. Two channels are red and green, whatever their use is. */
static fathom_status find_channels(const uint8_t *samples, size_t count, ktx2_image *out,
                                   image_message *why) {
    const unsigned first = samples[3] & 15, second = count > 1 ? samples[SAMPLE + 3] & 15 : 0;
    size_t has = out->plain_bytes;
    out->two_slices = out->format == KTX2_ETC1S && count == 2;
    out->second = ALPHA;
    if (out->format == KTX2_ETC1S) {
        const bool color = first == 0 && (count == 1 || second == 15);
        const bool red = first == 3 && (count == 1 || second == 4);
        if (count > 2 || (!color && !red))
            return ktx2_refuse(why, "the channels of ETC1S are none of RGB, RGB and AAA, RRR, RRR and GGG");
        has = (color ? 2 : 0) + count;
        if (red) out->second = GREEN;
    } else if (out->format == KTX2_UASTC) {
        static const uint8_t channels[] = {3, 0, 0, 4, 1, 2, 2};
        has = count == 1 && first < sizeof channels ? channels[first] : 0;
        if (!has) return ktx2_refuse(why, "the channels of UASTC are none of RGB, RGBA, RRR, RRRG, RG");
        if (first == 5) out->second = GREEN;
    } else if (count != has) {
        return ktx2_refuse(why, "the data format descriptor has %zu channels; expected %zu, for the vkFormat",
                           count, has);
    }
    if (has == 1) set_sources(out, RED, RED, RED, KTX2_ONE);
    if (has == 2) set_sources(out, RED, GREEN, KTX2_ZERO, KTX2_ONE);
    if (has == 3) set_sources(out, RED, GREEN, BLUE, KTX2_ONE);
    if (has == 4) set_sources(out, RED, GREEN, BLUE, ALPHA);
    return FATHOM_OK;
}

static image_transfer transfer_of(uint8_t code) {
    return code == 0   ? IMAGE_TRANSFER_UNKNOWN
           : code == 1 ? IMAGE_TRANSFER_LINEAR
           : code == 2 ? IMAGE_TRANSFER_SRGB
                       : IMAGE_TRANSFER_OTHER;
}

/* The basic descriptor comes first, after the size of all. */
static fathom_status read_descriptor(const uint8_t *bytes, size_t size, ktx2_image *out, image_message *why) {
    const uint32_t format = u32_at(bytes + 12);
    const uint64_t at = u32_at(bytes + 48), length = u32_at(bytes + 52);
    if (!is_within(at, length, size) || length < DESCRIPTOR_HEAD + SAMPLE)
        return ktx2_refuse(why, "the data format descriptor is missing or ends early");
    const uint8_t *d = bytes + at;
    const size_t block = d[10] | (size_t)d[11] << 8;
    if (u32_at(d + 4) != 0 || block < DESCRIPTOR_HEAD - 4 + SAMPLE || block > length - 4)
        return ktx2_refuse(why, "the data format descriptor does not begin with a basic one");
    const fathom_status status = find_format(format, d[12], out, why);
    if (status != FATHOM_OK) return status;
    if (out->format != KTX2_PLAIN && (d[16] != 3 || d[17] != 3 || d[18] || d[19]))
        return ktx2_refuse(why, "its blocks are not of 4 x 4 texels");
    out->transfer = transfer_of(d[14]);
    out->premultiplied = d[15] & 1;
    return find_channels(d + DESCRIPTOR_HEAD, (block - (DESCRIPTOR_HEAD - 4)) / SAMPLE, out, why);
}

/* ---- key/value data ---- */

static fathom_status read_orientation(const char *value, ktx2_image *out, image_message *why) {
    out->upwards = strcmp(value, "ru") == 0;
    if (out->upwards || strcmp(value, "rd") == 0) return FATHOM_OK;
    return ktx2_refuse(why, "KTXorientation is \"%.8s\"; expected \"rd\" or \"ru\"", value);
}

static fathom_status read_swizzle(const char *value, ktx2_image *out, image_message *why) {
    static const char letters[] = "rgba01";
    uint8_t sources[4];
    for (unsigned c = 0; c < 4; ++c) {
        const char *found = value[c] ? strchr(letters, value[c]) : NULL;
        if (!found || strlen(value) != 4)
            return ktx2_refuse(why, "KTXswizzle is \"%.8s\"; expected four of r, g, b, a, 0, 1", value);
        const uint8_t source = (uint8_t)(found - letters);
        /* A single channel is red alone here, not grey. */
        sources[c] = source < 4 ? out->sources[source] : source;
        if (source > RED && source < ALPHA && out->sources[GREEN] == RED) sources[c] = KTX2_ZERO;
    }
    memcpy(out->sources, sources, sizeof sources);
    return FATHOM_OK;
}

static fathom_status read_pair(const char *key, const char *value, ktx2_image *out, image_message *why) {
    if (strcmp(key, "KTXorientation") == 0) return read_orientation(value, out, why);
    if (strcmp(key, "KTXswizzle") == 0) return read_swizzle(value, out, why);
    return FATHOM_OK;
}

/* Each entry: a length, a key that ends with zero, a value, padding to a multiple of 4. */
static fathom_status read_pairs(const uint8_t *bytes, size_t size, ktx2_image *out, image_message *why) {
    uint64_t at = u32_at(bytes + 56), length = u32_at(bytes + 60);
    if (!is_within(at, length, size)) return ktx2_refuse(why, "the key/value data ends early");
    for (const uint64_t end = at + length; end - at > 4;) {
        const uint32_t pair = u32_at(bytes + at);
        const char *key = (const char *)bytes + at + 4;
        if (pair > end - at - 4) return ktx2_refuse(why, "the key/value data ends early");
        const size_t key_length = strnlen(key, pair);
        if (key_length < pair) {
            char value[64];
            const size_t room = pair - key_length - 1;
            snprintf(value, sizeof value, "%.*s", (int)(room < sizeof value ? room : sizeof value - 1),
                     key + key_length + 1);
            const fathom_status status = read_pair(key, value, out, why);
            if (status != FATHOM_OK) return status;
        }
        at += 4 + ((uint64_t)pair + 3) / 4 * 4;
        if (at > end) break;
    }
    return FATHOM_OK;
}

/* ---- the level ---- */

static uint64_t level_size(const ktx2_image *k) {
    const uint64_t across = ((uint64_t)k->width + 3) / 4, down = ((uint64_t)k->height + 3) / 4;
    return k->format == KTX2_UASTC ? across * down * 16 : (uint64_t)k->width * k->height * k->plain_bytes;
}

static fathom_status read_level(const uint8_t *bytes, size_t size, ktx2_image *out, image_message *why) {
    const uint32_t packing = u32_at(bytes + 44);
    const uint64_t global_at = u64_at(bytes + 64), global_size = u64_at(bytes + 72);
    const uint64_t at = u64_at(bytes + HEAD), length = u64_at(bytes + HEAD + 8);
    const bool lz = out->format == KTX2_ETC1S;
    if (packing > KTX2_ZLIB)
        return ktx2_refuse(
            why,
            "the supercompression scheme is %u; expected 0 (none), 1 (BasisLZ), 2 (Zstandard) or "
            "3 (ZLIB)",
            packing);
#ifndef FATHOM_ZSTD
    if (packing == KTX2_ZSTD)
        return ktx2_refuse(why,
                           "is compressed by Zstandard, but this Fathom was built without it; build it with "
                           "libzstd-dev (Debian), or encode the image without Zstandard");
#endif
    out->packing = (ktx2_packing)packing;
    if (lz != (out->packing == KTX2_BASIS_LZ))
        return ktx2_refuse(why, lz ? "ETC1S is not packed by BasisLZ" : "only ETC1S is packed by BasisLZ");
    if (!is_within(at, length, size) || !length) return ktx2_refuse(why, "level 0 ends early");
    if (!is_within(global_at, global_size, size)) return ktx2_refuse(why, "the global data ends early");
    out->level = (ktx2_range){(size_t)at, (size_t)length};
    out->global = (ktx2_range){(size_t)global_at, (size_t)global_size};
    if (lz) return FATHOM_OK;
    out->unpacked_size = level_size(out);
    const uint64_t unpacked = packing == KTX2_NOT_PACKED ? length : u64_at(bytes + HEAD + 16);
    if (unpacked == out->unpacked_size) return FATHOM_OK;
    return ktx2_refuse(why, "level 0 has %llu bytes; expected %llu", (unsigned long long)unpacked,
                       (unsigned long long)out->unpacked_size);
}

/* Grey needs one channel, and an opaque image needs no alpha. */
static fathom_status settle_channels(ktx2_image *out, image_message *why) {
    const uint8_t *s = out->sources;
    const bool grey = s[RED] == s[GREEN] && s[RED] == s[BLUE], opaque = s[ALPHA] == KTX2_ONE;
    if (s[RED] == RED && s[GREEN] == GREEN && s[BLUE] == KTX2_ZERO)
        return ktx2_refuse(
            why, "has the channels red and green alone; expected grey, grey and alpha, RGB or RGBA");
    out->channels = (grey ? 1u : 3u) + (opaque ? 0u : 1u);
    if (grey) out->sources[1] = s[ALPHA];
    return FATHOM_OK;
}

static fathom_status read_shape(const uint8_t *bytes, size_t size, ktx2_image *out, image_message *why) {
    const uint32_t depth = u32_at(bytes + 28), layers = u32_at(bytes + 32), faces = u32_at(bytes + 36);
    out->width = u32_at(bytes + 20), out->height = u32_at(bytes + 24);
    out->level_count = u32_at(bytes + 40) ? u32_at(bytes + 40) : 1;
    if (depth || layers || faces != 1 || !out->width || !out->height)
        return ktx2_refuse(why, "is %s; expected one flat image",
                           faces == 6 ? "a cube map"
                           : depth    ? "a 3D texture"
                           : layers   ? "an array of images"
                                      : "no flat image");
    if (out->level_count > LEVELS_MAX || (size - HEAD) / LEVEL < out->level_count)
        return ktx2_refuse(why, "the index of levels ends early");
    return FATHOM_OK;
}

fathom_status ktx2_open(const uint8_t *bytes, size_t size, ktx2_image *out, image_message *why) {
    static fathom_status (*const read[])(const uint8_t *, size_t, ktx2_image *, image_message *) = {
        read_shape, read_descriptor, read_pairs, read_level};
    *out = (ktx2_image){.bytes = bytes};
    if (!ktx2_is(bytes, size)) return ktx2_refuse(why, "is no KTX 2.0 file");
    if (size < HEAD) return ktx2_refuse(why, "the file ends within its header");
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < sizeof read / sizeof *read && status == FATHOM_OK; ++i)
        status = read[i](bytes, size, out, why);
    return status == FATHOM_OK ? settle_channels(out, why) : status;
}
