#include "cli/notes.h"

#include "base/text.h"
#include "cli/json_text.h"
#include "cli/log.h"

#include <stdarg.h>
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

void warnings_say_once(void *user, const char *message) {
    const warning_list *said = user;
    for (size_t i = 0; i < said->count; ++i) {
        if (strcmp(said->items[i], message) == 0) return;
    }
    warnings_say(user, message);
}

void warnings_tell(warning_list *warnings, const char *format, ...) {
    char text[LOG_LENGTH];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    text_disarm(text);
    warnings_say(warnings, text);
}

json_t *warnings_json(const warning_list *warnings) {
    json_t *list = json_array();
    for (size_t i = 0; i < warnings->count; ++i) json_array_append_new(list, json_text(warnings->items[i]));
    return list;
}

void warnings_free(warning_list *warnings) {
    for (size_t i = 0; i < warnings->count; ++i) free(warnings->items[i]);
    array_free(warnings);
    *warnings = (warning_list){.count = 0};
}

static const fathom_left_out no_helper = {"image helper for writing",
                                          "EXR, and PNG in the built-in sRGB view, are written without it"};

static uint32_t count_all(const left_out_list *list) { return list->count + list->no_helper; }

static const fathom_left_out *item_at(const left_out_list *list, uint32_t i) {
    return i < list->count ? &list->items[i] : &no_helper;
}

void left_out_print(const left_out_list *list, const char *title) {
    for (uint32_t i = 0; i < count_all(list); ++i)
        printf("%-*s%s: %s\n", (int)strlen(title), i ? "" : title, item_at(list, i)->what,
               item_at(list, i)->why);
}

json_t *left_out_json(const left_out_list *list) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < count_all(list); ++i)
        json_array_append_new(
            array, json_of(JSON("what", item_at(list, i)->what), JSON("why", item_at(list, i)->why)));
    return array;
}
