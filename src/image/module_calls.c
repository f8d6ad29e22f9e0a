#include "image/module_calls.h"

#include <setjmp.h>
#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

static const image_module *module;
static atomic_uint under_way;
static atomic_bool broken;
static _Thread_local sigjmp_buf *volatile landing; /* of the call that this thread is in */

#define LACK 0x100 /* beside the number of the signal */

void image_call_failed_here(int number, bool lack) {
    if (landing) siglongjmp(*landing, number | (lack ? LACK : 0));
}

bool image_is_called_here(void) { return landing != NULL; }
bool image_is_called(void) { return atomic_load(&under_way) > 0; }

static fathom_status refuse(image_message *message) {
    snprintf(message->text, sizeof message->text, "a library of the image module failed before");
    return FATHOM_INTERNAL;
}

static void end_call(void) {
    landing = NULL;
    atomic_fetch_sub(&under_way, 1);
}

static fathom_status land(int what, image_message *message) {
    end_call();
    atomic_store(&broken, true);
    const char *name = sigabbrev_np(what & ~LACK);
    snprintf(message->text, sizeof message->text, "a library of the image module failed (SIG%s)%s",
             name ? name : "?", what & LACK ? ", as some do when they lack memory" : "");
    return what & LACK ? FATHOM_OUT_OF_RESOURCES : FATHOM_INTERNAL;
}

/* A function's body: makes the call, and returns its status. Nothing changes between the mark and the jump
 * that is looked at after it. */
#define RETURN_CALL(call)                                                                                    \
    sigjmp_buf here;                                                                                         \
    if (atomic_load(&broken)) return refuse(message);                                                        \
    atomic_fetch_add(&under_way, 1);                                                                         \
    int what = sigsetjmp(here, 1);                                                                           \
    if (what) return land(what, message);                                                                    \
    landing = &here;                                                                                         \
    fathom_status status = (call);                                                                           \
    end_call();                                                                                              \
    return status

static fathom_status open_writer(const image_target *target, image_writer **out, image_message *message) {
    RETURN_CALL(module->writer.open(target, out, message));
}

static fathom_status write_rows(image_writer *writer, uint32_t count, const void *pixels,
                                image_message *message) {
    RETURN_CALL(module->writer.rows(writer, count, pixels, message));
}

static fathom_status close_writer(image_writer *writer, bool finish, image_message *message) {
    RETURN_CALL(module->writer.close(writer, finish, message));
}

static fathom_status read_image(const char *path, unsigned threads, const image **out,
                                image_message *message) {
    RETURN_CALL(module->read(path, threads, out, message));
}

static fathom_status open_view(const image_view_request *request, image_view **out, bool *srgb,
                               image_message *message) {
    RETURN_CALL(module->view_open(request, out, srgb, message));
}

static fathom_status apply_view(const image_view *view, float *rgba, size_t count, image_message *message) {
    RETURN_CALL(module->view_apply(view, rgba, count, message));
}

/* What is only given back cannot fail for its caller. */
static fathom_status close_and_tell(image_view *view, image_message *message) {
    RETURN_CALL((module->view_close(view), FATHOM_OK));
}

static void close_view(image_view *view) {
    image_message ignored = {""};
    close_and_tell(view, &ignored);
}

static fathom_status release_and_tell(const image *img, image_message *message) {
    RETURN_CALL((module->release(img), FATHOM_OK));
}

static void release_image(const image *img) {
    image_message ignored = {""};
    release_and_tell(img, &ignored);
}

const image_module *module_calls(const image_module *own) {
    static const image_module calls = {IMAGE_MODULE_VERSION,
                                       {open_writer, write_rows, close_writer},
                                       read_image,
                                       release_image,
                                       open_view,
                                       apply_view,
                                       close_view};
    module = own;
    return &calls;
}
