#include "cli/args.h"

#include "base/text.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool args_wrong(args_problem *problem, const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(problem->text, sizeof problem->text, format, args);
    va_end(args);
    text_disarm(problem->text);
    return false;
}

const char *args_nearest(const char *wanted, const char *const *names, size_t count) {
    text_search search = text_search_begin(wanted);
    for (size_t i = 0; i < count; ++i) {
        if (names[i]) text_search_offer(&search, names[i]);
    }
    return search.best;
}

const args_option *args_options(const args_spec *spec) { return spec->table ? spec->table() : spec->options; }

typedef struct parser {
    const args_spec *spec;
    int argc, at;
    char **argv;
    char *settings;
    size_t operands;
    args_problem *problem;
} parser;

static bool unknown_option(parser *p, const char *name, size_t length) {
    char wanted[64];
    const char *names[64];
    size_t count = 0;
    snprintf(wanted, sizeof wanted, "%.*s", (int)length, name);
    for (const args_option *o = args_options(p->spec); o && o->help && count < 64; ++o)
        names[count++] = o->name;
    const char *nearest = args_nearest(wanted, names, count);
    if (nearest) return args_wrong(p->problem, "unknown option --%s; did you mean --%s?", wanted, nearest);
    return args_wrong(p->problem, "unknown option --%s", wanted);
}

/* Takes the value from the next argument. If that looks like an option, the value was probably forgotten;
 * --name=value accepts any value. */
static bool next_value(parser *p, const args_option *option, const char *typed, const char **value) {
    const char *next = p->at + 1 < p->argc ? p->argv[p->at + 1] : NULL;
    if (!next || strncmp(next, "--", 2) == 0)
        return args_wrong(p->problem, "%s: expected a value, %s", typed, option->value);
    ++p->at;
    *value = next;
    return true;
}

/* value: NULL if it is not part of `typed`. length: of the option's name in `typed`, which begins messages.
 */
static bool apply(parser *p, const args_option *option, const char *value, const char *typed, size_t length) {
    if (option->value && !value && !next_value(p, option, typed, &value)) return false;
    if (option->take(option, value, p->settings + option->offset, p->problem)) return true;
    const args_problem inner = *p->problem;
    return args_wrong(p->problem, "%.*s: %.460s", (int)length, typed, inner.text);
}

static bool parse_long(parser *p, const char *typed) {
    const char *name = typed + 2, *equals = strchr(name, '=');
    size_t length = equals ? (size_t)(equals - name) : strlen(name);
    for (const args_option *option = args_options(p->spec); option && option->help; ++option) {
        if (!option->name || strlen(option->name) != length || strncmp(option->name, name, length) != 0)
            continue;
        const char *value = equals ? equals + 1 : NULL;
        if (!option->value && value) return args_wrong(p->problem, "--%s takes no value", option->name);
        return apply(p, option, value, typed, length + 2);
    }
    return unknown_option(p, name, length);
}

static bool parse_short(parser *p, const char *typed) {
    for (const args_option *option = args_options(p->spec); option && option->help; ++option) {
        if (!option->letter || option->letter != typed[1]) continue;
        const char *value = typed[2] ? typed + 2 : NULL;
        if (!option->value && value)
            return args_wrong(p->problem, "unknown option %s; -%c takes no value", typed, option->letter);
        return apply(p, option, value, typed, 2);
    }
    return args_wrong(p->problem, "unknown option %.40s", typed);
}

static bool add_operand(parser *p, const char *text) {
    args_many *all = (args_many *)(void *)(p->settings + p->spec->operands[0].offset);
    if (!all->items) all->items = calloc((size_t)p->argc, sizeof *all->items);
    if (!all->items) return args_wrong(p->problem, "out of memory");
    all->items[all->count++] = text;
    p->operands = 1;
    return true;
}

static size_t operand_count(const args_spec *spec) {
    size_t count = 0;
    while (count < ARGS_OPERANDS_MAX && spec->operands[count].name) ++count;
    return count;
}

static bool takes_output(const args_spec *spec) {
    for (const args_option *option = args_options(spec); option && option->help; ++option)
        if (option->letter == 'o') return true;
    return false;
}

static bool parse_operand(parser *p, const char *text) {
    if (p->spec->many) return add_operand(p, text);
    if (p->operands == operand_count(p->spec))
        return args_wrong(p->problem, "unexpected argument \"%.300s\"%s", text,
                          takes_output(p->spec) ? "; the file to write follows -o" : "");
    memcpy(p->settings + p->spec->operands[p->operands++].offset, &text, sizeof text);
    return true;
}

bool args_ask_help(int argc, char **argv) {
    for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; ++i)
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) return true;
    return false;
}

args_result args_parse(const args_spec *spec, int argc, char **argv, void *settings, args_problem *problem) {
    if (args_ask_help(argc, argv)) return ARGS_HELP;
    parser p = {spec, argc, 1, argv, settings, 0, problem};
    bool options_end = false;
    for (; p.at < argc; ++p.at) {
        const char *text = argv[p.at];
        bool fine;
        if (options_end || text[0] != '-' || !text[1])
            fine = parse_operand(&p, text);
        else if (strcmp(text, "--") == 0)
            fine = options_end = true;
        else
            fine = text[1] == '-' ? parse_long(&p, text) : parse_short(&p, text);
        if (!fine) return ARGS_WRONG;
    }
    if (p.operands + spec->operands_optional >= operand_count(spec)) return ARGS_READY;
    args_wrong(problem, "%s is missing", spec->operands[p.operands].name);
    return ARGS_WRONG;
}
