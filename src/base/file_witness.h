/* Whether a mapped file still holds what it held. */
#ifndef BASE_FILE_WITNESS_H
#define BASE_FILE_WITNESS_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/stat.h>

/* Remembers when the file was last written to (its stamp), and bit by bit what it holds (a hash of 64 bits),
 * so that a new stamp over the same bytes, as `touch` makes it, can be told from other bytes. Any thread may
 * look. */
typedef struct file_witness file_witness;

typedef enum file_state { FILE_SAME, FILE_TRUNCATED, FILE_CHANGED } file_state;

/* What is hashed by when: so much at the first look, and from so many seconds of work on, which are worth
 * saving, so many bytes for each of them, a hundredth of a processor or so. */
#define WITNESS_AT_ONCE ((off_t)1 << 20)
#define WITNESS_AFTER 10.0
#define WITNESS_RATE 1e8

/* The file as it is mapped: info of its descriptor. Times are clock_seconds(). NULL: no memory. */
file_witness *witness_create(const char *path, const struct stat *info, double now);
void witness_destroy(file_witness *w);
const char *witness_path(const file_witness *w);

/* FILE_CHANGED and FILE_TRUNCATED once the bytes were others or not as many, or may have been: the stamp is
 * new and not all had been hashed before. They stay so, even if the file is put right again. A file that was
 * replaced under its name is the same, since the mapping keeps the old one. Bytes that were written and put
 * back between two looks are not seen. left: the file's size where it was truncated. */
file_state witness_look(file_witness *w, double now, size_t *left);

/* Whether the file was touched since this was last asked: written to, but its bytes are the same. */
bool witness_take_touched(file_witness *w);

#endif
