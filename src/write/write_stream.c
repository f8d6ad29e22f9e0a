#include "base/text.h"
#include "base/threads.h"
#include "write/write.h"

#include <stdio.h>
#include <stdlib.h>

#define PIECE_BYTES ((size_t)1 << 18)
#define MOST_PIECES 256u

fathom_status write_stream_open(fathom_context *context, const char *path, write_stream *out) {
    unsigned threads = fathom_context_threads(context);
    *out = (write_stream){.context = context, .locale = uselocale((locale_t)0)};
    out->pieces = threads < MOST_PIECES / 4 ? 4 * threads : MOST_PIECES;
    out->buffer = malloc(out->pieces * PIECE_BYTES);
    out->sizes = malloc(out->pieces * sizeof *out->sizes);
    fathom_status status = FATHOM_OK;
    if (!out->buffer || !out->sizes) status = fail_memory(context, out->pieces * PIECE_BYTES);
    if (status == FATHOM_OK) status = file_writer_open(context, path, &out->file);
    if (status != FATHOM_OK) {
        free(out->buffer);
        free(out->sizes);
    }
    return status;
}

typedef struct items_job {
    write_stream *stream;
    write_format format;
    const void *user;
    size_t first, count, grain; /* items of this round; `grain` items per piece */
} items_job;

static void format_pieces(void *user, size_t begin, size_t end) {
    items_job *job = user;
    locale_t before = uselocale(job->stream->locale);
    for (size_t piece = begin; piece < end; ++piece) {
        size_t from = piece * job->grain, to = from + job->grain;
        if (to > job->count) to = job->count;
        char *out = job->stream->buffer + piece * PIECE_BYTES;
        job->stream->sizes[piece] = job->format(job->user, job->first + from, job->first + to, out);
    }
    uselocale(before);
}

void write_items(write_stream *s, size_t count, size_t most, write_format format, const void *user) {
    items_job job = {.stream = s, .format = format, .user = user, .grain = PIECE_BYTES / most};
    size_t round = job.grain * s->pieces;
    for (; job.first < count; job.first += job.count) {
        job.count = count - job.first < round ? count - job.first : round;
        size_t pieces = (job.count + job.grain - 1) / job.grain;
        loop_parallel(fathom_context_threads(s->context), pieces, 1, format_pieces, &job);
        for (size_t piece = 0; piece < pieces; ++piece)
            file_writer_put(s->file, s->buffer + piece * PIECE_BYTES, s->sizes[piece]);
    }
}

fathom_status write_stream_close(write_stream *s, fathom_status status) {
    if (status == FATHOM_OK)
        status = file_writer_commit(s->file);
    else
        file_writer_abort(s->file);
    free(s->buffer);
    free(s->sizes);
    return status;
}

/* ---- text ---- */

size_t write_integer(char *out, uint64_t value) {
    char digits[20];
    size_t count = 0;
    do digits[count++] = (char)('0' + value % 10);
    while (value /= 10);
    for (size_t i = 0; i < count; ++i) out[i] = digits[count - 1 - i];
    return count;
}

/* Writes digits · 10^last as a plain decimal number without trailing zeros; 10^8 <= digits < 10^9, -13 <=
 * last <= 0. */
static size_t put_decimals(char *out, uint32_t digits, int last) {
    char text[24];
    int count = 0, written = 0;
    for (; last < 0 && digits % 10 == 0; ++last) digits /= 10;
    for (; last < 0; ++last, digits /= 10) text[count++] = (char)('0' + digits % 10);
    int part = count;
    do text[count++] = (char)('0' + digits % 10);
    while (digits /= 10);
    while (count > part) out[written++] = text[--count];
    if (count) out[written++] = '.';
    while (count) out[written++] = text[--count];
    return (size_t)written;
}

/* Nine significant digits distinguish any two floats. The product with an exact power of ten has a relative
 * error of 2^-53, so the nine digits have an error of at most 1/2 + 2^-23 units in the last digit. Half the
 * distance between neighbouring floats is at least 2.9 such units, so the text reads back as the same
 * float. */
size_t write_float(char *out, float value) {
    static const double powers[] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13};
    double size = fabs((double)value);
    if (size == 0 || !(size >= 1e-5 && size < 1e8))
        return (size_t)snprintf(out, WRITE_NUMBER_BYTES, "%.9g", (double)value);
    int shift = 13; /* 10^8 <= size 10^shift < 10^9 */
    while (size * powers[shift] >= 1e9) --shift;
    uint32_t digits = (uint32_t)(size * powers[shift] + 0.5);
    size_t sign = value < 0;
    if (sign) *out = '-';
    return sign + put_decimals(out + sign, digits, -shift);
}

void write_quoted(file_writer *file, const char *text) {
    file_writer_print(file, "\"");
    while (*text) {
        unsigned code;
        size_t length = text_character(text, &code);
        if (length == 0)
            file_writer_print(file, "?");
        else if ((unsigned char)*text < 0x20)
            file_writer_print(file, "\\u%04x", (unsigned)*text);
        else
            file_writer_print(file, "%s%.*s", *text == '"' || *text == '\\' ? "\\" : "", (int)length, text);
        text += length ? length : 1;
    }
    file_writer_print(file, "\"");
}
