/* Files: mapped for reading, written whole or not at all, locked, and their names. */
#pragma once

#include "base/file_name.h"
#include "base/status.h"

#include <fathom/file.h>

/* A file mapped for reading, or copied (fathom_context_copy_files()). At least FILE_PADDING zero bytes follow
 * the last byte, so text is terminated, and Embree may read past a vertex buffer at the end of the file. */
#define FILE_PADDING 64
typedef struct file_map {
    const unsigned char *bytes;
    size_t size;                /* of the file */
    size_t reserved;            /* of the mapping */
    struct file_record *record; /* of the mapped file; NULL: the file was copied, or none is open */
} file_map;

/* FATHOM_BAD_INPUT when the file is missing, unreadable, empty, or a folder, pipe or device;
 * FATHOM_OUT_OF_RESOURCES when memory or file descriptors run out; FATHOM_BAD_USAGE when the file is an
 * output (fathom_file_protect()). */
fathom_status file_open(fathom_context *context, const char *path, file_map *out);
void file_close(file_map *map);
/* FATHOM_BAD_INPUT when the file's size or modification time changed since it was opened. Any thread may call
 * it. */
fathom_status file_check(fathom_context *context, const file_map *map);
/* Checks the file with file_check() and closes it, after reading has ended with `status`. Returns the failure
 * of the check, else `status`. */
fathom_status file_finish(fathom_context *context, file_map *map, fathom_status status);
/* Drops the whole pages within [begin, end) from memory. Pages that are read again are loaded from the file.
 * Does nothing for a copy. */
void file_rest(const file_map *map, size_t begin, size_t end);

/* Writes a whole file or none, even if the process is killed or the machine stops: bytes go to a temporary
 * file next to `path` ("out.fathom-tmp4711.exr" for "out.exr"), which is renamed once they are on the disk.
 * An existing file is replaced and its permissions are kept; a symbolic link is replaced, not followed. A
 * killed process leaves the temporary file behind; fathom_file_remove_left_over() removes it. */
typedef struct file_writer file_writer;
fathom_status file_writer_open(fathom_context *context, const char *path, file_writer **out);
/* Writes to memory: there is no temporary file and no descriptor. Messages call the output `name`. */
fathom_status file_writer_open_memory(fathom_context *context, const char *name, file_writer **out);
/* Ends a writer to memory. On FATHOM_OK the caller frees `bytes`. */
fathom_status file_writer_take(file_writer *writer, unsigned char **bytes, size_t *size);
/* The name of the temporary file, for libraries that write by name. */
const char *file_writer_temporary(const file_writer *writer);
/* The descriptor of the open temporary file, for writing at offsets. Do not combine with
 * file_writer_put(). */
int file_writer_descriptor(const file_writer *writer);
/* Buffered; errors are kept and reported by file_writer_commit(). */
void file_writer_put(file_writer *writer, const void *bytes, size_t size);
/* Replaces bytes that were put, from the byte `at` on. */
void file_writer_put_at(file_writer *writer, uint64_t at, const void *bytes, size_t size);
void file_writer_print(file_writer *writer, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Waits until all bytes are on the disk. file_writer_commit() does this itself. */
void file_writer_sync(file_writer *writer);
/* Both end the writer. Commit returns FATHOM_OUT_OF_RESOURCES when writing failed, for example on a full
 * disk. */
fathom_status file_writer_commit(file_writer *writer);
void file_writer_abort(file_writer *writer);

/* Locks a file. Until file_lock_release(), every other file_lock_take() of it, in any process, returns
 * FATHOM_BAD_USAGE. file_lock_release() accepts NULL. */
typedef struct file_lock file_lock;
fathom_status file_lock_take(fathom_context *context, const char *path, file_lock **out);
void file_lock_release(file_lock *lock);

/* False, with errno, when the disk or memory is full. */
bool file_write_at(int descriptor, uint64_t offset, const void *bytes, size_t size);
/* A file in memory, without a name, that holds these bytes, for another process to read from its start. The
 * caller closes the descriptor. -1, with errno, when out of memory. */
int file_in_memory(const void *bytes, size_t size);

/* The path of `name` next to the file `base`, unless name is absolute. Release with free(). */
char *file_beside(const char *base, const char *name);
/* Finds a file whose path equals `path` from index `from` on as far as computers differ: in the case of
 * letters, in Latin-1 in place of UTF-8 (Windows), and in marks behind their letters (macOS). Each part of
 * the path matches exactly if possible, else the first match by strcmp() is taken. NULL: no such file, or out
 * of memory. Release with free(). */
char *file_of_any_case(const char *path, size_t from);
/* True if the ".." in a path lead above its start. Symbolic links are not followed. */
bool file_climbs_out(const char *path);
/* FATHOM_BAD_INPUT when `name`, as written in an input file, is an absolute path, or when `path`, to which it
 * was resolved, lies outside the folder of the file `top` ("": the working folder), unless the context allows
 * it. Symbolic links are followed. Does not guard against changes between this call and file_open(). */
fathom_status file_confine(fathom_context *context, const char *top, const char *path, const char *name);

/* Six files with the faces of a cube, named by one path with "<FACE>" in it. */
#define FILE_FACE "<FACE>"
enum { FILE_FACES = 6 };

/* The files of a path: the path itself, or the faces towards +x, -x, +y, -y, +z and -z. */
typedef struct file_faces {
    char *paths[FILE_FACES];
    unsigned count; /* 1 or FILE_FACES; after a failure 0 */
} file_faces;

/* "<FACE>" becomes px nx py ny pz nz, else posx negx posy negy posz negz, else right left top bottom front
 * back: the first of these whose first file exists. FATHOM_BAD_INPUT when none does, or another face is
 * missing. A path without "<FACE>" need not exist. Release with file_faces_close(). */
fathom_status file_faces_open(fathom_context *context, const char *path, file_faces *out);
void file_faces_close(file_faces *files);

/* `pattern` with px, nx, py, ny, pz or nz in place of each "<FACE>". Release with free(). NULL: no memory. */
char *file_face_name(const char *pattern, unsigned face);
