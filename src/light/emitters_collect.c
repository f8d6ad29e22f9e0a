/* Finds all emitters, and puts the finite ones into a tree. Emissive planes are left to BSDF samples: their
 * light comes from half of all directions. */
#include "light/emitters_inner.h"

#include "base/kernel.h"
#include "base/memory.h"
#include "light/light.h"

#include <stdlib.h>
#include <string.h>

KERNEL_BEST(shape_kernels)

/* ---- materials ---- */

/* Drops the textures if no emission varies, because scenes with a single even light are faster. */
static bool find_emission(emitters *e) {
    const fathom_scene *scene = e->w->scene;
    bool varies = false;
    e->emission = calloc(scene->materials.count, sizeof *e->emission);
    for (size_t i = 0; e->emission && i < scene->materials.count; ++i) {
        shader_emission(&scene->materials.items[i].value, e->emission[i]);
        varies |= e->texturing && luminance(e->emission[i]) > 0 &&
                  texturing_varies_emission(e->texturing, (fathom_id)i);
    }
    if (!varies) e->texturing = NULL;
    return e->emission != NULL;
}

/* ---- runs ---- */

/* True if it moves while the shutter is open. */
static bool is_moving(const world *w, uint32_t geometry, uint32_t instance) {
    return w->geometries.items[geometry].moving ||
           (instance != FATHOM_NONE && w->instances.items[instance].moving);
}

/* All triangles of a mesh have one material. */
static bool emits(const emitters *e, uint32_t geometry, uint32_t instance) {
    const world_geometry *g = &e->w->geometries.items[geometry];
    const uint32_t looks = g->kind == WORLD_MESH ? 1 : g->count;
    for (uint32_t i = 0; i < looks; ++i) {
        if (emitters_power(e, geometry, i, instance) > 0) return true;
    }
    return false;
}

typedef ARRAY(emitter_run) run_list;

/* Adds the runs of a group's geometries, including those that emit nothing; adds none if nothing in the group
 * emits. */
static bool add_runs(emitters *e, run_list *runs, uint32_t group, uint32_t instance) {
    const world_group *g = &e->w->groups.items[group];
    const size_t before = runs->count;
    bool any = false;
    for (uint32_t k = g->first; k < g->first + g->count; ++k) {
        emitter_run run = {.geometry = k, .instance = instance};
        if (emits(e, k, instance)) {
            run.count = e->w->geometries.items[k].count;
            e->moving |= is_moving(e->w, k, instance);
        }
        any |= run.count > 0;
        if (!array_push(runs, run)) return false;
    }
    if (!any) runs->count = before;
    return true;
}

static bool find_runs(emitters *e) {
    const world *w = e->w;
    run_list runs = {.items = NULL};
    e->run_of = malloc((w->instances.count + 1) * sizeof *e->run_of);
    bool fine = e->run_of != NULL;
    e->run_of += fine; /* run_of[-1]: the root */
    for (size_t i = 0; fine && i <= w->instances.count; ++i) {
        const uint32_t instance = i ? (uint32_t)(i - 1) : FATHOM_NONE;
        const size_t before = runs.count;
        fine = add_runs(e, &runs, i ? w->instances.items[i - 1].group : 0, instance);
        e->run_of[(ptrdiff_t)i - 1] = runs.count > before ? (uint32_t)before : FATHOM_NONE;
    }
    e->runs = runs.items, e->run_count = (uint32_t)runs.count;
    return fine;
}

/* Returns the number of emitters. */
static uint64_t number_runs(emitters *e) {
    uint64_t total = 0;
    for (uint32_t r = 0; r < e->run_count; ++r) {
        e->runs[r].first = (uint32_t)total;
        total += e->runs[r].count;
    }
    return total;
}

const emitter_run *emitters_run(const emitters *e, uint32_t geometry, uint32_t instance) {
    const bool root = instance == FATHOM_NONE;
    if (geometry >= e->w->geometries.count) return NULL; /* a plane, or no hit */
    const uint32_t first = e->run_of[root ? (ptrdiff_t)-1 : (ptrdiff_t)instance];
    if (first == FATHOM_NONE) return NULL;
    const uint32_t group = root ? 0 : e->w->instances.items[instance].group;
    const emitter_run *run = &e->runs[first + (geometry - e->w->groups.items[group].first)];
    return run->count ? run : NULL;
}

const emitter_run *emitters_run_of(const emitters *e, uint32_t emitter) {
    uint32_t low = 0, high = e->run_count;
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (e->runs[middle].first <= emitter)
            low = middle;
        else
            high = middle;
    }
    return &e->runs[low];
}

/* ---- lamps and suns ---- */

static void sort_suns(emitters *e) {
    for (uint32_t i = 0; i < e->sun_count; ++i) {
        const emitter_sun sun = e->suns[i];
        if (!(sun.cap > 0)) continue;
        e->suns[i] = e->suns[e->disc_count];
        e->suns[e->disc_count++] = sun;
    }
}

static bool sort_lights(emitters *e) {
    const fathom_scene *scene = e->w->scene;
    const size_t count = scene_replaces_lights(scene) ? 0 : scene->lights.count;
    e->lamps = calloc(count + 1, sizeof *e->lamps);
    e->suns = calloc(count + 1, sizeof *e->suns);
    if (!e->lamps || !e->suns) return false;
    for (size_t i = 0; i < count; ++i) {
        const fathom_light *light = &scene->lights.items[i];
        const uint8_t group = e->groups ? e->groups->of[FATHOM_SOURCE_LIGHT][i] : 0;
        shade_light made;
        if (!(luminance(light->intensity) > 0)) continue;
        light_prepare(light, e->w->origin, &made);
        if (light->type != FATHOM_LIGHT_DIRECTIONAL) {
            e->lamps[e->lamp_count++] =
                (emitter_lamp){.light = made, .radius = light->radius, .group = group};
            continue;
        }
        emitter_sun *sun = &e->suns[e->sun_count++];
        sun->group = group;
        const double half = sin((double)light->angular_radius / 2);
        sun->to_light = made.to_light, sun->cap = 2 * half * half;
        for (int c = 0; c < 3; ++c) sun->irradiance[c] = (float)SHAPE_PI * light->intensity[c];
    }
    sort_suns(e);
    /* Shapes that cast no shadow let the light of suns and lamps pass, but not the rays that would find them:
     * there light samples count alone. */
    e->found = world_casts_all_shadows(e->w);
    return emitters_prepare_lamps(e);
}

static void share_among_suns(emitters *e) {
    double sum = 0, below = 0;
    for (uint32_t i = 0; i < e->sun_count; ++i) sum += (double)luminance(e->suns[i].irradiance);
    for (uint32_t i = 0; i < e->sun_count; ++i) {
        e->suns[i].chance = (double)luminance(e->suns[i].irradiance) / sum;
        e->suns[i].below = below;
        below += e->suns[i].chance;
    }
}

static fathom_status find_lamp_surfaces(fathom_context *context, emitters *e) {
    if (!e->lamp_count) return FATHOM_OK;
    shade_light *lights = malloc(e->lamp_count * sizeof *lights);
    bool *in_mesh = calloc(e->lamp_count, sizeof *in_mesh);
    fathom_status status = lights && in_mesh ? FATHOM_OK : fail_memory(context, e->lamp_count);
    if (status == FATHOM_OK) {
        for (uint32_t i = 0; i < e->lamp_count; ++i) lights[i] = e->lamps[i].light;
        vec3_f32 eye = narrow(sub_f64(load_f64(e->w->scene->camera.origin), e->w->origin));
        status = light_surfaces_find(context, e->w, eye, lights, e->lamp_count, in_mesh, &e->surfaces);
    }
    for (uint32_t i = 0; status == FATHOM_OK && i < e->lamp_count; ++i) e->lamps[i].light = lights[i];
    free(lights);
    free(in_mesh);
    return status;
}

/* ---- from outside ---- */

/* Luminance times solid angle. */
static double background_power(const emitters *e) { return 4 * SHAPE_PI * (double)luminance(e->background); }

static double outside_power(const emitters *e) {
    double sum = background_power(e);
    for (uint32_t i = 0; i < e->sky_count; ++i) sum += environment_power(e->skies[i].image);
    return sum;
}

static void share_outside(emitters *e) {
    const double all = outside_power(e);
    for (uint32_t i = 0; i < e->sky_count; ++i)
        e->skies[i].chance = all > 0 ? environment_power(e->skies[i].image) / all : 0;
    e->background_chance = all > 0 ? background_power(e) / all : 0;
}

/* Reads the environments. */
static fathom_status emitters_open_skies(fathom_context *context, emitters *e) {
    const fathom_scene *scene = e->w->scene;
    fathom_status status = FATHOM_OK;
    e->skies = calloc(scene->environments.count + 1, sizeof *e->skies);
    if (!e->skies) return fail_memory(context, sizeof *e->skies);
    if (scene->in_studio) {
        status = environment_studio(context, load_f64(scene->camera.z), scene->studio_up, &e->skies[0].image);
        e->sky_count += status == FATHOM_OK;
    }
    for (size_t i = 0; i < scene->environments.count && status == FATHOM_OK; ++i) {
        status = environment_open(context, scene, (fathom_id)i, &e->skies[i].image);
        e->sky_count += status == FATHOM_OK;
    }
    share_outside(e);
    return status;
}

/* Environments and background add up. */
void emitters_brightest_outside(const emitters *e, float out[3]) {
    memcpy(out, e->background, sizeof e->background);
    for (uint32_t i = 0; i < e->sky_count; ++i) {
        float more[3];
        environment_brightest(e->skies[i].image, more);
        for (int c = 0; c < 3; ++c) out[c] += more[c];
    }
}

/* ---- the whole ---- */

static fathom_status build_tree(fathom_context *context, emitters *e, uint32_t total) {
    const size_t bytes = total * (sizeof(tree_item) + sizeof *e->slot_of);
    e->slot_of = memory_has(bytes) ? malloc((total + (size_t)1) * sizeof *e->slot_of) : NULL;
    tree_item *items = e->slot_of ? malloc((total + (size_t)1) * sizeof *items) : NULL;
    bool fine = items != NULL;
    if (fine) {
        e->finite_count = emitters_list_items(e, items);
        e->only = e->finite_count == 1 ? items[0].light : FATHOM_NONE;
        fine = tree_build(items, e->finite_count, &e->lights, e->slot_of);
    }
    free(items);
    return fine ? FATHOM_OK : fail_memory(context, bytes);
}

static fathom_status collect(fathom_context *context, emitters *e) {
    if (!find_emission(e) || !find_runs(e) || !sort_lights(e)) return fail_memory(context, 1 << 20);
    emitters_divide_runs(e);
    emitters_pair_runs(e);
    const uint64_t total = number_runs(e);
    if (total + e->lamp_count >= TREE_LEAF / TREE_WIDE) {
        return fail(
            context, FATHOM_OUT_OF_RESOURCES,
            "the scene holds %.3g emissive primitives, instances counted; at most 2^28 can be sampled",
            (double)total);
    }
    e->surface_count = (uint32_t)total;
    share_among_suns(e);
    fathom_status status = find_lamp_surfaces(context, e);
    return status == FATHOM_OK ? build_tree(context, e, e->surface_count + e->lamp_count) : status;
}

static bool from_outside(const emitters *e) {
    double sum = e->background_chance;
    for (uint32_t i = 0; i < e->sky_count; ++i) sum += e->skies[i].chance;
    return sum > 0;
}

/* Each class has the same probability, until scout paths find better ones. A background without images is
 * even: scattered rays find it as well as light samples do. So light samples go to the other lights, if
 * there are any. */
void emitters_share(emitters *e) {
    bool there[EMITTER_PARTS] = {e->finite_count > 0, from_outside(e), e->sun_count > 0};
    if (there[EMITTER_FINITE] || there[EMITTER_DIRECTIONAL]) there[EMITTER_OUTSIDE] &= e->sky_count > 0;
    const int parts = there[EMITTER_FINITE] + there[EMITTER_OUTSIDE] + there[EMITTER_DIRECTIONAL];
    for (int k = 0; k < EMITTER_PARTS; ++k) e->shares.of[k] = there[k] ? 1.0 / parts : 0;
}

fathom_status emitters_create(fathom_context *context, const world *w, const texturing *varied,
                              const light_groups *groups, emitters **out) {
    *out = NULL;
    emitters *e = calloc(1, sizeof *e);
    if (!e) return fail_memory(context, sizeof *e);
    e->w = w, e->texturing = varied, e->groups = groups;
    e->shapes = shape_kernels_best(), e->points = light_kernels_best();
    if (!w->scene->in_studio) memcpy(e->background, w->scene->background, sizeof e->background);
    fathom_status status = collect(context, e);
    if (status == FATHOM_OK) status = emitters_open_skies(context, e);
    emitters_share(e);
    if (status == FATHOM_OK && (!emitters_prepare_one(e) || !emitters_prepare_ready(e)))
        status = fail_memory(context, sizeof *e->one.face + e->surface_count * sizeof *e->ready);
    if (status != FATHOM_OK) {
        emitters_destroy(e);
        return status;
    }
    emitters_note_groups(e, groups);
    *out = e;
    return FATHOM_OK;
}

void emitters_destroy(emitters *e) {
    if (!e) return;
    tree_destroy(&e->lights);
    tree_destroy(&e->spheres);
    if (e->run_of) free(e->run_of - 1);
    free(e->emission);
    free(e->one.face);
    free(e->ready);
    free(e->runs);
    free(e->slot_of);
    free(e->lamps);
    free(e->surfaces);
    free(e->suns);
    for (uint32_t i = 0; i < e->sky_count; ++i) environment_destroy(e->skies[i].image);
    free(e->skies);
    free(e->seen.splits);
    free(e->seen.tables);
    emitters_forget_views(e);
    free(e->splits);
    free(e->regions);
    free(e);
}

bool emitters_any_outside(const emitters *e) {
    return from_outside(e) || (e->shares.of[EMITTER_DIRECTIONAL] > 0 && e->disc_count);
}

bool emitters_any_skies(const emitters *e) { return e->sky_count > 0; }

bool emitters_choose_finite(const emitters *e) { return e->finite_count > 1; }

bool emitters_move(const emitters *e) { return e->moving; }

bool emitters_none(const emitters *e) {
    double sum = 0;
    for (int k = 0; k < EMITTER_PARTS; ++k) sum += e->shares.of[k];
    return !(sum > 0);
}
