#include "cli/outputs.h"

#include "base/file_name.h"
#include "cli/fail.h"
#include "cli/log.h"

#include <errno.h>
#include <fathom/file.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

bool outputs_is_exr(const char *path) { return file_ends_in(path, "exr"); }

size_t outputs_count_exr(const args_list *outputs) {
    size_t count = 0;
    for (size_t i = 0; i < outputs->count; ++i) count += outputs_is_exr(outputs->items[i]);
    return count;
}

/* ---- temporary files ---- */

fathom_status temporary_create(fathom_context *context, const char *ending, char path[TEMPORARY_PATH]) {
    const char *folder = getenv("TMPDIR");
    snprintf(path, TEMPORARY_PATH, "%s/fathom-XXXXXX%s", folder && *folder ? folder : "/tmp", ending);
    int file = mkstemps(path, (int)strlen(ending));
    if (file < 0) {
        fathom_status status =
            cli_fail_file(context, FATHOM_OUT_OF_RESOURCES, path,
                          "cannot be written; expected a folder for temporary files in $TMPDIR");
        path[0] = '\0';
        return status;
    }
    fathom_file_abandon_also(path);
    close(file);
    return FATHOM_OK;
}

void temporary_remove(char path[TEMPORARY_PATH]) {
    remove(path);
    fathom_file_abandon_no_more(path);
}

/* ---- standard output ---- */

/* Names for an image that goes to standard output, until it has a file. They are recognised by address,
 * because a file may have the same name. */
static const char *const names[] = {"stdout.png",  "stdout.exr", "stdout.jpg",
                                    "stdout.jpeg", "stdout.tif", "stdout.tiff"};
#define NAMES (sizeof names / sizeof *names)

static struct {
    int descriptor; /* the original standard output; 0: not replaced yet */
    const char *name;
    size_t index; /* index of the image */
    char path[TEMPORARY_PATH];
} out;

/* "-", "exr:-"; NULL: a file. */
static const char *name_of(const char *value) {
    if (strcmp(value, "-") == 0) return names[0];
    for (size_t i = 0; i < NAMES; ++i) {
        const char *extension = strrchr(names[i], '.') + 1;
        const size_t length = strlen(extension);
        if (strncmp(value, extension, length) == 0 && strcmp(value + length, ":-") == 0) return names[i];
    }
    return NULL;
}

static bool is_name(const char *item) {
    for (size_t i = 0; i < NAMES; ++i)
        if (item == names[i]) return true;
    return false;
}

bool outputs_is_standard(const char *path) { return path && (strcmp(path, "-") == 0 || is_name(path)); }

bool take_output(const args_option *option, const char *value, void *field, args_problem *problem) {
    const char *name = name_of(value);
    return take_list(option, name ? name : value, field, problem);
}

/* After this, anything printed to standard output goes to stderr, or nowhere with --log json, whose lines
 * programs read there. */
static fathom_status take_stream(fathom_context *context) {
    out.descriptor = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    const int other = log_is_json() ? open("/dev/null", O_WRONLY | O_CLOEXEC) : STDERR_FILENO;
    const bool fine = out.descriptor > 0 && other >= 0 && dup2(other, STDOUT_FILENO) >= 0;
    if (other > STDERR_FILENO) close(other);
    if (fine) return FATHOM_OK;
    return cli_fail(context, FATHOM_OUT_OF_RESOURCES, "standard output cannot be written: %s",
                    strerror(errno));
}

static fathom_status make_file(fathom_context *context) {
    if (out.path[0]) return FATHOM_OK;
    if (isatty(out.descriptor))
        return cli_fail(context, FATHOM_BAD_USAGE,
                        "-o -: standard output is a terminal; expected a pipe or a file, as in -o - >%s",
                        out.name);
    return temporary_create(context, strrchr(out.name, '.'), out.path);
}

fathom_status standard_output_begin(fathom_context *context, args_list *images, const char *const *files,
                                    size_t count) {
    size_t named = 0;
    out.name = NULL;
    for (size_t i = 0; i < images->count; ++i)
        if (is_name(images->items[i])) ++named, out.index = i, out.name = images->items[i];
    for (size_t i = 0; i < count; ++i) named += outputs_is_standard(files[i]);
    if (!named) return FATHOM_OK;
    if (named > 1)
        return cli_fail(context, FATHOM_BAD_USAGE,
                        "standard output is named twice; expected different outputs");
    fathom_status status = out.descriptor > 0 ? FATHOM_OK : take_stream(context);
    if (status != FATHOM_OK || !out.name) return status;
    status = make_file(context);
    if (status == FATHOM_OK) images->items[out.index] = out.path;
    return status;
}

const char *standard_output_shown(const args_list *images, size_t index) {
    return out.name && index == out.index ? out.name : images->items[index];
}

static fathom_status put_all(fathom_context *context, const char *bytes, size_t size) {
    while (size) {
        const ssize_t done = write(out.descriptor, bytes, size);
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0)
            return cli_fail(context, FATHOM_OUT_OF_RESOURCES, "standard output cannot be written: %s",
                            strerror(errno));
        bytes += done, size -= (size_t)done;
    }
    return FATHOM_OK;
}

static fathom_status cannot_read(fathom_context *context, const char *path) {
    return cli_fail_file(context, FATHOM_OUT_OF_RESOURCES, path, "cannot be read: %s", strerror(errno));
}

static fathom_status copy_file(fathom_context *context, const char *path, int file) {
    char bytes[1 << 15];
    for (;;) {
        const ssize_t size = read(file, bytes, sizeof bytes);
        if (size < 0 && errno == EINTR) continue;
        if (size < 0) return cannot_read(context, path);
        if (!size) return FATHOM_OK;
        fathom_status status = put_all(context, bytes, (size_t)size);
        if (status != FATHOM_OK) return status;
    }
}

fathom_status standard_output_deliver(fathom_context *context, size_t index, const char *path) {
    if (!out.name || index != out.index) return FATHOM_OK;
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) return cannot_read(context, path);
    fathom_status status = copy_file(context, path, file);
    close(file);
    unlink(path);
    return status;
}

void standard_output_end(void) {
    if (out.path[0]) temporary_remove(out.path);
    out.path[0] = '\0';
}

/* ---- files ---- */

/* Splits a path into the folder's real path and the name; also works for files that do not exist yet. */
static bool resolve(const char *path, char folder[PATH_MAX], const char **name) {
    const char *slash = strrchr(path, '/');
    *name = slash ? slash + 1 : path;
    if (!slash) return realpath(".", folder) != NULL;
    size_t length = (size_t)(slash - path) + 1;
    char above[PATH_MAX];
    if (length >= sizeof above) return false;
    memcpy(above, path, length);
    above[length] = '\0';
    return realpath(above, folder) != NULL;
}

bool outputs_are_same(const char *a, const char *b) {
    struct stat info_a, info_b;
    if (stat(a, &info_a) == 0 && stat(b, &info_b) == 0)
        return info_a.st_dev == info_b.st_dev && info_a.st_ino == info_b.st_ino;
    char folder_a[PATH_MAX], folder_b[PATH_MAX];
    const char *name_a, *name_b;
    return resolve(a, folder_a, &name_a) && resolve(b, folder_b, &name_b) && strcmp(name_a, name_b) == 0 &&
           strcmp(folder_a, folder_b) == 0;
}

fathom_status outputs_check_distinct(fathom_context *context, const char *const *outputs, size_t count,
                                     const char *input) {
    for (size_t i = 0; i < count; ++i) {
        if (input && outputs_are_same(outputs[i], input))
            return cli_fail_file(context, FATHOM_BAD_USAGE, outputs[i],
                                 "is the input; expected another name for the output");
        for (size_t k = 0; k < i; ++k) {
            if (outputs_are_same(outputs[i], outputs[k]))
                return cli_fail_file(context, FATHOM_BAD_USAGE, outputs[i],
                                     "the same file is named twice; expected different outputs");
        }
    }
    return fathom_file_protect(context, outputs, count);
}

fathom_status outputs_write(fathom_context *context, const char *path, const char *bytes, size_t size) {
    if (outputs_is_standard(path)) return put_all(context, bytes, size);
    return fathom_file_write(context, path, bytes, size);
}
