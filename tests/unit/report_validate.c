/* validate's page: what is in the results is on it, what is not is said, and nothing breaks it. */
#include "report/validate_page.h"
#include "report/validate_parts.h"
#include "unit.h"

static char *page_of(const json_t *results) {
    page p = {.count = 0};
    validate_page(&p, results);
    assert_false(p.lost);
    char *text = strdup(p.items);
    assert_non_null(text);
    page_free(&p);
    return text;
}

static json_t *load(const char *name) {
    char path[512];
    json_error_t error;
    snprintf(path, sizeof path, SOURCE_DIR "/tests/report/%s", name);
    json_t *results = json_load_file(path, 0, &error);
    if (!results) fail_msg("%s: %s", path, error.text);
    return results;
}

static size_t count(const char *text, const char *what) {
    size_t n = 0;
    for (; (text = strstr(text, what)); text += strlen(what)) ++n;
    return n;
}

/* ---- a page with everything ---- */

static void test_everything_is_there(void **state) {
    (void)state;
    json_t *results = load("full.json");
    char *text = page_of(results);
    assert_int_equal(count(text, "class=\"absent\""), 0);
    static const char *const there[] = {"12 answers wrong",
                                        "1 of 32 extreme cases failed",
                                        "1 of 3 shading cases out of bounds",
                                        "AVX-512",
                                        "2026-11-21",
                                        "Intel(R) Xeon(R) &lt;test&gt;",
                                        "data:image/png;base64,iVBOR",
                                        "beyond",
                                        "0x1.4p+0",
                                        "spheres of radius 10⁻⁸ to 10⁸.",
                                        "10⁻⁶ to 1 rad off &lt;the&gt; surface.",
                                        "<li>flat &lt;triangles&gt;</li>",
                                        "--replay"};
    for (size_t i = 0; i < sizeof there / sizeof *there; ++i) {
        if (!strstr(text, there[i])) fail_msg("not on the page: %s", there[i]);
    }
    /* Names that look like markup are text. */
    assert_null(strstr(text, "<script"));
    assert_null(strstr(text, "<the>"));
    assert_non_null(strstr(text, "&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt; &amp; &quot;a&quot;.json"));
    free(text);
    json_decref(results);
}

/* ---- what is missing ---- */

static void test_missing_keys_leave_out_sections(void **state) {
    (void)state;
    json_t *results = load("full.json");
    static const char *const keys[] = {"extremes", "shading", "images", "runs"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i) {
        json_t *part = json_copy(results);
        json_object_del(part, keys[i]);
        char *text = page_of(part);
        assert_true(count(text, "class=\"absent\"") >= 1);
        free(text);
        json_decref(part);
    }
    json_decref(results);
    json_t *nothing = json_object();
    char *text = page_of(nothing);
    assert_non_null(strstr(text, "Nothing wrong in 0 rays."));
    free(text);
    json_decref(nothing);
}

/* Any value in place of any other: the page is still a document. */
static void test_any_value_anywhere(void **state) {
    (void)state;
    json_t *results = load("full.json");
    const char *key;
    json_t *value;
    void *next;
    static const char *const others[] = {"null", "5",  "-1e300",      "\"text\"",
                                         "[]",   "{}", "[1,null,{}]", "[[],\"a\"]"};
    const char *lists[] = {NULL, "runs", "extremes", "shading", "images"};
    for (size_t l = 0; l < 5; ++l) {
        json_t *within = lists[l] ? json_array_get(json_object_get(results, lists[l]), 0) : results;
        json_object_foreach_safe(within, next, key, value) {
            json_t *kept = json_incref(value);
            for (size_t i = 0; i < sizeof others / sizeof *others; ++i) {
                json_object_set_new(within, key, json_loads(others[i], JSON_DECODE_ANY, NULL));
                char *text = page_of(results);
                assert_non_null(strstr(text, "</html>"));
                free(text);
            }
            json_object_set_new(within, key, kept);
        }
    }
    json_decref(results);
}

/* ---- sums ---- */

static void test_spreads(void **state) {
    (void)state;
    static spread s;
    json_t *error = json_loads("{\"max\": {\"value\": 5.5}, \"histogram\": {\"zeros\": 2, \"first\": -1, "
                               "\"perOctave\": 2, \"bins\": [0, 3, 0, 0, 0, 4, 1]}}",
                               0, NULL);
    memset(&s, 0, sizeof s);
    assert_true(isnan(spread_quantile(&s, 0.5)));
    spread_add(&s, error);
    assert_int_equal(s.total, 10);
    assert_near(spread_quantile(&s, 0.2), 0, 0);
    assert_near(spread_quantile(&s, 0.5), 1, 1e-12);     /* the second bin ends at 2^(2/2 - 1) */
    assert_near(spread_quantile(&s, 0.6), 4, 1e-12);     /* the sixth at 2^(6/2 - 1) */
    assert_near(spread_quantile(&s, 0.999), 5.5, 1e-12); /* never past the largest */
    spread_add(&s, error);
    assert_int_equal(s.total, 20);
    assert_near(spread_quantile(&s, 0.5), 1, 1e-12);
    json_decref(error);
}

static void test_sums_of_tracers(void **state) {
    (void)state;
    json_t *results = load("full.json");
    tracer_sums sums = {.count = 0};
    assert_true(tracer_sums_of(results, &sums));
    assert_int_equal(sums.count, 7);
    assert_string_equal(sums.items[0].spec, "embree");
    assert_near(sums.items[0].rays, 4000, 0);
    assert_near(sums.items[0].nanoseconds, 99, 1e-9); /* 90 and 108, as many rays each */
    assert_int_equal(sums.items[0].all.total, sums.items[0].ordinary.total + sums.items[0].hard.total);
    static const unsigned kinds[7] = {0, 0, 0, 0, 1, 2, 3};
    for (int i = 0; i < 7; ++i) assert_int_equal(sums.items[i].kind, kinds[i]);
    array_free(&sums);
    json_decref(results);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_everything_is_there), cmocka_unit_test(test_missing_keys_leave_out_sections),
        cmocka_unit_test(test_any_value_anywhere),  cmocka_unit_test(test_spreads),
        cmocka_unit_test(test_sums_of_tracers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
