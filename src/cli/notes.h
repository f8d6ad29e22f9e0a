/* What there is to tell of a scene: warnings, and what a render does without. */
#ifndef CLI_NOTES_H
#define CLI_NOTES_H

#include "base/array.h"
#include "integrate/parts.h"

#include <jansson.h>

/* Warnings in the order in which they came; the strings are its own. Zero it to start with. */
typedef ARRAY(char *) warning_list;

/* Two fathom_warning_fn; `user` is the list, which keeps what there is memory for. */
void warnings_keep(void *user, const char *message);
/* Writes it to stderr as well; without a list, only there. */
void warnings_say(void *user, const char *message);
json_t *warnings_json(const warning_list *warnings);
void warnings_free(warning_list *warnings);

/* Adds that the image helper is not started. False when out of memory. */
bool left_out_image_module(left_out_list *list);
/* A line each, the first behind `title`, the others below it. */
void left_out_print(const left_out_list *list, const char *title);
/* [{"what": …, "why": …}, …] */
json_t *left_out_json(const left_out_list *list);

#endif
