/* Exposure of images for the display, and warnings about images that show nothing. */
#pragma once

#include "cli/notes.h"
#include "cli/render/render_options.h"

/* True if images for the display may get another exposure than 0 that is not given. */
bool brightness_is_open(const render_options *options);
/* Finds the exposure that options->exposure requests. Warns if the image is black, or if a file for the
 * display is nearly all black or white. `name` begins the warnings. scene: NULL if only its film is known, or
 * if the film is not finished. False: nothing in view is lit, so the exposure stays as it is. */
bool brightness_settle(warning_list *warnings, const fathom_scene *scene, const char *name,
                       const fathom_film *film, render_options *options);

/* ", in the studio, exposure -0.4": if the built-in studio lights the image, and if an exposure was chosen.
 */
void brightness_print(const render_options *options);
