/* Option parsing: every spelling means the same, what is wrong is named, nothing wrong passes. */
#include "unit.h"

#include "cli/args.h"

typedef struct settings {
    const char *scene, *text;
    args_list outputs;
    bool quiet;
    uint32_t spp;
    uint64_t seed, triangles;
    args_counts counts;
    args_size size;
    double epsilon;
    float exposure;
    unsigned pattern;
} settings;

static const args_option table[] = {
    {.help = "A heading"},
    {"output", 'o', "IMAGE", take_list, offsetof(settings, outputs), 0, 0, "images"},
    {"text", 0, "TEXT", take_text, offsetof(settings, text), 0, 0, "text"},
    {"spp", 0, "N", take_u32, offsetof(settings, spp), 1, 65536, "samples"},
    {"seed", 0, "N", take_u64, offsetof(settings, seed), 0, HUGE_VAL, "seed"},
    {"triangles", 't', "N", take_u64, offsetof(settings, triangles), 1, 1e11, "count"},
    {"counts", 0, "N,N", take_counts, offsetof(settings, counts), 1, 1e11, "counts"},
    {"size", 0, "WxH", take_size, offsetof(settings, size), 1, 100, "size"},
    {"epsilon", 0, "E", take_f64, offsetof(settings, epsilon), 0, 10, "epsilon"},
    {"exposure", 0, "STOPS", take_f32, offsetof(settings, exposure), -64, 64, "exposure"},
    {"pattern", 0, "grid|stratified|sobol", take_choice, offsetof(settings, pattern), 0, 0, "pattern"},
    {"quiet", 'q', NULL, take_true, offsetof(settings, quiet), 0, 0, "quiet"},
    {.help = NULL},
};
static const args_spec spec = {.options = table, .operands = {{"SCENE", offsetof(settings, scene)}}};

static settings got;
static args_problem problem;

/* Words up to the first NULL, after the command's name. */
static args_result parse(const char *a, const char *b, const char *c, const char *d) {
    char *argv[] = {(char *)(uintptr_t) "render", (char *)(uintptr_t)a, (char *)(uintptr_t)b,
                    (char *)(uintptr_t)c, (char *)(uintptr_t)d};
    int argc = 1;
    while (argc < 5 && argv[argc]) ++argc;
    got = (settings){.spp = 7};
    problem.text[0] = '\0';
    return args_parse(&spec, argc, argv, &got, &problem);
}

static void assert_wrong(const char *a, const char *b, const char *text) {
    assert_int_equal(parse("scene", a, b, NULL), ARGS_WRONG);
    if (!strstr(problem.text, text)) fail_msg("\"%s\" does not hold \"%s\"", problem.text, text);
}

UNIT_TEST(spellings_mean_the_same) {
    assert_int_equal(parse("scene", "--spp", "16", NULL), ARGS_READY);
    assert_int_equal(got.spp, 16);
    assert_int_equal(parse("--spp=16", "scene", NULL, NULL), ARGS_READY);
    assert_int_equal(got.spp, 16);
    assert_string_equal(got.scene, "scene");
    assert_int_equal(parse("scene", "-o", "a", "-ob"), ARGS_READY);
    assert_int_equal(got.outputs.count, 2);
    assert_string_equal(got.outputs.items[0], "a");
    assert_string_equal(got.outputs.items[1], "b");
    assert_int_equal(parse("scene", "--output=a=b", "--output", "c"), ARGS_READY);
    assert_string_equal(got.outputs.items[0], "a=b");
    assert_string_equal(got.outputs.items[1], "c");
    assert_int_equal(parse("scene", "-q", NULL, NULL), ARGS_READY);
    assert_true(got.quiet);
}

UNIT_TEST(what_is_not_given_stays) {
    assert_int_equal(parse("scene", NULL, NULL, NULL), ARGS_READY);
    assert_int_equal(got.spp, 7);
    assert_false(got.quiet);
}

UNIT_TEST(the_last_one_holds) {
    assert_int_equal(parse("scene", "--spp=2", "--spp=3", NULL), ARGS_READY);
    assert_int_equal(got.spp, 3);
}

UNIT_TEST(dashes) {
    assert_int_equal(parse("--exposure", "-1.5", "scene", NULL), ARGS_READY);
    assert_near(got.exposure, -1.5, 0);
    assert_int_equal(parse("--", "--spp", NULL, NULL), ARGS_READY);
    assert_string_equal(got.scene, "--spp");
    assert_int_equal(parse("-", NULL, NULL, NULL), ARGS_READY);
    assert_string_equal(got.scene, "-");
    assert_int_equal(parse("scene", "--text=--spp", NULL, NULL), ARGS_READY);
    assert_string_equal(got.text, "--spp");
}

UNIT_TEST(help_ends_parsing) {
    assert_int_equal(parse("--help", NULL, NULL, NULL), ARGS_HELP);
    assert_int_equal(parse("scene", "-h", "--nonsense", NULL), ARGS_HELP);
}

UNIT_TEST(wrong_usage_is_named) {
    assert_wrong("--sppp", "4", "unknown option --sppp; did you mean --spp?");
    assert_wrong("--expsoure=2", NULL, "did you mean --exposure?");
    assert_wrong("--zebra", NULL, "unknown option --zebra");
    assert_null(strstr(problem.text, "did you mean"));
    assert_wrong("-x", NULL, "unknown option -x");
    assert_wrong("--spp", NULL, "--spp: expected a value");
    assert_wrong("--spp", "--quiet", "--spp: expected a value");
    assert_wrong("-o", NULL, "-o: expected a value");
    assert_wrong("--quiet=1", NULL, "--quiet takes no value");
    assert_wrong("-qx", NULL, "-q takes no value");
    assert_wrong("--output=", NULL, "--output: expected IMAGE, found nothing");
    assert_wrong("--text=", NULL, "--text: expected TEXT, found nothing");
    assert_wrong("second", NULL, "unexpected argument \"second\"");
    assert_int_equal(parse("--quiet", NULL, NULL, NULL), ARGS_WRONG);
    assert_string_equal(problem.text, "SCENE is missing");
}

UNIT_TEST(whole_numbers_are_whole) {
    static const char *const wrong[] = {"",    "0",     "65537", "-1",  "+1",  "1.0",
                                        "1e2", "0x10",  "12x",   " 12", "12 ", "one",
                                        "nan", "1,000", "1 0",   "٣",   "1\n", "18446744073709551617"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        const char *text = unit_text("--spp=%s", wrong[i]);
        assert_wrong(text, NULL, "--spp: expected a whole number from 1 to 65536, found");
        assert_int_equal(got.spp, 7);
    }
    assert_int_equal(parse("scene", "--spp=1", NULL, NULL), ARGS_READY);
    assert_int_equal(parse("scene", "--spp=65536", NULL, NULL), ARGS_READY);
    assert_int_equal(got.spp, 65536);
    assert_int_equal(parse("scene", "--seed=18446744073709551615", NULL, NULL), ARGS_READY);
    assert_true(got.seed == UINT64_MAX);
    assert_wrong("--seed=18446744073709551616", NULL, "from 0 to 2^64 - 1");
    assert_wrong("--seed=99999999999999999999999", NULL, "from 0 to 2^64 - 1");
}

UNIT_TEST(counts_have_units) {
    static const struct {
        const char *text;
        uint64_t count;
    } right[] = {{"1", 1},           {"20k", 20000},         {"8M", 8000000},
                 {"1G", 1000000000}, {"100G", 100000000000}, {"3e2", 300},
                 {"7e0", 7},         {"1e11", 100000000000}};
    for (size_t i = 0; i < sizeof right / sizeof *right; ++i) {
        assert_int_equal(parse("scene", "-t", right[i].text, NULL), ARGS_READY);
        assert_true(got.triangles == right[i].count);
    }
    static const char *const wrong[] = {
        "0",    "101G", "8m", "8MM",  "k",     "8 M",  "1.5M", "-8M", "18446744073709551615G",
        "1e12", "1e",   "e1", "1e2x", "1e2e1", "1e-1", "0e0"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        assert_wrong("-t", wrong[i], "-t: expected a whole number from 1 to 100000000000");
    }
    assert_wrong("-t", "0e18446744073709551615", "-t: expected a whole number from 1 to 100000000000");
}

UNIT_TEST(counts_make_lists) {
    assert_int_equal(parse("scene", "--counts", "1,20k,3e2", NULL), ARGS_READY);
    assert_int_equal(got.counts.count, 3);
    assert_true(got.counts.items[0] == 1 && got.counts.items[1] == 20000 && got.counts.items[2] == 300);
    static const char *const wrong[] = {"", "1,", ",1", "1,,2", "1;2", "1,x"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        const char *text = unit_text("--counts=%s", wrong[i]);
        assert_wrong(text, NULL, "--counts: expected a whole number from 1 to 100000000000");
        assert_int_equal(got.counts.count, 0);
    }
    char many[2 * ARGS_LIST_MAX + 3] = "";
    for (int i = 0; i < ARGS_LIST_MAX; ++i) strcat(many, i ? ",1" : "1");
    assert_int_equal(parse("scene", "--counts", many, NULL), ARGS_READY);
    assert_int_equal(got.counts.count, ARGS_LIST_MAX);
    strcat(many, ",1");
    assert_wrong("--counts", many, "--counts: expected at most 16 numbers, found more");
    char long_one[200];
    memset(long_one, '1', sizeof long_one - 1);
    long_one[sizeof long_one - 1] = '\0';
    assert_wrong("--counts", long_one, "--counts: expected a whole number from 1 to 100000000000");
}

UNIT_TEST(sizes_have_two_sides) {
    assert_int_equal(parse("scene", "--size", "1x100", NULL), ARGS_READY);
    assert_true(got.size.width == 1 && got.size.height == 100);
    static const char *const wrong[] = {"0x1", "1x0", "101x1", "1x101", "1", "1x", "x1", "1x1x1", "1X1"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i)
        assert_wrong("--size", wrong[i], "--size: expected WIDTHxHEIGHT, each from 1 to 100");
}

UNIT_TEST(numbers_are_decimal_and_finite) {
    static const struct {
        const char *text;
        double number;
    } right[] = {{"0", 0}, {"1e-5", 1e-5}, {".5", 0.5}, {"10", 10}, {"+2.5E0", 2.5}, {"1e-400", 0}};
    for (size_t i = 0; i < sizeof right / sizeof *right; ++i) {
        assert_int_equal(parse("scene", "--epsilon", right[i].text, NULL), ARGS_READY);
        assert_true(got.epsilon == right[i].number);
    }
    static const char *const wrong[] = {"",    "-1", "10.1", "1e999", "nan", "inf", "0x1p-3",
                                        "1,5", "1e", ".",    "1.5x",  " 1",  "1 ",  "e5"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        const char *text = unit_text("--epsilon=%s", wrong[i]);
        assert_wrong(text, NULL, "--epsilon: expected a number from 0 to 10, found");
    }
}

UNIT_TEST(choices_are_exact) {
    static const char *const words[] = {"grid", "stratified", "sobol"};
    for (unsigned i = 0; i < 3; ++i) {
        assert_int_equal(parse("scene", "--pattern", words[i], NULL), ARGS_READY);
        assert_int_equal(got.pattern, i);
    }
    static const char *const wrong[] = {"gri", "grids", "Grid", "sobol ", "grid|sobol", "|"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        assert_wrong("--pattern", wrong[i], "--pattern: expected grid|stratified|sobol, found");
    }
}

UNIT_TEST(lists_end) {
    char *argv[2 + ARGS_LIST_MAX + 1] = {(char *)(uintptr_t) "render", (char *)(uintptr_t) "scene"};
    for (int i = 0; i <= ARGS_LIST_MAX; ++i) argv[2 + i] = (char *)(uintptr_t) "-ofile";
    got = (settings){.spp = 1};
    assert_int_equal(args_parse(&spec, 2 + ARGS_LIST_MAX, argv, &got, &problem), ARGS_READY);
    assert_int_equal(got.outputs.count, ARGS_LIST_MAX);
    got = (settings){.spp = 1};
    assert_int_equal(args_parse(&spec, 3 + ARGS_LIST_MAX, argv, &got, &problem), ARGS_WRONG);
}

UNIT_TEST(the_nearest_name) {
    static const char *const names[] = {"render", "info", "generate", NULL, "help"};
    assert_string_equal(args_nearest("rendr", names, 5), "render");
    assert_string_equal(args_nearest("renedr", names, 5), "render");
    assert_string_equal(args_nearest("Info", names, 5), "info");
    assert_string_equal(args_nearest("generat", names, 5), "generate");
    assert_null(args_nearest("xyzzy", names, 5));
    assert_null(args_nearest("", names, 5));
    char long_name[300];
    memset(long_name, 'a', sizeof long_name - 1);
    long_name[sizeof long_name - 1] = '\0';
    assert_null(args_nearest(long_name, names, 5));
}

int main(void) { return unit_main(NULL, NULL); }
