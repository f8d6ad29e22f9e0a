/* Files that appear whole or not at all: the order of what the disk is told, and what killed writers leave.
 */
#include "base/file.h"

#include "unit_folder.h"

#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* ---- what the system is told, by calls that the linker hands to us ---- */

static char calls[8];
static int sync_error;

int __real_fsync(int descriptor);
int __wrap_fsync(int descriptor);
int __real_rename(const char *from, const char *to);
int __wrap_rename(const char *from, const char *to);

static void note(char call) {
    size_t length = strlen(calls);
    if (length + 1 < sizeof calls) calls[length] = call;
}

int __wrap_fsync(int descriptor) {
    struct stat info;
    fstat(descriptor, &info);
    note(S_ISDIR(info.st_mode) ? 'D' : 'f');
    if (!sync_error) return __real_fsync(descriptor);
    errno = sync_error;
    return -1;
}

int __wrap_rename(const char *from, const char *to) {
    note('r');
    return __real_rename(from, to);
}

/* ---- a folder of the test's own ---- */

static char place[400];

static int set_up(void **state) {
    (void)state;
    snprintf(place, sizeof place, "%s", in_folder("a.bin"));
    memset(calls, 0, sizeof calls);
    sync_error = 0;
    return 0;
}

/* Files in the folder; removes them when asked to. */
static int count_files(bool remove_all) {
    DIR *stream = opendir(folder);
    int count = 0;
    for (const struct dirent *entry; (entry = readdir(stream));) {
        if (entry->d_name[0] == '.') continue;
        ++count;
        if (remove_all) unlink(in_folder(entry->d_name));
    }
    closedir(stream);
    return count;
}

static int tear_down(void **state) {
    (void)state;
    count_files(true);
    return 0;
}

static file_writer *begin(const char *text) {
    file_writer *writer;
    assert_ok(context, file_writer_open(context, place, &writer));
    file_writer_put(writer, text, strlen(text));
    return writer;
}

static void assert_holds(const char *text) {
    file_map map;
    assert_ok(context, file_open(context, place, &map));
    assert_int_equal(map.size, strlen(text));
    assert_memory_equal(map.bytes, text, map.size);
    file_close(&map);
}

static void make(const char *path) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fclose(file);
}

/* ---- laws ---- */

/* Bytes, then the name, then the folder that holds the name. */
UNIT_TEST(bytes_are_on_the_disk_before_the_name) {
    assert_ok(context, file_writer_commit(begin("one")));
    assert_string_equal(calls, "frD");
    assert_holds("one");
    assert_int_equal(count_files(false), 1);
}

UNIT_TEST(a_failing_disk_keeps_the_old_file) {
    assert_ok(context, file_writer_commit(begin("one")));
    sync_error = EIO;
    assert_int_equal(file_writer_commit(begin("two")), FATHOM_OUT_OF_RESOURCES);
    assert_non_null(strstr(fathom_context_message(context), "cannot be written"));
    assert_holds("one");
    assert_int_equal(count_files(false), 1);
}

UNIT_TEST(file_systems_without_sync_are_accepted) {
    sync_error = EINVAL;
    assert_ok(context, file_writer_commit(begin("one")));
    assert_holds("one");
}

UNIT_TEST(writers_of_one_file_do_not_interfere) {
    file_writer *first = begin("first"), *second = begin("second");
    assert_string_not_equal(file_writer_temporary(first), file_writer_temporary(second));
    assert_ok(context, file_writer_commit(first));
    assert_holds("first");
    assert_ok(context, file_writer_commit(second));
    assert_holds("second");
    assert_int_equal(count_files(false), 1);
}

UNIT_TEST(abort_leaves_nothing) {
    file_writer_abort(begin("one"));
    assert_int_equal(count_files(false), 0);
}

/* As whole as in a file, and nothing is there beside the memory. */
UNIT_TEST(memory_holds_the_bytes_written) {
    file_writer *writer;
    unsigned char *bytes;
    size_t size;
    assert_ok(context, file_writer_open_memory(context, "name", &writer));
    for (int i = 0; i < 100000; ++i) file_writer_put(writer, "0123456789", 10);
    assert_ok(context, file_writer_take(writer, &bytes, &size));
    assert_int_equal(size, 1000000);
    for (size_t i = 0; i < size; ++i) assert_int_equal(bytes[i], '0' + i % 10);
    free(bytes);
    assert_ok(context, file_writer_open_memory(context, "name", &writer));
    file_writer_put(writer, "one", 3);
    file_writer_abort(writer);
    assert_int_equal(count_files(false), 0);
    assert_string_equal(calls, "");
}

static mode_t mode_of(const char *path) {
    struct stat info;
    assert_int_equal(lstat(path, &info), 0);
    return info.st_mode;
}

UNIT_TEST(a_new_file_keeps_the_old_rights) {
    const mode_t before = umask(022);
    assert_ok(context, file_writer_commit(begin("one")));
    assert_int_equal(mode_of(place) & 07777, 0644);
    assert_int_equal(chmod(place, 04600), 0);
    file_writer *writer = begin("two");
    assert_int_equal(mode_of(file_writer_temporary(writer)) & 07777, 0600);
    assert_ok(context, file_writer_commit(writer));
    assert_int_equal(mode_of(place) & 07777, 0600);
    umask(before);
}

/* A name that others could foresee: the file that they put there is not written to, nor what leads elsewhere.
 */
UNIT_TEST(predicted_temporary_names_are_harmless) {
    const char *name = unit_text("a.fathom-tmp%ld.bin", (long)getpid());
    const char *other = unit_text("%s", in_folder("other"));
    for (int symbolic = 0; symbolic < 2; ++symbolic) {
        FILE *file = fopen(other, "w");
        assert_true(fputs("precious", file) >= 0 && fclose(file) == 0);
        assert_int_equal(symbolic ? symlink(other, in_folder(name)) : link(other, in_folder(name)), 0);
        assert_ok(context, file_writer_commit(begin("one")));
        assert_holds("one");
        struct stat info;
        assert_int_equal(stat(other, &info), 0);
        assert_int_equal(info.st_size, strlen("precious"));
        count_files(true);
    }
}

UNIT_TEST(a_link_is_replaced_and_its_target_stays) {
    const char *other = unit_text("%s", in_folder("other"));
    static const char *const targets[] = {"other", "nowhere", "a.bin"}; /* one leads to itself */
    for (size_t i = 0; i < sizeof targets / sizeof *targets; ++i) {
        make(other);
        assert_int_equal(symlink(targets[i], place), 0);
        assert_ok(context, fathom_file_check(context, place));
        assert_ok(context, file_writer_commit(begin("one")));
        assert_true(S_ISREG(mode_of(place)));
        assert_holds("one");
        struct stat info;
        assert_int_equal(stat(other, &info), 0);
        assert_int_equal(info.st_size, 0);
        assert_int_equal(count_files(true), 2);
    }
}

/* Every name that the system takes: what comes before the extension is left out of the temporary one. */
UNIT_TEST(the_longest_file_names_work) {
    char path[sizeof folder + 300], name[256];
    for (size_t stem = 200; stem < 252; ++stem) {
        /* Two bytes a letter, and one at the beginning for half of them. */
        size_t length = stem % 2;
        memset(name, 'x', sizeof name);
        for (; length < stem; length += 2) memcpy(name + length, "\u00e4", 2);
        snprintf(name + length, sizeof name - length, ".exr");
        snprintf(path, sizeof path, "%s/%s", folder, name);
        file_writer *writer;
        assert_ok(context, file_writer_open(context, path, &writer));
        const char *temporary = file_writer_temporary(writer);
        assert_string_equal(temporary + strlen(temporary) - 4, ".exr");
        const char *kept = unit_text("%s", temporary);
        assert_true(strchr("x\xa4", strstr(kept, ".fathom")[-1])); /* no half of a letter */
        assert_ok(context, file_writer_commit(writer));
        make(kept);
        assert_int_equal(count_files(false), 2);
        fathom_file_remove_left_over(path);
        assert_int_equal(count_files(true), 1);
    }
}

/* Only who has no say over the file but may write to its folder learns of it in the end otherwise. */
UNIT_TEST(protected_files_are_refused) {
    assert_ok(context, file_writer_commit(begin("one")));
    assert_int_equal(chmod(place, 0444), 0);
    assert_int_equal(chmod(folder, 01777), 0);
    const bool root = geteuid() == 0;
    if (root) assert_int_equal(seteuid(65534), 0);
    assert_int_equal(fathom_file_check(context, place), FATHOM_OUT_OF_RESOURCES);
    assert_non_null(strstr(fathom_context_message(context), "a.bin: cannot be written: Permission denied"));
    if (root) {
        assert_int_equal(seteuid(0), 0);
        assert_int_equal(chmod(place, 0666), 0);
        assert_int_equal(seteuid(65534), 0);
        assert_int_equal(fathom_file_check(context, place), FATHOM_OUT_OF_RESOURCES);
        assert_non_null(strstr(fathom_context_message(context), "Operation not permitted"));
        assert_int_equal(seteuid(0), 0);
    }
    assert_holds("one");
}

UNIT_TEST(abort_removes_added_files) {
    char path[400];
    snprintf(path, sizeof path, "%s", in_folder("other"));
    for (int kept = 0; kept < 2; ++kept) {
        make(path);
        fathom_file_abandon_also(path);
        if (kept) fathom_file_abandon_no_more(path);
        fathom_file_abandon_all();
        assert_int_equal(access(path, F_OK) == 0, kept);
        fathom_file_abandon_no_more(path);
    }
}

UNIT_TEST(only_left_over_files_are_removed) {
    file_writer *alive = begin("one");
    make(in_folder("a.fathom-tmp1.bin"));
    make(in_folder("a.fathom-tmp123-4.bin"));
    static const char *const others[] = {"a.bin.bak",         "a.tmp1.bin",        "a.fathom-tmp.bin",
                                         "a.fathom-tmp1.exr", "b.fathom-tmp1.bin", "a.fathom-tmp1x.bin"};
    const int count = sizeof others / sizeof *others;
    for (int i = 0; i < count; ++i) make(in_folder(others[i]));
    assert_int_equal(count_files(false), count + 3);
    fathom_file_remove_left_over(place);
    assert_int_equal(count_files(false), count + 1);
    for (int i = 0; i < count; ++i) assert_int_equal(access(in_folder(others[i]), F_OK), 0);
    assert_ok(context, file_writer_commit(alive));
    assert_holds("one");
}

/* While the child lives its file is in use; killed, it has left it over. */
UNIT_TEST(the_file_of_a_killed_writer_is_removed) {
    int ready[2];
    char byte;
    assert_int_equal(pipe(ready), 0);
    pid_t child = fork();
    if (child == 0) {
        begin("never finished");
        if (write(ready[1], "x", 1) == 1) pause();
        _exit(1);
    }
    assert_int_equal(read(ready[0], &byte, 1), 1);
    fathom_file_remove_left_over(place);
    assert_int_equal(count_files(false), 1);
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
    assert_int_equal(count_files(false), 1);
    fathom_file_remove_left_over(place);
    assert_int_equal(count_files(false), 0);
    close(ready[0]), close(ready[1]);
}

int main(void) {
    unit_each(set_up, tear_down);
    return unit_main(open_folder, remove_folder);
}
