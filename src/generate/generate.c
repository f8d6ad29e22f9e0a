/* Generated meshes: the kinds, their limits, and the check against free memory. */
#include "generate/generate.h"

#include "base/memory.h"
#include "base/sized.h"

#include <inttypes.h>

SIZED_DEFAULT_OWN(fathom_generate_options, {.kind = FATHOM_GENERATE_SPHERE, .triangles = 1000000})

fathom_status generate_allocate(fathom_scene *scene, uint32_t vertices, uint32_t triangles, unsigned arrays,
                                generate_mesh *out) {
    size_t vectors = (size_t)vertices * 3, normals = arrays & GENERATE_NORMALS ? vectors : 0;
    size_t uvs = arrays & GENERATE_UVS ? (size_t)vertices * 2 : 0, corners = (size_t)triangles * 3;
    size_t bytes = (vectors + normals + uvs) * sizeof(float) + corners * sizeof(uint32_t);
    size_t room = memory_free();
    if (bytes > room) {
        return fail(scene->context, FATHOM_OUT_OF_RESOURCES,
                    "%" PRIu32 " generated triangles take %.1f GiB of memory, and %.1f GiB are free",
                    triangles, (double)bytes * 0x1p-30, (double)room * 0x1p-30);
    }
    void *data;
    fathom_status status = scene_allocate(scene, bytes, &data);
    if (status != FATHOM_OK) return status;
    float *numbers = data;
    *out = (generate_mesh){.positions = numbers,
                           .normals = normals ? numbers + vectors : NULL,
                           .uvs = uvs ? numbers + vectors + normals : NULL,
                           .vertex_count = vertices,
                           .triangle_count = triangles};
    out->indices = (uint32_t *)data + vectors + normals + uvs;
    return FATHOM_OK;
}

fathom_status generate_finish(fathom_scene *scene, fathom_id group, const generate_mesh *mesh,
                              fathom_id material) {
    fathom_mesh m;
    fathom_mesh_default(&m);
    m.positions = mesh->positions, m.vertex_count = mesh->vertex_count;
    m.indices = mesh->indices, m.triangle_count = mesh->triangle_count;
    m.normals = mesh->normals, m.normal_count = mesh->normals ? mesh->vertex_count : 0;
    m.uvs = mesh->uvs, m.uv_count = mesh->uvs ? mesh->vertex_count : 0;
    m.material = material == FATHOM_NONE ? 0 : material;
    return fathom_scene_add_mesh_shared(scene, group, &m, NULL);
}

void generate_rows(const fathom_scene *scene, size_t rows, size_t row_size, loop_body body, void *job) {
    size_t grain = 8192 / (row_size ? row_size : 1);
    loop_parallel(fathom_context_threads(scene->context), rows, grain, body, job);
}

uint32_t generate_nearest_square(uint64_t triangles, uint32_t factor) {
    uint64_t n = (uint64_t)sqrt((double)triangles / factor);
    while (n && factor * n * n > triangles) --n;
    while (factor * (n + 1) * (n + 1) <= triangles) ++n;
    /* Now factor n² <= triangles < factor (n+1)². */
    if (!n || triangles - factor * n * n > factor * (n + 1) * (n + 1) - triangles) ++n;
    return (uint32_t)n;
}

/* Kinds of one mesh are limited by 32-bit indices, kinds of instances by a million instances of the largest
 * part. */
static const struct {
    const char *name;
    uint64_t most;
    fathom_status (*make)(fathom_scene *scene, fathom_id group, const fathom_generate_options *options);
} generators[] = {
    [FATHOM_GENERATE_SPHERE] = {"sphere", 4000000000u, generate_sphere},
    [FATHOM_GENERATE_TERRAIN] = {"terrain", 4000000000u, generate_terrain},
    [FATHOM_GENERATE_SPONGE] = {"sponge", 100000000000u, generate_sponge},
    [FATHOM_GENERATE_FOREST] = {"forest", 100000000000u, generate_forest},
};

static fathom_status check_options(const fathom_scene *scene, fathom_id group,
                                   const fathom_generate_options *options) {
    fathom_context *context = scene->context;
    size_t kind = (size_t)options->kind;
    if (kind >= sizeof generators / sizeof *generators)
        return fail(context, FATHOM_BAD_USAGE, "generate: there is no kind %zu", kind);
    if (group >= scene->groups.count)
        return fail(context, FATHOM_BAD_USAGE, "generate: there is no group %u", group);
    if (options->material != FATHOM_NONE && options->material >= scene->materials.count)
        return fail(context, FATHOM_BAD_USAGE, "generate: there is no material %u", options->material);
    if (options->triangles < 1 || options->triangles > generators[kind].most) {
        return fail(context, FATHOM_BAD_USAGE,
                    "generate %s: triangles: expected 1 to %" PRIu64 ", found %" PRIu64,
                    generators[kind].name, generators[kind].most, options->triangles);
    }
    return FATHOM_OK;
}

fathom_status fathom_scene_generate(fathom_scene *scene, fathom_id group,
                                    const fathom_generate_options *options) {
    if (!scene) return FATHOM_BAD_USAGE;
    fathom_generate_options asked;
    fathom_status status = SIZED_OWN(scene->context, fathom_generate_options, options, &asked);
    if (status == FATHOM_OK) status = check_options(scene, group, &asked);
    return status == FATHOM_OK ? generators[asked.kind].make(scene, group, &asked) : status;
}
