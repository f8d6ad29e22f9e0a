#include "verify/exact/exact_root.h"

#include <string.h>

/* By its bits, whatever the thread's mode does with denormals. */
dyadic dyadic_of(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    int e = (int)(bits >> 23 & 0xff);
    int64_t m = bits & 0x7fffff;
    if (e) m |= 0x800000;
    if (m == 0) return (dyadic){0, 0};
    int zeros = __builtin_ctzll((unsigned long long)m);
    dyadic d = {bits >> 31 ? -(m >> zeros) : m >> zeros, (e ? e : 1) - 150 + zeros};
    return d;
}

void exact_root_scale(exact_root *r, int bits) {
    if (bits < 0) {
        integer_shift(&r->q, (unsigned)-bits);
        return;
    }
    integer_shift(&r->p, (unsigned)bits);
    if (r->s) integer_shift(&r->d, 2 * (unsigned)bits);
}

/* (p + s √d) / q - m 2^e. For e < 0 numerator and denominator are scaled first. */
void exact_root_subtract(exact_root *r, dyadic x) {
    integer m, product;
    if (x.m == 0) return;
    if (x.e < 0) exact_root_scale(r, -x.e);
    integer_set(&m, x.m, x.e > 0 ? (unsigned)x.e : 0);
    integer_mul(&product, &m, &r->q);
    integer_sub(&r->p, &r->p, &product);
    if (x.e < 0) exact_root_scale(r, x.e);
}

/* The sign of a + s √d. */
static int sign_of_sum(const integer *a, int s, const integer *d) {
    int sa = integer_sign(a), sd = s * integer_sign(d);
    if (sa * sd >= 0) return sa ? sa : sd;
    integer square;
    integer_mul(&square, a, a);
    return sa * integer_compare(&square, d);
}

int exact_root_sign(const exact_root *r) {
    return r->s ? sign_of_sum(&r->p, r->s, &r->d) : integer_sign(&r->p);
}

/* The sign of a + s √e + r √f. With X = a + s √e the first two: if √f pulls the same way, that of X; else X²
 * against f, which is a² + e - f + 2 a s √e against 0. */
static int sign_of_sums(const integer *a, int s, const integer *e, int r, const integer *f) {
    int sx = s ? sign_of_sum(a, s, e) : integer_sign(a), sf = r * integer_sign(f);
    if (sx * sf >= 0) return sx ? sx : sf;
    integer g, square;
    integer_mul(&square, a, a);
    integer_sub(&g, &square, f);
    if (!s) return sx * integer_sign(&g);
    integer_add(&g, &g, e);
    integer h;
    integer_mul(&h, &square, e);
    integer_shift(&h, 2);
    return sx * sign_of_sum(&g, s * integer_sign(a), &h);
}

static void square_times(integer *out, const integer *q, const integer *d) {
    integer square;
    integer_mul(&square, q, q);
    integer_mul(out, &square, d);
}

/* x - y over the product of both q: p1 q2 - p2 q1 + s1 √(q2² d1) - s2 √(q1² d2). After an instance's map, and
 * scaled by exact_root_scale(), p and q have at most 1720 bits and d 3440; the square of the first term then
 * has 6,900, and its square in turn 13,800. */
int exact_root_compare(const exact_root *x, const exact_root *y) {
    integer a, b, e, f;
    integer_mul(&a, &x->p, &y->q);
    integer_mul(&b, &y->p, &x->q);
    integer_sub(&a, &a, &b);
    e.size = f.size = 0;
    if (x->s) square_times(&e, &y->q, &x->d);
    if (y->s) square_times(&f, &x->q, &y->d);
    return sign_of_sums(&a, x->s, &e, -y->s, &f);
}

/* Where p and s √d pull against each other, p + s √d = (p² - d) / (p - s √d), whose parts do not cancel. */
ball exact_root_ball(const exact_root *r) {
    ball p = integer_ball(&r->p), q = integer_ball(&r->q);
    if (!r->s) return ball_div(p, q);
    ball root = ball_sqrt(integer_ball(&r->d));
    if (r->s < 0) root = ball_neg(root);
    if (integer_sign(&r->p) * r->s >= 0) return ball_div(ball_add(p, root), q);
    integer n;
    integer_mul(&n, &r->p, &r->p);
    integer_sub(&n, &n, &r->d);
    return ball_div(integer_ball(&n), ball_mul(q, ball_sub(p, root)));
}
