/* Decimal numbers from text, the same in every locale, rounded to the nearest double. The text must end in a
 * byte that cannot belong to a number, such as file_map's padding. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

/* digits × 10^exponent, if the fast path of number_read() does not apply. `text`: the number after its sign,
 * for the C library. */
double number_rounded(uint64_t digits, unsigned significant, int64_t exponent, const char *text);

/* Reads "nan", "inf" or "infinity" in upper or lower case; false if the text is none of them. */
bool number_read_special(const char **cursor, double *out);
/* True where a word is what programs print for no number: "nan", "-nan(ind)", "1.#QNAN", "inf". */
bool number_is_odd(const char *text);

static inline unsigned number_digit(char c) { return (unsigned)(unsigned char)c - '0'; }

/* Appends the digits at p to `value`, which wraps around beyond 19 digits. Returns the first other character.
 */
static inline const char *number_digits(const char *p, uint64_t *value) {
    uint64_t v = *value;
    for (unsigned d; (d = number_digit(*p)) < 10; ++p) v = v * 10 + d;
    *value = v;
    return p;
}

/* Reads an exponent such as e+12; an e without digits is not consumed. Large exponents saturate. */
static inline const char *number_exponent(const char *p, int64_t *exponent) {
    const char *digit = p + 1 + (p[1] == '-' || p[1] == '+');
    if (number_digit(*digit) >= 10) return p;
    int64_t value = 0;
    for (unsigned d; (d = number_digit(*digit)) < 10; ++digit) {
        if (value < 1000000) value = value * 10 + d;
    }
    *exponent += p[1] == '-' ? -value : value;
    return digit;
}

/* The number of digits after leading zeros. */
unsigned number_significant(const char *text, const char *end);

/* Reads a number at *cursor and moves past it: sign, digits with an optional point, optional exponent; nan
 * and inf too. False, with the cursor unmoved, if there is no number. Powers of ten up to 10^22 and digits up
 * to 2^53 are exact doubles, so one multiplication or division rounds once (Clinger 1990). number_rounded()
 * handles all others. */
static inline bool number_read(const char **cursor, double *out) {
    static const double tens[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                  1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    const char *p = *cursor;
    bool negative = *p == '-';
    p += *p == '-' || *p == '+';
    const char *start = p;
    uint64_t digits = 0;
    int64_t exponent = 0;
    p = number_digits(p, &digits);
    unsigned count = (unsigned)(p - start);
    if (*p == '.') {
        const char *fraction = ++p;
        p = number_digits(p, &digits);
        exponent = fraction - p;
        count += (unsigned)(p - fraction);
    }
    if (!count) return number_read_special(cursor, out);
    const char *end = p;
    if ((*p | 32) == 'e') p = number_exponent(p, &exponent);
    if (count > 19) count = number_significant(start, end);
    double value;
    if (count <= 19 && digits <= UINT64_C(1) << 53 && exponent >= -22 && exponent <= 22) {
        value = exponent < 0 ? (double)(int64_t)digits / tens[-exponent]
                             : (double)(int64_t)digits * tens[exponent];
    } else {
        value = number_rounded(digits, count, exponent, start);
    }
    *out = negative ? -value : value;
    *cursor = p;
    return true;
}

/* Reads an integer at *cursor; saturates far above any index. False, with the cursor unmoved, if there is no
 * integer. */
static inline bool number_read_integer(const char **cursor, int64_t *out) {
    const char *p = *cursor;
    bool negative = *p == '-';
    p += *p == '-' || *p == '+';
    if (number_digit(*p) >= 10) return false;
    int64_t value = 0;
    for (unsigned d; (d = number_digit(*p)) < 10; ++p) {
        if (value < INT64_MAX / 100) value = value * 10 + d;
    }
    *out = negative ? -value : value;
    *cursor = p;
    return true;
}
