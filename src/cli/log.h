/* Lines on stderr: for people, or with --log json one JSON object a line for programs. */
#pragma once

#include "cli/args.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum log_level { LOG_INFO, LOG_WARNING, LOG_ERROR } log_level;

/* Removes "--log text|json" from the arguments, at any position. False: wrong usage. */
bool log_take_option(int *argc, char **argv, args_problem *problem);
bool log_is_json(void);

/* "fathom: text", or {"time": seconds since 1970, "level": "error", "message": "text"}. Removes a progress
 * bar first. Replaces bytes that could control a terminal with '?'. Cuts text beyond LOG_LENGTH. Allocates no
 * memory and takes no lock, so signal handlers may call it. */
#define LOG_LENGTH 8192
void log_line(log_level level, const char *text);
/* The same with further members of the JSON object, such as "\"fraction\": 0.5"; lines for people omit
 * them. */
void log_line_with(log_level level, const char *text, const char *members);
/* log_line() of a formatted text; not for signal handlers. */
void log_say(log_level level, const char *format, ...) __attribute__((format(printf, 2, 3)));

#ifdef __cplusplus
}
#endif
