/* Level 0: unpacked, and decoded in bands of four rows, or of one of plain texels. */
#include "helper/ktx2/basis_lz.h"
#include "helper/ktx2/ktx2.h"
#include "helper/ktx2/uastc.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>
#ifdef FATHOM_ZSTD
#include <zstd.h>
#include <zstd_errors.h>
#endif

enum { P_FRAME = 2, BLOCK = 4, GREEN = 1 };

struct ktx2_rows {
    const ktx2_image *image;
    uint32_t y, blocks_across;
    const uint8_t *level;  /* not ETC1S: the bytes of the level, unpacked */
    uint8_t *unpacked;     /* NULL: they are the file's own */
    uint8_t *band, *other; /* four rows of R, G, B, A; those of the second slice */
    lz_book book;
    lz_slice *slices[2];
};

/* ---- unpacking ---- */

static fathom_status unpack_zstd(uint8_t *to, size_t size, const uint8_t *from, size_t packed,
                                 image_message *why) {
#ifdef FATHOM_ZSTD
    const size_t got = ZSTD_decompress(to, size, from, packed);
    if (ZSTD_getErrorCode(got) == ZSTD_error_memory_allocation) return ktx2_no_memory(why);
    return got == size ? FATHOM_OK
                       : ktx2_refuse(why, "level 0 cannot be unpacked by Zstandard: the data is broken");
#else
    (void)to, (void)size, (void)from, (void)packed;
    return ktx2_refuse(why, "Zstandard is missing"); /* ktx2_open() has refused the file */
#endif
}

static fathom_status unpack_zlib(uint8_t *to, size_t size, const uint8_t *from, size_t packed,
                                 image_message *why) {
    uLongf got = size;
    const int result = uncompress(to, &got, from, packed);
    if (result == Z_MEM_ERROR) return ktx2_no_memory(why);
    return result == Z_OK && got == size
               ? FATHOM_OK
               : ktx2_refuse(why, "level 0 cannot be unpacked by zlib: the data is broken");
}

static fathom_status unpack(ktx2_rows *r, image_message *why) {
    const ktx2_image *k = r->image;
    const uint8_t *from = k->bytes + k->level.at;
    r->level = from;
    if (k->packing == KTX2_NOT_PACKED) return FATHOM_OK;
    r->unpacked = malloc(k->unpacked_size);
    r->level = r->unpacked;
    if (!r->unpacked) return ktx2_no_memory(why);
    return (k->packing == KTX2_ZSTD ? unpack_zstd : unpack_zlib)(r->unpacked, k->unpacked_size, from,
                                                                 k->level.size, why);
}

/* ---- ETC1S ---- */

static fathom_status open_slice(ktx2_rows *r, unsigned which, uint32_t at, uint32_t size,
                                image_message *why) {
    const ktx2_range *level = &r->image->level;
    if (!size || at > level->size || size > level->size - at)
        return ktx2_refuse(why, "%s",
                           which ? "its second slice lies beyond level 0"
                                 : "its first slice lies beyond level 0");
    r->slices[which] = lz_slice_open(&r->book, r->image->bytes + level->at + at, size, r->blocks_across);
    return r->slices[which] ? FATHOM_OK : ktx2_no_memory(why);
}

static fathom_status open_slices(ktx2_rows *r, image_message *why) {
    const ktx2_image *k = r->image;
    lz_image places;
    fathom_status status =
        lz_book_open(k->bytes + k->global.at, k->global.size, k->level_count, &r->book, &places, why);
    if (status == FATHOM_OK && places.flags & P_FRAME)
        status = ktx2_refuse(why, "is a frame of a video that depends on another; expected an image");
    if (status == FATHOM_OK) status = open_slice(r, 0, places.color_at, places.color_size, why);
    if (status == FATHOM_OK && k->two_slices)
        status = open_slice(r, 1, places.alpha_at, places.alpha_size, why);
    return status;
}

static bool next_etc1s(ktx2_rows *r) {
    const size_t texels = (size_t)r->blocks_across * BLOCK * BLOCK;
    if (!lz_slice_next(r->slices[0], r->band)) return false;
    if (!r->slices[1]) return true;
    if (!lz_slice_next(r->slices[1], r->other)) return false;
    for (size_t i = 0; i < texels; ++i) r->band[4 * i + r->image->second] = r->other[4 * i + GREEN];
    return true;
}

/* ---- UASTC and plain texels ---- */

static bool next_uastc(ktx2_rows *r) {
    const size_t row_bytes = (size_t)r->blocks_across * BLOCK * 4;
    const uint8_t *block = r->level + (size_t)(r->y / BLOCK) * r->blocks_across * UASTC_BLOCK;
    for (uint32_t x = 0; x < r->blocks_across; ++x, block += UASTC_BLOCK) {
        uint8_t texels[BLOCK * BLOCK][4];
        if (!uastc_decode(block, texels)) return false;
        if (r->image->second == GREEN)
            for (size_t i = 0; i < BLOCK * BLOCK; ++i) texels[i][GREEN] = texels[i][3];
        for (size_t y = 0; y < BLOCK; ++y)
            memcpy(r->band + y * row_bytes + (size_t)x * BLOCK * 4, texels[y * BLOCK], BLOCK * 4);
    }
    return true;
}

static void next_plain(ktx2_rows *r) {
    const ktx2_image *k = r->image;
    const uint8_t *from = r->level + (size_t)r->y * k->width * k->plain_bytes;
    for (uint32_t x = 0; x < k->width; ++x, from += k->plain_bytes) {
        uint8_t *to = r->band + (size_t)x * 4;
        memcpy(to, from, k->plain_bytes);
        if (k->blue_first) to[0] = from[2], to[2] = from[0];
    }
}

/* ---- rows ---- */

fathom_status ktx2_rows_open(const ktx2_image *k, ktx2_rows **out, image_message *why) {
    ktx2_rows *r = *out = calloc(1, sizeof *r);
    if (!r) return ktx2_no_memory(why);
    r->image = k;
    r->blocks_across = (k->width - 1) / BLOCK + 1;
    const size_t band = (size_t)r->blocks_across * BLOCK * 4 * (k->format == KTX2_PLAIN ? 1 : BLOCK);
    r->band = calloc(1, band);
    r->other = k->two_slices ? calloc(1, band) : NULL;
    fathom_status status = r->band && (r->other || !k->two_slices) ? FATHOM_OK : ktx2_no_memory(why);
    if (status == FATHOM_OK) status = k->format == KTX2_ETC1S ? open_slices(r, why) : unpack(r, why);
    if (status == FATHOM_OK) return status;
    ktx2_rows_close(r);
    *out = NULL;
    return status;
}

void ktx2_rows_close(ktx2_rows *r) {
    if (!r) return;
    lz_slice_close(r->slices[0]), lz_slice_close(r->slices[1]);
    lz_book_close(&r->book);
    free(r->unpacked), free(r->band), free(r->other);
    free(r);
}

static bool next_band(ktx2_rows *r) {
    switch (r->image->format) {
    case KTX2_ETC1S: return next_etc1s(r);
    case KTX2_UASTC: return next_uastc(r);
    case KTX2_PLAIN: next_plain(r); break;
    }
    return true;
}

fathom_status ktx2_rows_next(ktx2_rows *r, uint8_t *texels, image_message *why) {
    const ktx2_image *k = r->image;
    const uint32_t rows = k->format == KTX2_PLAIN ? 1 : BLOCK;
    if (r->y % rows == 0 && !next_band(r))
        return ktx2_refuse(why, "the data of level 0 is broken, in the blocks of row %u", r->y);
    const uint8_t *from = r->band + (size_t)(r->y % rows) * r->blocks_across * BLOCK * 4;
    for (uint32_t x = 0; x < k->width; ++x, from += 4) {
        const uint8_t values[6] = {from[0], from[1], from[2], from[3], 0, 255};
        for (uint32_t c = 0; c < k->channels; ++c) *texels++ = values[k->sources[c]];
    }
    ++r->y;
    return FATHOM_OK;
}
