#include "image/helper/helper.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <pthread.h>
#include <signal.h>
#include <spawn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#define HELPER_FILE "fathom/fathom-image"

typedef enum helper_state { HELPER_NONE, HELPER_STARTING, HELPER_READY, HELPER_FAILED } helper_state;

/* A helper process. It handles one request at a time; the first process handles all requests except
 * textures. */
typedef struct helper_process {
    pthread_mutex_t lock; /* guards the other members but `open`; held during a request */
    helper_state state;
    pid_t owner; /* the process that started it, to tell a forked child */
    pid_t child;
    int socket;
    wire_memory memory;
    uint64_t process;     /* id of the current start: index + 1, plus HELPERS_MOST for each restart */
    unsigned open;        /* number of open textures; atomic */
    char libraries[1024]; /* from its first reply */
    char why[1024];       /* why the last start failed */
} helper_process;

static helper_process helpers[HELPERS_MOST] = {[0 ... HELPERS_MOST - 1] = {.lock = PTHREAD_MUTEX_INITIALIZER,
                                                                           .socket = -1,
                                                                           .memory = {.descriptor = -1}}};

static void say(char text[1024], const char *format, ...) __attribute__((format(printf, 2, 3)));
static void say(char text[1024], const char *format, ...) {
    va_list list;
    va_start(list, format);
    vsnprintf(text, 1024, format, list);
    va_end(list);
}

/* ---- the program ---- */

/* Folders to search, relative to that of the file with this code: libfathom.so in a library folder, or a
 * program in bin/. IMAGE_LIBRARY_FOLDER: the installation's library folder, relative to its programs;
 * IMAGE_MULTIARCH: the system's name for the architecture, may be "". */
static const char *const places[] = {"", IMAGE_LIBRARY_FOLDER "/", "../lib/", "../lib/" IMAGE_MULTIARCH "/"};

/* Finds the file that contains this code. The main program has an empty name in the link map. */
static bool own_file(char path[PATH_MAX]) {
    Dl_info info;
    struct link_map *map = NULL;
    if (!dladdr1((void *)(uintptr_t)&helpers, &info, (void **)&map, RTLD_DL_LINKMAP) || !map) return false;
    return realpath(map->l_name[0] ? map->l_name : "/proc/self/exe", path) != NULL;
}

bool helper_find_file(const char *name, char path[PATH_MAX]) {
    char own[PATH_MAX];
    const bool known = own_file(own);
    for (size_t i = 0; known && i < sizeof places / sizeof *places; ++i) {
        const char *slash = strrchr(own, '/');
        int length = snprintf(path, PATH_MAX, "%.*s/%s%s", (int)(slash - own), own, places[i], name);
        if (length < PATH_MAX && access(path, R_OK) == 0) return true;
    }
    return false;
}

static bool find_program(char path[PATH_MAX], char text[1024]) {
    char own[PATH_MAX];
    if (helper_find_file(HELPER_FILE, path) && access(path, X_OK) == 0) return true;
    const bool known = own_file(own);
    say(text,
        "%s was found neither next to %s nor in the library folders near it; install Fathom again, "
        "or write .exr, or .png in the sRGB view: neither needs the helper",
        HELPER_FILE, known ? own : "(unknown program)");
    return false;
}

static fathom_status fail_helper(fathom_context *context, const char *text) {
    return fail(context, FATHOM_OUT_OF_RESOURCES, "image helper: %s", text);
}

fathom_status helper_find(fathom_context *context) {
    char path[PATH_MAX], text[1024];
    return find_program(path, text) ? FATHOM_OK : fail_helper(context, text);
}

/* ---- start and end ---- */

static double limit_seconds(void) {
    const char *named = getenv("FATHOM_IMAGE_SECONDS");
    double seconds = named ? strtod(named, NULL) : 0;
    return seconds > 0 && seconds <= 1e6 ? seconds : HELPER_SECONDS;
}

/* The caller holds the lock. Kills the helper and releases its resources. A forked child only releases its
 * copies. */
static void end(helper_process *h) {
    if (h->socket >= 0) close(h->socket);
    h->socket = -1;
    wire_memory_release(&h->memory);
    if (h->child > 0 && h->owner == getpid()) {
        kill(h->child, SIGKILL);
        while (waitpid(h->child, NULL, 0) < 0 && errno == EINTR) continue;
    }
    h->child = 0;
}

/* The caller holds the lock. Writes to `text` how the helper ended. */
static void say_end(helper_process *h, char text[1024], const char *doing) {
    int status;
    pid_t found = 0;
    for (int i = 0; i < 50 && found == 0; ++i) { /* the socket closes shortly before the process ends */
        found = waitpid(h->child, &status, WNOHANG);
        if (found == 0) usleep(2000);
    }
    if (found != h->child) {
        say(text, "the image helper ended %s", doing);
        return;
    }
    h->child = 0;
    const char *name = WIFSIGNALED(status) ? sigabbrev_np(WTERMSIG(status)) : NULL;
    if (name)
        say(text,
            "the image helper was ended by SIG%s %s: one of its libraries failed, as they do when memory is "
            "lacking",
            name, doing);
    else
        say(text, "the image helper ended %s: one of its libraries left, as some do when memory is lacking",
            doing);
}

/* Moves a descriptor to a number above those of the helper, with close-on-exec. */
static int move_up(int descriptor) {
    int moved = descriptor < 0 ? -1 : fcntl(descriptor, F_DUPFD_CLOEXEC, 10);
    if (descriptor >= 0) close(descriptor);
    return moved;
}

int helper_spawn(const char *path, const int descriptors[], int count, pid_t *child) {
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t none;
    int failed = posix_spawn_file_actions_init(&actions);
    if (failed) return failed;
    failed = posix_spawnattr_init(&attributes);
    if (!failed) {
        sigemptyset(&none);
        posix_spawnattr_setsigmask(&attributes, &none);
        posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
        for (int i = 0; i < count; ++i) {
            if (descriptors[i] < 0)
                posix_spawn_file_actions_addopen(&actions, i, "/dev/null", O_RDWR, 0);
            else
                posix_spawn_file_actions_adddup2(&actions, descriptors[i], i);
        }
        posix_spawn_file_actions_addclosefrom_np(&actions, count);
        failed = posix_spawn(child, path, &actions, &attributes, (char *[]){(char *)(uintptr_t)path, NULL},
                             environ);
        posix_spawnattr_destroy(&attributes);
    }
    posix_spawn_file_actions_destroy(&actions);
    return failed;
}

/* The caller holds the lock. */
static void start(helper_process *h) {
    char path[PATH_MAX];
    int sockets[2] = {-1, -1};
    end(h);
    h->state = HELPER_FAILED;
    if (!find_program(path, h->why)) return;
    bool made = socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets) == 0;
    h->socket = move_up(sockets[0]);
    int theirs = move_up(sockets[1]);
    h->memory.descriptor = move_up(memfd_create("fathom-image", MFD_CLOEXEC | MFD_ALLOW_SEALING));
    const int descriptors[] = {-1, -1, -1, [WIRE_SOCKET] = theirs, [WIRE_MEMORY] = h->memory.descriptor};
    /* Access to a mapping of a file that shrank would end this process. */
    made = made && h->socket >= 0 && theirs >= 0 && h->memory.descriptor >= 0 &&
           fcntl(h->memory.descriptor, F_ADD_SEALS, F_SEAL_SHRINK) == 0;
    const int failed = made ? helper_spawn(path, descriptors, WIRE_MEMORY + 1, &h->child) : errno;
    if (theirs >= 0) close(theirs);
    if (!failed) {
        h->state = HELPER_STARTING;
        h->owner = getpid();
        h->process += h->process ? HELPERS_MOST : (uint64_t)(h - helpers) + 1;
        return;
    }
    h->child = 0;
    say(h->why, "the image helper cannot be started: %s", strerror(failed));
    end(h);
}

/* The caller holds the lock. Receives the helper's first reply; with `wait`, waits for it. */
static void come_up(helper_process *h, bool wait) {
    wire_reply hello;
    int milliseconds = wait ? (int)(1000 * limit_seconds()) : 0;
    wire_result result = wire_receive(h->socket, &hello, sizeof hello, milliseconds, NULL);
    if (result == WIRE_LATE && !wait) return;
    hello.text[sizeof hello.text - 1] = '\0';
    h->state = HELPER_FAILED;
    if (result == WIRE_LATE)
        say(h->why, "the image helper was not ready after %g seconds", limit_seconds());
    else if (result == WIRE_GONE)
        say_end(h, h->why, "while it loaded its libraries");
    else if (hello.version != WIRE_VERSION)
        say(h->why, "the image helper is of another build");
    else if (hello.status != FATHOM_OK)
        say(h->why, "%s", hello.text);
    else {
        say(h->libraries, "%s", hello.text);
        h->state = HELPER_READY;
    }
    if (h->state == HELPER_FAILED) end(h);
}

/* The caller holds the lock. In a child of fork(), releases the parent's helper; the child starts its own. */
static void disown(helper_process *h) {
    if (h->state == HELPER_NONE || h->owner == getpid()) return;
    end(h);
    h->state = HELPER_NONE;
}

static void prefetch(helper_process *h) {
    pthread_mutex_lock(&h->lock);
    disown(h);
    if (h->state == HELPER_NONE || h->state == HELPER_FAILED) start(h);
    pthread_mutex_unlock(&h->lock);
}

void image_prefetch(void) { prefetch(&helpers[0]); }

void helper_prefetch(unsigned count) {
    for (unsigned i = 0; i < count && i < HELPERS_MOST; ++i) prefetch(&helpers[i]);
}

fathom_status image_prefetch_status(fathom_context *context) {
    char why[1024];
    helper_process *h = &helpers[0];
    if (pthread_mutex_trylock(&h->lock) != 0) return FATHOM_OK; /* another thread waits for the helper */
    disown(h);
    if (h->state == HELPER_STARTING) come_up(h, false);
    bool failed = h->state == HELPER_FAILED;
    if (failed) say(why, "%s", h->why);
    pthread_mutex_unlock(&h->lock);
    return failed ? fail_helper(context, why) : FATHOM_OK;
}

/* ---- asking ---- */

static fathom_status fail_text(helper_exchange *e, const char *text) {
    say(e->reply.text, "%s", text);
    return FATHOM_OUT_OF_RESOURCES;
}

/* The caller holds the lock. Makes the helper ready: starts it if necessary, and waits for its first
 * reply. */
static fathom_status be_ready(helper_process *h, helper_exchange *e) {
    disown(h);
    if (e->process && (h->state != HELPER_READY || e->process != h->process))
        return fail_text(e, "the image helper ended before");
    if (h->state == HELPER_NONE || h->state == HELPER_FAILED) start(h);
    if (h->state == HELPER_STARTING) come_up(h, true);
    return h->state == HELPER_READY ? FATHOM_OK : fail_text(e, h->why);
}

/* The caller holds the lock. */
static fathom_status exchange(helper_process *h, helper_exchange *e) {
    if (e->request.size && !wire_memory_reach(&h->memory, e->request.size, true))
        return fail_text(e, errno == ENOMEM || errno == ENOSPC ? "out of memory" : strerror(errno));
    if (e->bytes) memcpy(h->memory.bytes, e->bytes, e->request.size);
    wire_result result = WIRE_GONE;
    if (wire_send(h->socket, &e->request, sizeof e->request, e->descriptor))
        result = wire_receive(h->socket, &e->reply, sizeof e->reply, (int)(1000 * limit_seconds()), NULL);
    e->reply.text[sizeof e->reply.text - 1] = '\0';
    if (result == WIRE_CAME) return (fathom_status)e->reply.status;
    if (result == WIRE_LATE)
        say(e->reply.text, "the image helper gave no answer for %g seconds", limit_seconds());
    else
        say_end(h, e->reply.text, "at work");
    end(h);
    h->state = HELPER_NONE;
    return FATHOM_OUT_OF_RESOURCES;
}

/* The helper that owns the request's object; for process 0, the one with the fewest open textures of those
 * that the request may use. */
static helper_process *choose(const helper_exchange *e) {
    helper_process *best = &helpers[e->process ? (e->process - 1) % HELPERS_MOST : 0];
    for (unsigned i = 1; !e->process && i < e->helpers && i < HELPERS_MOST; ++i) {
        if (__atomic_load_n(&helpers[i].open, __ATOMIC_RELAXED) <
            __atomic_load_n(&best->open, __ATOMIC_RELAXED))
            best = &helpers[i];
    }
    return best;
}

static void count_open(helper_process *h, const helper_exchange *e, fathom_status status) {
    if (e->request.op == WIRE_TEXTURE && status == FATHOM_OK)
        __atomic_add_fetch(&h->open, 1, __ATOMIC_RELAXED);
    if (e->request.op == WIRE_END_TEXTURE) __atomic_sub_fetch(&h->open, 1, __ATOMIC_RELAXED);
}

fathom_status helper_ask(helper_exchange *e) {
    helper_process *h = choose(e);
    pthread_mutex_lock(&h->lock);
    e->reply = (wire_reply){.text = ""};
    fathom_status status = be_ready(h, e);
    if (status == FATHOM_OK) status = exchange(h, e);
    if (status == FATHOM_OK && e->take) {
        status = wire_memory_reach(&h->memory, e->reply.size, false)
                     ? e->take(e->user, h->memory.bytes, &e->reply)
                     : fail_text(e, "out of memory");
    }
    e->process = h->process;
    count_open(h, e, status);
    pthread_mutex_unlock(&h->lock);
    return status;
}

fathom_status image_libraries(fathom_context *context, char out[256]) {
    helper_exchange none = {.descriptor = -1};
    helper_process *h = &helpers[0];
    pthread_mutex_lock(&h->lock);
    fathom_status status = be_ready(h, &none);
    if (status == FATHOM_OK) snprintf(out, 256, "%.255s", h->libraries);
    pthread_mutex_unlock(&h->lock);
    return status == FATHOM_OK ? status : fail_helper(context, none.reply.text);
}
