/* Files that are truncated, changed or replaced while a scene is read, built and rendered: at known moments,
 * by the calls that report warnings and progress. */
#include "base/file.h"
#include "defaults.h"
#include "trace/trace.h"
#include "unit_folder.h"

#include <fathom/fathom.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* cmocka puts a handler of its own in place before each test. */
static struct sigaction guard_action;

static void guard(void) { assert_int_equal(sigaction(SIGBUS, &guard_action, NULL), 0); }

/* What is done to a file, and at which warning. */
typedef struct blow {
    const char *path, *warning;
    off_t left; /* bytes */
    bool struck;
} blow;

static void strike(blow *b) {
    if (b->struck) return;
    b->struck = true;
    assert_int_equal(truncate(b->path, b->left), 0);
}

static void strike_at_warning(void *user, const char *message) {
    blow *b = user;
    if (strstr(message, b->warning)) strike(b);
}

static bool strike_at_progress(void *user, const fathom_progress *progress) {
    (void)progress;
    strike(user);
    return true;
}

/* A ball of 20,000 triangles: half a megabyte, a hundred pages. */
static const char *write_ball(const char *name) {
    const char *path = in_folder(name);
    fathom_scene *scene;
    fathom_generate_options options = default_generate_options();
    options.triangles = 20000;
    unlink(path);
    assert_ok(context, fathom_scene_create(context, &scene));
    assert_ok(context, fathom_scene_generate(scene, FATHOM_ROOT, &options));
    assert_ok(context, fathom_scene_write(scene, path));
    fathom_scene_destroy(scene);
    return path;
}

static void write_text(const char *path, const char *mode, const char *text) {
    FILE *f = fopen(path, mode);
    assert_non_null(f);
    assert_true(fputs(text, f) >= 0);
    assert_int_equal(fclose(f), 0);
}

static fathom_settings small(void) {
    fathom_settings settings = default_settings();
    fathom_settings_set_integrator(&settings, FATHOM_INTEGRATOR_CLASSIC);
    settings.width = settings.height = 64;
    return settings;
}

static void fails_to_render(fathom_scene *scene, blow *at_progress, const char *text) {
    fathom_film *film;
    fathom_settings settings = small();
    assert_fails(context,
                 fathom_render(context, scene, &settings, at_progress ? strike_at_progress : NULL,
                               at_progress, NULL, &film),
                 FATHOM_BAD_INPUT, text);
    assert_null(film);
    fathom_scene_destroy(scene);
}

static const char *const mapped[] = {"ball.ply", "ball.glb"};
#define EACH_MAPPED(i) for (size_t i = 0; i < sizeof mapped / sizeof *mapped; ++i)

UNIT_TEST(truncation_before_rendering_is_an_error) {
    guard();
    EACH_MAPPED(i) {
        for (off_t left = 0; left <= 200000; left += 100000) {
            fathom_scene *scene;
            const char *path = write_ball(mapped[i]);
            assert_ok(context, fathom_scene_read(context, path, &scene));
            assert_ok(context, fathom_scene_check_files(scene));
            assert_int_equal(truncate(path, left), 0);
            assert_fails(context, fathom_scene_check_files(scene), FATHOM_BAD_INPUT, path);
            fails_to_render(scene, NULL, ": was truncated while it was read");
        }
    }
}

/* The file is gone as well: the fault itself has to be noticed. */
UNIT_TEST(truncation_of_a_removed_file_is_an_error) {
    guard();
    EACH_MAPPED(i) {
        fathom_scene *scene;
        const char *path = write_ball(mapped[i]);
        assert_ok(context, fathom_scene_read(context, path, &scene));
        assert_int_equal(truncate(path, 4096), 0);
        assert_int_equal(unlink(path), 0);
        fails_to_render(scene, NULL, ": was truncated while it was read, or cannot be read to its end");
    }
}

/* A triangle without area is warned about when the world is made, before Embree builds. */
UNIT_TEST(truncation_before_building_is_an_error) {
    guard();
    static const float flat[9] = {0};
    static const uint32_t corners[3] = {0, 1, 2};
    EACH_MAPPED(i) {
        fathom_scene *scene;
        fathom_mesh mesh = default_mesh();
        blow b = {.path = write_ball(mapped[i]), .warning = "without area"};
        mesh.positions = flat, mesh.vertex_count = 3, mesh.indices = corners, mesh.triangle_count = 1;
        assert_ok(context, fathom_scene_read(context, b.path, &scene));
        assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
        fathom_context_on_warning(context, strike_at_warning, &b);
        fails_to_render(scene, NULL, ": was truncated while it was read: 0 bytes are left of ");
        fathom_context_on_warning(context, NULL, NULL);
        assert_true(b.struck);
    }
}

UNIT_TEST(truncation_while_rendering_is_an_error) {
    guard();
    EACH_MAPPED(i) {
        fathom_scene *scene;
        blow b = {.path = write_ball(mapped[i]), .left = 5000};
        assert_ok(context, fathom_scene_read(context, b.path, &scene));
        fails_to_render(scene, &b, ": was truncated while it was read: 5000 bytes are left of ");
        assert_true(b.struck);
    }
}

static void fails_to_read(blow *b) {
    fathom_scene *scene;
    fathom_context_on_warning(context, strike_at_warning, b);
    assert_fails(context, fathom_scene_read(context, b->path, &scene), FATHOM_BAD_INPUT,
                 ": was truncated while it was read: ");
    fathom_context_on_warning(context, NULL, NULL);
    assert_true(b->struck);
    assert_null(scene);
}

/* OBJ warns between looking for statements and reading them, PLY between counting rows and reading them, glTF
 * between nodes. */
UNIT_TEST(truncation_while_reading_is_an_error) {
    guard();
    for (off_t left = 0; left <= 100000; left += 50000) {
        blow obj = {.path = write_ball("ball.obj"), .warning = "mtllib", .left = left};
        write_text(obj.path, "a", "mtllib none.mtl\n");
        fails_to_read(&obj);
        blow ply = {.path = in_folder("rows.ply"), .warning = "rows after", .left = left};
        write_text(ply.path, "w",
                   "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                   "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n");
        write_text(ply.path, "a", "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
        for (int i = 0; i < 20000; ++i) write_text(ply.path, "a", "0 0 0 0 0 0\n");
        fails_to_read(&ply);
    }
}

/* Flips a bit of the last byte. */
static void write_over(const char *path) {
    usleep(20000); /* the system's clock of files ticks a hundred times a second or more */
    FILE *f = fopen(path, "r+");
    assert_non_null(f);
    assert_int_equal(fseek(f, -1, SEEK_END), 0);
    int last = fgetc(f);
    assert_int_equal(fseek(f, -1, SEEK_END), 0);
    assert_true(last >= 0 && fputc(last ^ 1, f) >= 0);
    assert_int_equal(fclose(f), 0);
}

UNIT_TEST(a_changed_byte_is_an_error) {
    guard();
    EACH_MAPPED(i) {
        fathom_scene *scene;
        const char *path = write_ball(mapped[i]);
        assert_ok(context, fathom_scene_read(context, path, &scene));
        write_over(path);
        fails_to_render(scene, NULL, ": was changed while it was read");
    }
}

static bool write_over_at_progress(void *user, const fathom_progress *progress) {
    blow *b = user;
    if (progress->phase == FATHOM_PHASE_RENDER && !b->struck) write_over(b->path), b->struck = true;
    return true;
}

/* A render of which nobody would see the end does not go on for long. */
UNIT_TEST(a_render_of_a_changed_file_ends_soon) {
    guard();
    fathom_scene *scene;
    fathom_film *film;
    blow b = {.path = write_ball("ball.ply")};
    fathom_settings settings = small();
    settings.width = settings.height = 2048, settings.spp = 65536;
    assert_ok(context, fathom_scene_read(context, b.path, &scene));
    assert_fails(context, fathom_render(context, scene, &settings, write_over_at_progress, &b, NULL, &film),
                 FATHOM_BAD_INPUT, ": was changed while it was read");
    assert_null(film);
    fathom_scene_destroy(scene);
}

static double sum_of(fathom_scene *scene) {
    fathom_film *film;
    fathom_settings settings = small();
    assert_ok(context, fathom_render(context, scene, &settings, NULL, NULL, NULL, &film));
    const float *red = fathom_film_channel(film, "R");
    double sum = 0;
    for (size_t i = 0; i < 64 * 64; ++i) sum += (double)red[i] * (double)(i + 1);
    fathom_film_destroy(film);
    fathom_scene_destroy(scene);
    return sum;
}

/* Another file under the old name is no change, and neither is what happens to one that was copied. */
UNIT_TEST(replaced_and_copied_files_keep_their_bytes) {
    guard();
    EACH_MAPPED(i) {
        fathom_scene *scene;
        const char *path = write_ball(mapped[i]);
        assert_ok(context, fathom_scene_read(context, path, &scene));
        double sum = sum_of(scene);
        assert_true(sum > 0);
        assert_ok(context, fathom_scene_read(context, path, &scene));
        write_text(in_folder("other"), "w", "nothing");
        assert_int_equal(rename(in_folder("other"), path), 0);
        assert_true(sum_of(scene) == sum);
        write_ball(mapped[i]);
        fathom_context_copy_files(context, true);
        assert_ok(context, fathom_scene_read(context, path, &scene));
        fathom_context_copy_files(context, false);
        assert_int_equal(truncate(path, 0), 0);
        assert_true(sum_of(scene) == sum);
    }
}

/* A new name, a link or other rights leave the bytes alone. */
UNIT_TEST(links_and_rights_change_nothing) {
    guard();
    EACH_MAPPED(i) {
        fathom_scene *scene;
        const char *path = write_ball(mapped[i]);
        assert_ok(context, fathom_scene_read(context, path, &scene));
        usleep(20000);
        assert_int_equal(link(path, in_folder("other")), 0);
        assert_int_equal(unlink(in_folder("other")), 0);
        assert_int_equal(chmod(path, 0400), 0);
        assert_ok(context, fathom_scene_check_files(scene));
        assert_int_equal(chmod(path, 0600), 0);
        fathom_scene_destroy(scene);
    }
}

/* More files at once than a chunk of the table has slots, in any order of closing. */
UNIT_TEST(many_files_can_be_mapped_at_once) {
    guard();
    enum { COUNT = 500 };
    static file_map maps[COUNT];
    const char *path = write_ball("ball.ply");
    for (int round = 0; round < 3; ++round) {
        for (int i = 0; i < COUNT; ++i) assert_ok(context, file_open(context, path, &maps[i]));
        for (int i = 0; i < COUNT; ++i) file_close(&maps[(i * 7 + round) % COUNT]);
    }
    assert_ok(context, file_open(context, path, &maps[0]));
    assert_ok(context, file_open(context, path, &maps[1]));
    assert_int_equal(truncate(path, 0), 0);
    assert_int_equal(maps[0].bytes[maps[0].size - 1], 0);
    unlink(path);
    assert_fails(context, file_check(context, &maps[0]), FATHOM_BAD_INPUT, "was truncated");
    assert_ok(context, file_check(context, &maps[1])); /* nothing of it was read */
    file_close(&maps[0]);
    file_close(&maps[1]);
}

static void exit_7(int number) {
    (void)number;
    _exit(7);
}

/* A SIGBUS of others goes where it went before, sent by a process or come of memory that is not ours. */
UNIT_TEST(other_bus_errors_reach_their_handler) {
    guard();
    for (int way = 0; way < 2; ++way) {
        const char *name = unit_text("%s", in_folder("foreign"));
        fflush(NULL);
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            char program[] = "/proc/self/exe", argument[12];
            snprintf(argument, sizeof argument, "%d", way);
            execl(program, program, argument, name, (char *)NULL);
            _exit(1);
        }
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFEXITED(status));
        assert_int_equal(WEXITSTATUS(status), 7);
    }
}

/* What the child of the test above is: its handler first, then the guard, then the fault. */
static int meet_foreign_fault(int way, const char *path) {
    signal(SIGBUS, exit_7);
    fathom_guard_files();
    fathom_guard_files();
    if (way == 0) raise(SIGBUS);
    int descriptor = open(path, O_RDWR | O_CREAT | O_TRUNC, 0600);
    if (descriptor < 0 || ftruncate(descriptor, 4096) != 0) return 2;
    volatile char *bytes = mmap(NULL, 4096, PROT_READ, MAP_SHARED, descriptor, 0);
    if (ftruncate(descriptor, 0) != 0 || unlink(path) != 0) return 3;
    return bytes[0] + 4;
}

static int remove_files(void **state) {
    static const char *const names[] = {"ball.ply", "ball.glb", "ball.obj", "ball.mtl", "rows.ply"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) unlink(in_folder(names[i]));
    return remove_folder(state);
}

int main(int argc, char **argv) {
    if (argc == 3) return meet_foreign_fault(argv[1][0] - '0', argv[2]);
    fathom_guard_files();
    sigaction(SIGBUS, NULL, &guard_action);
    return unit_main(open_folder, remove_files);
}
