#include "cli/time_left.h"

#include "base/file.h"
#include "base/status.h"

#include <string.h>

/* Seconds for each value written, medians measured of images with smooth and noisy parts
 * (bench/README.md, Rendering to a time). Half floats and bytes are compressed faster than floats. */
static double seconds_a_value(const char *extension, bool half) {
    if (strcmp(extension, "exr") == 0) return half ? 30e-9 : 100e-9;
    return strncmp(extension, "jp", 2) == 0 ? 35e-9 : 60e-9;
}

/* Beside the colours: floats and ids, but for albedo and alpha. */
static unsigned other_channels(unsigned aovs, unsigned *colors) {
    const unsigned three = FATHOM_AOV_N | FATHOM_AOV_P | FATHOM_AOV_ID,
                   one = FATHOM_AOV_Z | FATHOM_AOV_SAMPLES;
    *colors = 3 + (aovs & FATHOM_AOV_ALPHA ? 1u : 0u) + (aovs & FATHOM_AOV_ALBEDO ? 3u : 0u);
    return 3 * (unsigned)__builtin_popcount(aovs & three) + (unsigned)__builtin_popcount(aovs & one);
}

double time_to_write(const render_options *options) {
    const fathom_settings *s = &options->settings;
    const uint32_t *c = s->crop;
    double pixels = c[2] ? (double)(c[2] - c[0]) * (c[3] - c[1]) : (double)s->width * s->height, sum = 0;
    unsigned colors, others = other_channels(s->aovs, &colors);
    for (size_t i = 0; i < options->outputs.count; ++i) {
        char extension[16];
        file_extension(options->outputs.items[i], extension);
        bool exr = strcmp(extension, "exr") == 0;
        double values = pixels * (exr ? colors : s->aovs & FATHOM_AOV_ALPHA ? 4 : 3);
        sum += values * seconds_a_value(extension, !options->write.float_color);
        if (exr) sum += pixels * others * seconds_a_value(extension, false);
    }
    return sum;
}

fathom_status time_left(fathom_context *context, double elapsed, render_options *options) {
    if (!(options->max_time > 0)) return FATHOM_OK;
    double writing = time_to_write(options);
    options->settings.max_time = options->max_time - elapsed - writing;
    if (options->settings.max_time > 0) return FATHOM_OK;
    return fail(context, FATHOM_BAD_USAGE,
                "--max-time: %g s are too short: reading took %.2f s, and writing takes about %.2f s; give "
                "more time",
                options->max_time, elapsed, writing);
}
