/* Shading where it is stiff, in `fathom validate --extremes`. */
#ifndef CLI_VALIDATE_SHADING_H
#define CLI_VALIDATE_SHADING_H

#include "cli/validate/validate.h"
#include "verify/light/shading.h"

/* Runs all cases with each of the settings' tracers but those from outside, which take triangles alone, and
 * appends rows; images only for --json or --report. */
fathom_status validate_shading_run(fathom_context *context, const validate_settings *settings,
                                   shading_rows *rows, shading_images *images);
/* Rows out of their bounds. */
uint64_t validate_shading_wrong(const shading_rows *rows);
void validate_shading_print(const shading_rows *rows, const validate_settings *settings);
/* The lists "shading" and "images" of --json. */
json_t *validate_shading_json(const shading_rows *rows);
json_t *validate_images_json(const shading_images *images);

#endif
