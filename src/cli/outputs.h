/* Outputs of a command: files, standard output, and temporary files. */
#pragma once

#include "cli/args.h"

#include <fathom/base.h>

/* ---- files ---- */

/* FATHOM_BAD_USAGE if two of the outputs, or an output and `input` (may be NULL), are the same file. After
 * this call, reading one of the outputs fails with FATHOM_BAD_USAGE. */
fathom_status outputs_check_distinct(fathom_context *context, const char *const *outputs, size_t count,
                                     const char *input);

/* True if the path ends in .exr. */
bool outputs_is_exr(const char *path);
size_t outputs_count_exr(const args_list *outputs);

/* True if both paths name the same file, which need not exist. */
bool outputs_are_same(const char *a, const char *b);

/* Writes a file that is not an image, whole or not at all. "-" is standard output. */
fathom_status outputs_write(fathom_context *context, const char *path, const char *bytes, size_t size);

/* ---- standard output: "-o -", "-o exr:-", "--stats -" ---- */

/* True for "-" and the internal names of take_output(). Once standard output is an output, everything else
 * printed there goes to stderr, or nowhere with --log json. */
bool outputs_is_standard(const char *path);

/* Reads an option's value like take_list(). "-" means PNG. "-", "png:-", "exr:-" and so on become internal
 * names with that extension, until standard_output_begin() replaces them. */
bool take_output(const args_option *option, const char *value, void *field, args_problem *problem);

/* Replaces the internal name of the image for standard output with the path of a temporary file.
 * FATHOM_BAD_USAGE: two of the images and the `count` other files (NULL: none) go to standard output, or an
 * image does and standard output is a terminal. May be called again for a list that was read again. Ends with
 * standard_output_end(). */
fathom_status standard_output_begin(fathom_context *context, args_list *images, const char *const *files,
                                    size_t count);
/* Call once image `index` is written to `path`. If it is the image for standard output, copies and removes
 * the file. FATHOM_OUT_OF_RESOURCES: cannot be written. */
fathom_status standard_output_deliver(fathom_context *context, size_t index, const char *path);
/* The path for messages and for names of other files; "stdout.png" for the image on standard output. */
const char *standard_output_shown(const args_list *images, size_t index);
void standard_output_end(void);

/* ---- temporary files ---- */

#define TEMPORARY_PATH 4096

/* Creates an empty file in $TMPDIR whose name has this ending. temporary_remove(), or a signal that ends the
 * process, removes it. */
fathom_status temporary_create(fathom_context *context, const char *ending, char path[TEMPORARY_PATH]);
void temporary_remove(char path[TEMPORARY_PATH]);
