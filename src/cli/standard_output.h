/* Standard output in place of a file: "-o -", "-o exr:-", "--stats -". Then whatever else is printed there,
 * by this program or by a library, goes to stderr. */
#ifndef CLI_STANDARD_OUTPUT_H
#define CLI_STANDARD_OUTPUT_H

#include "cli/args.h"

#include <fathom/base.h>

/* Reader of an option's values as take_list(). "-", which is PNG, and "png:-", "exr:-" and so on become names
 * of the program's own with that extension, until standard_output_begin(). */
bool take_output(const args_option *option, const char *value, void *field, args_problem *problem);

/* "-": the name of a file that is no image. */
bool standard_output_is_named(const char *path);

/* FATHOM_BAD_USAGE when two of the images and the `count` other files (of which some may be NULL) are to go
 * there, or an image and it is a terminal. Puts the path of a temporary file in place of the image's name; it
 * may be called again for a list that was read again. Ends with standard_output_end(). */
fathom_status standard_output_begin(fathom_context *context, args_list *images, const char *const *files,
                                    size_t count);

/* Once image `index` is written to `path`: copies the file if it is the one for standard output, and removes
 * it. FATHOM_OUT_OF_RESOURCES: it cannot be written. */
fathom_status standard_output_deliver(fathom_context *context, size_t index, const char *path);
/* The path, or what stands for it in messages and names of other files: "stdout.png". */
const char *standard_output_shown(const args_list *images, size_t index);

/* All bytes of a file that is no image, after standard_output_begin(). */
fathom_status standard_output_put(fathom_context *context, const char *bytes, size_t size);

void standard_output_end(void);

#endif
