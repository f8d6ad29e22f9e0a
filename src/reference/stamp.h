/* Includes the intersectors for one precision. Defined before: REAL, VEC3, FN(name), SQRT, ABS, and
 * - UNIT: the unit roundoff;
 * - RANGE_LOW, RANGE_HIGH: fourth powers of numbers between them keep full relative precision;
 * - AREA_LOW, AREA_HIGH: sums of products between them keep it too, with denormals flushed or not. */

/* Triangle: P = (1-u-v) A + u B + v C. Quad: see quad_text.h. */
typedef struct FN(reference_hit) {
    REAL t, u, v;
} FN(reference_hit);

static inline REAL FN(largest)(VEC3 a) {
    REAL x = ABS(a.x), y = ABS(a.y), z = ABS(a.z), m = x > y ? x : y;
    return m > z ? m : z;
}

/* Fallbacks in the next wider precision, in reference.c. Rarely called. */
bool FN(sphere_roots_wide)(VEC3 center, REAL radius, VEC3 org, VEC3 dir, REAL roots[2]);
/* Same, for a sphere whose centre and radius are sums of two numbers each; the second is below the last place
 * of the first. */
bool FN(sphere_roots_split)(const VEC3 center[2], const REAL radius[2], VEC3 org, VEC3 dir, REAL roots[2]);
/* Computes the weights of B and C from three sheared vertices; false: miss. */
bool FN(triangle_weights_wide)(VEC3 a, VEC3 b, VEC3 c, REAL weights[2]);
bool FN(triangle_has_area_wide)(VEC3 a, VEC3 b, VEC3 c);
REAL FN(plane_wide)(VEC3 point, VEC3 normal, VEC3 org, VEC3 dir);

#include "reference/sphere_text.h"

#include "reference/triangle_text.h"

#include "reference/quad_text.h"

#undef REAL
#undef VEC3
#undef FN
#undef SQRT
#undef ABS
#undef UNIT
#undef RANGE_LOW
#undef RANGE_HIGH
#undef AREA_LOW
#undef AREA_HIGH
