/* Shared by the parts of the writer of scene JSON. */
#pragma once

#include "base/file.h"
#include "read/json/json_form.h"
#include "write/image.h"
#include "write/write.h"

typedef struct json_out {
    const fathom_scene *scene;
    const scene_graph *graph;
    write_stream stream;
    write_images images;
    char **materials, **groups; /* their names */
} json_out;

/* The name of the light group of a source; NULL: it is in none. */
const char *json_light_group(const fathom_scene *scene, fathom_light_source source, fathom_id id);

/* The members "groups" and "objects". */
fathom_status json_put_objects(json_out *o);
/* Twelve numbers, rows of an affine map, as an array of columns. */
void json_put_matrix(file_writer *t, const double rows[12]);

/* Writes the members of a struct, by the tables that the reader of scene JSON uses (read/json/json_form.h):
 * those of `values` that differ from `usual`, and the required ones. A comma precedes each member, except the
 * first if `*comma` is "". The caller writes lists, maps and rows. Keys are skipped if a key that they need
 * is not written, because they have no effect without it. */
void form_put(file_writer *t, const form *f, const void *values, const void *usual, const char **comma);
/* The variant with this id. */
const form *form_variant(const form *f, int id);
/* Decimal text that reads back as the same number. */
void form_put_number(file_writer *t, double number);
/* Adds a note for each number, word or switch that has an effect in `before` and is another one in `after`.
 * Numbers may differ by rounding. format: the name of the file format that cannot hold them. */
void form_note_changes(const form *f, const void *before, const void *after, const void *usual,
                       const char *format, note_list *notes);
