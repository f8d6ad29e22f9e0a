/* Triangles: points and normals of sixteen hits. */
#include "math/inverse_root.h"
#include "math/lane.h"
#include "surface/kernels/kernel.h"

static inline double clamp_unit(double x) { return x > 0 ? (x < 1 ? x : 1) : 0; }
static inline float larger(float a, float b) { return a > b ? a : b; }
static inline float largest(vec3_f32 v) { return larger(fabsf(v.x), larger(fabsf(v.y), fabsf(v.z))); }

static inline void put_f64(lanes3_f64 to, unsigned i, bool mine, vec3_f64 v) {
    to[0][i] = mine ? v.x : to[0][i], to[1][i] = mine ? v.y : to[1][i], to[2][i] = mine ? v.z : to[2][i];
}
static inline void put_f32(float to[3][LANES], unsigned i, uint32_t mine, vec3_f32 v) {
    to[0][i] = chosen(mine, v.x, to[0][i]);
    to[1][i] = chosen(mine, v.y, to[1][i]);
    to[2][i] = chosen(mine, v.z, to[2][i]);
}

/* The largest coordinate of any side. Float is accurate enough for its use as a bound. */
static inline float extent_of(vec3_f32 a, vec3_f32 b, vec3_f32 c) {
    return larger(largest(sub_f32(b, a)), larger(largest(sub_f32(c, a)), largest(sub_f32(c, b))));
}

/* Computed step by step, all in double: the processor overlaps such short loops, but one long loop would wait
 * for its divisions and roots. */
typedef struct facet_points {
    double a[3][LANES], ab[3][LANES], ac[3][LANES]; /* a corner, and the sides from it */
    double n[3][LANES], inverse[LANES];             /* normal, and the inverse of its length */
    double u[LANES], v[LANES], determinant[LANES];  /* weights of the second and third corner */
} facet_points;

static void find_sides(const facet_block *f, facet_points *restrict out) {
    for (int c = 0; c < 3; ++c) {
        for (unsigned i = 0; i < LANES; ++i) {
            double a = (double)f->corner[0][c][i];
            out->a[c][i] = a;
            out->ab[c][i] = (double)f->corner[1][c][i] - a;
            out->ac[c][i] = (double)f->corner[2][c][i] - a;
        }
    }
}

static void find_normals(facet_points *restrict p) {
    for (unsigned i = 0; i < LANES; ++i) {
        vec3_f64 n = cross_f64(lane_f64(p->ab, i), lane_f64(p->ac, i));
        put_f64(p->n, i, true, n);
        p->inverse[i] = dot_f64(n, n);
    }
    for (unsigned i = 0; i < LANES; ++i) p->inverse[i] = inverse_root(p->inverse[i] > 0 ? p->inverse[i] : 1);
}

/* Weights of the second and third corner (Möller and Trumbore 1997), clamped to the triangle: another
 * tracer's hit may be outside by a rounding here. */
static void weigh(const local_block *b, facet_points *restrict p) {
    for (unsigned i = 0; i < LANES; ++i) {
        vec3_f64 ab = lane_f64(p->ab, i), ac = lane_f64(p->ac, i), dir = lane_f64(b->dir, i);
        vec3_f64 from_a = sub_f64(lane_f64(b->org, i), lane_f64(p->a, i));
        vec3_f64 across = cross_f64(dir, ac), along = cross_f64(from_a, ab);
        p->determinant[i] = dot_f64(ab, across);
        p->u[i] = dot_f64(from_a, across), p->v[i] = dot_f64(dir, along);
    }
    for (unsigned i = 0; i < LANES; ++i) {
        bool flat = p->determinant[i] == 0;
        double inverse = 1 / (flat ? 1 : p->determinant[i]);
        double x = clamp_unit(p->u[i] * inverse), y = clamp_unit(p->v[i] * inverse);
        x = flat ? 1 / 3.0 : x, y = flat ? 1 / 3.0 : y;
        double most = 1 - x;
        p->u[i] = x, p->v[i] = y < most ? y : most;
    }
}

static inline void set_points(const facet_points *p, bool all, const uint32_t facet[LANES],
                              local_block *restrict b) {
    for (unsigned i = 0; i < LANES; ++i) {
        bool mine = all || facet[i] != 0;
        vec3_f64 at = madd_f64(lane_f64(p->a, i), p->u[i], lane_f64(p->ab, i));
        put_f64(b->p, i, mine, madd_f64(at, p->v[i], lane_f64(p->ac, i)));
        put_f64(b->n, i, mine, scale_f64(p->inverse[i], lane_f64(p->n, i)));
    }
}

static void set_weights(const facet_points *from, float (*restrict weight)[LANES]) {
    for (unsigned i = 0; i < LANES; ++i) {
        double u = from->u[i], v = from->v[i];
        weight[0][i] = (float)(1 - u - v), weight[1][i] = (float)u, weight[2][i] = (float)v;
    }
}

static void set_self_hit(const facet_block *f, bool all, double *restrict out) {
    for (unsigned i = 0; i < LANES; ++i) {
        double self_hit =
            LOCAL_FACE_SELF_HIT * (double)extent_of(lane_f32(f->corner[0], i), lane_f32(f->corner[1], i),
                                                    lane_f32(f->corner[2], i));
        out[i] = all || f->facet[i] ? self_hit : out[i];
    }
}

static void find_points(const facet_block *f, local_block *restrict b) {
    facet_points points;
    uint32_t others = 0;
    for (unsigned i = 0; i < LANES; ++i) others |= ~f->facet[i];
    find_sides(f, &points);
    find_normals(&points);
    weigh(b, &points);
    set_weights(&points, b->weight);
    if (others) {
        set_points(&points, false, f->facet, b);
        set_self_hit(f, false, b->self_hit);
    } else {
        set_points(&points, true, f->facet, b);
        set_self_hit(f, true, b->self_hit);
    }
}

/* v / |v| if the square is out of float's range. First v is multiplied by a power of two. This is exact, so a
 * scaled scene gets the same bits. It is done in two steps, because the full power may be out of range
 * itself. */
static vec3_f32 unit_of_stiff(vec3_f32 v) {
    int exponent;
    frexpf(largest(v), &exponent);
    v = scale_f32(ldexpf(1, -exponent / 2), scale_f32(ldexpf(1, -exponent - (-exponent / 2)), v));
    float square = dot_f32(v, v);
    return square > 0 ? scale_f32(1 / sqrtf(square), v) : v;
}

/* Normals with a squared length this close to 1 are not normalised. Their length only acts as a weight in the
 * mean, which is normalised later: an error of 2^-21 rotates it by this fraction of the angle between the
 * normals. */
#define UNIT_SQUARE 0x1p-20f

static bool are_unit(const float normal[3][LANES], const uint32_t has_normals[LANES]) {
    uint32_t off = 0;
    for (unsigned i = 0; i < LANES; ++i) {
        vec3_f32 v = lane_f32(normal, i);
        off |= has_normals[i] & (fabsf(dot_f32(v, v) - 1) <= UNIT_SQUARE ? 0 : ~0u);
    }
    return !off;
}

static bool all_unit(const facet_block *f) {
    return are_unit(f->normal[0], f->has_normals) && are_unit(f->normal[1], f->has_normals) &&
           are_unit(f->normal[2], f->has_normals);
}

static void make_unit(const float from[3][LANES], float (*restrict to)[LANES]) {
    int stiff = 0;
    for (unsigned i = 0; i < LANES; ++i) {
        vec3_f32 v = lane_f32(from, i);
        float square = dot_f32(v, v);
        stiff |= !((square > 0x1p-100f) & (square < 0x1p100f));
        put_f32(to, i, ~0u, scale_f32(1 / sqrtf(square), v));
        put_f32(to, i, fabsf(square - 1) <= UNIT_SQUARE ? ~0u : 0, v);
    }
    for (unsigned i = 0; stiff && i < LANES; ++i) {
        vec3_f32 v = lane_f32(from, i);
        float square = dot_f32(v, v);
        if (!(square > 0x1p-100f && square < 0x1p100f)) put_f32(to, i, ~0u, unit_of_stiff(v));
    }
}

/* If the normals cancel, the facet keeps its geometric normal and is not `smooth`. */
static void mix_normals(const facet_block *f, const float (*normal)[3][LANES], local_block *restrict b) {
    for (unsigned i = 0; i < LANES; ++i) {
        vec3_f32 sum = {0, 0, 0};
        for (int k = 0; k < 3; ++k) sum = madd_f32(sum, b->weight[k][i], lane_f32(normal[k], i));
        float square = dot_f32(sum, sum);
        uint32_t mine = f->has_normals[i] & (square > 0x1p-40f ? ~0u : 0);
        put_f32(b->ns, i, mine, scale_f32(1 / sqrtf(square), sum));
        b->smooth[i] = mine;
    }
}

/* Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II (2021): p plus the weighted mean of its
 * offsets to the tangent planes at the corners, for planes that lie above it on the viewer's side. Winding
 * and normals may disagree about the outside; the normals decide. */
static void lift(const facet_block *f, const float (*normal)[3][LANES], local_block *restrict b) {
    for (unsigned i = 0; i < LANES; ++i) {
        vec3_f32 p = narrow(lane_f64(b->p, i)), sum = {0, 0, 0};
        float along = (float)dot_f64(widen(lane_f32(b->ns, i)), lane_f64(b->n, i));
        float facing = (float)dot_f64(lane_f64(b->dir, i), lane_f64(b->n, i));
        float viewer = facing < 0 ? 1 : -1, side = along < 0 ? -viewer : viewer;
        for (int k = 0; k < 3; ++k) {
            vec3_f32 n = lane_f32(normal[k], i);
            float above = side * dot_f32(sub_f32(p, lane_f32(f->corner[k], i)), n);
            float by = -b->weight[k][i] * above * side;
            sum = madd_f32(sum, above < 0 ? by : 0, n);
        }
        put_f32(b->lift, i, b->smooth[i], sum);
    }
}

static void leave_flat(const facet_block *f, local_block *restrict b) {
    for (unsigned i = 0; i < LANES; ++i) {
        put_f32(b->lift, i, f->facet[i], (vec3_f32){0, 0, 0});
        b->smooth[i] &= ~f->facet[i];
    }
}

static void smoothen(const facet_block *f, const float (*normal)[3][LANES], bool lifted,
                     local_block *restrict b) {
    mix_normals(f, normal, b);
    if (lifted)
        lift(f, normal, b);
    else
        leave_flat(f, b);
}

void KERNEL(facets)(const facet_block *f, bool lifted, local_block *restrict b) {
    float normal[3][3][LANES];
    find_points(f, b);
    for (unsigned i = 0; i < LANES; ++i) put_f32(b->ns, i, f->facet[i], narrow(lane_f64(b->n, i)));
    leave_flat(f, b);
    if (!f->smooth) return;
    if (all_unit(f)) {
        smoothen(f, f->normal, lifted, b);
        return;
    }
    for (int k = 0; k < 3; ++k) make_unit(f->normal[k], normal[k]);
    smoothen(f, normal, lifted, b);
}
