/* Paths: which lead out of a folder, and what their parts are; and room in arrays. */
#include "base/array.h"
#include "base/file.h"
#include "unit_folder.h"

#include <sys/stat.h>
#include <unistd.h>

static const char *const folders[] = {"box", "box/inner", "box-two", "box.d"};
static const char *const files[] = {"scene",     "box/scene", "box/a",   "box/inner/a",
                                    "box-two/a", "box.d/a",   "box/...", "box/..a"};
#define COUNT(list) (sizeof(list) / sizeof *(list))

static int set_up(void **state) {
    if (open_folder(state) != 0) return -1;
    for (size_t i = 0; i < COUNT(folders); ++i) assert_int_equal(mkdir(in_folder(folders[i]), 0700), 0);
    for (size_t i = 0; i < COUNT(files); ++i) {
        FILE *file = fopen(in_folder(files[i]), "wb");
        assert_non_null(file);
        fclose(file);
    }
    assert_int_equal(symlink("../box-two", in_folder("box/link")), 0);
    assert_int_equal(symlink("inner", in_folder("box/within")), 0);
    return 0;
}

static int tear_down(void **state) {
    unlink(in_folder("box/link")), unlink(in_folder("box/within"));
    for (size_t i = 0; i < COUNT(files); ++i) unlink(in_folder(files[i]));
    for (size_t i = COUNT(folders); i-- > 0;) rmdir(in_folder(folders[i]));
    return remove_folder(state);
}

/* The name as a scene in `scene` has it. */
static fathom_status confine(const char *scene, const char *name) {
    char *path = file_beside(scene, name);
    assert_non_null(path);
    fathom_status status = file_confine(context, scene, path, name);
    free(path);
    return status;
}

UNIT_TEST(paths_inside_the_folder_are_allowed) {
    static const char *const within[] = {"a",          "./a",       "inner/a",  "inner/../a", "within/a",
                                         "inner//./a", "../box/a",  "...",      "..a",        "inner/none",
                                         "none/a",     "none/../a", ".../../a", "none/./a"};
    const char *scene = unit_text("%s", in_folder("box/scene"));
    for (size_t i = 0; i < COUNT(within); ++i) assert_ok(context, confine(scene, within[i]));
}

/* Folders that begin with the same letters are others; of files that are not there the words are judged. */
UNIT_TEST(paths_outside_the_folder_are_refused) {
    static const char *const outside[] = {"../box-two/a", "../box.d/a",  "../scene",      "link/a",
                                          "..",           "../none",     "inner/../../x", "../box-two/none",
                                          "./../x",       ".../../../x", "none/../../a"};
    const char *scene = unit_text("%s", in_folder("box/scene"));
    for (size_t i = 0; i < COUNT(outside); ++i)
        assert_fails(context, confine(scene, outside[i]), FATHOM_BAD_INPUT, "leads outside");
    assert_fails(context, confine(scene, in_folder("box/a")), FATHOM_BAD_INPUT, "is an absolute path");
    fathom_context_allow_outside(context, true);
    for (size_t i = 0; i < COUNT(outside); ++i) assert_ok(context, confine(scene, outside[i]));
    fathom_context_allow_outside(context, false);
}

/* All lies within the root; a scene without a folder lies in the working folder. */
UNIT_TEST(root_and_working_folders_confine_too) {
    assert_ok(context, confine("/fathom-no-such-scene", "etc/passwd"));
    assert_ok(context, confine("/fathom-no-such-scene", "tmp/../etc/passwd"));
    char before[4096];
    assert_non_null(getcwd(before, sizeof before));
    assert_int_equal(chdir(in_folder("box")), 0);
    assert_ok(context, confine("scene", "inner/a"));
    assert_fails(context, confine("scene", "../box-two/a"), FATHOM_BAD_INPUT, "the folder of scene");
    assert_fails(context, confine("scene", "../none"), FATHOM_BAD_INPUT, "leads outside");
    assert_int_equal(chdir(before), 0);
}

/* "Ä" is one byte in Latin-1, one character in UTF-8, and on macOS a letter and a mark. */
UNIT_TEST(names_are_found_in_any_encoding) {
    static const char *const forms[] = {"b\xc3\xa4\xc3\xb1", "B\xe4\xf1", "b\xc4\xd1", "ba\xcc\x88n\xcc\x83",
                                        "B\xc3\x84\xc3\x91"};
    static const char *const others[] = {"ban", "b\xc3\xa5\xc3\xb1", "b\xc3\xa4", "b\xc3\xa4\xc3\xb1\xc3\xb1",
                                         "b\xd7\xf1"};
    const size_t from = strlen(folder) + 1;
    for (size_t i = 0; i < COUNT(forms); ++i) {
        unit_write_file(in_folder(forms[i]), "", 0);
        for (size_t k = 0; k < COUNT(forms); ++k) {
            char *found = file_of_any_case(in_folder(forms[k]), from);
            assert_non_null(found);
            assert_string_equal(found, in_folder(forms[i]));
            free(found);
        }
        for (size_t k = 0; k < COUNT(others); ++k) assert_null(file_of_any_case(in_folder(others[k]), from));
        unlink(in_folder(forms[i]));
    }
}

/* Of each part that names nothing the letters of what is there; the first of several. */
UNIT_TEST(names_are_found_in_any_case) {
    static const char *const names[][2] = {{"box/inner/a", "box/inner/a"},
                                           {"BOX/Inner/A", "box/inner/a"},
                                           {"box//INNER/./A", "box//inner/./a"},
                                           {"Box-Two/a", "box-two/a"},
                                           {"box/../BOX.D/A", "box/../box.d/a"}};
    static const char *const none[] = {"box/inner/b", "boxes/a", "box/a/A", "BOX/inner/ab"};
    const size_t from = strlen(folder) + 1;
    for (size_t i = 0; i < COUNT(names); ++i) {
        char *found = file_of_any_case(in_folder(names[i][0]), from);
        assert_non_null(found);
        assert_string_equal(found, in_folder(names[i][1]));
        free(found);
    }
    for (size_t i = 0; i < COUNT(none); ++i) assert_null(file_of_any_case(in_folder(none[i]), from));
    /* What comes before is taken as it is. */
    char *upper = strdup(in_folder("box"));
    for (size_t i = 1; i < from; ++i)
        upper[i] = (char)(upper[i] >= 'a' && upper[i] <= 'z' ? upper[i] - 32 : upper[i]);
    assert_null(file_of_any_case(upper, from));
    free(upper);
}

UNIT_TEST(paths_split_into_stem_name_and_extension) {
    const struct {
        const char *path, *name, *extension;
        size_t stem;
    } cases[] = {{"a/b.c/scene.JSON", "scene.JSON", "json", 11},
                 {"a.b/c", "c", "", 5},
                 {"x.tar.gz", "x.tar.gz", "gz", 5},
                 {"a/.hidden", ".hidden", "hidden", 2},
                 {"end.", "end.", "", 3},
                 {"a.fifteen-letters", "a.fifteen-letters", "fifteen-letters", 1},
                 {"a.sixteen--letters", "a.sixteen--letters", "", 1}};
    for (size_t i = 0; i < COUNT(cases); ++i) {
        char extension[16];
        file_extension(cases[i].path, extension);
        assert_string_equal(extension, cases[i].extension);
        assert_int_equal(file_ends_in(cases[i].path, "json|gz"),
                         strcmp(extension, "json") == 0 || strcmp(extension, "gz") == 0);
        assert_int_equal(file_stem_length(cases[i].path), cases[i].stem);
        assert_string_equal(file_name(cases[i].path), cases[i].name);
    }
}

/* What no memory holds is refused, and what there is stays as it was. */
UNIT_TEST(impossible_array_sizes_change_nothing) {
    ARRAY(double) list = {.items = NULL};
    for (int i = 0; i < 100; ++i) assert_true(array_push(&list, i));
    const double *items = list.items;
    const size_t capacity = list.capacity;
    assert_false(array_room(&list, SIZE_MAX));
    assert_false(array_room(&list, SIZE_MAX / sizeof(double) - 99));
    assert_false(array_room(&list, SIZE_MAX / sizeof(double) - 100));
    assert_false(array_room(&list, SIZE_MAX / 64));
    assert_ptr_equal(list.items, items);
    assert_true(list.count == 100 && list.capacity == capacity);
    for (int i = 0; i < 100; ++i) assert_true(list.items[i] == i);
    assert_true(array_room(&list, 5000));
    assert_true(list.capacity >= 5100 && list.items[99] == 99);
    array_free(&list);
}

int main(void) { return unit_main(set_up, tear_down); }
