/* Makes a heavy mesh, or times how fast files are read. See read.sh. */
#include "base/clock.h"
#include "scene/scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

static int complain(fathom_context *context) {
    fprintf(stderr, "%s\n", fathom_context_message(context));
    return 3;
}

static int make(fathom_context *context, uint64_t triangles, const char *path) {
    fathom_scene *scene;
    fathom_generate_options options;
    fathom_generate_options_default(&options);
    options.kind = FATHOM_GENERATE_SPHERE;
    options.triangles = triangles;
    fathom_status status = fathom_scene_create(context, &scene);
    if (status != FATHOM_OK) return complain(context);
    status = fathom_scene_generate(scene, FATHOM_ROOT, &options);
    if (status == FATHOM_OK) status = fathom_scene_write(scene, path);
    fathom_scene_destroy(scene);
    return status == FATHOM_OK ? 0 : complain(context);
}

static double processor_seconds(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Reading as a user's command does it: with the checks, the camera and the lights of a bare model. */
static int measure(fathom_context *context, const char *path, int repeats) {
    double seconds[100], processor = 0;
    size_t triangles = 0;
    if (repeats > 100) repeats = 100;
    for (int i = -1; i < repeats; ++i) { /* the first warms the page cache */
        fathom_scene *scene;
        double before = processor_seconds(), start = clock_seconds();
        if (fathom_scene_read(context, path, &scene) != FATHOM_OK) return complain(context);
        if (i >= 0) {
            seconds[i] = clock_seconds() - start;
            processor += (processor_seconds() - before) / repeats;
        }
        triangles = 0;
        for (size_t k = 0; k < scene->meshes.count; ++k) triangles += scene->meshes.items[k].triangle_count;
        fathom_scene_destroy(scene);
    }
    qsort(seconds, (size_t)repeats, sizeof *seconds, ascending);
    double n = 1e-6 * (double)triangles, least = seconds[0], median = seconds[repeats / 2];
    const char *dot = strrchr(path, '/');
    printf("| %-16s | %6.2f M | %7.4f / %7.4f s | %8.1f / %8.1f M/s | %7.4f s |\n", dot ? dot + 1 : path, n,
           least, median, n / least, n / median, processor);
    return 0;
}

int main(int argc, char **argv) {
    fathom_context *context;
    if (argc != 4 || fathom_context_create(&context) != FATHOM_OK) return 2;
    int result = strcmp(argv[1], "make") == 0 ? make(context, strtoull(argv[2], NULL, 10), argv[3])
                                              : measure(context, argv[2], atoi(argv[3]));
    fathom_context_destroy(context);
    return result;
}
