/* Shared by the parts of the writer of scene JSON. */
#pragma once

#include "base/file.h"
#include "write/image.h"
#include "write/write.h"
#include "write/write_form.h"

typedef struct json_out {
    const fathom_scene *scene;
    const scene_graph *graph;
    write_stream stream;
    write_images images;
    char **materials, **groups; /* their names */
    bool *numbered;             /* by group: its shapes without a name get their kind and number */
    note_list *notes;
} json_out;

/* The name of the light group of a source; NULL: it is in none. */
const char *json_light_group(const fathom_scene *scene, fathom_light_source source, fathom_id id);

/* The members "groups" and "objects". */
fathom_status json_put_objects(json_out *o);
/* Twelve numbers, rows of an affine map, as an array of columns. */
void json_put_matrix(file_writer *t, const double rows[12]);
