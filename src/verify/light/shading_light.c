/* Point lights in places and of strengths where divisions go wrong: on the surface they light, a rounding
 * beside it, at 1e20 and at 1e-20, and brighter than float can add up. */
#include "math/limit.h"
#include "verify/light/shading_studio.h"

#define PIXELS 33

static const vec3_f64 down = {0, 0, -1}, across = {1, 0, 0}, up = {0, 0, 1};

/* What a light of intensity 1 at height h makes of a white point at distance x from its foot. */
static double lit(double h, double x) {
    double r = sqrt(h * h + x * x);
    return h > 0 && r > 0 ? h / (r * r * r) : 0;
}

/* ---- on the surface, and beside it ----
 * The plane z = 1 seen from above: float's neighbours of 1 are 2^-23 above and 2^-24 below it. */

/* The plane puts its points back on itself, and float has 1 - z exactly for z near 1 (Sterbenz): the light's
 * height is what its coordinate says. Sideways the point is good to 16 u of x, and 24 roundings follow. */
static void judge_beside(const studio *s, double height, double x, uint32_t i, studio_worst *worst) {
    double value = lit(height, x), near = lit(height, fabs(x) * (1 - 16 * SHADING_U)),
           far = lit(height, fabs(x) * (1 + 16 * SHADING_U));
    studio_judge(worst, studio_at(s, 0, i), value, near - far + 24 * SHADING_U * value);
}

static fathom_status beside(fathom_context *context, const shading_options *options, shading_rows *rows,
                            double height) {
    const double field = 1;
    studio s;
    studio_open(context, options, rows, PIXELS, &s);
    fathom_material white = studio_lambert(1, 1, 1);
    studio_plane(&s, up, up, &white);
    studio_point_light(&s, (vec3_f64){0, 0, 1 + height}, 1, 1, 1);
    studio_camera(&s, (vec3_f64){0, 0, 3}, down, across, field);
    studio_worst worst = {0};
    double taken = studio_twisted(&s, (double)(float)(1 + height) - 1);
    bool rendered = studio_render(&s);
    for (uint32_t i = 0; rendered && i < PIXELS; ++i)
        judge_beside(&s, taken, 2 * ((i + 0.5) / PIXELS - 0.5) * field, i, &worst);
    studio_row(&s, "light on surface", height, &worst,
               height == 0 ? "light exactly on a surface" : "light %.3g %s a surface", fabs(height),
               height < 0 ? "below" : "above");
    return studio_close(&s);
}

/* ---- near and far ----
 * A light at height D, as strong as D^2 or as float allows; the scene is as small as D for D < 1. The squared
 * distance is beyond float below 1e-19 and above 1e19. */

static fathom_status distant(fathom_context *context, const shading_options *options, shading_rows *rows,
                             double distance) {
    double size = fmin(distance, 1), field = 1;
    float intensity = (float)fmax(fmin(distance * distance, 1e38), 1e-37);
    studio s;
    studio_open(context, options, rows, PIXELS, &s);
    fathom_material white = studio_lambert(1, 1, 1);
    studio_plane(&s, (vec3_f64){0, 0, 0}, up, &white);
    studio_point_light(&s, (vec3_f64){0, 0, distance}, intensity, intensity, intensity);
    studio_camera(&s, (vec3_f64){0, 0, 2 * size}, down, across, field);
    studio_worst worst = {0};
    double taken = studio_twisted(&s, distance);
    bool rendered = studio_render(&s);
    for (uint32_t i = 0; rendered && i < PIXELS; ++i) {
        /* In units of D all is as at D = 1: the point is good to 16 u of 2, and changes 4 times itself. */
        double x = 2 * size * ((i + 0.5) / PIXELS - 0.5) * field;
        double value = (double)intensity / (distance * distance) * lit(taken / distance, x / distance);
        studio_judge(&worst, studio_at(&s, 0, i), value, value * (4 * 32 + 24) * SHADING_U);
    }
    studio_row(&s, "light distance", distance, &worst, "light at distance %g, of intensity %.3g", distance,
               (double)intensity);
    return studio_close(&s);
}

/* ---- brighter than can be added up ----
 * Radiance ends at 2^100, see math/limit.h. */

static fathom_status bright(fathom_context *context, const shading_options *options, shading_rows *rows,
                            double intensity) {
    studio s;
    studio_open(context, options, rows, PIXELS, &s);
    fathom_material white = studio_lambert(1, 0, 1);
    studio_plane(&s, (vec3_f64){0, 0, 0}, up, &white);
    studio_point_light(&s, (vec3_f64){0, 0, 1}, (float)intensity, (float)intensity, 0);
    studio_camera(&s, (vec3_f64){0, 0, 2}, down, across, 1);
    studio_worst worst = {0};
    double height = studio_twisted(&s, 1);
    bool rendered = studio_render(&s);
    for (uint32_t i = 0; rendered && i < PIXELS; ++i) {
        double value = intensity * lit(height, 2 * ((i + 0.5) / PIXELS - 0.5));
        /* Arriving radiance ends there; the cosine comes after it. */
        double x = 2 * ((i + 0.5) / PIXELS - 0.5), cosine = 1 / sqrt(1 + x * x);
        value = fmin(value, (double)limited(INFINITY) * cosine);
        studio_judge(&worst, studio_at(&s, 0, i), value, value * (4 * 32 + 24) * SHADING_U);
        studio_judge(&worst, studio_at(&s, 1, i), 0, 0);
    }
    studio_row(&s, "light intensity", intensity, &worst, "light of intensity %g", intensity);
    return studio_close(&s);
}

/* Mirrors that return `gain` times what they get, facing each other: weights grow until their limit, and the
 * sum of what 65 surfaces send out is gain^0 + gain^1 + ... as far as it goes. Black must stay black. */
static fathom_status gaining(fathom_context *context, const shading_options *options, shading_rows *rows,
                             double gain) {
    studio s;
    studio_open(context, options, rows, 1, &s);
    fathom_material m = studio_emitter(1, 0, 1);
    for (int c = 0; c < 3; ++c) m.k_r[c] = (float)gain;
    studio_plane(&s, down, up, &m);
    studio_plane(&s, up, down, &m);
    studio_camera(&s, (vec3_f64){0, 0, 0}, down, across, 0.1);
    studio_worst worst = {0};
    if (studio_render(&s)) {
        double sum = 0, weight = 1, most = (double)limited(INFINITY);
        for (int k = 0; k <= 64; ++k, weight = fmin(weight * (double)(float)studio_twisted(&s, gain), most))
            sum += weight;
        /* Each of 65 sums and products rounds once, and weights bring the roundings of those before them. */
        studio_judge(&worst, studio_at(&s, 0, 0), sum, sum * 2 * 65 * SHADING_U);
        studio_judge(&worst, studio_at(&s, 1, 0), 0, 0);
    }
    studio_row(&s, "mirror gain", gain, &worst,
               "64 bounces between mirrors that return %g times what they get", gain);
    return studio_close(&s);
}

fathom_status shading_lights(fathom_context *context, const shading_options *options, shading_rows *rows) {
    static const double heights[] = {0, 0x1p-23, -0x1p-24, 1e-6, 1e-4, 1e-2, 1};
    static const double distances[] = {1e-20, 1e-15, 1e-10, 1e-5, 1, 1e5, 1e10, 1e15, 1e19, 1e20};
    static const double intensities[] = {1e-37, 1, 1e10, 1e20, 1e30, 1e38, 3.4e38};
    static const double gains[] = {0.5, 1, 2, 1e10, 3e38};
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < sizeof heights / sizeof *heights && status == FATHOM_OK; ++i)
        status = beside(context, options, rows, heights[i]);
    for (size_t i = 0; i < sizeof distances / sizeof *distances && status == FATHOM_OK; ++i)
        status = distant(context, options, rows, distances[i]);
    for (size_t i = 0; i < sizeof intensities / sizeof *intensities && status == FATHOM_OK; ++i)
        status = bright(context, options, rows, intensities[i]);
    for (size_t i = 0; i < sizeof gains / sizeof *gains && status == FATHOM_OK; ++i)
        status = gaining(context, options, rows, gains[i]);
    return status;
}
