/* Looking through the arrays of a mesh, in parallel. */
#ifndef SCENE_ARRAY_CHECK_H
#define SCENE_ARRAY_CHECK_H

#include "base/status.h"

/* FATHOM_BAD_INPUT, with "what[17]", for the first item that holds a NaN or an infinity. Items have
 * `components` floats and lie `stride` bytes apart, a multiple of 4. */
fathom_status array_check_finite(fathom_context *context, const char *what, const float *values,
                                 size_t stride, size_t components, uint32_t count);
/* The same for the first index, three to a triangle, that is not below `limit`. */
fathom_status array_check_indices(fathom_context *context, const char *what, const uint32_t *indices,
                                  size_t count, uint32_t limit);

#endif
