/* Bytes of files. */
#ifndef BASE_FILE_H
#define BASE_FILE_H

#include "base/status.h"

/* A file mapped for reading, or copied (fathom_context_copy_files()). At least FILE_PADDING zero bytes follow
 * the last one, so that text is terminated and Embree may read past a vertex buffer that ends with the file.
 */
#define FILE_PADDING 64
typedef struct file_map {
    const unsigned char *bytes;
    size_t size;     /* of the file */
    size_t hole;     /* where the first zeros begin that the disk does not store; `size`: nowhere */
    size_t reserved; /* of the mapping */
    struct file_record *record; /* of what is mapped; NULL: a copy, or nothing */
} file_map;

/* FATHOM_BAD_INPUT when the file is missing, unreadable, empty, or no file but a folder, a pipe or a device;
 * the message names it. FATHOM_OUT_OF_RESOURCES when memory or descriptors ran out. FATHOM_BAD_USAGE: it is
 * to be written (context_set_outputs()). */
fathom_status file_open(fathom_context *context, const char *path, file_map *out);
void file_close(file_map *map);
/* FATHOM_BAD_INPUT when the file under the mapping has been truncated or changed since it was opened, or may
 * have been: then what was read of it is worth nothing. The more often it is asked, the more it can tell
 * (file_witness.h). Any thread may. */
fathom_status file_check(fathom_context *context, const file_map *map);
/* Warns, once each time, of a file that was found to be written to and unchanged. */
void file_tell_touched(fathom_context *context, const file_map *map);
/* file_close(), after what was read with `status`: hands it on, or what file_check() has to say. */
fathom_status file_finish(fathom_context *context, file_map *map, fathom_status status);
/* Lets go of the memory under the bytes from `begin` to `end`, in whole pages: when they are next read they
 * come back from the system's cache of the file, or from the file. */
void file_rest(const file_map *map, size_t begin, size_t end);

/* Writes a whole file or none, whatever happens to the process or the machine: to a temporary name beside
 * `path`, "out.fathom-tmp4711.exr" for "out.exr", which is renamed once its bytes are on the disk. A file
 * that was there is replaced, and its rights are kept; so is a symbolic link, and what it leads to stays as
 * it is. Who is killed leaves that file behind: file_remove_left_over(). */
typedef struct file_writer file_writer;
fathom_status file_writer_open(fathom_context *context, const char *path, file_writer **out);
/* No file, but bytes in memory, for file_writer_put() alone; `name` stands for it in messages. */
fathom_status file_writer_open_memory(fathom_context *context, const char *name, file_writer **out);
/* Ends its life as commit does a file's: on FATHOM_OK `bytes` is to be released with free(). */
fathom_status file_writer_take(file_writer *writer, unsigned char **bytes, size_t *size);
/* The name of the temporary file, for libraries that write by name. */
const char *file_writer_temporary(const file_writer *writer);
/* The open temporary file, for those that write by offset and may read what they wrote; not together with
 * file_writer_put(). */
int file_writer_descriptor(const file_writer *writer);
/* Buffered; errors are kept and reported by file_writer_commit(). */
void file_writer_put(file_writer *writer, const void *bytes, size_t size);
/* Waits until what was put is on the disk; commit does so by itself. */
void file_writer_sync(file_writer *writer);
/* Either one ends the writer's life. Commit returns FATHOM_OUT_OF_RESOURCES when the disk is full. */
fathom_status file_writer_commit(file_writer *writer);
void file_writer_abort(file_writer *writer);
/* Removes the temporary files of all writers, for a signal handler that is about to end the process: safe to
 * call there, and nowhere else. */
void file_writer_abort_all(void);
/* That is to remove this file as well, until it is told to let it be. The path stays the caller's. */
void file_abort_also(char *path);
void file_abort_no_more(char *path);

/* Removes the temporary files of `path` that no living process, here or on another machine, is writing to. */
void file_remove_left_over(const char *path);

/* Keeps all others from the file that take its lock as well, in this process or another: FATHOM_BAD_USAGE for
 * them. On FATHOM_OK end with file_lock_release(); NULL is fine there. */
typedef struct file_lock file_lock;
fathom_status file_lock_take(fathom_context *context, const char *path, file_lock **out);
void file_lock_release(file_lock *lock);

/* FATHOM_OUT_OF_RESOURCES when file_writer_open() and the rename would fail: `path` is a folder or a device,
 * its folder does not exist or cannot be written to, or has no room for a page; a file that is there may not
 * be written to, or not be replaced. */
fathom_status file_check_writable(fathom_context *context, const char *path);

/* Extension without the dot, in lower case, "" when there is none. `out` has room for 16 bytes. */
void file_extension(const char *path, char out[16]);
/* The part of `path` behind its folder. */
const char *file_name(const char *path);
/* How much of `path` comes before the dot of its extension. */
size_t file_stem_length(const char *path);
/* How many bytes of a name are kept where at most so many may be: characters of UTF-8 stay whole. */
size_t file_name_cut(const char *name, size_t most);
/* The path of `name` as seen from the file `base`: beside it, unless name is absolute. Release with free().
 */
char *file_beside(const char *base, const char *name);
/* FATHOM_BAD_INPUT when `path`, which a file names as `name`, is absolute or leads out of the folder of the
 * file `top` ("": the working folder), and the context does not allow it. Links are followed first. What is
 * changed between this and file_open() is not guarded against: who can do that can change the files as well.
 */
fathom_status file_confine(fathom_context *context, const char *top, const char *path, const char *name);

#endif
