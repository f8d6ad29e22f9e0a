/* Groups in groups, scaled up and down, stretched and mirrored. */
#include "verify/extremes/case.h"

static fathom_id put_things(extremes_case *c, double size) {
    fathom_id group = put_group(c);
    put_ball(c, group, vec_f64(0, 0, 0), 0.6 * size);
    put_spheres(c, group, vec_f64(0, 0, 0), size);
    put_quads(c, group, vec_f64(0, 0, 0), size);
    return group;
}

static affine_f64 turned(double angle) { return affine_rotation_axis(vec_f64(0.3, 1, -0.4), angle); }

/* First the scale, then a turn, then a shift. */
static affine_f64 placing(vec3_f64 scale, double angle, vec3_f64 shift) {
    affine_f64 s = affine_scaling(scale), r = turned(angle), t = affine_translation(shift);
    affine_f64 rs = affine_compose(&r, &s);
    return affine_compose(&t, &rs);
}

/* Two placements of `inner`, one of `middle` within each of two of `outer`. */
static void nest(extremes_case *c, fathom_id things, const affine_f64 *inner, const affine_f64 *outer) {
    fathom_id group = put_group(c);
    put_instance(c, things, group, inner);
    affine_f64 aside = affine_translation(vec_f64(2.5, 0.3, 0));
    affine_f64 second = affine_compose(&aside, outer);
    put_instance(c, group, FATHOM_ROOT, outer);
    put_instance(c, group, FATHOM_ROOT, &second);
}

void nested_back(extremes_case *c, double ratio) {
    case_say(c, "groups scaled by %g within groups scaled back", ratio);
    fathom_id things = put_things(c, 1);
    affine_f64 inner = placing(vec_f64(ratio, ratio, ratio), 0.7, vec_f64(ratio, 0, 0));
    double back = 0.9 / ratio;
    affine_f64 outer = placing(vec_f64(back, back, back), -1.1, vec_f64(0.2, 0.1, -0.3));
    nest(c, things, &inner, &outer);
}

void nested_grow(extremes_case *c, double ratio) {
    case_say(c, "groups scaled by %g in two steps, contents as much smaller", ratio);
    fathom_id things = put_things(c, 1 / ratio);
    double step = sqrt(ratio), size = 1 / step;
    affine_f64 inner = placing(vec_f64(step, step, step), 0.7, vec_f64(size, 0, 0));
    affine_f64 outer = placing(vec_f64(step, step, step), -1.1, vec_f64(0.2, 0.1, -0.3));
    nest(c, things, &inner, &outer);
}

void nested_stretch(extremes_case *c, double ratio) {
    case_say(c, "groups stretched by %g along one axis between two turns", ratio);
    c->thin = ratio < 1e-5 || ratio > 1e5 ? 4 : 1; /* so flat that few primitives can be told apart */
    fathom_id things = put_things(c, 1);
    affine_f64 inner = placing(vec_f64(1, 1, 1), 0.7, vec_f64(0.3, 0, 0.1));
    affine_f64 outer = placing(vec_f64(1, ratio, 1), -1.1, vec_f64(0.2, 0.1, -0.3));
    nest(c, things, &inner, &outer);
}

void nested_mirror(extremes_case *c, double ratio) {
    case_say(c, "groups mirrored along x and scaled by %g within groups mirrored along z, scaled back",
             ratio);
    fathom_id things = put_things(c, 1);
    affine_f64 inner = placing(vec_f64(-ratio, ratio, ratio), 0.7, vec_f64(ratio, 0, 0));
    double back = 0.9 / ratio;
    affine_f64 outer = placing(vec_f64(back, 2 * back, -back), -1.1, vec_f64(0.2, 0.1, -0.3));
    nest(c, things, &inner, &outer);
}
