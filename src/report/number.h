/* Numbers for people: three digits, powers of a thousand. */
#ifndef REPORT_NUMBER_H
#define REPORT_NUMBER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* By value, so that it can stand in a call: page_put(p, "%s", number_of(x).text). Never needs escaping. */
typedef struct number {
    char text[48];
} number;

/* "0.0123", "1 230", "3.9×10⁸" as "390×10⁶"; "–" for a NaN. */
number number_of(double x);
/* All digits, in groups of three. */
number number_count(uint64_t n);
/* Whether x is a power of ten. */
bool number_is_power(double x);
/* A number on an axis: a power of ten as "10⁻⁸", others by number_of(). */
number number_tick(double x);
/* Characters, not bytes, of UTF-8: what a text takes in a line of equally wide ones. */
size_t number_width(const char *text);

#endif
