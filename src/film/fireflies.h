/* Fireflies: sums of samples by brightness, and a second image in which rare bright samples have a lower
 * weight. */
#pragma once

#include "film/squares.h"

/* Number of sums by brightness, three channels each. Cascade k is for a brightness of about 2^-10 * 8^k
 * (fireflies.c). */
#define FIREFLY_CASCADES 12u

/* Size of the text in a file's header. */
#define FIREFLY_TEXT 256

/* Adds the 16 samples at slots from `from` on to the sums of the cascades (three per cascade), at slots from
 * `slot` on. */
void fireflies_add(const wave_samples *samples, uint32_t from, double (*to)[WAVE_SLOTS], uint32_t slot);
