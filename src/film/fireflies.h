/* Fireflies: samples by how bright they are, and an image in which rare bright ones count less. */
#ifndef FILM_FIREFLIES_H
#define FILM_FIREFLIES_H

#include "film/squares.h"

/* Sums of samples by brightness, three channels each; cascade k is for about 2^-10 * 8^k (fireflies.c). */
#define FIREFLY_CASCADES 12u

/* The entry of a file's header. */
#define FIREFLY_TEXT 256

/* Adds the samples of 16 slots from `from` on to the cascades' sums, three of each, from `slot` on. */
void fireflies_add(const wave_samples *samples, uint32_t from, double (*to)[WAVE_SLOTS], uint32_t slot);

#endif
