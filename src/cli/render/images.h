/* The files that get the pixels of a render: the named images; files next to them if the render was
 * interrupted, so that no finished image is lost; other places if they cannot be written. */
#ifndef CLI_IMAGES_H
#define CLI_IMAGES_H

#include "cli/render/render_options.h"

#include <limits.h>

/* True when writing them takes the image helper. */
bool images_need_helper(const render_options *options);

/* Before rendering: FATHOM_BAD_USAGE when an interrupted render would put an image where one of the `count`
 * files of the command goes, or its path would be too long. */
fathom_status images_check_partial(fathom_context *context, const args_list *outputs,
                                   const char *const *files, size_t count);
/* Likewise where --fireflies reweight puts its images, or when there is no place for one. */
fathom_status images_check_reweighted(fathom_context *context, const args_list *outputs,
                                      const char *const *files, size_t count);
/* Removes the partial images that killed renders left. */
void images_remove_left_over(const args_list *outputs);

typedef struct image_names {
    char names[ARGS_LIST_MAX][PATH_MAX];
} image_names;

/* Puts "out.partial.exr" in place of "out.exr". Release *room, which holds the names, with free(). */
fathom_status images_rename(fathom_context *context, args_list *outputs, image_names **room);

/* Writes all of them, even where one fails, and says what went wrong; "out.reweighted.exr", too, if the film
 * was rendered for it. */
fathom_status images_write(fathom_context *context, const fathom_film *film, const render_options *options);

/* fathom_film_rescue(), for a `path` that is not to be or could not be written. Says where the pixels are, or
 * that there is no place. which: of the pixels, in the message. */
void images_rescue(fathom_context *context, const fathom_film *film, const char *path, const char *which);

#endif
