#include "cli/render/exhausted.h"

extern "C" {
#include "cli/log.h"
}

#include <fathom/file.h>

#include <atomic>
#include <cstdio>
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

/* Allocates no memory. */
[[noreturn]] static void leave(fathom_status status, const char *text) {
    log_line(LOG_ERROR, text);
    fathom_file_abandon_all();
    _exit(status);
}

static void on_refusal() {
    was_refused = true;
    void *spare = reserve.exchange(nullptr);
    if (!spare) leave(FATHOM_OUT_OF_RESOURCES, "out of memory");
    munmap(spare, RESERVE);
}

/* True if the exception means lack of memory or threads. If TBB's own malloc() fails, its destructors throw
 * missing_wait, which hides the bad_alloc; missing_wait has no other cause here. A thread that cannot be
 * created gives a system_error, or TBB's own message. */
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
            char text[512];
            std::snprintf(text, sizeof text, "internal error: a library failed: %s", e.what());
            if (!is_lack(e)) leave(FATHOM_INTERNAL, text);
        } catch (...) {
            leave(FATHOM_INTERNAL, "internal error: a library failed");
        }
    }
    leave(FATHOM_OUT_OF_RESOURCES, "out of memory or threads");
}

void exhausted_watch() {
    void *spare = mmap(nullptr, RESERVE, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (spare != MAP_FAILED) reserve = spare;
    std::set_new_handler(on_refusal);
    std::set_terminate(on_terminate);
}
