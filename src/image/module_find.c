#include "image/module_find.h"

#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <link.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/auxv.h>
#include <sys/stat.h>
#include <unistd.h>

#define MODULE_FILE "fathom/fathom_image.so"

/* Where the module may be, seen from the folder of the file that holds this code: libfathom.so in a library
 * folder, or a program in bin/. IMAGE_LIBRARY_FOLDER is where the installation puts libraries, seen from
 * where it puts programs; IMAGE_MULTIARCH is the system's name for the architecture, perhaps "". */
static const char *const places[] = {"", IMAGE_LIBRARY_FOLDER "/", "../lib/", "../lib/" IMAGE_MULTIARCH "/"};

/* The absolute path of the file that holds this code, or NULL. It is asked for once, and before the load
 * begins: dladdr1() waits for a dlopen() that is under way. The main program is known by its empty name in
 * the link map: the name it was called by may be anything. */
static pthread_once_t own_file_once = PTHREAD_ONCE_INIT;
static char own_file_room[PATH_MAX]; /* no memory can be lacking for it */
static const char *own_file_path;

static void find_own_file(void) {
    Dl_info info;
    struct link_map *map = NULL;
    if (!dladdr1((void *)(uintptr_t)&own_file_once, &info, (void **)&map, RTLD_DL_LINKMAP) || !map) return;
    own_file_path = realpath(map->l_name[0] ? map->l_name : "/proc/self/exe", own_file_room);
    /* Without /proc: as it was called, which is good for as long as the working folder stays. */
    const char *called = (const char *)(uintptr_t)getauxval(AT_EXECFN);
    if (!own_file_path && !map->l_name[0] && called) own_file_path = realpath(called, own_file_room);
}

static const char *own_file(void) {
    pthread_once(&own_file_once, find_own_file);
    return own_file_path;
}

void module_find_begin(void) { own_file(); }

void module_trouble_say(module_trouble *why, fathom_status status, const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(why->text, sizeof why->text, format, args);
    va_end(args);
    why->status = status;
}

/* A pipe would be waited for. */
static bool find_named(const char *named, char *path, module_trouble *why) {
    struct stat info;
    const bool found = realpath(named, path) && stat(path, &info) == 0;
    if (found && S_ISREG(info.st_mode)) return true;
    module_trouble_say(why, !found && errno == ENOMEM ? FATHOM_OUT_OF_RESOURCES : FATHOM_INTERNAL,
                       "$FATHOM_IMAGE_MODULE: %s: %s", named, found ? "expected a file" : strerror(errno));
    return false;
}

bool module_find(char *path, module_trouble *why) {
    const char *named = getenv("FATHOM_IMAGE_MODULE");
    if (named && named[0]) return find_named(named, path, why);
    const char *own = own_file();
    for (size_t i = 0; own && i < sizeof places / sizeof *places; ++i) {
        const char *slash = strrchr(own, '/');
        int length = snprintf(path, PATH_MAX, "%.*s/%s" MODULE_FILE, (int)(slash - own), own, places[i]);
        if (length < PATH_MAX && access(path, R_OK) == 0) return true;
    }
    module_trouble_say(why, FATHOM_INTERNAL,
                       "%s was found neither beside %s nor in the library folders near it; set "
                       "$FATHOM_IMAGE_MODULE to its path",
                       MODULE_FILE, own ? own : "(unknown program)");
    return false;
}
