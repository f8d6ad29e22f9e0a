/* Exposure of images for the display, and warnings about images that show nothing. */
#pragma once

#include "cli/notes.h"
#include "cli/render/render_options.h"

/* Finds the exposure that options->exposure requests. Warns if the image is black, or if a file for the
 * display is nearly all black or white. `name` begins the warnings. scene: NULL if only its film is known, or
 * if the film is not finished. */
void brightness_settle(warning_list *warnings, const fathom_scene *scene, const char *name,
                       const fathom_film *film, render_options *options);

/* ", exposure -0.4" if one was chosen. */
void brightness_print(const render_options *options);
