/* Readers of option values. Numbers are checked to the last character: "12x", "1e999", "0x10" and "" are
 * errors. */
#include "cli/args.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

bool args_read_u64(const char **text, char end, uint64_t *out) {
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

/* strtod() follows the locale; the program never sets one, so the point is a point. What strtod() takes
 * beyond decimal numbers (spaces, hexadecimal, "nan") is turned away by the spelling. */
bool args_read_f64(const char **text, char end, double *out) {
    size_t length = strspn(*text, "+-.0123456789eE");
    if (length == 0 || (*text)[length] != end) return false;
    char *stop;
    errno = 0;
    double number = strtod(*text, &stop);
    if (stop != *text + length || !isfinite(number)) return false;
    *out = number;
    *text = end ? stop + 1 : stop;
    return true;
}

bool take_true(const args_option *option, const char *value, void *field, args_problem *problem) {
    (void)option, (void)value, (void)problem;
    *(bool *)field = true;
    return true;
}

bool take_false(const args_option *option, const char *value, void *field, args_problem *problem) {
    (void)option, (void)value, (void)problem;
    *(bool *)field = false;
    return true;
}

bool take_text(const args_option *option, const char *value, void *field, args_problem *problem) {
    if (!*value) return args_wrong(problem, "expected %s, found nothing", option->value);
    memcpy(field, &value, sizeof value);
    return true;
}

bool take_list(const args_option *option, const char *value, void *field, args_problem *problem) {
    args_list *list = field;
    if (!*value) return args_wrong(problem, "expected %s, found nothing", option->value);
    if (list->count == ARGS_LIST_MAX) return args_wrong(problem, "given more than %d times", ARGS_LIST_MAX);
    list->items[list->count++] = value;
    return true;
}

bool take_u32(const args_option *option, const char *value, void *field, args_problem *problem) {
    uint64_t number;
    const char *text = value;
    if (!args_read_u64(&text, '\0', &number) || number < (uint64_t)option->least ||
        number > (uint64_t)option->most) {
        return args_wrong(problem, "expected a whole number from %.0f to %.0f, found \"%.60s\"",
                          option->least, option->most, value);
    }
    *(uint32_t *)field = (uint32_t)number;
    return true;
}

bool take_u64(const args_option *option, const char *value, void *field, args_problem *problem) {
    (void)option;
    const char *text = value;
    if (args_read_u64(&text, '\0', field)) return true;
    return args_wrong(problem, "expected a whole number from 0 to 2^64 - 1, found \"%.60s\"", value);
}

/* "1e9": a whole number of decimal places. Zero never gets too large, however many they are. */
static bool read_power(const char *text, uint64_t *out) {
    uint64_t places;
    if (!args_read_u64(&text, 'e', out) || !args_read_u64(&text, '\0', &places) || *text) return false;
    for (; places > 0 && *out > 0; --places) {
        if (*out > UINT64_MAX / 10) return false;
        *out *= 10;
    }
    return true;
}

static bool is_between(const args_option *option, uint64_t number) {
    return number >= (uint64_t)option->least && number <= (uint64_t)option->most;
}

bool take_count(const args_option *option, const char *value, void *field, args_problem *problem) {
    static const struct {
        char suffix;
        uint64_t factor;
    } units[] = {{'\0', 1}, {'k', 1000}, {'M', 1000000}, {'G', 1000000000}};
    for (size_t i = 0; i < sizeof units / sizeof *units; ++i) {
        uint64_t number;
        const char *text = value;
        if (!args_read_u64(&text, units[i].suffix, &number) || *text) continue;
        if (number > UINT64_MAX / units[i].factor) break;
        number *= units[i].factor;
        if (!is_between(option, number)) break;
        *(uint64_t *)field = number;
        return true;
    }
    uint64_t number;
    if (read_power(value, &number) && is_between(option, number)) {
        *(uint64_t *)field = number;
        return true;
    }
    return args_wrong(problem,
                      "expected a whole number from %.0f to %.0f (also 20k, 8M, 1e9), found \"%.60s\"",
                      option->least, option->most, value);
}

bool take_counts(const args_option *option, const char *value, void *field, args_problem *problem) {
    args_counts counts = {.count = 0};
    for (const char *at = value;; ++at) {
        char one[64];
        size_t length = strcspn(at, ",");
        if (counts.count == ARGS_LIST_MAX)
            return args_wrong(problem, "expected at most %d numbers, found more", ARGS_LIST_MAX);
        if (length >= sizeof one) length = sizeof one - 1; /* too long for any number that is taken */
        memcpy(one, at, length);
        one[length] = '\0';
        if (!take_count(option, one, &counts.items[counts.count++], problem)) return false;
        at += strcspn(at, ",");
        if (!*at) break;
    }
    *(args_counts *)field = counts;
    return true;
}

bool take_size(const args_option *option, const char *value, void *field, args_problem *problem) {
    uint64_t width, height;
    const char *text = value;
    bool fine = args_read_u64(&text, 'x', &width) && args_read_u64(&text, '\0', &height);
    double least = option->least, most = option->most;
    if (!fine || (double)width < least || (double)width > most || (double)height < least ||
        (double)height > most) {
        return args_wrong(problem,
                          "expected WIDTHxHEIGHT, each from %.0f to %.0f, such as 1280x720, found \"%.60s\"",
                          least, most, value);
    }
    *(args_size *)field = (args_size){(uint32_t)width, (uint32_t)height};
    return true;
}

bool take_f64(const args_option *option, const char *value, void *field, args_problem *problem) {
    double number;
    const char *text = value;
    if (args_read_f64(&text, '\0', &number) && number >= option->least && number <= option->most) {
        *(double *)field = number;
        return true;
    }
    return args_wrong(problem, "expected a number from %g to %g, found \"%.60s\"", option->least,
                      option->most, value);
}

bool take_f32(const args_option *option, const char *value, void *field, args_problem *problem) {
    double number = 0;
    if (!take_f64(option, value, &number, problem)) return false;
    *(float *)field = (float)number;
    return true;
}

bool take_choice(const args_option *option, const char *value, void *field, args_problem *problem) {
    size_t length = strlen(value);
    unsigned place = 0;
    for (const char *word = option->value;; ++place) {
        size_t end = strcspn(word, "|");
        if (end == length && strncmp(word, value, length) == 0) {
            *(unsigned *)field = place;
            return true;
        }
        if (!word[end]) break;
        word += end + 1;
    }
    return args_wrong(problem, "expected %s, found \"%.60s\"", option->value, value);
}
