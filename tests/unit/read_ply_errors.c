/* PLY files that are wrong: one message each, with the line of text or the byte, and nothing left behind. */
#include "ply_file.h"

#include "random.h"

static void expect_error(const ply_maker *m, const char *message) {
    fathom_status status;
    if (ply_try(m, &status)) fail_msg("read, expected \"%s\"", message);
    assert_int_equal(status, FATHOM_BAD_INPUT);
    if (!strstr(fathom_context_message(context), message)) {
        fail_msg("message \"%s\" does not hold \"%s\"", fathom_context_message(context), message);
    }
}

static void expect_text_error(const char *text, const char *message) {
    ply_maker m = {.flavour = ASCII};
    ply_text(&m, text);
    expect_error(&m, message);
}

#define START "ply\nformat ascii 1.0\n"

UNIT_TEST(wrong_headers_name_their_line) {
    expect_text_error("plx\n", "a.ply:1: expected \"ply\" as the first line of a PLY file, found \"plx\"");
    expect_text_error("ply", "a.ply:1: the file ends inside the header");
    expect_text_error(START, "a.ply:3: the file ends inside the header; expected end_header");
    expect_text_error("ply\nformat binary 1.0\n", "a.ply:2: format: expected ascii, binary_little_endian or");
    expect_text_error("ply\nformat ascii 2.0\n", "format: expected version 1.0, found \"2.0\"");
    expect_text_error("ply\nend_header\n", "a.ply:2: end_header: expected a format statement before it");
    expect_text_error(START "property float x\n", "a.ply:3: property: expected an element before it");
    expect_text_error(START "element vertex\n",
                      "a.ply:3: element vertex: expected a count, found the end of the line");
    expect_text_error(START "element vertex -1\n", "expected a count, found \"-1\"");
    expect_text_error(START "element\n", "element: expected a name and a count");
    expect_text_error(START "element vertex 1\nproperty half x\n",
                      "a.ply:4: property: the type \"half\" is not known");
    expect_text_error(START "element vertex 1\nproperty list uchar\n",
                      "the type the end of the line is not known");
    expect_text_error(START "element vertex 1\nproperty float\n", "a.ply:4: property: expected a name");
    expect_text_error(START "elephant\n",
                      "a.ply:3: expected format, comment, element, property or end_header");
    expect_text_error(START "end_header\n", "element vertex: the header has none");
    expect_text_error(START "element vertex 1\nproperty float x\nproperty float y\nend_header\n",
                      "a.ply:3: element vertex: it has no number z; expected x, y and z");
    expect_text_error(
        START
        "element vertex 1\nproperty float x\nproperty float y\nproperty list uchar float z\nend_header\n",
        "it has no number z");
    expect_text_error(START XYZ FACES(1) "element x 3\nend_header\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n3 0 1 2\n",
                      "a.ply:9: element x: it has no properties");
}

UNIT_TEST(files_without_faces_are_refused) {
    expect_text_error(
        START XYZ
        "element face 1\nproperty list uchar int corners\nend_header\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n1 0\n",
        "a.ply:7: element face: it has no list vertex_indices or vertex_index");
    expect_text_error(START XYZ FACES(1) "end_header\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n2 0 1\n",
                      "no faces: expected at least one with 3 corners");
}

/* Counts that the file has no room for are refused before anything is allocated for them. */
UNIT_TEST(false_counts_are_refused) {
    expect_text_error(
        START "element vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\n" FACES(
            1) "end_header\n0 0 0\n",
        "a.ply:3: element vertex: 4000000000 rows of at least 6 bytes do not fit into the 7 bytes");
    expect_text_error(
        START
        "element vertex 99999999999999999999\nproperty float x\nproperty float y\nproperty float z\n" FACES(
            1) "end_header\n0 0 0\n",
        "a.ply:3: element vertex:");
    ply_maker m;
    for (int flavour = LITTLE; flavour <= BIG; ++flavour) {
        ply_header(&m, (ply_flavour)flavour, XYZ FACES(1000000000), 0);
        ply_square(&m);
        expect_error(
            &m, "a.ply:7: element face: 1000000000 rows of at least 1 bytes do not fit into the 0 bytes");
        /* Lists that say they are longer than the file. */
        ply_header(&m, (ply_flavour)flavour, XYZ "element face 1\nproperty list uint int vertex_indices\n",
                   0);
        ply_square(&m);
        ROW(&m, "iiii", 4000000000.0, 0, 1, 2);
        expect_error(
            &m, "vertex_indices: a list of 4000000000 numbers does not fit into the 12 bytes that follow");
        ply_header(&m, (ply_flavour)flavour, XYZ "element face 1\nproperty list int int vertex_indices\n", 0);
        ply_square(&m);
        ROW(&m, "iiii", -3, 0, 1, 2);
        expect_error(&m, "vertex_indices: a list of length -3");
        ply_header(&m, (ply_flavour)flavour, XYZ "element face 1\nproperty list float int vertex_indices\n",
                   0);
        ply_square(&m);
        ROW(&m, "fiii", 2.5, 0, 1, 2);
        expect_error(&m, "vertex_indices: a list of length 2.5");
    }
}

UNIT_TEST(wrong_text_names_its_line) {
#define TEXT(rows) START XYZ FACES(1) "end_header\n" rows
    expect_text_error(TEXT("0 0 0\n0 x 0\n0 0 0\n0 0 0\n3 0 1 2\n"),
                      "a.ply:11: y: expected a number, found \"x\"");
    expect_text_error(TEXT("0 0 0\n0 0\n0 0 0\n0 0 0\n3 0 1 2\n"),
                      "a.ply:11: z: expected a number, found the end of the line");
    expect_text_error(TEXT("0 0 0\n0 0 0 7 a\n0 0 0\n0 0 0\n3 0 1 2\n"),
                      "a.ply:11: vertex: expected the end of the row, found \"a\"");
    expect_text_error(TEXT("0 0 0\n0 0 0\n0 nan 0\n0 0 0\n3 0 1 2\n"),
                      "a.ply: no faces remain: expected at least one whose corners are finite numbers");
    expect_text_error(TEXT("0 0 0\n0 0 0\n0 0 1e40\n0 0 0\n3 0 1 2\n"), "a.ply: no faces remain");
    expect_text_error(TEXT("nan 0 0\n0 -inf 0\n0 0 1.#QNAN\n0 0 -nan(ind)\n3 0 1 2\n"),
                      "a.ply: it has no vertex whose x, y and z are finite numbers that fit a float, of 4");
    expect_text_error(TEXT("0 0 0\n0 0 0\n0 0 0\n0 0 0\n3 0 1 4\n"),
                      "a.ply:14: face: vertex index 4 is out of range; there are 4 vertices");
    expect_text_error(TEXT("0 0 0\n0 0 0\n0 0 0\n0 0 0\n3 0 1 -1\n"),
                      "a.ply:14: face: vertex index -1 is out of range");
    expect_text_error(TEXT("0 0 0\n0 0 0\n0 0 0\n0 0 0\n3 0 1 1.5\n"),
                      "a.ply:14: vertex_indices: expected a whole number, found \"1.5\"");
    expect_text_error(TEXT("0 0 0\n0 0 0\n0 0 0\n0 0 0\n4 0 1 2\n"),
                      "a.ply:14: vertex_indices: expected a whole number, found the end");
    expect_text_error(TEXT("0 0 0\n0 0 0\n0 0 0\n0 0 0\n-1\n"),
                      "a.ply:14: vertex_indices: a list of -1 numbers");
    expect_text_error(TEXT("0 0 0\n0 0 0\n0 0 0\n\n  \n3 0 1 2\n"),
                      "a.ply:16: the file ends after 4 rows; its header promises 5");
}

UNIT_TEST(wrong_bytes_name_their_offset) {
    for (int flavour = LITTLE; flavour <= BIG; ++flavour) {
        for (size_t shift = 0; shift < 2; ++shift) {
            ply_maker m;
            char expected[96];
            ply_header(&m, (ply_flavour)flavour, XYZ FACES(2), shift);
            size_t body = m.size;
            ROW(&m, "fff fff fff fff", 0, 0, 0, 1, 0, 0, 1, (double)NAN, 0, 0, 1, (double)INFINITY);
            ROW(&m, "biii biii", 3, 0, 1, 2, 3, 0, 2, 3);
            expect_error(&m,
                         "a.ply: no faces remain: expected at least one whose corners are finite numbers");
            ply_header(&m, (ply_flavour)flavour, XYZ FACES(2), shift);
            ply_square(&m);
            ROW(&m, "biii biii", 3, 0, 1, 2, 3, 0, -2, 3);
            snprintf(expected, sizeof expected, "at byte %zu: face: vertex index -2 is out of range",
                     body + 48 + 13 + 5);
            expect_error(&m, expected);
            ply_header(&m, (ply_flavour)flavour, XYZ FACES(2), shift);
            ply_square(&m);
            ROW(&m, "biii biiii", 3, 0, 1, 2, 4, 0, 2, 3, 4);
            snprintf(expected, sizeof expected, "at byte %zu: face: vertex index 4 is out of range",
                     body + 48 + 13 + 13);
            expect_error(&m, expected);
            ply_header(&m, (ply_flavour)flavour,
                       XYZ "element face 1\nproperty list uchar double vertex_index\n", shift);
            ply_square(&m);
            ROW(&m, "bddd", 3, 0, 1, 1.5);
            expect_error(&m, "face: the index 1.5 is not a whole number");
            ply_header(&m, (ply_flavour)flavour,
                       XYZ "element face 1\nproperty list uchar int64 vertex_index\n", shift);
            ply_square(&m);
            ROW(&m, "blll", 3, 0, 1, -0x1p62);
            expect_error(&m, "face: the index -4.61169e+18 is not a whole number below 2^53");
        }
    }
}

/* Of several faults the one that comes first in the file is told, whichever thread found it. */
UNIT_TEST(the_first_fault_is_reported) {
    enum { faces = 300000, row = 13 };
    static const unsigned char right[row] = {3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0}, wrong = 7;
    ply_maker m;
    ply_header(&m, LITTLE, XYZ FACES(300000), 0);
    ply_square(&m);
    size_t size = m.size + (size_t)faces * row;
    unsigned char *bytes = unit_memory(size);
    memcpy(bytes, m.bytes, m.size);
    for (size_t i = 0; i < faces; ++i) memcpy(bytes + m.size + row * i, right, row);
    for (size_t i = 90000; i < faces; i += 90000) bytes[m.size + row * i + 1] = wrong;
    const char *path = mesh_write("a.ply", bytes, size);
    const char *expected = unit_text("at byte %zu: face: vertex index 7", m.size + row * 90000ul + 1);
    for (unsigned threads = 1; threads < 8; threads += 3) {
        fathom_status status;
        fathom_context_set_threads(context, threads);
        assert_null(mesh_try(read_ply, path, plain, &status));
        assert_fails(context, status, FATHOM_BAD_INPUT, expected);
    }
    fathom_context_set_threads(context, 0);
}

/* Files that hold a bit of everything, in all formats. */
static void make_any(ply_maker *m, int flavour, bool strips) {
    ply_header(m, (ply_flavour)flavour,
               strips ? "element vertex 4\nproperty double x\nproperty float y\nproperty short z\n"
                        "element tristrips 1\nproperty list int int vertex_indices\n"
                      : "element junk 2\nproperty list uchar short a\n" XYZ NORMALS FACES(3),
               0);
    if (strips) {
        ROW(m, "dfs dfs dfs dfs iiiiii", 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 5, 0, 1, 2, 3, -1);
        return;
    }
    ROW(m, "bss b", 2, 1, 2, 0);
    for (int i = 0; i < 4; ++i) ROW(m, "ffffff", i % 2, i / 2, 0, 0, 0, 1);
    ROW(m, "biii biiii bii", 3, 0, 1, 2, 4, 0, 1, 3, 2, 2, 0, 1);
}

static void read_or_refuse(const unsigned char *bytes, size_t size) {
    fathom_status status;
    mesh_try(read_ply, mesh_write("a.ply", bytes, size), plain, &status);
    assert_true(status == FATHOM_OK || status == FATHOM_BAD_INPUT);
    if (status != FATHOM_OK) assert_non_null(strstr(fathom_context_message(context), folder));
    unit_end_things(0);
}

/* Cut after each byte, and with random bytes changed: read or refused, and never more (the sanitizers watch).
 */
UNIT_TEST(damage_anywhere_does_no_harm) {
    random_state random = {11};
    for (int i = 0; i < 2 * FLAVOURS; ++i) {
        ply_maker m;
        make_any(&m, i / 2, i % 2);
        read_or_refuse(m.bytes, m.size);
        for (size_t size = 1; size < m.size; ++size) read_or_refuse(m.bytes, size);
        for (int round = 0; round < 1000; ++round) {
            ply_maker bad = m;
            for (int k = 0; k < 3; ++k)
                bad.bytes[random_bits(&random) % m.size] = (unsigned char)random_bits(&random);
            read_or_refuse(bad.bytes, bad.size);
        }
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
