/* The defaults that the schema publishes are the reader's: writing one down changes nothing. */
#include "json_scene.h"
#include "scene/settings.h"

#include <jansson.h>

static json_t *definition(json_t *schema, const char *name) {
    return json_object_get(json_object_get(schema, "definitions"), name);
}

/* A property's own default, or that of the shorthand it refers to. */
static json_t *default_of(json_t *schema, json_t *form, const char *key) {
    json_t *property = json_object_get(json_object_get(form, "properties"), key);
    json_t *own = json_object_get(property, "default");
    const char *target = json_string_value(json_object_get(property, "$ref"));
    return own || !target ? own : json_object_get(definition(schema, strrchr(target, '/') + 1), "default");
}

/* ---- scenes that are the same ---- */

#define SAME(member) assert_memory_equal(&a->member, &b->member, sizeof a->member)

static void same_parameters(parameter_table table, const void *a, const void *b) {
    for (size_t i = 0; i < table.count; ++i) {
        const fathom_parameter *p = &table.rows[i];
        for (unsigned k = 0; k < parameter_count(p); ++k)
            assert_true(parameter_number(p, a, k) == parameter_number(p, b, k));
    }
}

static void same_light(const fathom_light *a, const fathom_light *b) {
    SAME(type);
    SAME(position);
    SAME(direction);
    SAME(intensity);
    SAME(inner_angle);
    SAME(outer_angle);
    SAME(radius);
    SAME(angular_radius);
    SAME(rotation);
}

/* Each document here has one object; a placement by nothing is the identity. */
static void same_object(const fathom_scene *a, const fathom_scene *b) {
    fathom_instance placed[2];
    const fathom_scene *scenes[] = {a, b};
    for (int i = 0; i < 2; ++i) {
        fathom_instance_default(&placed[i]);
        if (scenes[i]->instances.count) placed[i] = scenes[i]->instances.items[0];
    }
    assert_memory_equal(placed[0].transform, placed[1].transform, sizeof placed[0].transform);
    assert_int_equal(a->objects.count, b->objects.count);
    for (size_t i = 0; i < a->spheres.count; ++i)
        assert_int_equal(a->spheres.items[i].flags, b->spheres.items[i].flags);
    for (size_t i = 0; i < a->meshes.count; ++i) {
        const fathom_mesh *x = &a->meshes.items[i], *y = &b->meshes.items[i];
        assert_true((x->normals == NULL) == (y->normals == NULL));
        assert_int_equal(x->vertex_count, y->vertex_count);
        assert_memory_equal(x->positions, y->positions, 3 * sizeof(float) * x->vertex_count);
    }
}

static void same_scene(const fathom_scene *a, const fathom_scene *b) {
    same_parameters(settings_table, &a->settings, &b->settings);
    SAME(camera);
    SAME(background);
    assert_int_equal(a->lights.count, b->lights.count);
    assert_int_equal(a->materials.count, b->materials.count);
    for (size_t i = 0; i < a->lights.count; ++i) same_light(&a->lights.items[i], &b->lights.items[i]);
    assert_int_equal(a->environments.count, b->environments.count);
    for (size_t i = 0; i < a->environments.count; ++i)
        same_light(&a->environments.items[i], &b->environments.items[i]);
    for (size_t i = 0; i < a->materials.count; ++i) {
        const fathom_material *x = &a->materials.items[i].value, *y = &b->materials.items[i].value;
        assert_int_equal(x->model, y->model);
        same_parameters(material_table(x->model), x, y);
    }
    same_object(a, b);
}

/* ---- with and without ---- */

/* Adds `"key": default` in text, and the same for the keys that it needs. */
static void write_default(json_t *schema, json_t *form, const char *key, char *out, size_t room) {
    char *value = json_dumps(default_of(schema, form, key), JSON_ENCODE_ANY);
    size_t used = strlen(out);
    snprintf(out + used, room - used, ", \"%s\": %s", key, value);
    free(value);
    json_t *needed = json_object_get(json_object_get(form, "dependencies"), key), *other;
    size_t i;
    json_array_foreach(needed, i, other) {
        if (default_of(schema, form, json_string_value(other)))
            write_default(schema, form, json_string_value(other), out, room);
    }
}

/* Tries each default of the form in the document, where it has "@". Returns how many there were. */
static size_t try_defaults(json_scene *s, json_t *schema, json_t *form, const char *document) {
    const char *at = strchr(document, '@'), *key;
    char text[2048], extra[512];
    size_t tried = 0;
    snprintf(text, sizeof text, "%.*s%s", (int)(at - document), document, at + 1);
    fathom_scene *without = json_scene_good(s, text);
    json_t *property;
    json_object_foreach(json_object_get(form, "properties"), key, property) {
        if (!default_of(schema, form, key)) continue;
        extra[0] = '\0';
        write_default(schema, form, key, extra, sizeof extra);
        snprintf(text, sizeof text, "%.*s%s%s", (int)(at - document), document,
                 at[-1] == '{' ? extra + 1 : extra, at + 1);
        fathom_scene *with = json_scene_good(s, text);
        same_scene(without, with);
        ++tried;
    }
    return tried;
}

#define OBJECT(text) "{\"objects\": [{" text " @}]}"
#define LIGHT(text) "{\"lights\": [{" text " @}], \"objects\": []}"
#define ROW "[[0, 0, 0], [1, 0, 0], [0, 1, 0]]"

UNIT_TEST(written_defaults_change_nothing) {
    static const struct {
        const char *form, *document;
    } cases[] = {
        {"image", "{\"image\": {@}, \"objects\": []}"},
        {"camera", "{\"camera\": {\"eye\": [1, 2, 3], \"target\": [0, 0, 0] @}, \"objects\": []}"},
        {"frame", "{\"camera\": {\"frame\": {\"origin\": [1, 2, 3], \"z\": [1, 2, 3] @}}, \"objects\": []}"},
        {"classic", "{\"materials\": {\"m\": {\"ka\": [0, 0, 1] @}}, \"objects\": []}"},
        {"metallicRoughness",
         "{\"materials\": {\"m\": {\"model\": \"metallicRoughness\" @}}, \"objects\": []}"},
        {"point", LIGHT("\"type\": \"point\", \"position\": [1, 2, 3]")},
        {"directional", LIGHT("\"type\": \"directional\", \"direction\": [1, 2, 3]")},
        {"sun", LIGHT("\"type\": \"sun\", \"direction\": [1, 2, 3]")},
        {"environment", LIGHT("\"type\": \"environment\", \"file\": \"triangle.obj\"")},
        {"spot", LIGHT("\"type\": \"spot\", \"position\": [1, 2, 3], \"target\": [0, 0, 0]")},
        {"sphere", OBJECT("\"type\": \"sphere\", \"center\": [1, 2, 3], \"radius\": 1")},
        {"quad", OBJECT("\"type\": \"quad\", \"center\": [1, 2, 3], \"u\": [1, 0, 0], \"v\": [0, 1, 0]")},
        {"plane", OBJECT("\"type\": \"plane\", \"point\": [1, 2, 3], \"normal\": [1, 0, 0]")},
        {"triangle", OBJECT("\"type\": \"triangle\", \"vertices\": " ROW)},
        {"mesh",
         OBJECT("\"type\": \"mesh\", \"indices\": [[0, 1, 2]], \"positions\": " ROW ", \"normals\": " ROW)},
        {"generate", OBJECT("\"type\": \"generate\", \"kind\": \"sphere\", \"triangles\": 300")},
        {"group", OBJECT("\"type\": \"group\", \"children\": []")},
    };
    json_scene s;
    json_scene_open(&s);
    json_error_t error;
    json_t *schema = json_load_file(SOURCE_DIR "/scenes/fathom.schema.json", 0, &error);
    assert_non_null(schema);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        json_t *form = definition(schema, cases[i].form);
        assert_true(try_defaults(&s, schema, form, cases[i].document) > 0);
    }
    json_decref(schema);
    json_scene_close(&s);
}

int main(void) { return unit_main(NULL, NULL); }
