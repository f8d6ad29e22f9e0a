/* SipHash against its authors' vectors, and tables of names that go by it. */
#include "base/keyed_hash.h"
#include "read/mesh/names.h"

#include "unit.h"

#include <stdio.h>
#include <string.h>

/* Appendix A of the paper (15 bytes), and of the authors' vectors_sip64 those of no byte, 8 and 63. */
static void authors_vectors(void **state) {
    (void)state;
    static const struct {
        size_t size;
        uint64_t hash;
    } known[] = {{0, UINT64_C(0x726fdb47dd0e0e31)},
                 {8, UINT64_C(0x93f5f5799a932462)},
                 {15, UINT64_C(0xa129ca6149be45e5)},
                 {63, UINT64_C(0x958a324ceb064572)}};
    const hash_key key = {{UINT64_C(0x0706050403020100), UINT64_C(0x0f0e0d0c0b0a0908)}};
    unsigned char bytes[64];
    for (unsigned i = 0; i < sizeof bytes; ++i) bytes[i] = (unsigned char)i;
    for (size_t i = 0; i < sizeof known / sizeof *known; ++i)
        assert_true(sip_hash(key, bytes, known[i].size) == known[i].hash);
}

static void key_is_drawn_once(void **state) {
    (void)state;
    hash_key key = process_hash_key(), again = process_hash_key();
    assert_true(key.half[0] || key.half[1]);
    assert_memory_equal(&key, &again, sizeof key);
}

enum { NAMES = 3000 };

static void names_are_numbered_in_their_order(void **state) {
    (void)state;
    static char text[NAMES][16];
    name_table table = {0};
    for (uint32_t i = 0; i < NAMES; ++i) {
        snprintf(text[i], sizeof text[i], "name%u", i * 7919);
        assert_int_equal(names_add(&table, text[i], strlen(text[i])), i);
    }
    for (uint32_t i = 0; i < NAMES; ++i) {
        assert_int_equal(names_add(&table, text[i], strlen(text[i])), i);
        assert_int_equal(names_find(&table, text[i], strlen(text[i])), i);
    }
    assert_true(names_find(&table, "name", 4) == UINT32_MAX);
    assert_true(names_find(&table, "name1", 5) == UINT32_MAX);
    names_free(&table);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(authors_vectors),
        cmocka_unit_test(key_is_drawn_once),
        cmocka_unit_test(names_are_numbered_in_their_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
