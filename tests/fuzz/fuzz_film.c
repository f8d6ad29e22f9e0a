#include "fuzz.h"

#include "film/film.h"

#include <stdlib.h>

#define SIDE 12
#define CHANNELS 4

void fuzz_film_make(fathom_film *film, fathom_settings *settings) {
    static const char *const names[CHANNELS] = {"R", "G", "B", "A"};
    fathom_settings_default(settings);
    fathom_settings_set_integrator(settings, FATHOM_INTEGRATOR_CLASSIC);
    settings->width = settings->height = 2 * WAVE_SIDE;
    *film = (fathom_film){.width = SIDE,
                          .height = SIDE,
                          .x = WAVE_SIDE - 6,
                          .y = WAVE_SIDE - 6,
                          .full_width = 2 * WAVE_SIDE,
                          .full_height = 2 * WAVE_SIDE,
                          .channel_count = CHANNELS};
    pthread_mutex_init(&film->lock, NULL);
    for (unsigned i = 0; i < CHANNELS; ++i) {
        film->channels[i] = (film_channel){.name = names[i], .data = calloc(SIDE * SIDE, sizeof(float))};
        if (!film->channels[i].data) abort();
    }
}

void fuzz_film_free(fathom_film *film) {
    pthread_mutex_destroy(&film->lock);
    for (unsigned i = 0; i < film->channel_count; ++i) free(film->channels[i].data);
}
