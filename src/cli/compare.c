#include "cli/command.h"

#include "image/image.h"

#include <math.h>
#include <string.h>

typedef struct compare_settings {
    const char *a, *b;
    double tolerance;
    bool quiet;
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
        if (!settings->quiet) printf("%s\n", problem.text);
        return FATHOM_CHECK_FAILED;
    }
    difference d = {.largest = 0};
    for (uint32_t y = 0; y < a->height; ++y) {
        for (uint32_t x = 0; x < a->width; ++x) compare_pixel(a, b, x, y, settings->tolerance, &d);
    }
    if (!settings->quiet) {
        printf("max %.9g", d.largest);
        if (d.largest > 0) printf(" in %s at (%u,%u)", d.channel, d.x, d.y);
        printf(", RMSE %.9g, %llu of %llu pixels differ", sqrt(d.square_sum / (double)d.values),
               (unsigned long long)d.pixels, (unsigned long long)a->width * a->height);
        if (settings->tolerance > 0) printf(" by more than %g", settings->tolerance);
        putchar('\n');
    }
    return d.pixels ? FATHOM_CHECK_FAILED : FATHOM_OK;
}

static fathom_status read_and_compare(fathom_context *context, const compare_settings *settings) {
    const image *a = NULL, *b = NULL;
    fathom_status status = image_read(context, settings->a, &a);
    if (status == FATHOM_OK) status = image_read(context, settings->b, &b);
    say_status(&command_compare, context, status);
    if (status == FATHOM_OK) status = compare_images(a, b, settings);
    image_release(a);
    image_release(b);
    return status;
}

static fathom_status run(int argc, char **argv) {
    compare_settings settings = {.tolerance = 0};
    fathom_status status;
    if (!command_parse(&command_compare, argc, argv, &settings, &status)) return status;
    fathom_context *context;
    status = command_context(0, &context);
    if (status != FATHOM_OK) return status;
    status = read_and_compare(context, &settings);
    fathom_context_destroy(context);
    return status;
}

static const args_option options[] = {
    {.help = "Options"},
    {"tolerance", 0, "T", take_f64, offsetof(compare_settings, tolerance), 0, 1e300,
     "differences up to T do not count (0)"},
    {"quiet", 'q', NULL, take_true, offsetof(compare_settings, quiet), 0, 0, "only the exit code"},
    {.help = NULL},
};
static const char *const operands[] = {"A", "B"};
static const size_t operand_offsets[] = {offsetof(compare_settings, a), offsetof(compare_settings, b)};

const command command_compare = {
    .name = "compare",
    .usage = "A B [--tolerance T]",
    .summary = "Tell how much two images differ.",
    .text = "Compares every channel of two images as stored, and prints the largest\n"
            "difference of a value, the root mean square of all, and how many pixels differ.\n"
            "The exit code is 0 when none does, 1 when some do or the images have not the\n"
            "same size, crop and channels.\n",
    .examples = "  fathom compare old.exr new.exr --tolerance 0.001\n",
    .args = {options, operands, operand_offsets, 2},
    .run = run,
};
