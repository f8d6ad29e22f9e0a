/* A JSON document while it is read: reads its objects by the tables of json_form.h, and adds the line and
 * path to errors. */
#pragma once

#include "base/status.h"
#include "read/json/json_form.h"
#include "read/json/json_where.h"

typedef struct doc {
    fathom_context *context;
    const char *path; /* of the file */
    const char *text; /* all of it, zero-terminated */
    size_t *told;     /* how many warnings there were */
} doc;

/* Fills in *spot: file, line and path. */
const fathom_place *doc_place(const doc *d, const where *at, where_spot *spot);
#define doc_fail(d, at, ...)                                                                                 \
    fail_at((d)->context, FATHOM_BAD_INPUT, doc_place(d, at, &(where_spot){.place.line = 0}), __VA_ARGS__)
/* Adds a warning about a value, with its place; after some, only that there are more. */
void doc_warn(const doc *d, const where *at, const char *format, ...) __attribute__((format(printf, 3, 4)));
/* Adds the place to a callee's error. If the value at the place has a member with the name of the error's
 * field, the path includes the field. */
fathom_status doc_within(const doc *d, const where *at, fathom_status status);
/* "expected `expected`, found " and the value there. */
fathom_status doc_expected(const doc *d, const where *at, json_t *value, const char *expected);
/* "there is no `what` "name"", with the most similar name in `names`, or with all names if there are only a
 * few. */
fathom_status doc_unknown_name(const doc *d, const where *at, const char *what, const char *name,
                               json_t *names);

/* Fails for the key at.key of an object of this form. The key may belong to another variant, such as a
 * material of another model, or to an object or list in this one. */
fathom_status doc_unknown_key(const doc *d, const where *at, json_t *value, const form *f);
/* Fails for a value of the key that selects a variant of the form. */
fathom_status doc_unknown_type(const doc *d, const where *at, json_t *value, const form *f);
/* The key that selects a variant of the form. */
const char *doc_tag(const form *f);
/* Appends to a list in text, with `mark` around the word. From the first word without room on, "..." stands
 * for all. */
void doc_list_word(char *text, size_t room, const char *word, const char *mark);

/* Reads an object by its form into the struct that the form fills. If a key is absent, its member is
 * unchanged. */
fathom_status doc_read(const doc *d, const where *at, json_t *value, const form *f, void *to);
/* Warns of the keys that have no effect, by the rules FORM_WANTS. also: a key that counts as present, or
 * NULL. */
void doc_warn_useless(const doc *d, const where *at, json_t *value, const form *f, const char *also);
/* Finds the variant that the object's "type", or the form's own tag, names. */
fathom_status doc_choose(const doc *d, const where *at, json_t *value, const form *f, const form **out);

static inline bool doc_has(json_t *object, const char *key) { return json_object_get(object, key) != NULL; }
