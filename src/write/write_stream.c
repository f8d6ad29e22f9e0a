#include "base/threads.h"
#include "write/write.h"

#include <stdlib.h>

#define PIECE_BYTES ((size_t)1 << 18)
#define MOST_PIECES 256u

fathom_status write_stream_open(fathom_context *context, const char *path, write_stream *out) {
    unsigned threads = fathom_context_threads(context);
    *out = (write_stream){.context = context};
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
    size_t first, count, grain; /* of the items in this round; grain of them fill a piece */
} items_job;

static void format_pieces(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    items_job *job = user;
    for (size_t piece = begin; piece < end; ++piece) {
        size_t from = piece * job->grain, to = from + job->grain;
        if (to > job->count) to = job->count;
        char *out = job->stream->buffer + piece * PIECE_BYTES;
        job->stream->sizes[piece] = job->format(job->user, job->first + from, job->first + to, out);
    }
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

void write_bytes(write_stream *s, const void *bytes, size_t size) { file_writer_put(s->file, bytes, size); }

fathom_status write_stream_close(write_stream *s, fathom_status status) {
    if (status == FATHOM_OK)
        status = file_writer_commit(s->file);
    else
        file_writer_abort(s->file);
    free(s->buffer);
    free(s->sizes);
    return status;
}
