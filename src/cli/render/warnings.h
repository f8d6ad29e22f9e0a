/* Warnings, said and kept: for stderr, for --stats, and as the problems of `info`. */
#ifndef CLI_WARNINGS_H
#define CLI_WARNINGS_H

#include "base/array.h"

#include <jansson.h>

/* In the order in which they came; the strings are its own. Zero it to start with. */
typedef ARRAY(char *) warning_list;

/* Two fathom_warning_fn; `user` is the list, which keeps what there is memory for. */
void warnings_keep(void *user, const char *message);
/* Writes it to stderr as well; without a list, only there. */
void warnings_say(void *user, const char *message);
json_t *warnings_json(const warning_list *warnings);
void warnings_free(warning_list *warnings);

#endif
