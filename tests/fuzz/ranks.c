/* Messages between the ranks of a render, as rank 0 and as another: u8 how, then each with its length as u16.
 * The film is the one of fuzz_film.c. */
#include "fuzz.h"

#include "job/ranks/ranks.h"

#include <sched.h>
#include <string.h>

enum { NOT_ROOT = 1, TO_AN_ERROR = 2, MANY_SAMPLES = 4 };

typedef struct post {
    const uint8_t *at, *end;
    atomic_bool empty;
} post;

static bool send_nowhere(void *user, uint32_t to, const void *bytes, size_t size) {
    (void)user, (void)to, (void)bytes, (void)size;
    return true;
}

static bool receive_next(void *user, uint32_t *from, const void **bytes, size_t *size) {
    post *p = user;
    if (p->end - p->at < 2) {
        atomic_store(&p->empty, true);
        return false;
    }
    const size_t left = (size_t)(p->end - p->at) - 2, wanted = (size_t)(p->at[0] | p->at[1] << 8);
    *from = 1, *size = wanted < left ? wanted : left;
    *bytes = p->at + 2;
    p->at += 2 + *size;
    return true;
}

/* Does no work, and hands over its results. */
static void work(const fathom_film *film, wave_share *share) {
    const wave_grid grid = film_waves(film);
    const atomic_bool stop = true;
    wave_result done = {.samples = 1};
    while (share->next(share->user, &stop, &done.unit)) {
        if (done.unit.wave >= grid.count || !done.unit.squares)
            fuzz_wrong("a unit of wave %u", done.unit.wave);
        const wave_region region = wave_grid_region(&grid, done.unit.wave);
        if (done.unit.squares & ~wave_region_bits(region)) fuzz_wrong("a unit beyond the film");
        share->take(share->user, &done);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (!size) return 0;
    const unsigned how = data[0];
    fathom_settings settings;
    fathom_film film;
    ranks *r;
    wave_share *share;
    post p = {.at = data + 1, .end = data + size};
    fathom_ranks options;
    fuzz_film_make(&film, &settings);
    if (how & TO_AN_ERROR) settings.target_error = 0.1;
    if (how & MANY_SAMPLES) settings.spp = 256;
    fathom_ranks_default(&options);
    options.rank = how & NOT_ROOT, options.count = 3;
    options.user = &p, options.send = send_nowhere, options.receive = receive_next;
    fuzz_begin(size, 64);
    fathom_status status = ranks_open(fuzz_context(), &options, &settings, &film, &r);
    if (status == FATHOM_OK) status = ranks_begin(r, "embree", NULL, &share);
    if (status != FATHOM_OK) fuzz_wrong("status %d at the beginning", (int)status);
    while (!atomic_load(&p.empty)) sched_yield();
    work(&film, share);
    status = ranks_close(r, FATHOM_OK);
    if (status != FATHOM_OK && status != FATHOM_BAD_INPUT) fuzz_wrong("status %d", (int)status);
    fuzz_end();
    fuzz_film_free(&film);
    return 0;
}
