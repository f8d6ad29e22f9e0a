/* Total internal reflection: down a bar of glass by dozens of reflections, and on both sides of the critical
 * angle. */
#include "verify/light/shading_beam.h"
#include "verify/light/shading_studio.h"

#define PIXELS 32

static const double ior = 1.5;

/* ---- a light guide ----
 * Glass between z = 0 and z = 1 that ends at x = length. A ray below 48 degrees of the axis stays in, and its
 * z goes up and down like a triangle wave; at the end face it leaves by Snell's law. Blue counts the
 * reflections, red tells where on a ruler behind the end the path lands. */

static const vec3_f64 guide_eye = {0, 0, 0.5}, guide_view = {1, 0, 0}, guide_up = {0, 0, 1};
static const double guide_field =
    1.2; /* slopes to 0.6, 31 degrees: at the end face, too, below the critical 42 */

static void build_guide(studio *s, double length) {
    fathom_material side = studio_glass((float)ior), end = side, ruler = studio_lambert(1, 0, 0);
    side.k_e[2] = 1;
    vec3_f64 half = {length / 2, 0, 0}, up = {0, 0, 0.5}, aside = {0, 4, 0};
    studio_quad(s, (vec3_f64){length / 2, 0, 1}, half, aside, &side);
    studio_quad(s, (vec3_f64){length / 2, 0, 0}, half, neg_f64(aside), &side);
    studio_quad(s, (vec3_f64){length, 0, 0.5}, aside, up, &end);
    studio_plane(s, (vec3_f64){length + 1, 0, 0}, (vec3_f64){-1, 0, 0}, &ruler);
    studio_point_light(s, (vec3_f64){length + 0.5, 1, 0.5}, 1, 0, 0);
    studio_camera(s, guide_eye, guide_view, guide_up, guide_field);
}

/* Where z is at the end, folded back into the bar, and the reflections until then. */
static double folded(double z, double height, double *reflections) {
    double k = floor(z / height), within = z - k * height;
    *reflections = fabs(k);
    return fmod(fabs(k), 2) > 0.5 ? height - within : within;
}

static void judge_guide(const studio *s, double length, uint32_t i, studio_worst *count,
                        studio_worst *landing) {
    double height = studio_twisted(s, 1), eta = studio_twisted(s, ior), reflections, bound;
    vec3_f64 d = studio_direction(s, guide_view, guide_up, guide_field, i);
    double slope = d.z / d.x, unfolded = guide_eye.z + length * slope;
    double z = folded(unfolded, height, &reflections);
    /* Only the bounds of this beam count: one stretch and one mirror for each reflection. */
    beam b = beam_start(guide_eye, d);
    double stretch = length / d.x / (reflections + 1);
    for (unsigned k = 0; k <= reflections; ++k) {
        beam_go(&b, stretch, length);
        if (k) beam_mirror(&b, (vec3_f64){0, 0, d.z > 0 ? -1 : 1}, 4 * SHADING_U);
    }
    /* At the edge of the end face float may see one reflection more or less. */
    if (fmin(z, height - z) < 2 * b.aside / d.x) return;
    studio_judge(count, studio_at(s, 2, i), reflections, 0);
    bool down = (fmod(reflections, 2) > 0.5) != (slope < 0);
    b.at = (vec3_f64){length, 0, z};
    b.along = (vec3_f64){d.x, 0, down ? -fabs(d.z) : fabs(d.z)};
    if (!beam_bend(&b, (vec3_f64){-1, 0, 0}, 4 * SHADING_U, eta)) return;
    beam_go(&b, 1 / b.along.x, length);
    double value =
        beam_radiance(&b, (vec3_f64){length + 0.5, 1, 0.5}, (vec3_f64){-1, 0, 0}, length + 1, &bound);
    studio_judge(landing, studio_at(s, 0, i), value, bound);
}

static fathom_status guide(fathom_context *context, const shading_options *options, shading_rows *rows,
                           double length) {
    studio s;
    studio_open(context, options, rows, PIXELS, &s);
    build_guide(&s, length);
    studio_worst count = {0}, landing = {0};
    if (studio_render(&s)) {
        for (uint32_t i = 0; i < PIXELS; ++i) judge_guide(&s, length, i, &count, &landing);
    }
    studio_row(&s, "light guide", length, &count, "total reflections in a bar of glass %g times its height",
               length);
    studio_row(&s, "light guide", length, &landing,
               "light where rays leave a bar of glass %g times its height", length);
    return studio_close(&s);
}

/* ---- the critical angle ----
 * From inside glass, a field of view of a few times `near` around the critical angle: beyond it all is
 * mirrored, to a surface that sends out 1; below it the ray leaves, to black. */

static fathom_status critical(fathom_context *context, const shading_options *options, shading_rows *rows,
                              double near) {
    static const vec3_f64 origin = {0, 0, 0}, outwards = {0, 0, -1};
    studio s;
    studio_open(context, options, rows, PIXELS, &s);
    fathom_material glass = studio_glass((float)ior), bright = studio_emitter(1, 1, 1);
    studio_plane(&s, (vec3_f64){0, 0, -1}, outwards, &glass);
    studio_plane(&s, (vec3_f64){0, 0, 1}, (vec3_f64){0, 0, 1}, &bright);
    double angle = asin(1 / ior);
    vec3_f64 view = {sin(angle), 0, -cos(angle)}, across = {cos(angle), 0, sin(angle)};
    studio_camera(&s, origin, view, across, 4 * near);
    studio_worst worst = {0};
    double eta = studio_twisted(&s, ior);
    bool rendered = studio_render(&s);
    for (uint32_t i = 0; rendered && i < PIXELS; ++i) {
        beam b = beam_start(origin, studio_direction(&s, view, across, 4 * near, i));
        double doubt = beam_doubt(&b, (vec3_f64){0, 0, 1}, SHADING_U, eta), value = studio_at(&s, 0, i);
        /* Nearer than float can tell it is still one or the other. */
        double expected = fabs(doubt) < 1 ? (value > 0.5 ? 1 : 0) : (doubt < 0 ? 1 : 0);
        studio_judge(&worst, value, expected, 0);
    }
    studio_row(&s, "critical angle", near, &worst, "mirrored or let out, within %g rad of the critical angle",
               2 * near);
    return studio_close(&s);
}

fathom_status shading_guide(fathom_context *context, const shading_options *options, shading_rows *rows) {
    static const double lengths[] = {4, 8, 16, 32, 64};
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths && status == FATHOM_OK; ++i)
        status = guide(context, options, rows, lengths[i]);
    for (int e = 1; e <= 7 && status == FATHOM_OK; ++e)
        status = critical(context, options, rows, pow(10, -e));
    return status;
}
