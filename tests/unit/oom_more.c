/* Memory that runs out, requests.h says how: over all that the formats know, the shapes that scenes are made
 * of, and the ways to sample, save and write. */
#include "defaults.h"
#include "scene/scene.h"

#include "requests.h" /* last: cmocka defines words such as fail */

#include <dirent.h>

/* ---- reading ---- */

/* What was read, by its fingerprint. */
static fathom_status read_file(fathom_context *context, const char *path, outcome *out) {
    fathom_scene *scene;
    fathom_status status = fathom_scene_read(context, path, &scene);
    assert_true((scene != NULL) == (status == FATHOM_OK));
    uint64_t number;
    if (status == FATHOM_OK) status = scene_fingerprint(scene, &number);
    if (status == FATHOM_OK) add(out, &number, sizeof number);
    fathom_scene_destroy(scene);
    return status;
}

/* The seeds of the fuzz targets hold every feature of their formats; some are wrong, and say so however
 * little memory there is. */
static void read_all(const char *format) {
    char path[512];
    snprintf(path, sizeof path, "%s/tests/fuzz/corpus/%s", SOURCE_DIR, format);
    DIR *directory = opendir(path);
    assert_non_null(directory);
    unsigned good = 0;
    for (struct dirent *entry; (entry = readdir(directory));) {
        if (entry->d_name[0] == '.') continue;
        snprintf(path, sizeof path, "%s/tests/fuzz/corpus/%s/%s", SOURCE_DIR, format, entry->d_name);
        outcome unused;
        bool told;
        failing = 0;
        fathom_status status = attempt(read_file, path, &unused, &told);
        assert_true(status == FATHOM_OK || status == FATHOM_BAD_INPUT);
        exhaust_to(read_file, path, status);
        good += status == FATHOM_OK;
    }
    closedir(directory);
    assert_true(good >= 4);
}

UNIT_TEST(reading_gltf) {
    read_all("gltf");
    read_all("glb");
}

UNIT_TEST(reading_obj) { read_all("obj"); }

UNIT_TEST(reading_ply) { read_all("ply"); }

UNIT_TEST(reading_json) { read_all("scene_json"); }

/* ---- scenes of everything ---- */

static const char all_json[] =
    "{ \"name\": \"all\", \"camera\": { \"eye\": [0, 1, 6], \"target\": [0, 0.5, 0], \"fovy\": 40 },\n"
    "  \"image\": { \"width\": 8, \"height\": 6, \"spp\": 4 }, \"ambient\": [0.1, 0.1, 0.1],\n"
    "  \"materials\": { \"shiny\": { \"kd\": [0.2, 0.2, 0.2], \"ks\": [0.5, 0.5, 0.5], \"specular\": "
    "\"phong\", \"kr\": [0.4, 0.4, "
    "0.4] },\n"
    "    \"clear\": { \"kd\": [0, 0, 0], \"kt\": [0.9, 0.9, 0.9], \"kr\": [0.1, 0.1, 0.1], \"ior\": 1.4 } "
    "},\n"
    "  \"lights\": [ { \"type\": \"directional\", \"direction\": [0.4, -1, -0.7], \"intensity\": 1 },\n"
    "    { \"type\": \"point\", \"position\": [0, 3, 3], \"intensity\": 9 } ],\n"
    "  \"groups\": { \"inner\": [\n"
    "      { \"type\": \"mesh\", \"positions\": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],\n"
    "        \"indices\": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], \"material\": \"shiny\" },\n"
    "      { \"type\": \"quad\", \"center\": [0, 0, 1], \"u\": [0.4, 0, 0], \"v\": [0, 0.4, 0] },\n"
    "      { \"type\": \"plane\", \"point\": [0, -4, 0], \"normal\": [0, 1, 0] } ],\n"
    "    \"outer\": [ { \"type\": \"instance\", \"of\": \"inner\", \"scale\": [0.5, 0.5, 0.5] },\n"
    "      { \"type\": \"instance\", \"of\": \"inner\", \"translation\": [1, 0, 0], \"material\": \"clear\" "
    "},\n"
    "      { \"type\": \"sphere\", \"center\": [-1, 0, 0], \"radius\": 0.3, \"material\": \"clear\" } ] },\n"
    "  \"objects\": [\n"
    "    { \"type\": \"plane\", \"point\": [0, 0, 0], \"normal\": [0, 1, 0] },\n"
    "    { \"type\": \"triangle\", \"vertices\": [[0, 0, -1], [1, 0, -1], [0, 1, -1]] },\n"
    "    { \"type\": \"mesh\", \"positions\": [[0, 0, -2], [1, 0, -2], [0, 1, -2]], \"indices\": [[0, 1, "
    "2]],\n"
    "      \"normals\": [[0, 0, 1], [0, 0.1, 1], [0, 0, 1]] },\n"
    "    { \"type\": \"generate\", \"kind\": \"sphere\", \"triangles\": 64, \"seed\": 3, \"translation\": "
    "[-1, 1, -1] },\n"
    "    { \"type\": \"generate\", \"kind\": \"sponge\", \"triangles\": 300, \"translation\": [1, 1, -2] },\n"
    "    { \"type\": \"generate\", \"kind\": \"terrain\", \"triangles\": 50, \"translation\": [0, -1, 0] },\n"
    "    { \"type\": \"instance\", \"of\": \"outer\" }, { \"type\": \"instance\", \"of\": \"outer\", "
    "\"translation\": [0, "
    "1, 0] },\n"
    "    { \"type\": \"group\", \"translation\": [0, 0, -3], \"children\": [\n"
    "      { \"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 0.3, \"scale\": [1, 2, 1] } ] } ] }\n";

static fathom_settings settings_of(const fathom_scene *scene) {
    fathom_settings settings;
    fathom_scene_settings(scene, &settings);
    settings.width = 8, settings.height = 6, settings.spp = 4, settings.target_error = 0;
    settings.aovs = FATHOM_AOVS & ~(unsigned)FATHOM_AOV_ERROR;
    return settings;
}

static void add_film(outcome *out, const fathom_film *film) {
    static const char *const channels[] = {"R", "G", "B", "A", "Z", "N.X"};
    for (size_t c = 0; c < sizeof channels / sizeof *channels; ++c)
        add(out, fathom_film_channel(film, channels[c]), 8 * 6 * sizeof(float));
}

static const char *tracer;
static bool adaptive, timed, saved;

/* By the four words above. */
static fathom_status render(fathom_context *context, const char *file, outcome *out) {
    fathom_scene *scene;
    fathom_film *film;
    fathom_status status = fathom_scene_read_to_render(context, in_folder(file), &scene);
    if (status != FATHOM_OK) return status;
    fathom_settings settings = settings_of(scene);
    settings.tracer = tracer;
    if (adaptive || timed) settings.pattern = FATHOM_PATTERN_SOBOL, settings.spp = 8;
    if (adaptive) settings.target_error = 1e-6;
    if (timed) settings.max_time = 1e6;
    fathom_checkpoint checkpoint = default_checkpoint();
    checkpoint.path = in_folder("saved"), checkpoint.every = 0;
    fathom_session_options options = default_session_options();
    if (saved) options.checkpoint = &checkpoint;
    status = fathom_session_run(context, scene, &settings, &options, NULL, &film);
    assert_true((film != NULL) == (status == FATHOM_OK));
    if (film) add_film(out, film);
    fathom_film_destroy(film);
    fathom_scene_destroy(scene);
    unlink(in_folder("saved"));
    return status;
}

UNIT_TEST(tracers) {
    static const char *const specs[] = {"linear", "bvh",         "bvh:f64",
                                        "embree", "embree:user", "embree:triangles"};
    for (size_t i = 0; i < sizeof specs / sizeof *specs; ++i) {
        tracer = specs[i];
        exhaust(render, "all.json");
    }
}

UNIT_TEST(sampling_and_saving) {
    tracer = "linear";
    for (int k = 1; k < 8; ++k) {
        adaptive = k & 1, timed = k & 2, saved = k & 4;
        exhaust(render, "meshes.json");
    }
    adaptive = timed = saved = false;
}

/* ---- writing ---- */

static fathom_status write_mesh(fathom_context *context, const char *file, outcome *out) {
    fathom_scene *scene;
    fathom_status status = fathom_scene_read(context, in_folder("all.json"), &scene);
    if (status != FATHOM_OK) return status;
    status = fathom_scene_write(scene, in_folder(file));
    fathom_scene_destroy(scene);
    assert_true((access(in_folder(file), F_OK) == 0) == (status == FATHOM_OK));
    unlink(in_folder(file)), unlink(in_folder("made.mtl"));
    add(out, &status, sizeof status);
    return status;
}

static fathom_status write_film(fathom_context *context, const char *file, outcome *out) {
    fathom_scene *scene;
    fathom_film *film;
    fathom_status status = fathom_scene_read(context, in_folder("meshes.json"), &scene);
    if (status != FATHOM_OK) return status;
    fathom_settings settings = settings_of(scene);
    fathom_write_options options = default_write_options();
    settings.tracer = "linear";
    status = fathom_render(context, scene, &settings, NULL, NULL, NULL, &film);
    const bool plain = strcmp(file, "plain.exr") == 0;
    if (status == FATHOM_OK)
        status = plain ? fathom_film_write_plain(context, film, in_folder(file))
                       : fathom_film_write(context, film, in_folder(file), &options);
    assert_true((access(in_folder(file), F_OK) == 0) == (status == FATHOM_OK));
    unlink(in_folder(file));
    fathom_film_destroy(film);
    fathom_scene_destroy(scene);
    add(out, &status, sizeof status);
    return status;
}

UNIT_TEST(writing) {
    exhaust(write_mesh, "made.glb");
    exhaust(write_mesh, "made.ply");
    exhaust(write_mesh, "made.obj");
    exhaust(write_film, "image.png");
    exhaust(write_film, "plain.exr");
}

/* ---- set-up ---- */

static const char meshes_json[] =
    "{ \"camera\": { \"eye\": [0, 0, 5], \"target\": [0, 0, 0], \"fovy\": 40 },\n"
    "  \"lights\": [ { \"type\": \"directional\", \"direction\": [0, -1, -1] } ],\n"
    "  \"image\": { \"width\": 8, \"height\": 6, \"spp\": 4 },\n"
    "  \"materials\": { \"m\": { \"kd\": [0.2, 0.2, 0.2], \"kr\": [0.4, 0.4, 0.4] } },\n"
    "  \"objects\": [ { \"type\": \"generate\", \"kind\": \"sphere\", \"triangles\": 64, \"material\": \"m\" "
    "},\n"
    "    { \"type\": \"sphere\", \"center\": [1, 0, 0], \"radius\": 0.5 } ] }\n";

static int begin(void **state) {
    (void)state;
    requests_begin();
    put("all.json", all_json), put("meshes.json", meshes_json);
    return 0;
}

/* Nothing is left but what was put there. */
static int end(void **state) {
    (void)state;
    unlink(in_folder("all.json")), unlink(in_folder("meshes.json"));
    return rmdir(folder);
}

int main(void) { return unit_main(begin, end); }
