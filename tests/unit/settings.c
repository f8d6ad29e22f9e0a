/* Settings by name: the table holds every member, and text, numbers and checks agree about each. */
#include "scene/settings.h"
#include "scene/scene.h"
#include "unit_scene.h"

#define EACH(p)                                                                                              \
    for (const fathom_parameter *p = settings_table.rows; p < settings_table.rows + settings_table.count; ++p)

static size_t bytes_of(const fathom_parameter *p) {
    fathom_settings zeros, ones;
    memset(&zeros, 0, sizeof zeros), memset(&ones, 0xff, sizeof ones);
    parameter_copy(p, &ones, &zeros);
    size_t bytes = 0;
    for (size_t i = 0; i < sizeof zeros; ++i) bytes += ((unsigned char *)&zeros)[i] != 0;
    return bytes;
}

/* What lies between two members is less than a number: no member is without a row. */
UNIT_TEST(the_table_has_every_member) {
    size_t end = sizeof(size_t); /* its size */
    EACH(p) {
        assert_in_range(p->offset, end, end + 7);
        assert_true(p->offset % 8 == 0 || p->offset < end + 4);
        end = p->offset + bytes_of(p);
    }
    assert_in_range(sizeof(fathom_settings), end, end + 7);
    size_t count;
    assert_ptr_equal(fathom_settings_parameters(&count), settings_table.rows);
    assert_int_equal(count, settings_table.count);
    assert_ptr_equal(fathom_material_parameters(FATHOM_MODEL_CLASSIC, &count), classic_table.rows);
    assert_int_equal(count, classic_table.count);
    assert_ptr_equal(fathom_material_parameters(FATHOM_MODEL_METALLIC_ROUGHNESS, &count),
                     metallic_table.rows);
    assert_int_equal(count, metallic_table.count);
}

UNIT_TEST(every_row_says_what_it_is_for) {
    EACH(p) {
        const bool words = p->type == FATHOM_PARAMETER_WORD || p->type == FATHOM_PARAMETER_WORDS;
        assert_true(p->name && p->help && (!words || p->words));
        if (p->flags & FATHOM_PARAMETER_COMMAND)
            assert_true(p->group && (p->unit || p->words || p->type == FATHOM_PARAMETER_BOOL));
        assert_true(strlen(p->name) + 4 < PARAMETER_NAME);
        assert_ptr_equal(parameter_find(settings_table, p->name), p);
    }
}

UNIT_TEST(defaults_are_allowed) {
    fathom_settings s = default_settings();
    fathom_material m = default_material();
    assert_ok(context, scene_check_settings(context, &s));
    assert_ok(context, scene_check_material(context, &m));
    assert_true(s.width == 1280 && s.height == 720 && s.spp == 1024 && s.max_depth == 16 && s.terminator_fix);
    assert_true(s.min_weight == 1.0f / 65536 && s.block_width == 16 && s.tile_size == 32 && !s.tracer);
}

static bool same(const fathom_parameter *p, const fathom_settings *a, const fathom_settings *b) {
    return memcmp((const char *)a + p->offset, (const char *)b + p->offset, bytes_of(p)) == 0;
}

UNIT_TEST(text_goes_out_as_it_came_in) {
    static const char *const texts[][2] = {{"width", "640"},
                                           {"height", "65536"},
                                           {"spp", "16"},
                                           {"pattern", "stratified"},
                                           {"pattern", "sobol"},
                                           {"seed", "18446744073709551615"},
                                           {"crop", "1,2,30,40"},
                                           {"target_error", "0.01"},
                                           {"target_error", "off"},
                                           {"max_time", "1.5"},
                                           {"min_spp", "64"},
                                           {"min_spp", "auto"},
                                           {"max_depth", "0"},
                                           {"min_weight", "0.1"},
                                           {"max_loss", "1e-09"},
                                           {"epsilon", "auto"},
                                           {"epsilon", "1e-300"},
                                           {"terminator_fix", "false"},
                                           {"aovs", "none"},
                                           {"aovs", "Z,N,id"},
                                           {"tracer", "bvh:f64"},
                                           {"memory_limit", "auto"},
                                           {"memory_limit", "8000000000"},
                                           {"block_width", "4"},
                                           {"tile_size", "64"}};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) {
        fathom_settings s = default_settings();
        char out[128];
        assert_ok(context, fathom_settings_set_text(context, &s, texts[i][0], texts[i][1]));
        assert_ok(context, fathom_settings_get_text(context, &s, texts[i][0], out, sizeof out));
        assert_string_equal(out, texts[i][1]);
    }
    fathom_settings s = default_settings();
    assert_ok(context, fathom_settings_set_text(context, &s, "memory_limit", "8G"));
    assert_true(s.memory_limit == 8000000000);
    assert_ok(context, fathom_settings_set_text(context, &s, "aovs", "all"));
    assert_int_equal(s.aovs, FATHOM_AOVS & ~(unsigned)(FATHOM_AOV_ALPHA | FATHOM_AOV_ERROR));
}

UNIT_TEST(defaults_go_through_text) {
    EACH(p) {
        fathom_settings a = default_settings(), b;
        char out[128], wrong[PARAMETER_WRONG];
        memset(&b, 0x55, sizeof b);
        if (p->type == FATHOM_PARAMETER_TEXT) continue;
        assert_ok(context, fathom_settings_get_text(context, &a, p->name, out, sizeof out));
        if (!parameter_read(p, out, &b, wrong)) fail_msg("%s: %s: %s", p->name, out, wrong);
        assert_true(same(p, &a, &b));
    }
}

UNIT_TEST(wrong_text_changes_nothing) {
    static const char *const wrong[][3] = {
        {"width", "0", "width: expected a whole number from 1 to 65536, found \"0\""},
        {"spp", "4.5", "spp: expected a whole number"},
        {"pattern", "Grid", "pattern: expected grid|stratified|sobol, found \"Grid\""},
        {"crop", "1,2,3", "crop: expected X0,Y0,X1,Y1"},
        {"crop", "1,2,3,99999", "crop: expected X0,Y0,X1,Y1"},
        {"epsilon", "0", "epsilon: expected auto or a number above 0"},
        {"epsilon", "inf", "epsilon: expected auto or a number above 0"},
        {"min_weight", "1", "min weight: expected a number from 0 to less than 1"},
        {"min_spp", "2", "min spp: expected auto or a whole number from 4 to 65536"},
        {"terminator_fix", "yes", "terminator fix: expected true or false"},
        {"aovs", "Z,,N", "aovs: expected names from alpha,Z,N,P,albedo,id,samples"},
        {"tracer", "", "tracer: expected SPEC|FILE.so, found nothing"},
        {"memory_limit", "9", "memory limit: expected auto or a whole number from 1000000"},
        {"block_width", "2", "block width: expected 1|4|8|16"},
        {"tile_size", "48", "tile size: expected a whole number from 32 to 65536, a multiple of 32"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        fathom_settings s = default_settings(), before;
        before = s;
        assert_fails(context, fathom_settings_set_text(context, &s, wrong[i][0], wrong[i][1]),
                     FATHOM_BAD_INPUT, wrong[i][2]);
        EACH(p) assert_true(same(p, &s, &before));
    }
}

UNIT_TEST(what_is_missing_is_named) {
    fathom_settings s = default_settings();
    char out[4];
    assert_fails(context, fathom_settings_set_text(context, &s, "sspp", "1"), FATHOM_BAD_USAGE,
                 "there is no \"sspp\"");
    assert_fails(context, fathom_settings_set_text(context, NULL, "spp", "1"), FATHOM_BAD_USAGE, "settings");
    assert_fails(context, fathom_settings_set_text(context, &s, NULL, "1"), FATHOM_BAD_USAGE, "name");
    assert_fails(context, fathom_settings_set_text(context, &s, "spp", NULL), FATHOM_BAD_USAGE, "value");
    assert_fails(context, fathom_settings_get_text(context, &s, "spp", NULL, 0), FATHOM_BAD_USAGE, "value");
    assert_fails(context, fathom_settings_get_text(context, &s, "width", out, sizeof out), FATHOM_BAD_USAGE,
                 "takes 5 bytes");
    assert_non_null(fathom_settings_parameters(NULL));
}

UNIT_TEST(names_have_three_spellings) {
    const fathom_parameter names[] = {{.name = "max_depth"}, {.name = "k_d"}, {.name = "lit_from_behind"}};
    static const char *const spelled[][3] = {{"max-depth", "max depth", "maxDepth"},
                                             {"kd", "kd", "kd"},
                                             {"lit-from-behind", "lit from behind", "litFromBehind"}};
    for (size_t i = 0; i < 3; ++i) {
        char out[PARAMETER_NAME];
        for (size_t k = 0; k < 3; ++k) {
            parameter_name(&names[i], "- \0"[k], out);
            assert_string_equal(out, spelled[i][k]);
        }
    }
}

int main(void) { return unit_main_each(open_scene, NULL); }
