#include "scene/array_check.h"

#include "base/threads.h"
#include "scene/kernels.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

/* One array under a parallel check. `bad` is the first bad item. */
typedef struct array_check {
    const float *values;
    size_t stride, components;
    const uint32_t *indices;
    uint32_t limit;
    _Atomic size_t bad;
} array_check;

static void note_bad(array_check *check, size_t i) {
    size_t first = atomic_load(&check->bad);
    while (i < first && !atomic_compare_exchange_weak(&check->bad, &first, i)) {
    }
}

static const float *item(const float *values, size_t stride, size_t i) {
    return (const float *)(const void *)((const char *)values + stride * i);
}

/* The top bit of the result is set if the exponent of any of n floats has all its bits set: without the sign,
 * one more in the last place of the exponent then carries into the top bit. Integer arithmetic, so the loop
 * vectorises; the floats need not be touched one by one unless something is wrong. */
static uint32_t exponents_full(const float *values, size_t n) {
    uint32_t full = 0;
    for (size_t i = 0; i < n; ++i) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        full |= (bits & 0x7fffffffu) + 0x00800000u;
    }
    return full >> 31;
}

static bool run_is_finite(const array_check *check, size_t begin, size_t end) {
    const float *first = item(check->values, check->stride, begin);
    if (check->stride == check->components * sizeof(float))
        return !exponents_full(first, (end - begin) * check->components);
    return array_first_odd(first, check->stride, check->components, end - begin) == end - begin;
}

size_t array_first_odd(const float *values, size_t stride, size_t components, size_t count) {
    size_t i = 0;
    while (i < count && !exponents_full(item(values, stride, i), components)) ++i;
    return i;
}

static void check_finite_run(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    array_check *check = user;
    if (run_is_finite(check, begin, end)) return;
    const float *first = item(check->values, check->stride, begin);
    note_bad(check, begin + array_first_odd(first, check->stride, check->components, end - begin));
}

size_t array_first_beyond(const uint32_t *indices, size_t count, uint32_t limit) {
    size_t i = 0;
    while (i < count && indices[i] < limit) ++i;
    return i;
}

static void check_index_run(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    array_check *check = user;
    if (scene_kernels_best()->indices(check->indices + begin, end - begin, check->limit)) return;
    note_bad(check, begin + array_first_beyond(check->indices + begin, end - begin, check->limit));
}

fathom_status array_check_stride(fathom_context *context, const char *what, size_t stride,
                                 size_t components) {
    if (stride % 4 == 0 && stride >= components * sizeof(float)) return FATHOM_OK;
    return fail_field(context, FATHOM_BAD_INPUT, what,
                      "the stride is %zu; expected a multiple of 4 of at least %zu", stride,
                      components * sizeof(float));
}

fathom_status array_fail_odd(fathom_context *context, const char *what, size_t bad) {
    return fail_item(context, FATHOM_BAD_INPUT, what, bad,
                     "expected finite numbers, found a NaN or an infinity");
}

fathom_status array_fail_index(fathom_context *context, const char *what, const uint32_t *indices, size_t bad,
                               uint32_t limit) {
    return fail_item(context, FATHOM_BAD_INPUT, what, bad,
                     "%u, of triangle %zu, is out of range; there are %u", indices[bad], bad / 3, limit);
}

fathom_status array_check_finite(fathom_context *context, const char *what, const float *values,
                                 size_t stride, size_t components, uint32_t count) {
    fathom_status status = array_check_stride(context, what, stride, components);
    if (status != FATHOM_OK) return status;
    array_check check = {.values = values, .stride = stride, .components = components, .bad = SIZE_MAX};
    loop_parallel(fathom_context_threads(context), count, 1u << 16, check_finite_run, &check);
    size_t bad = atomic_load(&check.bad);
    return bad == SIZE_MAX ? FATHOM_OK : array_fail_odd(context, what, bad);
}

fathom_status array_check_indices(fathom_context *context, const char *what, const uint32_t *indices,
                                  size_t count, uint32_t limit) {
    array_check check = {.indices = indices, .limit = limit, .bad = SIZE_MAX};
    loop_parallel(fathom_context_threads(context), count, 1u << 18, check_index_run, &check);
    size_t bad = atomic_load(&check.bad);
    return bad == SIZE_MAX ? FATHOM_OK : array_fail_index(context, what, indices, bad, limit);
}
