/* Structs as JSON, by the tables that the reader of scene JSON follows (read/json/json_form.h). */
#ifndef WRITE_FORM_H
#define WRITE_FORM_H

#include "base/file.h"
#include "read/json/json_form.h"

/* The members of `values` that differ from `usual`, and those that every such object needs, each behind a
 * comma but the first if `*comma` is "". Lists, maps and rows are left to the caller. Keys that need others
 * which are not given are left out: they mean nothing. */
void form_put(file_writer *t, const form *f, const void *values, const void *usual, const char **comma);
/* The variant of this id. */
const form *form_variant(const form *f, int id);
/* Decimal text that reads back as the same number. */
void form_put_number(file_writer *t, double number);

#endif
