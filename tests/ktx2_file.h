/* KTX 2.0 files of tests, as bytes. */
#pragma once

#include "unit.h"

enum { KTX2_FILE_MAX = 2048 };

/* The parts of a file that has one level. Zeros leave parts out. */
typedef struct ktx2_recipe {
    uint32_t format, width, height, depth, layers, faces, scheme;
    uint8_t model, transfer, flags;
    const char *channels; /* the number of each, as a character of that value plus '0' */
    const char *key, *value;
    const void *level;
    size_t level_size, unpacked_size;
} ktx2_recipe;

static inline void ktx2_put_u32(uint8_t *to, uint64_t value) {
    for (unsigned i = 0; i < 4; ++i) to[i] = (uint8_t)(value >> (8 * i));
}

/* Returns the size. */
static inline size_t ktx2_make(const ktx2_recipe *r, uint8_t file[KTX2_FILE_MAX]) {
    static const uint8_t identifier[12] = {0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n', 0x1a, '\n'};
    const uint32_t head[] = {
        r->format, 1, r->width, r->height, r->depth, r->layers, r->faces ? r->faces : 1, 1, r->scheme};
    const size_t channels = strlen(r->channels), descriptor = 28 + 16 * channels;
    size_t at = 104 + descriptor;
    memset(file, 0, KTX2_FILE_MAX);
    memcpy(file, identifier, sizeof identifier);
    for (size_t i = 0; i < sizeof head / sizeof *head; ++i) ktx2_put_u32(file + 12 + 4 * i, head[i]);
    ktx2_put_u32(file + 48, 104), ktx2_put_u32(file + 52, descriptor);
    ktx2_put_u32(file + 104, descriptor), ktx2_put_u32(file + 112, 2 | (descriptor - 4) << 16);
    file[116] = r->model, file[117] = 1, file[118] = r->transfer, file[119] = r->flags;
    if (r->model > 1) file[120] = file[121] = 3;
    for (size_t i = 0; i < channels; ++i) file[132 + 16 * i + 3] = (uint8_t)(r->channels[i] - '0');
    if (r->key) {
        const size_t key = strlen(r->key) + 1, value = strlen(r->value) + 1,
                     length = (key + value + 7) / 4 * 4;
        ktx2_put_u32(file + 56, at), ktx2_put_u32(file + 60, length);
        ktx2_put_u32(file + at, key + value);
        memcpy(file + at + 4, r->key, key), memcpy(file + at + 4 + key, r->value, value);
        at += length;
    }
    ktx2_put_u32(file + 80, at), ktx2_put_u32(file + 88, r->level_size);
    ktx2_put_u32(file + 96, r->unpacked_size ? r->unpacked_size : r->level_size);
    memcpy(file + at, r->level, r->level_size);
    return at + r->level_size;
}

/* Returns the size. */
static inline size_t ktx2_from_hex(const char *text, uint8_t file[KTX2_FILE_MAX]) {
    const size_t size = strlen(text) / 2;
    for (size_t i = 0; i < size; ++i) {
        unsigned byte;
        assert_int_equal(sscanf(text + 2 * i, "%2x", &byte), 1);
        file[i] = (uint8_t)byte;
    }
    return size;
}
