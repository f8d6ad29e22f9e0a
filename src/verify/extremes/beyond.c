/* Shapes at the end of float's range and past it, beside good ones. Embree leaves out what has a coordinate
 * beyond 1.8e18; the world counts that. */
#include "verify/extremes/case.h"

static const vec3_f64 middle = {0, 0, 0};

static void put_far_triangles(extremes_case *c, double at) {
    vec3_f64 corners[24];
    for (unsigned i = 0; i < 24; ++i) {
        corners[i] = vec_f64(scattered(i, 0, -1, 1), scattered(i, 1, -1, 1), scattered(i, 2, -1, 1));
        if (i % 3 == i / 3 % 3) corners[i] = scale_f64(at, normalize_f64(corners[i]));
    }
    put_triangles(c, FATHOM_ROOT, middle, corners, 8);
}

void beyond_triangles(extremes_case *c, double at) {
    case_say(c, "among good triangles: some with a corner %g away", at);
    c->thin = 8; /* such exponents take the oracle's whole numbers long */
    put_ball(c, FATHOM_ROOT, middle, 0.3);
    put_far_triangles(c, at);
}

void beyond_quads(extremes_case *c, double at) {
    case_say(c, "among good quads: some with sides of %g", at);
    c->thin = 4;
    put_quads(c, FATHOM_ROOT, middle, 1);
    for (unsigned i = 0; i < 6; ++i) {
        vec3_f64 u = vec_f64(scattered(i, 0, -1, 1), scattered(i, 1, -1, 1), scattered(i, 2, -1, 1));
        vec3_f64 v = cross_f64(u, vec_f64(0.3, 1, -0.2));
        put_quad(c, FATHOM_ROOT, scale_f64(3, u), scale_f64(at, u), scale_f64(at, v));
    }
}

void beyond_spheres(extremes_case *c, double at) {
    case_say(c, "among good spheres: one of radius %g around all, and one as far away", at);
    put_spheres(c, FATHOM_ROOT, middle, 1);
    put_sphere(c, FATHOM_ROOT, middle, at);
    put_sphere(c, FATHOM_ROOT, vec_f64(0.6 * at, -1.2 * at, 0), 0.5 * at);
}
