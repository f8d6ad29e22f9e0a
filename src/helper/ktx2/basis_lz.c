/* The code books of BasisLZ. */
#include "helper/ktx2/basis_lz.h"
#include "helper/ktx2/ktx2.h"

#include <stdlib.h>

enum { HEAD = 20, IMAGE = 20 };

static fathom_status broken(image_message *why, const char *part) {
    return ktx2_refuse(why, "the %s of BasisLZ is broken or ends early", part);
}

/* ---- end points ---- */

/* Each value is a difference to the one before; which code it has depends on that one. */
static bool take_color(const huffman models[3], bit_reader *bits, uint8_t *value) {
    const int delta = huffman_take(&models[*value < 10 ? 0 : *value < 22 ? 1 : 2], bits);
    *value = (uint8_t)((*value + (unsigned)delta) & 31);
    return delta >= 0;
}

static bool take_endpoint(const huffman models[4], bit_reader *bits, bool grey, lz_endpoint *e) {
    const int delta = huffman_take(&models[3], bits);
    if (delta < 0) return false;
    e->table = (uint8_t)((e->table + (unsigned)delta) & 7);
    for (unsigned c = 0; c < (grey ? 1 : 3); ++c)
        if (!take_color(models, bits, &e->color[c])) return false;
    if (grey) e->color[1] = e->color[2] = e->color[0];
    return true;
}

static huffman_result read_endpoints(bit_reader *bits, lz_book *book) {
    huffman models[4] = {{.symbols = NULL}};
    lz_endpoint e = {{16, 16, 16}, 0};
    huffman_result result = HUFFMAN_FINE;
    for (unsigned i = 0; i < 4 && result == HUFFMAN_FINE; ++i) result = huffman_read(bits, &models[i]);
    const bool grey = bits_take(bits, 1);
    for (uint32_t i = 0; i < book->endpoint_count && result == HUFFMAN_FINE; ++i) {
        if (!take_endpoint(models, bits, grey, &e)) result = HUFFMAN_BROKEN;
        book->endpoints[i] = e;
    }
    for (unsigned i = 0; i < 4; ++i) huffman_free(&models[i]);
    return result == HUFFMAN_FINE && bits_are_over(bits) ? HUFFMAN_BROKEN : result;
}

/* ---- selectors ---- */

/* The first selector is stored as it is, and the others as differences, unless all are stored as they are. */
static bool take_selectors(const huffman *model, bit_reader *bits, bool raw, lz_book *book) {
    lz_selector s = {{0}};
    for (uint32_t i = 0; i < book->selector_count; ++i) {
        for (unsigned row = 0; row < 4; ++row) {
            const int delta = raw || i == 0 ? (int)bits_take(bits, 8) : huffman_take(model, bits);
            if (delta < 0 || delta > 255) return false;
            s.rows[row] = (uint8_t)(raw ? delta : s.rows[row] ^ delta);
        }
        book->selectors[i] = s;
    }
    return !bits_are_over(bits);
}

static huffman_result read_selectors(bit_reader *bits, lz_book *book) {
    huffman model = {.symbols = NULL};
    if (bits_take(bits, 2) != 0) return HUFFMAN_BROKEN;
    const bool raw = bits_take(bits, 1);
    huffman_result result = raw ? HUFFMAN_FINE : huffman_read(bits, &model);
    if (result == HUFFMAN_FINE && !take_selectors(&model, bits, raw, book)) result = HUFFMAN_BROKEN;
    huffman_free(&model);
    return result;
}

/* ---- the codes of slices ---- */

static huffman_result read_codes(bit_reader *bits, lz_book *book) {
    huffman *const tables[] = {&book->predictions, &book->deltas, &book->selector_codes, &book->runs};
    for (unsigned i = 0; i < 4; ++i) {
        const huffman_result result = huffman_read(bits, tables[i]);
        if (result != HUFFMAN_FINE) return result;
    }
    book->history = bits_take(bits, 13);
    return bits_are_over(bits) ? HUFFMAN_BROKEN : HUFFMAN_FINE;
}

/* ---- all of it ---- */

static lz_image image_at(const uint8_t *bytes) {
    return (lz_image){u32_at(bytes), u32_at(bytes + 4), u32_at(bytes + 8), u32_at(bytes + 12),
                      u32_at(bytes + 16)};
}

/* Counts that the data has no bits for are refused before they take memory: an end point has at least two
 * codes, a selector four. */
static bool are_plausible(const lz_book *book, size_t endpoints_size, size_t selectors_size) {
    return book->endpoint_count > 0 && book->endpoint_count <= 4 * endpoints_size &&
           book->selector_count > 0 && book->selector_count <= 2 * selectors_size;
}

fathom_status lz_book_open(const uint8_t *global, size_t size, uint32_t level_count, lz_book *out,
                           lz_image *first, image_message *why) {
    *out = (lz_book){.endpoints = NULL};
    if (size < HEAD || (size - HEAD) / IMAGE < level_count) return broken(why, "global data");
    const uint8_t *at = global + HEAD + (size_t)IMAGE * level_count;
    size_t left = size - HEAD - (size_t)IMAGE * level_count, sizes[3];
    *first = image_at(global + HEAD);
    out->endpoint_count = global[0] | (uint32_t)global[1] << 8;
    out->selector_count = global[2] | (uint32_t)global[3] << 8;
    for (unsigned i = 0; i < 3; ++i) {
        sizes[i] = u32_at(global + 4 + 4 * i);
        if (sizes[i] > left) return broken(why, "global data");
        left -= sizes[i];
    }
    if (!are_plausible(out, sizes[0], sizes[1])) return broken(why, "global data");
    out->endpoints = malloc(out->endpoint_count * sizeof *out->endpoints);
    out->selectors = malloc(out->selector_count * sizeof *out->selectors);
    if (!out->endpoints || !out->selectors) return ktx2_no_memory(why);
    static huffman_result (*const read[3])(bit_reader *, lz_book *) = {read_endpoints, read_selectors,
                                                                       read_codes};
    static const char *const names[3] = {"code book of end points", "code book of selectors",
                                         "table of codes"};
    for (unsigned i = 0; i < 3; at += sizes[i++]) {
        bit_reader bits = {.bytes = at, .size = sizes[i]};
        const huffman_result result = read[i](&bits, out);
        if (result == HUFFMAN_NO_MEMORY) return ktx2_no_memory(why);
        if (result == HUFFMAN_BROKEN) return broken(why, names[i]);
    }
    return FATHOM_OK;
}

void lz_book_close(lz_book *book) {
    huffman *const tables[] = {&book->predictions, &book->deltas, &book->selector_codes, &book->runs};
    for (unsigned i = 0; i < 4; ++i) huffman_free(tables[i]);
    free(book->endpoints), free(book->selectors);
    *book = (lz_book){.endpoints = NULL};
}
