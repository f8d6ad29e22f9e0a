/* Point lights with positions and intensities that break divisions: on the surface that they light, one
 * rounding off it, at distances of 1e20 and 1e-20, and too bright for sums in float. */
#include "math/limit.h"
#include "verify/light/shading_studio.h"

#define PIXELS 33

static const vec3_f64 zero = {0, 0, 0}, down = {0, 0, -1}, across = {1, 0, 0}, up = {0, 0, 1};

/* x of pixel i at distance 2 from the camera, in a field of view of 1. */
static double pixel_x(uint32_t i) { return 2 * ((i + 0.5) / PIXELS - 0.5); }

/* Radiance of a white surface at distance x from the point below a light of intensity 1 at height h. */
static double lit(double h, double x) {
    double r = sqrt(h * h + x * x);
    return h > 0 && r > 0 ? h / (r * r * r) : 0;
}

/* ---- on the surface, and next to it ----
 * The plane z = 1 seen from above. In float, the neighbours of 1 are 2^-23 above and 2^-24 below it. */

/* Hit points are projected onto the plane, and 1 - z is exact in float for z near 1 (Sterbenz), so the
 * light's height has no error. Sideways the point's error is 16 u of x, and 24 roundings follow. */
static void judge_near(studio *s, double height, double x, uint32_t i) {
    double value = lit(height, x), near = lit(height, fabs(x) * (1 - 16 * SHADING_U)),
           far = lit(height, fabs(x) * (1 + 16 * SHADING_U));
    studio_judge(s, 0, studio_at(s, 0, i), value, near - far + 24 * SHADING_U * value);
}

static void near_surface(studio *s, double height) {
    studio_begin(s, PIXELS);
    paint_plane(&s->b, up, up, build_lambert(vec_f64(1, 1, 1)));
    build_point_light(&s->b, (vec3_f64){0, 0, 1 + height}, vec_f64(1, 1, 1), 0);
    studio_camera(s, (vec3_f64){0, 0, 3}, down, across, 1);
    double taken = studio_twisted(s, (double)(float)(1 + height) - 1);
    for (uint32_t i = 0, n = studio_render(s); i < n; ++i) judge_near(s, taken, pixel_x(i), i);
    studio_row(s, 0, "light on surface", height,
               height == 0 ? "light exactly on a surface" : "light %.3g %s a surface", fabs(height),
               height < 0 ? "below" : "above");
}

/* ---- near and far ----
 * A light at height D with intensity D^2, or as close to it as float allows; for D < 1 the scene is scaled by
 * D. The squared distance is out of float's range below 1e-19 and above 1e19. */

static void distant(studio *s, double distance) {
    double size = fmin(distance, 1);
    float intensity = (float)fmax(fmin(distance * distance, 1e38), 1e-37);
    studio_begin(s, PIXELS);
    paint_plane(&s->b, zero, up, build_lambert(vec_f64(1, 1, 1)));
    build_point_light(&s->b, (vec3_f64){0, 0, distance},
                      vec_f64((double)intensity, (double)intensity, (double)intensity), 0);
    studio_camera(s, (vec3_f64){0, 0, 2 * size}, down, across, 1);
    double taken = studio_twisted(s, distance);
    for (uint32_t i = 0, n = studio_render(s); i < n; ++i) {
        /* In units of D everything is as at D = 1: the point's error is 16 u of 2, and the value changes by a
         * fraction of 4 per unit. */
        double x = 2 * size * ((i + 0.5) / PIXELS - 0.5);
        double value = (double)intensity / (distance * distance) * lit(taken / distance, x / distance);
        studio_judge(s, 0, studio_at(s, 0, i), value, value * (4 * 32 + 24) * SHADING_U);
    }
    studio_row(s, 0, "light distance", distance, "light at distance %g, of intensity %.3g", distance,
               (double)intensity);
}

/* ---- too bright for sums ----
 * Radiance is limited to 2^100, see math/limit.h. */

static void bright(studio *s, double intensity) {
    studio_begin(s, PIXELS);
    paint_plane(&s->b, zero, up, build_lambert(vec_f64(1, 0, 1)));
    build_point_light(&s->b, up, vec_f64(intensity, intensity, 0), 0);
    studio_camera(s, (vec3_f64){0, 0, 2}, down, across, 1);
    double height = studio_twisted(s, 1);
    for (uint32_t i = 0, n = studio_render(s); i < n; ++i) {
        /* The incident radiance is clamped before the cosine factor. */
        double x = pixel_x(i), cosine = 1 / sqrt(1 + x * x);
        double value = fmin(intensity * lit(height, x), (double)limited(INFINITY) * cosine);
        studio_judge(s, 0, studio_at(s, 0, i), value, value * (4 * 32 + 24) * SHADING_U);
        studio_judge(s, 0, studio_at(s, 1, i), 0, 0);
    }
    studio_row(s, 0, "light intensity", intensity, "light of intensity %g", intensity);
}

/* Facing mirrors with reflectance `gain`: the throughput grows up to its limit, and the emission of 65
 * surfaces sums to gain^0 + gain^1 + ... with each term limited. Black must stay black. */
static void gaining(studio *s, double gain) {
    studio_begin(s, 1);
    fathom_material m = build_emitter(vec_f64(1, 0, 1));
    m.k_r[0] = m.k_r[1] = m.k_r[2] = (float)gain;
    paint_plane(&s->b, down, up, m);
    paint_plane(&s->b, up, down, m);
    studio_camera(s, zero, down, across, 0.1);
    if (studio_render(s)) {
        double sum = 0, weight = 1, most = (double)limited(INFINITY);
        for (int k = 0; k <= 64; ++k, weight = fmin(weight * (double)(float)studio_twisted(s, gain), most))
            sum += weight;
        /* Each of 65 sums and products rounds once, and each weight includes the roundings of the earlier
         * ones. */
        studio_judge(s, 0, studio_at(s, 0, 0), sum, sum * 2 * 65 * SHADING_U);
        studio_judge(s, 0, studio_at(s, 1, 0), 0, 0);
    }
    studio_row(s, 0, "mirror gain", gain, "64 bounces between mirrors that return %g times what they get",
               gain);
}

void shading_lights(studio *s) {
    static const double heights[] = {0, 0x1p-23, -0x1p-24, 1e-6, 1e-4, 1e-2, 1};
    static const double distances[] = {1e-20, 1e-15, 1e-10, 1e-5, 1, 1e5, 1e10, 1e15, 1e19, 1e20};
    static const double intensities[] = {1e-37, 1, 1e10, 1e20, 1e30, 1e38, 3.4e38};
    static const double gains[] = {0.5, 1, 2, 1e10, 3e38};
    for (size_t i = 0; i < sizeof heights / sizeof *heights; ++i) near_surface(s, heights[i]);
    for (size_t i = 0; i < sizeof distances / sizeof *distances; ++i) distant(s, distances[i]);
    for (size_t i = 0; i < sizeof intensities / sizeof *intensities; ++i) bright(s, intensities[i]);
    for (size_t i = 0; i < sizeof gains / sizeof *gains; ++i) gaining(s, gains[i]);
}
