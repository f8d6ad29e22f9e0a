/* Frames and transforms of scene JSON. */
#ifndef READ_JSON_PLACE_H
#define READ_JSON_PLACE_H

#include "math/affine.h"
#include "math/frame.h"
#include "read/json/json_doc.h"

/* `value` is the "frame" object that was read into `values`. */
fathom_status place_frame(const doc *d, const where *at, json_t *value, const form_frame_values *values,
                          frame_f64 *out);

/* The map of an object's placement keys; *placed is false when it has none. */
fathom_status place_object(const doc *d, const where *at, json_t *object, const form_place_values *values,
                           affine_f64 *out, bool *placed);

double place_radians(double degrees);

#endif
