/* What there is to tell of a scene: warnings, and what a render does without. */
#ifndef CLI_NOTES_H
#define CLI_NOTES_H

#include "base/array.h"

#include <fathom/render.h>
#include <jansson.h>

/* Warnings in the order in which they came; the strings are its own. Zero it to start with. */
typedef ARRAY(char *) warning_list;

/* Two fathom_warning_fn; `user` is the list, which keeps what there is memory for. */
void warnings_keep(void *user, const char *message);
/* Writes it to stderr as well; without a list, only there. */
void warnings_say(void *user, const char *message);
/* Both, of a text in parts. */
void warnings_tell(warning_list *warnings, const char *format, ...) __attribute__((format(printf, 2, 3)));
json_t *warnings_json(const warning_list *warnings);
void warnings_free(warning_list *warnings);

/* What a render does without; that of the library stays its own. */
typedef struct left_out_list {
    const fathom_left_out *items;
    uint32_t count;
    bool no_helper; /* nor is the image helper started */
} left_out_list;

/* A line each, the first behind `title`, the others below it. */
void left_out_print(const left_out_list *list, const char *title);
/* [{"what": …, "why": …}, …] */
json_t *left_out_json(const left_out_list *list);

#endif
