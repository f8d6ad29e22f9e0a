#include "image/loader.h"

#include "base/file.h"
#include "base/pool.h"
#include "base/threads.h"
#include "image/rest.h"

#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <link.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define MODULE_FILE "fathom/fathom_image.so"
#define PARTS_FILE "fathom_image.parts" /* beside it */

/* Where the module may be, seen from the folder of the file that holds this code: libfathom.so in a library
 * folder, or a program in bin/. IMAGE_LIBRARY_FOLDER is where the installation puts libraries, seen from
 * where it puts programs; IMAGE_MULTIARCH is the system's name for the architecture, perhaps "". */
static const char *const places[] = {"", IMAGE_LIBRARY_FOLDER "/", "../lib/", "../lib/" IMAGE_MULTIARCH "/"};

/* Why there is no module; text: "" while there is no reason against it. */
typedef struct trouble {
    fathom_status status;
    char text[1024];
} trouble;

static struct {
    pthread_mutex_t lock; /* guards module; held while loading */
    const image_module *module;
    atomic_bool closing;
    trouble why;        /* the prefetch failed… */
    atomic_bool failed; /* …which it did */

    pthread_mutex_t thread_lock; /* guards the rest */
    bool thread_runs, thread_was_started;
    pthread_t thread;
    pid_t process;
} loader = {.lock = PTHREAD_MUTEX_INITIALIZER, .thread_lock = PTHREAD_MUTEX_INITIALIZER};

static _Thread_local volatile sig_atomic_t loading_here;

bool image_is_loading_here(void) { return loading_here; }

/* The absolute path of the file that holds this code, or NULL. It is asked for once, and before the load
 * begins: dladdr1() waits for a dlopen() that is under way. The main program is known by its empty name in
 * the link map: the name it was called by may be anything. */
static pthread_once_t own_file_once = PTHREAD_ONCE_INIT;
static char own_file_room[PATH_MAX]; /* no memory can be lacking for it */
static const char *own_file_path;

static void find_own_file(void) {
    Dl_info info;
    struct link_map *map = NULL;
    if (!dladdr1((void *)(uintptr_t)&loader, &info, (void **)&map, RTLD_DL_LINKMAP) || !map) return;
    own_file_path = realpath(map->l_name[0] ? map->l_name : "/proc/self/exe", own_file_room);
}

static const char *own_file(void) {
    pthread_once(&own_file_once, find_own_file);
    return own_file_path;
}

static void say(trouble *why, fathom_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
static void say(trouble *why, fathom_status status, const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(why->text, sizeof why->text, format, args);
    va_end(args);
    why->status = status;
}

/* The path of the module, in `path` of PATH_MAX; false with a reason when there is none. */
static bool find(char *path, trouble *why) {
    const char *named = getenv("FATHOM_IMAGE_MODULE");
    if (named && named[0]) {
        if (realpath(named, path)) return true;
        say(why, errno == ENOMEM ? FATHOM_OUT_OF_RESOURCES : FATHOM_INTERNAL, "$FATHOM_IMAGE_MODULE: %s: %s",
            named, strerror(errno));
        return false;
    }
    const char *own = own_file();
    for (size_t i = 0; own && i < sizeof places / sizeof *places; ++i) {
        const char *slash = strrchr(own, '/');
        int length = snprintf(path, PATH_MAX, "%.*s/%s" MODULE_FILE, (int)(slash - own), own, places[i]);
        if (length < PATH_MAX && access(path, R_OK) == 0) return true;
    }
    say(why, FATHOM_INTERNAL,
        "%s was found neither beside %s nor in the library folders near it; set "
        "$FATHOM_IMAGE_MODULE to its path",
        MODULE_FILE, own ? own : "(unknown program)");
    return false;
}

/* The loader of libraries tells by its words alone what it lacked. */
static fathom_status status_of(const char *error) {
    static const char *const words[] = {"out of memory", "annot allocate", "cannot create",
                                        "cannot map",    "failed to map",  "Too many open files"};
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i) {
        if (strstr(error, words[i])) return FATHOM_OUT_OF_RESOURCES;
    }
    return FATHOM_INTERNAL;
}

/* The libraries that the module needs, one by one, from those up that need no others. A dlopen() looks for
 * each symbol of each library it brings among all that it brings, and the module's are 260, most of whose
 * symbols are their own: so loaded, each looks among those that it needs, and all take half of the time. A
 * name that is wrong by now, or a library that leans on its user's, is left for the module to bring. */
static void load_parts(const char *module) {
    char *path = file_beside(module, PARTS_FILE), name[256];
    FILE *list = path ? fopen(path, "re") : NULL;
    while (list && !atomic_load(&loader.closing) && fgets(name, sizeof name, list)) {
        name[strcspn(name, "\n")] = '\0';
        if (*name) dlopen(name, RTLD_NOW | RTLD_LOCAL);
    }
    if (list) fclose(list);
    free(path);
}

/* While they are loaded, many of the module's libraries end the process where memory is lacking. What they
 * take is asked for beforehand. */
#define LOADING ((size_t)64 << 20)

static bool has_memory(trouble *why) {
    void *room = mmap(NULL, LOADING, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (room != MAP_FAILED) return munmap(room, LOADING) == 0;
    say(why, FATHOM_OUT_OF_RESOURCES, "out of memory: loading it takes %zu bytes", LOADING);
    return false;
}

/* NULL: the loader of libraries tells why. */
static void *open_module(const char *path) {
    loading_here = 1;
    load_parts(path);
    void *library = atomic_load(&loader.closing) ? NULL : dlopen(path, RTLD_NOW | RTLD_LOCAL);
    loading_here = 0;
    return library;
}

/* With loader.lock held. */
static void load(trouble *why) {
    char path[PATH_MAX];
    if (!find(path, why) || !has_memory(why)) return;
    void *library = open_module(path);
    if (!library && atomic_load(&loader.closing)) {
        say(why, FATHOM_INTERNAL, "the process is leaving");
        return;
    }
    const image_module *module = library ? dlsym(library, IMAGE_MODULE_SYMBOL) : NULL;
    if (!module) {
        const char *error = dlerror();
        say(why, error ? status_of(error) : FATHOM_OUT_OF_RESOURCES, "%s", error ? error : path);
    } else if (module->version != IMAGE_MODULE_VERSION) {
        say(why, FATHOM_INTERNAL, "%s: is of another build: version %u, expected %d", path, module->version,
            IMAGE_MODULE_VERSION);
    } else {
        loader.module = module;
    }
    if (library && !loader.module) dlclose(library);
}

fathom_status loader_module(fathom_context *context, const image_module **out) {
    trouble why = {.text = ""};
    pthread_mutex_lock(&loader.lock);
    if (!loader.module) load(&why);
    *out = loader.module;
    pthread_mutex_unlock(&loader.lock);
    if (*out) return FATHOM_OK;
    return fail(context, why.status, "image module: %s", why.text);
}

const image_module *loader_loaded(void) {
    pthread_mutex_lock(&loader.lock);
    const image_module *module = loader.module;
    pthread_mutex_unlock(&loader.lock);
    return module;
}

fathom_status image_prefetch_status(fathom_context *context) {
    if (!atomic_load(&loader.failed)) return FATHOM_OK;
    return fail(context, loader.why.status, "image module: %s", loader.why.text);
}

fathom_status loader_find(fathom_context *context) {
    trouble why = {.text = ""};
    char path[PATH_MAX];
    return find(path, &why) ? FATHOM_OK : fail(context, why.status, "image module: %s", why.text);
}

static void *prefetch(void *unused) {
    (void)unused;
    pthread_mutex_lock(&loader.lock);
    size_t before = rest_library_count();
    bool loads = !loader.module && !atomic_load(&loader.closing);
    if (loads) load(&loader.why);
    if (loads && !loader.module) atomic_store(&loader.failed, true);
    loads &= loader.module != NULL;
    pthread_mutex_unlock(&loader.lock);
    /* Beside a build that may need the memory; whoever waits for the module need not wait for this. */
    if (loads) rest_libraries(before);
    return NULL;
}

static void join_prefetch(void) {
    if (loader.process != getpid()) return; /* a forked child has no such thread */
    atomic_store(&loader.closing, true);    /* what has not begun to load need not */
    pthread_mutex_lock(&loader.thread_lock);
    if (loader.thread_runs) pthread_join(loader.thread, NULL);
    loader.thread_runs = false;
    pthread_mutex_unlock(&loader.thread_lock);
}

static void join_prefetch_of_thread(void *unused) {
    (void)unused;
    join_prefetch();
}

/* The C library's side of C++'s thread_local destructors; glibc 2.18 and later, in no header. */
extern int __cxa_thread_atexit_impl(void (*destructor)(void *), void *object, void *library);

/* While a library is loaded, its constructors run and register destructors; exit() on another thread would
 * run those at the same time. A handler of atexit() comes too late, after them: the last registered runs
 * first. What exit() runs before all handlers are the thread's own destructors, so the thread that asked for
 * the prefetch, nearly always the one that leaves the process, waits there. The handler is for those that
 * exit elsewhere. */
static void join_at_exit(void) {
    loading_here = 1; /* it calls abort() where memory is lacking */
    __cxa_thread_atexit_impl(join_prefetch_of_thread, NULL, &loader);
    loading_here = 0;
    atexit(join_prefetch);
}

void image_prefetch(void) {
    pthread_mutex_lock(&loader.thread_lock);
    if (!loader.thread_was_started) {
        loader.process = getpid();
        own_file();
        join_at_exit();
        /* Signals are for the threads that know of them. */
        sigset_t old;
        threads_without_signals(&old);
        /* While the module loads, making a thread waits for it: reading and rendering find theirs made
         * already, one for each processor and one that watches. */
        pool_start(processor_count() + 1);
        loader.thread_runs = pthread_create(&loader.thread, NULL, prefetch, NULL) == 0;
        pthread_sigmask(SIG_SETMASK, &old, NULL);
        loader.thread_was_started = true;
    }
    pthread_mutex_unlock(&loader.thread_lock);
}
