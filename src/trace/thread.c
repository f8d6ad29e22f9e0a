#include "trace/trace.h"

#if defined(__SSE2__)
#include <xmmintrin.h>
#define FLUSH_TO_ZERO 0x8000u
#define DENORMALS_ARE_ZERO 0x0040u

unsigned trace_thread_begin(void) {
    unsigned state = _mm_getcsr();
    _mm_setcsr(state | FLUSH_TO_ZERO | DENORMALS_ARE_ZERO);
    return state;
}
void trace_thread_end(unsigned state) { _mm_setcsr(state); }
#else
unsigned trace_thread_begin(void) { return 0; }
void trace_thread_end(unsigned state) { (void)state; }
#endif
