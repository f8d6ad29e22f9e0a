/* Where scene JSON is wrong: the line, the place, and no crash on whatever bytes come. */
#include "json_group.h"

static const char whole[] =
    "{\n"                                                                                             /* 1 */
    "  \"$schema\": \"a \\\" } ] { [ \\\\\",\n"                                                       /* 2 */
    "  \"na\\u006de\": \"\\n\\u0041\", \"camera\": {\"eye\": [0, 0, 5],\n"                            /* 3 */
    "    \"target\": [0, 0, 0]},\n"                                                                   /* 4 */
    "  \"image\": {\"width\": 64, \"height\": 64,\n"                                                  /* 5 */
    "    \"spp\": 4, \"integrator\": \"classic\", \"aovs\": [\"Z\", \"N\"]},\n"                       /* 6 */
    "  \"background\": [0.1, 0.2, 0.3], \"ambient\": [0, 0, 0],\n"                                    /* 7 */
    "  \"materials\": {\"dark \\\"red\": {\"kd\": [0.5, 0, 0], \"specular\": \"blinn\",\n"            /* 8 */
    "    \"ks\": [1, 1, 1], \"kr\": [0, 0, 1], \"fresnel\": true}},\n"                                /* 9 */
    "  \"lights\": [{\"type\": \"spot\", \"position\": [0, 9, 0], \"target\": [0, 0, 0],\n"           /* 10 */
    "      \"innerAngle\": 10},\n"                                                                    /* 11 */
    "    {\"type\": \"directional\", \"direction\": [0, -1, 0]}],\n"                                  /* 12 */
    "  \"groups\": {\"a\": [{\"type\": \"mesh\", \"file\": \"triangle.obj\"}],\n"                     /* 13 */
    "    \"b\": [{\"type\": \"instance\", \"of\": \"a\", \"rotation\": [0, 0, 0, 1]}]},\n"            /* 14 */
    "  \"objects\": [\n"                                                                              /* 15 */
    "    {\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 1},\n"                             /* 16 */
    "    {\"type\": \"triangle\", \"vertices\": [[0, 0, 0], [1, 0, 0],\n"                             /* 17 */
    "      [0, 1, 0]], \"material\": \"dark \\\"red\"},\n"                                            /* 18 */
    "    {\"type\": \"group\", \"scale\": [2, 2, 2], \"children\": [\n"                               /* 19 */
    "      {\"type\": \"plane\", \"point\": [0, 0, 0], \"normal\": [0, 1, 0]},\n"                     /* 20 */
    "      {\"type\": \"quad\", \"center\": [0, 0, 0], \"u\": [1, 0, 0], \"v\": [0, 1, 0]}\n"         /* 21 */
    "    ]},\n"                                                                                       /* 22 */
    "    {\"type\": \"mesh\", \"positions\": [[0, 0, 0], [1, 0, 0], [0, 1, 0]],\n"                    /* 23 */
    "      \"indices\": [[0, 1, 2]], \"shading\": \"smooth\",\n"                                      /* 24 */
    "      \"frame\": {\"origin\": [0, 0, 0], \"z\": [0, 0, 1]}},\n"                                  /* 25 */
    "    {\"type\": \"instance\", \"of\": \"b\", \"rotate\": {\"axis\": [0, 1, 0], \"angle\": 30}}\n" /* 26 */
    "  ]\n"                                                                                           /* 27 */
    "}\n";                                                                                            /* 28 */

UNIT_TEST(the_whole_is_good) { json_scene_good(&s, whole); }

/* `whole` with the first `from` replaced is refused at this line and place. */
static void assert_refused(const char *from, const char *to, unsigned line, const char *message) {
    const char *found = strstr(whole, from);
    assert_non_null(found);
    const char *text = unit_text("%.*s%s%s", (int)(found - whole), whole, to, found + strlen(from));
    json_scene_bad(&s, text, unit_text("%s:%u: %s", s.file, line, message));
}

UNIT_TEST(lines_and_places) {
    assert_refused("\"\\n\\u0041\"", "7", 3, "name: expected a string, found 7");
    /* Cut before the character that would not fit whole. */
    assert_refused(
        "64, \"height\"", "\"aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa\xc3\xa9\", \"height\"", 5,
        "image.width: expected an integer in [1, 65536], found \"aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa...");
    assert_refused("[0, 0, 5]", "[0, 0, \"x\"]", 3, "camera.eye[2]: expected a number, found \"x\"");
    assert_refused("[0, 0, 0]},", "[0, 0, 5]},", 4, "camera.target: it is where the eye is");
    assert_refused("\"width\": 64", "\"width\": 0", 5,
                   "image.width: expected an integer in [1, 65536], found 0");
    assert_refused("\"spp\": 4", "\"spp\": 5", 6, "image.spp: the pattern is n x n");
    assert_refused("\"N\"]", "\"Z\"]", 6, "image.aovs[1]: \"Z\" is there twice");
    assert_refused("\"ks\"", "\"ls\"", 9, "materials[\"dark \"red\"].ls: unknown key; did you mean \"ks\"?");
    assert_refused("10}", "90}", 11, "lights[0].innerAngle: expected a number in [0, 90), found 90");
    assert_refused("[0, -1, 0]", "[0, 0, 0]", 12, "lights[1].direction: expected numbers that are not all 0");
    assert_refused("\"a\", \"rotation\"", "\"x\", \"rotation\"", 14,
                   "groups.b[0].of: there is no group \"x\"");
    assert_refused("\"a\", \"rotation\"", "\"b\", \"rotation\"", 13,
                   "groups: groups contain each other in a cycle: \"b\"");
    assert_refused("\"radius\": 1", "\"radius\": -1", 16,
                   "objects[0].radius: expected a number > 0, found -1");
    assert_refused(", \"radius\": 1", "", 16, "objects[0]: \"radius\" is missing; every sphere needs it");
    assert_refused(
        "      [0, 1, 0]]", "      [0, 1]]", 18,
        "objects[1].vertices[2]: expected an array of 3 numbers in [-1e+30, 1e+30], found an array of 2");
    assert_refused("[2, 2, 2]", "[2, 0, 2]", 19,
                   "objects[2].scale[1]: expected a number other than 0, found 0");
    assert_refused("\"normal\"", "\"norml\"", 20,
                   "objects[2].children[0].norml: unknown key; did you mean \"normal\"?");
    assert_refused("[0, 1, 0]}\n", "[2, 0, 0]}\n", 21, "objects[2].children[1]: quad: it has no area");
    assert_refused("[[0, 1, 2]]", "[[0, 1, 3]]", 24, "objects[3].indices[0][2]: expected an integer < 3");
    assert_refused("\"angle\": 30", "\"angle\": null", 26,
                   "objects[4].rotate.angle: expected a number, found null");
}

/* What a mesh file says comes behind the place that names it. */
UNIT_TEST(mesh_files) {
    char inner[160];
    snprintf(inner, sizeof inner, "groups.a[0].file: %s/none.obj: ", s.folder);
    assert_refused("triangle.obj", "none.obj", 13, inner);
    snprintf(inner, sizeof inner, "groups.a[0].file: %s/scene.json: the extension .json is not known",
             s.folder);
    assert_refused("triangle.obj", "scene.json", 13, inner);
}

/* Not JSON at all: the line and the column. */
UNIT_TEST(syntax) {
    const struct {
        const char *text, *message;
    } cases[] = {{"{\n \"objects\": [1,]}", "scene.json:2:16: "},
                 {"{\n \"objects\": []\n", "scene.json:3:"},
                 {"{\"objects\": [],\n \"objects\": []}", "scene.json:2:"},
                 {"{\"objects\": [],\n \"objects\": []}", "duplicate object key"},
                 {"{\n\"ambient\": [0, 1e999, 0]}", "scene.json:2:"},
                 {"{\n\"ambient\": [0, 1e999, 0]}", "real number overflow"},
                 {"{\n\"ambient\": [0, NaN, 0]}", "scene.json:2:"},
                 {"{} {}", "scene.json:1:"},
                 {"\xff\xfe{\0}\0", "scene.json:1:"},
                 {"// no\n{}", "scene.json:1:"},
                 {"{\"name\": \"a\\u0000b\", \"objects\": []}", "scene.json:1:"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        json_scene_bad(&s, cases[i].text, cases[i].message);
    fathom_scene *scene;
    assert_fails(s.context, json_scene_read(&s, "", 0, &scene), FATHOM_BAD_INPUT,
                 "scene.json: the file is empty");
    assert_fails(s.context, json_scene_read(&s, "{\0}", 3, &scene), FATHOM_BAD_INPUT, "scene.json:1:");
    json_scene_bad(&s, "\xEF\xBB\xBF{\"objects\": 3}", "scene.json:1: objects: expected an array, found 3");
    json_scene_good(&s, "\xEF\xBB\xBF{\"objects\": []}");
}

/* Numbers mean the same however they are written. */
UNIT_TEST(numbers) {
    fathom_scene *scene =
        json_scene_good(&s, "{\"image\": {\"width\": 4e2, \"height\": 300.0, \"spp\": 0.4e1}, \"objects\":"
                            "[{\"type\": \"sphere\", \"center\": [100000000000000000000000, -0, 1e-320],"
                            "\"radius\": 1E+300}]}");
    assert_true(scene->settings.width == 400 && scene->settings.height == 300 && scene->settings.spp == 4);
    assert_true(scene->spheres.items[0].center[0] == 1e23 && scene->spheres.items[0].radius == 1e300);
}

/* A nest of `depth` groups around a sphere; NULL-terminated text, to be freed. */
static char *nest(size_t depth) {
    static const char open[] = "{\"type\":\"group\",\"children\":[",
                      inmost[] = "{\"type\":\"sphere\",\"center\":[0,0,0],\"radius\":1}";
    char *text = malloc(depth * (sizeof open + 2) + 256), *end = text;
    end += sprintf(end, "{\"objects\":[");
    for (size_t i = 0; i < depth; ++i) end += sprintf(end, "%s", open);
    end += sprintf(end, "%s", inmost);
    for (size_t i = 0; i < depth; ++i) end += sprintf(end, "]}");
    sprintf(end, "]}");
    return text;
}

/* Down to 512 levels is read, with a stack of 1 MB (tests/cli/nested.sh); deeper is an error, not a crash. */
UNIT_TEST(deep_nests) {
    char *text = nest(512);
    fathom_scene *scene = json_scene_good(&s, text);
    assert_int_equal(scene->instances.count, 512);
    free(text);
    text = nest(513);
    json_scene_bad(&s, text, "children are nested more than 512 levels");
    free(text);
    text = nest(100000);
    json_scene_bad(&s, text, "brackets are nested too deep");
    free(text);
}

/* A hundred thousand groups, each placing the next: good as a chain, refused as a ring. */
UNIT_TEST(long_chains) {
    const size_t count = 100000;
    char *text = malloc(count * 64 + 256), *end = text;
    end += sprintf(end, "{\"groups\":{");
    for (size_t i = 0; i < count; ++i)
        end += sprintf(end, "%s\"g%zu\":[{\"type\":\"instance\",\"of\":\"g%zu\"}]", i ? "," : "", i, i + 1);
    char *last = end;
    end += sprintf(end, ",\"g%zu\":[]},\"objects\":[]}", count);
    json_scene_good(&s, text);
    sprintf(last, ",\"g%zu\":[{\"type\":\"instance\",\"of\":\"g0\"}]},\"objects\":[]}", count);
    json_scene_bad(&s, text, "scene.json:1: groups: groups contain each other in a cycle");
    free(text);
}

/* A ring through groups that are deep in themselves: no stack holds all of it at once. */
UNIT_TEST(deep_rings) {
    enum { count = 300, depth = 400 };
    char *text = malloc(count * (depth * 40 + 100)), *end = text;
    end += sprintf(end, "{\"groups\":{");
    for (int i = 0; i < count; ++i) {
        end += sprintf(end, "%s\"g%d\":[", i ? "," : "", i);
        for (int k = 0; k < depth; ++k) end += sprintf(end, "{\"type\":\"group\",\"children\":[");
        end += sprintf(end, "{\"type\":\"instance\",\"of\":\"g%d\"}", (i + 1) % count);
        for (int k = 0; k < depth; ++k) end += sprintf(end, "]}");
        end += sprintf(end, "]");
    }
    sprintf(end, "},\"objects\":[]}");
    json_scene_bad(&s, text, "scene.json:1: groups: groups contain each other in a cycle");
    free(text);
}

/* ---- mutations ---- */

static uint64_t next_random(uint64_t *state) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return *state >> 33;
}

/* Changes, drops, doubles or moves a few bytes, most often by pieces that JSON is made of. */
static size_t mutate(char *text, size_t size, uint64_t *random) {
    static const char *const pieces[] = {
        "{",   "}",    "[",    "]",        ",",        ":",      "\"",      "\\",   "0",       "-1",
        "1e9", "null", "true", "\"type\"", "\"mesh\"", "\"of\"", "[0,0,0]", "\xff", "\\ud800", "1e-310"};
    for (uint64_t edits = next_random(random) % 3 + 1; edits; --edits) {
        size_t at = next_random(random) % size, length = next_random(random) % 12;
        if (at + length > size) length = size - at;
        const char *piece = pieces[next_random(random) % (sizeof pieces / sizeof *pieces)];
        size_t added = next_random(random) % 3 ? strlen(piece) : 0;
        memmove(text + at + added, text + at + length, size - at - length);
        memcpy(text + at, piece, added);
        size = size - length + added;
    }
    return size;
}

/* Whatever the bytes, the answer is a scene or a message that names the file. */
UNIT_TEST(mutations) {
    uint64_t random = 20240229;
    unsigned read = 0, refused = 0;
    for (int i = 0; i < 10000; ++i) {
        char text[sizeof whole + 64];
        memcpy(text, whole, sizeof whole);
        size_t size = mutate(text, sizeof whole - 1, &random);
        fathom_scene *scene;
        unit_end_things(0);
        fathom_status status = json_scene_read(&s, text, size, &scene);
        if (status == FATHOM_OK) {
            ++read;
            continue;
        }
        ++refused;
        assert_int_equal(status, FATHOM_BAD_INPUT);
        assert_memory_equal(fathom_context_message(s.context), s.file, strlen(s.file));
    }
    /* Both must happen, or nothing was tried. */
    assert_true(read > 100 && refused > 5000);
}

int main(void) { return unit_main(setup, teardown); }
