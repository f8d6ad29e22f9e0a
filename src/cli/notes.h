/* Notes about a scene: warnings, and the parts that a render does without. */
#ifndef CLI_NOTES_H
#define CLI_NOTES_H

#include "base/array.h"

#include <fathom/render.h>
#include <jansson.h>

/* Warnings in the order in which they came; the strings are its own. Zero it to start with. */
typedef ARRAY(char *) warning_list;

/* Two fathom_warning_fn; `user` is the list. */
void warnings_keep(void *user, const char *message);
/* Writes it to stderr as well; without a list, only there. */
void warnings_say(void *user, const char *message);
/* warnings_say() of a formatted text. */
void warnings_tell(warning_list *warnings, const char *format, ...) __attribute__((format(printf, 2, 3)));
json_t *warnings_json(const warning_list *warnings);
void warnings_free(warning_list *warnings);

/* The parts that a render does without. `items` stay the library's. */
typedef struct left_out_list {
    const fathom_left_out *items;
    uint32_t count;
    bool no_helper; /* the image helper is not started either */
} left_out_list;

/* A line each, the first behind `title`, the others below it. */
void left_out_print(const left_out_list *list, const char *title);
/* [{"what": …, "why": …}, …] */
json_t *left_out_json(const left_out_list *list);

#endif
