#include "cli/command.h"

#include <fathom/image.h>

typedef struct compare_settings {
    command_common common;
    const char *a, *b;
    double tolerance, ppd;
    bool flip;
} compare_settings;

static void print_difference(const fathom_image_difference *d, const fathom_image *image, double tolerance) {
    uint32_t width, height;
    fathom_image_size(image, &width, &height);
    printf("max %.9g", d->largest);
    if (d->largest > 0) {
        fputs(" in ", stdout);
        print_name(stdout, d->channel);
        printf(" at (%u,%u)", d->x, d->y);
    }
    printf(", RMSE %.9g, %llu of %llu pixels differ", d->rmse, (unsigned long long)d->pixels,
           (unsigned long long)width * height);
    if (tolerance > 0) printf(" by more than %g", tolerance);
    putchar('\n');
}

static fathom_status print_flip(fathom_context *context, const fathom_image *a, const fathom_image *b,
                                double ppd) {
    fathom_flip f = {.size = sizeof f};
    fathom_status status = fathom_image_flip(context, a, b, ppd, &f);
    if (status != FATHOM_OK) return say_status(&command_compare, context, status);
    printf("FLIP %.6g at %g pixels a degree", f.mean, ppd);
    if (f.nonfinite) printf(", %llu pixels not finite", (unsigned long long)f.nonfinite);
    putchar('\n');
    return status;
}

static fathom_status compare(fathom_context *context, const fathom_image *a, const fathom_image *b,
                             const compare_settings *settings) {
    const bool quiet = settings->common.quiet;
    fathom_image_difference d = {.size = sizeof d};
    fathom_status status = fathom_image_compare(context, a, b, settings->tolerance, &d);
    if (status != FATHOM_OK) {
        if (!quiet) printf("%s\n", fathom_context_message(context));
        return status;
    }
    if (!quiet) print_difference(&d, a, settings->tolerance);
    if (!quiet && settings->flip)
        status = print_flip(context, a, b, settings->ppd > 0 ? settings->ppd : FATHOM_FLIP_PPD);
    return status == FATHOM_OK && d.pixels ? FATHOM_CHECK_FAILED : status;
}

static fathom_status read_and_compare(fathom_context *context, void *user) {
    const compare_settings *settings = user;
    const fathom_image *a = NULL, *b = NULL;
    if (settings->ppd > 0 && !settings->flip) return say_usage(&command_compare, "--ppd: only with --flip");
    fathom_status status = fathom_image_read(context, settings->a, &a);
    if (status == FATHOM_OK) status = fathom_image_read(context, settings->b, &b);
    say_status(&command_compare, context, status);
    if (status == FATHOM_OK) status = compare(context, a, b, settings);
    fathom_image_destroy(a);
    fathom_image_destroy(b);
    return status;
}

static const args_option options[] = {
    {.help = "Options"},
    {"tolerance", 0, "T", take_f64, offsetof(compare_settings, tolerance), 0, 1e300,
     "differences of values up to T do not count (0). Values of 8-bit files are from 0 to 1: a level is "
     "0.004"},
    {"flip", 0, NULL, take_true, offsetof(compare_settings, flip), 0, 0,
     "also print FLIP: how visible the difference is when flipping between the images, from 0 to "
     "1. Values of .exr, .hdr and .pfm count as linear, those of other formats as sRGB"},
    {"ppd", 0, "N", take_f64, offsetof(compare_settings, ppd), FATHOM_FLIP_PPD_LEAST, FATHOM_FLIP_PPD_MOST,
     "pixels per degree of the viewer's eye, for FLIP (67: a 4K screen 0.7 m wide, from 0.7 m "
     "away)"},
    COMMAND_QUIET("only the exit code"),
    {.help = NULL},
};

const command command_compare = {
    .name = "compare",
    .usage = "A B [--tolerance T] [--flip]",
    .summary = "Measure how much two images differ.",
    .text = "Compares every channel of two images as stored, and prints the largest\n"
            "difference of a value, the root mean square of all, and how many pixels differ.\n"
            "The exit code is 0 if no pixel differs. It is 1 if some do, or if the images\n"
            "differ in size, crop or channels. FLIP does not change the exit code.\n",
    .examples = "  fathom compare old.exr new.exr --tolerance 0.001\n"
                "  fathom compare old.png new.png --flip\n",
    .args = {options, {{"A", offsetof(compare_settings, a)}, {"B", offsetof(compare_settings, b)}}},
    COMMAND_BODY(read_and_compare, compare_settings, {.a = NULL}),
};
