/* Canonical Huffman codes (RFC 1951, section 3.2.2) as BasisLZ stores them: KTX 2.0 specification,
 * "Compressed Huffman Tables". */
#pragma once

#include "helper/ktx2/bits.h"

#define HUFFMAN_LENGTH_MAX 16
#define HUFFMAN_SYMBOLS_MAX 16383

typedef struct huffman {
    uint16_t counts[HUFFMAN_LENGTH_MAX + 1]; /* codes of each length */
    uint16_t *symbols;                       /* sorted by code; release with huffman_free() */
} huffman;

typedef enum huffman_result { HUFFMAN_FINE, HUFFMAN_BROKEN, HUFFMAN_NO_MEMORY } huffman_result;

/* A table may be empty; it then has no codes. *out is valid, and to be released, whatever the result. */
huffman_result huffman_read(bit_reader *bits, huffman *out);
void huffman_free(huffman *table);

/* The next symbol; -1 if the bits are none of the table's codes. */
int huffman_take(const huffman *table, bit_reader *bits);
