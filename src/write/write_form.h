/* Writes structs as JSON, by the tables that the reader of scene JSON uses (read/json/json_form.h). */
#pragma once

#include "base/file.h"
#include "read/json/json_form.h"
#include "read/mesh/text.h"

/* Writes the members of `values` that differ from `usual`, and the required ones, with commas between them.
 * The caller writes lists, maps and rows. Keys are skipped if a key that they need is not written, because
 * they have no effect without it. Numbers that the reader would refuse become the nearest that it takes, with
 * a note. */
void form_put(file_writer *t, const form *f, const void *values, const void *usual, note_list *notes);
/* The value of one key of numbers. */
void form_put_numbers(file_writer *t, const form_key *key, const void *value, note_list *notes);
/* The nearest number that the reader takes; with `single`, the nearest float. */
double form_nearest(const form_key *key, double number, bool single);
/* Adds a note on numbers of this key that form_nearest() changed. */
void form_note_nearest(const form_key *key, size_t changed, note_list *notes);
/* The variant with this id. */
const form *form_variant(const form *f, int id);
/* Decimal text that reads back as the same number. */
void form_put_number(file_writer *t, double number);
/* Adds a note for each number, word or switch that has an effect in `before` and is another one in `after`.
 * Numbers may differ by rounding. format: the name of the file format that cannot hold them. */
void form_note_changes(const form *f, const void *before, const void *after, const void *usual,
                       const char *format, note_list *notes);
