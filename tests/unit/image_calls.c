/* Calls of the image module that end in a signal return as failed, and no more are made. */
#include "image/module_calls.h"

#include "unit.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static bool fails, lacks;
static unsigned made; /* calls that reached the module */

static fathom_status work(void) {
    ++made;
    if (fails) raise(SIGABRT);
    return FATHOM_OK;
}

static fathom_status own_open(const image_target *t, image_writer **out, image_message *m) {
    (void)t, (void)out, (void)m;
    return work();
}
static fathom_status own_rows(image_writer *w, uint32_t count, const void *pixels, image_message *m) {
    (void)w, (void)count, (void)pixels, (void)m;
    return work();
}
static fathom_status own_close(image_writer *w, bool finish, image_message *m) {
    (void)w, (void)finish, (void)m;
    return work();
}
static fathom_status own_read(const char *path, unsigned threads, const image **out, image_message *m) {
    (void)path, (void)threads, (void)out, (void)m;
    return work();
}
static void own_release(const image *img) {
    (void)img;
    work();
}
static fathom_status own_view_open(const image_view_request *r, image_view **out, bool *srgb,
                                   image_message *m) {
    (void)r, (void)out, (void)srgb, (void)m;
    return work();
}
static fathom_status own_view_apply(const image_view *v, float *rgba, size_t count, image_message *m) {
    (void)v, (void)rgba, (void)count, (void)m;
    return work();
}
static void own_view_close(image_view *v) {
    (void)v;
    work();
}

static const image_module own = {IMAGE_MODULE_VERSION,
                                 {own_open, own_rows, own_close},
                                 own_read,
                                 own_release,
                                 own_view_open,
                                 own_view_apply,
                                 own_view_close};

#define CALLS 8
#define TELLING 6 /* the first of them return a status */

static fathom_status call(const image_module *m, int which, image_message *message) {
    switch (which) {
    case 0: return m->writer.open(NULL, NULL, message);
    case 1: return m->writer.rows(NULL, 0, NULL, message);
    case 2: return m->writer.close(NULL, true, message);
    case 3: return m->read("", 1, NULL, message);
    case 4: return m->view_open(NULL, NULL, NULL, message);
    case 5: return m->view_apply(NULL, NULL, 0, message);
    case 6: m->view_close(NULL); return FATHOM_OK;
    default: m->release(NULL); return FATHOM_OK;
    }
}

static void on_signal(int number) {
    if (!image_is_called_here() || !image_is_called()) _exit(98);
    image_call_failed_here(number, lacks);
    _exit(99);
}

/* What comes of it, in a process of its own: 0 if all is as it should be, else the line. */
#define EXPECT(condition)                                                                                    \
    if (!(condition)) _exit(__LINE__ % 90 + 1)

static void fail_in(int which) {
    const image_module *m = module_calls(&own);
    image_message message = {""};
    EXPECT(signal(SIGABRT, on_signal) != SIG_ERR);
    for (int i = 0; i < CALLS; ++i) EXPECT(call(m, i, &message) == FATHOM_OK);
    EXPECT(made == CALLS && !image_is_called() && !image_is_called_here());
    fails = true;
    fathom_status status = call(m, which, &message);
    EXPECT(made == CALLS + 1 && !image_is_called() && !image_is_called_here());
    if (which < TELLING) {
        EXPECT(status == (lacks ? FATHOM_OUT_OF_RESOURCES : FATHOM_INTERNAL));
        EXPECT(strstr(message.text, "(SIGABRT)") != NULL);
        EXPECT((strstr(message.text, "lack memory") != NULL) == lacks);
    }
    fails = false;
    for (int i = 0; i < TELLING; ++i) {
        EXPECT(call(m, i, &message) == FATHOM_INTERNAL);
        EXPECT(strstr(message.text, "failed before") != NULL);
    }
    for (int i = TELLING; i < CALLS; ++i) call(m, i, &message);
    EXPECT(made == CALLS + 1);
    /* Another signal on the way: it is blocked no longer. */
    sigset_t blocked;
    EXPECT(pthread_sigmask(SIG_BLOCK, NULL, &blocked) == 0 && !sigismember(&blocked, SIGABRT));
}

static void calls_that_end(void **state) {
    (void)state;
    for (int i = 0; i < 2 * CALLS; ++i) {
        lacks = i & 1;
        fflush(NULL);
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            fail_in(i / 2);
            exit(0);
        }
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        if (!WIFEXITED(status) || WEXITSTATUS(status))
            fail_msg("call %d: %s %d", i / 2, WIFEXITED(status) ? "code" : "signal",
                     WIFEXITED(status) ? WEXITSTATUS(status) : WTERMSIG(status));
    }
}

/* Elsewhere it returns, and the handler goes on. */
static void no_call(void **state) {
    (void)state;
    assert_false(image_is_called_here());
    image_call_failed_here(SIGABRT, true);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(calls_that_end), cmocka_unit_test(no_call)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
