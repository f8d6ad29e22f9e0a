#include "cli/standard_output.h"

#include "base/file.h"
#include "base/status.h"
#include "cli/log.h"
#include "cli/temporary.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Names of an image until there is a file for it: known by their address, whatever else is called that. */
static const char *const names[] = {"stdout.png",  "stdout.exr", "stdout.jpg",
                                    "stdout.jpeg", "stdout.tif", "stdout.tiff"};
#define NAMES (sizeof names / sizeof *names)

static struct {
    int descriptor; /* what was standard output; 0: it still is */
    const char *name;
    size_t index; /* of the image */
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
    for (size_t i = 0; i < NAMES; ++i) {
        if (item == names[i]) return true;
    }
    return false;
}

bool take_output(const args_option *option, const char *value, void *field, args_problem *problem) {
    const char *name = name_of(value);
    return take_list(option, name ? name : value, field, problem);
}

bool standard_output_is_named(const char *path) { return path && strcmp(path, "-") == 0; }

/* What others print there from now on is for people; programs that read lines of JSON get none of it. */
static fathom_status take_stream(fathom_context *context) {
    out.descriptor = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    const int other = log_is_json() ? open("/dev/null", O_WRONLY | O_CLOEXEC) : STDERR_FILENO;
    const bool fine = out.descriptor > 0 && other >= 0 && dup2(other, STDOUT_FILENO) >= 0;
    if (other > STDERR_FILENO) close(other);
    if (fine) return FATHOM_OK;
    return fail(context, FATHOM_OUT_OF_RESOURCES, "standard output cannot be written: %s", strerror(errno));
}

static fathom_status make_file(fathom_context *context) {
    if (out.path[0]) return FATHOM_OK;
    if (isatty(out.descriptor))
        return fail(context, FATHOM_BAD_USAGE,
                    "-o -: standard output is a terminal; expected a pipe or a file, as in -o - >%s",
                    out.name);
    return temporary_create(context, strrchr(out.name, '.'), out.path);
}

fathom_status standard_output_begin(fathom_context *context, args_list *images, const char *const *files,
                                    size_t count) {
    size_t named = 0;
    out.name = NULL;
    for (size_t i = 0; i < images->count; ++i) {
        if (is_name(images->items[i])) ++named, out.index = i, out.name = images->items[i];
    }
    for (size_t i = 0; i < count; ++i) named += standard_output_is_named(files[i]);
    if (!named) return FATHOM_OK;
    if (named > 1)
        return fail(context, FATHOM_BAD_USAGE, "standard output is named twice; expected different outputs");
    fathom_status status = out.descriptor > 0 ? FATHOM_OK : take_stream(context);
    if (status != FATHOM_OK || !out.name) return status;
    status = make_file(context);
    if (status == FATHOM_OK) images->items[out.index] = out.path;
    return status;
}

const char *standard_output_shown(const args_list *images, size_t index) {
    return out.name && index == out.index ? out.name : images->items[index];
}

fathom_status standard_output_put(fathom_context *context, const char *bytes, size_t size) {
    while (size) {
        const ssize_t done = write(out.descriptor, bytes, size);
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0)
            return fail(context, FATHOM_OUT_OF_RESOURCES, "standard output cannot be written: %s",
                        strerror(errno));
        bytes += done, size -= (size_t)done;
    }
    return FATHOM_OK;
}

fathom_status standard_output_deliver(fathom_context *context, size_t index, const char *path) {
    if (!out.name || index != out.index) return FATHOM_OK;
    file_map map;
    fathom_status status = file_open(context, path, &map);
    if (status != FATHOM_OK) return status;
    status = standard_output_put(context, (const char *)map.bytes, map.size);
    file_close(&map);
    unlink(path);
    return status;
}

void standard_output_end(void) {
    if (out.path[0]) temporary_remove(out.path);
    out.path[0] = '\0';
}
