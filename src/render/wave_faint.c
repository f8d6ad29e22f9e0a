/* Shadow rays that are not worth casting. What is left out of a sample, were every light seen, is at most
 * max_loss + max_relative_loss R, R its radiance so far: radiance only grows, so R is at most the sample's
 * own in the end. A pixel is the mean of its samples, and loses at most max_loss + max_relative_loss times
 * its value. Each sample goes by its own paths alone, in their order, so grouping changes nothing. */
#include "render/wave.h"

/* Rounded upwards: however many are added, `lost` is never less than their sum. */
static float sum_above(float lost, float gain) { return (lost + gain) * (1 + 0x1p-21f); }

static bool may_lose(const wave *w, uint32_t slot, const float gain[3]) {
    const fathom_settings *settings = &w->plan->settings;
    for (int c = 0; c < 3; ++c) {
        float most = settings->max_loss + settings->max_relative_loss * w->radiance[c][slot];
        if (!(sum_above(w->lost[c][slot], gain[c]) <= most)) return false;
    }
    return true;
}

void wave_spare_faint(wave *w, const surface_block *s, light_block *arriving) {
    for (uint32_t i = 0; i < s->count; ++i) {
        const float gain[3] = {arriving->radiance[0][i], arriving->radiance[1][i], arriving->radiance[2][i]};
        if (!(gain[0] + gain[1] + gain[2] > 0) || !may_lose(w, s->slot[i], gain)) continue;
        for (int c = 0; c < 3; ++c) {
            w->lost[c][s->slot[i]] = sum_above(w->lost[c][s->slot[i]], gain[c]);
            arriving->radiance[c][i] = 0;
        }
        arriving->distance[i] = 0;
        ++w->rays.faint;
    }
}
