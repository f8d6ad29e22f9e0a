/* What a file is to be: its format by its extension, its colours by a view. */
#ifndef IMAGE_OUTPUT_H
#define IMAGE_OUTPUT_H

#include "image/helper/module.h"

/* FATHOM_BAD_USAGE: the extension is unknown. */
fathom_status output_format(fathom_context *context, const char *path, image_format *out);

/* FATHOM_BAD_USAGE: the format does not hold so many pixels. */
fathom_status output_check_size(fathom_context *context, const char *path, image_format format,
                                uint32_t width, uint32_t height);
fathom_status output_check_exposure(fathom_context *context, const fathom_write_options *options);

bool output_needs_module(image_format format, const fathom_write_options *options);

/* The view that the options name, by OpenColorIO; to be closed by image_calls.view_close(). *srgb: see
 * module.h. */
fathom_status output_open_view(fathom_context *context, const fathom_write_options *options, image_view **out,
                               bool *srgb);

#endif
