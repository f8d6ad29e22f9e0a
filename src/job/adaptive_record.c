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

/* Copies a field to its place in the record, or back. */
static void copy(unsigned char **record, bool save, void *field, size_t bytes) {
    if (bytes) memcpy(save ? *record : field, save ? field : *record, bytes);
    *record += bytes;
}

static void copy_wave(adaptive_wave *a, bool save, unsigned char *record) {
    for (uint32_t run = 0; run < ADAPTIVE_RUNS; ++run) {
        adaptive_run *r = &a->runs[run];
        copy(&record, save, r->square_error, sizeof r->square_error);
        copy(&record, save, r->rays, sizeof r->rays);
        copy(&record, save, r->done, sizeof r->done);
    }
    for (uint32_t run = 0; run < ADAPTIVE_RUNS; ++run)
        copy(&record, save, a->runs[run].rgb, sizeof a->runs[run].rgb);
    copy(&record, save, a->layers, layer_bytes(a->parts));
    copy(&record, save, a->mattes, matte_bytes(a->parts));
    copy(&record, save, a->hits, a->hits ? sizeof *a->hits : 0);
}

void adaptive_record_save(const adaptive_wave *a, unsigned char *out) {
    copy_wave((adaptive_wave *)(uintptr_t)a, true, out); /* is only read */
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
    copy_wave(a, false, (unsigned char *)(uintptr_t)record); /* is only read */
    for (uint32_t run = 0; run < ADAPTIVE_RUNS; ++run)
        memcpy(a->runs[run].taken, a->runs[run].done, sizeof a->runs[run].taken);
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) a->seen[s] = max_u32(a->runs[0].done[s], a->runs[1].done[s]);
    adaptive_rate(settings, a);
}
