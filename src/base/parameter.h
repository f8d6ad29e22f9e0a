/* Members of plain structs by their rows in a table: defaults, checks, text, numbers. `base` is the struct.
 */
#ifndef BASE_PARAMETER_H
#define BASE_PARAMETER_H

#include "base/text.h"

#include <fathom/parameter.h>

typedef struct parameter_table {
    const fathom_parameter *rows;
    size_t count;
} parameter_table;

/* COUNT: numbers in a member; the others: bytes. */
enum { PARAMETER_COUNT = 4, PARAMETER_NAME = 32, PARAMETER_TEXT = 160, PARAMETER_WRONG = 480 };

/* NULL when there is none. */
const fathom_parameter *parameter_find(parameter_table table, const char *name);

/* The name's parts joined: '-' "max-depth", ' ' "max depth", 0 "maxDepth". A single letter stays with the
 * part before it: "k_d" is "kd" everywhere. */
void parameter_name(const fathom_parameter *p, char between, char out[PARAMETER_NAME]);

/* Numbers in the member, at least 1. */
unsigned parameter_count(const fathom_parameter *p);
double parameter_number(const fathom_parameter *p, const void *base, unsigned i);
void parameter_set_number(const fathom_parameter *p, void *base, unsigned i, double number);
/* Copies the member from one struct to another. */
void parameter_copy(const fathom_parameter *p, const void *from, void *to);

/* Every member gets its default; texts get NULL. */
void parameters_default(parameter_table table, void *base);

/* FATHOM_BAD_INPUT: a number is not allowed. FATHOM_BAD_USAGE: a value has no word. */
fathom_status parameters_check(fathom_context *context, parameter_table table, const void *base);

/* From text, which the member keeps by its pointer. False: the member is as it was, and `wrong` holds
 * "expected …, found …". */
bool parameter_read(const fathom_parameter *p, const char *text, void *base, char wrong[PARAMETER_WRONG]);
/* As text that parameter_read() takes. Returns the length without the limit of `room`. */
size_t parameter_print(const fathom_parameter *p, const void *base, char *out, size_t room);

/* Digits up to `end`; moves *text past it. False: no number, too large, or followed by something else. */
bool text_read_u64(const char **text, char end, uint64_t *out);

#endif
