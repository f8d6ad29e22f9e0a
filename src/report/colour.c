#include "report/colour.h"

#include <math.h>

static unsigned char encode(double linear) {
    double x = linear < 0 ? 0 : linear > 1 ? 1 : linear;
    double s = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
    return (unsigned char)lround(255 * s);
}

/* From lightness, chroma and hue in Oklab (B. Ottosson, A perceptual color space for image processing, 2020):
 * equal steps of lightness look equal. */
static colour from_oklch(double lightness, double chroma, double hue) {
    double a = chroma * cos(hue), b = chroma * sin(hue);
    double l = pow(lightness + 0.3963377774 * a + 0.2158037573 * b, 3);
    double m = pow(lightness - 0.1055613458 * a - 0.0638541728 * b, 3);
    double s = pow(lightness - 0.0894841775 * a - 1.2914855480 * b, 3);
    return (colour){encode(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
                    encode(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
                    encode(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

/* Yellow-green to blue-violet: lightness carries the order, hue helps to tell neighbours apart. */
colour colour_step(unsigned step, int dark) {
    double t = (double)step / (COLOUR_STEPS - 1);
    double hue = 2.0 + (dark ? 1 - t : t) * 2.9;
    double lightness = dark ? 0.27 + 0.63 * t : 0.95 - 0.63 * t;
    return from_oklch(lightness, 0.045 + 0.075 * sin(3.14159265 * (0.15 + 0.7 * t)), hue);
}

static double decode(unsigned char c) {
    double x = c / 255.0;
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

double colour_luminance(colour c) {
    return 0.2126 * decode(c.r) + 0.7152 * decode(c.g) + 0.0722 * decode(c.b);
}
