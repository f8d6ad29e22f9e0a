/* Tasks that find out what all frames of an animation share. The frames report
 * what is wrong with a scene; these tasks do not. */
#pragma once

#include "cli/render/task.h"

/* Gives the task a context. False: out of memory. */
bool trial_open(task *s);
/* Destroys all but the options and the framing. */
void trial_close(task *s);
/* Settles the exposure by a small image, and sets `framing` as running the task does; then closes the task.
 * Warns if the exposure had to change.
 * False: nothing in view is lit, or an error. */
bool trial_exposure(task *s);
