/* Embree's threads are made when asked for, ahead of the first build, and leave signals to others. */
#include "base/threads.h"
#include "stage.h"

#include <dirent.h>
#include <signal.h>

/* Threads of this process; *deaf: those of them that block SIGINT. */
static unsigned count_threads(unsigned *deaf) {
    unsigned count = 0;
    DIR *tasks = opendir("/proc/self/task");
    assert_non_null(tasks);
    *deaf = 0;
    for (struct dirent *entry; (entry = readdir(tasks));) {
        char path[300], line[256];
        unsigned long long blocked;
        if (entry->d_name[0] == '.') continue;
        snprintf(path, sizeof path, "/proc/self/task/%s/status", entry->d_name);
        FILE *status = fopen(path, "r");
        assert_non_null(status);
        while (fgets(line, sizeof line, status)) {
            if (sscanf(line, "SigBlk: %llx", &blocked) == 1) *deaf += blocked >> (SIGINT - 1) & 1;
        }
        fclose(status);
        ++count;
    }
    closedir(tasks);
    return count;
}

static void threads_are_there_before_a_build(void **state) {
    (void)state;
    if (processor_count() == 1) skip();
    unsigned deaf_before, deaf_after, before = count_threads(&deaf_before);
    trace_start_threads();
    unsigned after = count_threads(&deaf_after);
    assert_true(after > before);
    assert_int_equal(deaf_after - deaf_before, after - before);
    sigset_t mask;
    assert_int_equal(pthread_sigmask(SIG_SETMASK, NULL, &mask), 0);
    assert_int_equal(sigismember(&mask, SIGINT), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(threads_are_there_before_a_build)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
