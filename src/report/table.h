/* Tables: columns of words to the left, of numbers to the right, heads that say what they head. */
#ifndef REPORT_TABLE_H
#define REPORT_TABLE_H

#include "report/page.h"

#include <stdint.h>

/* Every text is escaped. */
void table_begin(page *p, const char *caption);
void table_column(page *p, const char *name, bool numbers);
/* After the columns, before the first row or group. */
void table_body(page *p);
/* A row across the table that heads those below it. */
void table_group(page *p, size_t columns, const char *code, const char *words);
/* A row begins with its name, as code or as words. */
void table_row(page *p, const char *name, bool code);
void table_words(page *p, const char *text);
void table_code(page *p, const char *text);
/* Three digits; a NaN leaves the cell empty. */
void table_number(page *p, double x);
/* All digits of a float, for what is compared. */
void table_exact(page *p, double x);
/* All digits; 0 is a dot, so that what is not 0 stands out. */
void table_count(page *p, uint64_t n);
/* As a count, marked: "bad" or "leak"; 0 is not. */
void table_marked(page *p, uint64_t n, const char *class);
void table_end(page *p);

#endif
