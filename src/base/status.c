#include "base/status.h"

#include "base/array.h"
#include "base/opened.h"
#include "base/text.h"
#include "base/threads.h"

#include <fathom/file.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Bytes, enough for the longest path and the text about it. */
#define MESSAGE_SIZE 6144

/* The longest chain of places is a list of rays, a scene, a glTF file and its buffer. */
enum { PLACES = 4, STRINGS_SIZE = (PLACES + 1) * MESSAGE_SIZE };

typedef struct error_store {
    fathom_error error;
    fathom_place places[PLACES]; /* from the error outwards */
    size_t place_count, used;
    char strings[STRINGS_SIZE]; /* the text of `error` and `places` */
    char message[MESSAGE_SIZE];
} error_store;

typedef struct file_identity {
    dev_t device;
    ino_t number;
} file_identity;

struct fathom_context {
    error_store failed;
    fathom_warning_fn on_warning;
    void *warning_user;
    unsigned threads;
    bool allow_outside, copy_files, note_opened;
    ARRAY(file_identity) outputs;
    ARRAY(char *) opened;
};

static const fathom_place no_place = {.file = "", .field = ""};
static const fathom_error no_error = {FATHOM_OK, &no_place, ""};

fathom_status fathom_context_create(fathom_context **out) {
    if (!out) return FATHOM_BAD_USAGE;
    *out = calloc(1, sizeof **out);
    if (!*out) return FATHOM_OUT_OF_RESOURCES;
    (*out)->failed.error = no_error;
    return FATHOM_OK;
}

void fathom_context_destroy(fathom_context *context) {
    for (size_t i = 0; context && i < context->opened.count; ++i) free(context->opened.items[i]);
    if (context) array_free(&context->opened);
    if (context) array_free(&context->outputs);
    free(context);
}

const fathom_error *fathom_context_error(const fathom_context *context) {
    return context ? &context->failed.error : &no_error;
}

const char *fathom_context_message(const fathom_context *context) {
    return context ? context->failed.message : "";
}

void fathom_context_on_warning(fathom_context *context, fathom_warning_fn fn, void *user) {
    if (!context) return;
    context->on_warning = fn;
    context->warning_user = user;
}

void fathom_context_set_threads(fathom_context *context, unsigned threads) {
    if (context) context->threads = threads;
}

unsigned fathom_context_threads(const fathom_context *context) {
    const unsigned threads = context && context->threads ? context->threads : processor_count();
    return threads < THREADS_MAX ? threads : THREADS_MAX;
}

void fathom_context_allow_outside(fathom_context *context, bool allow) {
    if (context) context->allow_outside = allow;
}

bool context_allows_outside(const fathom_context *context) { return context->allow_outside; }

void fathom_context_copy_files(fathom_context *context, bool copy) {
    if (context) context->copy_files = copy;
}

bool context_copies_files(const fathom_context *context) { return context->copy_files; }

void context_note_opened(fathom_context *context, bool note) {
    while (note && context->opened.count) free(context->opened.items[--context->opened.count]);
    context->note_opened = note;
}

bool context_add_opened(fathom_context *context, const char *path) {
    if (!context->note_opened) return true;
    for (size_t i = 0; i < context->opened.count; ++i)
        if (strcmp(context->opened.items[i], path) == 0) return true;
    char *copy = strdup(path);
    if (copy && array_push(&context->opened, copy)) return true;
    free(copy);
    return false;
}

size_t context_opened_count(const fathom_context *context) { return context->opened.count; }

const char *context_opened(const fathom_context *context, size_t index) {
    return context->opened.items[index];
}

fathom_status fathom_file_protect(fathom_context *context, const char *const *paths, size_t count) {
    if (!context || (!paths && count)) return fail_null(context, "paths");
    context->outputs.count = 0;
    for (size_t i = 0; i < count; ++i) {
        struct stat info;
        if (!paths[i])
            return fail_item(context, FATHOM_BAD_USAGE, "paths", i, "expected an address, found NULL");
        if (stat(paths[i], &info) != 0) continue;
        const file_identity file = {info.st_dev, info.st_ino};
        if (!array_push(&context->outputs, file)) return fail_memory(context, sizeof file);
    }
    return FATHOM_OK;
}

bool context_is_output(const fathom_context *context, const struct stat *file) {
    for (size_t i = 0; i < context->outputs.count; ++i) {
        const file_identity *one = &context->outputs.items[i];
        if (one->device == file->st_dev && one->number == file->st_ino) return true;
    }
    return false;
}

/* ---- errors ---- */

static const char *keep(error_store *store, const char *text) {
    if (!text || !*text || store->used >= STRINGS_SIZE) return "";
    char *copy = store->strings + store->used;
    snprintf(copy, STRINGS_SIZE - store->used, "%s", text);
    store->used += strlen(copy) + 1;
    return copy;
}

/* Texts quote files and appear on terminals. No byte from a file may control a terminal or look like a line
 * end. */
static const char *keep_disarmed(error_store *store, const char *text) {
    const size_t begin = store->used;
    const char *kept = keep(store, text);
    if (*kept) text_disarm(store->strings + begin);
    return kept;
}

static void add_place(error_store *store, const fathom_place *place) {
    if (store->place_count == PLACES) return;
    fathom_place *added = &store->places[store->place_count];
    *added = *place;
    added->file = keep(store, place->file);
    added->field = keep_disarmed(store, place->field);
    added->within = NULL;
    if (store->place_count++) added[-1].within = added;
}

static void append(char *message, const char *format, ...) {
    const size_t used = strlen(message);
    va_list args;
    va_start(args, format);
    vsnprintf(message + used, MESSAGE_SIZE - used, format, args);
    va_end(args);
}

static void append_place(char *message, const fathom_place *place) {
    append(message, "%s", place->file);
    if (place->line) append(message, ":%zu", place->line);
    if (place->column) append(message, ":%zu", place->column);
    if (*place->file) append(message, ": ");
    if (place->has_byte) append(message, "at byte %zu: ", place->byte);
    if (*place->field) append(message, "%s: ", place->field);
}

/* All messages are made here from errors. */
static void format_message(error_store *store) {
    store->message[0] = '\0';
    for (size_t i = store->place_count; i-- > 0;) append_place(store->message, &store->places[i]);
    append(store->message, "%s", store->error.text);
    text_disarm(store->message);
}

/* The arguments may point into the previous error, so they are formatted before it is overwritten. */
static fathom_status store_error(fathom_context *context, fathom_status status, const fathom_place *place,
                                 const char *format, va_list args) {
    if (!context) return status;
    error_store *store = &context->failed;
    char text[MESSAGE_SIZE];
    vsnprintf(text, sizeof text, format, args);
    store->used = store->place_count = 0;
    add_place(store, place);
    store->error = (fathom_error){status, store->places, keep_disarmed(store, text)};
    format_message(store);
    return status;
}

fathom_status fail(fathom_context *context, fathom_status status, const char *format, ...) {
    va_list args;
    va_start(args, format);
    store_error(context, status, &no_place, format, args);
    va_end(args);
    return status;
}

fathom_status fail_item(fathom_context *context, fathom_status status, const char *array, size_t index,
                        const char *format, ...) {
    char field[64];
    snprintf(field, sizeof field, "%s[%zu]", array, index);
    va_list args;
    va_start(args, format);
    store_error(context, status, &(fathom_place){.field = field}, format, args);
    va_end(args);
    return status;
}

fathom_status fail_at(fathom_context *context, fathom_status status, const fathom_place *place,
                      const char *format, ...) {
    va_list args;
    va_start(args, format);
    store_error(context, status, place, format, args);
    va_end(args);
    return status;
}

/* The error has no file yet, so `place` becomes its place. Its own field is a name inside the callee: it goes
 * to the text if `place` has a field too. */
static void move_error(error_store *store, const fathom_place *place) {
    const char *field = store->places[0].field;
    fathom_place joined = *place;
    if (!joined.field || !*joined.field) {
        joined.field = field;
    } else if (*field) {
        char text[MESSAGE_SIZE];
        snprintf(text, sizeof text, "%s: %s", field, store->error.text);
        store->error.text = keep(store, text);
    }
    store->place_count = 0;
    add_place(store, &joined);
}

fathom_status fail_within(fathom_context *context, fathom_status status, const fathom_place *place) {
    if (!context) return status;
    error_store *store = &context->failed;
    if (store->place_count == 1 && !*store->places[0].file)
        move_error(store, place);
    else
        add_place(store, place);
    store->error.status = status;
    format_message(store);
    return status;
}

fathom_status fathom_context_fail_within(fathom_context *context, const fathom_place *place) {
    if (!context || !place) return fail_null(context, "place");
    return fail_within(context, context->failed.error.status, place);
}

fathom_status fathom_context_fail(fathom_context *context, const fathom_error *error) {
    if (!context || !error) return fail_null(context, "error");
    const fathom_place *place = error->place ? error->place : &no_place;
    fathom_status status = fail_at(context, error->status, place, "%s", error->text ? error->text : "");
    for (place = place->within; place; place = place->within) fail_within(context, status, place);
    return status;
}

fathom_status fail_memory(fathom_context *context, size_t bytes) {
    return fail(context, FATHOM_OUT_OF_RESOURCES, "out of memory: %zu bytes are not available", bytes);
}

fathom_status fail_null(fathom_context *context, const char *argument) {
    return fail_field(context, FATHOM_BAD_USAGE, argument, "expected an address, found NULL");
}

void warn(fathom_context *context, const char *format, ...) {
    if (!context->on_warning) return;
    char text[MESSAGE_SIZE];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    text_disarm(text);
    context->on_warning(context->warning_user, text);
}
