/* The files that receive the pixels of a render: the named images; if the render was interrupted, files next
 * to them, so that no finished image is overwritten; other places if these cannot be written. */
#pragma once

#include "cli/render/render_options.h"

#include <limits.h>

/* True if writing the images needs the image helper. */
bool images_need_helper(const render_options *options);

/* Call before rendering. FATHOM_BAD_USAGE if an interrupted render would write an image to one of the `count`
 * files of the command, or if that image's path would be too long. */
fathom_status images_check_partial(fathom_context *context, const args_list *outputs,
                                   const char *const *files, size_t count);
/* The same check for the images of --fireflies reweight. Also FATHOM_BAD_USAGE if an output is standard
 * output. */
fathom_status images_check_reweighted(fathom_context *context, const args_list *outputs,
                                      const char *const *files, size_t count);
/* Removes temporary files that killed renders left next to partial images. */
void images_remove_left_over(const args_list *outputs);
/* Removes the partial images of an interrupted render that was continued and has ended. */
void images_remove_partial(const args_list *outputs);

typedef struct image_names {
    char names[ARGS_LIST_MAX][PATH_MAX];
} image_names;

/* Replaces "out.exr" with "out.partial.exr". Release *room, which holds the names, with free(). */
fathom_status images_rename(fathom_context *context, args_list *outputs, image_names **room);

/* The files that a render writes: images, and statistics. A name of --fireflies reweight counts whether or
 * not the film has such an image. */
typedef struct image_files {
    const char *items[2 * ARGS_LIST_MAX + 1];
    size_t count;
    image_names room;
} image_files;
fathom_status images_files(fathom_context *context, const render_options *options, image_files *out);

/* Writes all images, even after a failure, and reports failures. Also writes "out.reweighted.exr" if the film
 * was rendered for it, and then sets the setting: `fathom merge` learns it from the film. */
fathom_status images_write(fathom_context *context, const fathom_film *film, render_options *options);
/* Image number i as messages show it, with those of --fireflies reweight after the others; NULL: there is
 * none. */
const char *images_shown(const render_options *options, size_t i, char room[PATH_MAX]);
/* Prints "out.exr, out.png". */
void images_print(const render_options *options);

/* Calls fathom_film_rescue() for a `path` that must not be, or could not be, written. Prints where the pixels
 * are, or that there was no place for them. which: names the pixels in the message. */
void images_rescue(fathom_context *context, const fathom_film *film, const char *path, const char *which);
