/* KTX 2.0 files with one flat image: Basis Universal's ETC1S and UASTC LDR 4x4, and plain bytes. Level 0
 * alone is decoded, to eight bits a channel.
 *
 *     ktx2.c        header, data format descriptor, key/value data
 *     ktx2_rows.c   level 0, unpacked and decoded band by band
 *     basis_lz.c, basis_lz_slice.c, huffman.c   ETC1S
 *     uastc.c       UASTC */
#pragma once

#include "image/helper/module.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum ktx2_format { KTX2_ETC1S, KTX2_UASTC, KTX2_PLAIN } ktx2_format;
typedef enum ktx2_packing { KTX2_NOT_PACKED, KTX2_BASIS_LZ, KTX2_ZSTD, KTX2_ZLIB } ktx2_packing;

typedef struct ktx2_range {
    size_t at, size;
} ktx2_range;

/* A channel of a texel is one of the decoded R, G, B, A (0 to 3), or a constant. */
enum { KTX2_ZERO = 4, KTX2_ONE = 5 };

typedef struct ktx2_image {
    const uint8_t *bytes; /* the caller's */
    uint32_t width, height, level_count;
    uint32_t channels; /* 1: grey; 2: grey, alpha; 3: R, G, B; 4: R, G, B, alpha */
    ktx2_format format;
    ktx2_packing packing;
    image_transfer transfer;
    bool premultiplied;
    bool upwards;         /* the first row is the lowest one */
    bool blue_first;      /* plain texels are B, G, R, A */
    uint32_t plain_bytes; /* of a plain texel */
    bool two_slices;      /* ETC1S: the second slice is alpha, or green */
    uint8_t second;       /* the channel that the second slice of ETC1S, or the alpha of UASTC, is */
    uint8_t sources[4];   /* what each of the `channels` is */
    ktx2_range level, global;
    uint64_t unpacked_size; /* of the level; of ETC1S unknown */
} ktx2_image;

/* FATHOM_BAD_INPUT and FATHOM_OUT_OF_RESOURCES, with the reason. */
fathom_status ktx2_refuse(image_message *why, const char *format, ...) __attribute__((format(printf, 2, 3)));
fathom_status ktx2_no_memory(image_message *why);

bool ktx2_is(const uint8_t *bytes, size_t size);

/* Checks everything but the level's data. FATHOM_BAD_INPUT, with the reason, if the file is broken or has
 * what this cannot read. */
fathom_status ktx2_open(const uint8_t *bytes, size_t size, ktx2_image *out, image_message *why);

typedef struct ktx2_rows ktx2_rows;

/* The image and its bytes stay the caller's, and are used until ktx2_rows_close(). */
fathom_status ktx2_rows_open(const ktx2_image *k, ktx2_rows **out, image_message *why);
/* Decodes the next row, in the order of the file: `channels` bytes a texel. */
fathom_status ktx2_rows_next(ktx2_rows *rows, uint8_t *texels, image_message *why);
void ktx2_rows_close(ktx2_rows *rows);

#ifdef __cplusplus
}
#endif
