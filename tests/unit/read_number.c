/* Numbers from text: what the C library reads in the C locale, in every locale. */
#include "read/mesh/number.h"

#include "random.h"
#include "unit.h"

#include <locale.h>

static void expect_same(const char *text) {
    const char *p = text;
    char *end;
    double found, expected = strtod(text, &end);
    assert_true(number_read(&p, &found));
    if (memcmp(&found, &expected, sizeof found) != 0 || p != end) {
        fail_msg("\"%s\" read as %.17g up to \"%s\", expected %.17g up to \"%s\"", text, found, p, expected,
                 end);
    }
}

UNIT_TEST(numbers_at_the_ends_of_the_range_are_exact) {
    const char *texts[] = {"0",
                           "-0",
                           "+1",
                           ".5",
                           "5.",
                           "-.25e1",
                           "1e",
                           "1e+",
                           "1e-x",
                           "1e22",
                           "1e23",
                           "1e-22",
                           "1e-23",
                           "1e27",
                           "1e28",
                           "1e-27",
                           "1e-28",
                           "1e308",
                           "1e309",
                           "-1e309",
                           "4.9e-324",
                           "2e-324",
                           "0e999999999999",
                           "9007199254740993",
                           "9007199254740993.0000000000000000000000000000000000000000000000001",
                           "0.000000000000000000000000000000000000000000000000001",
                           "123456789012345678901234567890",
                           "00000000000000000000000000001.5",
                           "0.30000000000000004",
                           "2.2250738585072011e-308",
                           "1.7976931348623157e308"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) expect_same(texts[i]);
}

/* Every count of digits, every place of the point, exponents around all limits of the fast ways. */
UNIT_TEST(random_numbers_round_like_the_library) {
    random_state seed = {1};
    char text[96];
    for (int round = 0; round < 400000; ++round) {
        unsigned digits = 1 + (unsigned)(random_bits(&seed) % 22),
                 point = (unsigned)(random_bits(&seed) % (digits + 2));
        size_t n = 0;
        if (random_bits(&seed) & 1) text[n++] = '-';
        for (unsigned i = 0; i < digits; ++i) {
            if (i == point) text[n++] = '.';
            text[n++] = (char)('0' + random_bits(&seed) % 10);
        }
        text[n] = '\0';
        if (random_bits(&seed) & 1) sprintf(text + n, "e%d", (int)(random_bits(&seed) % 70) - 35);
        expect_same(text);
    }
}

/* Halfway between two doubles: the even one, and to either side of it. */
UNIT_TEST(ties_round_to_even) {
    random_state seed = {2};
    for (int round = 0; round < 2000; ++round) {
        uint64_t odd = (UINT64_C(1) << 53 | random_bits(&seed) >> 11) << 1 | 1;
        char text[96];
        for (int away = -1; away <= 1; ++away) {
            sprintf(text, "%llu", (unsigned long long)(odd + (uint64_t)(int64_t)away));
            expect_same(text);
            strcat(text, "e-5");
            expect_same(text);
        }
    }
}

UNIT_TEST(words_are_no_numbers) {
    const char *texts[] = {"", "-", "+", ".", "e5", "-.", "x1", ",5", "i", "na"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) {
        const char *p = texts[i];
        double value;
        assert_false(number_read(&p, &value));
        assert_ptr_equal(p, texts[i]);
    }
    const char *comma = "1,5";
    double value;
    assert_true(number_read(&comma, &value));
    assert_string_equal(comma, ",5");
}

UNIT_TEST(nan_and_infinity_are_read) {
    const char *p = "-inf x";
    double value;
    assert_true(number_read(&p, &value) && isinf(value) && value < 0);
    p = "NaN";
    assert_true(number_read(&p, &value) && isnan(value) && *p == '\0');
}

/* A point stays a point where the locale has a comma. */
UNIT_TEST(the_locale_changes_nothing) {
    const char *names[] = {"de_DE.UTF-8", "de_DE.utf8",  "fr_FR.UTF-8", "fr_FR.utf8",
                           "de_DE",       "nl_NL.UTF-8", "es_ES.UTF-8"};
    const char *set = NULL;
    for (size_t i = 0; i < sizeof names / sizeof *names && !set; ++i) set = setlocale(LC_NUMERIC, names[i]);
    if (!set) skip();
    const char *p = "12345678901234567890123.5e-3";
    double value;
    assert_true(number_read(&p, &value));
    setlocale(LC_NUMERIC, "C");
    assert_true(value == 12345678901234567890.1235);
    assert_true(*p == '\0');
}

UNIT_TEST(integers_saturate) {
    const char *p = "-12/3";
    int64_t value;
    assert_true(number_read_integer(&p, &value));
    assert_int_equal(value, -12);
    assert_string_equal(p, "/3");
    p = "99999999999999999999999999";
    assert_true(number_read_integer(&p, &value));
    assert_true(value > INT64_C(1) << 50);
    p = "/3";
    assert_false(number_read_integer(&p, &value));
}

int main(void) { return unit_main(NULL, NULL); }
