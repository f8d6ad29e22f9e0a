/* The document and its file. */
#include "base/status.h"
#include "report/page.h"
#include "unit.h"

#include <fathom/fathom.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- text ---- */

static void check_text(const char *text, const char *expected) {
    page p = {.count = 0};
    page_text(&p, text);
    assert_false(p.lost);
    assert_string_equal(p.items ? p.items : "", expected);
    page_free(&p);
}

static void test_text_stands_for_itself(void **state) {
    (void)state;
    check_text("plain", "plain");
    check_text(NULL, "");
    check_text("<script>alert(\"1\" & '2')</script>",
               "&lt;script&gt;alert(&quot;1&quot; &amp; &#39;2&#39;)&lt;/script&gt;");
    check_text("&lt;", "&amp;lt;");
    check_text("Größe 10⁻⁸ 🙂", "Größe 10⁻⁸ 🙂");
    /* Names of files need not be UTF-8: cut off, overlong, a lone continuation, past the last character. */
    check_text("a\xc3", "a\ufffd");
    check_text("\xc0\xbc", "\ufffd\ufffd");
    check_text("\x80<", "\ufffd&lt;");
    check_text("\xf5\x80\x80\x80", "\ufffd\ufffd\ufffd\ufffd");
    check_text("\xe2\x82<", "\ufffd\ufffd&lt;");
    check_text("a\001b\x7f", "a\ufffdb\ufffd");
    page p = {.count = 0};
    page_textf(&p, "%s, %d", "<&>", 5);
    assert_string_equal(p.items, "&lt;&amp;&gt;, 5");
    page_free(&p);
}

static void test_document(void **state) {
    (void)state;
    page p = {.count = 0};
    page_begin(&p, "Rays & <scenes>");
    page_links(&p);
    page_section(&p, "one", "First <part>");
    page_section(&p, "two", "Second");
    page_end(&p);
    assert_false(p.lost);
    const char *nav = strstr(p.items, "<nav"), *first = strstr(p.items, "<section id=\"one\"");
    assert_non_null(strstr(p.items, "<title>Rays &amp; &lt;scenes&gt;</title>"));
    assert_true(nav && first && nav < first);
    assert_non_null(strstr(nav, "<li><a href=\"#one\">First &lt;part&gt;</a></li>"));
    /* Nothing in it asks for anything from outside. */
    assert_null(strstr(p.items, "http:"));
    assert_null(strstr(p.items, "https:"));
    assert_null(strstr(p.items, "<script"));
    assert_null(strstr(p.items, "url("));
    assert_null(strstr(p.items, "@import"));
    page_free(&p);
}

/* ---- the file ---- */

typedef struct place {
    fathom_context *context;
    char folder[64], index[96];
    page page;
} place;

static void begin(place *t) {
    memset(t, 0, sizeof *t);
    snprintf(t->folder, sizeof t->folder, "/tmp/fathom-report-XXXXXX");
    assert_non_null(mkdtemp(t->folder));
    snprintf(t->index, sizeof t->index, "%s/index.html", t->folder);
    assert_int_equal(fathom_context_create(&t->context), FATHOM_OK);
    page_begin(&t->page, "t");
    page_end(&t->page);
}

static void end(place *t) {
    unlink(t->index);
    rmdir(t->folder);
    page_free(&t->page);
    fathom_context_destroy(t->context);
}

static void put(const char *path, const char *text) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static void check_index(const place *t, const char *start) {
    char head[512] = "";
    FILE *file = fopen(t->index, "r");
    assert_non_null(file);
    assert_true(fread(head, 1, sizeof head - 1, file) > 0);
    fclose(file);
    assert_memory_equal(head, start, strlen(start));
}

static void test_folder_is_made(void **state) {
    (void)state;
    place t;
    begin(&t);
    rmdir(t.folder);
    assert_ok(t.context, page_check(t.context, t.folder));
    assert_int_not_equal(access(t.folder, F_OK), 0); /* a check makes nothing */
    assert_ok(t.context, page_write(t.context, &t.page, t.folder));
    check_index(&t, "<!DOCTYPE html>");
    /* Our own page is replaced. */
    assert_ok(t.context, page_write(t.context, &t.page, t.folder));
    char deep[128];
    snprintf(deep, sizeof deep, "%s/no/such", t.folder);
    assert_fails(t.context, page_check(t.context, deep), FATHOM_OUT_OF_RESOURCES, "folder does not exist");
    end(&t);
}

static void test_files_of_others_stay(void **state) {
    (void)state;
    place t;
    begin(&t);
    put(t.index, "<html>my diary</html>");
    assert_fails(t.context, page_check(t.context, t.folder), FATHOM_OUT_OF_RESOURCES, "no report of fathom");
    assert_fails(t.context, page_write(t.context, &t.page, t.folder), FATHOM_OUT_OF_RESOURCES, t.index);
    check_index(&t, "<html>my diary");
    assert_fails(t.context, page_check(t.context, t.index), FATHOM_OUT_OF_RESOURCES, "expected a folder");
    /* An empty file holds nothing to lose. */
    put(t.index, "");
    assert_ok(t.context, page_write(t.context, &t.page, t.folder));
    t.page.lost = true;
    assert_int_equal(page_write(t.context, &t.page, t.folder), FATHOM_OUT_OF_RESOURCES);
    end(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_text_stands_for_itself),
        cmocka_unit_test(test_document),
        cmocka_unit_test(test_folder_is_made),
        cmocka_unit_test(test_files_of_others_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
