/* Colours as three floats. */
#pragma once

#include <stdbool.h>

/* False for black. */
static inline bool rgb_any(const float rgb[3]) { return rgb[0] > 0 || rgb[1] > 0 || rgb[2] > 0; }
