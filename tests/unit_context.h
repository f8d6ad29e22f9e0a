/* A context, for tests that need no more: set-up of a group. */
#pragma once

#include "owned.h"

static fathom_context *context;

static inline int open_context(void **state) {
    (void)state;
    context = new_context();
    return 0;
}
