/* Outputs of a command: files, standard output in place of one, temporary files. */
#ifndef CLI_OUTPUTS_H
#define CLI_OUTPUTS_H

#include "cli/args.h"

#include <fathom/base.h>

/* ---- files ---- */

/* FATHOM_BAD_USAGE when two of the outputs, or one of them and `input` (may be NULL), are the same file.
 * Reading one of them is FATHOM_BAD_USAGE afterwards. */
fathom_status outputs_check_distinct(fathom_context *context, const char *const *outputs, size_t count,
                                     const char *input);

/* True if both paths lead to one file, or would. */
bool outputs_are_same(const char *a, const char *b);

/* A file that is no image: whole or not at all. "-" is standard output. */
fathom_status outputs_write(fathom_context *context, const char *path, const char *bytes, size_t size);

/* ---- standard output: "-o -", "-o exr:-", "--stats -" ---- */

/* "-". Everything else printed there then goes to stderr. */
bool outputs_is_standard(const char *path);

/* Reader of an option's values as take_list(). "-", which is PNG, and "png:-", "exr:-" and so on become names
 * of the program's own with that extension, until standard_output_begin(). */
bool take_output(const args_option *option, const char *value, void *field, args_problem *problem);

/* Puts the path of a temporary file in place of the name of the image that goes there. FATHOM_BAD_USAGE when
 * two of the images and the `count` other files (NULL: none) go there, or an image and it is a terminal. May
 * be called again for a list that was read again. Ends with standard_output_end(). */
fathom_status standard_output_begin(fathom_context *context, args_list *images, const char *const *files,
                                    size_t count);
/* Once image `index` is written to `path`: copies the file if it is the one for standard output, and removes
 * it. FATHOM_OUT_OF_RESOURCES: it cannot be written. */
fathom_status standard_output_deliver(fathom_context *context, size_t index, const char *path);
/* The path, or what stands for it in messages and names of other files: "stdout.png". */
const char *standard_output_shown(const args_list *images, size_t index);
void standard_output_end(void);

/* ---- temporary files ---- */

#define TEMPORARY_PATH 4096

/* An empty file in $TMPDIR, its name with this ending. Removed by temporary_remove() or by a signal that ends
 * the process. */
fathom_status temporary_create(fathom_context *context, const char *ending, char path[TEMPORARY_PATH]);
void temporary_remove(char path[TEMPORARY_PATH]);

#endif
