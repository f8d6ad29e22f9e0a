/* Scout paths run before the render, to find out which light the scene blocks. This file chooses their
 * light samples, and adapts the sampling probabilities to their results. */
#include "light/emitters_inner.h"

#include <stdlib.h>
#include <string.h>

/* ---- the paths' light samples ---- */

/* Three quarters of the light samples go outside, the others to lamps and suns. */
#define BEYOND 0.75

static emitter_shares scout_shares(const emitters *e, bool outside) {
    const bool finite = e->finite_count > 0, suns = e->sun_count > 0;
    double left = 1;
    if (outside) left = finite || suns ? 1 - BEYOND : 0;
    const double each = left / (finite && suns ? 2 : 1);
    return (emitter_shares){{finite ? each : 0, 1 - left, suns ? each : 0}};
}

bool emitters_scout(const emitters *e, emitters **out) {
    double sum = 0;
    *out = NULL;
    for (uint32_t k = 0; k < e->sky_count; ++k) sum += e->skies[k].chance;
    const bool painted = sum > 0 && e->shares.of[EMITTER_OUTSIDE] > 0,
               even = !e->sky_count && e->background_chance > 0;
    if (!painted && !even && e->finite_count < 2 && !(e->finite_count && e->sun_count)) return true;
    emitters *scout = malloc(sizeof *scout + e->sky_count * sizeof *e->skies);
    if (!scout) return false;
    *scout = *e;
    *out = scout;
    if (e->one.sky) return true;
    scout->skies = (emitter_sky *)(scout + 1);
    for (uint32_t k = 0; k < e->sky_count; ++k) {
        scout->skies[k] = e->skies[k];
        if (sum > 0) scout->skies[k].chance *= 0.5 / sum;
    }
    scout->background_chance = e->sky_count ? 0.5 : 1;
    scout->shares = scout_shares(e, painted || even);
    scout->one = (emitter_one){0};
    return true;
}

/* ---- lessons ---- */

/* An even background is sampled as an image if little of it is visible, and if it matters next to other
 * lights: see bench/path_tracing.md. */
#define LITTLE_SEEN 0.25
#define FAINT 0.12

static bool learn_even(emitters *e, const emitter_lesson *from) {
    environment *sky;
    if (from->seen > LITTLE_SEEN || from->outside < FAINT) return true;
    bool fine = environment_even(e->w->scene->context, e->background, &sky) == FATHOM_OK &&
                environment_learn(sky, from->rays, from->ray_count);
    if (!fine || !environment_sky(sky)->roots) {
        environment_destroy(sky);
        return fine;
    }
    e->skies[e->sky_count++] = (emitter_sky){sky, 1, e->background_group};
    memset(e->background, 0, sizeof e->background);
    free(e->one.face);
    e->background_chance = 0, e->one = (emitter_one){0};
    emitters_share(e);
    return true;
}

static bool learn_skies(emitters *e, const emitter_lesson *from) {
    bool fine = true;
    for (uint32_t k = 0; k < e->sky_count && fine; ++k)
        fine = environment_learn(e->skies[k].image, from->rays, from->ray_count);
    return fine;
}

bool emitters_learn(emitters *e, const emitter_lesson *from) {
    const bool fine = e->sky_count ? learn_skies(e, from) : learn_even(e, from);
    return fine && emitters_learn_seen(e, from) && emitters_learn_views(e, from) &&
           emitters_learn_regions(e, from);
}
