/* Light at grazing angles, where its cosine goes to zero: on a plane and across a ball's terminator. Also
 * spots with half angles from a millionth of a radian to a right angle. */
#include "verify/light/shading_studio.h"

#define PIXELS 33

static const vec3_f64 zero = {0, 0, 0}, down = {0, 0, -1}, across = {1, 0, 0}, up = {0, 0, 1};

/* ---- a plane under parallel light ---- */

static void grazing(studio *s, double cosine) {
    studio_begin(s, PIXELS);
    paint_quad(&s->b, zero, (vec3_f64){4, 0, 0}, (vec3_f64){0, 4, 0}, build_lambert(vec_f64(1, 1, 1)));
    build_directional_light(&s->b, (vec3_f64){-sqrt(1 - cosine * cosine), 0, -cosine}, vec_f64(1, 1, 1), 0);
    studio_camera(s, (vec3_f64){0, 0, 2}, down, across, 2);
    double expected = studio_twisted(s, cosine);
    /* n is exact, the light's z is rounded once, and about 6 products follow. */
    for (uint32_t i = 0, n = studio_render(s); i < n; ++i)
        studio_judge(s, 0, studio_at(s, 0, i), expected, 8 * SHADING_U * expected);
    studio_row(s, 0, "grazing light", cosine, "light that meets a surface under a cosine of %g", cosine);
}

/* ---- across the terminator of a ball ----
 * The ball of radius 1 seen from z = 4, with light from +x; n·l = x. The twist rotates the light. No point of
 * the lit side may be in the ball's own shadow. */

static void terminator(studio *s, double near) {
    studio_begin(s, PIXELS);
    paint_sphere(&s->b, zero, 1, build_lambert(vec_f64(1, 1, 1)));
    build_directional_light(&s->b, neg_f64(across), vec_f64(1, 1, 1), 0);
    double field = 2 * near / 3; /* at distance 3 from the terminator */
    studio_camera(s, (vec3_f64){0, 0, 4}, down, across, field);
    for (uint32_t i = 0, n = studio_render(s); i < n; ++i) {
        vec3_f64 d = studio_direction(s, down, across, field, i);
        double half = 4 * d.z, t = -half - sqrt(half * half - 15), turn = s->options->twist;
        double x = t * d.x, z = 4 + t * d.z, value = x * cos(turn) + z * sin(turn);
        /* The direction's x has no sum: its relative error is 1 u, that of t 16 u, and 24 more roundings
         * follow. z only matters with a twist; its error is 16 u of 4. */
        double bound = 41 * SHADING_U * fabs(x) + 64 * SHADING_U * fabs(sin(turn));
        studio_judge(s, 0, studio_at(s, 0, i), fmax(0, value), bound);
    }
    studio_row(s, 0, "terminator", near, "within %g of a ball's terminator", near);
}

/* ---- spots ----
 * A spot at height 1 over a plane, seen from the light's position. The radiance is ((cos - cos o)/(cos i -
 * cos o))^2 times the plane's cosine divided by the squared distance, which is that cosine cubed. */

static double one_less_cosine(double angle) { return 2 * sin(angle / 2) * sin(angle / 2); }

typedef struct cone {
    double inner, outer; /* angles of the formula */
    vec3_f64 axis, aside;
    double field;
} cone;

/* cos i - cos o */
static double edge_width(const cone *c) {
    return 2 * sin((c->outer + c->inner) / 2) * sin((c->outer - c->inner) / 2);
}

static double falloff(const cone *c, double angle) {
    double t = (one_less_cosine(c->outer) - one_less_cosine(angle)) / edge_width(c);
    t = t < 0 ? 0 : (t > 1 ? 1 : t);
    return t * t;
}

/* Straight down, the angle's relative error is 16 u. Otherwise the axis, the direction and the point's
 * coordinates are rounded, 36 u together. The cone's edge and scale have 4 roundings each, relative to its
 * axis; 24 more follow. */
static void judge_spot(studio *s, const cone *c, uint32_t i) {
    vec3_f64 d = studio_direction(s, c->axis, c->aside, c->field, i);
    double angle = atan(fabs((i + 0.5) / PIXELS - 0.5) * c->field);
    double off = c->axis.x == 0 ? 16 * SHADING_U * angle : 36 * SHADING_U;
    double value = falloff(c, angle), nearer = falloff(c, fmax(angle - off, 0)),
           further = falloff(c, angle + off), cube = -d.z * d.z * d.z;
    double spread = one_less_cosine(c->outer) / edge_width(c);
    double bound = fmax(nearer - value, value - further) + nearer * 24 * SHADING_U +
                   (nearer > 0 && further < 1 ? 8 * SHADING_U * spread : 0);
    studio_judge(s, 0, studio_at(s, 0, i), cube * value, cube * bound);
}

typedef enum spot_kind { SPOT_SOFT, SPOT_HARD, SPOT_TILTED } spot_kind;

static void spot(studio *s, double outer, spot_kind kind) {
    static const char *const names[] = {"soft edge", "hard edge", "tilted"};
    bool tilted = kind == SPOT_TILTED;
    cone c = {.axis = tilted ? (vec3_f64){0.6, 0, -0.8} : down,
              .aside = tilted ? (vec3_f64){0.8, 0, 0.6} : across,
              .field = 2 * tan(fmin(1.25 * outer, tilted ? 0.5 : 1.2))};
    studio_begin(s, PIXELS);
    paint_plane(&s->b, zero, up, build_lambert(vec_f64(1, 1, 1)));
    fathom_light light = build_light_of(FATHOM_LIGHT_SPOT, up, c.axis, vec_f64(1, 1, 1));
    light.inner_angle = kind == SPOT_HARD ? (float)(0.9999 * outer) : 0, light.outer_angle = (float)outer;
    build_light(&s->b, &light);
    studio_camera(s, up, c.axis, c.aside, c.field);
    c.inner = studio_twisted(s, (double)light.inner_angle);
    c.outer = studio_twisted(s, (double)light.outer_angle);
    for (uint32_t i = 0, n = studio_render(s); i < n; ++i) judge_spot(s, &c, i);
    studio_row(s, 0, "spot", outer, "spot of half angle %g rad, %s", outer, names[kind]);
}

void shading_slants(studio *s) {
    for (int e = 0; e <= 7; ++e) {
        grazing(s, pow(10, -e));
        terminator(s, 0.5 * pow(10, -e));
    }
    for (int e = 0; e <= 6; ++e) {
        for (int kind = SPOT_SOFT; kind <= SPOT_TILTED; ++kind)
            spot(s, e ? pow(10, -e) : 1.5707963, (spot_kind)kind);
    }
}
