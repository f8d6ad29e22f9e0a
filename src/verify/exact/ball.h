/* Ball arithmetic: quadruple precision that carries a bound on its own error.
 *
 * A ball stands for a real number x with |x - value| <= error. Each operation below is given balls that hold
 * their numbers and returns one that holds the result; so whatever is computed with them is proved step by
 * step, and nothing else needs proving. U = 2^-113 is the unit roundoff of binary128: a sum, product or
 * quotient is within U |result| of the exact one (rounding to nearest; numbers made of floats stay far inside
 * binary128's range: products of twenty of them do, so nothing overflows or becomes denormal).
 *
 * Errors are long doubles, whose range is binary128's. They are sums of at most eight rounded terms, each
 * within 2^-63 of the true term; BALL_PAD makes up for that. */
#ifndef PARITY_BALL_H
#define PARITY_BALL_H

#include "reference/vec_f128.h"

#if LDBL_MAX_EXP < 16384 || LDBL_MANT_DIG < 64
#error "Error bounds need a long double with the range of binary128"
#endif

typedef struct ball {
    real_f128 value;
    long double error; /* 0: exact */
} ball;

typedef struct ball3 {
    ball x, y, z;
} ball3;

#define BALL_UNIT 0x1p-113L
#define BALL_PAD (1 + 0x1p-59L)

static inline long double ball_size(ball a) { return (long double)abs_f128(a.value); }

/* A float or double, exactly. */
static inline ball ball_exact(double x) { return (ball){(real_f128)x, 0}; }

static inline ball ball_neg(ball a) { return (ball){-a.value, a.error}; }

static inline ball ball_add(ball a, ball b) {
    real_f128 r = a.value + b.value;
    if (a.error == 0 && b.error == 0) {
        /* Differences of floats are mostly exact. The difference of the sum and the larger part is exact
         * (Dekker's fast two-sum), so it shows the lost part. */
        bool first = abs_f128(a.value) >= abs_f128(b.value);
        real_f128 large = first ? a.value : b.value, small = first ? b.value : a.value;
        if (r - large == small) return (ball){r, 0};
    }
    ball sum = {r, (a.error + b.error + (long double)abs_f128(r) * BALL_UNIT) * BALL_PAD};
    return sum;
}

static inline ball ball_sub(ball a, ball b) { return ball_add(a, ball_neg(b)); }

static inline ball ball_mul(ball a, ball b) {
    real_f128 r = a.value * b.value;
    long double error = ball_size(a) * b.error + ball_size(b) * a.error + a.error * b.error;
    return (ball){r, (error + (long double)abs_f128(r) * BALL_UNIT) * BALL_PAD};
}

/* Where b may be zero the error is infinite. |a/b - q| = |a - q b| / |b|, for the true a and b and q =
 * value(a) / value(b): at most (error(a) + |q| error(b)) / (|b| - error(b)). */
static inline ball ball_div(ball a, ball b) {
    long double least = ball_size(b) * (1 - 0x1p-60L) - b.error;
    if (!(least > 0)) return (ball){0, HUGE_VALL};
    real_f128 q = a.value / b.value;
    long double size = (long double)abs_f128(q);
    return (ball){q, ((a.error + size * b.error) / least + size * 2 * BALL_UNIT) * BALL_PAD};
}

/* For numbers known to be at least 0. |√x - r| = |x - r²| / (√x + r) <= (error + |value - r²|) / r, and the
 * computed r² is within U r² of r². Where nothing but zero can be told: √x <= √(|value| + error). */
static inline ball ball_sqrt(ball a) {
    if (a.error == 0 && a.value == 0) return a;
    if (!((long double)a.value > 2 * a.error)) {
        return (ball){0, sqrtl((ball_size(a) + a.error) * BALL_PAD) * BALL_PAD};
    }
    real_f128 r = sqrt_f128(a.value), square = r * r;
    long double off =
        a.error + (long double)abs_f128(a.value - square) * (1 + 0x1p-60L) + (long double)square * BALL_UNIT;
    return (ball){r, off / (long double)r * BALL_PAD};
}

/* True when the number is known to 12 digits: then so is its sign, and zero is zero exactly. */
static inline bool ball_known(ball a) { return a.error <= ball_size(a) * 0x1p-40L; }

static inline ball3 ball3_sub(ball3 a, ball3 b) {
    return (ball3){ball_sub(a.x, b.x), ball_sub(a.y, b.y), ball_sub(a.z, b.z)};
}
static inline ball ball3_dot(ball3 a, ball3 b) {
    return ball_add(ball_add(ball_mul(a.x, b.x), ball_mul(a.y, b.y)), ball_mul(a.z, b.z));
}
static inline ball3 ball3_cross(ball3 a, ball3 b) {
    return (ball3){ball_sub(ball_mul(a.y, b.z), ball_mul(a.z, b.y)),
                   ball_sub(ball_mul(a.z, b.x), ball_mul(a.x, b.z)),
                   ball_sub(ball_mul(a.x, b.y), ball_mul(a.y, b.x))};
}
static inline ball3 ball3_exact(vec3_f32 a) {
    return (ball3){ball_exact((double)a.x), ball_exact((double)a.y), ball_exact((double)a.z)};
}

#endif
