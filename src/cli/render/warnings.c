#include "cli/render/warnings.h"

#include "cli/json_text.h"
#include "cli/log.h"

#include <stdlib.h>
#include <string.h>

void warnings_keep(void *user, const char *message) {
    warning_list *warnings = user;
    char *copy = strdup(message);
    if (copy && !array_push(warnings, copy)) free(copy);
}

void warnings_say(void *user, const char *message) {
    log_line(LOG_WARNING, message);
    if (user) warnings_keep(user, message);
}

json_t *warnings_json(const warning_list *warnings) {
    json_t *list = json_array();
    for (size_t i = 0; i < warnings->count; ++i) json_array_append_new(list, json_text(warnings->items[i]));
    return list;
}

void warnings_free(warning_list *warnings) {
    for (size_t i = 0; i < warnings->count; ++i) free(warnings->items[i]);
    array_free(warnings);
}
