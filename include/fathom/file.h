/* Output files of any kind: checked before the work begins, protected from being read as input, and
 * written whole or not at all. */
#ifndef FATHOM_FILE_H
#define FATHOM_FILE_H

#include <fathom/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* FATHOM_OUT_OF_RESOURCES when writing would fail: `path` is a folder or a device, its folder is missing,
 * full or not writable, or an existing file may not be written to or replaced. Calls
 * fathom_file_remove_left_over(). */
FATHOM_API fathom_status fathom_file_check(fathom_context *context, const char *path);

/* From now on, reading one of these files with this context is FATHOM_BAD_USAGE, by any spelling of its
 * path. Files that do not exist yet are not protected. count 0: everything may be read again. */
FATHOM_API fathom_status fathom_file_protect(fathom_context *context, const char *const *paths, size_t count);

/* Writes a whole file or none, even if the process is killed or the machine stops: bytes go to a temporary
 * file next to `path` ("out.fathom-tmp4711.txt" for "out.txt"), which is renamed once they are on the disk.
 * An existing file is replaced and its rights are kept; a symbolic link is replaced, not followed.
 * FATHOM_OUT_OF_RESOURCES. All files that Fathom writes are written so. */
FATHOM_API fathom_status fathom_file_write(fathom_context *context, const char *path, const void *bytes,
                                           size_t size);

/* Removes the temporary files of `path` that a killed process left and no living one is writing to. */
FATHOM_API void fathom_file_remove_left_over(const char *path);
/* Removes the temporary files of this process. Only for a signal handler that is about to end the process. */
FATHOM_API void fathom_file_abandon_all(void);
/* Adds a file of the caller to those that fathom_file_abandon_all() removes, or takes it off again. The
 * caller keeps the path. */
FATHOM_API void fathom_file_abandon_also(char *path);
FATHOM_API void fathom_file_abandon_no_more(char *path);

#ifdef __cplusplus
}
#endif
#endif
