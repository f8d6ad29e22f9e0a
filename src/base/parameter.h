/* Access to members of plain structs through rows of a table: defaults, checks, text, numbers. `base` is the
 * address of the struct. */
#pragma once

#include "base/text.h"

#include <fathom/parameter.h>

typedef struct parameter_table {
    const fathom_parameter *rows;
    size_t count;
} parameter_table;

/* Maxima: PARAMETER_COUNT is in numbers per member, the others are in bytes of text. */
enum { PARAMETER_COUNT = 4, PARAMETER_NAME = 32, PARAMETER_TEXT = 160, PARAMETER_WRONG = 480 };

/* NULL when there is none. */
const fathom_parameter *parameter_find(parameter_table table, const char *name);

/* Writes the name with its parts joined by `between`: '-' gives "max-depth", ' ' "max depth", 0 "maxDepth". A
 * part of one letter is appended to the part before it: "k_d" is always "kd". */
void parameter_name(const fathom_parameter *p, char between, char out[PARAMETER_NAME]);

/* The count of numbers in the member, at least 1. */
unsigned parameter_count(const fathom_parameter *p);
double parameter_number(const fathom_parameter *p, const void *base, unsigned i);
void parameter_set_number(const fathom_parameter *p, void *base, unsigned i, double number);
/* Copies the member from one struct to another. */
void parameter_copy(const fathom_parameter *p, const void *from, void *to);

/* Sets every member to its default, and texts to NULL. */
void parameters_default(parameter_table table, void *base);

/* FATHOM_BAD_INPUT: a number is out of range. FATHOM_BAD_USAGE: the value of an enum or a bit set has no
 * word. */
fathom_status parameters_check(fathom_context *context, parameter_table table, const void *base);

/* Sets the member from text. A member of type text keeps the pointer, not a copy. False: the text is not
 * valid, the member is unchanged, and `wrong` holds "expected …, found …". */
bool parameter_read(const fathom_parameter *p, const char *text, void *base, char wrong[PARAMETER_WRONG]);
/* Writes the value as text that parameter_read() accepts. Returns the full length even if `room` is too
 * small, as snprintf() does. */
size_t parameter_print(const fathom_parameter *p, const void *base, char *out, size_t room);

/* Reads decimal digits up to the character `end` and moves *text past it. False: there is no digit, the
 * number is too large, or another character follows. */
bool text_read_u64(const char **text, char end, uint64_t *out);
