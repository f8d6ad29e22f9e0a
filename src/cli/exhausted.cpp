#include "cli/exhausted.h"

extern "C" {
#include "base/file.h"
#include "cli/progress.h"
}

#include <fathom/base.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <sys/mman.h>
#include <system_error>
#include <typeinfo>
#include <unistd.h>

#define RESERVE (static_cast<std::size_t>(32) << 20)

static std::atomic<void *> reserve;
static std::atomic<bool> was_refused;

static void say(const char *text) {
    ssize_t ignored = write(STDERR_FILENO, text, std::strlen(text));
    static_cast<void>(ignored);
}

/* Asks for no memory. */
[[noreturn]] static void leave(fathom_status status, const char *text, const char *more) {
    say(progress_clear_text());
    say(text), say(more), say("\n");
    file_writer_abort_all();
    _exit(status);
}

static void on_refusal() {
    was_refused = true;
    void *spare = reserve.exchange(nullptr);
    if (!spare) leave(FATHOM_OUT_OF_RESOURCES, "fathom: out of memory", "");
    munmap(spare, RESERVE);
}

/* TBB throws from destructors where it lacked memory that it takes by malloc(), and that hides the bad_alloc:
 * its missing_wait has no other cause here. Threads that cannot be had are a system_error, or TBB's own
 * words. */
static bool is_lack(const std::exception &e) {
    return dynamic_cast<const std::bad_alloc *>(&e) || dynamic_cast<const std::system_error *>(&e) ||
           std::strstr(typeid(e).name(), "missing_wait") ||
           std::strstr(e.what(), "pthread_create has failed");
}

static void on_terminate() {
    if (!was_refused && std::current_exception()) {
        try {
            throw;
        } catch (const std::exception &e) {
            if (!is_lack(e)) leave(FATHOM_INTERNAL, "fathom: internal error: a library failed: ", e.what());
        } catch (...) {
            leave(FATHOM_INTERNAL, "fathom: internal error: a library failed", "");
        }
    }
    leave(FATHOM_OUT_OF_RESOURCES, "fathom: out of memory or threads", "");
}

void exhausted_watch() {
    void *spare = mmap(nullptr, RESERVE, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (spare != MAP_FAILED) reserve = spare;
    std::set_new_handler(on_refusal);
    std::set_terminate(on_terminate);
}
