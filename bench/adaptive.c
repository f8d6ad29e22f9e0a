/* CPU time of rendering to an error against as many samples everywhere, at equal true error.
 * usage: adaptive truth SCENE WIDTH HEIGHT SPP FILE Y0 Y1     rows of the true image, to their place in FILE
 *        adaptive compare SCENE WIDTH HEIGHT FILE MOST_SPP REPEATS
 *
 * True images have SPP Sobol samples of another seed. Ways take turns within each repetition. From the CPU
 * time of fathom_render(), all threads together, that of the same call for one wave and 4 samples is taken
 * off: what is left is rendering, the build always being the same. */
#include "image/compare/flip.h"

#include <fathom/fathom.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define WAYS 16
#define REPEATS 32
#define TILE 32

/* Root mean squares: of linear radiance, weighed as targets are, and so for the worst tile; and FLIP. */
enum { RMSE, WEIGHED, TILE_ERROR, FLIP, METRICS };

typedef struct way {
    uint32_t spp;
    double target; /* 0: as many samples everywhere */
    fathom_pattern pattern;
    double seconds[REPEATS], cpu, errors[METRICS], mean_spp, estimate;
} way;

typedef struct bench {
    fathom_context *context;
    fathom_scene *scene;
    fathom_settings settings;
    float *truth; /* R, G, B one after the other */
    metric_image image;
    flip_view *view;
    way ways[WAYS];
    int count, repeats;
} bench;

static void die(const char *what) {
    fprintf(stderr, "%s\n", what);
    exit(1);
}

static double cpu_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static fathom_film *render(bench *b, const fathom_settings *settings, fathom_stats *stats, double *seconds) {
    fathom_film *film;
    double began = cpu_seconds();
    if (fathom_render(b->context, b->scene, settings, NULL, NULL, stats, &film) != FATHOM_OK)
        die(fathom_context_message(b->context));
    *seconds = cpu_seconds() - began;
    return film;
}

static const float *channel(const fathom_film *film, int c) {
    static const char *const names[3] = {"R", "G", "B"};
    return fathom_film_channel(film, names[c]);
}

/* ---- the true image ---- */

static void render_truth(bench *b, uint32_t spp, const char *file, uint32_t y0, uint32_t y1) {
    fathom_settings settings = b->settings;
    double seconds;
    const uint32_t crop[4] = {0, y0, settings.width, y1};
    settings.spp = spp, settings.seed = 1000;
    memcpy(settings.crop, crop, sizeof crop);
    fathom_film *film = render(b, &settings, NULL, &seconds);
    FILE *out = fopen(file, "r+b");
    if (!out) out = fopen(file, "w+b");
    if (!out) die(file);
    for (int c = 0; c < 3; ++c) {
        long at = ((long)c * settings.height + y0) * settings.width * (long)sizeof(float);
        size_t count = (size_t)(y1 - y0) * settings.width;
        if (fseek(out, at, SEEK_SET) || fwrite(channel(film, c), sizeof(float), count, out) != count)
            die(file);
    }
    if (fclose(out)) die(file);
    fathom_film_destroy(film);
}

static void read_truth(bench *b, const char *file) {
    size_t pixels = (size_t)b->settings.width * b->settings.height;
    FILE *in = fopen(file, "rb");
    b->truth = malloc(3 * pixels * sizeof(float));
    if (!in || !b->truth || fread(b->truth, sizeof(float), 3 * pixels, in) != 3 * pixels) die(file);
    fclose(in);
    b->image = (metric_image){
        {b->truth, b->truth + pixels, b->truth + 2 * pixels}, b->settings.width, b->settings.height};
    b->view = flip_view_create(&b->image, FLIP_PPD);
    if (!b->view) die("out of memory");
}

/* ---- errors ---- */

static double weighed_square(const bench *b, const metric_image *got, size_t pixel) {
    double grey = 0, sum = 0;
    for (int c = 0; c < 3; ++c) {
        double d = (double)got->rgb[c][pixel] - (double)b->image.rgb[c][pixel];
        grey += (double)b->image.rgb[c][pixel] / 3;
        sum += d * d / 3;
    }
    return sum / (grey < 1 ? fmax(grey, 0.01) : grey * grey);
}

/* Sums over one tile. Returns its pixels. */
static uint32_t add_tile(const bench *b, const metric_image *got, uint32_t left, uint32_t top, double *sum) {
    uint32_t count = 0;
    for (uint32_t y = top; y < top + TILE && y < got->height; ++y) {
        for (uint32_t x = left; x < left + TILE && x < got->width; ++x, ++count)
            *sum += weighed_square(b, got, (size_t)y * got->width + x);
    }
    return count;
}

static void compare(const bench *b, const fathom_film *film, way *w) {
    metric_image got = b->image;
    double weighed = 0, worst = 0;
    for (int c = 0; c < 3; ++c) got.rgb[c] = channel(film, c);
    for (uint32_t top = 0; top < got.height; top += TILE) {
        for (uint32_t left = 0; left < got.width; left += TILE) {
            double sum = 0;
            uint32_t pixels = add_tile(b, &got, left, top, &sum);
            weighed += sum;
            worst = fmax(worst, sum / pixels);
        }
    }
    flip_view *view = flip_view_create(&got, FLIP_PPD);
    if (!view) die("out of memory");
    w->errors[RMSE] = metric_rmse(&b->image, &got);
    w->errors[WEIGHED] = sqrt(weighed / ((double)got.width * got.height));
    w->errors[TILE_ERROR] = sqrt(worst);
    w->errors[FLIP] = flip_mean(b->view, view, NULL);
    flip_view_destroy(view);
}

/* ---- ways ---- */

static void run_way(bench *b, way *w, int repeat) {
    fathom_settings settings = b->settings;
    fathom_stats stats = {.size = sizeof stats};
    settings.spp = w->spp, settings.target_error = w->target, settings.pattern = w->pattern;
    fathom_film *film = render(b, &settings, &stats, &w->seconds[repeat]);
    if (!repeat) compare(b, film, w);
    w->mean_spp = (double)stats.samples / ((double)settings.width * settings.height);
    w->estimate = stats.error_estimate;
    fathom_film_destroy(film);
}

/* The CPU time of a render that renders nearly nothing. */
static double overhead(bench *b) {
    fathom_settings settings = b->settings;
    double seconds;
    settings.crop[2] = settings.crop[3] = TILE, settings.spp = 4;
    fathom_film_destroy(render(b, &settings, NULL, &seconds));
    return seconds;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count) {
    qsort(values, (size_t)count, sizeof *values, ascending);
    return (values[count / 2] + values[(count - 1) / 2]) / 2;
}

static bool even_sobol(const way *w) { return !(w->target > 0) && w->pattern == FATHOM_PATTERN_SOBOL; }

/* Of even samples' renders, the time at this error: on straight lines between them in log-log. */
static double even_time(const bench *b, int metric, double error) {
    for (int i = 0; i + 1 < b->count && even_sobol(&b->ways[i + 1]); ++i) {
        const way *p = &b->ways[i], *q = &b->ways[i + 1];
        double high = p->errors[metric], low = q->errors[metric];
        if (error > high || error < low) continue;
        double t = log(error / high) / log(low / high);
        return exp(log(p->cpu) * (1 - t) + log(q->cpu) * t);
    }
    return (double)NAN;
}

static void print_way(const bench *b, const way *w) {
    const char *pattern = w->pattern == FATHOM_PATTERN_SOBOL ? "Sobol" : "grid";
    if (w->target > 0)
        printf("| target %g", w->target);
    else
        printf("| %u spp, %s", w->spp, pattern);
    printf(" | %.1f | %.2f", w->mean_spp, w->cpu);
    for (int m = 0; m < METRICS; ++m) printf(" | %.5f", w->errors[m]);
    if (w->target > 0)
        printf(" | %.5f", w->estimate);
    else
        printf(" |");
    for (int m = 0; m < METRICS; ++m) {
        double even = even_time(b, m, w->errors[m]);
        if (even_sobol(w) || isnan(even))
            printf(" |");
        else
            printf(" | %.2f×", even / w->cpu);
    }
    printf(" |\n");
}

static void print(const bench *b) {
    printf(
        "| way | samples a pixel | CPU s | RMSE | weighed error | worst tile's | FLIP | largest estimate | "
        "time of even samples at equal RMSE | weighed error | worst tile | FLIP |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (int i = 0; i < b->count; ++i) print_way(b, &b->ways[i]);
}

static void add_way(bench *b, uint32_t spp, double target, fathom_pattern pattern) {
    b->ways[b->count++] = (way){.spp = spp, .target = target, .pattern = pattern};
}

static void measure(bench *b, uint32_t most) {
    double base[REPEATS];
    for (uint32_t spp = 4; spp <= most && spp <= 1024; spp *= 2) add_way(b, spp, 0, FATHOM_PATTERN_SOBOL);
    const double targets[] = {0.03, 0.02, 0.015, 0.01};
    for (int i = 0; i < 4; ++i) add_way(b, 4096, targets[i], FATHOM_PATTERN_SOBOL);
    add_way(b, 16, 0, FATHOM_PATTERN_GRID);
    for (int r = 0; r < b->repeats; ++r) {
        base[r] = overhead(b);
        for (int i = 0; i < b->count; ++i) run_way(b, &b->ways[i], r);
    }
    double off = median(base, b->repeats);
    for (int i = 0; i < b->count; ++i) b->ways[i].cpu = median(b->ways[i].seconds, b->repeats) - off;
    print(b);
}

static uint32_t number(const char *text) { return (uint32_t)atoi(text); }

int main(int argc, char **argv) {
    bench b = {.count = 0};
    bool truth = argc == 9 && strcmp(argv[1], "truth") == 0;
    if (!truth && !(argc == 8 && strcmp(argv[1], "compare") == 0)) return 2;
    if (fathom_context_create(&b.context) != FATHOM_OK) return 4;
    if (fathom_scene_read(b.context, argv[2], &b.scene) != FATHOM_OK) die(fathom_context_message(b.context));
    fathom_scene_settings(b.scene, &b.settings);
    b.settings.width = number(argv[3]), b.settings.height = number(argv[4]);
    b.settings.pattern = FATHOM_PATTERN_SOBOL, b.settings.tracer = "embree:medium";
    if (truth) {
        render_truth(&b, number(argv[5]), argv[6], number(argv[7]), number(argv[8]));
    } else {
        read_truth(&b, argv[5]);
        b.repeats = atoi(argv[7]) < REPEATS ? atoi(argv[7]) : REPEATS;
        measure(&b, number(argv[6]));
        flip_view_destroy(b.view);
        free(b.truth);
    }
    fathom_scene_destroy(b.scene);
    fathom_context_destroy(b.context);
    return 0;
}
