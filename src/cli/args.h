/* Options of a command line, described by a table.
 *
 * A command has a plain struct of settings and a table that says which option fills which field and what its
 * help is. Single values are read as base/parameter.h says. */
#ifndef CLI_ARGS_H
#define CLI_ARGS_H

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
    const char *items[ARGS_LIST_MAX];
    size_t count;
} args_list;

/* Operands of which there may be any number from one on. Release `items` with free(). */
typedef struct args_many {
    const char **items;
    size_t count;
} args_many;

/* Counts of one option, separated by commas. */
typedef struct args_counts {
    uint64_t items[ARGS_LIST_MAX];
    size_t count;
} args_counts;

typedef struct args_size {
    uint32_t width, height;
} args_size;

/* A number that need not be given. */
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

/* Without a name: a heading in the help. Without a help: the end of the table. */
struct args_option {
    const char *name;   /* "spp" for --spp */
    char letter;        /* 'o' for -o; 0: none */
    const char *value;  /* what the help calls the value; NULL: a flag */
    args_take take;     /* what reads it */
    size_t offset;      /* of the field in the settings */
    double least, most; /* of a number, both included */
    const char *help;
};

typedef struct args_spec {
    const args_option *options;    /* NULL: none */
    const char *const *operands;   /* "SCENE"; all required but the optional */
    const size_t *operand_offsets; /* of their const char * fields */
    size_t operand_count;
    size_t operands_optional;          /* of the last ones */
    const args_option *(*table)(void); /* makes the options, where they follow from another table; or NULL */
    bool many;                         /* the only operand is an args_many */
} args_spec;

typedef enum args_result { ARGS_READY, ARGS_HELP, ARGS_WRONG } args_result;

/* Skips argv[0]. Takes --name value, --name=value, -n value, -nvalue, and "--" before operands that begin
 * with a dash. --help or -h before "--" is ARGS_HELP, even if something else is wrong. The strings stay
 * argv's. */
args_result args_parse(const args_spec *spec, int argc, char **argv, void *settings, args_problem *problem);

const args_option *args_options(const args_spec *spec);

/* --help or -h is among the arguments, before "--". */
bool args_ask_help(int argc, char **argv);

/* The entry that `wanted` was probably meant to be (base/text.h); NULL: none. */
const char *args_nearest(const char *wanted, const char *const *names, size_t count);

/* Always false, for `return args_wrong(…)`. The text follows the option's name: "--spp: " + text. */
bool args_wrong(args_problem *problem, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* ---- readers of values; the field's type is in the name ---- */

bool take_true(const args_option *option, const char *value, void *field, args_problem *problem);
bool take_text(const args_option *option, const char *value, void *field, args_problem *problem);
bool take_list(const args_option *option, const char *value, void *field, args_problem *problem);
/* uint32_t and unsigned, within [least, most]. */
bool take_u32(const args_option *option, const char *value, void *field, args_problem *problem);
/* Any uint64_t. */
bool take_u64(const args_option *option, const char *value, void *field, args_problem *problem);
/* A uint64_t within [least, most]; k, M and G multiply by a thousand, a million, a thousand million. */
bool take_count(const args_option *option, const char *value, void *field, args_problem *problem);
/* The same, several, separated by commas; an args_counts. */
bool take_counts(const args_option *option, const char *value, void *field, args_problem *problem);
/* "1280x720", each within [least, most]; an args_size. */
bool take_size(const args_option *option, const char *value, void *field, args_problem *problem);
bool take_f32(const args_option *option, const char *value, void *field, args_problem *problem);
bool take_given_f64(const args_option *option, const char *value, void *field, args_problem *problem);
bool take_f64(const args_option *option, const char *value, void *field, args_problem *problem);
/* The option's `value` lists the words, "grid|sobol"; an unsigned or an enum gets the word's place. */
bool take_choice(const args_option *option, const char *value, void *field, args_problem *problem);
/* A value by a row of a table of parameters. field: the struct that has the member. */
bool take_parameter(const fathom_parameter *p, const char *value, void *field, args_problem *problem);

#ifdef __cplusplus
}
#endif

#endif
