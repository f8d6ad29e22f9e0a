/* The times at which the automatic camera considers moving objects. */
#pragma once

#include "scene/scene.h"

enum { FRAMING_TIMES_MOST = 128 };

typedef struct framing_times {
    double items[FRAMING_TIMES_MOST];
    uint32_t count;
} framing_times;

/* If nothing moves: only the time when the shutter opens. Otherwise also uniform times while it is open,
 * because objects may rotate between two keys, and the times of keys, as many as fit. */
void framing_choose_times(const fathom_scene *scene, framing_times *times);
