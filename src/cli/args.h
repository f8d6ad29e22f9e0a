/* Options of a command line, described by a table.
 *
 * A command has a plain struct of settings, and a table that gives for each option its field and its help
 * text. Single values are read as fathom/parameter.h describes. */
#pragma once

#include <fathom/parameter.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define ARGS_LIST_MAX 16

/* Values of an option that may be given several times. */
typedef struct args_list {
    const char *items[ARGS_LIST_MAX + 1]; /* NULL after the last */
    size_t count;
} args_list;

/* One or more operands. Release `items` with free(). */
typedef struct args_many {
    const char **items;
    size_t count;
} args_many;

/* Several counts in one option, separated by commas. */
typedef struct args_counts {
    uint64_t items[ARGS_LIST_MAX];
    size_t count;
} args_counts;

typedef struct args_size {
    uint32_t width, height;
} args_size;

/* An optional number. */
typedef struct args_f64 {
    bool given;
    double value;
} args_f64;

typedef struct args_problem {
    char text[512];
} args_problem;

typedef struct args_option args_option;

/* Reads `value` (NULL for a flag) into `field`. False: `problem` says what was expected. */
typedef bool (*args_take)(const args_option *option, const char *value, void *field, args_problem *problem);

/* Without a name: a heading in the help. Without a help text: the end of the table. */
struct args_option {
    const char *name;   /* "spp" for --spp */
    char letter;        /* 'o' for -o; 0: none */
    const char *value;  /* name of the value in the help; NULL: a flag */
    args_take take;     /* reader of the value */
    size_t offset;      /* of the field in the settings */
    double least, most; /* limits of a number, inclusive */
    const char *help;
};

/* A row of a table of options, for macros. */
#define ARGS_ROW(...)                                                                                        \
    { __VA_ARGS__ }

/* The field is a const char *. */
typedef struct args_operand {
    const char *name; /* "SCENE" */
    size_t offset;    /* of the field in the settings */
} args_operand;

#define ARGS_OPERANDS_MAX 2

typedef struct args_spec {
    const args_option *options;               /* NULL: none */
    args_operand operands[ARGS_OPERANDS_MAX]; /* up to the first without a name; all are required, except the
                                                 optional ones */
    size_t operands_optional;                 /* number of optional operands, which come last */
    const args_option *(*table)(void); /* creates the options if they follow from another table; or NULL */
    bool many;                         /* the only operand is an args_many */
} args_spec;

typedef enum args_result { ARGS_READY, ARGS_HELP, ARGS_WRONG } args_result;

/* Skips argv[0]. Accepts --name value, --name=value, -n value, -nvalue, and "--" before operands that begin
 * with a dash. --help or -h before "--" gives ARGS_HELP, even if something else is wrong. The settings point
 * into argv's strings. */
args_result args_parse(const args_spec *spec, int argc, char **argv, void *settings, args_problem *problem);

const args_option *args_options(const args_spec *spec);

/* True if --help or -h is among the arguments, before "--". */
bool args_ask_help(int argc, char **argv);

/* The entry that `wanted` probably means (base/text.h); NULL: none. */
const char *args_nearest(const char *wanted, const char *const *names, size_t count);

/* Always false, for `return args_wrong(…)`. The text follows the option's name: "--spp: " + text. */
bool args_wrong(args_problem *problem, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* ---- readers of values; the field's type is in the name ---- */

bool take_true(const args_option *option, const char *value, void *field, args_problem *problem);
bool take_text(const args_option *option, const char *value, void *field, args_problem *problem);
bool take_list(const args_option *option, const char *value, void *field, args_problem *problem);
/* uint32_t and unsigned, within [least, most]. */
bool take_u32(const args_option *option, const char *value, void *field, args_problem *problem);
/* A uint64_t within [least, most]; k, M and G multiply by a thousand, a million, a thousand million. most:
 * HUGE_VAL for any. */
bool take_u64(const args_option *option, const char *value, void *field, args_problem *problem);
/* Several of these, separated by commas; an args_counts. */
bool take_counts(const args_option *option, const char *value, void *field, args_problem *problem);
/* "1280x720", each within [least, most]; an args_size. */
bool take_size(const args_option *option, const char *value, void *field, args_problem *problem);
bool take_f32(const args_option *option, const char *value, void *field, args_problem *problem);
bool take_given_f64(const args_option *option, const char *value, void *field, args_problem *problem);
bool take_f64(const args_option *option, const char *value, void *field, args_problem *problem);
/* The option's `value` lists the words, as "grid|sobol"; an unsigned or an enum receives the index of the
 * word. */
bool take_choice(const args_option *option, const char *value, void *field, args_problem *problem);
/* Reads a value as a row of a parameter table describes. field: the struct that has the member. */
bool take_parameter(const fathom_parameter *p, const char *value, void *field, args_problem *problem);

#ifdef __cplusplus
}
#endif
