#include "read/mesh/number.h"

#include "base/text.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

unsigned number_significant(const char *text, const char *end) {
    const char *first = text;
    while (first < end && (*first == '0' || *first == '.')) ++first;
    unsigned count = 0;
    for (const char *p = first; p < end; ++p) count += *p != '.';
    return count;
}

bool number_read_special(const char **cursor, double *out) {
    const char *p = *cursor;
    bool negative = *p == '-';
    p += *p == '-' || *p == '+';
    double value;
    if (strncasecmp(p, "infinity", 8) == 0)
        value = (double)INFINITY, p += 8;
    else if (strncasecmp(p, "inf", 3) == 0)
        value = (double)INFINITY, p += 3;
    else if (strncasecmp(p, "nan", 3) == 0)
        value = (double)NAN, p += 3;
    else
        return false;
    *out = negative ? -value : value;
    *cursor = p;
    return true;
}

bool number_is_odd(const char *text) {
    if (*text == '-' || *text == '+') ++text;
    return strncasecmp(text, "nan", 3) == 0 || strncasecmp(text, "inf", 3) == 0 ||
           strncmp(text, "1.#", 3) == 0;
}

static double by_library(const char *text) {
    const locale_t own = text_locale_begin();
    const double value = strtod(text, NULL);
    text_locale_end(own);
    return value;
}

/* 10^n = 5^n 2^n, and 5^27 < 2^63: the product of 64-bit digits with 5^n is exact in 128 bits, and a quotient
 * by 5^n with its remainder determines the rounding. Converting a 128-bit integer to double rounds to nearest
 * even, and the remaining power of two is exact because 10^±46 is far from the ends of double's range. */
double number_rounded(uint64_t digits, unsigned significant, int64_t exponent, const char *text) {
    if (significant > 19 || exponent < -27 || exponent > 27) return by_library(text);
    if (!digits) return 0;
    uint64_t five = 1;
    for (int64_t i = exponent < 0 ? -exponent : exponent; i > 0; --i) five *= 5;
    if (exponent >= 0) return ldexp((double)((unsigned __int128)digits * five), (int)exponent);
    int zeros = __builtin_clzll(digits);
    unsigned __int128 dividend = (unsigned __int128)(digits << zeros) << 64;
    /* The dividend's top bit is set, so the quotient has at least 64 bits; the remainder becomes a sticky
     * bit. */
    unsigned __int128 quotient = dividend / five | (dividend % five != 0);
    return ldexp((double)quotient, (int)exponent - 64 - zeros);
}
