/* The times at which the automatic camera looks at what moves. */
#ifndef SCENE_FRAMING_TIMES_H
#define SCENE_FRAMING_TIMES_H

#include "scene/scene.h"

enum { FRAMING_TIMES_MOST = 128 };

typedef struct framing_times {
    double items[FRAMING_TIMES_MOST];
    uint32_t count;
} framing_times;

/* The shutter's opening alone where nothing moves; else even times while it is open, in case things turn
 * between two keys, and keys, as far as there is room. */
void framing_choose_times(const fathom_scene *scene, framing_times *times);

#endif
