/* Memory that runs out while files are read, rendered and written: requests.h says how. Those of other
 * libraries: tests/cli/oom.sh. */
#include "defaults.h"
#include "scene/scene.h"

#include "requests.h" /* last: cmocka defines words such as fail */

static const char scene_json[] =
    "{ \"name\": \"a name that is longer than the first room for a string\",\n"
    "  \"camera\": { \"eye\": [0, 1.5, 5.12345678901234567], \"target\": [0, 0.7, 0], \"fovy\": 40 },\n"
    "  \"image\": { \"width\": 8, \"height\": 6, \"spp\": 4 }, \"background\": [0.2, 0.3, 0.4],\n"
    "  \"materials\": {\n"
    "    \"chrome\": { \"kd\": [0.1, 0.1, 0.1], \"kr\": [0.8, 0.8, 0.8] },\n"
    "    \"glass\": { \"kd\": [0, 0, 0], \"kt\": [0.9, 0.9, 0.9], \"ior\": 1.5 },\n"
    "    \"floor\": { \"kd\": [0.6, 0.5, 0.4] } },\n"
    "  \"lights\": [ { \"type\": \"point\", \"position\": [2, 4, 3], \"intensity\": 25 },\n"
    "    { \"type\": \"spot\", \"position\": [0, 4, 0], \"direction\": [0, -1, 0], \"intensity\": 9 } ],\n"
    "  \"groups\": { \"pair\": [\n"
    "    { \"type\": \"mesh\", \"file\": \"part.obj\" },\n"
    "    { \"type\": \"sphere\", \"center\": [0.5, 0.8, 0], \"radius\": 0.4, \"material\": \"glass\" } ] },\n"
    "  \"objects\": [\n"
    "    { \"type\": \"sphere\", \"center\": [-0.5, 0.8, 0], \"radius\": 0.5, \"material\": \"chrome\" },\n"
    "    { \"type\": \"quad\", \"center\": [0, 0, 0], \"u\": [3, 0, 0], \"v\": [0, 0, -3], \"material\": "
    "\"floor\" },\n"
    "    { \"type\": \"instance\", \"of\": \"pair\", \"translation\": [0.5, 0, 0] } ] }\n";

static const char part_obj[] = "mtllib part.mtl\nv -1 0 -1\nv 1 0 -1\nv 0 1 -1\nv 0 2 -2\nvn 0 0 1\nvt 0 0\n"
                               "usemtl red\nf 1/1/1 2/1/1 3/1/1\ng other\nusemtl none\nf 1 2 3 4\n";
static const char part_mtl[] = "newmtl red\nKd 0.8 0.1 0.1\nNs 10\nKs 0.2 0.2 0.2\n";
static const char part_ply[] =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
    "3 0 1 2\n4 0 1 2 3\n";
static const char part_gltf[] =
    "{ \"asset\": { \"version\": \"2.0\" }, \"scene\": 0, \"scenes\": [ { \"nodes\": [0] } ],\n"
    "  \"nodes\": [ { \"mesh\": 0, \"children\": [1] }, { \"mesh\": 0, \"translation\": [1, 0, 0] } ],\n"
    "  \"materials\": [ { \"name\": \"red\" } ],\n"
    "  \"meshes\": [ { \"primitives\": [ { \"attributes\": { \"POSITION\": 0 }, \"material\": 0 } ] } ],\n"
    "  \"accessors\": [ { \"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\",\n"
    "    \"min\": [0, 0, 0], \"max\": [1, 1, 0] } ],\n"
    "  \"bufferViews\": [ { \"buffer\": 0, \"byteLength\": 36 } ],\n"
    "  \"buffers\": [ { \"byteLength\": 36, \"uri\": \"data:application/octet-stream;base64,"
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\" } ] }\n";

static fathom_status render(fathom_context *context, const char *file, const char *tracer, outcome *out) {
    fathom_scene *scene;
    fathom_film *film;
    fathom_settings settings;
    fathom_status status = fathom_scene_read(context, in_folder(file), &scene);
    if (status != FATHOM_OK) {
        assert_null(scene);
        return status;
    }
    fathom_scene_settings(scene, &settings);
    settings.width = 8, settings.height = 6, settings.spp = 4;
    settings.aovs = FATHOM_AOV_ALPHA | FATHOM_AOV_Z | FATHOM_AOV_N;
    settings.tracer = tracer;
    status = fathom_render(context, scene, &settings, NULL, NULL, NULL, &film);
    if (status == FATHOM_OK) {
        static const char *const channels[] = {"R", "G", "B", "A", "Z", "N.X"};
        for (size_t c = 0; c < sizeof channels / sizeof *channels; ++c)
            add(out, fathom_film_channel(film, channels[c]), 8 * 6 * sizeof(float));
        fathom_film_destroy(film);
    } else {
        assert_null(film);
    }
    fathom_scene_destroy(scene);
    return status;
}

static fathom_status render_linear(fathom_context *context, const char *file, outcome *out) {
    return render(context, file, "linear", out);
}
static fathom_status render_bvh(fathom_context *context, const char *file, outcome *out) {
    return render(context, file, "bvh", out);
}
static fathom_status render_embree(fathom_context *context, const char *file, outcome *out) {
    return render(context, file, "embree", out);
}
static fathom_status render_user(fathom_context *context, const char *file, outcome *out) {
    return render(context, file, "embree:user", out);
}

static fathom_status write_mesh(fathom_context *context, const char *file, outcome *out) {
    const char *path = in_folder(file);
    fathom_scene *scene;
    unlink(path);
    fathom_status status = fathom_scene_read(context, in_folder("scene.json"), &scene);
    if (status != FATHOM_OK) return status;
    status = fathom_scene_write(scene, path);
    fathom_scene_destroy(scene);
    unsigned long keep = failing;
    failing = 0;
    FILE *made = fopen(path, "rb");
    failing = keep;
    assert_true((made != NULL) == (status == FATHOM_OK));
    char bytes[4096];
    for (size_t got; made && (got = fread(bytes, 1, sizeof bytes, made));) add(out, bytes, got);
    if (made) fclose(made);
    return status;
}

static fathom_status generate(fathom_context *context, const char *file, outcome *out) {
    fathom_scene *scene;
    (void)file;
    fathom_status status = fathom_scene_create(context, &scene);
    if (status != FATHOM_OK) return status;
    fathom_generate_options options = default_generate_options();
    options.kind = FATHOM_GENERATE_FOREST, options.triangles = 3000;
    status = fathom_scene_generate(scene, FATHOM_ROOT, &options);
    if (status == FATHOM_OK) add(out, &scene->instances.count, sizeof scene->instances.count);
    fathom_scene_destroy(scene);
    return status;
}

static fathom_status trace(fathom_context *context, const char *file, outcome *out) {
    fathom_scene *scene;
    fathom_tracer *tracer;
    fathom_status status = fathom_scene_read(context, in_folder(file), &scene);
    if (status != FATHOM_OK) return status;
    status = fathom_tracer_create(context, scene, "reference", &tracer);
    if (status == FATHOM_OK) {
        fathom_ray rays[20];
        fathom_hit hits[20];
        bool met[20];
        for (int i = 0; i < 20; ++i)
            rays[i] = (fathom_ray){{0, 1.5, 5}, {0.1 * (i - 10), -0.1, -1}, 0, (double)INFINITY};
        status = fathom_tracer_closest(tracer, rays, 20, hits);
        if (status == FATHOM_OK) status = fathom_tracer_any(tracer, rays, 20, met);
        for (int i = 0; i < 20 && status == FATHOM_OK; ++i) add(out, &hits[i].t, sizeof hits[i].t);
        fathom_tracer_destroy(tracer);
    } else {
        assert_null(tracer);
    }
    fathom_scene_destroy(scene);
    return status;
}

UNIT_TEST(reading_and_rendering) {
    exhaust(render_linear, "scene.json");
    exhaust(render_linear, "part.obj");
    exhaust(render_linear, "part.ply");
    exhaust(render_linear, "part.gltf");
    exhaust(render_linear, "part.glb");
}

UNIT_TEST(tracers) {
    exhaust(render_bvh, "scene.json");
    exhaust(render_embree, "scene.json");
    exhaust(render_user, "scene.json");
    exhaust(trace, "scene.json");
}

UNIT_TEST(writing_and_generating) {
    exhaust(write_mesh, "made.glb");
    exhaust(write_mesh, "made.ply");
    exhaust(write_mesh, "made.obj");
    exhaust(generate, "forest");
}

static int set_up(void **state) {
    (void)state;
    requests_begin();
    put("scene.json", scene_json), put("part.obj", part_obj), put("part.mtl", part_mtl);
    put("part.ply", part_ply), put("part.gltf", part_gltf);
    fathom_context *context;
    fathom_scene *scene;
    assert_int_equal(fathom_context_create(&context), FATHOM_OK);
    assert_ok(context, fathom_scene_read(context, in_folder("part.gltf"), &scene));
    assert_ok(context, fathom_scene_write(scene, in_folder("part.glb")));
    fathom_scene_destroy(scene);
    fathom_context_destroy(context);
    return 0;
}

/* Nothing is left but what was put there. */
static int tear_down(void **state) {
    (void)state;
    static const char *const names[] = {"scene.json", "part.obj", "part.mtl", "part.ply", "part.gltf",
                                        "part.glb",   "made.glb", "made.ply", "made.obj", "made.mtl"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) unlink(in_folder(names[i]));
    return rmdir(folder);
}

int main(void) { return unit_main(set_up, tear_down); }
