/* One HTML document that needs nothing else: no script, no network, plots as SVG within it. */
#ifndef REPORT_PAGE_H
#define REPORT_PAGE_H

#include "base/array.h"
#include "base/status.h"

typedef struct page {
    char *items; /* the document so far */
    size_t count, capacity;
    char *links; /* what leads to its sections */
    size_t links_count, links_capacity;
    size_t links_at; /* where they belong */
    bool lost;       /* memory ran out: page_write() says so */
    unsigned ids;    /* given so far, for what refers to another element */
} page;

/* Zero it first, release it with page_free(). `title` is escaped. */
void page_begin(page *p, const char *title);
/* The links to the sections go here. */
void page_links(page *p);
/* A section lasts until the next one, or the end. `name` is plain letters. */
void page_section(page *p, const char *name, const char *heading);
void page_end(page *p);
void page_free(page *p);

/* Markup. Text from outside the program never goes here, but to page_text(). */
void page_put(page *p, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Text of any origin, which stands for itself between tags and in attributes. NULL: nothing. */
void page_text(page *p, const char *text);
void page_textf(page *p, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* FATHOM_OUT_OF_RESOURCES when page_write() would fail: `folder` is no folder and cannot become one, or holds
 * an index.html that no report has written. */
fathom_status page_check(fathom_context *context, const char *folder);
/* Makes the folder if need be; index.html is there whole or not at all. */
fathom_status page_write(fathom_context *context, const page *p, const char *folder);

#endif
