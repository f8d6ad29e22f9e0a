#include "integrate/media.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A path inside more volumes than this drops the outermost one. */
#define MOST 8

struct media {
    const shader *shaders;
    uint32_t count[WAVE_SLOTS], in[WAVE_SLOTS][MOST]; /* materials, the innermost last */
};

media *media_create(const shader *shaders) {
    media *m = malloc(sizeof *m);
    if (m) m->shaders = shaders;
    return m;
}

void media_begin(media *m, uint32_t slot, const uint32_t *materials, uint32_t count) {
    m->count[slot] = count;
    memcpy(m->in[slot], materials, count * sizeof *materials);
}

static void enter(media *m, uint32_t slot, uint32_t material) {
    uint32_t *in = m->in[slot];
    if (m->count[slot] == MOST) memmove(in, in + 1, (--m->count[slot]) * sizeof *in);
    in[m->count[slot]++] = material;
}

/* The innermost volume of that material; MOST: none. */
static uint32_t place_of(const media *m, uint32_t slot, uint32_t material) {
    uint32_t k = m->count[slot];
    while (k && m->in[slot][k - 1] != material) --k;
    return k ? k - 1 : MOST;
}

/* A path may leave a volume that it never entered: after passing a partly transparent surface, or from an
 * open mesh. */
static void leave(media *m, uint32_t slot, uint32_t material) {
    uint32_t *in = m->in[slot], k = place_of(m, slot, material);
    if (k == MOST) return;
    memmove(in + k, in + k + 1, (m->count[slot] - k - 1) * sizeof *in);
    --m->count[slot];
}

void media_cross(media *m, uint32_t slot, uint32_t material, bool entering) {
    if (entering)
        enter(m, slot, material);
    else
        leave(m, slot, material);
}

/* The index of the volume that fills the space, ignoring the one at `skip`: the one of highest priority, the
 * innermost among equals. The count, if there is none. */
static uint32_t filling(const media *m, uint32_t slot, uint32_t skip) {
    const uint32_t count = m->count[slot];
    uint32_t best = count;
    for (uint32_t k = 0; k < count; ++k) {
        const uint32_t priority = m->shaders[m->in[slot][k]].priority;
        if (k != skip && (best == count || priority >= m->shaders[m->in[slot][best]].priority)) best = k;
    }
    return best;
}

static const shader *shader_at(const media *m, uint32_t slot, uint32_t at) {
    return at < m->count[slot] ? &m->shaders[m->in[slot][at]] : NULL;
}

/* NULL: empty space. */
static const shader *filled_by(const media *m, uint32_t slot) {
    return shader_at(m, slot, filling(m, slot, MOST));
}

bool media_meet(const media *m, uint32_t slot, uint32_t material, bool entering, float *around) {
    const uint32_t own = entering ? MOST : place_of(m, slot, material);
    const uint32_t at = filling(m, slot, own), priority = m->shaders[material].priority;
    const shader *other = shader_at(m, slot, at);
    *around = 1;
    if (!other || !other->priority) return true;
    *around = other->ior;
    return other->priority <= priority && m->in[slot][at] != material;
}

const shader *media_around(const media *m, uint32_t slot, uint32_t material, bool entering) {
    return shader_at(m, slot, filling(m, slot, entering ? MOST : place_of(m, slot, material)));
}

static void left_in(const shader *s, float length, float left[3]) {
    for (int c = 0; c < 3; ++c) left[c] = s && s->absorption[c] > 0 ? expf(-s->absorption[c] * length) : 1;
}

void media_left(const media *m, uint32_t slot, float length, float left[3]) {
    left_in(filled_by(m, slot), length, left);
}

void media_left_behind(const media *m, uint32_t slot, uint32_t material, bool entering, float length,
                       float left[3]) {
    if (entering) {
        left_in(&m->shaders[material], length, left);
        return;
    }
    left_in(media_around(m, slot, material, entering), length, left);
}
