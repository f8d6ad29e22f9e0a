#include "image/module_open.h"

#include "base/file.h"
#include "image/module_calls.h"

#include <dlfcn.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define PARTS_FILE "fathom_image.parts" /* beside the module */

static _Thread_local volatile sig_atomic_t loading_here;

bool image_is_loading_here(void) { return loading_here; }
void module_loading_here(bool is) { loading_here = is; }

/* The loader of libraries tells by its words alone what it lacked. */
static fathom_status status_of(const char *error) {
    static const char *const words[] = {"out of memory", "annot allocate", "cannot create",
                                        "cannot map",    "failed to map",  "Too many open files"};
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i) {
        if (strstr(error, words[i])) return FATHOM_OUT_OF_RESOURCES;
    }
    return FATHOM_INTERNAL;
}

/* Where the loader has no memory to look for the module, it says of the file, which is there, that it cannot
 * be opened, with no reason or that of some earlier failure. */
static bool was_not_looked_for(const char *path, const char *error) {
    static const char says[] = ": cannot open shared object file", stale[] = ": No such file or directory";
    size_t length = strlen(path);
    if (strncmp(error, path, length) != 0 || strncmp(error + length, says, sizeof says - 1) != 0)
        return false;
    const char *reason = error + length + sizeof says - 1;
    return (!*reason || strcmp(reason, stale) == 0) && access(path, R_OK) == 0;
}

static void say_why_not(module_trouble *why, const char *path, const char *error) {
    if (!error)
        module_trouble_say(why, FATHOM_OUT_OF_RESOURCES, "%s", path);
    else if (was_not_looked_for(path, error))
        module_trouble_say(why, FATHOM_OUT_OF_RESOURCES, "out of memory: %s was not looked for", path);
    else
        module_trouble_say(why, status_of(error), "%s", error);
}

/* The libraries that the module needs, one by one, from those up that need no others. A dlopen() looks for
 * each symbol of each library it brings among all that it brings, and the module's are 260, most of whose
 * symbols are their own: so loaded, each looks among those that it needs, and all take half of the time. A
 * name that is wrong by now, or a library that leans on its user's, is left for the module to bring. */
static void load_parts(const char *module, const atomic_bool *closing) {
    char *path = file_beside(module, PARTS_FILE), name[256];
    FILE *list = path ? fopen(path, "re") : NULL;
    while (list && !atomic_load(closing) && fgets(name, sizeof name, list)) {
        name[strcspn(name, "\n")] = '\0';
        if (*name) dlopen(name, RTLD_NOW | RTLD_LOCAL);
    }
    if (list) fclose(list);
    free(path);
}

/* While they are loaded, many of the module's libraries end the process where memory is lacking. What they
 * take is asked for beforehand. */
#define LOADING ((size_t)64 << 20)

static bool has_memory(module_trouble *why) {
    void *room = mmap(NULL, LOADING, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (room != MAP_FAILED) return munmap(room, LOADING) == 0;
    module_trouble_say(why, FATHOM_OUT_OF_RESOURCES, "out of memory: loading it takes %zu bytes", LOADING);
    return false;
}

/* NULL: the loader of libraries tells why. */
static void *open_library(const char *path, const atomic_bool *closing) {
    module_loading_here(true);
    load_parts(path, closing);
    void *library = atomic_load(closing) ? NULL : dlopen(path, RTLD_NOW | RTLD_LOCAL);
    module_loading_here(false);
    return library;
}

const image_module *module_open(const atomic_bool *closing, module_trouble *why) {
    char path[PATH_MAX];
    if (!module_find(path, why) || !has_memory(why)) return NULL;
    void *library = open_library(path, closing);
    if (!library && atomic_load(closing)) {
        module_trouble_say(why, FATHOM_INTERNAL, "the process is leaving");
        return NULL;
    }
    const image_module *module = library ? dlsym(library, IMAGE_MODULE_SYMBOL) : NULL;
    if (module && module->version == IMAGE_MODULE_VERSION) return module_calls(module);
    if (!module) {
        say_why_not(why, path, dlerror());
    } else {
        module_trouble_say(why, FATHOM_INTERNAL, "%s: is of another build: version %u, expected %d", path,
                           module->version, IMAGE_MODULE_VERSION);
    }
    if (library) dlclose(library);
    return NULL;
}
