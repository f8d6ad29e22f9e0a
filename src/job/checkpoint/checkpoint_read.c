/* Reads a checkpoint from bytes. The only allocations are the records of waves. Their sizes follow from this
 * render, and their bytes were found in the file before. */
#include "base/hash.h"
#include "job/adaptive_record.h"
#include "job/checkpoint/checkpoint_state.h"

#include <stdlib.h>
#include <string.h>

typedef struct reading {
    fathom_context *context;
    const char *name;
    const unsigned char *at;
    size_t left;
    const fathom_film *film;
    checkpoint_state *state;
} reading;

static fathom_status damaged(const reading *r, const char *what) {
    return fail_file(r->context, FATHOM_BAD_INPUT, r->name,
                     "the checkpoint is damaged: %s; remove it to render from the beginning", what);
}

/* NULL if fewer bytes are left. */
static const unsigned char *take(reading *r, size_t bytes) {
    if (r->left < bytes) return NULL;
    const unsigned char *from = r->at;
    r->at += bytes, r->left -= bytes;
    return from;
}

static bool copy(reading *r, void *to, size_t bytes) {
    const unsigned char *from = take(r, bytes);
    if (from) memcpy(to, from, bytes);
    return from;
}

static fathom_status check_format(reading *r) {
    uint32_t format;
    const unsigned char *magic = take(r, strlen(CHECKPOINT_MAGIC));
    if (!magic || memcmp(magic, CHECKPOINT_MAGIC, strlen(CHECKPOINT_MAGIC)) != 0) {
        return fail_file(r->context, FATHOM_BAD_INPUT, r->name,
                         "is not a checkpoint; expected a file that a render with a checkpoint wrote");
    }
    if (!copy(r, &format, sizeof format)) return damaged(r, "it ends too early");
    if (format == CHECKPOINT_FORMAT) return FATHOM_OK;
    return fail_file(r->context, FATHOM_BAD_INPUT, r->name,
                     "is a checkpoint of format %u, and this Fathom reads format %u; finish it with the "
                     "Fathom that began it, or remove it",
                     format, CHECKPOINT_FORMAT);
}

/* Checks the hash of all bytes before the last eight. */
static fathom_status check_sum(reading *r, const unsigned char *bytes, size_t size) {
    uint64_t sum;
    if (r->left < sizeof sum) return damaged(r, "it ends too early");
    r->left -= sizeof sum;
    memcpy(&sum, bytes + size - sizeof sum, sizeof sum);
    return hash_of(bytes, size - sizeof sum) == sum
               ? FATHOM_OK
               : damaged(r, "its checksum does not fit, or it was cut short");
}

static fathom_status read_key(reading *r, checkpoint_key *out) {
    if (!copy(r, out, sizeof *out)) return damaged(r, "its head is not whole");
    return checkpoint_key_is_whole(out) ? FATHOM_OK : damaged(r, "a text in its head has no end");
}

static fathom_status read_record(reading *r, uint32_t place) {
    checkpoint_state *state = r->state;
    const size_t bytes = adaptive_record_bytes(state->parts);
    const unsigned char *from = take(r, bytes);
    if (!from) return damaged(r, "a wave's record is not whole");
    if (!adaptive_record_check(from, state->spp)) return damaged(r, "a wave's record makes no sense");
    state->records[place] = malloc(bytes);
    if (!state->records[place]) return fail_memory(r->context, bytes);
    memcpy(state->records[place], from, bytes);
    return FATHOM_OK;
}

/* Records are in ascending order, so none occurs twice. */
static fathom_status read_records(reading *r) {
    for (uint64_t next = 0;;) {
        uint32_t head[2];
        if (!copy(r, head, sizeof head) || head[1]) return damaged(r, "it ends among the waves' records");
        if (head[0] == UINT32_MAX) return FATHOM_OK;
        if (head[0] < next || head[0] >= r->state->grid.count)
            return damaged(r, "a record of a wave that there is not");
        fathom_status status = read_record(r, head[0]);
        if (status != FATHOM_OK) return status;
        next = (uint64_t)head[0] + 1;
    }
}

static fathom_status read_progress(reading *r) {
    checkpoint_state *s = r->state;
    if (!copy(r, &s->samples, sizeof s->samples) || !copy(r, &s->rays, sizeof s->rays) ||
        !copy(r, &s->error, sizeof s->error) || !copy(r, &s->seconds, sizeof s->seconds))
        return damaged(r, "it ends too early");
    if (!(s->error >= 0) || !(s->seconds >= 0 && s->seconds < 1e12))
        return damaged(r, "its error or time makes no sense");
    if (!copy(r, s->squares, s->grid.count * sizeof *s->squares)) return damaged(r, "it ends too early");
    for (uint32_t i = 0; i < s->grid.count; ++i) {
        if (s->squares[i] & ~wave_region_bits(wave_grid_region(&s->grid, i)))
            return damaged(r, "a square beyond the film");
    }
    return FATHOM_OK;
}

static bool read_wave(reading *r, uint32_t wave) {
    const uint64_t squares = r->state->squares[wave];
    const unsigned char *from = take(r, checkpoint_pixel_bytes(r->film->channel_count, squares));
    if (from) checkpoint_pixels_load(&r->state->grid, r->film, wave, squares, from);
    return from;
}

/* Discards the records of waves with finished squares: a record may have been saved just before its wave
 * finished. */
static fathom_status read_film(reading *r) {
    checkpoint_state *state = r->state;
    for (uint32_t i = 0; i < state->grid.count; ++i) {
        if (!read_wave(r, i)) return damaged(r, "it ends among the pixels");
        if (!state->squares[i]) continue;
        free(state->records[i]);
        state->records[i] = NULL;
    }
    return r->left ? damaged(r, "it goes on after its end") : FATHOM_OK;
}

fathom_status checkpoint_read(fathom_context *context, const char *name, const unsigned char *bytes,
                              size_t size, const checkpoint_key *key, const fathom_film *film,
                              checkpoint_state *state, char tracer[128]) {
    reading r = {context, name, bytes, size, film, state};
    checkpoint_key saved;
    fathom_status status = check_format(&r);
    if (status == FATHOM_OK) status = check_sum(&r, bytes, size);
    if (status == FATHOM_OK) status = read_key(&r, &saved);
    if (status == FATHOM_OK) status = checkpoint_key_compare(context, name, &saved, key);
    if (status == FATHOM_OK) status = read_records(&r);
    if (status == FATHOM_OK) status = read_progress(&r);
    if (status == FATHOM_OK) status = read_film(&r);
    if (status == FATHOM_OK) memcpy(tracer, saved.tracer, sizeof saved.tracer);
    return status;
}
