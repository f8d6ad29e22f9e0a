/* The light groups of emitters. */
#include "light/emitters_inner.h"
#include "math/rgb.h"

#include <string.h>

uint8_t emitters_group_of(const emitters *e, uint32_t emitter) {
    if (emitter >= e->surface_count) return e->lamps[emitter - e->surface_count].group;
    const emitter_run *run = emitters_run_of(e, emitter);
    const uint32_t primitive = emitters_primitive(e, run, emitter - run->first);
    return light_group_at(e->groups, world_object(e->w, run->geometry, primitive),
                          world_material(e->w, run->geometry, primitive, run->instance));
}

void emitters_note_groups(emitters *e, const light_groups *groups) {
    e->groups = groups;
    if (!groups) return;
    e->background_group = groups->of[FATHOM_SOURCE_BACKGROUND][0];
    bool known = rgb_any(e->background);
    e->outside_group = e->background_group;
    for (uint32_t i = 0; i < e->sky_count; ++i) {
        const uint8_t group = i < e->w->scene->environments.count ? groups->of[FATHOM_SOURCE_ENVIRONMENT][i]
                                                                  : e->background_group;
        e->skies[i].group = group;
        e->outside_group = known && group != e->outside_group ? LIGHT_GROUP_OUTSIDE : group;
        known = true;
    }
}

uint8_t emitters_outside_group(const emitters *e) { return e->outside_group; }

void emitters_outside_shares(const emitters *e, vec3_f32 direction, float (*shares)[3]) {
    float all[3];
    memset(shares, 0, e->groups->count * sizeof *shares);
    memcpy(shares[e->background_group], e->background, sizeof e->background);
    memcpy(all, e->background, sizeof all);
    for (uint32_t i = 0; i < e->sky_count; ++i) {
        float more[3];
        environment_radiance(e->skies[i].image, widen(direction), more);
        for (int c = 0; c < 3; ++c) shares[e->skies[i].group][c] += more[c], all[c] += more[c];
    }
    for (uint32_t g = 0; g < e->groups->count; ++g) {
        for (int c = 0; c < 3; ++c) shares[g][c] = all[c] > 0 ? shares[g][c] / all[c] : 0;
    }
}
