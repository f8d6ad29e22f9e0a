/* Readers of option values. A number must extend to the last character: "12x", "1e999", "0x10" and "" are
 * errors. */
#include "cli/args.h"

#include "base/parameter.h"

#include <string.h>

bool take_parameter(const fathom_parameter *p, const char *value, void *field, args_problem *problem) {
    char wrong[PARAMETER_WRONG];
    return parameter_read(p, value, field, wrong) || args_wrong(problem, "%s", wrong);
}

static bool take_as(fathom_parameter_type type, const args_option *option, const char *value, void *field,
                    args_problem *problem) {
    const fathom_parameter p = {.type = type,
                                .low = option->least,
                                .high = option->most,
                                .unit = option->value,
                                .words = type == FATHOM_PARAMETER_WORD ? option->value : NULL};
    return take_parameter(&p, value, field, problem);
}

#define TAKE(name, type)                                                                                     \
    bool name(const args_option *option, const char *value, void *field, args_problem *problem) {            \
        return take_as(type, option, value, field, problem);                                                 \
    }
TAKE(take_text, FATHOM_PARAMETER_TEXT)
TAKE(take_u32, FATHOM_PARAMETER_U32)
TAKE(take_u64, FATHOM_PARAMETER_U64)
TAKE(take_f32, FATHOM_PARAMETER_F32)
TAKE(take_f64, FATHOM_PARAMETER_F64)
TAKE(take_choice, FATHOM_PARAMETER_WORD)

bool take_true(const args_option *option, const char *value, void *field, args_problem *problem) {
    (void)option, (void)value, (void)problem;
    *(bool *)field = true;
    return true;
}

bool take_list(const args_option *option, const char *value, void *field, args_problem *problem) {
    args_list *list = field;
    if (!*value) return args_wrong(problem, "expected %s, found nothing", option->value);
    if (list->count == ARGS_LIST_MAX) return args_wrong(problem, "given more than %d times", ARGS_LIST_MAX);
    list->items[list->count++] = value;
    return true;
}

bool take_counts(const args_option *option, const char *value, void *field, args_problem *problem) {
    args_counts counts = {.count = 0};
    for (const char *at = value;; ++at) {
        char one[64];
        size_t length = strcspn(at, ",");
        if (counts.count == ARGS_LIST_MAX)
            return args_wrong(problem, "expected at most %d numbers, found more", ARGS_LIST_MAX);
        if (length >= sizeof one) length = sizeof one - 1; /* longer than any valid number */
        memcpy(one, at, length);
        one[length] = '\0';
        if (!take_u64(option, one, &counts.items[counts.count++], problem)) return false;
        at += strcspn(at, ",");
        if (!*at) break;
    }
    *(args_counts *)field = counts;
    return true;
}

bool take_size(const args_option *option, const char *value, void *field, args_problem *problem) {
    uint64_t width, height;
    const char *text = value;
    bool fine = text_read_u64(&text, 'x', &width) && text_read_u64(&text, '\0', &height);
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

bool take_given_f64(const args_option *option, const char *value, void *field, args_problem *problem) {
    args_f64 *number = field;
    number->given = true;
    return take_f64(option, value, &number->value, problem);
}
