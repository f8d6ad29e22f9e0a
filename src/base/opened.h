/* Which files a context has opened. */
#ifndef BASE_OPENED_H
#define BASE_OPENED_H

#include <fathom/base.h>
#include <stdbool.h>

/* From here on, or no longer: file_open() adds the paths to a list. */
void context_note_opened(fathom_context *context, bool note);
/* Where this is asked for; false: out of memory. */
bool context_add_opened(fathom_context *context, const char *path);
size_t context_opened_count(const fathom_context *context);
const char *context_opened(const fathom_context *context, size_t index);

#endif
