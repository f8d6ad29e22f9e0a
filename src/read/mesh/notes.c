#include "read/mesh/notes.h"

#include <stdio.h>
#include <string.h>

/* The note if this is the first of its kind and needs a place; else NULL. */
static note *count_in(note_list *notes, size_t times, const char *format, va_list args) {
    note fresh = {.count = times};
    vsnprintf(fresh.text, sizeof fresh.text, format, args);
    for (size_t i = 0; i < notes->count; ++i) {
        if (strcmp(notes->items[i].text, fresh.text) != 0) continue;
        notes->items[i].count += times;
        return NULL;
    }
    if (notes->count == NOTES_MAX) notes->beyond += times;
    if (!times || notes->count == NOTES_MAX) return NULL;
    notes->items[notes->count] = fresh;
    return &notes->items[notes->count++];
}

void notes_add(note_list *notes, size_t times, const char *place, const char *format, ...) {
    va_list args;
    va_start(args, format);
    note *first = count_in(notes, times, format, args);
    va_end(args);
    if (first) snprintf(first->place, sizeof first->place, "%s", place);
}

void notes_add_at(note_list *notes, size_t times, const text_file *file, const char *at, bool quoted,
                  const char *format, ...) {
    va_list args;
    va_start(args, format);
    note *first = count_in(notes, times, format, args);
    va_end(args);
    if (!first) return;
    snprintf(first->place, sizeof first->place, ":%zu", text_line(file, at));
    if (quoted) text_quote(at, first->example);
}

void notes_tell(const note_list *notes, fathom_context *context, const char *path) {
    for (size_t i = 0; i < notes->count; ++i) {
        const note *n = &notes->items[i];
        warn(context, "%s%s: %s (%zu such%s%s)", path, n->place, n->text, n->count,
             n->example[0] ? ", the first here: " : "", n->example);
    }
    if (notes->beyond)
        warn(context, "%s: more kinds of things are not followed (%zu such)", path, notes->beyond);
}
