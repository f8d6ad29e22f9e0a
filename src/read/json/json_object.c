#include "read/json/json_scene.h"

#include "read/read.h"
#include "scene/graph.h"
#include "scene/light_groups.h"

#include <stdlib.h>
#include <string.h>

/* ---- objects ---- */

/* An object from the file, with the ids of the names that it uses. */
typedef struct object {
    form_object_id kind;
    form_object_values values;
    fathom_id material; /* FATHOM_NONE: not given */
    unsigned flags;
    bool placed; /* it has a transform or a motion */
    affine_f64 map;
} object;

/* Children are read by recursion. Functions that do not recurse are not inlined, so that their variables take
 * no space in the recursive stack frames. */
#define LEAF static __attribute__((noinline))

static fathom_status find_id(const object_reader *r, const where *at, const char *key, const char *what,
                             const char *name, json_t *ids, fathom_id *out) {
    json_t *id = json_object_get(ids, name);
    const where named = {at, key, 0};
    if (!id) return doc_unknown_name(r->doc, &named, what, name, ids);
    *out = (fathom_id)json_integer_value(id);
    return FATHOM_OK;
}

LEAF fathom_status read_object(const object_reader *r, const where *at, json_t *value, object *out) {
    const form *f;
    memset(out, 0, sizeof *out);
    fathom_status status = doc_choose(r->doc, at, value, &form_object, &f);
    if (status != FATHOM_OK) return status;
    out->kind = (form_object_id)f->id;
    out->material = FATHOM_NONE;
    out->values.casts_shadow = true;
    status = doc_read(r->doc, at, value, f, &out->values);
    if (status != FATHOM_OK) return status;
    if (!out->values.casts_shadow) out->flags |= FATHOM_CASTS_NO_SHADOW;
    if (out->values.material)
        status = find_id(r, at, "material", "material", out->values.material, r->materials, &out->material);
    if (status != FATHOM_OK) return status;
    status = place_object(r->doc, at, value, &out->values.place, &out->map, &out->placed);
    out->placed |= out->values.motion != NULL;
    return status;
}

/* ---- kinds of objects ---- */

LEAF fathom_status add_sphere(const object_reader *r, const object *o, fathom_id group, fathom_id material) {
    fathom_sphere sphere = o->values.as.sphere;
    sphere.material = material;
    sphere.flags = o->flags;
    return fathom_scene_add_sphere(r->scene, group, &sphere, NULL);
}

LEAF fathom_status add_quad(const object_reader *r, json_t *value, const object *o, fathom_id group,
                            fathom_id material) {
    fathom_quad quad;
    fathom_quad_from_axes(o->values.as.quad.center, o->values.as.quad.u, o->values.as.quad.v, &quad);
    if (doc_has(value, "corners")) memcpy(quad.corners, o->values.as.quad.corners, sizeof quad.corners);
    quad.material = material;
    quad.flags = o->flags;
    return fathom_scene_add_quad(r->scene, group, &quad, NULL);
}

LEAF fathom_status add_plane(const object_reader *r, const object *o, fathom_id group, fathom_id material) {
    fathom_plane plane = o->values.as.plane;
    plane.material = material;
    plane.flags = o->flags;
    return fathom_scene_add_plane(r->scene, group, &plane, NULL);
}

/* A mesh casts no shadow because of its file's material, which instances may replace. */
#define CLEAR_IN_FILE (1u << 31)

LEAF fathom_status add_file(const object_reader *r, const where *at, const object *o, fathom_id group) {
    const where file = {at, "file", 0};
    const char *name = o->values.as.mesh.file;
    char *path;
    if (!*name) return doc_fail(r->doc, &file, "expected the name of a file, found \"\"");
    fathom_status status = read_beside(r->scene, r->doc->path, name, &path);
    if (status != FATHOM_OK) return doc_within(r->doc, &file, status);
    const read_mesh_options options = {.material = o->material,
                                       .flags = o->flags,
                                       .flat = o->values.as.mesh.shading == FORM_FLAT,
                                       .smooth = o->values.as.mesh.shading == FORM_SMOOTH};
    const size_t first = r->scene->meshes.count;
    status = read_mesh(r->scene, group, path, &options);
    for (size_t i = first; i < r->scene->meshes.count; ++i) {
        unsigned *flags = &r->scene->meshes.items[i].flags;
        if (*flags & ~o->flags & FATHOM_CASTS_NO_SHADOW) *flags |= CLEAR_IN_FILE;
    }
    free(path);
    return status == FATHOM_OK ? status : doc_within(r->doc, &file, status);
}

/* Sets the flags of all objects from `first` on. */
static void set_flags(fathom_scene *scene, size_t first, unsigned flags) {
    for (size_t i = first; i < scene->objects.count; ++i) {
        scene_object o = scene->objects.items[i];
        switch (o.kind) {
        case SCENE_SPHERE: scene->spheres.items[o.index].flags |= flags; break;
        case SCENE_QUAD: scene->quads.items[o.index].flags |= flags; break;
        case SCENE_PLANE: scene->planes.items[o.index].flags |= flags; break;
        case SCENE_MESH: scene->meshes.items[o.index].flags |= flags; break;
        }
    }
}

LEAF fathom_status add_generated(const object_reader *r, const object *o, fathom_id group,
                                 fathom_id material) {
    fathom_generate_options options;
    fathom_generate_options_default(&options);
    options.kind = (fathom_generator)o->values.as.generate.kind;
    options.triangles = o->values.as.generate.triangles;
    options.seed = o->values.as.generate.seed;
    options.material = material;
    size_t first = r->scene->objects.count;
    fathom_status status = fathom_scene_generate(r->scene, group, &options);
    set_flags(r->scene, first, o->flags);
    /* The fault is in the file, not in a call of the library. */
    return status == FATHOM_BAD_USAGE ? FATHOM_BAD_INPUT : status;
}

/* Each level of nesting is read by recursion, and takes about 1.2 kB of stack: 0.6 MB in all, of a stack that
 * may have only 1 MB. */
#define NESTING_MAX 512

static unsigned nesting(const where *at) {
    unsigned levels = 0;
    for (; at; at = at->parent) levels += at->key && strcmp(at->key, "children") == 0;
    return levels;
}

static fathom_status add_children(const object_reader *r, const where *at, const object *o, fathom_id group) {
    const where children = {at, "children", 0};
    if (nesting(&children) > NESTING_MAX)
        return doc_fail(r->doc, &children,
                        "children are nested more than %d levels deep; move inner ones to \"groups\", and "
                        "place them by instances",
                        NESTING_MAX);
    return object_list(r, &children, o->values.as.group.children, group);
}

/* Adds the object's content to the group. Adds the place to messages of the scene's own checks; other
 * messages have it already. */
static fathom_status add_content(const object_reader *r, const where *at, json_t *value, const object *o,
                                 fathom_id group, mesh_batch *batch) {
    fathom_id material = o->material == FATHOM_NONE ? 0 : o->material;
    fathom_status status = FATHOM_OK;
    switch (o->kind) {
    case FORM_SPHERE: status = add_sphere(r, o, group, material); break;
    case FORM_QUAD: status = add_quad(r, value, o, group, material); break;
    case FORM_PLANE: status = add_plane(r, o, group, material); break;
    case FORM_GENERATE: status = add_generated(r, o, group, material); break;
    case FORM_TRIANGLE:
        status = mesh_batch_add(r, value, &o->values, group, material, o->flags, batch);
        break;
    case FORM_MESH:
        if (o->values.as.mesh.file) return add_file(r, at, o, group);
        return mesh_inline(r, at, &o->values, group, material, o->flags);
    case FORM_GROUP: return add_children(r, at, o, group);
    case FORM_INSTANCE: return FATHOM_OK;
    }
    return status == FATHOM_OK ? status : doc_within(r->doc, at, status);
}

/* ---- transforms ---- */

/* The group that receives the object's content. A shape with a transform, and a group, get a new one. */
LEAF fathom_status choose_group(const object_reader *r, const where *at, const object *o, fathom_id parent,
                                fathom_id *out) {
    *out = parent;
    if (o->kind == FORM_INSTANCE)
        return find_id(r, at, "of", "group", o->values.as.instance.of, r->groups, out);
    if (o->kind != FORM_GROUP && !o->placed) return FATHOM_OK;
    return fathom_scene_add_group(r->scene, o->values.name, out);
}

static fathom_status read_place_key(const object_reader *r, const where *at, json_t *value, double *time,
                                    affine_f64 *map) {
    form_object_values values = {.name = NULL};
    bool placed;
    fathom_status status = doc_read(r->doc, at, value, &form_place_key, &values);
    *time = values.place.time;
    return status == FATHOM_OK ? place_object(r->doc, at, value, &values.place, map, &placed) : status;
}

/* The angle about the axis of `to` in degrees between two keys that give it; else 0. */
static double turn_between(json_t *from, json_t *to) {
    json_t *a = json_object_get(from, "rotate"), *b = json_object_get(to, "rotate");
    if (!a || !b) return 0;
    double axes[2][3];
    for (int i = 0; i < 3; ++i) {
        axes[0][i] = json_number_value(json_array_get(json_object_get(a, "axis"), (size_t)i));
        axes[1][i] = json_number_value(json_array_get(json_object_get(b, "axis"), (size_t)i));
    }
    const double along = dot_f64(normalize_f64(load_f64(axes[0])), normalize_f64(load_f64(axes[1])));
    if (fabs(along) < 1 - 1e-9) return 0;
    return json_number_value(json_object_get(b, "angle")) -
           copysign(1, along) * json_number_value(json_object_get(a, "angle"));
}

/* Whoever writes 0 and 360 degrees means a spin, and gets none. Once for each object. */
static void warn_of_spin(const object_reader *r, const where *at, json_t *keys) {
    const where motion = {at, "motion", 0};
    for (size_t k = 1; k < json_array_size(keys); ++k) {
        const where key = {&motion, NULL, k}, turn = {&key, "rotate", 0};
        const double angle = turn_between(json_array_get(keys, k - 1), json_array_get(keys, k));
        if (!(fabs(angle) >= 180 - 1e-9)) continue;
        doc_warn(r->doc, &turn,
                 "%.6g degrees from the key before, but motion takes the shorter way, here %.6g%s; give keys "
                 "less than half a turn apart, such as 0, 120, 240 and 360 degrees",
                 angle, remainder(angle, 360),
                 fabs(fabs(remainder(angle, 360)) - 180) < 1e-9 ? " either way" : "");
        return;
    }
}

LEAF fathom_status add_instance(const object_reader *r, const where *at, const object *o, fathom_id parent,
                                fathom_id group) {
    fathom_instance instance;
    fathom_instance_default(&instance);
    instance.group = group;
    instance.parent = parent;
    memcpy(instance.transform, o->map.m, sizeof instance.transform);
    if (o->kind == FORM_GROUP || o->kind == FORM_INSTANCE) instance.material = o->material;
    if (o->kind == FORM_INSTANCE) instance.name = o->values.name;
    double *keys = NULL;
    fathom_id id = 0;
    fathom_status status = FATHOM_OK;
    if (o->values.motion) {
        status = place_motion(r, at, o->values.motion, read_place_key, &instance.key_count, &keys);
        instance.key_times = keys, instance.key_transforms = keys ? keys + instance.key_count : NULL;
    }
    if (status == FATHOM_OK) {
        status = fathom_scene_add_instance(r->scene, &instance, &id);
        if (status != FATHOM_OK) status = place_within(r, at, "motion", status);
    }
    free(keys);
    if (status == FATHOM_OK && instance.key_count > 1) {
        warn_of_spin(r, at, o->values.motion);
        status = place_origin(r, at, SCENE_PART_MOVED, id);
    }
    return status;
}

static fathom_status add_object(const object_reader *r, const where *at, json_t *value, fathom_id parent,
                                mesh_batch *batch) {
    object o;
    fathom_id group = parent;
    fathom_status status = read_object(r, at, value, &o);
    if (status == FATHOM_OK) status = choose_group(r, at, &o, parent, &group);
    bool instanced = o.kind == FORM_GROUP || o.kind == FORM_INSTANCE || o.placed;
    if (status == FATHOM_OK && instanced) status = add_instance(r, at, &o, parent, group);
    if (status == FATHOM_OK && o.kind != FORM_TRIANGLE) status = mesh_batch_flush(r, batch);
    const size_t first = r->scene->objects.count;
    if (status == FATHOM_OK) status = add_content(r, at, value, &o, group, batch);
    if (status != FATHOM_OK) return status;
    if (o.kind == FORM_TRIANGLE) {
        /* Its mesh is added later; one added now is that of the triangles before it. */
        const where named = {at, "group", 0};
        uint8_t found;
        if (!o.values.light_group) return FATHOM_OK;
        status = light_group_find(r->scene, o.values.light_group, &found);
        return status == FATHOM_OK ? status : doc_within(r->doc, &named, status);
    }
    for (size_t i = first; o.kind != FORM_GROUP && o.values.name && i < r->scene->objects.count; ++i) {
        status = fathom_scene_name_object(r->scene, (fathom_id)i, o.values.name);
        if (status != FATHOM_OK) return status;
    }
    return light_group_set(r, at, "group", FATHOM_SOURCE_OBJECT, first, r->scene->objects.count,
                           o.values.light_group);
}

fathom_status object_list(const object_reader *r, const where *at, json_t *list, fathom_id group) {
    if (!json_is_array(list)) return doc_expected(r->doc, at, list, "an array");
    mesh_batch batch = {.group = group};
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < json_array_size(list) && status == FATHOM_OK; ++i) {
        const where item = {at, NULL, i};
        status = add_object(r, &item, json_array_get(list, i), group, &batch);
    }
    if (status == FATHOM_OK) status = mesh_batch_flush(r, &batch);
    mesh_batch_free(&batch);
    return status;
}

/* How a group is placed: with its own materials, or all replaced by one that is clear or solid. The outermost
 * instance that has a material decides. */
enum { OWN = 1, CLEAR = 2, SOLID = 4 };

static void find_ways(const fathom_scene *scene, const scene_graph *graph, uint8_t *ways) {
    ways[FATHOM_ROOT] = OWN;
    for (uint32_t k = 0; k < graph->order_count; ++k) {
        const uint32_t g = graph->order[k];
        for (uint32_t i = graph->instances.first[g]; i < graph->instances.first[g + 1]; ++i) {
            const fathom_instance *instance = &scene->instances.items[graph->instances.items[i]];
            const scene_named_material *all = scene->materials.items;
            unsigned own = OWN;
            if (instance->material != FATHOM_NONE)
                own = material_is_clear(&all[instance->material], scene->settings.integrator) ? CLEAR : SOLID;
            ways[instance->group] |= (uint8_t)((ways[g] & (CLEAR | SOLID)) | (ways[g] & OWN ? own : 0));
        }
    }
}

/* Returns whether a solid placement casts no shadow, because others of the mesh are clear. */
static bool cast(const fathom_scene *scene, const scene_object *o, unsigned ways) {
    unsigned *flags = o->kind == SCENE_MESH ? &scene->meshes.items[o->index].flags : NULL;
    if (!flags || !(*flags & CLEAR_IN_FILE)) return false;
    *flags &= ~(CLEAR_IN_FILE | (ways == SOLID ? FATHOM_CASTS_NO_SHADOW : 0u));
    return ways != SOLID && ways & SOLID;
}

fathom_status objects_cast(const object_reader *r) {
    fathom_scene *scene = r->scene;
    scene_graph graph;
    size_t lost = 0, clear = 0;
    for (size_t i = 0; i < scene->meshes.count; ++i) clear += scene->meshes.items[i].flags >= CLEAR_IN_FILE;
    if (!clear) return FATHOM_OK;
    fathom_status status = graph_create(scene, &graph);
    if (status != FATHOM_OK) return status;
    uint8_t *ways = calloc(scene->groups.count, sizeof *ways);
    if (ways) find_ways(scene, &graph, ways);
    for (size_t i = 0; ways && i < scene->objects.count; ++i)
        lost += cast(scene, &scene->objects.items[i], ways[scene->objects.items[i].group]);
    if (!ways) status = fail_memory(scene->context, scene->groups.count);
    if (lost)
        warn(scene->context,
             "%s: a mesh that is clear in its file casts no shadow even where an instance makes it solid, "
             "because others leave it clear (%zu such)",
             r->doc->path, lost);
    free(ways);
    graph_destroy(&graph);
    return status;
}
