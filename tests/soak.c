/* Renders many times in one process: other scenes, formats, sizes, tracers, numbers of threads and files each
 * time, and failures among them. After a first period, which brings what is made once (threads, modules,
 * buffers of others' libraries), nothing may stay behind: no descriptor, no thread, no block of the heap.
 * usage: soak RENDERS FOLDER [WARMUP]     scenes come from SOURCE_DIR, files go to FOLDER; exit code 0 means
 * passed. */
#include <fathom/fathom.h>

#include <dirent.h>
#include <glob.h>
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The same work comes again after so many renders, so what is in use can be compared. */
#define PERIOD 50

static const char *const tracers[] = {"embree", "bvh:f32", "embree:user", "embree:default:low:1", "linear"};
static const char *const outputs[] = {"a.exr", "a.png", "a.jpg", "a.tif"};
static const char *const meshes[] = {"m.glb", "m.ply", "m.obj"};

typedef struct soak {
    fathom_context *context;
    const char *folder;
    glob_t scenes;
    char path[512];
} soak;

typedef struct usage {
    size_t descriptors, threads, heap,
        resident; /* heap: bytes handed out; resident: KiB, once the rest is given back */
} usage;

static const char *in_folder(soak *s, const char *name) {
    snprintf(s->path, sizeof s->path, "%s/%s", s->folder, name);
    return s->path;
}

static bool stop_soon(void *user, const fathom_progress *progress) {
    (void)user, (void)progress;
    return false;
}

static bool expect(const soak *s, fathom_status found, fathom_status expected, unsigned index) {
    if (found == expected) return true;
    fprintf(stderr, "soak: render %u: status %d, expected %d: %s\n", index, (int)found, (int)expected,
            fathom_context_message(s->context));
    return false;
}

/* ---- what is rendered ---- */

static fathom_status make_meshes(soak *s) {
    fathom_scene *scene = NULL;
    fathom_generate_options options;
    fathom_generate_options_default(&options);
    options.triangles = 3000;
    fathom_status status = fathom_scene_create(s->context, &scene);
    if (status == FATHOM_OK) status = fathom_scene_generate(scene, FATHOM_ROOT, &options);
    for (size_t i = 0; status == FATHOM_OK && i < sizeof meshes / sizeof *meshes; ++i)
        status = fathom_scene_write(scene, in_folder(s, meshes[i]));
    fathom_scene_destroy(scene);
    return status;
}

static fathom_status read_scene(soak *s, unsigned k, fathom_scene **scene) {
    size_t files = s->scenes.gl_pathc + sizeof meshes / sizeof *meshes, file = k % files;
    if (file < s->scenes.gl_pathc) return fathom_scene_read(s->context, s->scenes.gl_pathv[file], scene);
    return fathom_scene_read_to_render(s->context, in_folder(s, meshes[file - s->scenes.gl_pathc]), scene);
}

static fathom_status write_film(soak *s, const fathom_film *film, unsigned k) {
    fathom_write_options options;
    fathom_write_options_default(&options);
    const char *name = outputs[k % 4];
    return fathom_film_write(s->context, film, in_folder(s, name), &options);
}

static bool render_well(soak *s, unsigned index, unsigned k) {
    fathom_scene *scene = NULL;
    fathom_film *film = NULL;
    fathom_settings settings;
    fathom_status status = read_scene(s, k, &scene);
    if (status == FATHOM_OK) {
        fathom_scene_settings(scene, &settings);
        settings.width = 8 + 8 * (k % 7), settings.height = 8 + 8 * (k % 5), settings.spp = k % 2 ? 4 : 1;
        memset(settings.crop, 0, sizeof settings.crop);
        settings.pattern = FATHOM_PATTERN_SOBOL;
        settings.target_error = settings.max_time = 0, settings.min_spp = 0;
        settings.tracer = tracers[k % 5],
        settings.aovs = k % 3 ? 0 : FATHOM_AOVS & ~(unsigned)FATHOM_AOV_ERROR;
        fathom_context_set_threads(s->context, 1 + k % 3);
        status = fathom_render(s->context, scene, &settings, NULL, NULL, NULL, &film);
    }
    if (status == FATHOM_OK && k % 10 == 4) status = write_film(s, film, k / 10);
    fathom_film_destroy(film);
    fathom_scene_destroy(scene);
    return expect(s, status, FATHOM_OK, index);
}

/* What goes wrong on the way to an image. */
static bool render_ill(soak *s, unsigned index, unsigned which) {
    fathom_scene *scene = NULL;
    fathom_film *film = NULL;
    fathom_settings settings;
    fathom_settings_default(&settings);
    fathom_settings_set_integrator(&settings, FATHOM_INTEGRATOR_CLASSIC);
    settings.width = settings.height = 16;
    if (which == 0)
        return expect(s, fathom_scene_read(s->context, in_folder(s, "none.json"), &scene), FATHOM_BAD_INPUT,
                      index);
    if (which == 1) /* cut short */
        return expect(s, fathom_scene_read(s->context, in_folder(s, "short.ply"), &scene), FATHOM_BAD_INPUT,
                      index);
    fathom_status status = read_scene(s, which, &scene), expected = FATHOM_BAD_USAGE;
    if (status == FATHOM_OK && which == 2) settings.tracer = "no such tracer", expected = FATHOM_BAD_USAGE;
    if (status == FATHOM_OK && which == 3) settings.spp = 0, expected = FATHOM_BAD_INPUT;
    if (status == FATHOM_OK && which == 4) expected = FATHOM_INTERRUPTED;
    if (status == FATHOM_OK) {
        status =
            fathom_render(s->context, scene, &settings, which == 4 ? stop_soon : NULL, NULL, NULL, &film);
        /* A small image may be done before anybody was asked. */
        if (which == 4 && status == FATHOM_OK) expected = FATHOM_OK;
    }
    fathom_film_destroy(film);
    fathom_scene_destroy(scene);
    return expect(s, status, expected, index);
}

static bool cut_short(soak *s) {
    char bytes[2000];
    FILE *whole = fopen(in_folder(s, "m.ply"), "rb");
    size_t read = whole ? fread(bytes, 1, sizeof bytes, whole) : 0;
    if (whole) fclose(whole);
    FILE *part = read == sizeof bytes ? fopen(in_folder(s, "short.ply"), "wb") : NULL;
    if (!part) return false;
    bool good = fwrite(bytes, 1, sizeof bytes, part) == sizeof bytes;
    return fclose(part) == 0 && good;
}

/* ---- what is in use ---- */

static size_t status_number(const char *key) {
    FILE *file = fopen("/proc/self/status", "r");
    char line[256];
    size_t number = 0;
    while (file && fgets(line, sizeof line, file)) {
        if (strncmp(line, key, strlen(key)) == 0) number = strtoull(line + strlen(key), NULL, 10);
    }
    if (file) fclose(file);
    return number;
}

static size_t count_descriptors(void) {
    DIR *folder = opendir("/proc/self/fd");
    size_t count = 0;
    while (folder && readdir(folder)) ++count;
    if (folder) closedir(folder);
    return count;
}

static usage usage_now(void) {
    malloc_trim(0);
    struct mallinfo2 info = mallinfo2();
    return (usage){count_descriptors(), status_number("Threads:"), info.uordblks + info.hblkhd,
                   status_number("VmRSS:")};
}

static void print_usage(const char *when, const usage *u) {
    printf("%s: %zu descriptors, %zu threads, %zu bytes of heap, %zu KiB resident\n", when, u->descriptors,
           u->threads, u->heap, u->resident);
}

/* The least block of the heap is 32 bytes: who leaves one behind at every other render leaves as many as
 * this. */
static bool is_flat(const usage *from, const usage *to, size_t renders) {
    size_t leak = 16 * renders;
    if (to->descriptors != from->descriptors || to->threads > from->threads) {
        fprintf(stderr, "soak: descriptors or threads stay behind\n");
        return false;
    }
    if (to->heap <= from->heap + leak) return true;
    fprintf(stderr, "soak: %zu bytes of heap stay behind after %zu renders, expected at most %zu\n",
            to->heap - from->heap, renders, leak);
    return false;
}

static bool run(soak *s, unsigned renders, unsigned warm_up) {
    if (make_meshes(s) != FATHOM_OK || !cut_short(s)) {
        fprintf(stderr, "soak: %s: %s\n", s->folder, fathom_context_message(s->context));
        return false;
    }
    usage warm = {0}, now = {0};
    for (unsigned i = 0; i < renders; ++i) {
        unsigned k = i % PERIOD;
        if (!(k % 10 == 9 ? render_ill(s, i, k / 10) : render_well(s, i, k))) return false;
        if (i + 1 == warm_up) warm = usage_now(), print_usage("warm", &warm);
        if (renders >= 1000 && (i + 1) % (renders / 10) == 0) {
            now = usage_now();
            print_usage("then", &now);
        }
    }
    now = usage_now();
    print_usage("end ", &now);
    double growth = 100 * ((double)now.resident / (double)warm.resident - 1);
    printf("%u renders, resident memory %+.2f %% since render %u\n", renders, growth, warm_up);
    return is_flat(&warm, &now, renders - warm_up);
}

int main(int argc, char **argv) {
    soak s = {.folder = argc > 2 ? argv[2] : "."};
    unsigned long renders = argc > 1 ? strtoul(argv[1], NULL, 10) : 0,
                  warm_up = argc > 3 ? strtoul(argv[3], NULL, 10) : PERIOD;
    if (warm_up < PERIOD || warm_up % PERIOD || renders % PERIOD || renders <= warm_up ||
        renders > 100000000) {
        fprintf(stderr, "usage: soak RENDERS FOLDER [WARMUP]; multiples of %d, RENDERS above WARMUP\n",
                PERIOD);
        return 2;
    }
    if (glob(SOURCE_DIR "/scenes/tour/*.json", 0, NULL, &s.scenes) != 0 ||
        fathom_context_create(&s.context) != FATHOM_OK)
        return 1;
    bool good = run(&s, (unsigned)renders, (unsigned)warm_up);
    fathom_context_destroy(s.context);
    globfree(&s.scenes);
    return good ? 0 : 1;
}
