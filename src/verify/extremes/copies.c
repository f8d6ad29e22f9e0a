/* Surfaces at one place: which of them answers is a tie. */
#include "verify/extremes/case.h"

static const vec3_f64 middle = {0, 0, 0};

/* The oracle looks at every copy. */
static void thin_out(extremes_case *c, double copies) { c->thin = (unsigned)fmax(1, copies / 500); }

void copies_triangles(extremes_case *c, double count) {
    uint32_t n = (uint32_t)count;
    thin_out(c, count);
    case_say(c, "one triangle %u times", n);
    vec3_f64 *corners = case_memory(c, n * 3 * sizeof *corners);
    for (uint32_t i = 0; corners && i < n; ++i) {
        corners[3 * (size_t)i] = vec_f64(-1, -0.7, 0.1);
        corners[3 * (size_t)i + 1] = vec_f64(1.1, -0.4, -0.3);
        corners[3 * (size_t)i + 2] = vec_f64(0.2, 1.3, 0.2);
    }
    if (corners) put_triangles(c, FATHOM_ROOT, middle, corners, n);
}

void copies_quads(extremes_case *c, double count) {
    case_say(c, "one quad %g times", count);
    thin_out(c, count);
    for (double i = 0; i < count; ++i)
        put_quad(c, FATHOM_ROOT, vec_f64(0.1, 0.2, -0.1), vec_f64(0.9, 0.1, 0.2), vec_f64(-0.2, 1, 0.3));
}

void copies_spheres(extremes_case *c, double count) {
    case_say(c, "one sphere %g times", count);
    thin_out(c, count);
    for (double i = 0; i < count; ++i) put_sphere(c, FATHOM_ROOT, vec_f64(0.1, 0.2, -0.1), 0.7);
}

/* ---- partly over each other ---- */

/* Triangles and quads in one plane, their corners anywhere: no side lies along another's, where surfaces that
 * share no corners would leave a seam. */
static void put_layer(extremes_case *c, double count, vec3_f64 x, vec3_f64 y) {
    uint32_t n = (uint32_t)count;
    thin_out(c, 10 * count);
    vec3_f64 *corners = case_memory(c, n * 3 * sizeof *corners);
    for (uint32_t i = 0; corners && i < 3 * n; ++i)
        corners[i] = add_f64(scale_f64(scattered(i, 0, -1, 1), x), scale_f64(scattered(i, 1, -1, 1), y));
    if (corners) put_triangles(c, FATHOM_ROOT, middle, corners, n);
    for (uint32_t i = 0; i < n; ++i) {
        double size = scattered(i, 4, 0.02, 0.5);
        vec3_f64 at = add_f64(scale_f64(scattered(i, 2, -1, 1), x), scale_f64(scattered(i, 3, -1, 1), y));
        put_quad(c, FATHOM_ROOT, at, scale_f64(size, x), scale_f64(size / 2, y));
    }
}

void overlap_level(extremes_case *c, double count) {
    case_say(c, "%g triangles and as many quads over each other in the plane z = 0", count);
    put_layer(c, count, vec_f64(1, 0, 0), vec_f64(0, 1, 0));
}

void overlap_tilted(extremes_case *c, double count) {
    case_say(c, "%g triangles and as many quads over each other in a tilted plane, as float has it", count);
    put_layer(c, count, vec_f64(0.8, 0.13, 0.57), vec_f64(-0.3, 0.9, 0.31));
}
