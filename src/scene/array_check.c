#include "scene/array_check.h"

#include "base/threads.h"

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

static const float *item(const array_check *check, size_t i) {
    return (const float *)(const void *)((const char *)check->values + check->stride * i);
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
    if (check->stride == check->components * sizeof(float))
        return !exponents_full(item(check, begin), (end - begin) * check->components);
    uint32_t full = 0;
    for (size_t i = begin; i < end; ++i) full |= exponents_full(item(check, i), check->components);
    return !full;
}

static void check_finite_run(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    array_check *check = user;
    if (run_is_finite(check, begin, end)) return;
    for (size_t i = begin; i < end; ++i) {
        if (!run_is_finite(check, i, i + 1)) {
            note_bad(check, i);
            return;
        }
    }
}

static void check_index_run(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    array_check *check = user;
    uint32_t highest = 0;
    for (size_t i = begin; i < end; ++i) highest = check->indices[i] > highest ? check->indices[i] : highest;
    if (highest < check->limit) return;
    for (size_t i = begin; i < end; ++i) {
        if (check->indices[i] >= check->limit) {
            note_bad(check, i);
            return;
        }
    }
}

fathom_status array_check_finite(fathom_context *context, const char *what, const float *values,
                                 size_t stride, size_t components, uint32_t count) {
    if (stride % 4 || stride < components * sizeof(float)) {
        return fail(context, FATHOM_BAD_INPUT,
                    "%s: the stride is %zu; expected a multiple of 4 of at least %zu", what, stride,
                    components * sizeof(float));
    }
    array_check check = {.values = values, .stride = stride, .components = components, .bad = SIZE_MAX};
    loop_parallel(fathom_context_threads(context), count, 1u << 16, check_finite_run, &check);
    size_t bad = atomic_load(&check.bad);
    if (bad == SIZE_MAX) return FATHOM_OK;
    return fail(context, FATHOM_BAD_INPUT, "%s[%zu]: expected finite numbers, found a NaN or an infinity",
                what, bad);
}

fathom_status array_check_indices(fathom_context *context, const char *what, const uint32_t *indices,
                                  size_t count, uint32_t limit) {
    array_check check = {.indices = indices, .limit = limit, .bad = SIZE_MAX};
    loop_parallel(fathom_context_threads(context), count, 1u << 18, check_index_run, &check);
    size_t bad = atomic_load(&check.bad);
    if (bad == SIZE_MAX) return FATHOM_OK;
    return fail(context, FATHOM_BAD_INPUT, "%s[%zu] (triangle %zu): %u is out of range, there are %u", what,
                bad, bad / 3, indices[bad], limit);
}
