/* A soft procedural studio, which lights models that have no light of their own. A grey backdrop runs from
 * the floor to the wall behind the model. A large soft box stands to the viewer's left and a fill light to
 * the right, a strip above and behind the model lights its rim, and a small panel overhead lights its top. */
#include "light/studio.h"

#include <math.h>
#include <stddef.h>

/* A light panel: its centre's direction from the model, in degrees to the right of the viewer and above the
 * floor; half of its width and height in degrees; and its radiance. */
typedef struct panel {
    double right, up, width, height;
    float radiance[3];
} panel;

static const panel panels[STUDIO_PANELS] = {
    {-48, 42, 28, 22, {4.2f, 4.0f, 3.75f}},
    {62, 22, 18, 30, {0.55f, 0.6f, 0.68f}},
    {150, 58, 45, 9, {3.0f, 3.05f, 3.2f}},
    {0, 90, 24, 24, {1.2f, 1.2f, 1.2f}},
};

/* The panels' edges fade over this many degrees. */
#define STUDIO_EDGE 6.0

static double smooth_step(double a, double b, double x) {
    const double t = fmin(fmax((x - a) / (b - a), 0), 1);
    return t * t * (3 - 2 * t);
}

static double degrees(double radians) { return radians * 57.29577951308232; }

/* The frame of a panel: `centre` points to it, `across` is horizontal. */
static studio_panel stand(const panel *p) {
    const double right = p->right / 57.29577951308232, up = p->up / 57.29577951308232;
    studio_panel out = {.centre = {cos(up) * sin(right), sin(up), cos(up) * cos(right)},
                        .across = {cos(right), 0, -sin(right)}};
    out.rise = cross_f64(out.centre, out.across);
    out.least = cos(hypot(p->width + STUDIO_EDGE, p->height + STUDIO_EDGE) / 57.29577951308232);
    return out;
}

static double share_of(const panel *p, const studio_panel *at, const vec3_f64 d) {
    const double ahead = dot_f64(d, at->centre);
    if (ahead <= at->least) return 0;
    const double x = fabs(degrees(atan2(dot_f64(d, at->across), ahead))),
                 y = fabs(degrees(atan2(dot_f64(d, at->rise), ahead)));
    return (1 - smooth_step(p->width, p->width + STUDIO_EDGE, x)) *
           (1 - smooth_step(p->height, p->height + STUDIO_EDGE, y));
}

void studio_open(studio *out) {
    for (size_t i = 0; i < STUDIO_PANELS; ++i) out->panels[i] = stand(&panels[i]);
}

void studio_radiance(const studio *s, vec3_f64 d, float radiance[3]) {
    /* Brightness from the floor, over the wall, to the dark ceiling. */
    const double floor = 0.09 + 0.15 * smooth_step(-0.9, 0.1, d.y),
                 grey = floor - 0.19 * smooth_step(0.15, 0.9, d.y);
    const float tint[3] = {0.97f, 0.99f, 1.03f};
    for (int c = 0; c < 3; ++c) radiance[c] = (float)grey * tint[c];
    for (size_t i = 0; i < STUDIO_PANELS; ++i) {
        const float share = (float)share_of(&panels[i], &s->panels[i], d);
        for (int c = 0; c < 3; ++c) radiance[c] += share * panels[i].radiance[c];
    }
}
