#include "cli/command.h"

#include "base/file.h"
#include "base/status.h"
#include "image/compare/flip.h"
#include "image/image.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct compare_settings {
    command_common common;
    const char *a, *b;
    double tolerance, ppd;
    bool flip;
} compare_settings;

typedef struct difference {
    double largest; /* infinite where only one of the two is a finite number */
    uint32_t x, y;  /* where the largest is */
    const char *channel;
    double square_sum; /* over all values */
    uint64_t values, pixels;
} difference;

static const image_channel *find_channel(const image *img, const char *name) {
    for (size_t i = 0; i < img->channel_count; ++i) {
        if (strcmp(img->channels[i].name, name) == 0) return &img->channels[i];
    }
    return NULL;
}

static double value_at(const image_channel *c, uint32_t width, uint32_t x, uint32_t y) {
    const char *place = (const char *)c->data + ((size_t)y * width + x) * c->stride;
    float number;
    uint32_t id;
    switch (c->type) {
    case IMAGE_FLOAT: memcpy(&number, place, sizeof number); return (double)number;
    case IMAGE_UINT: memcpy(&id, place, sizeof id); return (double)id;
    }
    return 0;
}

/* Equal infinities and two NaN do not differ; anything else that is not finite differs without bound. */
static double distance(double a, double b) {
    if (a == b || (isnan(a) && isnan(b))) return 0;
    double d = fabs(a - b);
    return isnan(d) ? HUGE_VAL : d;
}

/* What keeps the two from being compared at all; false when there is such a thing. */
static bool check_alike(const image *a, const image *b, args_problem *problem) {
    if (a->width != b->width || a->height != b->height)
        return args_wrong(problem, "different sizes: %ux%u and %ux%u", a->width, a->height, b->width,
                          b->height);
    if (a->x != b->x || a->y != b->y || a->full_width != b->full_width || a->full_height != b->full_height)
        return args_wrong(problem, "different crops: at (%u,%u) of %ux%u and at (%u,%u) of %ux%u", a->x, a->y,
                          a->full_width, a->full_height, b->x, b->y, b->full_width, b->full_height);
    for (int pass = 0; pass < 2; ++pass) {
        const image *one = pass ? b : a, *other = pass ? a : b;
        for (size_t i = 0; i < one->channel_count; ++i) {
            const image_channel *c = &one->channels[i], *twin = find_channel(other, c->name);
            if (!twin)
                return args_wrong(problem, "channel %.60s is only in the %s", c->name,
                                  pass ? "second" : "first");
            if (twin->type != c->type)
                return args_wrong(problem, "channel %.60s is of different types", c->name);
        }
    }
    return true;
}

static void compare_pixel(const image *a, const image *b, uint32_t x, uint32_t y, double tolerance,
                          difference *out) {
    bool differs = false;
    for (size_t i = 0; i < a->channel_count; ++i) {
        const image_channel *c = &a->channels[i], *twin = find_channel(b, c->name);
        double d = distance(value_at(c, a->width, x, y), value_at(twin, b->width, x, y));
        differs |= d > tolerance;
        out->square_sum += d * d;
        ++out->values;
        if (d > out->largest) {
            out->largest = d;
            out->x = x, out->y = y;
            out->channel = c->name;
        }
    }
    out->pixels += differs;
}

static fathom_status compare_images(const image *a, const image *b, const compare_settings *settings) {
    args_problem problem;
    if (!check_alike(a, b, &problem)) {
        if (!settings->common.quiet) printf("%s\n", problem.text);
        return FATHOM_CHECK_FAILED;
    }
    difference d = {.largest = 0};
    for (uint32_t y = 0; y < a->height; ++y) {
        for (uint32_t x = 0; x < a->width; ++x) compare_pixel(a, b, x, y, settings->tolerance, &d);
    }
    if (!settings->common.quiet) {
        printf("max %.9g", d.largest);
        if (d.largest > 0) {
            fputs(" in ", stdout);
            print_name(stdout, d.channel);
            printf(" at (%u,%u)", d.x, d.y);
        }
        printf(", RMSE %.9g, %llu of %llu pixels differ", sqrt(d.square_sum / (double)d.values),
               (unsigned long long)d.pixels, (unsigned long long)a->width * a->height);
        if (settings->tolerance > 0) printf(" by more than %g", settings->tolerance);
        putchar('\n');
    }
    return d.pixels ? FATHOM_CHECK_FAILED : FATHOM_OK;
}

/* ---- FLIP ---- */

typedef struct side {
    const image *img;
    const char *path; /* EXR holds linear values, all else is taken to hold sRGB's */
} side;

typedef struct flip_result {
    double mean;
    uint64_t nonfinite; /* pixels, each of which counts as the largest error */
} flip_result;

/* IEC 61966-2-1. */
static double linear_of(double srgb) {
    return srgb > 0.04045 ? pow((srgb + 0.055) / 1.055, 2.4) : srgb / 12.92;
}

static void take_plane(const image_channel *c, const image *img, bool encoded, float *out) {
    for (uint32_t y = 0; y < img->height; ++y) {
        for (uint32_t x = 0; x < img->width; ++x) {
            double value = value_at(c, img->width, x, y);
            *out++ = (float)(encoded ? linear_of(value) : value);
        }
    }
}

/* The planes are in *memory, to be released with free(). */
static fathom_status take_image(fathom_context *context, const side *from, float **memory,
                                metric_image *out) {
    static const char *const names[3] = {"R", "G", "B"};
    char extension[16];
    file_extension(from->path, extension);
    bool encoded = strcmp(extension, "exr") != 0;
    size_t pixels = (size_t)from->img->width * from->img->height;
    *memory = malloc(3 * pixels * sizeof **memory);
    if (!*memory) return fail_memory(context, 3 * pixels * sizeof **memory);
    *out = (metric_image){.width = from->img->width, .height = from->img->height};
    for (size_t i = 0; i < 3; ++i) {
        const image_channel *c = find_channel(from->img, names[i]);
        if (!c || c->type != IMAGE_FLOAT)
            return fail_file(context, FATHOM_BAD_INPUT, from->path, "FLIP needs the channels R, G and B");
        take_plane(c, from->img, encoded, *memory + i * pixels);
        out->rgb[i] = *memory + i * pixels;
    }
    return FATHOM_OK;
}

static fathom_status flip_planes(fathom_context *context, const metric_image *a, const metric_image *b,
                                 double ppd, flip_result *out) {
    flip_view *one = flip_view_create(a, ppd), *other = flip_view_create(b, ppd);
    bool made = one && other;
    if (made) *out = (flip_result){flip_mean(one, other, NULL), metric_nonfinite(a, b)};
    flip_view_destroy(one);
    flip_view_destroy(other);
    return made ? FATHOM_OK : fail_memory(context, (size_t)a->width * a->height * 8 * sizeof(double));
}

static fathom_status find_flip(fathom_context *context, const side *a, const side *b, double ppd,
                               flip_result *out) {
    float *memory[2] = {NULL, NULL};
    metric_image images[2];
    fathom_status status = take_image(context, a, &memory[0], &images[0]);
    if (status == FATHOM_OK) status = take_image(context, b, &memory[1], &images[1]);
    if (status == FATHOM_OK) status = flip_planes(context, &images[0], &images[1], ppd, out);
    free(memory[0]);
    free(memory[1]);
    return status;
}

static fathom_status print_flip(fathom_context *context, const image *a, const image *b,
                                const compare_settings *settings) {
    const side one = {a, settings->a}, other = {b, settings->b};
    flip_result f = {.mean = 0};
    fathom_status status = find_flip(context, &one, &other, settings->ppd, &f);
    if (status != FATHOM_OK) return say_status(&command_compare, context, status);
    printf("FLIP %.6g at %g pixels a degree", f.mean, settings->ppd);
    if (f.nonfinite) printf(", %llu pixels not finite", (unsigned long long)f.nonfinite);
    putchar('\n');
    return status;
}

/* ---- the command ---- */

static fathom_status read_and_compare(fathom_context *context, void *user) {
    const compare_settings *settings = user;
    const image *a = NULL, *b = NULL;
    fathom_status status = image_read(context, settings->a, &a);
    if (status == FATHOM_OK) status = image_read(context, settings->b, &b);
    say_status(&command_compare, context, status);
    args_problem unlike;
    fathom_status flipped = FATHOM_OK;
    if (status == FATHOM_OK) status = compare_images(a, b, settings);
    if (settings->flip && !settings->common.quiet && (status == FATHOM_OK || status == FATHOM_CHECK_FAILED) &&
        check_alike(a, b, &unlike))
        flipped = print_flip(context, a, b, settings);
    if (flipped != FATHOM_OK) status = flipped;
    image_release(a);
    image_release(b);
    return status;
}

static fathom_status run(int argc, char **argv) {
    compare_settings settings = {.ppd = FLIP_PPD};
    return command_run(&command_compare, argc, argv, &settings, read_and_compare);
}

static const args_option options[] = {
    {.help = "Options"},
    {"tolerance", 0, "T", take_f64, offsetof(compare_settings, tolerance), 0, 1e300,
     "differences up to T do not count (0)"},
    {"flip", 0, NULL, take_true, offsetof(compare_settings, flip), 0, 0,
     "also FLIP, the difference that is seen when flipping between the two, from 0 to 1, after sRGB: values "
     "of "
     ".exr are taken as linear, of others as sRGB's"},
    {"ppd", 0, "N", take_f64, offsetof(compare_settings, ppd), FLIP_PPD_LEAST, FLIP_PPD_MOST,
     "pixels that a degree of the eye holds, for FLIP (67: a 4K screen, 0.7 m wide and away)"},
    COMMAND_QUIET("only the exit code"),
    {.help = NULL},
};
static const char *const operands[] = {"A", "B"};
static const size_t operand_offsets[] = {offsetof(compare_settings, a), offsetof(compare_settings, b)};

const command command_compare = {
    .name = "compare",
    .usage = "A B [--tolerance T] [--flip]",
    .summary = "Tell how much two images differ.",
    .text = "Compares every channel of two images as stored, and prints the largest\n"
            "difference of a value, the root mean square of all, and how many pixels differ.\n"
            "The exit code is 0 when none does, 1 when some do or the images have not the\n"
            "same size, crop and channels. FLIP changes no exit code.\n",
    .examples = "  fathom compare old.exr new.exr --tolerance 0.001\n"
                "  fathom compare old.png new.png --flip\n",
    .args = {options, operands, operand_offsets, 2},
    .run = run,
};
