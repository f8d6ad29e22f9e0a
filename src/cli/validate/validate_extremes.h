/* The grid of extreme cases, in `fathom validate --extremes`. */
#ifndef CLI_VALIDATE_EXTREMES_H
#define CLI_VALIDATE_EXTREMES_H

#include "cli/validate/validate.h"
#include "verify/extremes/extremes.h"

#include <jansson.h>

/* Runs the grid with the settings' tracers, or those of its own where none are named, and appends rows, and
 * failures where --failures asks for them. */
fathom_status validate_extremes_run(fathom_context *context, const validate_settings *settings,
                                    extremes_rows *rows, extremes_failures *failures);
/* Over all rows. */
uint64_t validate_extremes_wrong(const extremes_rows *rows);
uint64_t validate_extremes_leaks(const extremes_rows *rows);
void validate_extremes_print(const extremes_rows *rows, const validate_settings *settings);
/* The list "extremes" of --json. */
json_t *validate_extremes_json(const extremes_rows *rows);

#endif
