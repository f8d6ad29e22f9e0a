/* scenes/fathom.schema.json and scenes/README.md against the tables that the reader follows: neither may know
 * a key, type, range or rule that the other does not. */
#include "read/json/json_form.h"
#include "scene/settings.h"
#include "unit.h"

/* ---- the schema that the tables stand for ---- */

static json_t *text(const char *s) { return json_string(s); }

static json_t *reference(const form *f) {
    return json_pack("{s:s}", "$ref", unit_text("#/definitions/%s", f->name));
}

static json_t *number_schema(const form_key *key) {
    bool whole = key->kind == FORM_U32 || key->kind == FORM_U64 || key->whole;
    json_t *schema = json_pack("{s:s}", "type", whole ? "integer" : "number");
    form_range r = key->range;
    if (r.open & FORM_NO_ZERO) json_object_set_new(schema, "not", json_pack("{s:f}", "const", 0.0));
    if (r.low == 0 && r.high == 0) return schema;
    const char *low = r.open & FORM_OPEN_LOW ? "exclusiveMinimum" : "minimum";
    const char *high = r.open & FORM_OPEN_HIGH ? "exclusiveMaximum" : "maximum";
    json_object_set_new(schema, low, json_real(r.low));
    if (!isinf(r.high)) json_object_set_new(schema, high, json_real(r.high));
    return schema;
}

/* exact 0: any number of items from one up. */
static json_t *array_schema(json_t *items, unsigned exact) {
    json_t *schema = json_pack("{s:s, s:o, s:f}", "type", "array", "items", items, "minItems",
                               exact ? (double)exact : 1.0);
    if (exact) json_object_set_new(schema, "maxItems", json_real(exact));
    return schema;
}

static json_t *numbers_schema(const form_key *key) {
    if (!key->count) return number_schema(key);
    json_t *row = array_schema(number_schema(key), key->count);
    if (key->nonzero) json_object_set_new(row, "contains", json_pack("{s:{s:f}}", "not", "const", 0.0));
    if (key->kind == FORM_ROWS || key->rows) return array_schema(row, key->rows);
    return row;
}

static json_t *words_schema(const char *words) {
    json_t *list = json_array();
    size_t length;
    const char *word;
    for (unsigned i = 0; (word = words_at(words, i, &length)); ++i)
        json_array_append_new(list, json_stringn(word, length));
    return json_pack("{s:o}", "enum", list);
}

static json_t *key_schema(const form *f, const form_key *key) {
    switch (key->kind) {
    case FORM_BOOL: return json_pack("{s:s}", "type", "boolean");
    case FORM_F32:
    case FORM_F64:
    case FORM_U32:
    case FORM_U64:
    case FORM_ROWS: return numbers_schema(key);
    case FORM_TEXT: return json_pack("{s:s, s:s*}", "type", "string", "pattern", key->words);
    case FORM_TAG: return json_pack("{s:s}", "const", f->name);
    case FORM_WORD: return words_schema(key->words);
    case FORM_WORDS:
        return json_pack("{s:s, s:o, s:b}", "type", "array", "items", words_schema(key->words), "uniqueItems",
                         1);
    case FORM_OBJECT: return reference(key->form);
    case FORM_LIST:
        if (key->count) return array_schema(reference(key->form), 0);
        return json_pack("{s:s, s:o}", "type", "array", "items", reference(key->form));
    case FORM_MAP:
        return json_pack("{s:s, s:o}", "type", "object", "additionalProperties", reference(key->form));
    case FORM_MAP_OF_LISTS:
        return json_pack("{s:s, s:{s:s, s:o}}", "type", "object", "additionalProperties", "type", "array",
                         "items", reference(key->form));
    }
    return NULL;
}

/* Adds value to the member `key` of `to`, made by make() when it is not there yet. */
static json_t *member(json_t *to, const char *key, json_t *(*make)(void)) {
    json_t *value = json_object_get(to, key);
    if (!value) json_object_set_new(to, key, value = make());
    return value;
}

/* A schema has no warnings. */
static void add_rule(json_t *schema, const form_rule *rule) {
    if (rule->kind == FORM_WANTS || rule->kind == FORM_WANTS_ONE_OF) return;
    json_t *list = json_array();
    for (const char *const *other = rule->others; *other; ++other) {
        json_array_append_new(list, rule->kind == FORM_ONE_OF ? json_pack("{s:[s]}", "required", *other)
                                                              : text(*other));
    }
    if (rule->kind == FORM_ONE_OF) {
        json_object_set_new(schema, "oneOf", list);
        return;
    }
    json_t *dependencies = member(schema, "dependencies", json_object);
    /* One key has rules of one kind only: both would want the same entry. */
    assert_null(json_object_get(dependencies, rule->key));
    if (rule->kind == FORM_EXCLUDES || rule->kind == FORM_HOLDS)
        list = json_pack("{s:{s:{s:o}}}", "propertyNames", "not", "enum", list);
    json_object_set_new(dependencies, rule->key, list);
}

static json_t *plain_schema(const form *f) {
    json_t *properties = json_object(), *schema = json_pack("{s:s, s:o, s:b}", "type", "object", "properties",
                                                            properties, "additionalProperties", 0);
    for (const form_key *const *part = f->parts; *part; ++part) {
        for (const form_key *key = *part; key->name; ++key) {
            json_object_set_new(properties, key->name, key_schema(f, key));
            if (key->required) json_array_append_new(member(schema, "required", json_array), text(key->name));
        }
    }
    for (const form_rule *const *part = f->rules; *part; ++part) {
        for (const form_rule *rule = *part; rule->kind != FORM_NO_RULE; ++rule) add_rule(schema, rule);
    }
    return schema;
}

/* The first variant is what it is without a tag. */
static json_t *untagged_schema(const form *f) {
    json_t *words = json_array(), *rest = reference(f->variants[0]), *schema = NULL;
    json_array_append_new(words, text(f->variants[0]->name));
    for (const form *const *variant = f->variants + 1; *variant; ++variant) {
        json_array_append_new(words, text((*variant)->name));
        rest = json_pack("{s:{s:{s:{s:s}}, s:[s]}, s:o, s:o}", "if", "properties", f->tag, "const",
                         (*variant)->name, "required", f->tag, "then", reference(*variant), "else", rest);
    }
    schema = json_pack("{s:s, s:{s:{s:o}}, s:[o]}", "type", "object", "properties", f->tag, "enum", words,
                       "allOf", rest);
    return schema;
}

/* Told apart by "type", in a way that lets editors complete the rest of an object once its type is there. */
static json_t *choice_schema(const form *f) {
    json_t *words = json_array(), *cases = json_array();
    for (const form *const *variant = f->variants; *variant; ++variant) {
        json_array_append_new(words, text((*variant)->name));
        json_array_append_new(cases,
                              json_pack("{s:{s:{s:{s:s}}, s:[s]}, s:o}", "if", "properties", "type", "const",
                                        (*variant)->name, "required", "type", "then", reference(*variant)));
    }
    return json_pack("{s:s, s:{s:{s:o}}, s:[s], s:o}", "type", "object", "properties", "type", "enum", words,
                     "required", "type", "allOf", cases);
}

static void define(json_t *definitions, const form *f);

static void define_parts(json_t *definitions, const form *f) {
    for (const form_key *const *part = f->parts; *part; ++part) {
        for (const form_key *key = *part; key->name; ++key) {
            if (key->form) define(definitions, key->form);
        }
    }
}

static void define(json_t *definitions, const form *f) {
    if (json_object_get(definitions, f->name)) return;
    json_object_set_new(definitions, f->name,
                        f->tag        ? untagged_schema(f)
                        : f->variants ? choice_schema(f)
                                      : plain_schema(f));
    define_parts(definitions, f);
    for (const form *const *variant = f->variants; variant && *variant; ++variant)
        define(definitions, *variant);
}

static json_t *schema_of_tables(void) {
    form_prepare();
    json_t *definitions = json_object(), *schema = plain_schema(&form_scene);
    define_parts(definitions, &form_scene);
    json_object_set_new(schema, "definitions", definitions);
    json_object_set_new(schema, "$schema", text("http://json-schema.org/draft-07/schema#"));
    return schema;
}

/* ---- the published schema, brought to the same form ---- */

static json_t *load(const char *path) {
    json_error_t error;
    json_t *value = json_load_file(path, JSON_DECODE_INT_AS_REAL | JSON_REJECT_DUPLICATES, &error);
    if (!value) fail_msg("%s:%d: %s", path, error.line, error.text);
    return value;
}

/* Words for people and editors, which judge nothing. */
static bool is_note(const char *key) {
    static const char *const notes[] = {"title", "description", "default", "defaultSnippets", "errorMessage"};
    for (size_t i = 0; i < sizeof notes / sizeof *notes; ++i) {
        if (strcmp(key, notes[i]) == 0) return true;
    }
    return false;
}

static bool is_form(const json_t *tables, const char *name) {
    return json_object_get(json_object_get(tables, "definitions"), name) != NULL;
}

static json_t *judging_part(const json_t *schema, json_t *value, const json_t *tables, bool names);

/* The definition a "$ref" points to; NULL when the value has none, or it stands for a form. */
static json_t *shorthand(const json_t *schema, const json_t *value, const json_t *tables) {
    static const char prefix[] = "#/definitions/";
    const char *target = json_string_value(json_object_get(value, "$ref"));
    if (!target) return NULL;
    assert_memory_equal(target, prefix, sizeof prefix - 1);
    target += sizeof prefix - 1;
    if (is_form(tables, target)) return NULL;
    json_t *definition = json_object_get(json_object_get(schema, "definitions"), target);
    if (!definition) fail_msg("the schema refers to \"%s\", which it does not define", target);
    return definition;
}

static json_t *judging_object(const json_t *schema, json_t *value, const json_t *tables, bool names) {
    json_t *short_for = names ? NULL : shorthand(schema, value, tables);
    if (short_for) return judging_part(schema, short_for, tables, false);
    json_t *out = json_object(), *item;
    const char *key;
    json_object_foreach(value, key, item) {
        if (!names && is_note(key)) continue;
        bool named = !names && (strcmp(key, "properties") == 0 || strcmp(key, "dependencies") == 0);
        json_object_set_new(out, key, judging_part(schema, item, tables, named));
    }
    return out;
}

/* A copy without notes and shorthands. names: the keys of this object are names, not words of the schema's
 * language. */
static json_t *judging_part(const json_t *schema, json_t *value, const json_t *tables, bool names) {
    if (json_is_object(value)) return judging_object(schema, value, tables, names);
    if (!json_is_array(value)) return json_copy(value);
    json_t *out = json_array(), *item;
    size_t i;
    json_array_foreach(value, i, item) {
        json_array_append_new(out, judging_part(schema, item, tables, false));
    }
    return out;
}

static json_t *published_schema(const json_t *tables) {
    json_t *schema = load(SOURCE_DIR "/scenes/fathom.schema.json");
    json_t *forms = json_object(), *definition;
    const char *name;
    json_object_foreach(json_object_get(schema, "definitions"), name, definition) {
        if (is_form(tables, name))
            json_object_set_new(forms, name, judging_part(schema, definition, tables, false));
    }
    json_t *rest = json_copy(schema);
    json_object_del(rest, "definitions");
    json_t *out = judging_part(schema, rest, tables, false);
    json_object_set_new(out, "definitions", forms);
    json_decref(rest);
    json_decref(schema);
    return out;
}

/* ---- comparing ---- */

/* Fails at the first difference, with its path. */
static void assert_same(json_t *published, json_t *tables, const char *path) {
    if (json_equal(published, tables)) return;
    if (!published) fail_msg("%s: the reader knows it, the schema does not", path);
    if (!tables) fail_msg("%s: the schema knows it, the reader does not", path);
    char inner[1024];
    const char *key;
    json_t *value;
    size_t i;
    if (json_is_object(published) && json_is_object(tables)) {
        json_object_foreach(published, key, value) {
            snprintf(inner, sizeof inner, "%s/%s", path, key);
            assert_same(value, json_object_get(tables, key), inner);
        }
        json_object_foreach(tables, key, value) {
            snprintf(inner, sizeof inner, "%s/%s", path, key);
            assert_same(json_object_get(published, key), value, inner);
        }
    } else if (json_is_array(published) && json_is_array(tables)) {
        json_array_foreach(published, i, value) {
            snprintf(inner, sizeof inner, "%s/%zu", path, i);
            assert_same(value, json_array_get(tables, i), inner);
        }
    }
    fail_msg("%s: the schema says %s, the reader %s", path,
             json_dumps(published, JSON_ENCODE_ANY | JSON_COMPACT),
             json_dumps(tables, JSON_ENCODE_ANY | JSON_COMPACT));
}

UNIT_TEST(schema_and_reader_agree) {
    json_t *tables = schema_of_tables(), *published = published_schema(tables);
    assert_same(published, tables, "");
    json_decref(published);
    json_decref(tables);
}

/* ---- the words about settings and material parameters ---- */

static void assert_described(json_t *schema, const char *form_name, parameter_table table) {
    json_t *definition = json_object_get(json_object_get(schema, "definitions"), form_name);
    json_t *properties = json_object_get(definition, "properties");
    for (size_t i = 0; i < table.count; ++i) {
        char name[PARAMETER_NAME];
        parameter_name(&table.rows[i], 0, name);
        if (!(table.rows[i].flags & FATHOM_PARAMETER_FILE)) continue;
        const char *words =
            json_string_value(json_object_get(json_object_get(properties, name), "description"));
        if (!words || strcmp(words, table.rows[i].help) != 0)
            fail_msg("%s.%s: the schema says \"%s\", the table \"%s\"", form_name, name, words,
                     table.rows[i].help);
    }
}

UNIT_TEST(schema_describes_as_the_tables_do) {
    json_t *schema = load(SOURCE_DIR "/scenes/fathom.schema.json");
    assert_described(schema, "image", settings_table);
    assert_described(schema, "classic", classic_table);
    assert_described(schema, "metallicRoughness", metallic_table);
    json_decref(schema);
}

/* ---- the reference ---- */

static char *load_text(const char *path) {
    FILE *file = fopen(path, "rb");
    if (!file) fail_msg("%s cannot be opened", path);
    char *out = calloc(1, 1 << 20);
    size_t size = fread(out, 1, (1 << 20) - 1, file);
    assert_in_range(size, 1, (1 << 20) - 2);
    fclose(file);
    return out;
}

/* Every key with the words that the schema has for it. */
static void assert_in_reference(const char *readme, const char *form_name, json_t *properties) {
    const char *key;
    json_t *property;
    json_object_foreach(properties, key, property) {
        const char *quoted = unit_text("`%s`", key);
        if (!strstr(readme, quoted)) fail_msg("scenes/README.md does not have %s of %s", quoted, form_name);
        const char *words = json_string_value(json_object_get(property, "description"));
        if (words && !strstr(readme, words))
            fail_msg("scenes/README.md says otherwise of %s of %s than the schema: %s", quoted, form_name,
                     words);
        if (!words && !json_object_get(property, "$ref"))
            fail_msg("the schema does not say what %s of %s is", quoted, form_name);
    }
}

UNIT_TEST(reference_has_every_key) {
    char *readme = load_text(SOURCE_DIR "/scenes/README.md");
    json_t *schema = load(SOURCE_DIR "/scenes/fathom.schema.json"), *definition;
    const char *name;
    assert_in_reference(readme, "the scene", json_object_get(schema, "properties"));
    json_object_foreach(json_object_get(schema, "definitions"), name, definition) {
        assert_in_reference(readme, name, json_object_get(definition, "properties"));
    }
    json_decref(schema);
    free(readme);
}

int main(void) { return unit_main(NULL, NULL); }
