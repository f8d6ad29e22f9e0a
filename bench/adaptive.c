/* CPU time of rendering to an error against as many samples everywhere, at equal true error.
 * usage: adaptive SCENE WIDTH HEIGHT TRUTH_SPP REPEATS
 *
 * True images have TRUTH_SPP Sobol samples of another seed. Ways take turns within each repetition. From the
 * CPU time of fathom_render(), all threads together, that of the same call for one wave and 4 samples is
 * taken off: what is left is rendering, the build always being the same. */
#include <fathom/fathom.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define WAYS 16

typedef struct way {
    uint32_t spp;
    double target; /* 0: as many samples everywhere */
    double seconds[32], rmse, weighted, mean_spp, estimate;
} way;

typedef struct bench {
    fathom_context *context;
    fathom_scene *scene;
    fathom_settings settings;
    fathom_film *truth;
    way ways[WAYS];
    int count, repeats;
} bench;

static double cpu_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static fathom_film *render(bench *b, const fathom_settings *settings, fathom_stats *stats, double *seconds) {
    fathom_film *film;
    double began = cpu_seconds();
    if (fathom_render(b->context, b->scene, settings, NULL, NULL, stats, &film) != FATHOM_OK) {
        fprintf(stderr, "%s\n", fathom_context_message(b->context));
        exit(1);
    }
    *seconds = cpu_seconds() - began;
    return film;
}

/* Root mean square of linear radiance, and weighed as targets are. */
static void compare(const bench *b, const fathom_film *film, way *w) {
    uint32_t width, height;
    const float *truth[3], *got[3];
    const char *names[3] = {"R", "G", "B"};
    double plain = 0, weighted = 0;
    fathom_film_size(film, &width, &height);
    for (int c = 0; c < 3; ++c) {
        truth[c] = fathom_film_channel(b->truth, names[c]);
        got[c] = fathom_film_channel(film, names[c]);
    }
    size_t pixels = (size_t)width * height;
    for (size_t i = 0; i < pixels; ++i) {
        double grey = ((double)truth[0][i] + (double)truth[1][i] + (double)truth[2][i]) / 3, sum = 0;
        for (int c = 0; c < 3; ++c) {
            double d = (double)got[c][i] - (double)truth[c][i];
            sum += d * d / 3;
        }
        plain += sum;
        weighted += sum / (grey < 1 ? fmax(grey, 0.01) : grey * grey);
    }
    w->rmse = sqrt(plain / (double)pixels);
    w->weighted = sqrt(weighted / (double)pixels);
}

static void run_way(bench *b, way *w, int repeat) {
    fathom_settings settings = b->settings;
    fathom_stats stats;
    settings.spp = w->spp, settings.target_error = w->target;
    fathom_film *film = render(b, &settings, &stats, &w->seconds[repeat]);
    compare(b, film, w);
    w->mean_spp = (double)stats.samples / ((double)settings.width * settings.height);
    w->estimate = stats.error_estimate;
    fathom_film_destroy(film);
}

/* The CPU time of a render that renders nearly nothing. */
static double overhead(bench *b) {
    fathom_settings settings = b->settings;
    double seconds;
    settings.crop[2] = settings.crop[3] = 32, settings.spp = 4;
    fathom_film_destroy(render(b, &settings, NULL, &seconds));
    return seconds;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count) {
    qsort(values, (size_t)count, sizeof *values, ascending);
    return values[count / 2];
}

/* The even renders' time at this error, on straight lines between them in log-log. */
static double even_time(const bench *b, double error, double (*error_of)(const way *)) {
    for (int i = 0; i + 1 < b->count && !(b->ways[i + 1].target > 0); ++i) {
        const way *p = &b->ways[i], *q = &b->ways[i + 1];
        double high = error_of(p), low = error_of(q);
        if (error > high || error < low) continue;
        double t = log(error / high) / log(low / high);
        return exp(log(p->seconds[0]) * (1 - t) + log(q->seconds[0]) * t);
    }
    return NAN;
}

static double rmse_of(const way *w) { return w->rmse; }
static double weighted_of(const way *w) { return w->weighted; }

static void print(const bench *b) {
    printf(
        "| way | samples a pixel | CPU s | RMSE | weighed error | largest estimate | time of even samples, "
        "equal RMSE | equal weighed error |\n|---|---|---|---|---|---|---|---|\n");
    for (int i = 0; i < b->count; ++i) {
        const way *w = &b->ways[i];
        if (!(w->target > 0)) {
            printf("| %u spp | %u | %.2f | %.5f | %.5f | | | |\n", w->spp, w->spp, w->seconds[0], w->rmse,
                   w->weighted);
            continue;
        }
        printf("| target %g | %.1f | %.2f | %.5f | %.5f | %.5f | %.2f× | %.2f× |\n", w->target, w->mean_spp,
               w->seconds[0], w->rmse, w->weighted, w->estimate,
               even_time(b, w->rmse, rmse_of) / w->seconds[0],
               even_time(b, w->weighted, weighted_of) / w->seconds[0]);
    }
}

static void add_way(bench *b, uint32_t spp, double target) {
    b->ways[b->count++] = (way){.spp = spp, .target = target};
}

static void measure(bench *b) {
    double base[32];
    for (uint32_t spp = 8; spp <= 128; spp *= 2) add_way(b, spp, 0);
    const double targets[] = {0.04, 0.02, 0.01};
    for (int i = 0; i < 3; ++i) add_way(b, 4096, targets[i]);
    for (int r = 0; r < b->repeats; ++r) {
        base[r] = overhead(b);
        for (int i = 0; i < b->count; ++i) run_way(b, &b->ways[i], r);
    }
    double off = median(base, b->repeats);
    for (int i = 0; i < b->count; ++i) {
        way *w = &b->ways[i];
        w->seconds[0] = median(w->seconds, b->repeats) - off;
    }
    print(b);
}

int main(int argc, char **argv) {
    bench b = {.count = 0};
    if (argc != 6 || fathom_context_create(&b.context) != FATHOM_OK) return 2;
    if (fathom_scene_read(b.context, argv[1], &b.scene) != FATHOM_OK) {
        fprintf(stderr, "%s\n", fathom_context_message(b.context));
        return 3;
    }
    fathom_scene_settings(b.scene, &b.settings);
    b.settings.width = (uint32_t)atoi(argv[2]), b.settings.height = (uint32_t)atoi(argv[3]);
    b.settings.pattern = FATHOM_PATTERN_SOBOL, b.settings.spp = (uint32_t)atoi(argv[4]);
    b.settings.seed = 1000, b.settings.tracer_spec = "embree:medium";
    b.repeats = atoi(argv[5]) < 32 ? atoi(argv[5]) : 32;
    double seconds;
    b.truth = render(&b, &b.settings, NULL, &seconds);
    b.settings.seed = 0;
    measure(&b);
    fathom_film_destroy(b.truth);
    fathom_scene_destroy(b.scene);
    fathom_context_destroy(b.context);
    return 0;
}
