/* Colours of magnitudes: one hue family, each step darker than the last on light paper, lighter on dark. */
#ifndef REPORT_COLOUR_H
#define REPORT_COLOUR_H

#define COLOUR_STEPS 12

typedef struct colour {
    unsigned char r, g, b; /* sRGB */
} colour;

/* step: 0 the least, near the paper, to COLOUR_STEPS - 1. */
colour colour_step(unsigned step, int dark);
/* Relative luminance as WCAG 2 defines it, 0 to 1. */
double colour_luminance(colour c);

#endif
