#include "cli/log.h"

#include "base/text.h"
#include "cli/render/progress.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static bool json;

bool log_is_json(void) { return json; }

static bool take_format(const char *value, args_problem *problem) {
    json = value && strcmp(value, "json") == 0;
    if (json || (value && strcmp(value, "text") == 0)) return true;
    return args_wrong(problem, "--log: expected text or json, found %s%.60s%s", value ? "\"" : "",
                      value ? value : "nothing", value ? "\"" : "");
}

/* Runs before the command's own options are read, because their errors are log lines too. */
bool log_take_option(int *argc, char **argv, args_problem *problem) {
    int kept = 1;
    bool fine = true, options_end = false;
    for (int i = 1; i < *argc; ++i) {
        options_end |= strcmp(argv[i], "--") == 0;
        if (!options_end && strcmp(argv[i], "--log") == 0)
            fine &= take_format(i + 1 < *argc ? argv[++i] : NULL, problem);
        else if (!options_end && strncmp(argv[i], "--log=", 6) == 0)
            fine &= take_format(argv[i] + 6, problem);
        else
            argv[kept++] = argv[i];
    }
    *argc = kept;
    return fine;
}

/* ---- lines, built without the C library's streams ---- */

typedef struct line {
    char text[2 * LOG_LENGTH + 1024]; /* each byte of a message may need two */
    size_t length;
} line;

static void put(line *l, const char *text, size_t length) {
    const size_t room = sizeof l->text - l->length;
    if (length > room) length = room;
    memcpy(l->text + l->length, text, length);
    l->length += length;
}

static void put_text(line *l, const char *text) { put(l, text, strlen(text)); }

static void put_number(line *l, unsigned long long number, unsigned digits) {
    char text[24];
    size_t at = sizeof text;
    for (; number || digits; number /= 10, digits -= digits > 0) text[--at] = (char)('0' + number % 10);
    put(l, text + at, sizeof text - at);
}

static void put_time(line *l) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    put_text(l, "\"time\": ");
    put_number(l, (unsigned long long)now.tv_sec, 1);
    put_text(l, ".");
    put_number(l, (unsigned long long)now.tv_nsec / 1000000, 3);
}

/* Writes UTF-8 without control characters. */
static void put_string(line *l, const char *text) {
    put_text(l, "\"");
    for (; *text; ++text) {
        if (*text == '"' || *text == '\\') put_text(l, "\\");
        put(l, text, 1);
    }
    put_text(l, "\"");
}

static void put_object(line *l, log_level level, const char *text, const char *members) {
    static const char *const names[] = {"info", "warning", "error"};
    put_text(l, "{");
    put_time(l);
    put_text(l, ", \"level\": ");
    put_string(l, names[level]);
    put_text(l, ", \"message\": ");
    put_string(l, text);
    if (*members) put_text(l, ", "), put_text(l, members);
    put_text(l, "}");
}

static void write_all(const char *bytes, size_t size) {
    while (size) {
        ssize_t done = write(STDERR_FILENO, bytes, size);
        if (done <= 0) return;
        bytes += done, size -= (size_t)done;
    }
}

void log_line_with(log_level level, const char *text, const char *members) {
    line l;
    char fit[LOG_LENGTH];
    l.length = 0;
    const size_t length = strnlen(text, sizeof fit - 1);
    memcpy(fit, text, length);
    fit[length] = '\0';
    text_disarm(fit);
    if (json) {
        put_object(&l, level, fit, members);
    } else {
        put_text(&l, progress_clear_text());
        put_text(&l, level == LOG_WARNING ? "fathom: warning: " : "fathom: ");
        put_text(&l, fit);
    }
    put_text(&l, "\n");
    write_all(l.text, l.length);
}

void log_line(log_level level, const char *text) { log_line_with(level, text, ""); }

void log_say(log_level level, const char *format, ...) {
    char text[LOG_LENGTH];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    log_line(level, text);
}
