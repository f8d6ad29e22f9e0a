#include "extremes/shading.h"

#include <stdlib.h>

fathom_status shading_run(fathom_context *context, const shading_options *options, shading_rows *out) {
    (void)context;
    (void)options;
    (void)out;
    return FATHOM_OK;
}

fathom_status shading_earth(fathom_context *context, const shading_options *options, shading_rows *rows,
                            shading_images *images) {
    (void)context;
    (void)options;
    (void)rows;
    (void)images;
    return FATHOM_OK;
}

void shading_images_free(shading_images *images) {
    for (size_t i = 0; i < images->count; ++i) free(images->items[i].png);
    array_free(images);
    *images = (shading_images){.items = NULL};
}
