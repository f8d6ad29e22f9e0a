/* Numbers as binary files store them. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef enum scalar_type {
    SCALAR_INT8,
    SCALAR_UINT8,
    SCALAR_INT16,
    SCALAR_UINT16,
    SCALAR_INT32,
    SCALAR_UINT32,
    SCALAR_INT64,
    SCALAR_UINT64,
    SCALAR_FLOAT32,
    SCALAR_FLOAT64
} scalar_type;

static inline size_t scalar_size(scalar_type type) {
    static const unsigned char sizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    return sizes[type];
}

static inline uint32_t scalar_load_32(const unsigned char *p, bool big) {
    uint32_t bits;
    memcpy(&bits, p, sizeof bits);
    return big ? __builtin_bswap32(bits) : bits;
}

static inline uint64_t scalar_load_64(const unsigned char *p, bool big) {
    uint64_t bits;
    memcpy(&bits, p, sizeof bits);
    return big ? __builtin_bswap64(bits) : bits;
}

/* The number at any address; big: big-endian. Whole numbers beyond 2^53 are rounded, all others are exact. */
static inline double scalar_load(const unsigned char *p, scalar_type type, bool big) {
    uint16_t bits16;
    uint32_t bits32;
    uint64_t bits64;
    float single;
    double number;
    switch (type) {
    case SCALAR_INT8: return (int8_t)*p;
    case SCALAR_UINT8: return *p;
    case SCALAR_INT16:
    case SCALAR_UINT16:
        memcpy(&bits16, p, sizeof bits16);
        if (big) bits16 = __builtin_bswap16(bits16);
        return type == SCALAR_INT16 ? (int16_t)bits16 : bits16;
    case SCALAR_INT32: return (int32_t)scalar_load_32(p, big);
    case SCALAR_UINT32: return scalar_load_32(p, big);
    case SCALAR_INT64: return (double)(int64_t)scalar_load_64(p, big);
    case SCALAR_UINT64: return (double)scalar_load_64(p, big);
    case SCALAR_FLOAT32:
        bits32 = scalar_load_32(p, big);
        memcpy(&single, &bits32, sizeof single);
        return (double)single;
    case SCALAR_FLOAT64:
        bits64 = scalar_load_64(p, big);
        memcpy(&number, &bits64, sizeof number);
        return number;
    }
    return 0;
}
