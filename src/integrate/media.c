#include "integrate/media.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A path that is in more volumes than this forgets the outermost. */
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

void media_clear(media *m) { memset(m->count, 0, sizeof m->count); }

static void enter(media *m, uint32_t slot, uint32_t material) {
    uint32_t *in = m->in[slot];
    if (m->count[slot] == MOST) memmove(in, in + 1, (--m->count[slot]) * sizeof *in);
    in[m->count[slot]++] = material;
}

/* The innermost of that material; a path that began inside leaves what it never entered. */
static void leave(media *m, uint32_t slot, uint32_t material) {
    uint32_t *in = m->in[slot], k = m->count[slot];
    while (k && in[k - 1] != material) --k;
    if (!k) return;
    memmove(in + k - 1, in + k, (m->count[slot] - k) * sizeof *in);
    --m->count[slot];
}

void media_cross(media *m, uint32_t slot, uint32_t material, bool entering) {
    if (entering)
        enter(m, slot, material);
    else
        leave(m, slot, material);
}

/* NULL: empty space. */
static const shader *innermost(const media *m, uint32_t slot) {
    return m->count[slot] ? &m->shaders[m->in[slot][m->count[slot] - 1]] : NULL;
}

bool media_absorbs(const media *m, uint32_t slot) {
    const shader *s = innermost(m, slot);
    return s && (s->absorption[0] > 0 || s->absorption[1] > 0 || s->absorption[2] > 0);
}

static void left_in(const shader *s, float length, float left[3]) {
    for (int c = 0; c < 3; ++c) left[c] = s && s->absorption[c] > 0 ? expf(-s->absorption[c] * length) : 1;
}

void media_left(const media *m, uint32_t slot, float length, float left[3]) {
    left_in(innermost(m, slot), length, left);
}

void media_left_behind(const media *m, uint32_t slot, uint32_t material, bool entering, float length,
                       float left[3]) {
    if (entering) {
        left_in(&m->shaders[material], length, left);
        return;
    }
    uint32_t k = m->count[slot];
    while (k && m->in[slot][k - 1] != material) --k;
    const bool innermost_left = k == m->count[slot];
    const uint32_t behind = innermost_left && k ? k - 1 : m->count[slot];
    left_in(behind ? &m->shaders[m->in[slot][behind - 1]] : NULL, length, left);
}
