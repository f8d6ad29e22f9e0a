#include "cli/exhausted.h"

extern "C" {
#include "base/file.h"
#include "cli/progress.h"
#include "image/image.h"
}

#include <fathom/base.h>

#include <atomic>
#include <csignal>
#include <cstdint>
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

/* ---- libraries in C ---- */

static void leave_loading() {
    leave(FATHOM_OUT_OF_RESOURCES,
          "fathom: image module: a library ended while it was loaded, as they do when they lack memory", "");
}

static void on_exit_of_library() {
    if (image_is_loading_here()) leave_loading();
    if (image_is_called_here()) {
        leave(FATHOM_OUT_OF_RESOURCES,
              "fathom: image module: a library ended the process, as some do when they lack memory", "");
    }
}

/* Raised by what this process does, not sent by another. */
static bool is_own(const siginfo_t *info) {
    return info->si_code > 0 || (info->si_code == SI_TKILL && info->si_pid == getpid());
}

/* Libraries that do not look at what they were given write through a null pointer, or near it: no page is
 * ever mapped there (vm.mmap_min_addr). Others end the process in so many words. */
static bool seems_lack(int number, const siginfo_t *info) {
    if (number == SIGSEGV) return reinterpret_cast<std::uintptr_t>(info->si_addr) < 65536;
    return number == SIGABRT || number == SIGTRAP;
}

static void end_of_library(int number, const siginfo_t *info) {
    if (!is_own(info)) return;
    if (image_is_loading_here()) leave_loading();
    image_call_failed_here(number, seems_lack(number, info));
    /* On a thread of its own: nobody could go on from there. */
    if (number == SIGSEGV && seems_lack(number, info) && image_is_called()) {
        leave(
            FATHOM_OUT_OF_RESOURCES,
            "fathom: image module: a thread used a null pointer while its libraries worked, as some do when "
            "they lack memory",
            "");
    }
}

static const int fatal[] = {SIGABRT, SIGTRAP, SIGSEGV, SIGFPE, SIGILL};
static struct sigaction before[sizeof fatal / sizeof *fatal];

/* Where no handler was, the signal comes again: from abort(), which insists, from the instruction, or from
 * here. */
static void on_fatal(int number, siginfo_t *info, void *machine) {
    end_of_library(number, info);
    file_writer_abort_all();
    for (std::size_t i = 0; i < sizeof fatal / sizeof *fatal; ++i) {
        if (fatal[i] != number) continue;
        static_cast<void>(sigaction(number, &before[i], nullptr));
        if (before[i].sa_flags & SA_SIGINFO)
            before[i].sa_sigaction(number, info, machine);
        else
            raise(number);
    }
}

static void watch_libraries() {
    struct sigaction action = {};
    action.sa_sigaction = on_fatal;
    action.sa_flags = SA_SIGINFO;
    sigemptyset(&action.sa_mask);
    for (std::size_t i = 0; i < sizeof fatal / sizeof *fatal; ++i)
        static_cast<void>(sigaction(fatal[i], &action, &before[i]));
    std::atexit(on_exit_of_library);
}

void exhausted_watch() {
    watch_libraries();
    void *spare = mmap(nullptr, RESERVE, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (spare != MAP_FAILED) reserve = spare;
    std::set_new_handler(on_refusal);
    std::set_terminate(on_terminate);
}
