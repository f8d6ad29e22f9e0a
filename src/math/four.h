/* Four floats as one register, by the compilers' vectors: for loops that they do not vectorise themselves. */
#ifndef MATH_FOUR_H
#define MATH_FOUR_H

#include <string.h>

#define FOUR_INLINE static inline __attribute__((always_inline)) /* into code for any instruction set */

typedef float four __attribute__((vector_size(16)));
typedef int four_marks __attribute__((vector_size(16))); /* each -1 or 0 */

FOUR_INLINE four four_load(const void *from) {
    four v;
    memcpy(&v, from, sizeof v);
    return v;
}

FOUR_INLINE four four_magnitude(four v) { return (four)((four_marks)v & 0x7fffffff); }

/* a where marked, else b. */
FOUR_INLINE four four_choose(four_marks marks, four a, four b) {
    return (four)(((four_marks)a & marks) | ((four_marks)b & ~marks));
}

/* b for a NaN in a. */
FOUR_INLINE four four_larger(four a, four b) { return four_choose(a > b, a, b); }
FOUR_INLINE four four_smaller(four a, four b) { return four_choose(a < b, a, b); }

#endif
