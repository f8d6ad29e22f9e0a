#include "image/compare/flip_colour.h"

#include <math.h>

/* XYZ over those of white, from the chromaticities of sRGB's primaries and of D65 as fractions: each row sums
 * to one. */
static void relative_xyz(const double c[3], double out[3]) {
    out[0] = (10135552 * c[0] + 8788810 * c[1] + 4435075 * c[2]) / 23359437;
    out[1] = (2613072 * c[0] + 8788810 * c[1] + 887015 * c[2]) / 12288897;
    out[2] = (1425312 * c[0] + 8788810 * c[1] + 70074185 * c[2]) / 80288307;
}

/* Its inverse, rounded. */
static const double rgb_of_xyz[3][3] = {
    {3.080341988280461, -1.5373989694887855, -0.5429430187916751},
    {-0.9211783961651236, 1.875929983695176, 0.04524841246994758},
    {0.05288129287554325, -0.20401120612390997, 1.1511299132483668},
};

/* 116 Y - 16, 500 (X - Y), 200 (Y - Z): L*a*b* without its cube roots. */
static void opponent_of(const double xyz[3], double out[3]) {
    out[0] = 116 * xyz[1] - 16;
    out[1] = 500 * (xyz[0] - xyz[1]);
    out[2] = 200 * (xyz[1] - xyz[2]);
}

void flip_opponent(const double rgb[3], double out[3]) {
    double xyz[3];
    relative_xyz(rgb, xyz);
    opponent_of(xyz, out);
}

void flip_opponent_rgb(const double opponent[3], double out[3]) {
    double y = (opponent[0] + 16) / 116, x = y + opponent[1] / 500, z = y - opponent[2] / 200;
    for (int i = 0; i < 3; ++i) out[i] = rgb_of_xyz[i][0] * x + rgb_of_xyz[i][1] * y + rgb_of_xyz[i][2] * z;
}

/* CIE 15: a straight line below (6/29)³, where the cube root is too steep. */
static double lightness(double t) {
    const double delta = 6.0 / 29;
    return t > delta * delta * delta ? cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
}

void flip_hunt(const double rgb[3], double out[3]) {
    double xyz[3];
    relative_xyz(rgb, xyz);
    for (int i = 0; i < 3; ++i) xyz[i] = lightness(xyz[i]);
    opponent_of(xyz, out);
    out[1] *= 0.01 * out[0];
    out[2] *= 0.01 * out[0];
}

double flip_hyab(const double a[3], const double b[3]) {
    return fabs(a[0] - b[0]) + hypot(a[1] - b[1], a[2] - b[2]);
}
