/* A context, for tests that need no more: set-up and tear-down of a group. */
#pragma once

#include "unit.h"

#include <fathom/base.h>

static fathom_context *context;

static inline int open_context(void **state) {
    (void)state;
    return fathom_context_create(&context) == FATHOM_OK ? 0 : -1;
}

static inline int close_context(void **state) {
    (void)state;
    fathom_context_destroy(context);
    return 0;
}
