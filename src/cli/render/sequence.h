/* The frames of an animation, one image each. */
#pragma once

#include "cli/render/task.h"

/* Renders all frames that the options request. */
fathom_status sequence_run(task *all);
