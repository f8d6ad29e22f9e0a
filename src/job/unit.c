#include "job/unit.h"

#include "trace/trace.h"

static uint64_t count(const unit_result *r, bool samples) {
    uint64_t sum = 0;
    for (uint64_t left = r->squares; left; left &= left - 1) {
        const uint32_t s = (uint32_t)__builtin_ctzll(left);
        const wave_square square = wave_square_at(&r->region, s);
        const bool whole = wave_square_is_whole(&r->region, &square);
        const int pixels = whole ? LANES : __builtin_popcount(wave_square_pixels(&r->region, &square));
        sum += (uint64_t)pixels * (samples ? r->samples[s] : 1);
    }
    return sum;
}

uint32_t unit_groups(const fathom_settings *s) { return s->aovs & FATHOM_AOV_ERROR ? SAMPLE_GROUPS : 1; }

uint64_t unit_pixels(const unit_result *r) { return count(r, false); }
uint64_t unit_samples(const unit_result *r) { return count(r, true); }

/* Squares without samples, because the time ended first, keep their pixels of the film. Threads that merge or
 * resume must round like rendering threads, which flush denormals. */
static void to_film(void *user, const unit_result *r) {
    fathom_film *film = user;
    const unsigned state = trace_thread_begin();
    pthread_mutex_lock(&film->lock);
    for (uint64_t left = r->squares; left; left &= left - 1) {
        const uint32_t s = (uint32_t)__builtin_ctzll(left);
        const wave_square square = wave_square_at(&r->region, s);
        if (r->samples[s])
            pixel_sums_store_square(r->sums, &r->region, &square, (sums_count){r->samples[s], r->hits[s]},
                                    film);
    }
    pthread_mutex_unlock(&film->lock);
    trace_thread_end(state);
}

unit_sink unit_film_sink(fathom_film *film) { return (unit_sink){to_film, film}; }
