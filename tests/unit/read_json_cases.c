/* Good and bad documents: tests/json/cases.json, which tests/cli/scene_schema.sh gives to the schema as well.
 */
#include "json_scene.h"

#include <jansson.h>

static void judge(json_scene *s, json_t *one, size_t place) {
    char *text = json_dumps(json_object_get(one, "document"), JSON_INDENT(1) | JSON_REAL_PRECISION(15));
    const char *expected = json_string_value(json_object_get(one, "message"));
    fathom_scene *scene;
    fathom_status status = json_scene_read(s, text, strlen(text), &scene);
    const char *message = fathom_context_message(s->context);
    if (!expected && status != FATHOM_OK) fail_msg("case %zu is good, but: %s", place, message);
    if (expected && status != FATHOM_BAD_INPUT) fail_msg("case %zu was read: %s", place, text);
    if (expected && !strstr(message, expected))
        fail_msg("case %zu: message \"%s\" does not hold \"%s\"", place, message, expected);
    free(text);
}

UNIT_TEST(documents_are_judged_right) {
    json_error_t error;
    json_t *cases = json_load_file(SOURCE_DIR "/tests/json/cases.json", 0, &error), *one;
    if (!cases) fail_msg("cases.json:%d: %s", error.line, error.text);
    assert_true(json_array_size(cases) > 150);
    json_scene s;
    json_scene_open(&s);
    size_t i;
    json_array_foreach(cases, i, one) { judge(&s, one, i); }
    json_scene_close(&s);
    json_decref(cases);
}

int main(void) { return unit_main(NULL, NULL); }
