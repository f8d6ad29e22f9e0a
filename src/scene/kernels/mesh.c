/* Loops over the arrays of meshes; see kernels.h. The compiler vectorises the loops over indices. The other
 * loops use vector types: `wide` has as many floats as a register of the instruction set. */
#include "scene/kernels.h"

#include "base/kernel.h"
#include "scene/world/world.h"

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#define ALWAYS_INLINE static inline __attribute__((always_inline))

#if defined(__AVX512F__)
#define WIDE 16
#elif defined(__AVX2__)
#define WIDE 8
#else
#define WIDE 4
#endif
#define WIDE_FOURS (WIDE / 4)

typedef float wide __attribute__((vector_size(4 * WIDE)));
typedef int wide_marks __attribute__((vector_size(4 * WIDE))); /* each -1 or 0 */

/* gcc 12 would compile the selection to four instructions; the intrinsics are one instruction. */
ALWAYS_INLINE wide_marks wide_larger(wide_marks a, wide_marks b) {
#if defined(__AVX512F__)
    return (wide_marks)_mm512_max_epi32((__m512i)a, (__m512i)b);
#elif defined(__AVX2__)
    return (wide_marks)_mm256_max_epi32((__m256i)a, (__m256i)b);
#else
    return (a & (a > b)) | (b & ~(a > b));
#endif
}

/* ---- extremes of vectors, and whether all their numbers are finite ---- */

/* Reads WIDE consecutive vectors at a time, number by number. v - v is NaN if v is not finite, else 0. */
static bool packed_vectors(const float *values, size_t count, float lower[3], float upper[3]) {
    float low[3 * WIDE], high[3 * WIDE], odd[3 * WIDE] = {0};
    bool finite = true;
    memcpy(low, values, sizeof low);
    memcpy(high, values, sizeof high);
    for (size_t i = 0; i + WIDE <= count; i += WIDE) {
        const float *v = values + 3 * i;
        for (int k = 0; k < 3 * WIDE; ++k) {
            low[k] = v[k] < low[k] ? v[k] : low[k];
            high[k] = v[k] > high[k] ? v[k] : high[k];
            odd[k] += v[k] - v[k];
        }
    }
    for (int k = 0; k < 3 * WIDE; ++k) {
        lower[k % 3] = low[k] < lower[k % 3] ? low[k] : lower[k % 3];
        upper[k % 3] = high[k] > upper[k % 3] ? high[k] : upper[k % 3];
        finite &= odd[k] == 0;
    }
    return finite;
}

static bool vectors(const float *values, size_t stride, size_t count, float lower[3], float upper[3]) {
    size_t done = 0;
    float odd = 0;
    if (stride == 3 * sizeof(float) && count >= WIDE) {
        if (!packed_vectors(values, count, lower, upper)) return false;
        done = count / WIDE * WIDE;
    }
    for (size_t i = done; i < count; ++i) {
        const float *v = (const float *)(const void *)((const char *)values + i * stride);
        for (int k = 0; k < 3; ++k) {
            lower[k] = v[k] < lower[k] ? v[k] : lower[k];
            upper[k] = v[k] > upper[k] ? v[k] : upper[k];
            odd += v[k] - v[k];
        }
    }
    return odd == 0;
}

/* ---- indices ---- */

static bool indices(const uint32_t *all, size_t count, uint32_t limit) {
    uint32_t highest = 0;
    for (size_t i = 0; i < count; ++i) highest = all[i] > highest ? all[i] : highest;
    return highest < limit || !count;
}

static uint64_t boundary(const uint32_t *triangles, size_t count) {
    uint64_t total = 0;
    for (size_t i = 0; i < 3 * count; i += 3) {
        total += boundary_sum(boundary_of_index(triangles[i]), boundary_of_index(triangles[i + 1]),
                              boundary_of_index(triangles[i + 2]));
    }
    return total;
}

/* ---- whether triangles have an area ----
 * A fast test: true is certain, false is not. It handles WIDE_FOURS triangles at once, each vertex in four
 * floats of a register; the last of the four is not used. */

typedef float four __attribute__((vector_size(16)));

ALWAYS_INLINE four corner(const float *positions, size_t stride, uint32_t index) {
    four v;
    memcpy(&v, (const char *)positions + index * stride, sizeof v);
    return v;
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
ALWAYS_INLINE wide corners(const float *positions, size_t stride, const uint32_t *t) {
#if WIDE == 4
    return corner(positions, stride, t[0]);
#else
    typedef float eight __attribute__((vector_size(32)));
    eight low = __builtin_shufflevector(corner(positions, stride, t[0]), corner(positions, stride, t[3]), 0,
                                        1, 2, 3, 4, 5, 6, 7);
#if WIDE == 8
    return low;
#else
    eight high = __builtin_shufflevector(corner(positions, stride, t[6]), corner(positions, stride, t[9]), 0,
                                         1, 2, 3, 4, 5, 6, 7);
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
#endif
#endif
}

ALWAYS_INLINE wide magnitude(wide v) { return (wide)((wide_marks)v & 0x7fffffff); }

/* Magnitudes have the same order as their bits; a NaN is the largest. */
ALWAYS_INLINE wide_marks larger(wide_marks bits, wide v) {
    return wide_larger(bits, (wide_marks)magnitude(v));
}

/* The sign is set if p - q is certainly not zero; p and q are products of differences of floats. With
 * u = 2^-24, the relative error of the differences is up to u and that of the products up to 3u; the error of
 * p - q is 4u (|p| + |q|) in all. 16u leave room for the rounding errors of the sum, and 2^-120 for the loss
 * of denormals. In double p - q is then not zero either. Nothing within reach overflows. */
ALWAYS_INLINE wide_marks surely_not_zero(wide p, wide q) {
    return (wide_marks)((magnitude(p) + magnitude(q)) * 0x1p-20f + 0x1p-120f - magnitude(p - q));
}

typedef struct state {
    wide_marks most; /* maximum of the magnitudes, as bits */
    wide_marks fine; /* the sign is set for triangles that have an area */
} state;

ALWAYS_INLINE void look(state *s, const float *positions, size_t stride, const uint32_t *t) {
    wide a = corners(positions, stride, t), b = corners(positions, stride, t + 1),
         c = corners(positions, stride, t + 2), ab = b - a, ac = c - a;
    wide_marks n = surely_not_zero(ab * SHUFFLED(ac, 1, 2, 0, 3), SHUFFLED(ab, 1, 2, 0, 3) * ac);
    s->fine &= n | SHUFFLED(n, 1, 2, 0, 3) | SHUFFLED(n, 2, 0, 1, 3);
    s->most = larger(larger(larger(s->most, a), b), c);
}

/* Handles one triangle, repeated to fill the register. */
ALWAYS_INLINE void look_at_one(state *s, const float *positions, size_t stride, const uint32_t *t) {
    uint32_t same[3 * WIDE_FOURS];
    for (int k = 0; k < 3 * WIDE_FOURS; ++k) same[k] = t[k % 3];
    look(s, positions, stride, same);
}

static bool areas(const float *positions, size_t stride, const uint32_t *triangles, size_t count,
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

#define TEXT_OF(isa) #isa
#define TEXT(isa) TEXT_OF(isa)

const scene_kernels KERNEL(scene_kernels) = {
    .name = TEXT(KERNEL_ISA), .vectors = vectors, .indices = indices, .boundary = boundary, .areas = areas};
