#include "verify/exact/integer.h"

#include <stdlib.h>

_Static_assert(GMP_NUMB_BITS == 64, "limbs of 64 bits");

static int limbs(const integer *a) { return abs(a->size); }

static int trimmed(const mp_limb_t *limb, int n) {
    while (n > 0 && limb[n - 1] == 0) --n;
    return n;
}

void integer_set(integer *r, int64_t m, unsigned shift) {
    r->size = m != 0;
    r->limb[0] = m < 0 ? 0 - (mp_limb_t)m : (mp_limb_t)m;
    if (m < 0) r->size = -1;
    integer_shift(r, shift);
}

void integer_copy(integer *r, const integer *a) {
    if (r == a) return;
    r->size = a->size;
    if (a->size) mpn_copyi(r->limb, a->limb, limbs(a));
}

/* |r| = |a| + |b| for limbs(a) >= limbs(b). */
static int add_sizes(integer *r, const integer *a, const integer *b) {
    int n = limbs(a), m = limbs(b);
    if (m == 0) {
        if (n && r != a) mpn_copyi(r->limb, a->limb, n);
        return n;
    }
    mp_limb_t carry = mpn_add(r->limb, a->limb, n, b->limb, m);
    if (carry) r->limb[n++] = carry;
    return n;
}

static int compare_sizes(const integer *a, const integer *b) {
    int n = limbs(a), m = limbs(b);
    if (n != m) return n < m ? -1 : 1;
    return n ? mpn_cmp(a->limb, b->limb, n) : 0;
}

/* a + sign b */
static void add_signed(integer *r, const integer *a, const integer *b, int sign) {
    int sa = integer_sign(a), sb = sign * integer_sign(b);
    if (sa * sb >= 0) {
        bool longer = limbs(a) >= limbs(b);
        int n = longer ? add_sizes(r, a, b) : add_sizes(r, b, a);
        r->size = (sa ? sa : sb) < 0 ? -n : n;
        return;
    }
    int order = compare_sizes(a, b);
    if (order == 0) {
        r->size = 0;
        return;
    }
    const integer *large = order > 0 ? a : b, *small = order > 0 ? b : a;
    int n = limbs(large), s = order > 0 ? sa : sb;
    mpn_sub(r->limb, large->limb, n, small->limb, limbs(small));
    n = trimmed(r->limb, n);
    r->size = s < 0 ? -n : n;
}

void integer_add(integer *r, const integer *a, const integer *b) { add_signed(r, a, b, 1); }
void integer_sub(integer *r, const integer *a, const integer *b) { add_signed(r, a, b, -1); }

void integer_mul(integer *r, const integer *a, const integer *b) {
    const integer *large = limbs(a) >= limbs(b) ? a : b, *small = large == a ? b : a;
    if (small->size == 0) {
        r->size = 0;
        return;
    }
    int n = limbs(large) + limbs(small);
    mpn_mul(r->limb, large->limb, limbs(large), small->limb, limbs(small));
    n = trimmed(r->limb, n);
    r->size = integer_sign(a) * integer_sign(b) < 0 ? -n : n;
}

void integer_shift(integer *r, unsigned bits) {
    int n = limbs(r), whole = (int)(bits / 64);
    if (n == 0 || bits == 0) return;
    mp_limb_t carry = 0;
    if (bits % 64)
        carry = mpn_lshift(r->limb + whole, r->limb, n, bits % 64);
    else
        mpn_copyd(r->limb + whole, r->limb, n);
    if (whole) mpn_zero(r->limb, whole);
    n += whole;
    if (carry) r->limb[n++] = carry;
    r->size = r->size < 0 ? -n : n;
}

int integer_compare(const integer *a, const integer *b) {
    int sa = integer_sign(a), sb = integer_sign(b);
    if (sa != sb) return sa < sb ? -1 : 1;
    int order = compare_sizes(a, b);
    return sa * ((order > 0) - (order < 0));
}

void integer_dot(integer *r, const integer a[3], const integer b[3]) {
    integer product;
    integer_mul(r, &a[0], &b[0]);
    for (int i = 1; i < 3; ++i) {
        integer_mul(&product, &a[i], &b[i]);
        integer_add(r, r, &product);
    }
}

void integer_cross(integer r[3], const integer a[3], const integer b[3]) {
    integer product;
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        integer_mul(&r[i], &a[j], &b[k]);
        integer_mul(&product, &a[k], &b[j]);
        integer_sub(&r[i], &r[i], &product);
    }
}

/* The upper three limbs hold at least 129 bits: dropping the rest changes less than 2^-128, and the two sums
 * round by 2^-113 each. Scaling by powers of two is exact. */
ball integer_ball(const integer *a) {
    int n = limbs(a), low = n > 3 ? n - 3 : 0;
    real_f128 value = 0;
    for (int i = n - 1; i >= low; --i) value = value * (real_f128)0x1p64 + (real_f128)a->limb[i];
    for (int i = 0; i < low; ++i) value *= (real_f128)0x1p64;
    long double error = n > 1 ? (long double)value * 0x1p-111L : 0;
    return (ball){a->size < 0 ? -value : value, error};
}
