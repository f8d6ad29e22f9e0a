#include "read/obj/obj.h"

#include <search.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* ---- names ---- */

static int compare(const void *a, const void *b) {
    const name_entry *x = a, *y = b;
    if (x->length != y->length) return x->length < y->length ? -1 : 1;
    return memcmp(x->text, y->text, x->length);
}

uint32_t names_find(const name_table *table, const char *text, size_t length) {
    const name_entry wanted = {text, length, 0}, **found = tfind(&wanted, &table->tree, compare);
    return found ? (*found)->number : UINT32_MAX;
}

uint32_t names_add(name_table *table, const char *text, size_t length) {
    uint32_t known = names_find(table, text, length);
    if (known != UINT32_MAX) return known;
    name_entry *entry = malloc(sizeof *entry);
    if (!entry || !array_push(&table->entries, entry)) {
        free(entry);
        return UINT32_MAX;
    }
    *entry = (name_entry){text, length, (uint32_t)table->entries.count - 1};
    return tsearch(entry, &table->tree, compare) ? entry->number : UINT32_MAX;
}

static void keep(void *entry) { (void)entry; }

void names_free(name_table *table) {
    tdestroy(table->tree, keep);
    for (size_t i = 0; i < table->entries.count; ++i) free(table->entries.items[i]);
    array_free(&table->entries);
    *table = (name_table){0};
}

/* ---- libraries ---- */

/* Each search for a missing file lists its folder, so a file that names very many would take long. */
enum { LIBRARIES_MISSED_MOST = 1000 };

/* The names that were looked for: exporters repeat the statement for each object. */
typedef struct library_names {
    name_table seen;   /* as written in the file; those that were read */
    name_table missed; /* those that were not */
    obj_tally absent;  /* names without a file */
    obj_tally refused; /* names of files that must not be read */
    size_t absent_length;
    char why[320]; /* why the first of them was refused */
} library_names;

static void tally(obj_tally *t, const char *at) {
    if (!t->count++) t->first = at;
}

/* *out: the path of the file with this name of `length` bytes, searched for as images are, because the path
 * may come from another computer; NULL: no such file. FATHOM_BAD_INPUT: the file must not be read; the
 * message has the reason. */
static fathom_status find_library(const obj_reader *r, const char *name, size_t length, char **out) {
    *out = NULL;
    char *copy = strndup(name, length);
    if (!copy) return fail_memory(r->scene->context, length);
    fathom_status status = read_image_beside(r->scene, r->file.path, copy, out);
    if (status == FATHOM_OK && !*out) { /* was it forbidden? */
        status = read_beside(r->scene, r->file.path, copy, out);
        free(*out), *out = NULL;
    }
    free(copy);
    return status;
}

static bool known(const name_table *table, const char *name, size_t length) {
    return names_find(table, name, length) != UINT32_MAX;
}

static bool missed_most(const library_names *names) {
    return names->missed.entries.count + names->refused.count >= LIBRARIES_MISSED_MOST;
}

/* Reads the file if it exists and was not read yet; FATHOM_BAD_INPUT if it must not be read. *found: whether
 * the file exists. */
static fathom_status read_name(obj_reader *r, mtl_library *library, library_names *names, const char *name,
                               size_t length, bool *found) {
    char *path;
    *found = known(&names->seen, name, length);
    if (*found || known(&names->missed, name, length) || missed_most(names)) return FATHOM_OK;
    fathom_status status = find_library(r, name, length, &path);
    if (status != FATHOM_OK) return status;
    if (!path)
        return names_add(&names->missed, name, length) == UINT32_MAX ? fail_memory(r->scene->context, length)
                                                                     : FATHOM_OK;
    *found = true;
    status = names_add(&names->seen, name, length) == UINT32_MAX ? fail_memory(r->scene->context, length)
                                                                 : mtl_read(r->scene->context, path, library);
    free(path);
    return status;
}

/* A missing library only adds a note, because the geometry is still usable. */
static fathom_status read_word(obj_reader *r, mtl_library *library, library_names *names, const char *word,
                               size_t length) {
    bool found;
    fathom_status status = read_name(r, library, names, word, length, &found);
    if (status == FATHOM_BAD_INPUT && !found) {
        if (!names->refused.count)
            snprintf(names->why, sizeof names->why, "%s", fathom_context_message(r->scene->context));
        tally(&names->refused, word);
        return FATHOM_OK;
    }
    if (status == FATHOM_OK && !found) {
        if (!names->absent.count) names->absent_length = length;
        tally(&names->absent, word);
    }
    return status;
}

/* True for "a.mtl b.mtl": a search for the last part of "x/a.mtl x/b.mtl" would find only b.mtl. */
static bool names_several(const obj_mention *mention) {
    const char *end = mention->at + mention->length;
    for (const char *p = mention->at; p + 4 < end; ++p) {
        if (text_is_blank(p[4]) && strncasecmp(p, ".mtl", 4) == 0) return true;
    }
    return false;
}

/* Reads a statement's text: as one name, which may contain blanks, or as several names separated by
 * blanks. */
static fathom_status read_mention(obj_reader *r, mtl_library *library, library_names *names,
                                  const obj_mention *mention) {
    bool found = false;
    fathom_status status = FATHOM_OK;
    if (!mention->length) {
        notes_add_at(&r->notes, 1, &r->file, mention->at, true, "mtllib: expected the name of a file");
        return FATHOM_OK;
    }
    if (!names_several(mention)) status = read_name(r, library, names, mention->at, mention->length, &found);
    if (found || (status != FATHOM_OK && status != FATHOM_BAD_INPUT)) return status;
    const char *end = mention->at + mention->length;
    for (const char *p = mention->at; p < end;) {
        const char *word = p;
        while (p < end && !text_is_blank(*p)) ++p;
        status = read_word(r, library, names, word, (size_t)(p - word));
        if (status != FATHOM_OK) return status;
        while (p < end && text_is_blank(*p)) ++p;
    }
    return FATHOM_OK;
}

bool obj_same_mention(const obj_mention *a, const obj_mention *b) {
    return a->length == b->length && memcmp(a->at, b->at, a->length) == 0;
}

static fathom_status read_mentions(obj_reader *r, mtl_library *library, library_names *names) {
    const obj_mention *last = NULL;
    for (size_t i = 0; i < r->piece_count; ++i) {
        for (size_t k = 0; k < r->pieces[i].libraries.count; ++k) {
            const obj_mention *mention = &r->pieces[i].libraries.items[k];
            if (last && obj_same_mention(last, mention)) continue;
            fathom_status status = read_mention(r, library, names, mention);
            if (status != FATHOM_OK) return status;
            last = mention;
        }
    }
    return FATHOM_OK;
}

static int shown(size_t length) { return length < 200 ? (int)length : 200; }

/* "models/bunny.obj" -> bunny.mtl, if no library was read and there is such a file. Some programs write no
 * mtllib statement, and people rename both files. *found: whether there is such a file. */
static fathom_status read_namesake(obj_reader *r, mtl_library *library, library_names *names, bool *found) {
    const char *file = file_name(r->file.path), *dot = strrchr(file, '.');
    char name[256];
    *found = false;
    if (!r->names.entries.count || names->seen.entries.count) return FATHOM_OK;
    const int length =
        snprintf(name, sizeof name, "%.*s.mtl", dot ? (int)(dot - file) : (int)strlen(file), file);
    if (length >= (int)sizeof name) return FATHOM_OK;
    char *path;
    fathom_status status = find_library(r, name, (size_t)length, &path);
    if (status == FATHOM_BAD_INPUT) return FATHOM_OK; /* it must not be read */
    if (status != FATHOM_OK || !path) return status;
    *found = true;
    notes_add(&r->notes, 1, "", "no mtllib statement names a file that can be read; %.200s is read instead",
              name);
    status = mtl_read(r->scene->context, path, library);
    free(path);
    return status;
}

static fathom_status read_libraries(obj_reader *r, mtl_library *library) {
    library_names names = {0};
    bool instead = false;
    fathom_status status = read_mentions(r, library, &names);
    if (status == FATHOM_OK) status = read_namesake(r, library, &names, &instead);
    if (status == FATHOM_OK && !instead) {
        notes_add_at(&r->notes, names.absent.count, &r->file, names.absent.first, false,
                     "mtllib: there is no file \"%.*s\"; materials named from it get the default",
                     shown(names.absent_length), names.absent.first);
        notes_add_at(&r->notes, names.refused.count, &r->file, names.refused.first, false,
                     "mtllib: %s; materials named from it get the default", names.why);
        notes_add(&r->notes, missed_most(&names), "",
                  "%d names of libraries have no file that can be read; no further name was looked for",
                  LIBRARIES_MISSED_MOST);
    }
    names_free(&names.seen);
    names_free(&names.missed);
    return status;
}

static bool push_slot(obj_reader *r, fathom_id material, uint32_t same_as, bool hidden) {
    obj_slot slot = {material, same_as, hidden};
    return array_push(&r->slots, slot);
}

/* Names without a material use slot 0, like faces that name none. */
static fathom_status fill_slots(obj_reader *r, const mtl_library *library) {
    size_t missing = 0, lost = 0;
    const name_entry *first = NULL;
    for (size_t i = 0; i < r->names.entries.count; ++i) {
        const name_entry *name = r->names.entries.items[i];
        uint32_t found = names_find(&library->names, name->text, name->length);
        fathom_id material = r->slots.items[0].material;
        bool hidden = false;
        if (found != UINT32_MAX) {
            const mtl_material *from = &library->materials.items[found];
            fathom_material value = from->value;
            fathom_status status = mtl_open_images(r->scene, from, &lost, &value);
            if (status == FATHOM_OK)
                status = fathom_scene_add_material(r->scene, from->name, &value, &material);
            hidden = from->hidden;
            if (status != FATHOM_OK)
                return fail_within(r->scene->context, status, &(fathom_place){.file = r->file.path});
        } else if (!missing++) {
            first = name;
        }
        if (!push_slot(r, material, found == UINT32_MAX ? 0 : (uint32_t)i + 1, hidden)) {
            return fail_memory(r->scene->context, sizeof(obj_slot));
        }
    }
    if (lost > MTL_LOST_IMAGES)
        notes_add(&r->notes, lost - MTL_LOST_IMAGES, "",
                  "images beyond the first %d that may not be read or do not exist are left out",
                  MTL_LOST_IMAGES);
    if (missing)
        notes_add_at(&r->notes, missing, &r->file, first->text, false,
                     "usemtl: no material \"%.*s\" is defined; it gets the default", shown(first->length),
                     first->text);
    return FATHOM_OK;
}

fathom_status obj_find_materials(obj_reader *r) {
    fathom_id given = r->options.material;
    if (!push_slot(r, given == FATHOM_NONE ? 0 : given, 0, false)) {
        return fail_memory(r->scene->context, sizeof(obj_slot));
    }
    if (given != FATHOM_NONE) {
        for (size_t i = 0; i < r->names.entries.count; ++i) {
            if (!push_slot(r, given, 0, false)) return fail_memory(r->scene->context, sizeof(obj_slot));
        }
        return FATHOM_OK;
    }
    mtl_library library = {0};
    fathom_status status = read_libraries(r, &library);
    if (status == FATHOM_OK) status = fill_slots(r, &library);
    mtl_free(&library);
    return status;
}
