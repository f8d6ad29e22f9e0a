/* Memory that runs out, requests.h says how: in each command of the program, which then ends with code 4,
 * says something and leaves no file, or does all that it does with all its memory. */
#include "cli/bench/bench.h"
#include "cli/command.h"

#include "requests.h" /* last: cmocka defines words such as fail */

#include <sys/stat.h>

/* ---- a command, and what comes of it ---- */

#define WORDS_MAX 24

typedef struct result {
    fathom_status status;
    size_t out, err; /* bytes that it printed */
    bool wrote;      /* the file that it was asked for */
} result;

static FILE *streams[2]; /* what stands for standard output and error */
static int streams_before[2];

static size_t take_printed(int stream) {
    struct stat info;
    fflush(stream ? stderr : stdout);
    assert_int_equal(fstat(fileno(streams[stream]), &info), 0);
    return (size_t)info.st_size;
}

static void redirect(void) {
    fflush(NULL);
    for (int k = 0; k < 2; ++k) {
        rewind(streams[k]);
        assert_int_equal(ftruncate(fileno(streams[k]), 0), 0);
        assert_int_equal(lseek(fileno(streams[k]), 0, SEEK_SET), 0);
        assert_int_equal(dup2(fileno(streams[k]), k + 1), k + 1);
    }
}

static void restore(void) {
    fflush(NULL);
    for (int k = 0; k < 2; ++k) assert_int_equal(dup2(streams_before[k], k + 1), k + 1);
}

/* The words of a command; a file of the test's own folder begins with '@', and the one that it writes with
 * '>'. */
static result run(const command *c, const char *line) {
    char text[512], paths[WORDS_MAX][160], *argv[WORDS_MAX + 1], *place;
    const char *output = NULL;
    int argc = 1;
    snprintf(text, sizeof text, "%s", line);
    argv[0] = (char *)(uintptr_t)c->name;
    for (char *word = strtok_r(text, " ", &place); word; word = strtok_r(NULL, " ", &place)) {
        assert_in_range(argc, 1, WORDS_MAX - 1);
        snprintf(paths[argc], sizeof paths[argc], "%s/%s", folder, word + 1);
        argv[argc] = word[0] == '@' || word[0] == '>' ? paths[argc] : word;
        if (word[0] == '>') output = paths[argc];
        ++argc;
    }
    argv[argc] = NULL;
    redirect();
    result r = {.status = command_run(c, argc, argv)};
    r.out = take_printed(0), r.err = take_printed(1);
    restore();
    r.wrote = output && access(output, F_OK) == 0;
    if (r.wrote) unlink(output);
    unlink(in_folder("a.rescue.exr")), unlink(in_folder("b.rescue.exr")); /* pixels whose own file failed */
    return r;
}

/* Each request in turn. Numbers that are measured print as long as they please: no outputs are compared. */
static void exhaust_command(const command *c, const char *line) {
    failing = 0;
    result good = run(c, line);
    for (int i = 0; i < 2; ++i) {
        if (good.status != FATHOM_OK)
            fail_msg("%s %s: status %d without a fault", c->name, line, good.status);
        good = run(c, line); /* the first run brings what stays */
    }
    const unsigned long begin = requests;
    run(c, line);
    const unsigned long count = requests - begin;
    unsigned long refused = 0;
    for (unsigned long n = 1; n <= count; n += n < refused_each ? 1 : REFUSED_STEP) {
        const unsigned long held = block_count, before = requests;
        failing = before + n;
        const result now = run(c, line);
        failing = 0;
        if (now.status != FATHOM_OK && now.status != FATHOM_OUT_OF_RESOURCES)
            fail_msg("%s %s, request %lu: status %d", c->name, line, n, now.status);
        if (now.status != FATHOM_OK && !now.err) fail_msg("%s %s, request %lu: no message", c->name, line, n);
        if (now.status == FATHOM_OK && (now.wrote != good.wrote || (now.out > 0) != (good.out > 0)))
            fail_msg("%s %s, request %lu: another result", c->name, line, n);
        if (now.status != FATHOM_OK && now.wrote)
            fail_msg("%s %s, request %lu: failed, and there is a file", c->name, line, n);
        if (block_count > held)
            fail_msg("%s %s, request %lu: %lu blocks leaked, one of them request %lu", c->name, line, n,
                     block_count - held, leaked_request(before));
        refused += now.status != FATHOM_OK;
    }
    assert_true(refused > 0);
    print_message("%s %s: %lu requests, %lu refused\n", c->name, line, count, refused);
}

/* ---- the commands ---- */

UNIT_TEST(describing) {
    exhaust_command(&command_info, "@scene.json");
    exhaust_command(&command_info, "@scene.json --json");
    exhaust_command(&command_generate, "sphere -t 64 -o >made.ply");
}

UNIT_TEST(rendering) {
    exhaust_command(&command_render, "@scene.json -o >a.png --threads 1 --tracer linear -v");
    exhaust_command(&command_render, "@scene.json -o @b.png --stats @a.json --threads 1 --tracer linear -q");
    exhaust_command(&command_compare, "@b.png @b.png --flip");
}

UNIT_TEST(validating) {
    exhaust_command(&command_validate,
                    "@scene.json --rays 2 --families camera --tracer linear --threads 1 --json >a.json -v");
    exhaust_command(&command_validate,
                    "@scene.json --rays 2 --families camera --tracer embree --threads 1 -q");
    exhaust_command(&command_validate, "--replay @rays.txt");
}

UNIT_TEST(measuring) {
    refused_each = 200;
    exhaust_command(&command_bench_trace,
                    "@scene.json --tracer bvh --rays 64 --repeats 1 --seconds 1e-4 --json >a.json");
    exhaust_command(&command_bench_trace,
                    "--triangles 100 --tracer bvh --rays 64 --repeats 1 --seconds 1e-4 --csv >a.csv");
    exhaust_command(&command_bench_render, "@scene.json --spp 1 --threads 1 --repeats 1 --json >a.json");
    exhaust_command(&command_bench_error,
                    "@scene.json --max-spp 4 --reference-spp 4 --seeds 1 --tracer linear --json >a.json");
    exhaust_command(&command_bench_render,
                    "--triangles 100 --size 16x12 --spp 1 --threads 1 --repeats 1 --json >a.json");
    refused_each = REFUSED_EACH;
}

static const char scene_json[] =
    "{ \"camera\": { \"eye\": [0, 0.5, 5], \"target\": [0, 0, 0], \"fovy\": 40 },\n"
    "  \"image\": { \"width\": 16, \"height\": 12 },\n"
    "  \"lights\": [ { \"type\": \"point\", \"position\": [0, 3, 3], \"intensity\": 9 } ],\n"
    "  \"objects\": [ { \"type\": \"generate\", \"kind\": \"sphere\", \"triangles\": 64 },\n"
    "    { \"type\": \"sphere\", \"center\": [1, 0, 2], \"radius\": 0.5 } ] }\n";

static const char rays_txt[] = "linear camera 1 wrong 0 0 5 0 0 -1 0 inf triangles\n"
                               "linear camera 2 any-wrong 0 0 5 0 0 -1 0 inf triangles\n"
                               "bvh camera 3 wrong 0 0 5 0 0 -1 0 inf spheres\n";

static int begin(void **state) {
    (void)state;
    requests_begin();
    put("scene.json", scene_json), put("rays.txt", rays_txt);
    setenv("TMPDIR", folder, 1);
    for (int k = 0; k < 2; ++k) {
        streams[k] = tmpfile();
        streams_before[k] = dup(k + 1);
        if (!streams[k] || streams_before[k] < 0) return -1;
    }
    return 0;
}

static int end(void **state) {
    (void)state;
    for (int k = 0; k < 2; ++k) fclose(streams[k]), close(streams_before[k]);
    unlink(in_folder("scene.json")), unlink(in_folder("rays.txt")), unlink(in_folder("b.png")),
        unlink(in_folder("a.json"));
    return rmdir(folder);
}

int main(void) { return unit_main(begin, end); }
