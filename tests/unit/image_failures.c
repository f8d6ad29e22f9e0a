/* Failures with images get a message and leave nothing behind. */
#include "defaults.h"
#include "image/image.h"
#include "texture/texture.h"
#include "unit_folder.h"

#include <dirent.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static const char *const files[] = {"a.exr", "a.png", "a.jpg", "a.tif"};

static fathom_write_options defaults(void) { return (fathom_write_options){.exposure = 0}; }

enum { SIDE = 256 };
static float noise[3 * SIDE * SIDE];
static image_channel channels[3];
static image noisy(void) {
    const char *const names[] = {"R", "G", "B"};
    for (size_t i = 0; i < 3 * SIDE * SIDE; ++i) noise[i] = (float)(i * 2654435761u % 65521) / 65521;
    for (size_t c = 0; c < 3; ++c) channels[c] = (image_channel){names[c], IMAGE_FLOAT, true, noise + c, 12};
    return (image){SIDE, SIDE, 0, 0, SIDE, SIDE, channels, 3, NULL, 0, 0};
}

static size_t files_in_folder(void) {
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    size_t count = 0;
    for (struct dirent *e; (e = readdir(directory));) count += e->d_name[0] != '.';
    closedir(directory);
    return count;
}

/* Runs body() in a child; it has to end with exit code 0. */
static void in_child(bool (*body)(void *user), void *user) {
    fflush(NULL);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) exit(body(user) ? 0 : 1);
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    if (!WIFEXITED(status) || WEXITSTATUS(status)) {
        fail_msg("the child ended with %s %d", WIFEXITED(status) ? "code" : "signal",
                 WIFEXITED(status) ? WEXITSTATUS(status) : WTERMSIG(status));
    }
}

static bool fails_with(fathom_status found, fathom_status expected, const char *text) {
    const char *message = fathom_context_message(context);
    if (found == expected && strstr(message, text)) return true;
    fprintf(stderr, "status %d, message \"%s\"; expected %d, \"%s\"\n", found, message, expected, text);
    return false;
}

/* The module that the helper loads stands for everything that can be wrong with its libraries. */
static bool without_module(void *user) {
    (void)user;
    image img = noisy();
    fathom_write_options options = defaults();
    setenv("FATHOM_IMAGE_MODULE", "/nowhere/fathom_image.so", 1);
    image_prefetch(); /* its failure is nobody's business yet */
    bool ok = fails_with(image_write(context, &img, in_folder("a.tif"), &options), FATHOM_OUT_OF_RESOURCES,
                         "/nowhere/fathom_image.so");
    ok &= fails_with(image_prefetch_status(context), FATHOM_OUT_OF_RESOURCES, "/nowhere/fathom_image.so");
    setenv("FATHOM_IMAGE_MODULE", in_folder("a.txt"), 1);
    ok &= fails_with(image_write(context, &img, in_folder("a.tif"), &options), FATHOM_OUT_OF_RESOURCES,
                     "a.txt");
    /* Once it can be had, it is. */
    unsetenv("FATHOM_IMAGE_MODULE");
    return ok && image_write(context, &img, in_folder("a.tif"), &options) == FATHOM_OK;
}

/* A module whose views fail, with a reason or without, and to which every image is broken. */
static bool with_failing_module(void *user) {
    (void)user;
    image img = noisy();
    const image *found;
    fathom_write_options options = defaults();
    options.view = "Raw";
    setenv("FATHOM_IMAGE_MODULE", LOST_MODULE, 1);
    setenv("FAULT_LOST", "view", 1);
    bool ok = fails_with(image_write(context, &img, in_folder("a.png"), &options), FATHOM_INTERNAL,
                         "a.png: OpenColorIO: no such colour");
    ok &= access(in_folder("a.png"), F_OK) != 0;
    return ok & fails_with(image_read(context, in_folder("a.txt"), &found), FATHOM_BAD_INPUT,
                           "a.txt: cannot be read as an image: is broken");
}

UNIT_TEST(module_failures_are_reported) {
    put_text("a.txt", "not an image\n");
    in_child(with_failing_module, NULL);
    assert_int_equal(unlink(in_folder("a.txt")), 0);
}

UNIT_TEST(a_missing_helper_is_reported) {
    put_text("a.txt", "not a library\n");
    in_child(without_module, NULL);
    assert_int_equal(unlink(in_folder("a.tif")), 0);
    assert_int_equal(unlink(in_folder("a.txt")), 0);
}

static bool png_and_exr_without_module(void *user) {
    (void)user;
    image img = noisy();
    fathom_write_options options = defaults();
    bool ok = true;
    setenv("FATHOM_IMAGE_MODULE", "/nowhere/fathom_image.so", 1);
    for (size_t i = 0; i < 2; ++i)
        ok &= image_check(context, in_folder(files[i]), &options) == FATHOM_OK &&
              image_write(context, &img, in_folder(files[i]), &options) == FATHOM_OK;
    options.view = "Raw";
    ok &=
        fails_with(image_check(context, in_folder("a.png"), &options), FATHOM_OUT_OF_RESOURCES, "/nowhere/");
    ok &= fails_with(image_write(context, &img, in_folder("a.png"), &options), FATHOM_OUT_OF_RESOURCES,
                     "/nowhere/");
    ok &= image_check(context, in_folder("a.exr"), &options) == FATHOM_OK;
    return ok && unlink(in_folder("a.png")) == 0 && unlink(in_folder("a.exr")) == 0;
}

UNIT_TEST(png_and_exr_need_no_helper) { in_child(png_and_exr_without_module, NULL); }

/* Whatever a library does while it is loaded or at work ends a call, and not this process; the next call has
 * a new helper. */
static bool survives(void *user) {
    image img = noisy();
    fathom_write_options options = defaults();
    setenv("FAULT_LOST", user, 1);
    setenv("FATHOM_IMAGE_MODULE", LOST_MODULE, 1);
    setenv("FATHOM_IMAGE_SECONDS", "0.5", 1);
    bool ok = fails_with(image_write(context, &img, in_folder("a.tif"), &options), FATHOM_OUT_OF_RESOURCES,
                         "image helper");
    ok &= access(in_folder("a.tif"), F_OK) != 0;
    unsetenv("FAULT_LOST"), unsetenv("FATHOM_IMAGE_MODULE"), unsetenv("FATHOM_IMAGE_SECONDS");
    return ok && image_write(context, &img, in_folder("a.tif"), &options) == FATHOM_OK &&
           unlink(in_folder("a.tif")) == 0;
}

UNIT_TEST(libraries_that_end_their_process_end_only_a_call) {
    static const char *const ways[] = {"exit",       "abort",     "null",       "fault",
                                       "hang",       "rows-exit", "rows-abort", "rows-null",
                                       "rows-fault", "rows-hang", "rows-thread"};
    for (size_t i = 0; i < sizeof ways / sizeof *ways; ++i) in_child(survives, (void *)(uintptr_t)ways[i]);
}

/* A texture whose file ends the helper is reported after a lookup, which gives a colour that is seen. */
static bool texture_survives(void *user) {
    const texture_queries q = {.count = 1};
    float rgba[4][TEXTURE_BLOCK];
    fathom_texture t = default_texture();
    fathom_scene *scene;
    texture_cache *cache;
    setenv("FAULT_LOST", user, 1);
    setenv("FATHOM_IMAGE_MODULE", LOST_MODULE, 1);
    setenv("FATHOM_IMAGE_SECONDS", "0.5", 1);
    put_text("a.png", "a");
    t.file = in_folder("a.png");
    bool ok = fathom_scene_create(context, &scene) == FATHOM_OK &&
              fathom_scene_add_texture(scene, &t, NULL) == FATHOM_OK &&
              texture_cache_open(context, scene, 1000000, &cache) == FATHOM_OK;
    if (!ok) return false;
    texture_lookup(cache, &q, rgba);
    ok = rgba[0][0] == 1 && rgba[1][0] == 0 && rgba[2][0] == 1 &&
         fails_with(texture_cache_check(cache, context), FATHOM_OUT_OF_RESOURCES,
                    "a.png: cannot be read as a texture: the image helper");
    texture_cache_close(cache);
    fathom_scene_destroy(scene);
    unlink(in_folder("a.png"));
    return ok;
}

UNIT_TEST(a_texture_that_ends_the_helper_is_reported) {
    static const char *const ways[] = {"texture-exit", "texture-abort", "texture-null", "texture-fault",
                                       "texture-hang"};
    for (size_t i = 0; i < sizeof ways / sizeof *ways; ++i)
        in_child(texture_survives, (void *)(uintptr_t)ways[i]);
}

static bool prefetch_and_leave(void *user) {
    image_prefetch();
    nanosleep(user, NULL);
    return true;
}

/* Leaving the process at any moment of the load, with all exit handlers. */
UNIT_TEST(a_helper_that_ends_while_loading_is_reported) {
    for (long i = 0; i < 6; ++i) {
        struct timespec wait = {0, i * 40000000};
        in_child(prefetch_and_leave, &wait);
    }
}

/* A child of a process with a helper has one of its own, and so has its parent. */
static bool write_in_both(void *user) {
    (void)user;
    image img = noisy();
    fathom_write_options options = defaults();
    bool ok = image_write(context, &img, in_folder("a.tif"), &options) == FATHOM_OK;
    pid_t child = fork();
    if (child == 0) exit(image_write(context, &img, in_folder("b.tif"), &options) != FATHOM_OK);
    ok &= image_write(context, &img, in_folder("a.tif"), &options) == FATHOM_OK;
    int status;
    ok &= waitpid(child, &status, 0) == child && status == 0;
    return ok && unlink(in_folder("a.tif")) == 0 && unlink(in_folder("b.tif")) == 0;
}

UNIT_TEST(a_forked_child_writes_too) { in_child(write_in_both, NULL); }

static bool write_after_prefetch(void *user) {
    (void)user;
    image img = noisy();
    fathom_write_options options = defaults();
    image_prefetch();
    image_prefetch();
    return image_write(context, &img, in_folder("a.tif"), &options) == FATHOM_OK &&
           unlink(in_folder("a.tif")) == 0;
}

UNIT_TEST(writing_waits_for_the_helper) { in_child(write_after_prefetch, NULL); }

UNIT_TEST(bad_paths_are_refused) {
    image img = noisy();
    fathom_write_options options = defaults();
    assert_int_equal(mkdir(in_folder("folder.png"), 0700), 0);
    const struct {
        const char *name, *text;
        fathom_status status;
    } cases[] = {
        {"a.bmp", "unknown image extension \"bmp\"", FATHOM_BAD_USAGE},
        {"a", "expected .exr, .png", FATHOM_BAD_USAGE},
        {"nowhere/a.png", "cannot be written", FATHOM_OUT_OF_RESOURCES},
        {"nowhere/a.exr", "cannot be written", FATHOM_OUT_OF_RESOURCES},
        {"folder.png", "cannot be written", FATHOM_OUT_OF_RESOURCES},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const char *path = in_folder(cases[i].name);
        assert_fails(context, image_check(context, path, &options), cases[i].status, cases[i].text);
        assert_fails(context, image_write(context, &img, path, &options), cases[i].status, cases[i].text);
    }
    assert_ok(context, image_check(context, in_folder("a.EXR"), &options));
    assert_int_equal(rmdir(in_folder("folder.png")), 0);
    assert_int_equal(files_in_folder(), 0);
}

static bool as_nobody(void *user) {
    image img = noisy();
    fathom_write_options options = defaults();
    image_prefetch(); /* the helper may lie below a folder that nobody else may enter */
    /* The system calls themselves: the C library's functions wait for threads of the sanitizer that a forked
     * child does not have. */
    if (geteuid() == 0 && (syscall(SYS_setgid, 65534) != 0 || syscall(SYS_setuid, 65534) != 0)) return false;
    const char *path = user;
    return fails_with(image_check(context, path, &options), FATHOM_OUT_OF_RESOURCES, "Permission denied") &&
           fails_with(image_write(context, &img, path, &options), FATHOM_OUT_OF_RESOURCES,
                      "Permission denied");
}

UNIT_TEST(closed_folders_are_refused) {
    fathom_write_options options = defaults();
    assert_ok(context, image_check(context, in_folder("a.png"), &options));
    assert_int_equal(chmod(folder, 0555), 0);
    in_child(as_nobody, (void *)(uintptr_t)in_folder("a.tif"));
    assert_int_equal(chmod(folder, 0755), 0);
}

static bool with_small_disk(void *user) {
    image img = noisy();
    fathom_write_options options = defaults();
    struct rlimit limit = {4096, 4096};
    signal(SIGXFSZ, SIG_IGN);
    return setrlimit(RLIMIT_FSIZE, &limit) == 0 &&
           fails_with(image_write(context, &img, user, &options), FATHOM_OUT_OF_RESOURCES, "File too large");
}

/* The file that was there stays, and nothing else is left. */
UNIT_TEST(a_full_disk_is_reported) {
    for (size_t i = 0; i < 4; ++i) {
        const char *path = in_folder(files[i]);
        unit_write_file(path, "precious", 8);
        in_child(with_small_disk, (void *)(uintptr_t)path);
        char kept[16] = "";
        FILE *f = fopen(path, "r");
        assert_non_null(f);
        assert_non_null(fgets(kept, sizeof kept, f));
        fclose(f);
        assert_string_equal(kept, "precious");
        assert_int_equal(unlink(path), 0);
        assert_int_equal(files_in_folder(), 0);
    }
}

UNIT_TEST(jpeg_size_is_limited) {
    static const float black[3];
    const char *const names[] = {"R", "G", "B"};
    image_channel none[3];
    for (size_t c = 0; c < 3; ++c) none[c] = (image_channel){names[c], IMAGE_FLOAT, true, black, 0};
    image img = {65501, 1, 0, 0, 65501, 1, none, 3, NULL, 0, 0};
    fathom_write_options options = defaults();
    assert_fails(context, image_write(context, &img, in_folder("a.jpg"), &options), FATHOM_BAD_USAGE,
                 "65500");
    img.channel_count = 2;
    assert_fails(context, image_write(context, &img, in_folder("a.png"), &options), FATHOM_INTERNAL,
                 "no channel B");
    assert_int_equal(files_in_folder(), 0);
}

UNIT_TEST(broken_images_are_refused) {
    const image *img;
    assert_fails(context, image_read(context, in_folder("none.png"), &img), FATHOM_BAD_INPUT, "none.png");
    assert_null(img);
    put_text("a.png", "no image");
    assert_fails(context, image_read(context, in_folder("a.png"), &img), FATHOM_BAD_INPUT, "a.png");
    assert_null(img);
    /* Every way to cut a file short. */
    image whole = noisy();
    fathom_write_options options = defaults();
    for (size_t i = 0; i < 4; ++i) {
        assert_ok(context, image_write(context, &whole, in_folder(files[i]), &options));
        struct stat info;
        assert_int_equal(stat(in_folder(files[i]), &info), 0);
        for (long size = info.st_size / 2; size > 0; size /= 4) {
            assert_int_equal(truncate(in_folder(files[i]), size), 0);
            if (image_read(context, in_folder(files[i]), &img) == FATHOM_OK) {
                /* libjpeg fills what is missing with grey. */
                assert_int_equal(i, 2);
                image_release(img);
            }
        }
        assert_int_equal(unlink(in_folder(files[i])), 0);
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
