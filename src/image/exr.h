/* OpenEXR without OpenEXR: for pixels that have to be saved when nothing else works. */
#ifndef IMAGE_EXR_H
#define IMAGE_EXR_H

#include "image/image.h"

/* As image_write() to .exr, but by nothing more than the C library: without compression, all colours as
 * 32-bit floats. Ten times as large, and in memory no more than a row. FATHOM_OUT_OF_RESOURCES. */
fathom_status exr_write_plain(fathom_context *context, const image *img, const char *path);

#endif
