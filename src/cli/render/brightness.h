/* How bright images for the display are, and warnings about those that show nothing. */
#ifndef CLI_BRIGHTNESS_H
#define CLI_BRIGHTNESS_H

#include "cli/notes.h"
#include "cli/render/render_options.h"

/* Finds the exposure that options->exposure asks for, and warns of an image that is black, or nearly all
 * black or white in a file for the display. `name` begins the warnings. scene: NULL when only its film is
 * known, or is not finished. */
void brightness_settle(warning_list *warnings, const fathom_scene *scene, const char *name,
                       const fathom_film *film, render_options *options);

/* ", exposure -0.4" if one was chosen. */
void brightness_print(const render_options *options);

#endif
