/* Both path integrators, compared over the 16 cells of an image. */
#pragma once

#include "base/status.h" /* before unit.h: cmocka has a macro fail() */

#include "unit.h"
#include "verify/laws/laws.h"

/* The allowance is that of `fathom validate --light`. Sanitizers watch memory, which few samples reach as
 * well. */
static inline laws_pair pair_of(uint32_t depth, uint64_t samples) {
    return (laws_pair){.across = 4,
                       .down = 4,
                       .depth = depth,
                       .samples = SANITIZED ? 1 << 13 : samples,
                       .seed = 1,
                       .threads = 2,
                       .allowance = 2e-5};
}
