#include "base/status.h"

#include "base/threads.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MESSAGE_SIZE 2048

struct fathom_context {
    char message[MESSAGE_SIZE];
    fathom_warning_fn on_warning;
    void *warning_user;
    unsigned threads;
};

fathom_status fathom_context_create(fathom_context **out) {
    *out = calloc(1, sizeof **out);
    return *out ? FATHOM_OK : FATHOM_OUT_OF_RESOURCES;
}

void fathom_context_destroy(fathom_context *context) { free(context); }

const char *fathom_context_message(const fathom_context *context) { return context->message; }

void fathom_context_on_warning(fathom_context *context, fathom_warning_fn fn, void *user) {
    context->on_warning = fn;
    context->warning_user = user;
}

void fathom_context_set_threads(fathom_context *context, unsigned threads) { context->threads = threads; }

unsigned fathom_context_threads(const fathom_context *context) {
    return context->threads ? context->threads : processor_count();
}

const char *fathom_version(void) {
#define TEXT(x) #x
#define DOTTED(a, b, c) TEXT(a) "." TEXT(b) "." TEXT(c)
    return DOTTED(FATHOM_VERSION_MAJOR, FATHOM_VERSION_MINOR, FATHOM_VERSION_PATCH);
}

fathom_status fail(fathom_context *context, fathom_status status, const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(context->message, MESSAGE_SIZE, format, args);
    va_end(args);
    return status;
}

fathom_status fail_within(fathom_context *context, fathom_status status, const char *format, ...) {
    char inner[MESSAGE_SIZE];
    memcpy(inner, context->message, MESSAGE_SIZE);
    va_list args;
    va_start(args, format);
    int used = vsnprintf(context->message, MESSAGE_SIZE, format, args);
    va_end(args);
    if (used >= 0 && used < MESSAGE_SIZE) {
        snprintf(context->message + used, (size_t)(MESSAGE_SIZE - used), "%s", inner);
    }
    return status;
}

fathom_status fail_memory(fathom_context *context, size_t bytes) {
    return fail(context, FATHOM_OUT_OF_RESOURCES, "out of memory: %zu bytes could not be had", bytes);
}

void warn(fathom_context *context, const char *format, ...) {
    if (!context->on_warning) return;
    char text[MESSAGE_SIZE];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    context->on_warning(context->warning_user, text);
}
