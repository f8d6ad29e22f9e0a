#include "report/number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define THIN "\xe2\x80\xaf" /* narrow no-break space */
#define MINUS "\xe2\x88\x92"
#define TIMES "\xc3\x97"

/* "10" and the exponent above the line. */
static void put_power(char *out, size_t room, int exponent) {
    static const char *const digits[10] = {"\xe2\x81\xb0", "\xc2\xb9",     "\xc2\xb2",     "\xc2\xb3",
                                           "\xe2\x81\xb4", "\xe2\x81\xb5", "\xe2\x81\xb6", "\xe2\x81\xb7",
                                           "\xe2\x81\xb8", "\xe2\x81\xb9"};
    char plain[16], high[40] = "";
    snprintf(plain, sizeof plain, "%d", exponent < 0 ? -exponent : exponent);
    size_t used = 0;
    for (const char *c = plain; *c && used < sizeof high; ++c)
        used += (size_t)snprintf(high + used, sizeof high - used, "%s", digits[*c - '0']);
    snprintf(out, room, "10%s%s", exponent < 0 ? "\xe2\x81\xbb" : "", high);
}

/* Without the zeros behind the point. */
static void put_digits(char *out, size_t room, double x, int after) {
    snprintf(out, room, "%.*f", after < 0 ? 0 : after, x);
    if (!strchr(out, '.')) return;
    size_t length = strlen(out);
    while (out[length - 1] == '0') out[--length] = '\0';
    if (out[length - 1] == '.') out[length - 1] = '\0';
}

number number_count(uint64_t n) {
    number out = {""};
    char plain[24];
    int length = snprintf(plain, sizeof plain, "%llu", (unsigned long long)n);
    char *end = out.text;
    for (int i = 0; i < length; ++i) {
        /* From five digits on: 1234 reads well as it is. */
        if (i > 0 && (length - i) % 3 == 0 && length > 4) {
            memcpy(end, THIN, sizeof THIN - 1);
            end += sizeof THIN - 1;
        }
        *end++ = plain[i];
    }
    *end = '\0';
    return out;
}

/* printf rounds to three digits, and its exponent is right where that of a logarithm is off by one. */
static number positive(double x) {
    number out;
    char text[32], digits[16], power[24];
    snprintf(text, sizeof text, "%.2e", x);
    char *e = strchr(text, 'e');
    *e = '\0';
    double mantissa = strtod(text, NULL);
    int exponent = (int)strtol(e + 1, NULL, 10);
    if (exponent >= -2 && exponent < 4) {
        put_digits(out.text, sizeof out.text, mantissa * pow(10, exponent), 2 - exponent);
        return out;
    }
    int above = (exponent % 3 + 3) % 3;
    put_digits(digits, sizeof digits, mantissa * pow(10, above), 2 - above);
    put_power(power, sizeof power, exponent - above);
    snprintf(out.text, sizeof out.text, "%s" TIMES "%s", digits, power);
    return out;
}

number number_of(double x) {
    if (isnan(x)) return (number){"\xe2\x80\x93"};
    if (x == 0) return (number){"0"};
    if (isinf(x)) return x > 0 ? (number){"\xe2\x88\x9e"} : (number){MINUS "\xe2\x88\x9e"};
    number size = positive(fabs(x)), out;
    if (x > 0) return size;
    snprintf(out.text, sizeof out.text, MINUS "%.40s", size.text);
    return out;
}

bool number_is_power(double x) {
    return x > 0 && isfinite(x) && fabs(x / pow(10, round(log10(x))) - 1) < 1e-9;
}

number number_tick(double x) {
    number out;
    if (!number_is_power(x) || (x > 0.002 && x < 500)) return number_of(x);
    put_power(out.text, sizeof out.text, (int)round(log10(x)));
    return out;
}

size_t number_width(const char *text) {
    size_t count = 0;
    for (; *text; ++text) count += ((unsigned char)*text & 0xc0) != 0x80;
    return count;
}
