/* The film to an image file, with what it was made from in the header. */
#include "image/image.h"
#include "render/film.h"
#include "trace/trace.h"

void fathom_write_options_default(fathom_write_options *options) {
    *options = (fathom_write_options){.exposure = 0};
}

/* What comes beside the load finds its threads made. */
void fathom_image_prefetch(void) {
    trace_start_threads();
    image_prefetch();
}

fathom_status fathom_film_write(fathom_context *context, const fathom_film *film, const char *path,
                                const fathom_write_options *options) {
    image_channel channels[FILM_CHANNELS];
    for (uint32_t i = 0; i < film->channel_count; ++i) {
        const film_channel *c = &film->channels[i];
        channels[i] =
            (image_channel){c->name, c->is_id ? IMAGE_UINT : IMAGE_FLOAT, c->color, c->data, sizeof(float)};
    }
    const double spp = film->settings.spp, seed = (double)film->settings.seed,
                 seconds = film->stats.render_seconds,
                 fovy = 2 * atan(film->camera.h / (2 * film->camera.d)) * 57.29577951308232;
    const double mean_spp = (double)film->stats.samples / ((double)film->width * film->height);
    const bool estimated = film->stats.error_estimate > 0 && isfinite(film->stats.error_estimate);
    const char *pattern = film->settings.pattern == FATHOM_PATTERN_GRID         ? "grid"
                          : film->settings.pattern == FATHOM_PATTERN_STRATIFIED ? "stratified"
                                                                                : "sobol";
    char software[64] = "Fathom ";
    for (size_t i = 0; fathom_version()[i] && i < 32; ++i) software[7 + i] = fathom_version()[i];
    const image_attribute attributes[] = {
        {"Software", software, NULL, 0},
        {"fathom:scene", film->scene_name, NULL, 0},
        {"fathom:version", fathom_version(), NULL, 0},
        {"fathom:tracer", film->stats.tracer, NULL, 0},
        {"fathom:pattern", pattern, NULL, 0},
        {"fathom:spp", NULL, &spp, 1},
        {"fathom:seed", NULL, &seed, 1},
        {"fathom:renderTime", NULL, &seconds, 1},
        {"fathom:camera:origin", NULL, film->camera.origin, 3},
        {"fathom:camera:x", NULL, film->camera.x, 3},
        {"fathom:camera:y", NULL, film->camera.y, 3},
        {"fathom:camera:z", NULL, film->camera.z, 3},
        {"fathom:camera:fovy", NULL, &fovy, 1},
        {"fathom:meanSpp", NULL, &mean_spp, 1},
        {"fathom:errorEstimate", NULL, &film->stats.error_estimate, 1}, /* of renders that estimate it */
    };
    const image img = {.width = film->width,
                       .height = film->height,
                       .x = film->x,
                       .y = film->y,
                       .full_width = film->full_width,
                       .full_height = film->full_height,
                       .channels = channels,
                       .channel_count = film->channel_count,
                       .attributes = attributes,
                       .attribute_count = sizeof attributes / sizeof *attributes - !estimated};
    return image_write(context, &img, path, options);
}
