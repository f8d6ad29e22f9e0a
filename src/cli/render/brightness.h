/* Warnings about images that show nothing, with an exposure that would. */
#ifndef CLI_BRIGHTNESS_H
#define CLI_BRIGHTNESS_H

#include "cli/notes.h"
#include "cli/render/render_options.h"

/* Finds the exposure for --exposure auto. */
void brightness_expose(const fathom_film *film, render_options *options);

/* Warns of an image that is black, or nearly all black or white in a file for the display. */
void brightness_warn(warning_list *warnings, const fathom_scene *scene, const fathom_film *film,
                     const render_options *options);

#endif
