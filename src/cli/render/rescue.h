/* A place for pixels whose own file cannot be written. */
#ifndef CLI_RESCUE_H
#define CLI_RESCUE_H

#include <fathom/render.h>

/* Writes the film as plain EXR beside `path`, which is not to be or could not be written, or else in the
 * working folder, in $TMPDIR or in /tmp: "out.png" becomes "out.rescue.exr", or the first of
 * "out.rescue-2.exr"… that is not there yet. Says where, or that there is no place. which: of the pixels, in
 * the message. */
void rescue_film(fathom_context *context, const fathom_film *film, const char *path, const char *which);

#endif
