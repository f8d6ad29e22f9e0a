#include "image/loader.h"

#include "base/pool.h"
#include "base/stall.h"
#include "base/threads.h"
#include "image/module_open.h"
#include "image/rest.h"

#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

static struct {
    pthread_mutex_t lock; /* guards the rest; not held while loading */
    pthread_cond_t ended; /* `loading` or `busy` is less now */
    const image_module *module;
    module_trouble why; /* the last load failed */
    unsigned loading;   /* 0, 1 */
    unsigned busy;      /* threads for it, which have something to do when the module is there */
    stall thread;       /* the last of them; none: whoever asked loads on its own */
    pid_t process;      /* in which it began */
    atomic_bool closing;
} loader = {.lock = PTHREAD_MUTEX_INITIALIZER, .ended = PTHREAD_COND_INITIALIZER};

static void load_now(void) {
    module_trouble why = {.status = FATHOM_OK};
    const image_module *module = module_open(&loader.closing, &why);
    pthread_mutex_lock(&loader.lock);
    loader.module = module;
    loader.why = why;
    loader.loading = 0;
    pthread_cond_broadcast(&loader.ended);
    pthread_mutex_unlock(&loader.lock);
}

/* `ahead`: of its use; nobody has asked for the module yet. */
static void *load_on_thread(void *ahead) {
    pthread_mutex_lock(&loader.lock);
    loader.thread = (stall){.thread = gettid()};
    pthread_mutex_unlock(&loader.lock);
    size_t before = rest_library_count();
    load_now();
    /* Beside a build that may need the memory; whoever waits for the module need not wait for this. */
    if (ahead && loader_loaded()) rest_libraries(before);
    pthread_mutex_lock(&loader.lock);
    --loader.busy;
    pthread_cond_broadcast(&loader.ended);
    pthread_mutex_unlock(&loader.lock);
    return NULL;
}

/* ---- waiting for it ---- */

/* Under the lock. A library that waits for itself, as GLib does where it lacks memory for the message that it
 * lacks memory, would have everyone wait for ever. */
static bool never_ends(void) { return loader.process != getpid() || stall_look(&loader.thread); }

/* Under the lock, while `*what` holds: false when it will for ever. */
static bool wait_while(const unsigned *what) {
    while (*what) {
        if (never_ends()) return false;
        struct timespec until;
        clock_gettime(CLOCK_MONOTONIC, &until);
        until.tv_nsec += 100000000;
        if (until.tv_nsec >= 1000000000) ++until.tv_sec, until.tv_nsec -= 1000000000;
        pthread_cond_clockwait(&loader.ended, &loader.lock, CLOCK_MONOTONIC, &until);
    }
    return true;
}

/* For a process that ends: false where the load never does. */
static bool wait_for_end(void) {
    if (loader.process != getpid()) return true; /* a forked child has no such thread */
    if (image_is_loading_here()) return true;    /* a library calls exit() */
    atomic_store(&loader.closing, true);         /* what has not begun to load need not */
    pthread_mutex_lock(&loader.lock);
    bool ended = wait_while(&loader.busy);
    pthread_mutex_unlock(&loader.lock);
    return ended;
}

static void leave_at_exit(int status, void *unused) {
    (void)unused;
    if (wait_for_end()) return;
    /* The dynamic loader's own end would wait for that thread. */
    fflush(NULL);
    _exit(status);
}

static void wait_at_end_of_thread(void *unused) {
    (void)unused;
    wait_for_end();
}

/* The C library's side of C++'s thread_local destructors; glibc 2.18 and later, in no header. */
extern int __cxa_thread_atexit_impl(void (*destructor)(void *), void *object, void *library);

/* While a library is loaded, its constructors run and register destructors; exit() on another thread would
 * run those at the same time. A handler of exit() comes too late, after them: the last registered runs
 * first. What exit() runs before all handlers are the thread's own destructors, so the thread that asked for
 * the load, nearly always the one that leaves the process, waits there. The handler is for those that
 * exit elsewhere, and where the wait has no end. */
static void wait_at_exit(void) {
    module_loading_here(true); /* it calls abort() where memory is lacking */
    __cxa_thread_atexit_impl(wait_at_end_of_thread, NULL, &loader);
    module_loading_here(false);
    on_exit(leave_at_exit, NULL);
}

/* ---- beginning it ---- */

static bool on_new_thread(void *(*run)(void *), void *user) {
    pthread_t thread;
    sigset_t old;
    threads_without_signals(&old); /* signals are for the threads that know of them */
    bool made = pthread_create(&thread, NULL, run, user) == 0;
    pthread_sigmask(SIG_SETMASK, &old, NULL);
    if (made) pthread_detach(thread);
    return made;
}

/* Under the lock, which it gives back for a while where no thread can be had. */
static void begin(bool ahead) {
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    loader.loading = 1;
    ++loader.busy;
    loader.process = getpid();
    loader.thread = (stall){.thread = 0};
    module_find_begin();
    pthread_once(&once, wait_at_exit);
    if (on_new_thread(load_on_thread, ahead ? &loader : NULL)) return;
    --loader.busy;
    pthread_mutex_unlock(&loader.lock);
    load_now();
    pthread_mutex_lock(&loader.lock);
}

void image_prefetch(void) {
    /* While the module loads, making a thread waits for it: reading and rendering find theirs made
     * already, one for each processor and one that watches. */
    pool_start(processor_count() + 1);
    pthread_mutex_lock(&loader.lock);
    if (!loader.module && !loader.loading) begin(true);
    pthread_mutex_unlock(&loader.lock);
}

/* ---- what came of it ---- */

static fathom_status fail_module(fathom_context *context, fathom_status status, const char *why) {
    return fail(context, status, "image module: %s", why);
}

static fathom_status fail_endless(fathom_context *context) {
    if (loader.process != getpid())
        return fail_module(context, FATHOM_INTERNAL, "the process was forked while it was loaded");
    return fail(
        context, FATHOM_OUT_OF_RESOURCES,
        "image module: a library has been waiting for itself for %d seconds while it was loaded, as some do "
        "when they lack memory",
        STALL_SECONDS);
}

fathom_status loader_module(fathom_context *context, const image_module **out) {
    pthread_mutex_lock(&loader.lock);
    if (!loader.module && !loader.loading) begin(false);
    bool ended = wait_while(&loader.loading);
    *out = loader.module;
    module_trouble why = loader.why;
    pthread_mutex_unlock(&loader.lock);
    if (*out) return FATHOM_OK;
    return ended ? fail_module(context, why.status, why.text) : fail_endless(context);
}

const image_module *loader_loaded(void) {
    pthread_mutex_lock(&loader.lock);
    const image_module *module = loader.module;
    pthread_mutex_unlock(&loader.lock);
    return module;
}

bool image_is_wanted(void) {
    pthread_mutex_lock(&loader.lock);
    bool wanted = loader.module || loader.loading;
    pthread_mutex_unlock(&loader.lock);
    return wanted;
}

fathom_status image_prefetch_status(fathom_context *context) {
    pthread_mutex_lock(&loader.lock);
    bool endless = loader.loading && never_ends();
    module_trouble why = loader.why;
    pthread_mutex_unlock(&loader.lock);
    if (endless) return fail_endless(context);
    return why.status == FATHOM_OK ? FATHOM_OK : fail_module(context, why.status, why.text);
}

fathom_status loader_find(fathom_context *context) {
    module_trouble why = {.status = FATHOM_OK};
    char path[PATH_MAX];
    return module_find(path, &why) ? FATHOM_OK : fail_module(context, why.status, why.text);
}
