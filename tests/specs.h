/* Every Embree tracer that a name can ask for, but for the instruction set and what is left to the build. */
#pragma once

#include "owned.h"

#define SPECS_WORDS 5

/* Calls visit with "embree:triangles:robust:low:1:settled" and all others; what it makes ends with it. */
static inline void specs_each(void (*visit)(void *user, const char *text), void *user) {
    static const char *const words[SPECS_WORDS][5] = {{"triangles", "user"},
                                                      {"robust", "default", "compact"},
                                                      {"low", "medium", "high"},
                                                      {"1", "4", "8", "16"},
                                                      {"settled", "raw"}};
    unsigned at[SPECS_WORDS] = {0}, digit = 0;
    while (digit < SPECS_WORDS) {
        char text[128];
        snprintf(text, sizeof text, "embree:%s:%s:%s:%s:%s", words[0][at[0]], words[1][at[1]],
                 words[2][at[2]], words[3][at[3]], words[4][at[4]]);
        const size_t before = unit_thing_count;
        visit(user, text);
        unit_end_things(before);
        for (digit = 0; digit < SPECS_WORDS && !words[digit][++at[digit]]; ++digit) at[digit] = 0;
    }
}
