/* Frames, transforms and their motion in scene JSON. */
#include "read/json/json_scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

double place_radians(double degrees) { return degrees * 0.017453292519943295; }

/* Axes with three decimals have an error of up to 5e-4 in each component, so of sqrt(3) 5e-4 in length. The
 * error of the cosine of two axes is up to twice that. */
static bool right_angle(vec3_f64 a, vec3_f64 b) {
    return fabs(dot_f64(normalize_f64(a), normalize_f64(b))) <= 1.8e-3;
}

/* There may be many moving instances, and each line takes a search of the text, so these have none. */
fathom_status place_origin(const object_reader *r, const where *at, scene_part part, fathom_id id) {
    where_spot spot = {.place.field = spot.path};
    if (part == SCENE_PART_MOVED)
        where_path(at, spot.path, sizeof spot.path);
    else
        doc_place(r->doc, at, &spot);
    return scene_origin_add(r->scene, part, id, &spot.place);
}

fathom_status place_frame(const doc *d, const where *at, json_t *value, const form_frame_values *values,
                          frame_f64 *out) {
    vec3_f64 x = load_f64(values->x), y = load_f64(values->y), z = load_f64(values->z);
    bool has_y = doc_has(value, "y");
    *out = frame_from(load_f64(values->origin), z, has_y ? y : (vec3_f64){0, 1, 0});
    if (!doc_has(value, "x")) return FATHOM_OK;
    if (!right_angle(x, y) || !right_angle(y, z) || !right_angle(z, x))
        return doc_fail(d, at,
                        "x, y and z are not at right angles; leave x out, because y and z determine it");
    if (dot_f64(normalize_f64(x), out->x) < 0)
        return doc_fail(d, at, "x, y and z are left-handed; expected x along y cross z");
    return FATHOM_OK;
}

static fathom_status load_matrix(const doc *d, const where *at, const double m[16], affine_f64 *out) {
    *out = affine_of_columns(m);
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
        *out = frame_affine(&f);
    }
    return FATHOM_OK;
}

fathom_status place_object(const doc *d, const where *at, json_t *object, const form_place_values *values,
                           affine_f64 *out, bool *placed) {
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

fathom_status place_motion(const object_reader *r, const where *at, json_t *list, place_key_reader *read,
                           uint32_t *count, double **keys) {
    const where motion = {at, "motion", 0};
    const size_t n = json_array_size(list);
    *keys = malloc(13 * n * sizeof **keys);
    if (!*keys) return fail_memory(r->scene->context, 13 * n * sizeof **keys);
    *count = (uint32_t)n;
    for (size_t k = 0; k < n; ++k) {
        const where item = {&motion, NULL, k};
        affine_f64 map;
        fathom_status status = read(r, &item, json_array_get(list, k), *keys + k, &map);
        if (status != FATHOM_OK) return status;
        memcpy(*keys + n + 12 * k, map.m, sizeof map.m);
    }
    return FATHOM_OK;
}

fathom_status place_within(const object_reader *r, const where *at, const char *list, fathom_status status) {
    const fathom_error *error = fathom_context_error(r->doc->context);
    unsigned k;
    char of[16];
    const char *field = error->place->field;
    /* The camera's own errors name it already. */
    if (at->key && strcmp(field, at->key) == 0) return doc_within(r->doc, at->parent, status);
    if (sscanf(field, "key_%15[a-z][%u]", of, &k) != 2) return doc_within(r->doc, at, status);
    const where keys = {at, list, 0}, key = {&keys, NULL, k}, time = {&key, "time", 0};
    return doc_fail(r->doc, strcmp(of, "times") == 0 ? &time : &key, "%s", error->text);
}
