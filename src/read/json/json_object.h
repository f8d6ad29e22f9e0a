/* The objects of scene JSON: from the document into the scene. */
#ifndef READ_JSON_OBJECT_H
#define READ_JSON_OBJECT_H

#include "read/json/json_doc.h"
#include "scene/scene.h"

typedef struct object_reader {
    const doc *doc;
    fathom_scene *scene;
    json_t *materials, *groups; /* the ids by name */
} object_reader;

/* Adds the objects of `list` to `group`, in their order. */
fathom_status object_list(const object_reader *r, const where *at, json_t *list, fathom_id group);

#endif
