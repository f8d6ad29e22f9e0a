#include "cli/provenance.h"

#include "base/text.h"
#include "cli/json_text.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static int count;
static char **arguments;

void provenance_note(int argc, char **argv) {
    count = argc;
    arguments = argv;
}

/* Longer command lines end in "...". */
#define LENGTH 4096

typedef struct command_text {
    char text[LENGTH];
    size_t length;
} command_text;

static void put(command_text *t, const char *text, size_t length) {
    const size_t room = sizeof t->text - 4 - t->length;
    const bool fits = length <= room;
    memcpy(t->text + t->length, text, fits ? length : room);
    t->length += fits ? length : room;
    memcpy(t->text + t->length, "...", fits ? 0 : 4);
}

static bool is_plain(const char *text) {
    static const char safe[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_@%+=:,./-";
    return *text && !text[strspn(text, safe)];
}

/* Puts the text between single quotes; each single quote inside becomes '\''. */
static void put_quoted(command_text *t, const char *text) {
    put(t, "'", 1);
    for (; *text; ++text)
        if (*text == '\'')
            put(t, "'\\''", 4);
        else
            put(t, text, 1);
    put(t, "'", 1);
}

/* The offset of the value in "--name=value" and "-nvalue"; 0 if the argument is only a value, or has none. */
static size_t option_length(const char *argument) {
    if (argument[0] != '-' || !argument[1]) return 0;
    const char *equals = strchr(argument, '=');
    if (argument[1] == '-') return equals ? (size_t)(equals - argument) + 1 : 0;
    return 2;
}

/* "--ocio=/home/ada/show.ocio" becomes "--ocio=show.ocio". */
static void put_argument(command_text *t, const char *argument) {
    char name[LENGTH];
    const size_t option = option_length(argument);
    const char *slash = strrchr(argument + option, '/');
    const char *rest = slash ? slash + 1 : argument + option;
    if (option + strlen(rest) >= sizeof name) return;
    memcpy(name, argument, option);
    memcpy(name + option, rest, strlen(rest) + 1);
    text_disarm(name);
    if (t->length) put(t, " ", 1);
    if (is_plain(name))
        put(t, name, strlen(name));
    else
        put_quoted(t, name);
}

const char *provenance_command(void) {
    static command_text t;
    const char *epoch = getenv("SOURCE_DATE_EPOCH");
    t.length = 0;
    for (int i = 0; i < count && !(epoch && *epoch); ++i) put_argument(&t, arguments[i]);
    if (t.length < sizeof t.text - 4) t.text[t.length] = '\0';
    return t.text;
}

json_t *provenance_arguments(void) {
    json_t *array = json_array();
    for (int i = 0; i < count; ++i) json_array_append_new(array, json_text(arguments[i]));
    return array;
}
