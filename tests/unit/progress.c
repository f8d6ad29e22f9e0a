/* The bar fits its terminal, and its numbers follow from what is reported. */
#include "unit.h"

#include "cli/render/progress.h"

static fathom_progress at(double fraction, uint64_t rays, double seconds) {
    return (fathom_progress){
        .phase = FATHOM_PHASE_RENDER, .fraction = fraction, .rays = rays, .seconds = seconds};
}

UNIT_TEST(the_bar_fits) {
    for (unsigned columns = 0; columns < 300; ++columns) {
        for (int i = 0; i <= 20; ++i) {
            fathom_progress p = at(i / 20.0, 123456789, 3.0);
            char text[256];
            memset(text, 'x', sizeof text);
            progress_bar(&p, columns, text, sizeof text);
            assert_true(strlen(text) + 1 <= (columns ? columns : 1));
        }
    }
}

UNIT_TEST(the_bar_is_as_full_as_the_work) {
    int before = -1;
    for (int i = 0; i <= 100; ++i) {
        fathom_progress p = at(i / 100.0, 1000000, 2.0);
        char text[256];
        progress_bar(&p, 100, text, sizeof text);
        int full = 0, cells = (int)(strchr(text, ']') - strchr(text, '[')) - 1;
        for (const char *c = text; *c; ++c) full += *c == '=';
        assert_true(full >= before);
        before = full;
        assert_true(abs(full * 100 - i * cells) <= 100);
        if (i == 100) assert_int_equal(full, cells);
    }
}

UNIT_TEST(lines_say_what_is_known) {
    char text[128];
    fathom_progress p = at(0.25, 90000000, 2.0);
    progress_line(&p, text, sizeof text);
    assert_string_equal(text, "render 25 %, 45.0 Mrays/s, 0:06 left");
    p = at(0.5, 0, 3600.0);
    p.phase = FATHOM_PHASE_BUILD;
    progress_line(&p, text, sizeof text);
    assert_string_equal(text, "build 50 %, 1:00:00 left");
    p.phase = FATHOM_PHASE_PHOTONS;
    progress_line(&p, text, sizeof text);
    assert_string_equal(text, "photons 50 %, 1:00:00 left");
    p = at(0, 0, 0);
    progress_line(&p, text, sizeof text);
    assert_string_equal(text, "render 0 %");
}

UNIT_TEST(hundred_percent_means_done) {
    char text[128];
    fathom_progress p = at(0.9999, 0, 0);
    progress_line(&p, text, sizeof text);
    assert_string_equal(text, "render 99 %");
    p = at(1, 0, 0);
    progress_line(&p, text, sizeof text);
    assert_string_equal(text, "render 100 %");
}

UNIT_TEST(odd_fractions_are_held) {
    const double odd[] = {-1, 2, (double)NAN, (double)INFINITY, 1e-300};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; ++i) {
        fathom_progress p = at(odd[i], UINT64_MAX, 1e9);
        char text[256];
        progress_bar(&p, 80, text, sizeof text);
        assert_true(strlen(text) <= 79);
        progress_line(&p, text, sizeof text);
        assert_true(strlen(text) < 100);
    }
}

int main(void) { return unit_main(NULL, NULL); }
