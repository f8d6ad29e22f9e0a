/* Numbers of binary PLY files. */
#ifndef READ_PLY_BYTES_H
#define READ_PLY_BYTES_H

#include "read/ply/ply.h"

#include <string.h>

#define PLY_HOST_BIG (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__)

static inline uint16_t ply_load_16(const unsigned char *p, bool big) {
    uint16_t bits;
    memcpy(&bits, p, sizeof bits);
    return big == PLY_HOST_BIG ? bits : __builtin_bswap16(bits);
}

static inline uint32_t ply_load_32(const unsigned char *p, bool big) {
    uint32_t bits;
    memcpy(&bits, p, sizeof bits);
    return big == PLY_HOST_BIG ? bits : __builtin_bswap32(bits);
}

static inline float ply_load_float(const unsigned char *p, bool big) {
    uint32_t bits = ply_load_32(p, big);
    float number;
    memcpy(&number, &bits, sizeof number);
    return number;
}

static inline double ply_load_double(const unsigned char *p, bool big) {
    uint64_t bits;
    double number;
    memcpy(&bits, p, sizeof bits);
    if (big != PLY_HOST_BIG) bits = __builtin_bswap64(bits);
    memcpy(&number, &bits, sizeof number);
    return number;
}

/* `big`: the most significant byte comes first. Every type's numbers are doubles exactly. */
static inline double ply_load(const unsigned char *p, ply_type type, bool big) {
    switch (type) {
    case PLY_INT8: return (int8_t)*p;
    case PLY_UINT8: return *p;
    case PLY_INT16: return (int16_t)ply_load_16(p, big);
    case PLY_UINT16: return ply_load_16(p, big);
    case PLY_INT32: return (int32_t)ply_load_32(p, big);
    case PLY_UINT32: return ply_load_32(p, big);
    case PLY_FLOAT32: return (double)ply_load_float(p, big);
    case PLY_FLOAT64: return ply_load_double(p, big);
    }
    return 0;
}

/* Where the rows of an element of a binary file lie. Rows are read in blocks: rows that differ in size are
 * walked once, which notes where each block begins. */
#ifndef PLY_BLOCK /* fuzzing cuts small files */
#define PLY_BLOCK 4096
#endif

typedef struct ply_rows {
    const ply_element *element;
    const unsigned char *begin, *end;
    size_t row;                   /* bytes of every row, if they are alike; else 0 */
    size_t *offsets;              /* of each property in the row, if they are alike */
    const unsigned char **blocks; /* else where each block begins */
    size_t block_count;
} ply_rows;

/* Finds the rows of `element`, which begin at `begin`. */
fathom_status ply_find_rows(ply_reader *r, const ply_element *element, const unsigned char *begin,
                            ply_rows *out);
void ply_free_rows(ply_rows *rows);

/* A row that is being read. */
typedef struct ply_row {
    const unsigned char *at;
    const size_t *offsets;
    size_t *own_offsets;  /* where rows differ */
    uint64_t number, end; /* of the block */
} ply_row;

/* The first row of a block; ply_free_row() when done with it. */
bool ply_first_row(ply_reader *r, const ply_rows *rows, size_t block, ply_row *row);
/* False after the last row of the block. */
bool ply_next_row(ply_reader *r, const ply_rows *rows, ply_row *row);
void ply_free_row(ply_row *row);

/* The length of the list at `p`, past which it moves; false after a fault: not a whole number, or more than
 * the file holds. */
bool ply_list_count(ply_reader *r, const ply_property *list, const unsigned char **p, uint64_t *out);

#endif
