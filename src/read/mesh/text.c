#include "read/mesh/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool text_wrong(text_fault *fault, const char *at, const char *field, const char *format, ...) {
    if (fault->at) return false;
    fault->at = at;
    snprintf(fault->field, sizeof fault->field, "%s", field ? field : "");
    va_list args;
    va_start(args, format);
    vsnprintf(fault->what, sizeof fault->what, format, args);
    va_end(args);
    return false;
}

size_t text_line(const text_file *file, const char *at) {
    size_t line = 1;
    for (const char *p = file->begin; (p = memchr(p, '\n', (size_t)(at - p))) != NULL; ++p) ++line;
    return line;
}

fathom_status text_fail(const text_file *file, const text_fault *fault) {
    const fathom_place place = {
        .file = file->path, .line = text_line(file, fault->at), .field = fault->field};
    return fail_at(file->context, FATHOM_BAD_INPUT, &place, "%s", fault->what);
}

bool text_has_no_zeros(text_fault *fault, const char *begin, const char *end) {
    const char *zero = memchr(begin, '\0', (size_t)(end - begin));
    return !zero || text_wrong(fault, zero, NULL, "a zero byte; expected text");
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
    *out = (text_file){.context = context, .path = path, .begin = text, .end = end};
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

/* Whether a backslash joins the line that ends at `newline` to the next one. */
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

size_t text_rest(const char **p, const char *end) {
    const char *first = text_skip(*p);
    const char *last = first;
    while (last < end && !text_is_end(*last)) ++last;
    while (last > first && text_is_blank(last[-1])) --last;
    *p = first;
    return (size_t)(last - first);
}

size_t *text_pieces(const text_file *file, size_t grain, size_t *count) {
    size_t size = (size_t)(file->end - file->begin);
    size_t *starts = malloc((size / grain + 2) * sizeof *starts);
    if (!starts) return NULL;
    size_t n = 0;
    starts[0] = 0;
    while (starts[n] < size) {
        size_t target = starts[n] + grain;
        /* Search from one byte before the target, so that a line end there is found. */
        const char *next = file->end;
        if (target < size) {
            next = memchr(file->begin + target - 1, '\n', size - target + 1);
            while (next && is_joined(next, file->begin)) {
                next = memchr(next + 1, '\n', (size_t)(file->end - next - 1));
            }
            next = next ? next + 1 : file->end;
        }
        starts[++n] = (size_t)(next - file->begin);
    }
    *count = n;
    return starts;
}
