/* PNG by libpng. */
#ifndef IMAGE_WRITE_PNG_H
#define IMAGE_WRITE_PNG_H

#include "image/helper/module.h"

/* As the module's for other formats. Channels are R, G, B and perhaps A, stored as bytes. */
extern const image_writer_calls write_png_calls;

#endif
