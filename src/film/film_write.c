/* Writes the film to an image file, with its scene, settings and statistics in the header. */
#include "base/clock.h"
#include "base/sized.h"
#include "base/text.h"
#include "film/film_marks.h"
#include "image/image.h"
#include "scene/settings.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

SIZED_DEFAULT_OWN(fathom_write_options, {.exposure = 0})

void fathom_image_prefetch(void) { image_prefetch(); }

fathom_status fathom_image_libraries(fathom_context *context, char *out, size_t size) {
    char libraries[256];
    if (!context || !out) return fail_null(context, "out");
    fathom_status status = image_libraries(context, libraries);
    if (status == FATHOM_OK) snprintf(out, size, "%s", libraries);
    return status;
}

fathom_status fathom_write_check(fathom_context *context, const char *path,
                                 const fathom_write_options *options) {
    if (!context || !path) return fail_null(context, "path");
    fathom_write_options write;
    fathom_status status = SIZED_OWN(context, fathom_write_options, options, &write);
    return status == FATHOM_OK ? image_check(context, path, &write) : status;
}

fathom_status fathom_write_check_size(fathom_context *context, const char *path, uint32_t width,
                                      uint32_t height) {
    if (!context || !path) return fail_null(context, "path");
    return image_check_size(context, path, width, height);
}

bool fathom_write_is_srgb(const fathom_write_options *options) {
    fathom_write_options write;
    return SIZED_OWN(NULL, fathom_write_options, options, &write) == FATHOM_OK && image_view_is_srgb(&write);
}

bool fathom_write_needs_helper(const char *path, const fathom_write_options *options) {
    fathom_write_options write;
    return path && SIZED_OWN(NULL, fathom_write_options, options, &write) == FATHOM_OK &&
           image_needs_module(path, &write);
}

/* The destination. options: NULL for calls that use none. */
typedef struct target {
    const char *path;
    const fathom_write_options *options;
} target;

typedef fathom_status (*write_call)(fathom_context *context, const image *img, const target *to);

/* Removes empty texts; returns the number of entries left. */
static size_t keep_known(image_attribute *attributes, size_t count) {
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        if (!attributes[i].text || *attributes[i].text) attributes[kept++] = attributes[i];
    }
    return kept;
}

#define ERROR_ATTRIBUTES 4

/* Adds the known errors, and returns the number of entries; 0: the render estimated none. */
static size_t tell_error(const fathom_film *film, film_error *error, image_attribute *out) {
    size_t count = 0;
    if (film->stats.error_estimate > 0 && isfinite(film->stats.error_estimate))
        out[count++] = (image_attribute){"fathom:errorEstimate", NULL, &film->stats.error_estimate, 1};
    if (!film_error_of(film, error)) return count;
    out[count++] = (image_attribute){"fathom:error", NULL, &error->error, 1};
    out[count++] = (image_attribute){"fathom:errorDoubtful", NULL, &error->doubtful, 1};
    out[count++] = (image_attribute){"fathom:errorUnseen", NULL, &error->unseen, 1};
    return count;
}

static fathom_status write_film(fathom_context *context, const fathom_film *film, write_call call,
                                const target *to) {
    const locale_t own = text_locale_begin();
    image_channel channels[FILM_CHANNELS];
    uint32_t channel_count = 0;
    for (uint32_t i = 0; i < film->channel_count; ++i) {
        const film_channel *c = &film->channels[i];
        if (!c->name_in_file) continue;
        channels[channel_count++] = (image_channel){c->name_in_file, c->is_id ? IMAGE_UINT : IMAGE_FLOAT,
                                                    c->color, c->data, sizeof(float)};
    }
    const double spp = film->settings.spp, seed = (double)film->settings.seed,
                 fovy = film->camera.orthographic
                            ? 0
                            : 2 * atan(film->camera.h / (2 * film->camera.d)) * 57.29577951308232;
    const double mean_spp = (double)film->stats.samples / ((double)film->width * film->height);
    char settings[SETTINGS_TEXT], pattern[PARAMETER_NAME];
    settings_print(&film->settings, settings);
    parameter_print(parameter_find(settings_table, "pattern"), &film->settings, pattern, sizeof pattern);
    char software[64] = "Fathom ";
    for (size_t i = 0; fathom_version()[i] && i < 32; ++i) software[7 + i] = fathom_version()[i];
    char fingerprint[24];
    snprintf(fingerprint, sizeof fingerprint, "%016llx", (unsigned long long)film->stats.scene_fingerprint);
    const char *command = to->options && to->options->command ? to->options->command : "";
    const image_attribute attributes[] = {
        {"Software", software, NULL, 0},
        {"fathom:scene", film->scene_name, NULL, 0},
        {"fathom:version", fathom_version(), NULL, 0},
        {"fathom:commit", fathom_commit(), NULL, 0},
        {"fathom:command", command, NULL, 0},
        {"fathom:fireflies", film->fireflies, NULL, 0},
        {"fathom:fingerprint", fingerprint, NULL, 0},
        {"fathom:tracer", film->stats.tracer, NULL, 0},
        {"fathom:pattern", pattern, NULL, 0},
        {"fathom:spp", NULL, &spp, 1},
        {"fathom:seed", NULL, &seed, 1},
        {"fathom:settings", settings, NULL, 0},
        {"fathom:camera:origin", NULL, film->camera.origin, 3},
        {"fathom:camera:x", NULL, film->camera.x, 3},
        {"fathom:camera:y", NULL, film->camera.y, 3},
        {"fathom:camera:z", NULL, film->camera.z, 3},
        {"fathom:camera:fovy", NULL, &fovy, 1},
        {"fathom:meanSpp", NULL, &mean_spp, 1},
    };
    size_t count = sizeof attributes / sizeof *attributes;
    film_marks marks;
    film_error error;
    image_attribute all[sizeof attributes / sizeof *attributes + ERROR_ATTRIBUTES + FILM_MARKS];
    memcpy(all, attributes, count * sizeof *all);
    count += tell_error(film, &error, all + count);
    film_marks_of(film, to->options, &marks);
    memcpy(all + count, marks.items, marks.count * sizeof *all);
    const image img = {.width = film->width,
                       .height = film->height,
                       .x = film->x,
                       .y = film->y,
                       .full_width = film->full_width,
                       .full_height = film->full_height,
                       .channels = channels,
                       .channel_count = channel_count,
                       .attributes = all,
                       .attribute_count = keep_known(all, count + marks.count)};
    const fathom_status status = call(context, &img, to);
    text_locale_end(own);
    return status;
}

static fathom_status write_whole(fathom_context *context, const image *img, const target *to) {
    return image_write(context, img, to->path, to->options);
}

static fathom_status write_plain(fathom_context *context, const image *img, const target *to) {
    return exr_write_plain(context, img, to->path);
}

static fathom_status write_rehearsal(fathom_context *context, const image *img, const target *to) {
    return image_rehearse(context, img, to->path, to->options);
}

fathom_status fathom_film_write(fathom_context *context, const fathom_film *film, const char *path,
                                const fathom_write_options *options) {
    if (!context || !film) return fail_null(context, "film");
    if (!path) return fail_null(context, "path");
    fathom_write_options write;
    fathom_status status = SIZED_OWN(context, fathom_write_options, options, &write);
    if (status != FATHOM_OK) return status;
    return write_film(context, film, write_whole, &(target){.path = path, .options = &write});
}

fathom_status fathom_film_write_plain(fathom_context *context, const fathom_film *film, const char *path) {
    if (!context || !film) return fail_null(context, "film");
    if (!path) return fail_null(context, "path");
    return write_film(context, film, write_plain, &(target){.path = path});
}

/* ---- duration of writing ---- */

/* Number of rows that EXR compresses together. */
#define GROUP 16u

/* At least one group in this many is written as a rehearsal. */
#define SHARE 8u

static void strip_destroy(fathom_film *strip) {
    for (uint32_t i = 0; i < strip->channel_count; ++i) free(strip->channels[i].data);
}

/* Makes a film of groups of rows from all over the film; complete enough for writing. */
static bool strip_create(const fathom_film *film, uint32_t groups, fathom_film *out) {
    const size_t bytes = (size_t)GROUP * film->width * sizeof(float), all = film->height / GROUP;
    *out = *film;
    out->height = out->full_height = groups * GROUP, out->y = 0;
    for (out->channel_count = 0; out->channel_count < film->channel_count; ++out->channel_count) {
        char *to = malloc(groups * bytes);
        if (!to) return false;
        for (size_t g = 0; g < groups; ++g) {
            const char *from = film->channels[out->channel_count].data;
            memcpy(to + g * bytes, from + g * all / groups * bytes, bytes);
        }
        out->channels[out->channel_count].data = to;
    }
    return true;
}

static double rehearse(fathom_context *context, const fathom_film *film, uint32_t groups,
                       const film_outputs *outputs) {
    fathom_film strip;
    double seconds = 0;
    if (strip_create(film, groups, &strip)) {
        double began = clock_seconds();
        for (size_t i = 0; i < outputs->count; ++i) {
            write_film(context, &strip, write_rehearsal,
                       &(target){.path = outputs->paths[i], .options = outputs->options});
        }
        seconds = clock_seconds() - began;
    }
    strip_destroy(&strip);
    return seconds;
}

static uint32_t at_most(uint32_t a, uint32_t b) { return a < b ? a : b; }

/* Fits a constant time per file and a time per group of rows to two sizes. The larger size grows while
 * `allowed` permits. The first write of all is not timed: it loads libraries and data that later ones
 * reuse. */
double film_write_seconds(fathom_context *context, const fathom_film *film, const film_outputs *outputs,
                          double allowed) {
    const uint32_t all = film->height / GROUP;
    if (all < 2) return 0; /* negligible time */
    rehearse(context, film, 1, outputs);
    double one = rehearse(context, film, 1, outputs), more, spent = 0;
    uint32_t groups, next = all / SHARE > 2 ? all / SHARE : 2;
    do {
        groups = next, next = at_most(2 * groups, all);
        more = rehearse(context, film, groups, outputs);
        spent += more;
    } while (groups < all && spent + 2 * more < allowed);
    return one + fmax(more - one, 0) / (groups - 1) * ((double)film->height / GROUP - 1);
}
