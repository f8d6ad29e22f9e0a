#include "read/json/json_scene.h"

#include "base/file.h"
#include "read/read.h"
#include "scene/light_groups.h"

#include <stdlib.h>
#include <string.h>

/* ---- frames and transforms ---- */

double place_radians(double degrees) { return degrees * 0.017453292519943295; }

/* Axes typed with three decimals are off by up to 5e-4 in each component, so by sqrt(3) 5e-4 each; the cosine
 * of two axes is off by twice that. */
static bool right_angle(vec3_f64 a, vec3_f64 b) {
    return fabs(dot_f64(normalize_f64(a), normalize_f64(b))) <= 1.8e-3;
}

fathom_status place_frame(const doc *d, const where *at, json_t *value, const form_frame_values *values,
                          frame_f64 *out) {
    vec3_f64 x = load_f64(values->x), y = load_f64(values->y), z = load_f64(values->z);
    bool has_y = doc_has(value, "y");
    *out = frame_from(load_f64(values->origin), z, has_y ? y : (vec3_f64){0, 1, 0});
    if (!doc_has(value, "x")) return FATHOM_OK;
    if (!right_angle(x, y) || !right_angle(y, z) || !right_angle(z, x))
        return doc_fail(d, at,
                        "x, y and z are not at right angles; leave x out to have it made from y and z");
    if (dot_f64(normalize_f64(x), out->x) < 0)
        return doc_fail(d, at, "x, y and z are left-handed; expected x along y cross z");
    return FATHOM_OK;
}

/* Column-major, as in glTF. */
static fathom_status load_matrix(const doc *d, const where *at, const double m[16], affine_f64 *out) {
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) out->m[row][column] = m[column * 4 + row];
    }
    if (m[3] == 0 && m[7] == 0 && m[11] == 0 && m[15] == 1) return FATHOM_OK;
    const where matrix = {at, "matrix", 0};
    return doc_fail(
        d, &matrix,
        "expected an affine map: numbers 4, 8, 12 and 16 are 0, 0, 0 and 1, found %.6g, %.6g, %.6g "
        "and %.6g; columns come first",
        m[3], m[7], m[11], m[15]);
}

static fathom_status load_turn(const doc *d, const where *at, json_t *object, const form_place_values *values,
                               affine_f64 *out) {
    if (doc_has(object, "rotation")) {
        *out = affine_rotation(values->rotation);
    } else if (doc_has(object, "rotate")) {
        *out = affine_rotation_axis(load_f64(values->rotate.axis), place_radians(values->rotate.angle));
    } else if (doc_has(object, "frame")) {
        const where inner = {at, "frame", 0};
        frame_f64 f;
        fathom_status status = place_frame(d, &inner, json_object_get(object, "frame"), &values->frame, &f);
        if (status != FATHOM_OK) return status;
        *out = (affine_f64){{{f.x.x, f.y.x, f.z.x, f.origin.x},
                             {f.x.y, f.y.y, f.z.y, f.origin.y},
                             {f.x.z, f.y.z, f.z.z, f.origin.z}}};
    }
    return FATHOM_OK;
}

/* The map of an object's placement keys; *placed is false when it has none. */
static fathom_status place_object(const doc *d, const where *at, json_t *object,
                                  const form_place_values *values, affine_f64 *out, bool *placed) {
    static const char *const keys[] = {"matrix", "frame", "translation", "rotation", "rotate", "scale"};
    *out = affine_identity();
    *placed = false;
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i) *placed = *placed || doc_has(object, keys[i]);
    if (!*placed) return FATHOM_OK;
    if (doc_has(object, "matrix")) return load_matrix(d, at, values->matrix, out);
    affine_f64 turn = affine_identity(), scaling = affine_identity(), shift = affine_identity();
    fathom_status status = load_turn(d, at, object, values, &turn);
    if (status != FATHOM_OK) return status;
    if (doc_has(object, "scale")) scaling = affine_scaling(load_f64(values->scale));
    if (doc_has(object, "translation")) shift = affine_translation(load_f64(values->translation));
    affine_f64 turned = affine_compose(&turn, &scaling);
    *out = affine_compose(&shift, &turned);
    return FATHOM_OK;
}

/* ---- objects ---- */

/* An object as read, with what it names looked up. */
typedef struct object {
    form_object_id kind;
    form_object_values values;
    fathom_id material; /* FATHOM_NONE: not given */
    unsigned flags;
    bool placed; /* by keys of its own, or by motion */
    affine_f64 map;
} object;

/* Children nest by recursion: what does not recurse keeps its variables out of the frames that do. */
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

/* ---- each kind ---- */

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
    status = read_mesh(r->scene, group, path, &options);
    free(path);
    return status == FATHOM_OK ? status : doc_within(r->doc, &file, status);
}

/* Objects added since there were `first`. */
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
    /* Here the file makes the mistake, not a caller of the library. */
    return status == FATHOM_BAD_USAGE ? FATHOM_BAD_INPUT : status;
}

/* Each level is read by calls within calls, which take about 1.2 kB of stack: 0.6 MB of the 1 MB there may
 * be. */
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
                        "children within children, more than %d levels; expected such as groups of their own "
                        "under \"groups\", shown by instances",
                        NESTING_MAX);
    return object_list(r, &children, o->values.as.group.children, group);
}

/* Adds the object's content to the group. Messages of the scene's own checks get their place here; the others
 * have it. */
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

/* ---- placing ---- */

/* The group that the object's content goes to. A placed shape and a group get one of their own. */
LEAF fathom_status choose_group(const object_reader *r, const where *at, const object *o, fathom_id parent,
                                fathom_id *out) {
    *out = parent;
    if (o->kind == FORM_INSTANCE)
        return find_id(r, at, "of", "group", o->values.as.instance.of, r->groups, out);
    if (o->kind != FORM_GROUP && !o->placed) return FATHOM_OK;
    return fathom_scene_add_group(r->scene, o->values.name, out);
}

/* *keys: the memory of the instance's keys, for the caller to free, even after a failure. */
LEAF fathom_status read_motion(const object_reader *r, const where *at, json_t *list, double **keys,
                               fathom_instance *out) {
    const where motion = {at, "motion", 0};
    const size_t count = json_array_size(list);
    if (!count) return doc_fail(r->doc, &motion, "expected one or more keys, found none");
    *keys = malloc(13 * count * sizeof **keys);
    if (!*keys) return fail_memory(r->scene->context, 13 * count * sizeof **keys);
    for (size_t k = 0; k < count; ++k) {
        const where item = {&motion, NULL, k};
        json_t *value = json_array_get(list, k);
        form_object_values values = {.name = NULL};
        affine_f64 map;
        bool placed;
        fathom_status status = doc_read(r->doc, &item, value, &form_place_key, &values);
        if (status == FATHOM_OK) status = place_object(r->doc, &item, value, &values.place, &map, &placed);
        if (status != FATHOM_OK) return status;
        (*keys)[k] = values.place.time;
        memcpy(*keys + count + 12 * k, map.m, sizeof map.m);
    }
    out->key_count = (uint32_t)count;
    out->key_times = *keys, out->key_transforms = *keys + count;
    return FATHOM_OK;
}

LEAF fathom_status add_instance(const object_reader *r, const where *at, const object *o, fathom_id parent,
                                fathom_id group) {
    fathom_instance instance;
    fathom_instance_default(&instance);
    instance.group = group;
    instance.parent = parent;
    memcpy(instance.transform, o->map.m, sizeof instance.transform);
    if (o->kind == FORM_GROUP || o->kind == FORM_INSTANCE) instance.material = o->material;
    double *keys = NULL;
    fathom_status status = FATHOM_OK;
    if (o->values.motion) status = read_motion(r, at, o->values.motion, &keys, &instance);
    if (status == FATHOM_OK) {
        status = fathom_scene_add_instance(r->scene, &instance, NULL);
        if (status != FATHOM_OK) status = doc_within(r->doc, at, status);
    }
    free(keys);
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
    if (o.kind == FORM_TRIANGLE && o.values.light_group) {
        /* Its mesh comes later. */
        const where named = {at, "group", 0};
        uint8_t found;
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
