/* Notes about a scene: warnings, and the parts that a render leaves out. */
#pragma once

#include "base/array.h"

#include <fathom/render.h>
#include <jansson.h>

/* Warnings in their order of arrival; the list owns the strings. Initialise with zeros. */
typedef ARRAY(char *) warning_list;

/* Three fathom_warning_fn; `user` is the list. */
void warnings_keep(void *user, const char *message);
/* Also writes the warning to stderr; without a list, only there. */
void warnings_say(void *user, const char *message);
/* The same, unless the list has the warning already. */
void warnings_say_once(void *user, const char *message);
/* warnings_say() of a formatted text. */
void warnings_tell(warning_list *warnings, const char *format, ...) __attribute__((format(printf, 2, 3)));
json_t *warnings_json(const warning_list *warnings);
/* Leaves an empty list. */
void warnings_free(warning_list *warnings);

/* The parts that a render leaves out. The library owns `items`. */
typedef struct left_out_list {
    const fathom_left_out *items;
    uint32_t count;
    bool no_helper; /* images are written without the image helper, which is one more item */
} left_out_list;

/* Prints one line each: the first after `title`, the others below it. */
void left_out_print(const left_out_list *list, const char *title);
/* [{"what": …, "why": …}, …] */
json_t *left_out_json(const left_out_list *list);
