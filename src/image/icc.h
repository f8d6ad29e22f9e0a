/* The sRGB profile for formats that have no shorter word for it. */
#ifndef IMAGE_ICC_H
#define IMAGE_ICC_H

#include <stddef.h>

#define ICC_SRGB_SIZE 496

/* Fills `out` with an ICC profile, version 4.2, of IEC 61966-2-1. */
void icc_srgb(unsigned char out[ICC_SRGB_SIZE]);

#endif
