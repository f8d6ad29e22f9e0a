#include "base/status.h"

#include "base/text.h"
#include "base/threads.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of the longest path there may be, and what is said of it. */
#define MESSAGE_SIZE 6144

struct fathom_context {
    char message[MESSAGE_SIZE];
    fathom_warning_fn on_warning;
    void *warning_user;
    unsigned threads;
    bool allow_outside, copy_files;
    const file_identity *outputs;
    size_t output_count;
};

fathom_status fathom_context_create(fathom_context **out) {
    if (!out) return FATHOM_BAD_USAGE;
    *out = calloc(1, sizeof **out);
    return *out ? FATHOM_OK : FATHOM_OUT_OF_RESOURCES;
}

void fathom_context_destroy(fathom_context *context) { free(context); }

const char *fathom_context_message(const fathom_context *context) { return context ? context->message : ""; }

void fathom_context_on_warning(fathom_context *context, fathom_warning_fn fn, void *user) {
    if (!context) return;
    context->on_warning = fn;
    context->warning_user = user;
}

void fathom_context_set_threads(fathom_context *context, unsigned threads) {
    if (context) context->threads = threads;
}

unsigned fathom_context_threads(const fathom_context *context) {
    return context && context->threads ? context->threads : processor_count();
}

void fathom_context_allow_outside(fathom_context *context, bool allow) {
    if (context) context->allow_outside = allow;
}

bool context_allows_outside(const fathom_context *context) { return context->allow_outside; }

void fathom_context_copy_files(fathom_context *context, bool copy) {
    if (context) context->copy_files = copy;
}

bool context_copies_files(const fathom_context *context) { return context->copy_files; }

void context_set_outputs(fathom_context *context, const file_identity *files, size_t count) {
    context->outputs = files;
    context->output_count = count;
}

bool context_is_output(const fathom_context *context, const struct stat *file) {
    for (size_t i = 0; i < context->output_count; ++i) {
        const file_identity *one = &context->outputs[i];
        if (one->device == file->st_dev && one->number == file->st_ino) return true;
    }
    return false;
}

/* Messages quote files, and are shown on terminals: no byte of a file may steer one, or pass for a line of
 * its own. */
fathom_status fail(fathom_context *context, fathom_status status, const char *format, ...) {
    if (!context) return status;
    va_list args;
    va_start(args, format);
    vsnprintf(context->message, MESSAGE_SIZE, format, args);
    va_end(args);
    text_disarm(context->message);
    return status;
}

fathom_status fail_within(fathom_context *context, fathom_status status, const char *format, ...) {
    if (!context) return status;
    char inner[MESSAGE_SIZE];
    memcpy(inner, context->message, MESSAGE_SIZE);
    va_list args;
    va_start(args, format);
    int used = vsnprintf(context->message, MESSAGE_SIZE, format, args);
    va_end(args);
    if (used >= 0 && used < MESSAGE_SIZE) {
        snprintf(context->message + used, (size_t)(MESSAGE_SIZE - used), "%s", inner);
    }
    text_disarm(context->message);
    return status;
}

fathom_status fail_memory(fathom_context *context, size_t bytes) {
    return fail(context, FATHOM_OUT_OF_RESOURCES, "out of memory: %zu bytes could not be had", bytes);
}

fathom_status fail_null(fathom_context *context, const char *argument) {
    return fail(context, FATHOM_BAD_USAGE, "%s: expected an address, found NULL", argument);
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
