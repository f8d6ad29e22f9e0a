/* Fractions as 8-bit files hold them. */
#ifndef IMAGE_BYTE_H
#define IMAGE_BYTE_H

/* round(255 v) of v in [0,1], what is beyond as the nearest of them; NaN is 0. */
static inline unsigned char byte_from_float(float value) {
    if (!(value > 0.0f)) return 0;
    return value < 1.0f ? (unsigned char)(value * 255.0f + 0.5f) : 255;
}

#endif
