/* Bytes of files. */
#ifndef BASE_FILE_H
#define BASE_FILE_H

#include "base/status.h"

/* A file mapped for reading. At least FILE_PADDING zero bytes follow the last one, so that text is terminated
 * and Embree may read past a vertex buffer that ends with the file. */
#define FILE_PADDING 64
typedef struct file_map {
    const unsigned char *bytes;
    size_t size;     /* of the file */
    size_t reserved; /* of the mapping; for file_unmap */
} file_map;

/* FATHOM_BAD_INPUT when the file is missing, unreadable, a folder or empty; the message names it. */
fathom_status file_open(fathom_context *context, const char *path, file_map *out);
void file_close(file_map *map);
/* Lets go of the memory under the bytes from `begin` to `end`, in whole pages: when they are next read they
 * come back from the system's cache of the file, or from the file. */
void file_rest(const file_map *map, size_t begin, size_t end);

/* Writes a whole file or none: to a temporary name beside `path`, then renamed. */
typedef struct file_writer file_writer;
fathom_status file_writer_open(fathom_context *context, const char *path, file_writer **out);
/* The name of the temporary file, for libraries that write by name. */
const char *file_writer_temporary(const file_writer *writer);
/* The open temporary file, for those that write by offset; not together with file_writer_put(). */
int file_writer_descriptor(const file_writer *writer);
/* Buffered; errors are kept and reported by file_writer_commit(). */
void file_writer_put(file_writer *writer, const void *bytes, size_t size);
/* Either one ends the writer's life. Commit returns FATHOM_OUT_OF_RESOURCES when the disk is full. */
fathom_status file_writer_commit(file_writer *writer);
void file_writer_abort(file_writer *writer);
/* Removes the temporary files of all writers, for a signal handler that is about to end the process: safe to
 * call there, and nowhere else. */
void file_writer_abort_all(void);

/* FATHOM_OUT_OF_RESOURCES when file_writer_open() and the rename would fail: `path` is a folder or a device,
 * its folder does not exist or cannot be written to. */
fathom_status file_check_writable(fathom_context *context, const char *path);

/* Extension without the dot, in lower case, "" when there is none. `out` has room for 16 bytes. */
void file_extension(const char *path, char out[16]);
/* The path of `name` as seen from the file `base`: beside it, unless name is absolute. Release with free().
 */
char *file_beside(const char *base, const char *name);

#endif
