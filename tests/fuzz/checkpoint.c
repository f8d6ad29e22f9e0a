/* Checkpoints of a film of 12 × 12 pixels that lies in four waves. The last eight bytes, a checksum's place,
 * say how: unless bit 0 is set the sum is made right, unless bit 1 is set the key is taken for this render's
 * own, so that all behind them is reached; bit 2 is for records with hits.
 *
 * A wave's record takes 50 KB or more, nearly all of it sums of pixels, of which any will do: unless bit 3 is
 * set, an input has eight bytes in their place, which are repeated here. Inputs of a kilobyte then reach what
 * is said of records and what follows them. */
#include "fuzz.h"

#include "base/hash.h"
#include "integrate/plan.h"
#include "job/adaptive_record.h"
#include "job/checkpoint/checkpoint_state.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WAVES 4
#define KEY_AT 12 /* past the magic number and the format */
#define HEAD_BYTES (KEY_AT + sizeof(checkpoint_key))
#define SQUARE_BYTES ((size_t)56) /* of a record, besides the sums of its pixels */
#define SUM_BYTES sizeof(uint64_t)
/* The wave's number, what its record says of squares, and eight bytes for the sums. */
#define SHORT_RECORD (8 + WAVE_SQUARES * SQUARE_BYTES + SUM_BYTES)
#define INPUT_MOST ((size_t)2 << 20)
#define RECORD_MOST ((size_t)512 << 10)

enum { AS_SUMMED = 1, OF_ANOTHER = 2, WITH_HITS = 4, WHOLE_RECORDS = 8 };

static void adopt_key(const uint8_t *bytes, size_t size, checkpoint_key *key) {
    char tracer[sizeof key->tracer];
    if (size < HEAD_BYTES) return;
    memcpy(tracer, key->tracer, sizeof tracer);
    memcpy(key, bytes + KEY_AT, sizeof *key);
    memcpy(key->tracer, tracer, sizeof tracer);
}

static void correct_sum(uint8_t *bytes, size_t size) {
    const uint64_t sum = hash_of(bytes, size - sizeof(uint64_t));
    memcpy(bytes + size - sizeof sum, &sum, sizeof sum);
}

/* How many records of an input, which may end anywhere, are to be filled in. */
static size_t count_records(const uint8_t *data, size_t size) {
    static const uint8_t end[] = {0xff, 0xff, 0xff, 0xff};
    size_t count = 0;
    for (size_t at = HEAD_BYTES; count < WAVES && at + SHORT_RECORD <= size; at += SHORT_RECORD, ++count) {
        if (memcmp(data + at, end, sizeof end) == 0) break;
    }
    return count;
}

static uint8_t *put(uint8_t *to, const uint8_t *from, size_t bytes) {
    memcpy(to, from, bytes);
    return to + bytes;
}

static void fill_in(const uint8_t *data, size_t size, size_t records, size_t sums, uint8_t *out) {
    const uint8_t *from = data, *end = data + size;
    if (records) {
        out = put(out, from, HEAD_BYTES);
        from += HEAD_BYTES;
    }
    for (; records; --records, from += SHORT_RECORD) {
        const size_t squares = SHORT_RECORD - SUM_BYTES;
        out = put(out, from, squares);
        memcpy(out, from + squares, SUM_BYTES);
        for (size_t k = SUM_BYTES; k < sums; k *= 2) memcpy(out + k, out, k < sums - k ? k : sums - k);
        out += sums;
    }
    put(out, from, (size_t)(end - from));
}

/* What rendering does with a record that was let in. */
static void resume(const fathom_settings *settings, const checkpoint_state *state) {
    static hit_sums hits;
    static adaptive_wave a;
    const render_plan plan = {.settings = *settings};
    a.hits = state->parts.hits ? &hits : NULL;
    for (uint32_t i = 0; i < state->grid.count; ++i) {
        if (!state->records[i]) continue;
        adaptive_begin(&plan, i % 2 * WAVE_SIDE, i / 2 * WAVE_SIDE, &a);
        adaptive_record_load(settings, state->records[i], &a);
        for (unsigned run = 0; run < ADAPTIVE_RUNS; ++run) {
            if (isnan(a.runs[run].error) || isnan(a.runs[run].priority))
                fuzz_wrong("wave %u without an error", i);
        }
    }
}

static void read(const uint8_t *bytes, size_t size, unsigned how) {
    fathom_settings settings;
    fathom_film film;
    checkpoint_key key;
    checkpoint_state state;
    char tracer[128] = "";
    fuzz_film_make(&film, &settings);
    checkpoint_key_of(&settings, 7, &key);
    if (!(how & OF_ANOTHER)) adopt_key(bytes, size, &key);
    if (!checkpoint_state_create(&settings, &film, (film_parts){.hits = how & WITH_HITS}, &state)) abort();
    if (state.grid.count != WAVES) abort();
    fuzz_put_file(0, "a.checkpoint", bytes, size);
    fathom_status status =
        checkpoint_read(fuzz_context(), "a.checkpoint", bytes, size, &key, &film, &state, tracer);
    fuzz_judge(status);
    if (status == FATHOM_OK) resume(&settings, &state);
    if (status == FATHOM_OK && !memchr(tracer, '\0', sizeof tracer)) fuzz_wrong("a tracer without an end");
    checkpoint_state_destroy(&state);
    fuzz_film_free(&film);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static uint8_t room[INPUT_MOST + WAVES * RECORD_MOST];
    if (size > INPUT_MOST) return 0;
    const unsigned how = size < SUM_BYTES ? AS_SUMMED : data[size - 1];
    const size_t sums =
        adaptive_record_bytes((film_parts){.hits = how & WITH_HITS}) - WAVE_SQUARES * SQUARE_BYTES;
    const size_t records = how & WHOLE_RECORDS ? 0 : count_records(data, size);
    const size_t length = size + records * (sums - SUM_BYTES);
    if (length > sizeof room) abort();
    /* At the end of its room, so that AddressSanitizer sees a read beyond. */
    uint8_t *bytes = room + sizeof room - length;
    fill_in(data, size, records, sums, bytes);
    if (!(how & AS_SUMMED)) correct_sum(bytes, length);
    fuzz_begin(length, 16);
    read(bytes, length, how);
    fuzz_end();
    return 0;
}
