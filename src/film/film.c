#include "film/film.h"

#include "base/memory.h"
#include "scene/motion/motion.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static float *add_channel(fathom_film *film, const char *name, bool is_id, bool color) {
    /* float and uint32_t are both four bytes, so one allocation serves both. */
    float *data = film->pixels + film->channel_count * (size_t)film->width * film->height;
    film->channels[film->channel_count++] = (film_channel){name, name, is_id, color, data};
    return data;
}

static void add_three(fathom_film *film, float *out[3], const char *a, const char *b, const char *c,
                      bool color) {
    out[0] = add_channel(film, a, false, color);
    out[1] = add_channel(film, b, false, color);
    out[2] = add_channel(film, c, false, color);
}

/* Blender takes the text after the last dot as the name of a component, and reads only components of one
 * letter. */
static uint32_t *add_id(fathom_film *film, const char *name, const char *name_in_file) {
    uint32_t *data = (uint32_t *)(void *)add_channel(film, name, true, false);
    film->channels[film->channel_count - 1].name_in_file = name_in_file;
    return data;
}

static uint32_t group_count(const light_group_names *groups) { return groups->count ? groups->count : 1; }

/* Adds layers in the order of film_parts. */
static void add_layers(fathom_film *film) {
    static const char *const names[LIGHT_KINDS][3] = {{"emission.R", "emission.G", "emission.B"},
                                                      {"direct.R", "direct.G", "direct.B"},
                                                      {"indirect.R", "indirect.G", "indirect.B"}};
    const film_parts parts = film->parts;
    float *layer[3];
    film->layers = film->pixels + film->channel_count * (size_t)film->width * film->height;
    for (int k = 0; k < LIGHT_KINDS; ++k) {
        if (parts.kinds[k] >= 0) add_three(film, layer, names[k][0], names[k][1], names[k][2], true);
    }
    for (uint32_t g = 0; parts.groups >= 0 && g < group_count(&film->light_groups); ++g) {
        const char *name = g ? film->light_groups.names[g] : LIGHT_GROUP_REST;
        for (int c = 0; c < 3; ++c)
            snprintf(film->group_channels[g][c], sizeof film->group_channels[g][c], "light_%s.%c", name,
                     "RGB"[c]);
        add_three(film, layer, film->group_channels[g][0], film->group_channels[g][1],
                  film->group_channels[g][2], true);
    }
    for (uint32_t k = 0; k < 3 * parts.cascades; ++k) add_channel(film, NULL, false, false);
}

static void add_mattes(fathom_film *film) {
#define LAYER(name) name ".R", name ".G", name ".B", name ".A"
#define LAYERS(name) LAYER(name "00"), LAYER(name "01"), LAYER(name "02")
    static const char *const names[MATTE_KINDS][2 * MATTE_RANKS] = {
        [MATTE_OBJECT] = {LAYERS("CryptoObject")}, [MATTE_MATERIAL] = {LAYERS("CryptoMaterial")}};
    film->mattes = film->pixels + film->channel_count * (size_t)film->width * film->height;
    for (int k = 0; k < MATTE_KINDS; ++k) {
        for (uint32_t i = 0; film->parts.mattes[k] >= 0 && i < 2 * MATTE_RANKS; ++i)
            add_channel(film, names[k][i], false, false);
    }
}

static void add_channels(fathom_film *film, unsigned aovs) {
    add_three(film, film->rgb, "R", "G", "B", true);
    if (aovs & FATHOM_AOV_ALPHA) film->alpha = add_channel(film, "A", false, true);
    if (aovs & FATHOM_AOV_Z) film->z = add_channel(film, "Z", false, false);
    if (aovs & FATHOM_AOV_N) add_three(film, film->n, "N.X", "N.Y", "N.Z", false);
    if (aovs & FATHOM_AOV_P) add_three(film, film->p, "P.X", "P.Y", "P.Z", false);
    if (aovs & FATHOM_AOV_ALBEDO) add_three(film, film->albedo, "albedo.R", "albedo.G", "albedo.B", true);
    if (aovs & FATHOM_AOV_MOTION) {
        static const char *const names[4] = {"forward.u", "forward.v", "backward.u", "backward.v"};
        for (int c = 0; c < 4; ++c) film->motion[c] = add_channel(film, names[c], false, false);
    }
    if (aovs & FATHOM_AOV_ID) {
        film->object = add_id(film, "id.object", "id.object.V");
        film->primitive = add_id(film, "id.primitive", "id.primitive.V");
        film->instance = add_id(film, "id.instance", "id.instance.V");
    }
    if (aovs & FATHOM_AOV_ERROR) {
        add_three(film, film->error, "error.R", "error.G", "error.B", false);
        film->doubt = add_channel(film, "error.doubt", false, false);
    }
    if (aovs & FATHOM_AOV_SAMPLES)
        film->samples = add_id(film, "samples", "samples.V");
    else if (film->parts.cascades)
        film->samples = add_id(film, NULL, NULL);
    add_layers(film);
    add_mattes(film);
}

film_parts film_parts_of(const fathom_settings *settings, const light_group_names *groups) {
    const unsigned aovs = settings->aovs;
    static const unsigned of_kind[LIGHT_KINDS] = {[LIGHT_EMISSION] = FATHOM_AOV_EMISSION,
                                                  [LIGHT_DIRECT] = FATHOM_AOV_DIRECT,
                                                  [LIGHT_INDIRECT] = FATHOM_AOV_INDIRECT};
    const unsigned of_hits = FATHOM_AOV_ALPHA | FATHOM_AOV_Z | FATHOM_AOV_N | FATHOM_AOV_P |
                             FATHOM_AOV_ALBEDO | FATHOM_AOV_ID | FATHOM_AOV_MOTION;
    film_parts parts = {.hits = aovs & of_hits};
    if (settings->fireflies == FATHOM_FIREFLIES_REWEIGHT) parts.cascades = FIREFLY_CASCADES;
    for (int k = 0; k < LIGHT_KINDS; ++k) parts.kinds[k] = aovs & of_kind[k] ? (int8_t)parts.layers++ : -1;
    parts.groups = aovs & FATHOM_AOV_LIGHT_GROUPS ? (int8_t)parts.layers : -1;
    if (parts.groups >= 0) parts.layers += group_count(groups);
    for (unsigned k = 0; k < MATTE_KINDS; ++k)
        parts.mattes[k] = aovs & (unsigned)FATHOM_AOV_CRYPTO_OBJECT << k ? (int8_t)parts.matte_count++ : -1;
    return parts;
}

uint32_t film_channels(const fathom_settings *settings, const light_group_names *groups) {
    const film_parts parts = film_parts_of(settings, groups);
    const unsigned aovs = settings->aovs | (parts.cascades ? FATHOM_AOV_SAMPLES : 0);
    const unsigned one = FATHOM_AOV_ALPHA | FATHOM_AOV_Z | FATHOM_AOV_SAMPLES,
                   three = FATHOM_AOV_N | FATHOM_AOV_P | FATHOM_AOV_ALBEDO | FATHOM_AOV_ID;
    return 3 + 4 * (uint32_t)__builtin_popcount(aovs & (FATHOM_AOV_ERROR | FATHOM_AOV_MOTION)) +
           2 * MATTE_RANKS * parts.matte_count + 3 * film_part_sums(parts) +
           (uint32_t)__builtin_popcount(aovs & one) + 3 * (uint32_t)__builtin_popcount(aovs & three);
}

static fathom_status check_memory(fathom_context *context, const fathom_film *film) {
    const uint64_t room = memory_free();
    if (film->bytes <= room) return FATHOM_OK;
    return fail(context, FATHOM_OUT_OF_RESOURCES,
                "out of memory: %u x %u pixels take %.1f GiB, and %.1f GiB are free; render a smaller image "
                "or a crop",
                film->width, film->height, (double)film->bytes * 0x1p-30, (double)room * 0x1p-30);
}

/* Allocates the pixels and channels of a film with known size and settings. If memory runs out, releases the
 * film. */
static fathom_status take_pixels(fathom_context *context, fathom_film *film, const char *scene_name,
                                 fathom_film **out) {
    film->scene_name = strdup(scene_name);
    if (film->settings.fireflies == FATHOM_FIREFLIES_REWEIGHT)
        strcpy(film->fireflies, "kept; a second image has them reweighted");
    film->bytes = (uint64_t)film->width * film->height * sizeof(float) *
                  film_channels(&film->settings, &film->light_groups);
    fathom_status status = check_memory(context, film);
    if (status == FATHOM_OK) film->pixels = memory_take(film->bytes);
    film->group_channels = calloc(LIGHT_GROUPS, sizeof *film->group_channels);
    const size_t rows = film_error_rows(film);
    film->error_rows = rows ? malloc(rows) : NULL;
    if (status == FATHOM_OK &&
        (!film->scene_name || !film->pixels || !film->group_channels || (rows && !film->error_rows)))
        status = fail_memory(context, film->bytes);
    if (status != FATHOM_OK) {
        fathom_film_destroy(film);
        return status;
    }
    film->parts = film_parts_of(&film->settings, &film->light_groups);
    add_channels(film, film->settings.aovs);
    *out = film;
    return FATHOM_OK;
}

static fathom_status make_manifests(fathom_context *context, const fathom_scene *scene, fathom_film *film) {
    const film_parts parts = film_parts_of(&film->settings, &film->light_groups);
    for (int k = 0; k < MATTE_KINDS; ++k) {
        if (parts.mattes[k] < 0) continue;
        film->manifests[k] = matte_manifest(scene, (matte_kind)k);
        if (!film->manifests[k]) return fail_memory(context, scene->objects.count + scene->materials.count);
    }
    return FATHOM_OK;
}

fathom_status film_create(fathom_context *context, const fathom_scene *scene, const fathom_settings *settings,
                          fathom_film **out) {
    const settings_region region = settings_region_of(settings);
    fathom_film like = {.x = region.x,
                        .y = region.y,
                        .width = region.width,
                        .height = region.height,
                        .full_width = settings->width,
                        .full_height = settings->height,
                        .settings = *settings,
                        .camera = motion_camera_shown(&scene->camera, settings->motion_blur),
                        .in_studio = scene->in_studio && settings->integrator != FATHOM_INTEGRATOR_CLASSIC,
                        .light_groups = scene->light_groups,
                        .parts.octave = fireflies_octave(scene),
                        .scene_name = scene->name};
    like.settings.tracer = NULL; /* the film does not own it; the tracer's name is in the statistics */
    memcpy(like.background, scene->background, sizeof like.background);
    memcpy(like.brightest, scene->background, sizeof like.brightest);
    *out = NULL;
    fathom_status status = make_manifests(context, scene, &like);
    if (status == FATHOM_OK) status = film_create_like(context, &like, out);
    for (int k = 0; k < MATTE_KINDS; ++k) free(like.manifests[k]);
    return status;
}

fathom_status film_create_like(fathom_context *context, const fathom_film *film, fathom_film **out) {
    *out = NULL;
    fathom_film *copy = calloc(1, sizeof *copy);
    if (!copy) return fail_memory(context, sizeof *copy);
    pthread_mutex_init(&copy->lock, NULL);
    copy->width = film->width, copy->height = film->height;
    copy->x = film->x, copy->y = film->y;
    copy->full_width = film->full_width, copy->full_height = film->full_height;
    copy->settings = film->settings;
    copy->camera = film->camera;
    copy->light_groups = film->light_groups;
    for (int k = 0; k < MATTE_KINDS; ++k) {
        if (!film->manifests[k] || (copy->manifests[k] = strdup(film->manifests[k]))) continue;
        fathom_film_destroy(copy);
        return fail_memory(context, strlen(film->manifests[k]));
    }
    memcpy(copy->background, film->background, sizeof copy->background);
    memcpy(copy->brightest, film->brightest, sizeof copy->brightest);
    copy->in_studio = film->in_studio;
    copy->exposed = film->exposed, copy->exposure = film->exposure;
    const fathom_status status = take_pixels(context, copy, film->scene_name, out);
    if (status == FATHOM_OK) (*out)->parts.octave = film->parts.octave;
    return status;
}

fathom_status film_copy(fathom_context *context, const fathom_film *film, fathom_film **out) {
    fathom_status status = film_create_like(context, film, out);
    if (status != FATHOM_OK) return status;
    pthread_mutex_t *lock = (pthread_mutex_t *)(uintptr_t)&film->lock;
    pthread_mutex_lock(lock);
    memcpy((*out)->pixels, film->pixels, film->bytes);
    (*out)->whole = film->whole, (*out)->settled = film->settled;
    pthread_mutex_unlock(lock);
    return FATHOM_OK;
}

void fathom_film_destroy(fathom_film *film) {
    if (!film) return;
    if (film->pixels) memory_return(film->pixels, film->bytes);
    for (int k = 0; k < MATTE_KINDS; ++k) free(film->manifests[k]);
    free(film->scene_name);
    free(film->group_channels);
    free(film->error_rows);
    pthread_mutex_destroy(&film->lock);
    array_free(&film->left_out);
    free(film);
}

void fathom_film_size(const fathom_film *film, uint32_t *width, uint32_t *height) {
    if (width) *width = film ? film->width : 0;
    if (height) *height = film ? film->height : 0;
}

uint32_t fathom_film_left_out(const fathom_film *film, const fathom_left_out **out) {
    if (out) *out = film ? film->left_out.items : NULL;
    return film ? (uint32_t)film->left_out.count : 0;
}

static const void *find_channel(const fathom_film *film, const char *name, bool is_id) {
    for (uint32_t i = 0; film && name && i < film->channel_count; ++i) {
        const film_channel *c = &film->channels[i];
        if (c->is_id == is_id && c->name && strcmp(c->name, name) == 0) return c->data;
    }
    return NULL;
}

const float *fathom_film_channel(const fathom_film *film, const char *name) {
    return find_channel(film, name, false);
}

const uint32_t *fathom_film_channel_id(const fathom_film *film, const char *name) {
    return find_channel(film, name, true);
}
