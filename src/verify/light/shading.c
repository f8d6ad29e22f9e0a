#include "verify/light/shading_studio.h"

#include <stdlib.h>

fathom_status shading_run(fathom_context *context, const shading_options *options, shading_rows *out) {
    static fathom_status (*const groups[])(fathom_context *, const shading_options *, shading_rows *) = {
        shading_mirrors, shading_guide, shading_ior, shading_highlights, shading_lights, shading_slants};
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < sizeof groups / sizeof *groups && status == FATHOM_OK; ++i)
        status = groups[i](context, options, out);
    return status;
}

void shading_images_free(shading_images *images) {
    for (size_t i = 0; i < images->count; ++i) free(images->items[i].png);
    array_free(images);
    *images = (shading_images){.items = NULL};
}
