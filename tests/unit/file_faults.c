/* What the system may refuse about a file, or change under it, at each call: what comes of it, in which
 * words. The calls reach us by the linker: see tests/CMakeLists.txt. */
#include "base/file.h"

#include "unit_folder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>

/* ---- the fault ---- */

static struct {
    const char *call;   /* NULL: none */
    unsigned from, to;  /* which of its calls, from 1 */
    int error;          /* they fail with, or: */
    void (*then)(void); /* is done before each of them */
    unsigned met;
} fault;

static void fail_calls(const char *call, unsigned from, unsigned to, int error) {
    fault.call = call, fault.from = from, fault.to = to, fault.error = error;
    fault.then = NULL, fault.met = 0;
}

static void fail_call(const char *call, int error) { fail_calls(call, 1, 1, error); }

static void before_calls(const char *call, unsigned from, unsigned to, void (*then)(void)) {
    fail_calls(call, from, to, 0);
    fault.then = then;
}

static void no_fault(void) {
    assert_true(fault.met >= fault.from); /* it was met */
    fault.call = NULL;
}

static bool fails(const char *call) {
    if (!fault.call || strcmp(call, fault.call) != 0) return false;
    ++fault.met;
    if (fault.met < fault.from || fault.met > fault.to) return false;
    if (fault.then) {
        fault.then();
        return false;
    }
    errno = fault.error;
    return true;
}

#define WRAP(type, name, parameters, arguments, failed)                                                      \
    type __real_##name parameters;                                                                           \
    type __wrap_##name parameters;                                                                           \
    type __wrap_##name parameters { return fails(#name) ? (failed) : __real_##name arguments; }

WRAP(void *, calloc, (size_t count, size_t size), (count, size), NULL)
WRAP(int, fstat, (int descriptor, struct stat *out), (descriptor, out), -1)
WRAP(int, faccessat, (int at, const char *path, int mode, int flags), (at, path, mode, flags), -1)
WRAP(int, flock, (int descriptor, int operation), (descriptor, operation), -1)
WRAP(int, fsync, (int descriptor), (descriptor), -1)
WRAP(void *, mmap, (void *at, size_t size, int may, int flags, int descriptor, off_t from),
     (at, size, may, flags, descriptor, from), MAP_FAILED)
/* 0 is no error: the file ends there. */
WRAP(ssize_t, read, (int descriptor, void *to, size_t size), (descriptor, to, size), errno ? -1 : 0)
WRAP(size_t, fwrite, (const void *bytes, size_t size, size_t count, FILE *to), (bytes, size, count, to), 0)
WRAP(int, fflush, (FILE * stream), (stream), EOF)
WRAP(FILE *, open_memstream, (char **bytes, size_t *size), (bytes, size), NULL)

int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...) {
    return fails("open") ? -1 : __real_open(path, flags, 0666);
}

/* The stream is gone, whatever it says. */
int __real_fclose(FILE *stream);
int __wrap_fclose(FILE *stream);
int __wrap_fclose(FILE *stream) {
    int closed = __real_fclose(stream);
    return fails("fclose") ? EOF : closed;
}

/* ---- files ---- */

static void make(const char *path, const char *text) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

/* Opening `path` comes to this, and the message is the path and this text. */
static void fails_to_open(const char *path, fathom_status status, const char *text) {
    file_map map;
    char message[512];
    snprintf(message, sizeof message, "%s: %s", path, text);
    assert_int_equal(file_open(context, path, &map), status);
    if (text[0]) assert_string_equal(fathom_context_message(context), message);
    assert_null(map.bytes);
    no_fault();
}

UNIT_TEST(failures_to_open_are_reported) {
    const char *path = in_folder("a.bin");
    make(path, "0123456789");
    static const struct {
        const char *call;
        int error;
        fathom_status status;
        const char *text;
    } cases[] = {{"open", EMFILE, FATHOM_OUT_OF_RESOURCES, "Too many open files"},
                 {"open", ENFILE, FATHOM_OUT_OF_RESOURCES, "Too many open files in system"},
                 {"open", EACCES, FATHOM_BAD_INPUT, "Permission denied"},
                 {"fstat", EIO, FATHOM_BAD_INPUT, "Input/output error"},
                 {"mmap", ENOMEM, FATHOM_OUT_OF_RESOURCES, ""}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        fail_call(cases[i].call, cases[i].error);
        fails_to_open(path, cases[i].status, cases[i].text);
    }
    /* The first has room made, the second lays the file there. */
    fail_calls("mmap", 2, 2, ENODEV);
    fails_to_open(path, FATHOM_BAD_INPUT, "cannot be mapped: No such device");
    fail_calls("mmap", 2, 2, ENOMEM);
    fails_to_open(path, FATHOM_OUT_OF_RESOURCES, "cannot be mapped: Cannot allocate memory");
    unlink(path);
}

UNIT_TEST(failures_to_copy_are_reported) {
    const char *path = in_folder("a.bin");
    make(path, "0123456789");
    fathom_context_copy_files(context, true);
    fail_call("read", EIO);
    fails_to_open(path, FATHOM_BAD_INPUT, "Input/output error");
    fail_call("read", 0);
    fails_to_open(path, FATHOM_BAD_INPUT,
                  "was truncated while it was read: 0 bytes are left of 10; try again when it is whole");
    fail_call("read", EINTR);
    file_map map;
    assert_ok(context, file_open(context, path, &map));
    assert_memory_equal(map.bytes, "0123456789", 11);
    no_fault();
    file_close(&map);
    fathom_context_copy_files(context, false);
    unlink(path);
}

/* ---- a bus error that is not ours ---- */

static sigjmp_buf back;
static volatile sig_atomic_t asked;

static void jump(int number) {
    asked = number;
    siglongjmp(back, 1);
}
static void jump_with_info(int number, siginfo_t *info, void *machine) {
    (void)machine;
    if (info->si_signo == number) jump(number);
}

/* In a process of its own, in which no guard is yet: was the handler asked that was there before? */
static int ask_handler(bool with_info, bool sent, bool lacking) {
    struct sigaction action = {.sa_flags = SA_NODEFER};
    if (with_info)
        action.sa_sigaction = jump_with_info, action.sa_flags |= SA_SIGINFO;
    else
        action.sa_handler = jump;
    const char *path = in_folder("a.bin");
    make(path, "0123456789");
    fathom_context *own;
    file_map map;
    if (sigaction(SIGBUS, &action, NULL) != 0 || fathom_context_create(&own) != FATHOM_OK) return 2;
    fathom_guard_files();
    if (file_open(own, path, &map) != FATHOM_OK || truncate(path, 0) != 0) return 3;
    void *foreign = mmap(NULL, 4096, PROT_READ, MAP_PRIVATE, __real_open(path, O_RDONLY), 0);
    if (lacking) fail_call("mmap", ENOMEM);
    if (sigsetjmp(back, 1) == 0) {
        if (sent)
            raise(SIGBUS);
        else
            (void)*(volatile const unsigned char *)(lacking ? map.bytes : foreign);
        return 4;
    }
    file_close(&map);
    fathom_context_destroy(own);
    return asked == SIGBUS ? 0 : 5;
}

/* What is sent can be ignored, as it was before. */
static int ignore_sent(void) {
    if (signal(SIGBUS, SIG_IGN) == SIG_ERR) return 2;
    fathom_guard_files();
    return raise(SIGBUS);
}

static void ends_with_0(pid_t child) {
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
}

UNIT_TEST(other_bus_errors_reach_their_handler) {
    for (int k = 0; k < 8; ++k) {
        const bool with_info = k & 1, sent = k & 2, lacking = k & 4;
        if (sent && lacking) continue;
        fflush(NULL);
        pid_t child = fork();
        if (child == 0) exit(ask_handler(with_info, sent, lacking));
        ends_with_0(child);
    }
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) exit(ignore_sent());
    ends_with_0(child);
    unlink(in_folder("a.bin"));
}

/* ---- writing ---- */

static unsigned count_files(void) {
    DIR *directory = opendir(folder);
    unsigned count = 0;
    assert_non_null(directory);
    for (const struct dirent *entry; (entry = readdir(directory));) count += entry->d_name[0] != '.';
    closedir(directory);
    return count;
}

/* With the fault that is set, opening `path` to write or checking whether one may says so, and leaves
 * nothing. */
static void cannot_write(fathom_status call(fathom_context *, const char *), const char *path,
                         const char *why) {
    char message[512];
    snprintf(message, sizeof message, "%s: cannot be written: %s", path, why);
    assert_int_equal(call(context, path), FATHOM_OUT_OF_RESOURCES);
    assert_string_equal(fathom_context_message(context), message);
    if (fault.call) no_fault();
    assert_int_equal(count_files(), 0);
}

static fathom_status open_to_write(fathom_context *c, const char *path) {
    file_writer *writer;
    fathom_status status = file_writer_open(c, path, &writer);
    assert_true((writer != NULL) == (status == FATHOM_OK));
    file_writer_abort(writer); /* NULL is fine */
    return status;
}

UNIT_TEST(failures_to_begin_a_file_are_reported) {
    const char *path = in_folder("a.bin");
    fail_call("open", EDQUOT);
    cannot_write(open_to_write, path, "Disk quota exceeded");
    fail_call("calloc", ENOMEM);
    assert_int_equal(open_to_write(context, path), FATHOM_OUT_OF_RESOURCES);
    no_fault();
    /* No locks there are: it goes on without. */
    fail_calls("flock", 1, 1, ENOLCK);
    assert_ok(context, open_to_write(context, path));
    no_fault();
}

static void lose_temporary(void) {
    char name[256];
    snprintf(name, sizeof name, "%s/a.fathom-tmp%ld.bin", folder, (long)getpid());
    assert_int_equal(unlink(name), 0);
}

/* A name that another has is left to him, and so is one that was removed while it was locked, or may have
 * been; when all are taken, that is said. */
UNIT_TEST(temporary_names_in_use_are_skipped) {
    const char *path = in_folder("a.bin");
    file_writer *writer;
    before_calls("fstat", 1, 1, lose_temporary);
    assert_ok(context, file_writer_open(context, path, &writer));
    no_fault();
    assert_non_null(strstr(file_writer_temporary(writer), "-1.bin"));
    file_writer_abort(writer);
    assert_int_equal(count_files(), 0);
    fail_call("fstat", EIO);
    assert_ok(context, file_writer_open(context, path, &writer));
    no_fault();
    assert_non_null(strstr(file_writer_temporary(writer), "-1.bin"));
    file_writer_abort(writer);
    fathom_file_remove_left_over(path); /* the first is nobody's */
    assert_int_equal(count_files(), 0);
    fail_calls("flock", 1, 100, EWOULDBLOCK);
    assert_int_equal(file_writer_open(context, path, &writer), FATHOM_OUT_OF_RESOURCES);
    assert_non_null(
        strstr(fathom_context_message(context), "a.bin: cannot be written: Device or resource busy"));
    no_fault();
    fathom_file_remove_left_over(path);
    assert_int_equal(count_files(), 0);
}

static fathom_status write_all(fathom_context *c, const char *path) {
    file_writer *writer;
    assert_ok(c, file_writer_open(c, path, &writer));
    file_writer_put(writer, "0123456789", 10);
    return file_writer_commit(writer);
}

UNIT_TEST(failures_to_write_leave_nothing) {
    const char *path = in_folder("a.bin");
    fail_call("fwrite", ENOSPC);
    cannot_write(write_all, path, "No space left on device");
    fail_call("fwrite", 0); /* says nothing of why */
    cannot_write(write_all, path, "Input/output error");
    fail_call("fflush", ENOSPC);
    cannot_write(write_all, path, "No space left on device");
    fail_call("fsync", EIO);
    cannot_write(write_all, path, "Input/output error");
    static const int nothing_to_wait_for[] = {EINVAL, ENOTSUP, EROFS};
    for (size_t i = 0; i < sizeof nothing_to_wait_for / sizeof *nothing_to_wait_for; ++i) {
        fail_calls("fsync", 1, 2, nothing_to_wait_for[i]);
        assert_ok(context, write_all(context, path));
        no_fault();
    }
    unlink(path);
}

/* The file has its name by then, and keeps it: whether it is on the disk is not known. */
UNIT_TEST(failures_after_the_rename_keep_the_file) {
    const char *path = in_folder("a.bin");
    for (int closing = 0; closing < 2; ++closing) {
        if (closing)
            fail_call("fclose", EIO);
        else
            fail_calls("fsync", 2, 2, EIO);
        assert_int_equal(write_all(context, path), FATHOM_OUT_OF_RESOURCES);
        assert_non_null(
            strstr(fathom_context_message(context), "a.bin: cannot be written: Input/output error"));
        no_fault();
        assert_int_equal(count_files(), 1);
        assert_int_equal(unlink(path), 0);
    }
}

UNIT_TEST(failures_to_write_to_memory_are_reported) {
    file_writer *writer;
    unsigned char *bytes;
    size_t size;
    static const char *const calls[] = {"calloc", "open_memstream"};
    for (size_t i = 0; i < 2; ++i) {
        fail_call(calls[i], ENOMEM);
        assert_int_equal(file_writer_open_memory(context, "name", &writer), FATHOM_OUT_OF_RESOURCES);
        no_fault();
        assert_null(writer);
    }
    static const char *const later[] = {"fwrite", "fclose"};
    for (size_t i = 0; i < 2; ++i) {
        fail_call(later[i], ENOMEM);
        assert_ok(context, file_writer_open_memory(context, "name", &writer));
        file_writer_put(writer, "one", 3);
        assert_int_equal(file_writer_take(writer, &bytes, &size), FATHOM_OUT_OF_RESOURCES);
        no_fault();
        assert_true(!bytes && !size);
    }
}

UNIT_TEST(unwritable_paths_are_found_before_writing) {
    const char *path = in_folder("a.bin");
    fail_call("faccessat", EACCES);
    cannot_write(fathom_file_check, path, "its folder: Permission denied");
    fail_call("fwrite", ENOSPC);
    cannot_write(fathom_file_check, path, "No space left on device");
    fail_call("fflush", ENOSPC);
    cannot_write(fathom_file_check, path, "No space left on device");
    fail_call("open", EROFS);
    cannot_write(fathom_file_check, path, "Read-only file system");
    cannot_write(fathom_file_check, in_folder("no/a.bin"), "its folder does not exist");
    make(path, "x");
    assert_int_equal(fathom_file_check(context, in_folder("a.bin/a.bin")), FATHOM_OUT_OF_RESOURCES);
    assert_non_null(
        strstr(fathom_context_message(context), "a.bin/a.bin: cannot be written: its folder does not exist"));
    unlink(path);
}

/* Names like those of temporary files, of what is none. */
UNIT_TEST(only_temporary_files_are_removed) {
    const char *link = in_folder("a.fathom-tmp1.bin"), *inside = in_folder("a.fathom-tmp2.bin"),
               *file = in_folder("a.fathom-tmp3.bin");
    assert_int_equal(symlink("nowhere", link), 0);
    assert_int_equal(mkdir(inside, 0700), 0);
    make(file, "x");
    fail_calls("fstat", 1, 2, EIO);
    fathom_file_remove_left_over(in_folder("a.bin"));
    no_fault();
    assert_int_equal(count_files(), 3);
    fathom_file_remove_left_over(in_folder("a.bin"));
    assert_int_equal(count_files(), 2);
    assert_int_equal(access(file, F_OK), -1);
    fathom_file_remove_left_over(in_folder("no/a.bin"));
    unlink(link), rmdir(inside);
}

int main(void) { return unit_main(open_folder, remove_folder); }
