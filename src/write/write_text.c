#include "base/text.h"
#include "write/write.h"

#include <stdio.h>
#include <string.h>

size_t write_integer(char *out, uint64_t value) {
    char digits[20];
    size_t count = 0;
    do digits[count++] = (char)('0' + value % 10);
    while (value /= 10);
    for (size_t i = 0; i < count; ++i) out[i] = digits[count - 1 - i];
    return count;
}

/* Replaces the locale's decimal separator by a dot. */
static size_t print_number(char *out, const char *format, double value) {
    char text[64];
    snprintf(text, sizeof text, format, value);
    size_t length = 0;
    bool dotted = false;
    for (const char *c = text; *c; ++c) {
        if (strchr("+-0123456789e", *c)) {
            out[length++] = *c;
        } else if (!dotted) {
            out[length++] = '.';
            dotted = true;
        }
    }
    return length;
}

size_t write_double(char *out, double value) {
    if (value >= 0 && value < 1e9 && value == (double)(uint64_t)value && !signbit(value))
        return write_integer(out, (uint64_t)value);
    return print_number(out, "%.17g", value);
}

/* digits · 10^last as plain decimals without trailing zeros; 10^8 <= digits < 10^9, -13 <= last <= 0. */
static size_t put_decimals(char *out, uint32_t digits, int last) {
    char text[24];
    int count = 0, written = 0;
    for (; last < 0 && digits % 10 == 0; ++last) digits /= 10;
    for (; last < 0; ++last, digits /= 10) text[count++] = (char)('0' + digits % 10);
    int part = count;
    do text[count++] = (char)('0' + digits % 10);
    while (digits /= 10);
    while (count > part) out[written++] = text[--count];
    if (count) out[written++] = '.';
    while (count) out[written++] = text[--count];
    return (size_t)written;
}

/* Nine significant digits distinguish any two floats. The product with an exact power of ten is off by 2^-53
 * of itself, so the nine digits are off by at most 1/2 + 2^-23 of the last one. Half the distance of
 * neighbouring floats is at least 2.9 of it, so the text reads back as the same float. */
size_t write_float(char *out, float value) {
    static const double powers[] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13};
    double size = fabs((double)value);
    if (size == 0 || !(size >= 1e-5 && size < 1e8)) return print_number(out, "%.9g", (double)value);
    int shift = 13; /* 10^8 <= size 10^shift < 10^9 */
    while (size * powers[shift] >= 1e9) --shift;
    uint32_t digits = (uint32_t)(size * powers[shift] + 0.5);
    size_t sign = value < 0;
    if (sign) *out = '-';
    return sign + put_decimals(out + sign, digits, -shift);
}

void write_put(write_text *t, const char *format, ...) {
    va_list args;
    va_start(args, format);
    char line[512];
    int length = vsnprintf(line, sizeof line, format, args);
    va_end(args);
    if (length < 0 || (size_t)length >= sizeof line || !array_room(&t->bytes, (size_t)length))
        t->failed = true;
    if (t->failed) return;
    memcpy(t->bytes.items + t->bytes.count, line, (size_t)length);
    t->bytes.count += (size_t)length;
}

void write_put_text(write_text *t, const char *text) {
    size_t length = strlen(text);
    if (!array_room(&t->bytes, length)) t->failed = true;
    if (t->failed) return;
    memcpy(t->bytes.items + t->bytes.count, text, length);
    t->bytes.count += length;
}

void write_put_double(write_text *t, double value) {
    if (!array_room(&t->bytes, WRITE_NUMBER_BYTES)) t->failed = true;
    if (!t->failed) t->bytes.count += write_double(t->bytes.items + t->bytes.count, value);
}

void write_put_numbers(write_text *t, const double *numbers, int count) {
    for (int k = 0; k < count; ++k) {
        write_put_text(t, k ? "," : "[");
        write_put_double(t, numbers[k]);
    }
    write_put_text(t, "]");
}

void write_put_key(write_text *t, const char *key) {
    if (t->failed || !t->bytes.count) return;
    write_put(t, "%s\"%s\":", t->bytes.items[t->bytes.count - 1] == '{' ? "" : ",", key);
}

void write_put_json(write_text *t, const char *text) {
    write_put(t, "\"");
    while (*text) {
        unsigned code;
        size_t length = text_character(text, &code);
        if (length == 0)
            write_put(t, "?");
        else if ((unsigned char)*text < 0x20)
            write_put(t, "\\u%04x", (unsigned)*text);
        else
            write_put(t, "%s%.*s", *text == '"' || *text == '\\' ? "\\" : "", (int)length, text);
        text += length ? length : 1;
    }
    write_put(t, "\"");
}

double write_blinn_exponent(const fathom_material *m) {
    switch (m->specular) {
    case FATHOM_SPECULAR_NONE: return 0;
    case FATHOM_SPECULAR_PHONG: return 4 * (double)m->shininess;
    case FATHOM_SPECULAR_BLINN: return (double)m->shininess;
    }
    return 0;
}
