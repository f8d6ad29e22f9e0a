/* A JSON document under reading: its tables followed, its errors placed. */
#ifndef READ_JSON_DOC_H
#define READ_JSON_DOC_H

#include "base/status.h"
#include "read/json/json_form.h"
#include "read/json/json_where.h"

typedef struct doc {
    fathom_context *context;
    const char *path; /* of the file */
    const char *text; /* all of it, zero-terminated */
} doc;

/* A place for messages, with the memory of its path. */
typedef struct doc_spot {
    fathom_place place;
    char path[512];
} doc_spot;

/* Fills in *spot: file, line and path. */
const fathom_place *doc_place(const doc *d, const where *at, doc_spot *spot);
#define doc_fail(d, at, ...)                                                                                 \
    fail_at((d)->context, FATHOM_BAD_INPUT, doc_place(d, at, &(doc_spot){.place.line = 0}), __VA_ARGS__)
/* Adds the place to a callee's error. Its field joins the path where the document has it under that name. */
fathom_status doc_within(const doc *d, const where *at, fathom_status status);
/* "expected `expected`, found " and the value there. */
fathom_status doc_expected(const doc *d, const where *at, json_t *value, const char *expected);
/* "there is no `what` "name"", with the nearest name of those in `names`, or all of them when they are few.
 */
fathom_status doc_unknown_name(const doc *d, const where *at, const char *what, const char *name,
                               json_t *names);

/* Reads an object by its form into the struct the form fills. Members whose keys are absent keep what they
 * hold. */
fathom_status doc_read(const doc *d, const where *at, json_t *value, const form *f, void *to);
/* The variant that the object's "type" names, or its form's own tag. */
fathom_status doc_choose(const doc *d, const where *at, json_t *value, const form *f, const form **out);

/* The numbers of a FORM_ROWS value that was read, row after row. */
void doc_rows(json_t *rows, unsigned count, double *out);

static inline bool doc_has(json_t *object, const char *key) { return json_object_get(object, key) != NULL; }

#endif
