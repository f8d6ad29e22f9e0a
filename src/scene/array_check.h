/* Checks of the arrays of a mesh, in parallel; see mesh_facts.h for what is found out besides. */
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

/* What both are made of. The first of `count` items that holds a NaN or an infinity, the first index that is
 * not below `limit`; `count` where there is none. */
size_t array_first_odd(const float *values, size_t stride, size_t components, size_t count);
size_t array_first_beyond(const uint32_t *indices, size_t count, uint32_t limit);
/* The failures, FATHOM_BAD_INPUT; that of the stride only where it is not as expected. */
fathom_status array_check_stride(fathom_context *context, const char *what, size_t stride, size_t components);
fathom_status array_fail_odd(fathom_context *context, const char *what, size_t bad);
fathom_status array_fail_index(fathom_context *context, const char *what, const uint32_t *indices, size_t bad,
                               uint32_t limit);

#endif
