/* Lack of memory in libraries. */
#ifndef CLI_EXHAUSTED_H
#define CLI_EXHAUSTED_H

#ifdef __cplusplus
extern "C" {
#endif

/* Sets some address space aside, and gives it back when a request is refused for the first time; the request
 * is then repeated. The next refusal ends the process with a message, exit code 4 and no temporary file.
 * Libraries handle std::bad_alloc badly: while a library is loaded, or on a thread of its own, the exception
 * would end in abort(), and in some schedulers in an endless wait. An exception that nobody catches ends the
 * process the same way, as an internal error. */
void exhausted_watch(void);

#ifdef __cplusplus
}
#endif

#endif
