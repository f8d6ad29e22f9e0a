/* What there is of memory, and memory that is there before it is used. */
#include "base/memory.h"
#include "unit.h"

#define MEGABYTE ((size_t)1 << 20)

/* Little is not asked about, and what no machine has is refused wherever the system tells. */
UNIT_TEST(free_memory_is_granted) {
    assert_true(memory_has(0));
    assert_true(memory_has(256 * MEGABYTE));
    assert_int_equal(memory_has(SIZE_MAX - 1), memory_free() == SIZE_MAX);
    assert_true(memory_has(256 * MEGABYTE + 1) || memory_free() < 257 * MEGABYTE);
}

/* All is zero; up to 64 MB is in memory at once. */
UNIT_TEST(taken_memory_is_resident) {
    static const size_t sizes[] = {1, 8 * MEGABYTE, 64 * MEGABYTE, 64 * MEGABYTE + 1, 1024 * MEGABYTE};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        const size_t before = memory_resident(), at_once = memory_taken(sizes[i]);
        assert_int_equal(at_once, sizes[i] <= 64 * MEGABYTE ? sizes[i] : 0);
        unsigned char *bytes = memory_take(sizes[i]);
        assert_non_null(bytes);
        /* Other pages come and go beside it, some kilobytes. */
        assert_true(!before || memory_resident() + MEGABYTE > before + at_once);
        for (size_t at = 0; at < sizes[i]; at += 16 * MEGABYTE) assert_int_equal(bytes[at], 0);
        assert_int_equal(bytes[sizes[i] - 1], 0);
        memory_return(bytes, sizes[i]);
    }
    memory_return(NULL, 1);
    assert_null(memory_take(SIZE_MAX / 2));
    assert_true(memory_private() <= memory_resident());
}

int main(void) { return unit_main(NULL, NULL); }
