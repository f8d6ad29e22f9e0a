#include "cli/notes.h"

#include "cli/json_text.h"
#include "cli/log.h"

#include <stdio.h>
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

bool left_out_image_module(left_out_list *list) {
    return left_out_tell(list, "image helper", "PNG in the built-in sRGB view is written without it");
}

void left_out_print(const left_out_list *list, const char *title) {
    for (size_t i = 0; i < list->count; ++i)
        printf("%-*s%s: %s\n", (int)strlen(title), i ? "" : title, list->items[i].what, list->items[i].why);
}

json_t *left_out_json(const left_out_list *list) {
    json_t *array = json_array();
    for (size_t i = 0; i < list->count; ++i)
        json_array_append_new(array,
                              json_of(JSON("what", list->items[i].what), JSON("why", list->items[i].why)));
    return array;
}
