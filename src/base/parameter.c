#include "base/parameter.h"

#include "base/status.h"
#include "base/text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* ---- names ---- */

const fathom_parameter *parameter_find(parameter_table table, const char *name) {
    for (size_t i = 0; i < table.count; ++i)
        if (strcmp(table.rows[i].name, name) == 0) return &table.rows[i];
    return NULL;
}

void parameter_name(const fathom_parameter *p, char between, char out[PARAMETER_NAME]) {
    size_t used = 0;
    for (const char *c = p->name; *c && used + 2 < PARAMETER_NAME; ++c) {
        if (*c != '_') {
            out[used++] = *c;
        } else if (c[1] && c[2] && c[2] != '_') {
            ++c;
            if (between) out[used++] = between;
            out[used++] = between ? *c : (char)(*c - 'a' + 'A');
        }
    }
    out[used] = '\0';
}

/* ---- values ---- */

unsigned parameter_count(const fathom_parameter *p) { return p->count ? p->count : 1; }

static size_t item_size(const fathom_parameter *p) {
    switch (p->type) {
    case FATHOM_PARAMETER_BOOL: return sizeof(bool);
    case FATHOM_PARAMETER_U32:
    case FATHOM_PARAMETER_F32:
    case FATHOM_PARAMETER_WORD:
    case FATHOM_PARAMETER_WORDS: return 4;
    case FATHOM_PARAMETER_U64:
    case FATHOM_PARAMETER_F64: return 8;
    case FATHOM_PARAMETER_TEXT: return sizeof(char *);
    }
    return 0;
}

void parameter_copy(const fathom_parameter *p, const void *from, void *to) {
    memcpy((char *)to + p->offset, (const char *)from + p->offset, parameter_count(p) * item_size(p));
}

double parameter_number(const fathom_parameter *p, const void *base, unsigned i) {
    const void *member = (const char *)base + p->offset;
    switch (p->type) {
    case FATHOM_PARAMETER_BOOL: return ((const bool *)member)[i];
    case FATHOM_PARAMETER_U32:
    case FATHOM_PARAMETER_WORD:
    case FATHOM_PARAMETER_WORDS: return ((const uint32_t *)member)[i];
    case FATHOM_PARAMETER_U64: return (double)((const uint64_t *)member)[i];
    case FATHOM_PARAMETER_F32: return (double)((const float *)member)[i];
    case FATHOM_PARAMETER_F64: return ((const double *)member)[i];
    case FATHOM_PARAMETER_TEXT: break;
    }
    return 0;
}

void parameter_set_number(const fathom_parameter *p, void *base, unsigned i, double number) {
    void *member = (char *)base + p->offset;
    switch (p->type) {
    case FATHOM_PARAMETER_BOOL: ((bool *)member)[i] = number != 0; break;
    case FATHOM_PARAMETER_U32:
    case FATHOM_PARAMETER_WORD:
    case FATHOM_PARAMETER_WORDS: ((uint32_t *)member)[i] = (uint32_t)number; break;
    case FATHOM_PARAMETER_U64: ((uint64_t *)member)[i] = (uint64_t)number; break;
    case FATHOM_PARAMETER_F32: ((float *)member)[i] = (float)number; break;
    case FATHOM_PARAMETER_F64: ((double *)member)[i] = number; break;
    case FATHOM_PARAMETER_TEXT: *(const char **)member = NULL; break;
    }
}

static bool is_number(const fathom_parameter *p) {
    return p->type >= FATHOM_PARAMETER_U32 && p->type <= FATHOM_PARAMETER_F64;
}

void parameters_default(parameter_table table, void *base) {
    for (size_t i = 0; i < table.count; ++i) {
        const fathom_parameter *p = &table.rows[i];
        for (unsigned k = 0; k < parameter_count(p); ++k) parameter_set_number(p, base, k, p->fallback);
    }
}

/* ---- allowed values ---- */

static bool is_whole(const fathom_parameter *p) {
    return p->type == FATHOM_PARAMETER_U32 || p->type == FATHOM_PARAMETER_U64;
}

static bool in_range(const fathom_parameter *p, double x) {
    if (p->zero && x == 0) return true;
    if (p->flags & FATHOM_PARAMETER_SOFT) return isfinite(x) && (p->low < 0 || (p->low > 0 ? x > 0 : x >= 0));
    if (p->flags & FATHOM_PARAMETER_OPEN_LOW ? !(x > p->low) : !(x >= p->low)) return false;
    if (p->flags & FATHOM_PARAMETER_OPEN_HIGH ? !(x < p->high) : !(x <= p->high)) return false;
    return is_whole(p) || isfinite(x);
}

static bool allowed(const fathom_parameter *p, double x) {
    char text[32];
    if (p->words) {
        snprintf(text, sizeof text, "%.0f", x);
        return words_find(p->words, text, strlen(text)) >= 0;
    }
    return in_range(p, x) && (!p->step || fmod(x, p->step) == 0);
}

static void describe_number(const fathom_parameter *p, char *out, size_t room) {
    const bool soft = p->flags & FATHOM_PARAMETER_SOFT;
    const char *low = p->flags & FATHOM_PARAMETER_OPEN_LOW || (soft && p->low > 0) ? "above" : "from";
    if (p->words)
        snprintf(out, room, "%s", p->words);
    else if (is_whole(p) && isinf(p->high))
        snprintf(out, room, "a whole number from %.0f to 2^64 - 1", p->low);
    else if (is_whole(p))
        snprintf(out, room, "a whole number from %.0f to %.0f%s", p->low, p->high,
                 p->type == FATHOM_PARAMETER_U64 ? " (also 20k, 8M, 4G, 1e9)" : "");
    else if (soft && p->low < 0)
        snprintf(out, room, "a finite number");
    else if (soft || isinf(p->high))
        snprintf(out, room, *low == 'f' ? "a number >= %g" : "a number above %g", soft ? 0 : p->low);
    else
        snprintf(out, room, "a number %s %g %s %g", low, p->low,
                 p->flags & FATHOM_PARAMETER_OPEN_HIGH ? "to less than" : "to", p->high);
    const size_t used = strlen(out);
    if (p->step) snprintf(out + used, room - used, ", a multiple of %u", p->step);
}

/* Describes the allowed values, as in "auto or a number above 0". zero: what stands for 0 if it has a word.
 */
static void describe(const fathom_parameter *p, const char *zero, char *out, size_t room) {
    char number[96], list[128] = "";
    switch (p->type) {
    case FATHOM_PARAMETER_BOOL: snprintf(out, room, "true or false"); return;
    case FATHOM_PARAMETER_WORD: snprintf(out, room, "%s", p->words); return;
    case FATHOM_PARAMETER_TEXT: snprintf(out, room, "%s", p->unit); return;
    case FATHOM_PARAMETER_WORDS:
        for (size_t i = 0; i < strlen(p->words); ++i) list[i] = p->words[i] == '|' ? ',' : p->words[i];
        snprintf(out, room, "names from %s, or all%s", list,
                 p->flags & FATHOM_PARAMETER_OPEN_LOW ? "" : ", or none");
        return;
    case FATHOM_PARAMETER_U32:
    case FATHOM_PARAMETER_U64:
    case FATHOM_PARAMETER_F32:
    case FATHOM_PARAMETER_F64: break;
    }
    describe_number(p, number, sizeof number);
    if (p->count)
        snprintf(out, room, "%s, each %s", p->unit, number);
    else
        snprintf(out, room, "%s%s%s", p->zero ? zero : "", p->zero ? " or " : "", number);
}

/* True if the value of an enum or a bit set has words. If not, the calling program is wrong, not a file. */
static bool is_worded(const fathom_parameter *p, unsigned value) {
    unsigned count = 0;
    size_t length;
    while (words_at(p->words, count, &length)) ++count;
    return p->type == FATHOM_PARAMETER_WORD ? value < count : !(value >> count);
}

static fathom_status check(fathom_context *context, const fathom_parameter *p, const void *base) {
    char name[PARAMETER_NAME], expected[PARAMETER_TEXT];
    const bool words = p->type == FATHOM_PARAMETER_WORD || p->type == FATHOM_PARAMETER_WORDS;
    if (!words && !is_number(p)) return FATHOM_OK;
    for (unsigned i = 0; i < parameter_count(p); ++i) {
        const double x = parameter_number(p, base, i);
        if (words ? is_worded(p, (unsigned)x) : allowed(p, x)) continue;
        parameter_name(p, ' ', name);
        describe(p, "0", expected, sizeof expected);
        return fail_field(context, words ? FATHOM_BAD_USAGE : FATHOM_BAD_INPUT, name,
                          "expected %s, found %.9g", expected, x);
    }
    return FATHOM_OK;
}

fathom_status parameters_check(fathom_context *context, parameter_table table, const void *base) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < table.count && status == FATHOM_OK; ++i)
        status = check(context, &table.rows[i], base);
    return status;
}

/* ---- from text ---- */

bool text_read_u64(const char **text, char end, uint64_t *out) {
    const char *c = *text;
    uint64_t number = 0;
    if (*c < '0' || *c > '9') return false;
    for (; *c >= '0' && *c <= '9'; ++c) {
        uint64_t digit = (uint64_t)(*c - '0');
        if (number > (UINT64_MAX - digit) / 10) return false;
        number = number * 10 + digit;
    }
    if (*c != end) return false;
    *out = number;
    *text = end ? c + 1 : c;
    return true;
}

/* Reads a finite decimal number. strtod() alone would accept spaces, hexadecimal and "nan" too. */
static bool text_read_f64(const char **text, char end, double *out) {
    size_t length = strspn(*text, "+-.0123456789eE");
    if (length == 0 || (*text)[length] != end) return false;
    char *stop;
    const locale_t own = text_locale_begin();
    double number = strtod(*text, &stop);
    text_locale_end(own);
    if (stop != *text + length || !isfinite(number)) return false;
    *out = number;
    *text = end ? stop + 1 : stop;
    return true;
}

/* Reads "1e9": an integer with a decimal exponent, itself an integer. 0 does not overflow with any
 * exponent. */
static bool read_power(const char *text, uint64_t *out) {
    uint64_t places;
    if (!text_read_u64(&text, 'e', out) || !text_read_u64(&text, '\0', &places) || *text) return false;
    for (; places > 0 && *out > 0; --places) {
        if (*out > UINT64_MAX / 10) return false;
        *out *= 10;
    }
    return true;
}

/* Reads "20k", "8M" or "1e9". */
static bool read_count(const char *text, uint64_t *out) {
    static const struct {
        char suffix;
        uint64_t factor;
    } units[] = {{'k', 1000}, {'M', 1000000}, {'G', 1000000000}};
    for (size_t i = 0; i < sizeof units / sizeof *units; ++i) {
        const char *at = text;
        if (text_read_u64(&at, units[i].suffix, out) && !*at)
            return !__builtin_mul_overflow(*out, units[i].factor, out);
    }
    return read_power(text, out);
}

/* Reads one number that ends at the character `end`, and moves *text past it. */
static bool read_number(const fathom_parameter *p, const char **text, char end, void *base, unsigned i) {
    uint64_t count;
    double x;
    if (!is_whole(p)) {
        if (!text_read_f64(text, end, &x) || !allowed(p, x)) return false;
        parameter_set_number(p, base, i, x);
        return true;
    }
    if (!text_read_u64(text, end, &count) && (p->type != FATHOM_PARAMETER_U64 || !read_count(*text, &count)))
        return false;
    if (!allowed(p, (double)count)) return false;
    if (p->type == FATHOM_PARAMETER_U64)
        memcpy((char *)base + p->offset + i * sizeof count, &count, sizeof count);
    else
        parameter_set_number(p, base, i, (double)count);
    return true;
}

/* If 0 has a word, the digit 0 is rejected, because it may have been meant as a number. */
static bool read_numbers(const fathom_parameter *p, const char *text, void *base) {
    if (p->zero && strcmp(text, p->zero) == 0) {
        parameter_set_number(p, base, 0, 0);
        return true;
    }
    for (unsigned i = 0; i < parameter_count(p); ++i) {
        const bool last = i + 1 == parameter_count(p);
        if (!read_number(p, &text, last ? '\0' : ',', base, i)) return false;
        if (p->zero && parameter_number(p, base, i) == 0) return false;
    }
    return true;
}

/* Adds the bit of a word, ignoring case; "all" adds all bits, "none" adds none. False: there is no such
 * word. */
static bool add_bits(const fathom_parameter *p, const char *word, size_t length, unsigned *bits) {
    size_t found;
    const char *at;
    for (unsigned i = 0; (at = words_at(p->words, i, &found)); ++i) {
        if (found != length || strncasecmp(at, word, length) != 0) continue;
        *bits |= 1u << i;
        return true;
    }
    const bool all = length == 3 && strncasecmp(word, "all", length) == 0;
    if (all) *bits |= (unsigned)p->high;
    return all || (length == 4 && strncasecmp(word, "none", length) == 0);
}

/* Reads words separated by commas. On failure *text points to the unknown word. */
static bool read_words(const fathom_parameter *p, const char **text, void *base) {
    unsigned bits = 0;
    for (const char *word = *text;; ++word) {
        const size_t length = strcspn(word, ",");
        *text = word;
        if (!add_bits(p, word, length, &bits)) return false;
        word += length;
        if (!*word) break;
    }
    if (!bits && p->flags & FATHOM_PARAMETER_OPEN_LOW) return false;
    parameter_set_number(p, base, 0, bits);
    return true;
}

static bool read_value(const fathom_parameter *p, const char **text, void *base) {
    const size_t length = strlen(*text);
    int word;
    switch (p->type) {
    case FATHOM_PARAMETER_BOOL:
        word = words_find("false|true", *text, length);
        if (word >= 0) parameter_set_number(p, base, 0, word);
        return word >= 0;
    case FATHOM_PARAMETER_WORD:
        word = words_find(p->words, *text, length);
        if (word >= 0) parameter_set_number(p, base, 0, word);
        return word >= 0;
    case FATHOM_PARAMETER_TEXT:
        if (length) memcpy((char *)base + p->offset, text, sizeof *text);
        return length;
    case FATHOM_PARAMETER_WORDS: return read_words(p, text, base);
    case FATHOM_PARAMETER_U32:
    case FATHOM_PARAMETER_U64:
    case FATHOM_PARAMETER_F32:
    case FATHOM_PARAMETER_F64: return read_numbers(p, *text, base);
    }
    return false;
}

bool parameter_read(const fathom_parameter *p, const char *text, void *base, char wrong[PARAMETER_WRONG]) {
    uint64_t before[PARAMETER_COUNT];
    const size_t bytes = parameter_count(p) * item_size(p);
    char expected[PARAMETER_TEXT];
    memcpy(before, (const char *)base + p->offset, bytes);
    if (read_value(p, &text, base)) return true;
    memcpy((char *)base + p->offset, before, bytes);
    describe(p, p->zero, expected, sizeof expected);
    const size_t length = p->type == FATHOM_PARAMETER_WORDS ? strcspn(text, ",") : strlen(text);
    if (p->type == FATHOM_PARAMETER_TEXT)
        snprintf(wrong, PARAMETER_WRONG, "expected %s, found nothing", expected);
    else
        snprintf(wrong, PARAMETER_WRONG, "expected %s, found \"%.*s\"", expected,
                 length < 60 ? (int)length : 60, text);
    return false;
}

/* ---- to text ---- */

/* Prints the fewest digits, at least 6, that read back as the same number. */
static void print_real(const fathom_parameter *p, double x, char out[32]) {
    const locale_t own = text_locale_begin();
    for (int digits = 6; digits <= 17; ++digits) {
        snprintf(out, 32, "%.*g", digits, x);
        const double back = strtod(out, NULL);
        if (p->type == FATHOM_PARAMETER_F32 ? (float)back == (float)x : back == x) break;
    }
    text_locale_end(own);
}

static void print_number(const fathom_parameter *p, double x, char out[32]) {
    if (p->zero && x == 0)
        snprintf(out, 32, "%s", p->zero);
    else if (is_whole(p) && floor(x) == x)
        snprintf(out, 32, "%.0f", x);
    else
        print_real(p, x, out);
}

static size_t print_numbers(const fathom_parameter *p, const double *values, char *out, size_t room) {
    size_t used = 0;
    for (unsigned i = 0; i < parameter_count(p); ++i) {
        char number[32];
        print_number(p, values[i], number);
        used += (size_t)snprintf(out + (used < room ? used : room), used < room ? room - used : 0, "%s%s",
                                 i ? "," : "", number);
    }
    return used;
}

/* Prints the words of the value, separated by commas. */
static size_t print_words(const fathom_parameter *p, unsigned value, char *out, size_t room) {
    size_t used = 0, length;
    const char *word;
    for (unsigned i = 0; (word = words_at(p->words, i, &length)); ++i) {
        if (p->type == FATHOM_PARAMETER_WORD ? i != value : !(value >> i & 1)) continue;
        used += (size_t)snprintf(out + (used < room ? used : room), used < room ? room - used : 0, "%s%.*s",
                                 used ? "," : "", (int)length, word);
    }
    return used ? used : (size_t)snprintf(out, room, "none");
}

size_t parameter_print(const fathom_parameter *p, const void *base, char *out, size_t room) {
    const void *member = (const char *)base + p->offset;
    const char *const text = p->type == FATHOM_PARAMETER_TEXT ? *(const char *const *)member : NULL;
    double values[PARAMETER_COUNT];
    for (unsigned i = 0; i < parameter_count(p); ++i) values[i] = parameter_number(p, base, i);
    switch (p->type) {
    case FATHOM_PARAMETER_TEXT: return (size_t)snprintf(out, room, "%s", text ? text : "");
    case FATHOM_PARAMETER_BOOL: return (size_t)snprintf(out, room, "%s", values[0] != 0 ? "true" : "false");
    case FATHOM_PARAMETER_WORD:
    case FATHOM_PARAMETER_WORDS: return print_words(p, (unsigned)values[0], out, room);
    case FATHOM_PARAMETER_U64: /* exactly, unless 0: that may have a word */
        if (values[0] == 0) break;
        return (size_t)snprintf(out, room, "%llu", (unsigned long long)*(const uint64_t *)member);
    case FATHOM_PARAMETER_U32:
    case FATHOM_PARAMETER_F32:
    case FATHOM_PARAMETER_F64: break;
    }
    return print_numbers(p, values, out, room);
}
