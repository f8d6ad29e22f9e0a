/* What every unit test includes. */
#ifndef TESTS_UNIT_H
#define TESTS_UNIT_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* |a - b| <= tolerance; NaN fails. Each use says where its tolerance comes from. */
#define assert_near(a, b, tolerance)                                                                         \
    do {                                                                                                     \
        double near_a = (double)(a), near_b = (double)(b);                                                   \
        if (!(fabs(near_a - near_b) <= (double)(tolerance))) {                                               \
            fail_msg("%s = %.17g, expected %s = %.17g within %g", #a, near_a, #b, near_b,                    \
                     (double)(tolerance));                                                                   \
        }                                                                                                    \
    } while (0)

/* The call succeeds; otherwise its message is shown. */
#define assert_ok(context, call)                                                                             \
    do {                                                                                                     \
        if ((call) != FATHOM_OK) fail_msg("%s: %s", #call, fathom_context_message(context));                 \
    } while (0)

/* The call fails with this status, and the message holds `text`. */
#define assert_fails(context, call, status, text)                                                            \
    do {                                                                                                     \
        assert_int_equal((call), (status));                                                                  \
        if (!strstr(fathom_context_message(context), (text))) {                                              \
            fail_msg("%s: message \"%s\" does not hold \"%s\"", #call, fathom_context_message(context),      \
                     (text));                                                                                \
        }                                                                                                    \
    } while (0)

#endif
