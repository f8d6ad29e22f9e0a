/* Light along the surface, where its cosine goes to zero: on a plane, across a ball's terminator, and cones
 * of spots from a millionth of a radian to half a turn. */
#include "verify/light/shading_studio.h"

#define PIXELS 33

static const vec3_f64 down = {0, 0, -1}, across = {1, 0, 0}, up = {0, 0, 1};

static void parallel_light(studio *s, vec3_f64 towards) {
    fathom_light light;
    fathom_light_default(&light);
    light.type = FATHOM_LIGHT_DIRECTIONAL;
    store_f64(light.direction, neg_f64(towards));
    studio_light(s, &light);
}

/* ---- a plane under parallel light ---- */

static fathom_status grazing(fathom_context *context, const shading_options *options, shading_rows *rows,
                             double cosine) {
    studio s;
    studio_open(context, options, rows, PIXELS, &s);
    fathom_material white = studio_lambert(1, 1, 1);
    vec3_f64 half = {4, 0, 0}, other = {0, 4, 0};
    studio_quad(&s, (vec3_f64){0, 0, 0}, half, other, &white);
    parallel_light(&s, (vec3_f64){sqrt(1 - cosine * cosine), 0, cosine});
    studio_camera(&s, (vec3_f64){0, 0, 2}, down, across, 2);
    studio_worst worst = {0};
    double expected = studio_twisted(&s, cosine);
    bool rendered = studio_render(&s);
    /* n is exact, the light's z rounded once, and some 6 products follow. */
    for (uint32_t i = 0; rendered && i < PIXELS; ++i)
        studio_judge(&worst, studio_at(&s, 0, i), expected, 8 * SHADING_U * expected);
    studio_row(&s, "grazing light", cosine, &worst, "light that meets a surface under a cosine of %g",
               cosine);
    return studio_close(&s);
}

/* ---- across the terminator of a ball ----
 * The ball of radius 1 from z = 4, the light from +x, turned by the twist: n·l = x where the formula's light
 * is not turned. No point on the lit side may be in the ball's own shadow. */

static fathom_status terminator(fathom_context *context, const shading_options *options, shading_rows *rows,
                                double near) {
    studio s;
    studio_open(context, options, rows, PIXELS, &s);
    fathom_material white = studio_lambert(1, 1, 1);
    studio_sphere(&s, (vec3_f64){0, 0, 0}, 1, &white);
    parallel_light(&s, across);
    /* At distance 3 from the terminator. */
    double field = 2 * near / 3;
    studio_camera(&s, (vec3_f64){0, 0, 4}, down, across, field);
    studio_worst worst = {0};
    bool rendered = studio_render(&s);
    for (uint32_t i = 0; rendered && i < PIXELS; ++i) {
        vec3_f64 d = studio_direction(&s, down, across, field, i);
        double half = 4 * d.z, t = -half - sqrt(half * half - 15), turn = s.options->twist;
        double x = t * d.x, z = 4 + t * d.z, value = x * cos(turn) + z * sin(turn);
        /* Sideways nothing is added to the direction's x: it is good to 1 u of itself, t to 16 u, what is
         * made of them to 24 more; and z, of which only a twist takes a share, to 16 u of 4. */
        double bound = 41 * SHADING_U * fabs(x) + 64 * SHADING_U * fabs(sin(turn));
        studio_judge(&worst, studio_at(&s, 0, i), fmax(0, value), bound);
    }
    studio_row(&s, "terminator", near, &worst, "within %g of a ball's terminator", near);
    return studio_close(&s);
}

/* ---- spots ----
 * At height 1 over a plane, seen from the light's own place: ((cos - cos o)/(cos i - cos o))^2 times the
 * plane's cosine over the squared distance, which is that cosine cubed. */

static double one_less_cosine(double angle) { return 2 * sin(angle / 2) * sin(angle / 2); }

typedef struct cone {
    double inner, outer; /* as the formula has them */
    vec3_f64 axis, aside;
    double field;
} cone;

static double falloff(const cone *c, double angle) {
    double t = (one_less_cosine(c->outer) - one_less_cosine(angle)) /
               (2 * sin((c->outer + c->inner) / 2) * sin((c->outer - c->inner) / 2));
    t = t < 0 ? 0 : (t > 1 ? 1 : t);
    return t * t;
}

/* Straight down, what lies sideways is good to its own last places, so the angle to 16 u of itself. Else the
 * axis, the direction and the point's coordinates are rounded, 36 u together. The cone is off by its edge's
 * and scale's roundings, 4 each, as seen from its middle; 24 more follow. */
static void judge_spot(const studio *s, const cone *c, uint32_t i, studio_worst *worst) {
    vec3_f64 d = studio_direction(s, c->axis, c->aside, c->field, i);
    double angle = atan(fabs((i + 0.5) / PIXELS - 0.5) * c->field);
    double off = c->axis.x == 0 ? 16 * SHADING_U * angle : 36 * SHADING_U;
    double value = falloff(c, angle), nearer = falloff(c, fmax(angle - off, 0)),
           further = falloff(c, angle + off), cube = -d.z * d.z * d.z;
    double spread =
        one_less_cosine(c->outer) / (2 * sin((c->outer + c->inner) / 2) * sin((c->outer - c->inner) / 2));
    double bound = fmax(nearer - value, value - further) + nearer * 24 * SHADING_U +
                   (nearer > 0 && further < 1 ? 8 * SHADING_U * spread : 0);
    studio_judge(worst, studio_at(s, 0, i), cube * value, cube * bound);
}

typedef enum spot_kind { SPOT_SOFT, SPOT_HARD, SPOT_TILTED } spot_kind;

static fathom_status spot(fathom_context *context, const shading_options *options, shading_rows *rows,
                          double outer, spot_kind kind) {
    static const char *const names[] = {"soft edge", "hard edge", "tilted"};
    bool tilted = kind == SPOT_TILTED;
    cone c = {.axis = tilted ? (vec3_f64){0.6, 0, -0.8} : down,
              .aside = tilted ? (vec3_f64){0.8, 0, 0.6} : across,
              .field = 2 * tan(fmin(1.25 * outer, tilted ? 0.5 : 1.2))};
    studio s;
    studio_open(context, options, rows, PIXELS, &s);
    fathom_material white = studio_lambert(1, 1, 1);
    studio_plane(&s, (vec3_f64){0, 0, 0}, up, &white);
    fathom_light light;
    fathom_light_default(&light);
    light.type = FATHOM_LIGHT_SPOT;
    store_f64(light.position, up), store_f64(light.direction, c.axis);
    light.inner_angle = kind == SPOT_HARD ? (float)(0.9999 * outer) : 0, light.outer_angle = (float)outer;
    studio_light(&s, &light);
    studio_camera(&s, up, c.axis, c.aside, c.field);
    c.inner = studio_twisted(&s, (double)light.inner_angle);
    c.outer = studio_twisted(&s, (double)light.outer_angle);
    studio_worst worst = {0};
    bool rendered = studio_render(&s);
    for (uint32_t i = 0; rendered && i < PIXELS; ++i) judge_spot(&s, &c, i, &worst);
    studio_row(&s, "spot", outer, &worst, "spot of half angle %g rad, %s", outer, names[kind]);
    return studio_close(&s);
}

fathom_status shading_slants(fathom_context *context, const shading_options *options, shading_rows *rows) {
    fathom_status status = FATHOM_OK;
    for (int e = 0; e <= 7 && status == FATHOM_OK; ++e) {
        status = grazing(context, options, rows, pow(10, -e));
        if (status == FATHOM_OK) status = terminator(context, options, rows, 0.5 * pow(10, -e));
    }
    for (int e = 0; e <= 6 && status == FATHOM_OK; ++e) {
        double outer = e ? pow(10, -e) : 1.5707963;
        for (int kind = SPOT_SOFT; kind <= SPOT_TILTED && status == FATHOM_OK; ++kind)
            status = spot(context, options, rows, outer, (spot_kind)kind);
    }
    return status;
}
