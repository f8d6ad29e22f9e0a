/* Whether triangles have an area: a quick look that is right where it says so. WIDE_FOURS triangles at once,
 * each vertex four floats of a register, of which the last is of no use. */
#include "scene/kernels/kernel.h"
#include "scene/world/world.h"

FOUR_INLINE four corner(const float *positions, size_t stride, uint32_t index) {
    return four_load((const char *)positions + index * stride);
}

#if WIDE == 4
#define SHUFFLED(v, a, b, c, d) __builtin_shufflevector((v), (v), (a), (b), (c), (d))
#elif WIDE == 8
#define SHUFFLED(v, a, b, c, d)                                                                              \
    __builtin_shufflevector((v), (v), (a), (b), (c), (d), 4 + (a), 4 + (b), 4 + (c), 4 + (d))
#else
#define SHUFFLED(v, a, b, c, d)                                                                              \
    __builtin_shufflevector((v), (v), (a), (b), (c), (d), 4 + (a), 4 + (b), 4 + (c), 4 + (d), 8 + (a),       \
                            8 + (b), 8 + (c), 8 + (d), 12 + (a), 12 + (b), 12 + (c), 12 + (d))
#endif

/* One corner of each of WIDE_FOURS triangles. */
FOUR_INLINE wide corners(const float *positions, size_t stride, const uint32_t *indices) {
#if WIDE == 4
    return corner(positions, stride, indices[0]);
#else
    typedef float eight __attribute__((vector_size(32)));
    eight low = __builtin_shufflevector(corner(positions, stride, indices[0]),
                                        corner(positions, stride, indices[3]), 0, 1, 2, 3, 4, 5, 6, 7);
#if WIDE == 8
    return low;
#else
    eight high = __builtin_shufflevector(corner(positions, stride, indices[6]),
                                         corner(positions, stride, indices[9]), 0, 1, 2, 3, 4, 5, 6, 7);
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
#endif
#endif
}

FOUR_INLINE wide magnitude(wide v) { return (wide)((wide_marks)v & 0x7fffffff); }

/* Magnitudes order as their bits do; a NaN is the largest. */
FOUR_INLINE wide_marks larger(wide_marks bits, wide v) { return wide_larger(bits, (wide_marks)magnitude(v)); }

/* The sign is set where p - q, products of differences of floats, is not zero for sure. With u = 2^-24 the
 * differences are off by up to u of themselves, their products by 3u and p - q by 4u (|p| + |q|) in all; 16u
 * leave room for the sum's own roundings, and 2^-120 for all that denormals lose. Nor are they zero in double
 * then. Nothing within reach overflows. */
FOUR_INLINE wide_marks surely_not_zero(wide p, wide q) {
    return (wide_marks)((magnitude(p) + magnitude(q)) * 0x1p-20f + 0x1p-120f - magnitude(p - q));
}

typedef struct state {
    wide_marks most; /* of the magnitudes, as bits */
    wide_marks fine; /* the sign of each triangle's numbers is set */
} state;

FOUR_INLINE void look(state *s, const float *positions, size_t stride, const uint32_t *t) {
    wide a = corners(positions, stride, t), b = corners(positions, stride, t + 1),
         c = corners(positions, stride, t + 2), ab = b - a, ac = c - a;
    wide_marks n = surely_not_zero(ab * SHUFFLED(ac, 1, 2, 0, 3), SHUFFLED(ab, 1, 2, 0, 3) * ac);
    s->fine &= n | SHUFFLED(n, 1, 2, 0, 3) | SHUFFLED(n, 2, 0, 1, 3);
    s->most = larger(larger(larger(s->most, a), b), c);
}

/* The same triangle as often as a register holds. */
FOUR_INLINE void look_at_one(state *s, const float *positions, size_t stride, const uint32_t *t) {
    uint32_t same[3 * WIDE_FOURS];
    for (int k = 0; k < 3 * WIDE_FOURS; ++k) same[k] = t[k % 3];
    look(s, positions, stride, same);
}

bool KERNEL(areas)(const float *positions, size_t stride, const uint32_t *triangles, size_t count,
                   float *largest) {
    state s = {.most = {0}, .fine = ~(wide_marks){0}};
    size_t i = 0;
    for (; i + WIDE_FOURS <= count; i += WIDE_FOURS) look(&s, positions, stride, triangles + 3 * i);
    for (; i < count; ++i) look_at_one(&s, positions, stride, triangles + 3 * i);
    wide reach = (wide)s.most;
    bool fine = true;
    float most = *largest;
    for (int k = 0; k < WIDE; ++k) {
        if (k % 4 == 3) continue;
        fine &= (s.fine[k] < 0) & (reach[k] < (float)WORLD_REACH);
        most = reach[k] > most ? reach[k] : most;
    }
    if (fine) *largest = most;
    return fine;
}
