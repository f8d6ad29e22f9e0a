#include "read/obj/obj.h"

#include "base/threads.h"
#include "read/mesh/strokes.h"
#include "read/read.h"
#include "scene/mesh/absent.h"
#include "scene/mesh/mesh_array.h"

#include <stdlib.h>
#include <string.h>

/* A mesh of all triangles of one material, and of one object if objects are apart, with the same kinds of
 * data. */
typedef struct obj_mesh {
    uint32_t slot, object;
    bool has[OBJ_KINDS], same[OBJ_KINDS];
    size_t count;
    uint32_t *indices[OBJ_KINDS];
    fathom_mesh mesh;
    bool copied; /* it has its own arrays; otherwise it uses those of the file */
} obj_mesh;

typedef struct obj_builder {
    obj_reader *r;
    ARRAY(obj_mesh) meshes; /* in order of appearance */
    uint32_t *mesh_of;      /* slot × has uvs × has normals -> the last such mesh + 1 */
    bool apart;             /* each object gets its own meshes */
} obj_builder;

/* More meshes than this cost more time than the names are worth. */
#define OBJECTS_MOST 4096

/* True if no two objects use vertices of the same part of the file, as in files whose objects were separate
 * ones. Else they may be parts of one surface, and keep its vertices in one mesh. */
static bool are_apart(const obj_reader *r) {
    uint32_t object = 0, before = 0, most = 0;
    if (r->objects.count < 2) return true;
    if (r->objects.count > OBJECTS_MOST) return false;
    for (size_t i = 0; i < r->piece_count; ++i) {
        const obj_piece *piece = &r->pieces[i];
        for (size_t k = 0; k < piece->runs.count; ++k) {
            const obj_run *run = &piece->runs.items[k];
            const uint32_t *index = piece->corners[OBJ_POSITION].items + 3 * run->first;
            uint32_t least = UINT32_MAX;
            if (run->object != object) object = run->object, before = most;
            for (size_t c = 0; c < 3 * run->count; ++c) {
                least = index[c] < least ? index[c] : least;
                most = index[c] >= most ? index[c] + 1 : most;
            }
            if (least < before) return false;
        }
    }
    return true;
}

static uint32_t *mesh_slot(const obj_builder *b, const obj_run *run) {
    uint32_t slot = b->r->slots.items[run->slot].same_as;
    return &b->mesh_of[4 * (size_t)slot + 2 * run->has[OBJ_UV] + run->has[OBJ_NORMAL]];
}

static bool place_run(obj_builder *b, obj_run *run) {
    uint32_t *number = mesh_slot(b, run);
    if (!*number || (b->apart && b->meshes.items[*number - 1].object != run->object)) {
        obj_mesh mesh = {.slot = run->slot, .object = run->object, .same = {true, true, true}};
        memcpy(mesh.has, run->has, sizeof mesh.has);
        if (!array_push(&b->meshes, mesh)) return false;
        *number = (uint32_t)b->meshes.count;
    }
    run->mesh = *number - 1;
    obj_mesh *mesh = &b->meshes.items[run->mesh];
    run->target = mesh->count;
    mesh->count += run->count;
    for (int k = OBJ_UV; k < OBJ_KINDS; ++k) mesh->same[k] = mesh->same[k] && run->same[k];
    return true;
}

static fathom_status place_runs(obj_builder *b) {
    obj_reader *r = b->r;
    b->apart = are_apart(r);
    b->mesh_of = calloc(4 * r->slots.count, sizeof *b->mesh_of);
    if (!b->mesh_of) return fail_memory(r->scene->context, 4 * r->slots.count * sizeof *b->mesh_of);
    for (size_t i = 0; i < r->piece_count; ++i) {
        for (size_t k = 0; k < r->pieces[i].runs.count; ++k) {
            obj_run *run = &r->pieces[i].runs.items[k];
            if (run->count && !place_run(b, run)) return fail_memory(r->scene->context, sizeof(obj_mesh));
        }
    }
    return FATHOM_OK;
}

/* Index arrays equal to those of the positions are not allocated. */
static fathom_status allocate_meshes(obj_builder *b) {
    for (size_t i = 0; i < b->meshes.count; ++i) {
        obj_mesh *mesh = &b->meshes.items[i];
        if (mesh->count >= UINT32_MAX)
            return fail_file(b->r->scene->context, FATHOM_BAD_INPUT, b->r->file.path,
                             "%zu triangles of one material; at most 2^32 - 2 fit into a mesh", mesh->count);
        for (int k = 0; k < OBJ_KINDS; ++k) {
            if (k != OBJ_POSITION && (!mesh->has[k] || mesh->same[k])) continue;
            void *memory;
            fathom_status status =
                scene_allocate_items(b->r->scene, mesh->count, 3 * sizeof(uint32_t), &memory);
            if (status != FATHOM_OK) return status;
            mesh->indices[k] = memory;
        }
    }
    return FATHOM_OK;
}

static void copy_pieces(void *user, size_t begin, size_t end) {
    const obj_builder *b = user;
    for (size_t i = begin; i < end; ++i) {
        obj_piece *piece = &b->r->pieces[i];
        for (size_t k = 0; k < piece->runs.count; ++k) {
            const obj_run *run = &piece->runs.items[k];
            if (!run->count) continue;
            const obj_mesh *mesh = &b->meshes.items[run->mesh];
            for (int kind = 0; kind < OBJ_KINDS; ++kind) {
                if (!mesh->indices[kind]) continue;
                int from = piece->corners[kind].count ? kind : OBJ_POSITION;
                memcpy(mesh->indices[kind] + 3 * run->target, piece->corners[from].items + 3 * run->first,
                       3 * run->count * sizeof(uint32_t));
            }
        }
        for (int kind = 0; kind < OBJ_KINDS; ++kind) {
            array_free(&piece->corners[kind]);
            piece->corners[kind].items = NULL;
        }
    }
}

static fathom_status adopt_values(obj_builder *b) {
    for (int k = 0; k < OBJ_KINDS; ++k) {
        bool used = false;
        for (size_t i = 0; i < b->meshes.count; ++i) {
            const obj_mesh *mesh = &b->meshes.items[i];
            used |= !mesh->copied && (k == OBJ_POSITION || mesh->has[k]);
        }
        if (!used) continue;
        b->r->adopted[k] = true;
        fathom_status status = scene_adopt(b->r->scene, b->r->values[k], free);
        if (status != FATHOM_OK) return status;
    }
    return FATHOM_OK;
}

/* The indices of uvs or normals; NULL if they equal the positions' and every vertex has a value. */
static const uint32_t *shared_indices(const obj_builder *b, const obj_mesh *mesh, int kind) {
    if (mesh->indices[kind]) return mesh->indices[kind];
    return b->r->total[kind] < b->r->total[OBJ_POSITION] ? mesh->indices[OBJ_POSITION] : NULL;
}

fathom_status obj_add_mesh(obj_reader *r, uint32_t slot, fathom_mesh *mesh, mesh_facts facts) {
    store_f64(mesh->origin, r->origin);
    mesh->material = r->slots.items[slot].material;
    mesh->flags = r->options.flags;
    if (r->colors && !mesh->material) mesh->material = r->colored;
    if (absent_material(&r->scene->materials.items[mesh->material].classic))
        mesh->flags |= FATHOM_CASTS_NO_SHADOW;
    return read_add_mesh(r->scene, r->group, r->file.path, mesh, facts, &r->notes);
}

/* True if an image of the file's own material shows the colours. In Fathom's own files both count. */
static bool has_image(const obj_reader *r, uint32_t slot) {
    static const char own[] = "# Fathom ";
    const size_t length = sizeof own - 1, size = (size_t)(r->file.end - r->file.begin);
    const fathom_id material = r->slots.items[slot].material;
    return r->options.material == FATHOM_NONE &&
           !(size > length && memcmp(r->file.begin, own, length) == 0) &&
           r->scene->materials.items[material].value.maps[FATHOM_MAP_COLOR].texture != FATHOM_NONE;
}

/* Makes a mesh that uses the arrays of the whole file. */
static void make_mesh(const obj_builder *b, obj_mesh *from) {
    obj_reader *r = b->r;
    fathom_mesh *mesh = &from->mesh;
    fathom_mesh_default(mesh);
    mesh->positions = r->values[OBJ_POSITION];
    mesh->vertex_count = (uint32_t)r->total[OBJ_POSITION];
    mesh->indices = from->indices[OBJ_POSITION];
    mesh->triangle_count = (uint32_t)from->count;
    if (from->has[OBJ_UV]) {
        mesh->uvs = r->values[OBJ_UV];
        mesh->uv_count = (uint32_t)r->total[OBJ_UV];
        mesh->uv_indices = shared_indices(b, from, OBJ_UV);
    }
    if (from->has[OBJ_NORMAL]) {
        mesh->normals = r->values[OBJ_NORMAL];
        mesh->normal_count = (uint32_t)r->total[OBJ_NORMAL];
        mesh->normal_indices = shared_indices(b, from, OBJ_NORMAL);
    }
    const bool twice = r->colors && mesh->uvs && has_image(r, from->slot);
    notes_add(&r->notes, twice, "", READ_COLORS_TWICE);
    mesh->colors = twice ? NULL : r->colors;
    mesh_array_pack(mesh);
}

static fathom_status look_at_vertices(const obj_reader *r, const fathom_mesh *mesh, mesh_facts *facts) {
    return mesh_look_at_vertices(r->scene->context, r->file.path, mesh->positions, mesh->position_stride,
                                 mesh->vertex_count, facts);
}

/* Names the mesh that was added last. The only object of a file has the names of the instances that place it.
 */
static fathom_status name_mesh(const obj_builder *b, const obj_mesh *mesh) {
    fathom_scene *scene = b->r->scene;
    const obj_mention *object = mesh->object ? &b->r->objects.items[mesh->object - 1] : NULL;
    const bool whole = b->r->objects.count < 2 && b->r->group != FATHOM_ROOT;
    if (!b->apart || whole || !object || !object->length) return FATHOM_OK;
    char *name = strndup(object->at, object->length);
    if (!name) return fail_memory(scene->context, object->length);
    const fathom_status status = fathom_scene_name_object(scene, (fathom_id)(scene->objects.count - 1), name);
    free(name);
    return status;
}

/* facts: of the vertices of all meshes that are not copied. */
static fathom_status add_all(obj_builder *b, const mesh_facts *facts) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < b->meshes.count && status == FATHOM_OK; ++i) {
        obj_mesh *mesh = &b->meshes.items[i];
        mesh_facts own = *facts;
        if (mesh->copied) status = look_at_vertices(b->r, &mesh->mesh, &own);
        if (status == FATHOM_OK) status = obj_add_mesh(b->r, mesh->slot, &mesh->mesh, own);
        if (status == FATHOM_OK) status = name_mesh(b, mesh);
    }
    return status;
}

static fathom_status add_meshes(obj_builder *b) {
    fathom_status status = place_runs(b);
    if (status == FATHOM_OK) status = allocate_meshes(b);
    if (status != FATHOM_OK) return status;
    loop_parallel(b->r->threads, b->r->piece_count, 1, copy_pieces, b);
    mesh_facts facts = {.largest = 0};
    for (size_t i = 0; i < b->meshes.count && status == FATHOM_OK; ++i) {
        obj_mesh *mesh = &b->meshes.items[i];
        make_mesh(b, mesh);
        if (!i) status = look_at_vertices(b->r, &mesh->mesh, &facts);
        if (status == FATHOM_OK) status = mesh_compact(b->r->scene, true, &facts, &mesh->mesh, &mesh->copied);
    }
    if (status == FATHOM_OK) status = adopt_values(b);
    return status == FATHOM_OK ? add_all(b, &facts) : status;
}

fathom_status obj_build(obj_reader *r) {
    obj_builder b = {.r = r};
    bool drawn = false;
    fathom_status status = r->colors ? read_colored_material(r->scene, &r->colored) : FATHOM_OK;
    if (status == FATHOM_OK) status = add_meshes(&b);
    if (status == FATHOM_OK) status = obj_add_strokes(r, &drawn);
    if (status == FATHOM_OK && !b.meshes.count && !drawn) {
        status =
            fail_file(r->scene->context, FATHOM_BAD_INPUT, r->file.path,
                      "it has no faces (%llu vertices); expected at least one f statement with 3 corners",
                      (unsigned long long)r->total[OBJ_POSITION]);
    }
    array_free(&b.meshes);
    free(b.mesh_of);
    return status;
}
