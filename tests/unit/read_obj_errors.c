/* OBJ and MTL files that are wrong: one message each, with the line, and nothing left behind. */
#include "mesh_file.h"

static const read_mesh_options plain = {.material = FATHOM_NONE};

static void expect_error_with(const char *text, size_t size, read_mesh_options options, const char *message) {
    fathom_status status;
    assert_null(mesh_try(read_obj, mesh_write("a.obj", text, size), options, &status));
    assert_int_equal(status, FATHOM_BAD_INPUT);
    if (!strstr(fathom_context_message(context), message)) {
        fail_msg("message \"%s\" does not hold \"%s\"", fathom_context_message(context), message);
    }
}

static void expect_error(const char *text, const char *message) {
    expect_error_with(text, strlen(text), plain, message);
}

#define TRIANGLE "v 0 0 0\nv 1 0 0\nv 0 1 0\n"

UNIT_TEST(wrong_vertices_name_their_line) {
    expect_error("v 0 0\n", "a.obj:1: v: number 3 of 3: expected a number, found the end of the line");
    expect_error(TRIANGLE "v 0 zero 0\n", "a.obj:4: v: number 2 of 3: expected a number, found \"zero\"");
    expect_error("v 0 1,5 0\n", "found \"1,5\"");
    expect_error("v 0 0 1.5.5\n", "found \"1.5.5\"");
    expect_error("v nan 0 0\nv 0 -inf 0\nv 0 0 1e39\nf 1 2 3\n",
                 "a.obj: it has no vertex of finite numbers that fit a float, of 3");
    expect_error(TRIANGLE "v nan 0 0\nf 1 2 4\n", "it has no faces");
    expect_error("vt\n", "vt: number 1 of 2: expected a number");
    expect_error("vt x\n", "vt: number 1 of 2: expected a number, found \"x\"");
    expect_error("\n\nvn 0 0\n", "a.obj:3: vn: number 3 of 3");
    expect_error("v 1 \\\n2 \\\nx\n", "a.obj:3: v: number 3 of 3");
}

UNIT_TEST(wrong_faces_name_their_line) {
    expect_error(TRIANGLE "f 1 2 4\n", "a.obj:4: f: corner 3: v: index 4 is out of range; the file has 3");
    expect_error(TRIANGLE "f 1 2 -4\n",
                 "a.obj:4: f: corner 3: v: index -4 goes back beyond the first; there are 3 above");
    expect_error("v 0 0 0\nf -1 -1 -2\n" TRIANGLE,
                 "a.obj:2: f: corner 3: v: index -2 goes back beyond the first; there are 1");
    expect_error(TRIANGLE "f 0 1 2\n", "corner 1: v: 0 is no index");
    expect_error(TRIANGLE "f 1 2 99999999999999999999999\n", "corner 3: v: index");
    expect_error(TRIANGLE "f 1 2 x\n", "corner 3: v: expected an index, found \"x\"");
    expect_error(TRIANGLE "f 1 2 3.5\n", "corner 3: expected v, v/vt, v//vn or v/vt/vn, found \"3.5\"");
    expect_error(TRIANGLE "vt 0 0\nf 1/1/1/1 2 3\n", "corner 1: expected v, v/vt, v//vn or v/vt/vn");
    expect_error(TRIANGLE "s red\nf 1 2 3\n", "a.obj:4: s: expected a number, on or off, found \"red\"");
}

/* Of several faults the one that comes first in the file is told, whichever thread met it. */
UNIT_TEST(the_first_fault_is_reported) {
    const size_t lines = 200000;
    char *text = malloc(lines * 16 + 64), *p = text;
    for (size_t i = 0; i < lines; ++i) p += sprintf(p, i == 60000 || i == 150000 ? "v x 0 0\n" : "v 1 2 3\n");
    for (unsigned threads = 1; threads < 8; threads += 3) {
        fathom_context_set_threads(context, threads);
        expect_error_with(text, (size_t)(p - text), plain, "a.obj:60001: v: number 1");
    }
    fathom_context_set_threads(context, 0);
    free(text);
}

UNIT_TEST(files_without_faces_are_refused) {
    fathom_status status;
    expect_error("# nothing\n", "it has no faces (0 vertices)");
    expect_error(TRIANGLE "f 1 2\n", "a.obj: it has no faces (3 vertices)");
    expect_error(TRIANGLE "l 1\n", "it has no faces");
    expect_error("v 3.4e38 0 0\nv -3.4e38 0 0\n", "a.obj: has points as far out as 3.4e+38");
    expect_error(TRIANGLE "l 1 4\n", "a.obj:4: l: corner 2: v: index 4 is out of range; the file has 3");
    expect_error(TRIANGLE "p 1 x\n", "a.obj:4: p: corner 2: v: expected an index, found \"x\"");
    expect_error_with("\x7f"
                      "ELF\0\0\0\0",
                      8, plain, "a.obj:1: a zero byte; expected text");
    assert_null(mesh_try(read_obj, in_folder("none.obj"), plain, &status));
    assert_fails(context, status, FATHOM_BAD_INPUT, "none.obj: No such file");
    assert_null(mesh_try(read_obj, mesh_write("empty.obj", "", 0), plain, &status));
    assert_fails(context, status, FATHOM_BAD_INPUT, "empty");
    assert_null(mesh_try(read_obj, folder, plain, &status));
    assert_fails(context, status, FATHOM_BAD_INPUT, "is a folder");
}

/* A file that holds a bit of everything, cut after each byte: read or refused, and never more (the sanitizers
 * watch). */
UNIT_TEST(truncation_anywhere_does_no_harm) {
    const char mtl[] = "newmtl a\nKd 0.5 0.5 \\\n0.5\nillum 7\nNi 1.5\nmap_Kd x.png\nd -halo 0.5\n";
    const char text[] =
        "# x\nmtllib m.mtl\nv 0 0 0\nv 1e0 0 .5 \\\n 1\nv 1 1 0\r\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl a\ns 1\n"
        "f 1/1/1 2/1/1 3/1/1\nf -4 -3 -2 -1\ns 2\nf 1 2 3 4\nl 1 2\nfoo\nf 1 4 2 3 1";
    for (size_t size = 1; size < sizeof text; ++size) {
        fathom_status status;
        mesh_write("m.mtl", mtl, 1 + size % (sizeof mtl - 1));
        mesh_try(read_obj, mesh_write("a.obj", text, size), plain, &status);
        assert_true(status == FATHOM_OK || status == FATHOM_BAD_INPUT);
        if (status != FATHOM_OK) assert_non_null(strstr(fathom_context_message(context), folder));
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
