#include "cli/command.h"

#include <string.h>

#define HELP_WIDTH 80
#define HELP_COLUMN 28

void help_overview(FILE *out) {
    fputs("Fathom renders scenes by ray tracing.\n\nUsage: fathom COMMAND ...\n\nCommands:\n", out);
    for (size_t i = 0; commands[i]; ++i)
        fprintf(out, "  %-10s %s\n", commands[i]->name, commands[i]->summary);
    fputs("\n"
          "fathom COMMAND --help lists all options; fathom --version -v prints the version.\n"
          "The first image:  fathom render model.glb -o image.png\n",
          out);
}

/* Prints words from column `column` on, wrapped; the cursor is at column `at`. */
static void put_wrapped(FILE *out, const char *text, size_t at, size_t column) {
    while (*text) {
        size_t word = strcspn(text, " ");
        if (at > column && at + 1 + word > HELP_WIDTH) {
            fputc('\n', out);
            at = 0;
        }
        if (at < column) {
            fprintf(out, "%*s", (int)(column - at), "");
            at = column;
        } else if (at > column) {
            fputc(' ', out);
            ++at;
        }
        fwrite(text, 1, word, out);
        at += word;
        text += word + strspn(text + word, " ");
    }
    fputc('\n', out);
}

static void put_option(FILE *out, const args_option *option) {
    if (!option->name) {
        fprintf(out, "\n%s:\n", option->help);
        return;
    }
    char left[80], letter[8] = "";
    if (option->letter) snprintf(letter, sizeof letter, "-%c, ", option->letter);
    int length = snprintf(left, sizeof left, "  %s--%s%s%s", letter, option->name, option->value ? " " : "",
                          option->value ? option->value : "");
    size_t at = length < 0 ? 0 : (size_t)length;
    fputs(left, out);
    if (at + 2 > HELP_COLUMN) {
        fputc('\n', out);
        at = 0;
    }
    put_wrapped(out, option->help, at, HELP_COLUMN);
}

static const args_option common[] = {
    {.help = "Every command"},
    {"log", 0, "text|json", NULL, 0, 0, 0,
     "how to write progress, warnings and errors to stderr: as text, or as one JSON object per "
     "line (text)"},
    {"help", 'h', NULL, NULL, 0, 0, 0, "this text"},
    {.help = NULL},
};

void help_command(const command *c, FILE *out) {
    fprintf(out, "%s\n\nUsage: fathom %s%s%s\n", c->summary, c->name, *c->usage ? " " : "", c->usage);
    if (c->text) fprintf(out, "\n%s", c->text);
    for (const args_option *o = args_options(&c->args); o && o->help; ++o) put_option(out, o);
    for (const args_option *o = common; o->help; ++o) put_option(out, o);
    if (c->examples) fprintf(out, "\nExamples:\n%s", c->examples);
}

/* "help render --help" means the same as "help render". */
static int without_help(int argc, char **argv) {
    while (argc > 2 && (strcmp(argv[argc - 1], "--help") == 0 || strcmp(argv[argc - 1], "-h") == 0)) --argc;
    return argc;
}

static fathom_status run(int argc, char **argv) {
    argc = without_help(argc, argv);
    if (argc < 2) {
        help_overview(stdout);
        return FATHOM_OK;
    }
    args_problem problem;
    bool itself = strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0;
    const command *c = itself ? &command_help : command_find(commands, argv[1], &problem), *outer = NULL;
    if (c == &command_bench && argc == 3) outer = c, c = command_find(benches, argv[2], &problem);
    if (!c) return say_usage(outer, problem.text);
    if (argc > 2 && !outer) return say_usage(NULL, "help: expected at most one command");
    help_command(c, stdout);
    return FATHOM_OK;
}

const command command_help = {.name = "help",
                              .usage = "[COMMAND | bench WHAT]",
                              .summary = "Describe a command and its options.",
                              .run = run};
