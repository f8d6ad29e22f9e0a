/* Slices of BasisLZ, and the texels of their blocks. */
#include "helper/ktx2/basis_lz.h"

#include <stdlib.h>
#include <string.h>

/* Where a block takes its end points from. */
enum { LEFT, ABOVE, ABOVE_LEFT, CODED };
enum { REPEAT_PREDICTIONS = 256, REPEATS_MIN = 3, RUN_MIN = 3, RUN_LONG = 63 };

struct lz_slice {
    const lz_book *book;
    bit_reader bits;
    uint32_t blocks_across, row;
    /* The predictions of 2 × 2 blocks are one code, which may be repeated. */
    uint32_t last_predictions, prediction_repeats;
    uint32_t run;      /* further blocks that take the first selector of the history */
    uint32_t *history; /* selectors that were used */
    uint32_t oldest;   /* the next to be replaced; only the second half is */
    uint16_t *above;   /* end points: of this row up to the present block, of the row above from there on */
    uint8_t *below;    /* predictions for the next, odd row, of two blocks each */
};

lz_slice *lz_slice_open(const lz_book *book, const uint8_t *bytes, size_t size, uint32_t blocks_across) {
    lz_slice *s = malloc(sizeof *s);
    if (!s) return NULL;
    *s = (lz_slice){.book = book, .bits = {.bytes = bytes, .size = size}, .blocks_across = blocks_across};
    s->history = calloc(book->history + 1, sizeof *s->history);
    s->oldest = book->history / 2;
    s->above = calloc(blocks_across, sizeof *s->above);
    s->below = calloc(blocks_across / 2 + 1, sizeof *s->below);
    if (s->history && s->above && s->below) return s;
    lz_slice_close(s);
    return NULL;
}

void lz_slice_close(lz_slice *s) {
    if (!s) return;
    free(s->history), free(s->above), free(s->below);
    free(s);
}

/* A number in parts of `size` bits, the lowest first. A bit after each says whether another follows. */
static uint32_t take_parts(bit_reader *bits, unsigned size) {
    uint32_t value = 0;
    for (unsigned shift = 0; shift < 32; shift += size) {
        const uint32_t part = bits_take(bits, size + 1);
        value |= (part & ((1u << size) - 1)) << shift;
        if (!(part >> size)) break;
    }
    return value;
}

/* ---- end points ---- */

/* The predictions of a group of 2 × 2 blocks, two bits each; -1 if broken. */
static int take_predictions(lz_slice *s) {
    if (s->prediction_repeats) {
        --s->prediction_repeats;
        return (int)s->last_predictions;
    }
    const int code = huffman_take(&s->book->predictions, &s->bits);
    if (code > REPEAT_PREDICTIONS) return -1;
    if (code == REPEAT_PREDICTIONS)
        s->prediction_repeats = take_parts(&s->bits, 4) + REPEATS_MIN - 1;
    else if (code >= 0)
        s->last_predictions = (uint32_t)code;
    return code < 0 ? -1 : (int)s->last_predictions;
}

/* *above_left: the end point of the block above and to the left. False if broken. */
static bool take_endpoint(lz_slice *s, uint32_t x, unsigned prediction, uint32_t above_left, uint32_t *last) {
    int delta;
    switch (prediction) {
    case LEFT: return x > 0;
    case ABOVE: *last = s->above[x]; return s->row > 0;
    case ABOVE_LEFT: *last = above_left; return s->row > 0 && x > 0;
    default: break;
    }
    delta = huffman_take(&s->book->deltas, &s->bits);
    if (delta < 0) return false;
    *last += (uint32_t)delta;
    if (*last >= s->book->endpoint_count) *last -= s->book->endpoint_count;
    return *last < s->book->endpoint_count;
}

/* ---- selectors ---- */

/* Moves an entry of the history halfway to the front. */
static uint32_t use_history(lz_slice *s, uint32_t index) {
    const uint32_t selector = s->history[index];
    s->history[index] = s->history[index / 2];
    s->history[index / 2] = selector;
    return selector;
}

static void remember(lz_slice *s, uint32_t selector) {
    if (!s->book->history) return;
    s->history[s->oldest++] = selector;
    if (s->oldest == s->book->history) s->oldest = s->book->history / 2;
}

/* Codes beyond the selectors are places in the history, and the one beyond those is a run of its first place.
 */
static bool take_selector(lz_slice *s, uint32_t *out) {
    const uint32_t count = s->book->selector_count;
    int code = (int)count;
    if (s->run) {
        --s->run;
    } else {
        code = huffman_take(&s->book->selector_codes, &s->bits);
        if (code == (int)(count + s->book->history)) {
            const int length = huffman_take(&s->book->runs, &s->bits);
            if (length < 0 || length > RUN_LONG) return false;
            s->run = (length == RUN_LONG ? take_parts(&s->bits, 7) : (uint32_t)length) + RUN_MIN - 1;
            code = (int)count;
        }
    }
    if (code < 0 || (uint32_t)code >= count + s->book->history) return false;
    *out = (uint32_t)code;
    if (*out < count)
        remember(s, *out);
    else
        *out = use_history(s, *out - count);
    return *out < count;
}

/* ---- blocks ---- */

static uint8_t clamp(int value) { return (uint8_t)(value < 0 ? 0 : value > 255 ? 255 : value); }

/* ETC1 with one subblock: colours of five bits, to which each texel adds one of four modifiers. */
static void put_block(const lz_endpoint *e, const lz_selector *selector, uint8_t *texels, size_t row_bytes) {
    static const uint8_t modifiers[8][2] = {{2, 8},   {5, 17},  {9, 29},   {13, 42},
                                            {18, 60}, {24, 80}, {33, 106}, {47, 183}};
    const int low = modifiers[e->table][0], high = modifiers[e->table][1];
    const int add[4] = {-high, -low, low, high};
    uint8_t colors[4][3];
    for (unsigned i = 0; i < 4; ++i)
        for (unsigned c = 0; c < 3; ++c) colors[i][c] = clamp((e->color[c] << 3 | e->color[c] >> 2) + add[i]);
    for (unsigned y = 0; y < 4; ++y, texels += row_bytes)
        for (unsigned x = 0; x < 4; ++x)
            memcpy(texels + 4 * (size_t)x, colors[(selector->rows[y] >> (2 * x)) & 3], 3);
}

bool lz_slice_next(lz_slice *s, uint8_t *texels) {
    uint32_t last = s->row ? s->above[s->blocks_across - 1] : 0, above_left = 0, selector = 0;
    unsigned predictions = 0;
    for (uint32_t x = 0; x < s->blocks_across; ++x, predictions >>= 2) {
        if (x % 2 == 0 && s->row % 2 == 0) {
            const int taken = take_predictions(s);
            if (taken < 0) return false;
            predictions = (unsigned)taken;
            s->below[x / 2] = (uint8_t)(predictions >> 4);
        } else if (x % 2 == 0) {
            predictions = s->below[x / 2];
        }
        if (!take_endpoint(s, x, predictions & 3, above_left, &last) || !take_selector(s, &selector) ||
            bits_are_over(&s->bits))
            return false;
        above_left = s->above[x];
        s->above[x] = (uint16_t)last;
        put_block(&s->book->endpoints[last], &s->book->selectors[selector], texels + (size_t)x * 16,
                  (size_t)s->blocks_across * 16);
    }
    ++s->row;
    return true;
}
