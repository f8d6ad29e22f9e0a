/* Memory that a library could not be given. */
#ifndef CLI_EXHAUSTED_H
#define CLI_EXHAUSTED_H

#ifdef __cplusplus
extern "C" {
#endif

/* From here on. Some address space is set aside, and given back when a request is refused for the first time;
 * the request is then made again. The next one that is refused ends the process: a message, no temporary
 * file, exit code 4. Little of the libraries' code knows better: where it runs while a library is loaded, or
 * on a thread of their own, the exception would end in abort(), and in some of their schedulers in a wait
 * without end. An exception that nobody catches, for whatever reason, ends the process the same way, as an
 * internal error. */
void exhausted_watch(void);

#ifdef __cplusplus
}
#endif

#endif
