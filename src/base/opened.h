/* The list of files that a context has opened. */
#pragma once

#include <fathom/base.h>
#include <stdbool.h>

/* Starts recording with an empty list, or stops it. While it is on, file_open() adds its path to the list. */
void context_note_opened(fathom_context *context, bool note);
/* Adds a path, once, if recording is on. Returns false when out of memory. */
bool context_add_opened(fathom_context *context, const char *path);
size_t context_opened_count(const fathom_context *context);
const char *context_opened(const fathom_context *context, size_t index);
