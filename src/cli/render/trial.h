/* Trial runs that find what all frames of an animation share: the camera and the exposure. They report no
 * problems of the scene, because the frames do. */
#pragma once

#include "cli/render/task.h"

/* Gives the task a context. False: out of memory. */
bool trial_open(task *s);
/* Destroys all but the options and the framing. */
void trial_close(task *s);
/* Renders a small image to choose the exposure, and sets `framing` as running the task does; then closes
 * the task. Warns if the exposure had to change. False: nothing in view is lit, or an error. */
bool trial_exposure(task *s);
