#include "job/adaptive_record.h"

#include <string.h>

typedef struct squares_record {
    double square_error[WAVE_SQUARES];
    uint64_t rays[2][WAVE_SQUARES];
    uint32_t done[WAVE_SQUARES];
} squares_record;

typedef struct runs_record {
    squares_record squares[ADAPTIVE_RUNS];
    double rgb[ADAPTIVE_RUNS][SAMPLE_GROUPS][3][WAVE_SLOTS];
} runs_record;

_Static_assert(sizeof(squares_record) == WAVE_SQUARES * 28, "no bytes between the fields");
_Static_assert(sizeof(runs_record) == 2 * (WAVE_SQUARES * 28 + 12 * WAVE_SLOTS * 8), "nor between these");
_Static_assert(sizeof(hit_sums) == WAVE_SLOTS * (8 * 8 + 18 * 4), "nor between these");

static size_t layer_bytes(film_parts parts) {
    return adaptive_layer_count(parts) * WAVE_SLOTS * sizeof(double);
}

static size_t matte_bytes(film_parts parts) { return parts.matte_count * WAVE_SLOTS * sizeof(matte_list); }

/* Order: the runs, the layers, the mattes, the first hits. */
size_t adaptive_record_bytes(film_parts parts) { return sizeof(runs_record) + adaptive_bytes(parts); }

void adaptive_record_save(const adaptive_wave *a, unsigned char *out) {
    for (uint32_t run = 0; run < ADAPTIVE_RUNS; ++run) {
        const adaptive_run *r = &a->runs[run];
        squares_record squares;
        memcpy(squares.square_error, r->square_error, sizeof r->square_error);
        memcpy(squares.rays, r->rays, sizeof r->rays);
        memcpy(squares.done, r->done, sizeof r->done);
        memcpy(out + run * sizeof squares, &squares, sizeof squares);
        memcpy(out + offsetof(runs_record, rgb) + run * sizeof r->rgb, r->rgb, sizeof r->rgb);
    }
    out += sizeof(runs_record);
    if (a->layers) memcpy(out, a->layers, layer_bytes(a->parts));
    out += layer_bytes(a->parts);
    if (a->mattes) memcpy(out, a->mattes, matte_bytes(a->parts));
    if (a->hits) memcpy(out + matte_bytes(a->parts), a->hits, sizeof *a->hits);
}

bool adaptive_record_check(const unsigned char *record, uint32_t spp) {
    squares_record r;
    for (uint32_t run = 0; run < ADAPTIVE_RUNS; ++run) {
        memcpy(&r, record + run * sizeof r, sizeof r);
        for (uint32_t s = 0; s < WAVE_SQUARES; ++s) {
            const double error = r.square_error[s];
            const bool rated = error >= 0 && (r.rays[run][s] || error > 0); /* so error / rays is not NaN */
            if (!rated || r.done[s] > spp || (r.done[s] & (r.done[s] - 1))) return false;
        }
    }
    return true;
}

void adaptive_record_load(const fathom_settings *settings, const unsigned char *record, adaptive_wave *a) {
    for (uint32_t run = 0; run < ADAPTIVE_RUNS; ++run) {
        adaptive_run *r = &a->runs[run];
        squares_record squares;
        memcpy(&squares, record + run * sizeof squares, sizeof squares);
        memcpy(r->square_error, squares.square_error, sizeof r->square_error);
        memcpy(r->rays, squares.rays, sizeof r->rays);
        memcpy(r->done, squares.done, sizeof r->done);
        memcpy(r->taken, squares.done, sizeof r->taken);
        memcpy(r->rgb, record + offsetof(runs_record, rgb) + run * sizeof r->rgb, sizeof r->rgb);
    }
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) a->seen[s] = max_u32(a->runs[0].done[s], a->runs[1].done[s]);
    record += sizeof(runs_record);
    if (a->layers) memcpy(a->layers, record, layer_bytes(a->parts));
    record += layer_bytes(a->parts);
    if (a->mattes) memcpy(a->mattes, record, matte_bytes(a->parts));
    if (a->hits) memcpy(a->hits, record + matte_bytes(a->parts), sizeof *a->hits);
    adaptive_rate(settings, a);
}
