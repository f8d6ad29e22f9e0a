/* Two facing mirrors that are nearly parallel: one at z = 0, the other through (0, 1), sloping down towards
 * +x by a small angle a. Unfolded, the path is one straight line: after 2m reflections it is the camera ray
 * rotated by -2 m a about the apex, where the mirrors' planes intersect; after one more reflection z is
 * negated. So each hit and the exit of the path have a closed form, for any number of reflections. */
#include "verify/light/shading_studio.h"

#define PIXELS 32

/* Ends of the mirrors, and distance of the rulers from them. */
static const double left = -1, right = 8, beyond = 2;
static const vec3_f64 eye = {0, 0, 0.5};

typedef struct corridor {
    double angle, gap; /* values for the formula */
    uint32_t max_depth;
} corridor;

/* The image's x axis runs along z, so pixels differ in slope: from about half a bounce to nearly 200 bounces
 * per unit of x. */
static const double field = 1.2;
static vec3_f64 view_of(void) { return normalize_f64((vec3_f64){1, 0, -1.7}); }
static vec3_f64 up_of(void) { return normalize_f64((vec3_f64){1.7, 0, 1}); }

static fathom_material mirror(void) {
    fathom_material m = build_black();
    m.k_r[0] = m.k_r[1] = m.k_r[2] = 1;
    m.k_e[2] = 1; /* blue counts the hits */
    return m;
}

static void build(studio *s, double angle, uint32_t max_depth) {
    double middle = (left + right) / 2, half = (right - left) / 2;
    studio_begin(s, PIXELS);
    paint_quad(&s->b, (vec3_f64){middle, 0, 0}, (vec3_f64){half, 0, 0}, (vec3_f64){0, 1, 0}, mirror());
    paint_quad(&s->b, (vec3_f64){middle, 0, 1 - middle * tan(angle)}, (vec3_f64){half, 0, -half * tan(angle)},
               (vec3_f64){0, -1, 0}, mirror());
    paint_plane(&s->b, (vec3_f64){left - beyond, 0, 0}, (vec3_f64){1, 0, 0}, build_lambert(vec_f64(1, 0, 0)));
    paint_plane(&s->b, (vec3_f64){right + beyond, 0, 0}, (vec3_f64){-1, 0, 0},
                build_lambert(vec_f64(0, 1, 0)));
    build_point_light(&s->b, (vec3_f64){left - beyond + 1, 2, 0.5}, vec_f64(1, 0, 0), 0);
    build_point_light(&s->b, (vec3_f64){right + beyond - 1, 2, 0.5}, vec_f64(0, 1, 0), 0);
    studio_camera(s, eye, view_of(), up_of(), field);
    s->settings.max_depth = max_depth;
}

/* The line after `bounces` reflections. With θ = -2 m a, (1 - cos θ) and sin θ times the apex's distance gap
 * / tan a stay finite as a goes to 0. */
static void unfolded(const corridor *c, vec3_f64 direction, unsigned bounces, vec3_f64 *at, vec3_f64 *along) {
    double m = bounces / 2, turn = 2 * m * c->angle, tangent = tan(c->angle);
    double cosine = cos(turn), sine = -sin(turn), half = sin(m * c->angle);
    double x = tangent > 0 ? 2 * half * half * c->gap / tangent : 0;
    double z = tangent > 0 ? sin(turn) * c->gap / tangent : 2 * m * c->gap;
    *at = (vec3_f64){cosine * eye.x - sine * eye.z + x, 0, sine * eye.x + cosine * eye.z + z};
    *along =
        (vec3_f64){cosine * direction.x - sine * direction.z, 0, sine * direction.x + cosine * direction.z};
    if (bounces % 2) at->z = -at->z, along->z = -along->z;
}

/* Distance along the line to its next mirror, or infinity; x: the coordinate of that point. */
static double next_mirror(const corridor *c, unsigned bounces, vec3_f64 at, vec3_f64 along, double *x) {
    double slope = bounces % 2 ? -tan(c->angle) : 0, height = bounces % 2 ? c->gap : 0;
    double t = (height + slope * at.x - at.z) / (along.z - slope * along.x);
    *x = at.x + t * along.x;
    return t;
}

typedef struct leaving {
    unsigned hits;
    bool ended;               /* at the depth limit */
    bool sure;                /* no hit is so close to a mirror's end that float may decide differently */
    vec3_f64 at, along, last; /* the line, and the last hit on it */
    beam error;               /* error of the path so far: only its bounds are used */
} leaving;

static vec3_f64 facing(const corridor *c, unsigned bounces) {
    return bounces % 2 ? (vec3_f64){-sin(c->angle), 0, -cos(c->angle)} : (vec3_f64){0, 0, 1};
}

/* Corners are rounded: over a mirror's 9 units, this rotates it by less than 2 u. Its normal is a normalised
 * cross product. */
static const double normal_error = 8 * SHADING_U;

static leaving follow(const corridor *c, vec3_f64 direction) {
    leaving out = {.sure = true, .last = eye, .error = beam_start(eye, direction)};
    for (;; ++out.hits) {
        double x;
        unfolded(c, direction, out.hits, &out.at, &out.along);
        double t = next_mirror(c, out.hits, out.at, out.along, &x);
        double slant = fabs(dot_f64(out.along, facing(c, out.hits)));
        double blur = 2 * (out.error.aside + 32 * SHADING_U * right) / slant;
        bool on = t > 0 && x > left && x < right;
        out.sure &= fabs(x - left) > blur && fabs(x - right) > blur;
        if (out.hits > c->max_depth) out.ended = true;
        if (!on || out.ended) return out;
        vec3_f64 hit = madd_f64(out.at, t, out.along);
        beam_go(&out.error, length_f64(sub_f64(hit, out.last)), right);
        beam_mirror(&out.error, facing(c, out.hits), normal_error);
        out.last = hit;
    }
}

/* Blue counts the hits; red and green show where the path ends on the rulers. */
static void judge(studio *s, const corridor *c, uint32_t i) {
    leaving path = follow(c, studio_direction(s, view_of(), up_of(), field, i));
    if (!path.sure) return;
    studio_judge(s, 0, studio_at(s, 2, i), path.hits, 0);
    if (path.ended) return;
    bool back = path.along.x < 0;
    double wall = back ? left - beyond : right + beyond, bound = 0;
    beam b = path.error;
    vec3_f64 at = madd_f64(path.at, (wall - path.at.x) / path.along.x, path.along);
    beam_go(&b, length_f64(sub_f64(at, path.last)), fmax(right, fabs(at.z)) + beyond);
    b.at = at, b.along = path.along;
    double value = beam_radiance(&b, (vec3_f64){back ? wall + 1 : wall - 1, 2, 0.5},
                                 (vec3_f64){back ? 1 : -1, 0, 0}, fmax(right, fabs(b.at.z)) + beyond, &bound);
    studio_judge(s, 1, studio_at(s, back ? 0 : 1, i), value, bound);
}

static void corridor_of(studio *s, double angle, uint32_t max_depth) {
    build(s, angle, max_depth);
    corridor c = {angle, studio_twisted(s, 1), max_depth};
    for (uint32_t i = 0, n = studio_render(s); i < n; ++i) judge(s, &c, i);
}

void shading_mirrors(studio *s) {
    static const double angles[] = {0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1};
    static const uint32_t depths[] = {0, 1, 5, 11, 64};
    for (size_t i = 0; i < sizeof angles / sizeof *angles; ++i) {
        double angle = angles[i];
        corridor_of(s, angle, 64);
        studio_row(s, 0, "mirrors", angle, "hits between mirrors %g rad from parallel", angle);
        studio_row(s, 1, "mirrors", angle, "light where paths leave mirrors %g rad from parallel", angle);
    }
    for (size_t i = 0; i < sizeof depths / sizeof *depths; ++i) {
        corridor_of(s, 1e-3, depths[i]);
        studio_row(s, 0, "mirror depth", depths[i], "hits of mirrors 1e-3 rad apart, %u bounces allowed",
                   depths[i]);
    }
}
