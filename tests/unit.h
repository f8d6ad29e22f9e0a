/* What every unit test includes. */
#pragma once

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

/* Sanitizers take some ten times as long. Statistics need many rounds, but a few visit the same code. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { SANITIZED = 1 };
#else
enum { SANITIZED = 0 };
#endif

/* ---- What a test owns ends with it, whether it passes or not, the newest first: own_NAME(thing). ---- */

enum { UNIT_THINGS_MAX = 1 << 14 };
static struct {
    void *thing;
    void (*end)(void *thing);
} unit_things[UNIT_THINGS_MAX];
static size_t unit_thing_count;

static inline void unit_own(void *thing, void (*end)(void *thing)) {
    if (unit_thing_count == UNIT_THINGS_MAX) abort();
    unit_things[unit_thing_count].thing = thing, unit_things[unit_thing_count++].end = end;
}

/* Ends all but the first `left` things. */
static inline void unit_end_things(size_t left) {
    while (unit_thing_count > left) {
        --unit_thing_count;
        unit_things[unit_thing_count].end(unit_things[unit_thing_count].thing);
    }
}

#define UNIT_OWNS(name, type, destroy)                                                                       \
    static inline void unit_end_##name(void *thing) { destroy(thing); }                                      \
    static inline type *own_##name(type *thing) {                                                            \
        unit_own(thing, unit_end_##name);                                                                    \
        return thing;                                                                                        \
    }

/* Zeros, to the byte: a sanitizer sees what reads beyond. */
static inline void *unit_memory(size_t bytes) {
    void *memory = calloc(1, bytes);
    assert_non_null(memory);
    unit_own(memory, free);
    return memory;
}

/* A text as printf() makes it. */
__attribute__((format(printf, 1, 2))) static inline const char *unit_text(const char *format, ...) {
    char *text;
    va_list arguments;
    va_start(arguments, format);
    assert_true(vasprintf(&text, format, arguments) >= 0);
    va_end(arguments);
    unit_own(text, free);
    return text;
}

static int (*unit_each_teardown)(void **state); /* of each test; NULL: none */
static size_t unit_group_things;                /* of the set-up of all tests, which end with the last test */

static inline int unit_end_test(void **state) {
    unit_end_things(unit_group_things);
    return unit_each_teardown ? unit_each_teardown(state) : 0;
}

/* cmocka passes over what the teardown of a group returns, and many a one says there that something was left
 * behind: that fails, too. */
static int (*unit_set_up)(void **state), (*unit_teardown)(void **state);
static int unit_teardown_failed;

static inline int unit_note_set_up(void **state) {
    const int failed = unit_set_up && unit_set_up(state) != 0;
    unit_group_things = unit_thing_count;
    return failed;
}

static inline int unit_note_teardown(void **state) {
    unit_end_things(0);
    unit_teardown_failed = unit_teardown && unit_teardown(state) != 0;
    return 0;
}

static inline int unit_run(const char *name, const struct CMUnitTest *tests, size_t count,
                           int (*setup)(void **state), int (*teardown)(void **state)) {
    unit_set_up = setup, unit_teardown = teardown;
    const int failed = _cmocka_run_group_tests(name, tests, count, unit_note_set_up, unit_note_teardown);
    if (unit_teardown_failed) fprintf(stderr, "[  FAILED  ] the teardown of %s\n", name);
    return failed + unit_teardown_failed;
}

/* ---- UNIT_TEST(law) { … } is a test of the program, which may use `state`. main() returns unit_main() or
 * unit_main_each(). ---- */

enum { UNIT_TESTS_MAX = 64 };
static struct CMUnitTest unit_tests[UNIT_TESTS_MAX];
static int unit_lines[UNIT_TESTS_MAX];
static size_t unit_test_count;

/* By line: the linker puts constructors in any order. */
static inline void unit_add(const char *name, void (*run)(void **state), int line) {
    size_t at = unit_test_count++;
    if (at == UNIT_TESTS_MAX) abort();
    for (; at > 0 && unit_lines[at - 1] > line; --at)
        unit_tests[at] = unit_tests[at - 1], unit_lines[at] = unit_lines[at - 1];
    unit_tests[at] = (struct CMUnitTest){.name = name, .test_func = run};
    unit_lines[at] = line;
}

#define UNIT_TEST(law)                                                                                       \
    static void law(void **state);                                                                           \
    __attribute__((constructor)) static void unit_add_##law(void) { unit_add(#law, law, __LINE__); }         \
    static void law(void **state __attribute__((unused)))

/* Runs all tests in the order of the file, between one set-up and tear-down (NULL: none). */
static inline int unit_main(int (*setup)(void **state), int (*teardown)(void **state)) {
    for (size_t i = 0; i < unit_test_count; ++i) unit_tests[i].teardown_func = unit_end_test;
    return unit_run("tests", unit_tests, unit_test_count, setup, teardown);
}

/* Set-up and tear-down of each test (NULL: none); call it before unit_main(). */
static inline void unit_each(int (*setup)(void **state), int (*teardown)(void **state)) {
    for (size_t i = 0; i < unit_test_count; ++i) unit_tests[i].setup_func = setup;
    unit_each_teardown = teardown;
}

static inline int unit_main_each(int (*setup)(void **state), int (*teardown)(void **state)) {
    unit_each(setup, teardown);
    return unit_main(NULL, NULL);
}

/* A file of these bytes: a new one rather than a truncated one, since some file systems wait for the disk
 * after a truncation. */
static inline void unit_write_file(const char *path, const void *bytes, size_t size) {
    unlink(path);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

/* |a - b| <= tolerance; NaN fails. Each use says where its tolerance comes from. */
#define assert_near(a, b, tolerance)                                                                         \
    do {                                                                                                     \
        double near_a = (double)(a), near_b = (double)(b);                                                   \
        if (!(fabs(near_a - near_b) <= (double)(tolerance))) {                                               \
            fail_msg("%s = %.17g, expected %s = %.17g within %g", #a, near_a, #b, near_b,                    \
                     (double)(tolerance));                                                                   \
        }                                                                                                    \
    } while (0)

/* The call succeeds; otherwise its message is shown. */
#define assert_ok(context, call)                                                                             \
    do {                                                                                                     \
        if ((call) != FATHOM_OK) fail_msg("%s: %s", #call, fathom_context_message(context));                 \
    } while (0)

/* The call fails with this status, and the message holds `text`. */
#define assert_fails(context, call, status, text)                                                            \
    do {                                                                                                     \
        assert_int_equal((call), (status));                                                                  \
        if (!strstr(fathom_context_message(context), (text))) {                                              \
            fail_msg("%s: message \"%s\" does not hold \"%s\"", #call, fathom_context_message(context),      \
                     (text));                                                                                \
        }                                                                                                    \
    } while (0)
