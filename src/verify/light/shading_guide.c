/* Total internal reflection: dozens of reflections along a bar of glass, and both sides of the critical
 * angle. */
#include "verify/light/shading_studio.h"

#define PIXELS 32

static const double ior = 1.5;

/* ---- a light guide ----
 * Glass between z = 0 and z = 1 that ends at x = length. A ray below 48 degrees to the axis stays inside, and
 * its z goes up and down like a triangle wave; at the end face it leaves by Snell's law. Blue counts the
 * reflections; red shows where the path hits a ruler behind the end. */

static const vec3_f64 guide_eye = {0, 0, 0.5}, guide_view = {1, 0, 0}, guide_up = {0, 0, 1};
/* Slopes up to 0.6, 31 degrees: below the critical 42 degrees at the end face too. */
static const double guide_field = 1.2;

static void build_guide(studio *s, double length) {
    fathom_material end = studio_glass((float)ior), side = end;
    side.k_e[2] = 1;
    vec3_f64 half = {length / 2, 0, 0}, up = {0, 0, 0.5}, aside = {0, 4, 0};
    paint_quad(&s->b, (vec3_f64){length / 2, 0, 1}, half, aside, side);
    paint_quad(&s->b, (vec3_f64){length / 2, 0, 0}, half, neg_f64(aside), side);
    paint_quad(&s->b, (vec3_f64){length, 0, 0.5}, aside, up, end);
    paint_plane(&s->b, (vec3_f64){length + 1, 0, 0}, (vec3_f64){-1, 0, 0}, build_lambert(vec_f64(1, 0, 0)));
    build_point_light(&s->b, (vec3_f64){length + 0.5, 1, 0.5}, vec_f64(1, 0, 0), 0);
    studio_camera(s, guide_eye, guide_view, guide_up, guide_field);
}

/* z at the end, folded back into the bar; also counts the reflections. */
static double folded(double z, double height, double *reflections) {
    double k = floor(z / height), within = z - k * height;
    *reflections = fabs(k);
    return fmod(fabs(k), 2) > 0.5 ? height - within : within;
}

static void judge_guide(studio *s, double length, uint32_t i) {
    double height = studio_twisted(s, 1), eta = studio_twisted(s, ior), reflections, bound;
    vec3_f64 d = studio_direction(s, guide_view, guide_up, guide_field, i);
    double slope = d.z / d.x, unfolded = guide_eye.z + length * slope;
    double z = folded(unfolded, height, &reflections);
    /* Only this beam's error bounds are used: one step and one mirror per reflection. */
    beam b = beam_start(guide_eye, d);
    double stretch = length / d.x / (reflections + 1);
    for (unsigned k = 0; k <= reflections; ++k) {
        beam_go(&b, stretch, length);
        if (k) beam_mirror(&b, (vec3_f64){0, 0, d.z > 0 ? -1 : 1}, 4 * SHADING_U);
    }
    /* At the edge of the end face, float may count one reflection more or less. */
    if (fmin(z, height - z) < 2 * b.aside / d.x) return;
    studio_judge(s, 0, studio_at(s, 2, i), reflections, 0);
    bool down = (fmod(reflections, 2) > 0.5) != (slope < 0);
    b.at = (vec3_f64){length, 0, z};
    b.along = (vec3_f64){d.x, 0, down ? -fabs(d.z) : fabs(d.z)};
    if (!beam_refract(&b, (vec3_f64){-1, 0, 0}, 4 * SHADING_U, eta)) return;
    beam_go(&b, 1 / b.along.x, length);
    double value =
        beam_radiance(&b, (vec3_f64){length + 0.5, 1, 0.5}, (vec3_f64){-1, 0, 0}, length + 1, &bound);
    studio_judge(s, 1, studio_at(s, 0, i), value, bound);
}

static void guide(studio *s, double length) {
    studio_begin(s, PIXELS);
    build_guide(s, length);
    for (uint32_t i = 0, n = studio_render(s); i < n; ++i) judge_guide(s, length, i);
    studio_row(s, 0, "light guide", length, "total reflections in a bar of glass %g times its height",
               length);
    studio_row(s, 1, "light guide", length, "light where rays leave a bar of glass %g times its height",
               length);
}

/* ---- the critical angle ----
 * From inside glass, a field of view of a few times `near` around the critical angle: beyond it everything is
 * mirrored, to a surface that emits 1; below it the ray leaves, to black. */

static void critical(studio *s, double near) {
    static const vec3_f64 origin = {0, 0, 0}, up = {0, 0, 1};
    double angle = asin(1 / ior), eta = studio_twisted(s, ior);
    vec3_f64 view = {sin(angle), 0, -cos(angle)}, across = {cos(angle), 0, sin(angle)};
    studio_begin(s, PIXELS);
    paint_plane(&s->b, neg_f64(up), neg_f64(up), studio_glass((float)ior));
    paint_plane(&s->b, up, up, build_emitter(vec_f64(1, 1, 1)));
    studio_camera(s, origin, view, across, 4 * near);
    for (uint32_t i = 0, n = studio_render(s); i < n; ++i) {
        beam b = beam_start(origin, studio_direction(s, view, across, 4 * near, i));
        double doubt = beam_doubt(&b, up, SHADING_U, eta), value = studio_at(s, 0, i);
        /* Too close for float: both results are right, but nothing between them. */
        double expected = fabs(doubt) < 1 ? (value > 0.5 ? 1 : 0) : (doubt < 0 ? 1 : 0);
        studio_judge(s, 0, value, expected, 0);
    }
    studio_row(s, 0, "critical angle", near, "mirrored or let out, within %g rad of the critical angle",
               2 * near);
}

void shading_guide(studio *s) {
    for (int e = 2; e <= 6; ++e) guide(s, ldexp(1, e));
    for (int e = 1; e <= 7; ++e) critical(s, pow(10, -e));
}
