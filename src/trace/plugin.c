/* A tracer from a shared library: loads it, passes the world's triangles to it as one mesh, and converts
 * blocks of rays and hits. */
#include "trace/search.h"
#include "trace/tracer.h"

#include <fathom/plugin.h>

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Blocks per call. */
#define BATCH 8

/* Triangles of some or all of the world's geometries as one mesh, and the library's data for them. */
typedef struct plugin_part {
    float *positions;
    uint32_t *indices;
    uint32_t vertex_count, triangle_count;
    uint32_t *first;    /* first triangle of each geometry in this mesh */
    uint32_t *geometry; /* the world's index of each; parallel to first */
    uint32_t geometry_count;
    bool built;
    void *data;
} plugin_part;

typedef struct plugin_tracer {
    trace_tracer base;
    void *library;
    const fathom_plugin *plugin;
    plugin_part all, shadows; /* shadows: the geometries that cast shadows, if not all do */
    bool own_shadows;
} plugin_tracer;

/* ---- the library ---- */

/* dlopen() would block on a pipe. */
static bool is_file_or_none(const char *path) {
    struct stat info;
    return stat(path, &info) != 0 || S_ISREG(info.st_mode);
}

static fathom_status load(fathom_context *context, const char *path, plugin_tracer *tracer) {
    char local[4096]; /* without a slash, dlopen() would search the system's folders */
    if (!strchr(path, '/')) {
        snprintf(local, sizeof local, "./%s", path);
        path = local;
    }
    if (!is_file_or_none(path))
        return fail(context, FATHOM_BAD_INPUT, "tracer %s: cannot be loaded: is not a regular file", path);
    tracer->library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!tracer->library)
        return fail(context, FATHOM_BAD_INPUT, "tracer %s: cannot be loaded: %s", path, dlerror());
    fathom_plugin_get_fn get;
    void *symbol = dlsym(tracer->library, "fathom_plugin_get");
    if (!symbol) {
        return fail(context, FATHOM_BAD_INPUT,
                    "tracer %s: has no function fathom_plugin_get(); expected one as in fathom/plugin.h",
                    path);
    }
    memcpy(&get, &symbol, sizeof get); /* C cannot convert object pointers to function pointers */
    const fathom_plugin *p = tracer->plugin = get();
    if (!p || p->version != FATHOM_PLUGIN_VERSION) {
        return fail(context, FATHOM_BAD_INPUT, "tracer %s: is of version %u; expected %u", path,
                    p ? p->version : 0, FATHOM_PLUGIN_VERSION);
    }
    if (!p->name || !p->build || !p->closest || !p->any || !p->destroy || !(p->unit > 0 && p->unit < 1)) {
        return fail(context, FATHOM_BAD_INPUT,
                    "tracer %s: its table is not complete; expected name, unit and four functions", path);
    }
    return FATHOM_OK;
}

/* ---- the mesh ---- */

static fathom_status only_triangles(fathom_context *context, const world *w) {
    const char *what = w->instances.count ? "instances" : NULL;
    for (size_t g = 0; g < w->geometries.count && !what; ++g) {
        switch (w->geometries.items[g].kind) {
        case WORLD_SPHERES: what = w->geometries.items[g].cloud ? "points" : "spheres"; break;
        case WORLD_QUADS: what = "quads"; break;
        case WORLD_MESH: break;
        }
    }
    if (!what) return FATHOM_OK;
    return fail(context, FATHOM_BAD_USAGE,
                "a tracer from a library takes only triangles, and the scene has %s; expected meshes that "
                "are placed in the world once, without a frame or an origin of their own",
                what);
}

static bool chosen(const world *w, uint32_t geometry, bool shadows) {
    return !(shadows && w->geometries.items[geometry].flags & FATHOM_CASTS_NO_SHADOW);
}

static void copy_mesh(plugin_part *part, const fathom_mesh *mesh) {
    float *to = part->positions + 3 * (size_t)part->vertex_count;
    for (uint32_t i = 0; i < mesh->vertex_count; ++i)
        memcpy(to + 3 * (size_t)i, mesh_vertex(mesh, i), 3 * sizeof *to);
    uint32_t *index = part->indices + 3 * (size_t)part->triangle_count;
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; ++i)
        index[i] = mesh->indices[i] + part->vertex_count;
    part->vertex_count += mesh->vertex_count;
    part->triangle_count += mesh->triangle_count;
}

static fathom_status gather(fathom_context *context, const world *w, bool shadows, plugin_part *part) {
    uint64_t vertices = 0, triangles = 0;
    for (uint32_t g = 0; g < w->geometries.count; ++g) {
        const fathom_mesh *mesh = world_mesh(w, g);
        if (chosen(w, g, shadows)) vertices += mesh->vertex_count, triangles += mesh->triangle_count;
    }
    if (vertices > UINT32_MAX || triangles >= FATHOM_PLUGIN_MISS) {
        return fail(
            context, FATHOM_BAD_USAGE,
            "a tracer from a library counts to 2^32, and the scene has %llu vertices and %llu triangles",
            (unsigned long long)vertices, (unsigned long long)triangles);
    }
    part->positions = calloc(1, vertices * 3 * sizeof(float) + 16);
    part->indices = malloc(triangles * 3 * sizeof(uint32_t) + 1);
    part->first = malloc((w->geometries.count + 1) * sizeof *part->first);
    part->geometry = malloc((w->geometries.count + 1) * sizeof *part->geometry);
    if (!part->positions || !part->indices || !part->first || !part->geometry)
        return fail_memory(context, (vertices + triangles) * 3 * sizeof(float));
    for (uint32_t g = 0; g < w->geometries.count; ++g) {
        const fathom_mesh *mesh = world_mesh(w, g);
        if (!chosen(w, g, shadows) || !mesh->triangle_count) continue;
        part->first[part->geometry_count] = part->triangle_count;
        part->geometry[part->geometry_count++] = g;
        copy_mesh(part, mesh);
    }
    return FATHOM_OK;
}

static fathom_status build(fathom_context *context, plugin_tracer *tracer, unsigned threads, bool shadows,
                           plugin_part *part) {
    fathom_status status = gather(context, tracer->base.world, shadows, part);
    if (status != FATHOM_OK) return status;
    const fathom_plugin_mesh mesh = {part->positions, part->indices, part->vertex_count,
                                     part->triangle_count};
    char message[512] = "";
    if (tracer->plugin->build(&mesh, threads, message, sizeof message, &part->data) != 0) {
        message[sizeof message - 1] = '\0';
        return fail(context, FATHOM_BAD_INPUT, "tracer %.63s: cannot build: %s", tracer->plugin->name,
                    message[0] ? message : "it gave no reason");
    }
    part->built = true;
    return FATHOM_OK;
}

/* ---- blocks ---- */

/* A sum of products with zero is zero exactly when all are finite. */
static bool usable(const trace_rays *r, unsigned i) {
    float zero = r->org_x[i] * 0 + r->org_y[i] * 0 + r->org_z[i] * 0 + r->dir_x[i] * 0 + r->dir_y[i] * 0 +
                 r->dir_z[i] * 0;
    return zero == 0 && r->t_near[i] < r->t_far[i];
}

static void block_load(const trace_rays *r, unsigned lanes, fathom_plugin_block *to) {
    memcpy(to->org_x, r->org_x, sizeof r->org_x), memcpy(to->org_y, r->org_y, sizeof r->org_y);
    memcpy(to->org_z, r->org_z, sizeof r->org_z), memcpy(to->dir_x, r->dir_x, sizeof r->dir_x);
    memcpy(to->dir_y, r->dir_y, sizeof r->dir_y), memcpy(to->dir_z, r->dir_z, sizeof r->dir_z);
    memcpy(to->t_near, r->t_near, sizeof r->t_near), memcpy(to->t_far, r->t_far, sizeof r->t_far);
    to->active = 0;
    for (unsigned i = 0; i < lanes; ++i) to->active |= (uint32_t)usable(r, i) << i;
    for (unsigned i = 0; i < LANES; ++i) to->primitive[i] = FATHOM_PLUGIN_MISS;
}

/* Index in `first` of the geometry that contains the triangle. */
static uint32_t part_of(const plugin_part *part, uint32_t triangle) {
    uint32_t low = 0, high = part->geometry_count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (part->first[middle] <= triangle)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* An invalid triangle number counts as a miss. */
static void lane_store(const plugin_tracer *tracer, const fathom_plugin_block *from, unsigned i,
                       trace_block *to, trace_fine *fine) {
    const world *w = tracer->base.world;
    uint32_t triangle = from->primitive[i];
    to->hits.geometry[i] = FATHOM_NONE;
    if (!(from->active >> i & 1) || triangle >= tracer->all.triangle_count) return;
    uint32_t part = part_of(&tracer->all, triangle);
    to->hits.geometry[i] = tracer->all.geometry[part];
    to->hits.primitive[i] = triangle - tracer->all.first[part];
    to->hits.instance[i] = FATHOM_NONE;
    to->hits.u[i] = (float)from->u[i], to->hits.v[i] = (float)from->v[i];
    to->rays.t_far[i] = (float)from->t[i];
    vec3_f32 v[3];
    search_corners(world_mesh(w, to->hits.geometry[i]), to->hits.primitive[i], v);
    vec3_f32 n = cross_f32(sub_f32(v[1], v[0]), sub_f32(v[2], v[0]));
    to->hits.ng_x[i] = n.x, to->hits.ng_y[i] = n.y, to->hits.ng_z[i] = n.z;
    if (!fine) return;
    fine->t[i] = from->t[i], fine->t_low[i] = 0, fine->u[i] = from->u[i], fine->v[i] = from->v[i];
}

/* Closest hits of `blocks`, or any hits of `rays` if blocks is NULL. */
static void ask(const plugin_tracer *tracer, const plugin_part *part, trace_block *blocks, trace_rays *rays,
                trace_fine *fine, size_t count) {
    size_t total = (count + LANES - 1) / LANES;
    fathom_plugin_block batch[BATCH];
    for (size_t first = 0; first < total; first += BATCH) {
        size_t n = total - first < BATCH ? total - first : BATCH;
        for (size_t b = first; b < first + n; ++b)
            block_load(blocks ? &blocks[b].rays : &rays[b], trace_lanes(count, b), &batch[b - first]);
        (blocks ? tracer->plugin->closest : tracer->plugin->any)(part->data, batch, n);
        for (size_t b = first; b < first + n; ++b) {
            const fathom_plugin_block *from = &batch[b - first];
            for (unsigned i = 0; i < trace_lanes(count, b); ++i) {
                if (blocks)
                    lane_store(tracer, from, i, &blocks[b], fine ? &fine[b] : NULL);
                else if (from->active >> i & 1 && from->primitive[i] < part->triangle_count)
                    rays[b].t_far[i] = -INFINITY;
            }
        }
    }
}

static void plugin_closest(const trace_tracer *base, trace_block *blocks, trace_fine *fine, size_t count,
                           trace_coherence coherence) {
    (void)coherence;
    const plugin_tracer *tracer = (const plugin_tracer *)base;
    ask(tracer, &tracer->all, blocks, NULL, fine, count);
}

static void plugin_any(const trace_tracer *base, trace_rays *blocks, size_t count,
                       trace_coherence coherence) {
    (void)coherence;
    const plugin_tracer *tracer = (const plugin_tracer *)base;
    ask(tracer, tracer->own_shadows ? &tracer->shadows : &tracer->all, NULL, blocks, NULL, count);
}

/* ---- life ---- */

static void part_free(plugin_tracer *tracer, plugin_part *part) {
    if (part->built) tracer->plugin->destroy(part->data);
    free(part->positions);
    free(part->indices);
    free(part->first);
    free(part->geometry);
}

static void plugin_destroy(trace_tracer *base) {
    plugin_tracer *tracer = (plugin_tracer *)base;
    part_free(tracer, &tracer->all);
    part_free(tracer, &tracer->shadows);
    if (tracer->library) dlclose(tracer->library);
    free(tracer);
}

fathom_status plugin_create(fathom_context *context, const world *w, const trace_spec *spec,
                            const trace_options *options, trace_tracer **out) {
    static const trace_ops ops = {plugin_destroy, plugin_closest, plugin_any, true, false};
    plugin_tracer *tracer = calloc(1, sizeof *tracer);
    if (!tracer) return fail_memory(context, sizeof *tracer);
    tracer->base.ops = &ops;
    tracer->base.world = w;
    unsigned threads = options->threads ? options->threads : fathom_context_threads(context);
    for (uint32_t g = 0; g < w->geometries.count; ++g) tracer->own_shadows |= !chosen(w, g, true);
    fathom_status status = load(context, spec->path, tracer);
    if (status == FATHOM_OK) status = only_triangles(context, w);
    if (status == FATHOM_OK) status = build(context, tracer, threads, false, &tracer->all);
    if (status == FATHOM_OK && tracer->own_shadows)
        status = build(context, tracer, threads, true, &tracer->shadows);
    if (status != FATHOM_OK) {
        plugin_destroy(&tracer->base);
        return status;
    }
    tracer->base.unit = tracer->plugin->unit;
    snprintf(tracer->base.name, sizeof tracer->base.name, "%.63s", tracer->plugin->name);
    *out = &tracer->base;
    return FATHOM_OK;
}
