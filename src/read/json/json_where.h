/* Where a value of a JSON document stands in its text. */
#ifndef READ_JSON_WHERE_H
#define READ_JSON_WHERE_H

#include <stdbool.h>
#include <stddef.h>

/* One step of a path from the document's root to a value: a key, or with key NULL an index. The steps are
 * local variables of the functions that walk the document, so that following it costs nothing. */
typedef struct where {
    const struct where *parent; /* NULL: the document itself is the parent */
    const char *key;
    size_t index;
} where;

typedef struct where_place {
    unsigned line;     /* from 1; of the key, for the value of a key */
    const char *value; /* the value's text */
    size_t length;
    bool whole; /* the path was followed to its end */
} where_place;

/* Walks the text, which must be JSON and end with a zero byte, along the path. A step that is not there ends
 * the walk: the place is then that of the last value that is. */
where_place where_find(const char *text, const where *at);

/* Writes the path as objects[3].radius or materials["dark red"]; "" for the document. */
void where_path(const where *at, char *out, size_t room);

#endif
