/* Files that are touched, changed, or both, told apart by what was known of their bytes at the time. */
#include "base/file_witness.h"
#include "unit.h"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

static char folder[64], path[128], other[128];
static file_witness *witness;

#define BIG (WITNESS_AT_ONCE + 12345)

/* Each writing has a stamp of its own, years apart: no test depends on how fine the system's clock is. */
static time_t written = 1000000000;

static void stamp(void) {
    written += 1000;
    const struct timespec times[2] = {{.tv_sec = written}, {.tv_sec = written}};
    assert_int_equal(utimensat(AT_FDCWD, path, times, 0), 0);
}

/* ctime cannot be set, and ticks a hundred times a second or more. */
static void wait_for_tick(void) { usleep(20000); }

static void put(off_t at, char byte) {
    int descriptor = open(path, O_WRONLY);
    assert_true(descriptor >= 0);
    assert_int_equal(pwrite(descriptor, &byte, 1, at), 1);
    assert_int_equal(close(descriptor), 0);
    stamp();
}

/* A file of so many zeros, opened at second 0. */
static void begin(off_t size) {
    struct stat info;
    int descriptor = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    assert_true(descriptor >= 0);
    assert_int_equal(ftruncate(descriptor, size), 0);
    assert_int_equal(close(descriptor), 0);
    stamp();
    assert_int_equal(stat(path, &info), 0);
    witness_destroy(witness);
    witness = witness_create(path, &info, 0);
    assert_non_null(witness);
    assert_string_equal(witness_path(witness), path);
}

static file_state look(double now) {
    size_t left;
    return witness_look(witness, now, &left);
}

static void touched(void **state) {
    (void)state;
    begin(1000);
    assert_int_equal(look(0), FILE_SAME);
    assert_false(witness_take_touched(witness));
    for (int i = 0; i < 3; ++i) {
        stamp();
        assert_int_equal(look(0), FILE_SAME);
        assert_true(witness_take_touched(witness));
        assert_false(witness_take_touched(witness));
    }
    put(500, 0); /* what was there */
    assert_int_equal(look(0), FILE_SAME);
    assert_true(witness_take_touched(witness));
}

/* Nothing was known of its bytes. */
static void touched_too_early(void **state) {
    (void)state;
    begin(1000);
    stamp();
    assert_int_equal(look(0), FILE_CHANGED);
    assert_false(witness_take_touched(witness));
}

/* A big file is known when the work has taken long enough for it to be worth its while, and not a moment
 * before. */
static void big(void **state) {
    (void)state;
    const double known = WITNESS_AFTER + 12345 / WITNESS_RATE;
    for (int late = 0; late < 2; ++late) {
        begin(BIG);
        assert_int_equal(look(0), FILE_SAME);
        assert_int_equal(look(WITNESS_AFTER), FILE_SAME);
        assert_int_equal(look(late ? known + 1e-6 : known - 1e-6), FILE_SAME);
        stamp();
        assert_int_equal(look(1e6), late ? FILE_SAME : FILE_CHANGED);
        assert_int_equal(witness_take_touched(witness), late);
    }
}

static void changed(void **state) {
    (void)state;
    const off_t places[] = {0, 1, WITNESS_AT_ONCE - 1, WITNESS_AT_ONCE, BIG - 1};
    for (size_t i = 0; i < sizeof places / sizeof *places; ++i) {
        begin(BIG);
        assert_int_equal(look(1e6), FILE_SAME);
        put(places[i], 1);
        assert_int_equal(look(1e6), FILE_CHANGED);
        put(places[i], 0); /* put right: too late */
        assert_int_equal(look(1e6), FILE_CHANGED);
    }
    begin(1000);
    assert_int_equal(look(0), FILE_SAME);
    assert_int_equal(truncate(path, 1001), 0);
    assert_int_equal(look(0), FILE_CHANGED);
}

/* The time of writing put back to what it was. */
static void changed_secretly(void **state) {
    (void)state;
    begin(1000);
    assert_int_equal(look(0), FILE_SAME);
    wait_for_tick();
    written -= 1000;
    put(500, 1);
    assert_int_equal(look(0), FILE_CHANGED);
}

static void truncated(void **state) {
    (void)state;
    size_t left = 0;
    begin(1000);
    assert_int_equal(look(0), FILE_SAME);
    assert_int_equal(truncate(path, 300), 0);
    assert_int_equal(witness_look(witness, 0, &left), FILE_TRUNCATED);
    assert_int_equal(left, 300);
    assert_int_equal(truncate(path, 1000), 0); /* again as long, of the same zeros */
    left = 0;
    assert_int_equal(witness_look(witness, 0, &left), FILE_TRUNCATED);
    assert_int_equal(left, 300);
}

/* Rights, links and names are no bytes: whether they were known or not, nothing is said. */
static void left_alone(void **state) {
    (void)state;
    for (int known = 0; known < 2; ++known) {
        begin(1000);
        if (known) assert_int_equal(look(0), FILE_SAME);
        wait_for_tick();
        assert_int_equal(chmod(path, 0400), 0);
        assert_int_equal(look(0), FILE_SAME);
        wait_for_tick();
        assert_int_equal(link(path, other), 0);
        assert_int_equal(look(0), FILE_SAME);
        assert_int_equal(unlink(other), 0);
        assert_int_equal(rename(path, other), 0);
        assert_int_equal(look(0), FILE_SAME);
        assert_int_equal(rename(other, path), 0);
        assert_int_equal(look(0), FILE_SAME);
        assert_false(witness_take_touched(witness));
        /* Known by now: the rights have no part in it. */
        assert_int_equal(chmod(path, 0600), 0);
        stamp();
        assert_int_equal(look(0), FILE_SAME);
        assert_true(witness_take_touched(witness));
    }
}

/* The mapping keeps the file that it is of. */
static void replaced(void **state) {
    (void)state;
    begin(1000);
    assert_int_equal(look(0), FILE_SAME);
    assert_int_equal(rename(path, other), 0);
    int descriptor = open(path, O_WRONLY | O_CREAT | O_EXCL, 0600);
    assert_true(descriptor >= 0);
    assert_int_equal(close(descriptor), 0);
    assert_int_equal(look(1e6), FILE_SAME);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(look(1e6), FILE_SAME);
    assert_int_equal(unlink(other), 0);
}

static int setup(void **state) {
    (void)state;
    strcpy(folder, "/tmp/fathom_witness_XXXXXX");
    if (!mkdtemp(folder)) return -1;
    snprintf(path, sizeof path, "%s/file", folder);
    snprintf(other, sizeof other, "%s/other", folder);
    return 0;
}

static int teardown(void **state) {
    (void)state;
    witness_destroy(witness);
    unlink(path);
    return rmdir(folder); /* fails when anything was left */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(touched),    cmocka_unit_test(touched_too_early), cmocka_unit_test(big),
        cmocka_unit_test(changed),    cmocka_unit_test(changed_secretly),  cmocka_unit_test(truncated),
        cmocka_unit_test(left_alone), cmocka_unit_test(replaced),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
