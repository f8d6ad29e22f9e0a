/* Displays, views and configs: which there are, which is taken, and what linear Rec.709 is in a config of the
 * user's. */
#include "image/image.h"
#include "unit_folder.h"

#include <unistd.h>

static fathom_write_options defaults(void) { return (fathom_write_options){.exposure = 0}; }

static const float colors[5][3] = {
    {0.18f, 0.18f, 0.18f}, {0.5f, 0, 0}, {0, 0.5f, 0}, {0, 0, 0.5f}, {0.1f, 0.4f, 0.9f}};

/* Codes of the five colours. */
static void codes_of(const fathom_write_options *options, int codes[15]) {
    const char *const names[] = {"R", "G", "B"};
    image_channel channels[3];
    for (size_t c = 0; c < 3; ++c)
        channels[c] = (image_channel){names[c], IMAGE_FLOAT, true, &colors[0][c], 12};
    image img = {5, 1, 0, 0, 5, 1, channels, 3, NULL, 0, 0};
    assert_ok(context, image_write(context, &img, in_folder("a.png"), options));
    const image *back;
    assert_ok(context, image_read(context, in_folder("a.png"), &back));
    for (size_t i = 0; i < 15; ++i) {
        codes[i] = (int)lrintf(255 * ((const float *)back->channels[i % 3].data)[i / 3]);
    }
    image_release(back);
}

static void write_config(const char *name, const char *roles, const char *spaces) {
    FILE *f = fopen(in_folder(name), "w");
    assert_non_null(f);
    fprintf(f,
            "ocio_profile_version: 2\nroles:\n%s"
            "file_rules:\n  - !<Rule> {name: Default, colorspace: Plain}\n"
            "displays:\n  Screen:\n    - !<View> {name: Plain, colorspace: Plain}\n"
            "    - !<View> {name: Half, colorspace: Halved}\n    - !<View> {name: Data, colorspace: Data}\n"
            "  sRGB Monitor:\n    - !<View> {name: Half, colorspace: Halved}\n"
            "colorspaces:\n"
            "  - !<ColorSpace>\n    name: Data\n    isdata: true\n"
            "  - !<ColorSpace>\n    name: Halved\n    from_scene_reference: !<MatrixTransform>\n"
            "      {matrix: [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}\n%s",
            roles, spaces);
    assert_int_equal(fclose(f), 0);
}

#define PLAIN "  - !<ColorSpace>\n    name: Plain\n"

UNIT_TEST(unknown_names_are_listed) {
    fathom_write_options options = defaults();
    options.view = "Filmic";
    assert_fails(
        context, image_check(context, in_folder("a.png"), &options), FATHOM_BAD_USAGE,
        "no view of display \"sRGB\" is \"Filmic\"; expected one of: \"sRGB\", \"ACES 1.0 SDR\", \"Raw\"");
    options.display = "P3";
    assert_fails(context, image_check(context, in_folder("a.jpg"), &options), FATHOM_BAD_USAGE,
                 "no display \"P3\"; expected one of: \"sRGB\"");
    /* EXR goes through no view: one that another file of the same job asked for is no mistake. */
    assert_ok(context, image_check(context, in_folder("a.exr"), &options));
    options.display = "srgb", options.view = "aces 1.0 sdr";
    assert_ok(context, image_check(context, in_folder("a.tif"), &options));
}

UNIT_TEST(missing_and_broken_configs_are_reported) {
    fathom_write_options options = defaults();
    options.ocio = "/nowhere/config.ocio";
    assert_fails(context, image_check(context, in_folder("a.png"), &options), FATHOM_BAD_INPUT,
                 "/nowhere/config.ocio: cannot be read: No such file");
    setenv("OCIO", "/nowhere/else.ocio", 1);
    options.ocio = NULL;
    assert_fails(context, image_check(context, in_folder("a.png"), &options), FATHOM_BAD_INPUT,
                 "($OCIO) /nowhere/else.ocio");
    FILE *f = fopen(in_folder("broken.ocio"), "w");
    assert_non_null(f);
    fputs("ocio_profile_version: 2\ndisplays: [\n", f);
    fclose(f);
    options.ocio = in_folder("broken.ocio");
    assert_fails(context, image_check(context, in_folder("a.png"), &options), FATHOM_BAD_INPUT,
                 "broken.ocio");
    options.ocio = folder;
    assert_fails(context, image_check(context, in_folder("a.png"), &options), FATHOM_BAD_INPUT,
                 "is a folder");
    write_config("no-role.ocio", "  default: Plain\n", PLAIN);
    options.ocio = in_folder("no-role.ocio");
    assert_fails(context, image_check(context, in_folder("a.png"), &options), FATHOM_BAD_INPUT,
                 "aces_interchange");
    setenv("OCIO", "", 1); /* set to nothing is not set */
    options.ocio = NULL;
    assert_ok(context, image_check(context, in_folder("a.png"), &options));
    unsetenv("OCIO");
}

static void assert_codes(const int codes[15], float factor) {
    for (size_t i = 0; i < 15; ++i) {
        /* Half a code of rounding, and float. */
        assert_near(codes[i], 255 * (double)factor * (double)colors[i / 3][i % 3], 0.5 + 1e-4);
    }
}

UNIT_TEST(the_users_config_is_used) {
    int codes[15];
    fathom_write_options options = defaults();
    write_config("user.ocio", "  scene_linear: Plain\n", PLAIN);
    setenv("OCIO", in_folder("user.ocio"), 1);
    codes_of(&options, codes); /* first display, first view */
    assert_codes(codes, 1);
    options.view = "Half";
    codes_of(&options, codes);
    assert_codes(codes, 0.5f);
    unsetenv("OCIO");
    options.ocio = in_folder("user.ocio"), options.display = "sRGB Monitor", options.view = NULL;
    codes_of(&options, codes);
    assert_codes(codes, 0.5f);
}

/* A space with one of linear Rec.709's names goes before the role: in many configs scene_linear is ACEScg. */
UNIT_TEST(a_named_space_comes_before_roles) {
    int codes[15];
    fathom_write_options options = defaults();
    write_config("named.ocio", "  scene_linear: Plain\n",
                 PLAIN "  - !<ColorSpace>\n    name: any\n    aliases: [lin_rec709]\n"
                       "    to_scene_reference: !<MatrixTransform>\n"
                       "      {matrix: [0.25, 0, 0, 0, 0, 0.25, 0, 0, 0, 0, 0.25, 0, 0, 0, 0, 1]}\n");
    options.ocio = in_folder("named.ocio");
    codes_of(&options, codes);
    assert_codes(codes, 0.25f);
}

/* Where the config tells ACES2065-1, the same light comes out of it as out of the built-in config. */
UNIT_TEST(interchange_leads_to_rec709) {
    int codes[15], expected[15];
    fathom_write_options options = defaults();
    options.view = "Raw";
    codes_of(&options, expected);
    write_config(
        "aces.ocio", "  aces_interchange: AP0\n  scene_linear: Plain\n",
        "  - !<ColorSpace>\n    name: AP0\n"
        "  - !<ColorSpace>\n    name: Plain\n    from_scene_reference: !<GroupTransform>\n"
        "      children:\n"
        "        - !<BuiltinTransform> {style: UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD}\n"
        "        - !<BuiltinTransform> {style: UTILITY - ACES-AP1_to_CIE-XYZ-D65_BFD, direction: inverse}\n"
        "        - !<BuiltinTransform> {style: UTILITY - ACES-AP1_to_LINEAR-REC709_BFD}\n");
    options.ocio = in_folder("aces.ocio");
    options.view = "Plain";
    codes_of(&options, codes);
    assert_memory_equal(codes, expected, sizeof codes);
    options.view = "Data"; /* data are not transformed, not even to ACES */
    codes_of(&options, codes);
    assert_memory_equal(codes, expected, sizeof codes);
}

static bool file_holds(const char *path, const char *bytes, size_t count) {
    static char text[1 << 16];
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    size_t size = fread(text, 1, sizeof text, f);
    fclose(f);
    return memmem(text, size, bytes, count) != NULL;
}

/* Marked as sRGB when it is: PNG's own chunk, TIFF's ICC profile, JPEG's EXIF tag 0xa001 (short, count 1). */
UNIT_TEST(srgb_files_are_marked) {
    static const struct {
        const char *file, *mark;
        size_t size;
    } marks[] = {{"m.png", "sRGB", 4},
                 {"m.tif", "mntrRGB XYZ ", 12},
                 {"m.jpg", "\x01\xa0\x03\x00\x01\x00\x00\x00\x01", 9}};
    static const char *const views[] = {"sRGB", "ACES 1.0 SDR", "Raw"};
    const char *const names[] = {"R", "G", "B"};
    image_channel channels[3];
    for (size_t c = 0; c < 3; ++c)
        channels[c] = (image_channel){names[c], IMAGE_FLOAT, true, &colors[0][c], 12};
    image_attribute software = {"Software", "Fathom test", NULL, 0};
    image img = {5, 1, 0, 0, 5, 1, channels, 3, &software, 1, 0};
    fathom_write_options options = defaults();
    for (size_t v = 0; v < 3; ++v) {
        options.view = views[v];
        for (size_t m = 0; m < 3; ++m) {
            assert_ok(context, image_write(context, &img, in_folder(marks[m].file), &options));
            assert_int_equal(file_holds(in_folder(marks[m].file), marks[m].mark, marks[m].size), v < 2);
            assert_true(file_holds(in_folder(marks[m].file), "Fathom test", 11));
        }
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
