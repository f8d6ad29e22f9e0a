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
 * internal error.
 *
 * Libraries in C have other ways to go: some of the image module's call exit() or abort(), trap,
 * or write through a null pointer when they lack memory. While they are loaded, all that ends as above. When
 * they are called, the call fails, and the pixels can be saved by other means; but exit(), and what happens
 * on their own threads, ends as above. The same signals elsewhere, or from other processes, go where they
 * went before, once temporary files are removed. */
void exhausted_watch(void);

#ifdef __cplusplus
}
#endif

#endif
