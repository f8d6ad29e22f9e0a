/* The floating-point mode that the oracle's proofs assume: round to nearest, denormals kept. Tracers run with
 * denormals flushed to zero (see trace_thread_begin()); the oracle must not.
 *
 * Put the arithmetic between enter and leave into a function that is not inlined, because compilers move
 * arithmetic across a mode change. */
#pragma once

#define MODE_APART __attribute__((noinline))

#if defined(__SSE2__)
#include <xmmintrin.h>
#define MODE_DEFAULT 0x1f80u /* all exceptions masked */
static inline unsigned mode_enter(void) {
    unsigned state = _mm_getcsr();
    if (state != MODE_DEFAULT) _mm_setcsr(MODE_DEFAULT);
    return state;
}
static inline void mode_leave(unsigned state) {
    if (state != MODE_DEFAULT) _mm_setcsr(state);
}
#else
/* trace_thread_begin() changes nothing here. */
static inline unsigned mode_enter(void) { return 0; }
static inline void mode_leave(unsigned state) { (void)state; }
#endif
