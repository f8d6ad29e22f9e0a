#include "read/mesh/text.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void record(text_fault *fault, const char *at, const char *field, const char *what) {
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    pthread_mutex_lock(&lock);
    if (!at) {
        fault->no_memory = true;
    } else if (!fault->at || at < fault->at) {
        fault->at = at;
        snprintf(fault->field, sizeof fault->field, "%s", field ? field : "");
        snprintf(fault->what, sizeof fault->what, "%s", what);
    }
    pthread_mutex_unlock(&lock);
}

bool text_no_memory(text_fault *fault) {
    record(fault, NULL, NULL, NULL);
    return false;
}

bool text_wrong(text_fault *fault, const void *at, const char *field, const char *format, ...) {
    char what[sizeof fault->what];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    record(fault, at, field, what);
    return false;
}

/* The line of `at`, from 1. */
static size_t text_line(const text_file *file, const char *at) {
    size_t line = 1;
    for (const char *p = file->begin; (p = memchr(p, '\n', (size_t)(at - p))) != NULL; ++p) ++line;
    return line;
}

fathom_status text_status(const text_file *file, const text_fault *fault) {
    if (fault->no_memory) return fail_memory(file->context, file->size);
    if (!fault->at) return FATHOM_OK;
    fathom_place place = {.file = file->path, .field = fault->field};
    if (file->binary && fault->at >= file->binary)
        place.has_byte = true, place.byte = file->size - (size_t)(file->end - fault->at);
    else
        place.line = text_line(file, fault->at);
    return fail_at(file->context, FATHOM_BAD_INPUT, &place, "%s", fault->what);
}

bool text_has_no_zeros(text_fault *fault, const char *begin, const char *end) {
    const char *zero = memchr(begin, '\0', (size_t)(end - begin));
    if (!zero) return true;
    const bool utf16 = memcmp(begin, "\xFF\xFE", 2) == 0 || memcmp(begin, "\xFE\xFF", 2) == 0;
    return text_wrong(fault, zero, NULL,
                      utf16 ? "UTF-16; expected UTF-8: save it as UTF-8" : "a zero byte; expected text");
}

const char *text_after_mark(const char *begin, const char *end) {
    return end - begin >= 3 && memcmp(begin, "\xEF\xBB\xBF", 3) == 0 ? begin + 3 : begin;
}

bool text_ends_lines_in_cr(const char *begin, const char *end) {
    const char *newline = memchr(begin, '\n', (size_t)(end - begin));
    const char *cr = memchr(begin, '\r', (size_t)((newline ? newline : end) - begin));
    return cr && cr + 1 != newline;
}

fathom_status text_copy(text_file *file) {
    size_t size = (size_t)(file->end - file->begin);
    file->copy = malloc(size + FILE_PADDING);
    if (!file->copy) return fail_memory(file->context, size + FILE_PADDING);
    memcpy(file->copy, file->begin, size);
    memset(file->copy + size, 0, FILE_PADDING);
    file->begin = file->copy;
    file->end = file->copy + size;
    return FATHOM_OK;
}

void text_mend_line_ends(char *begin, const char *end) {
    for (char *p = begin; (p = memchr(p, '\r', (size_t)(end - p))) != NULL; ++p) {
        if (p[1] != '\n') *p = '\n';
    }
}

fathom_status text_open(fathom_context *context, const char *path, const file_map *map, text_file *out) {
    const char *text = (const char *)map->bytes, *end = text + map->size;
    *out = (text_file){.context = context, .path = path, .end = end, .size = map->size};
    out->begin = text_after_mark(text, end);
    if (!text_ends_lines_in_cr(out->begin, end)) return FATHOM_OK;
    fathom_status status = text_copy(out);
    if (status == FATHOM_OK) text_mend_line_ends(out->copy, out->end);
    return status;
}

void text_close(text_file *file) { free(file->copy); }

const char *text_quote(const char *at, char out[48]) {
    if (text_is_end(*at)) return "the end of the line";
    size_t n = 0;
    out[n++] = '"';
    while (n < 41 && !text_is_blank(*at) && !text_is_end(*at)) {
        out[n++] = *at < ' ' || *at == 127 ? '?' : *at;
        ++at;
    }
    if (!text_is_blank(*at) && !text_is_end(*at)) {
        memcpy(out + n, "...", 3);
        n += 3;
    }
    out[n++] = '"';
    out[n] = '\0';
    return out;
}

/* True when a backslash joins the line that ends at `newline` to the next one. */
static bool is_joined(const char *newline, const char *begin) {
    const char *p = newline;
    if (p > begin && p[-1] == '\r') --p;
    return p > begin && p[-1] == '\\';
}

const char *text_next(const char *p, const char *end) {
    for (const char *from = p; from < end;) {
        const char *newline = memchr(from, '\n', (size_t)(end - from));
        if (!newline) return end;
        if (!is_joined(newline, p)) return newline + 1;
        from = newline + 1;
    }
    return end;
}

static bool begins_remark(const char *p, const char *begin) {
    return *p == '#' && (p == begin || text_is_blank(p[-1])) && (text_is_blank(p[1]) || text_is_end(p[1]));
}

size_t text_rest(const char **p, const char *end) {
    const char *first = text_skip(*p);
    const char *last = first;
    while (last < end && !text_is_end(*last) && !begins_remark(last, first)) ++last;
    while (last > first && text_is_blank(last[-1])) --last;
    if (last - first > 1 && *first == '"' && last[-1] == '"') ++first, --last;
    *p = first;
    return (size_t)(last - first);
}

const char **text_pieces(const text_file *file, size_t grain, size_t *count) {
    size_t size = (size_t)(file->end - file->begin), n = 0;
    const char **starts = malloc((size / grain + 2) * sizeof *starts);
    if (!starts) return NULL;
    starts[0] = file->begin;
    while (starts[n] < file->end) {
        /* Starts one byte before the target, so that a line end there is found. */
        const char *from = starts[n] + grain - 1, *next = NULL;
        while ((size_t)(file->end - starts[n]) > grain && from < file->end) {
            next = memchr(from, '\n', (size_t)(file->end - from));
            if (!next || !is_joined(next, file->begin)) break;
            from = next + 1, next = NULL;
        }
        starts[++n] = next ? next + 1 : file->end;
    }
    *count = n;
    return starts;
}

/* ---- notes ---- */

/* Returns the note if it is the first of its kind and needs a place; otherwise NULL. */
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
        warn(context, "%s: more kinds of problems are not listed (%zu such)", path, notes->beyond);
}
