/* A file's format, by its extension; its date; its view; and the writers of EXR and PNG. */
#pragma once

#include "image/helper/module.h"

/* FATHOM_BAD_USAGE: the extension is unknown. */
fathom_status output_format(fathom_context *context, const char *path, image_format *out);

/* FATHOM_BAD_USAGE: the image is too large for the format. */
fathom_status output_check_size(fathom_context *context, const char *path, image_format format,
                                uint32_t width, uint32_t height);
fathom_status output_check_exposure(fathom_context *context, const fathom_write_options *options);

/* Opens the view that the options name; close it with image_calls.view_close(). *srgb: see module.h. */
fathom_status output_open_view(fathom_context *context, const fathom_write_options *options, image_view **out,
                               bool *srgb);

typedef struct image_date {
    char text[24]; /* "2026:11:22 16:45:33" */
} image_date;

/* The date of $SOURCE_DATE_EPOCH, seconds since 1970 in UTC; empty when it is not set. FATHOM_BAD_USAGE if it
 * is not a valid number. */
fathom_status date_read(fathom_context *context, image_date *out);

typedef struct exr_options {
    bool float_color; /* colours as 32-bit floats, not halves */
    bool compressed;  /* by ZIP, 16 rows at a time; else the writer needs memory for one row only */
    unsigned threads;
    const char *date; /* "2026:11:22 16:45:33"; NULL: now */
} exr_options;

/* Puts a whole EXR file with all channels of the image. Errors of writing appear at file_writer_commit().
 * FATHOM_OUT_OF_RESOURCES: memory is lacking; the file is not complete. */
fathom_status exr_put(fathom_context *context, struct file_writer *file, const image *img,
                      const exr_options *options);

/* The PNG writer, which uses libpng, with the module's interface. Channels are R, G, B and optionally A,
 * stored as bytes. */
extern const image_writer_calls write_png_calls;
