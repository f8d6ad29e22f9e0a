/* Handles out-of-memory in libraries. */
#pragma once

#ifdef __cplusplus
extern "C" {
#endif

/* Reserves some address space, and releases it when an allocation fails for the first time; the allocation is
 * then repeated. The next failure ends the process with a message and exit code 4, and removes temporary
 * files. The reason: libraries handle std::bad_alloc badly. While a library is loaded, or on one of its
 * threads, the exception would end in abort(), and in some schedulers in an endless wait. An uncaught
 * exception ends the process the same way, as an internal error. */
void exhausted_watch(void);

#ifdef __cplusplus
}
#endif
