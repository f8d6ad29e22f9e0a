#include "job/adaptive_record.h"

#include <string.h>

/* The next pass needs only the sum of the first two quarters of a pixel's samples. The other quarters served
 * the error, which is here. */
typedef struct sums_record {
    double square_error[WAVE_SQUARES];
    uint64_t rays[WAVE_SQUARES];
    uint32_t done[WAVE_SQUARES];
    double rgb[3][WAVE_SLOTS], half[3][WAVE_SLOTS];
} sums_record;

_Static_assert(sizeof(sums_record) == WAVE_SQUARES * 20 + 6 * WAVE_SLOTS * 8, "no bytes between the fields");
_Static_assert(sizeof(hit_sums) == WAVE_SLOTS * (8 * 8 + 14 * 4), "no bytes between the fields");

size_t adaptive_record_bytes(bool hits) { return sizeof(sums_record) + (hits ? sizeof(hit_sums) : 0); }

void adaptive_record_save(const adaptive_wave *a, bool hits, unsigned char *out) {
    memcpy(out + offsetof(sums_record, square_error), a->square_error, sizeof a->square_error);
    memcpy(out + offsetof(sums_record, rays), a->rays, sizeof a->rays);
    memcpy(out + offsetof(sums_record, done), a->done, sizeof a->done);
    memcpy(out + offsetof(sums_record, rgb), a->sums.rgb, sizeof a->sums.rgb);
    memcpy(out + offsetof(sums_record, half), a->parts[1], sizeof a->parts[1]);
    if (hits) memcpy(out + sizeof(sums_record), a->sums.hits, sizeof *a->sums.hits);
}

bool adaptive_record_check(const unsigned char *record, uint32_t spp) {
    double error[WAVE_SQUARES];
    uint64_t rays[WAVE_SQUARES];
    uint32_t done[WAVE_SQUARES];
    memcpy(rays, record + offsetof(sums_record, rays), sizeof rays);
    memcpy(error, record + offsetof(sums_record, square_error), sizeof error);
    memcpy(done, record + offsetof(sums_record, done), sizeof done);
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) {
        bool rated = error[s] >= 0 && (rays[s] || error[s] > 0); /* an error over rays is a number */
        if (!rated || done[s] > spp || (done[s] & (done[s] - 1))) return false;
    }
    return true;
}

void adaptive_record_load(const fathom_settings *settings, const unsigned char *record, bool hits,
                          adaptive_wave *a) {
    memcpy(a->square_error, record + offsetof(sums_record, square_error), sizeof a->square_error);
    memcpy(a->rays, record + offsetof(sums_record, rays), sizeof a->rays);
    memcpy(a->done, record + offsetof(sums_record, done), sizeof a->done);
    memcpy(a->taken, a->done, sizeof a->taken);
    memcpy(a->sums.rgb, record + offsetof(sums_record, rgb), sizeof a->sums.rgb);
    memcpy(a->parts[1], record + offsetof(sums_record, half), sizeof a->parts[1]);
    if (hits) memcpy(a->sums.hits, record + sizeof(sums_record), sizeof *a->sums.hits);
    adaptive_rate(settings, a);
}
