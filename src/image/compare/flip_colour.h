/* The colour spaces of FLIP. Linear RGB has the primaries of sRGB, white is D65. */
#ifndef IMAGE_FLIP_COLOUR_H
#define IMAGE_FLIP_COLOUR_H

/* YCxCz, opponent colours linear in light (the paper's spatial filtering). */
void flip_opponent(const double rgb[3], double out[3]);
void flip_opponent_rgb(const double opponent[3], double out[3]);

/* CIE L*a*b* with the Hunt effect: colours fade in the dark, a and b times 0.01 L. */
void flip_hunt(const double rgb[3], double out[3]);

/* |ΔL| + √(Δa² + Δb²), for large differences (Abasi, Amani Tehran and Fairchild,
 * Distance metrics for very large color differences, 2019). */
double flip_hyab(const double a[3], const double b[3]);

#endif
