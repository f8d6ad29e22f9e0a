#include "verify/exact/exact.h"

#include <string.h>

/* ---- integers ---- */

_Static_assert(GMP_NUMB_BITS == 64, "limbs of 64 bits");

void integer_dot(integer *r, const integer a[3], const integer b[3]) {
    integer_init(r);
    integer product;
    integer_init(&product);
    for (int i = 0; i < 3; ++i) {
        mpz_mul(product.z, a[i].z, b[i].z);
        mpz_add(r->z, r->z, product.z);
    }
}

void integer_cross(integer r[3], const integer a[3], const integer b[3]) {
    integer product;
    integer_init(&product);
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        integer_init(&r[i]);
        mpz_mul(r[i].z, a[j].z, b[k].z);
        mpz_mul(product.z, a[k].z, b[j].z);
        mpz_sub(r[i].z, r[i].z, product.z);
    }
}

/* The upper three limbs hold at least 129 bits. Dropping the others changes less than 2^-128, and the two
 * sums round by 2^-113 each. Scaling by powers of two is exact. */
real_f128 integer_real(const integer *a) {
    int n = (int)mpz_size(a->z), low = n > 3 ? n - 3 : 0;
    real_f128 value = 0;
    for (int i = n - 1; i >= low; --i) value = value * (real_f128)0x1p64 + (real_f128)mpz_getlimbn(a->z, i);
    for (int i = 0; i < low; ++i) value *= (real_f128)0x1p64;
    return mpz_sgn(a->z) < 0 ? -value : value;
}

/* Reads the bits, so the thread's denormal mode does not matter. */
dyadic dyadic_of(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    int e = (int)(bits >> 23 & 0xff);
    int64_t m = bits & 0x7fffff;
    if (e) m |= 0x800000;
    if (m == 0) return (dyadic){0, 0};
    int zeros = __builtin_ctzll((unsigned long long)m);
    return (dyadic){bits >> 31 ? -(m >> zeros) : m >> zeros, (e ? e : 1) - 150 + zeros};
}

/* ---- roots ---- */

/* *r = *r 2^bits */
static void scale(exact_root *r, int bits) {
    if (bits < 0) {
        mpz_mul_2exp(r->q.z, r->q.z, (mp_bitcnt_t)-bits);
        return;
    }
    mpz_mul_2exp(r->p.z, r->p.z, (mp_bitcnt_t)bits);
    if (r->s) mpz_mul_2exp(r->d.z, r->d.z, 2 * (mp_bitcnt_t)bits);
}

void exact_root_set(exact_root *r, const integer *p, int s, const integer *d, const integer *q, int bits) {
    integer_init(&r->p), integer_init(&r->d), integer_init(&r->q);
    mpz_set(r->p.z, p->z), mpz_set(r->q.z, q->z);
    if (s) mpz_set(r->d.z, d->z);
    r->s = s;
    scale(r, bits);
}

/* (p + s √d) / q - m 2^e. For e < 0 numerator and denominator are scaled first. */
void exact_root_subtract(exact_root *r, dyadic x) {
    integer m, product;
    if (x.m == 0) return;
    if (x.e < 0) scale(r, -x.e);
    integer_init(&m), integer_init(&product);
    mpz_set_si(m.z, x.m);
    if (x.e > 0) mpz_mul_2exp(m.z, m.z, (mp_bitcnt_t)x.e);
    mpz_mul(product.z, m.z, r->q.z);
    mpz_sub(r->p.z, r->p.z, product.z);
    if (x.e < 0) scale(r, x.e);
}

/* The sign of a + s √d. */
static int sign_of_sum(const integer *a, int s, const integer *d) {
    int sa = mpz_sgn(a->z), sd = s * mpz_sgn(d->z);
    if (sa * sd >= 0) return sa ? sa : sd;
    integer square;
    integer_init(&square);
    mpz_mul(square.z, a->z, a->z);
    int order = mpz_cmp(square.z, d->z);
    return sa * ((order > 0) - (order < 0));
}

/* The sign of a + s √e + r √f. Let X = a + s √e. If r √f has the same sign as X, it is that sign. Else
 * compare X² with f, which means a² + e - f + 2 a s √e with 0. */
static int sign_of_sums(const integer *a, int s, const integer *e, int r, const integer *f) {
    int sx = s ? sign_of_sum(a, s, e) : mpz_sgn(a->z), sf = r * mpz_sgn(f->z);
    if (sx * sf >= 0) return sx ? sx : sf;
    integer g, h, square;
    integer_init(&g), integer_init(&h), integer_init(&square);
    mpz_mul(square.z, a->z, a->z);
    mpz_sub(g.z, square.z, f->z);
    if (!s) return sx * mpz_sgn(g.z);
    mpz_add(g.z, g.z, e->z);
    mpz_mul(h.z, square.z, e->z);
    mpz_mul_2exp(h.z, h.z, 2);
    return sx * sign_of_sum(&g, s * mpz_sgn(a->z), &h);
}

static void square_times(integer *out, const integer *q, const integer *d) {
    integer square;
    integer_init(&square);
    mpz_mul(square.z, q->z, q->z);
    mpz_mul(out->z, square.z, d->z);
}

/* The sign of x - y, times the product of both q: p1 q2 - p2 q1 + s1 √(q2² d1) - s2 √(q1² d2). After an
 * instance's transform and scaling, p and q have at most 1720 bits and d 3440. The square of the first term
 * then has 6,900 bits, and the square of that 13,800. */
int exact_root_compare(const exact_root *x, const exact_root *y) {
    integer a, b, e, f;
    integer_init(&a), integer_init(&b), integer_init(&e), integer_init(&f);
    mpz_mul(a.z, x->p.z, y->q.z);
    mpz_mul(b.z, y->p.z, x->q.z);
    mpz_sub(a.z, a.z, b.z);
    if (x->s) square_times(&e, &y->q, &x->d);
    if (y->s) square_times(&f, &x->q, &y->d);
    return sign_of_sums(&a, x->s, &e, -y->s, &f);
}

/* If p and s √d have opposite signs, uses p + s √d = (p² - d) / (p - s √d), which has no cancellation. */
real_f128 exact_root_real(const exact_root *r) {
    const real_f128 p = integer_real(&r->p), q = integer_real(&r->q);
    if (!r->s) return p / q;
    const real_f128 root = r->s * sqrt_f128(integer_real(&r->d));
    if (mpz_sgn(r->p.z) * r->s >= 0) return (p + root) / q;
    integer n;
    integer_init(&n);
    mpz_mul(n.z, r->p.z, r->p.z);
    mpz_sub(n.z, n.z, r->d.z);
    return integer_real(&n) / (q * (p - root));
}
