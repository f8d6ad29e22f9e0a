#include "read/obj/mtl.h"
#include "read/obj/obj.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The file that a mention of `length` bytes means, beside the OBJ file; NULL when there is none. Names
 * written on Windows may have backslashes for slashes. `memory` is set when there was not enough. */
static char *find_library(const obj_reader *r, const char *name, size_t length, bool *memory) {
    char *copy = strndup(name, length);
    char *path = copy ? file_beside(r->file.path, copy) : NULL;
    *memory = path != NULL;
    bool found = path && access(path, F_OK) == 0;
    if (path && !found && strchr(copy, '\\')) {
        for (char *c = copy; (c = strchr(c, '\\')) != NULL;) *c = '/';
        free(path);
        path = file_beside(r->file.path, copy);
        *memory = path != NULL;
        found = path && access(path, F_OK) == 0;
    }
    free(copy);
    if (found) return path;
    free(path);
    return NULL;
}

static fathom_status read_library(obj_reader *r, mtl_library *library, char *path) {
    fathom_status status = mtl_read(r->scene->context, path, library);
    free(path);
    return status;
}

/* One name, which may hold blanks; or several, set apart by blanks. */
static fathom_status read_mention(obj_reader *r, mtl_library *library, const obj_mention *mention) {
    fathom_context *context = r->scene->context;
    bool memory;
    char *path = find_library(r, mention->at, mention->length, &memory);
    if (!memory) return fail_memory(context, mention->length);
    if (path) return read_library(r, library, path);
    const char *end = mention->at + mention->length;
    for (const char *p = mention->at; p < end;) {
        const char *word = p;
        while (p < end && !text_is_blank(*p)) ++p;
        path = find_library(r, word, (size_t)(p - word), &memory);
        if (!memory) return fail_memory(context, mention->length);
        if (path) {
            fathom_status status = read_library(r, library, path);
            if (status != FATHOM_OK) return status;
        } else {
            warn(context,
                 "%s:%zu: mtllib: there is no file \"%.*s\"; materials named from it get the default",
                 r->file.path, text_line(&r->file, mention->at), (int)(p - word), word);
        }
        while (p < end && text_is_blank(*p)) ++p;
    }
    return FATHOM_OK;
}

static bool same_mention(const obj_mention *a, const obj_mention *b) {
    return a->length == b->length && memcmp(a->at, b->at, a->length) == 0;
}

/* Exporters that repeat the statement for each object repeat it as it is. */
static fathom_status read_libraries(obj_reader *r, mtl_library *library) {
    const obj_mention *last = NULL;
    for (size_t i = 0; i < r->piece_count; ++i) {
        for (size_t k = 0; k < r->pieces[i].libraries.count; ++k) {
            const obj_mention *mention = &r->pieces[i].libraries.items[k];
            if (last && same_mention(last, mention)) continue;
            fathom_status status = read_mention(r, library, mention);
            if (status != FATHOM_OK) return status;
            last = mention;
        }
    }
    return FATHOM_OK;
}

static bool push_slot(obj_reader *r, fathom_id material, uint32_t same_as) {
    obj_slot slot = {material, same_as};
    return array_push(&r->slots, slot);
}

/* Names without a material share slot 0 with faces that name none. */
static fathom_status fill_slots(obj_reader *r, const mtl_library *library) {
    size_t missing = 0;
    const name_entry *first = NULL;
    for (size_t i = 0; i < r->names.entries.count; ++i) {
        const name_entry *name = &r->names.entries.items[i];
        uint32_t found = names_find(&library->names, name->text, name->length);
        fathom_id material = r->slots.items[0].material;
        if (found != UINT32_MAX) {
            const mtl_material *from = &library->materials.items[found];
            fathom_status status = fathom_scene_add_material(r->scene, from->name, &from->value, &material);
            if (status != FATHOM_OK) return fail_within(r->scene->context, status, "%s: ", r->file.path);
        } else if (!missing++) {
            first = name;
        }
        if (!push_slot(r, material, found == UINT32_MAX ? 0 : (uint32_t)i + 1)) {
            return fail_memory(r->scene->context, sizeof(obj_slot));
        }
    }
    if (missing) {
        warn(r->scene->context,
             "%s:%zu: usemtl: no material \"%.*s\" is defined; it gets the default (%zu such %s)",
             r->file.path, text_line(&r->file, first->text), (int)first->length, first->text, missing,
             missing == 1 ? "name" : "names");
    }
    return FATHOM_OK;
}

fathom_status obj_find_materials(obj_reader *r) {
    fathom_id given = r->options.material;
    if (!push_slot(r, given == FATHOM_NONE ? 0 : given, 0)) {
        return fail_memory(r->scene->context, sizeof(obj_slot));
    }
    if (given != FATHOM_NONE) {
        for (size_t i = 0; i < r->names.entries.count; ++i) {
            if (!push_slot(r, given, 0)) return fail_memory(r->scene->context, sizeof(obj_slot));
        }
        return FATHOM_OK;
    }
    mtl_library library = {0};
    fathom_status status = read_libraries(r, &library);
    if (status == FATHOM_OK) status = fill_slots(r, &library);
    mtl_free(&library);
    return status;
}
