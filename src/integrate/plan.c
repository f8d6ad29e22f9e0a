#include "integrate/plan.h"

#include "base/clock.h"
#include "integrate/caustics/caustics.h"
#include "integrate/integrator.h"
#include "integrate/reference/reference.h"
#include "light/light.h"
#include "math/rgb.h"
#include "scene/motion/motion.h"
#include "scene/scene.h"

#include <stdlib.h>

/* Average number of samples per pixel of adaptive renders with a usual error. */
#define ADAPTIVE_USUAL_SPP 32u
/* Average number of bounces of a path. */
#define PATH_USUAL_DEPTH 4u

uint32_t plan_expected_spp(const fathom_settings *s) {
    return s->target_error > 0 || s->max_time > 0 ? min_u32(s->spp, ADAPTIVE_USUAL_SPP) : s->spp;
}

render_plan plan_before(const render_plan *plan, uint64_t other_seed) {
    render_plan out = *plan;
    out.settings.aovs = 0, out.settings.fireflies = FATHOM_FIREFLIES_KEEP;
    out.parts = film_parts_of(&out.settings, NULL);
    out.sampler.seed ^= other_seed;
    return out;
}

uint64_t plan_expected_rays(const fathom_scene *scene, const fathom_settings *s) {
    unsigned bounces = parts_features(scene) & (MATERIAL_MIRROR | MATERIAL_REFRACT) ? 2 : 1;
    const uint64_t samples = settings_pixels(s) * plan_expected_spp(s);
    if (s->integrator != FATHOM_INTEGRATOR_CLASSIC)
        return samples * 2 * (s->max_depth < PATH_USUAL_DEPTH ? s->max_depth : PATH_USUAL_DEPTH);
    return samples * (1 + scene->lights.count) * bounces;
}

/* Camera rays start at different points or times. */
static bool eyes_vary(const render_plan *plan) {
    return (plan->moves && plan->settings.motion_blur) || plan->camera.parallel ||
           plan->camera.lens_radius > 0 || plan->camera.near_clip > 0;
}

static void plan_depths(render_plan *plan) {
    plan->eye_depth = watertight_depth(plan->watertight, plan->camera.eye);
    plan->depths_differ = eyes_vary(plan) && eye_depths_differ(plan);
}

/* Directional light comes from outside all meshes: depth 0. */
static fathom_status plan_watertight(fathom_context *context, render_plan *plan, const bool *in_mesh) {
    fathom_status status = watertight_create(context, plan->tracer, &plan->watertight);
    if (status != FATHOM_OK || !plan->watertight) return status;
    plan->light_depths = calloc(plan->light_count + 1, 1);
    if (!plan->light_depths) return fail_memory(context, plan->light_count + 1);
    plan_depths(plan);
    for (uint32_t i = 0; i < plan->light_count; ++i) {
        if (in_mesh[i])
            plan->light_depths[i] = WATERTIGHT_UNSURE;
        else if (plan->lights[i].type != FATHOM_LIGHT_DIRECTIONAL)
            plan->light_depths[i] = watertight_depth(plan->watertight, plan->lights[i].position);
    }
    return status;
}

static fathom_status plan_surroundings(fathom_context *context, render_plan *plan) {
    bool *in_mesh = calloc(plan->light_count + 1, sizeof *in_mesh);
    if (!in_mesh) return fail_memory(context, plan->light_count + 1);
    fathom_status status = light_surfaces_find(context, plan->world, plan->camera.eye, plan->lights,
                                               plan->light_count, in_mesh, &plan->light_surfaces);
    if (status == FATHOM_OK) status = plan_watertight(context, plan, in_mesh);
    free(in_mesh);
    return status;
}

/* ---- the path integrator ---- */

static fathom_status plan_shaders(fathom_context *context, render_plan *plan) {
    const fathom_scene *scene = plan->scene;
    const size_t count = scene->materials.count;
    plan->shaders = malloc((count + 1) * sizeof *plan->shaders);
    if (!plan->shaders) return fail_memory(context, (count + 1) * sizeof *plan->shaders);
    for (size_t i = 0; i < count; ++i) {
        shader *s = &plan->shaders[i];
        fathom_material m;
        mapped_between(&scene->materials.items[i].value, &m);
        shader_prepare(&m, s);
        const bool holes = plan->texturing && texturing_may_cover(plan->texturing, (fathom_id)i);
        plan->crosses |= s->transmits || holes;
        plan->nested |= s->encloses && s->priority;
        plan->dispersive |= (s->lobes & SHADER_DISPERSIVE) != 0;
        plan->panes |= s->clear || (plan->texturing && material_is_pane(&m)); /* images may make it smooth */
        plan->covered |= s->hole > 0 || holes || plan->nested || plan->panes;
        plan->one_sided |= s->one_sided;
        plan->absorbs |= rgb_any(s->absorption);
    }
    return FATHOM_OK;
}

static void plan_volumes(render_plan *plan) {
    eye_volumes_find(plan, plan->camera.eye, plan->settings.motion_blur ? 0 : 0.5f, &plan->eye_volumes);
    plan->volumes_differ = eyes_vary(plan) && eye_volumes_differ(plan);
    /* Volumes around a camera far away are behind planes. They absorb light all the way to the camera. */
    plan->far &= !plan->eye_volumes.count && !plan->volumes_differ;
}

static fathom_status plan_paths(fathom_context *context, render_plan *plan, plan_watch *watch) {
    fathom_status status = plan_shaders(context, plan);
    if (status == FATHOM_OK)
        status = emitters_create(context, plan->world, plan->texturing,
                                 plan->groups.count ? &plan->groups : NULL, &plan->emitters);
    if (status == FATHOM_OK) status = watertight_create(context, plan->tracer, &plan->watertight);
    if (status != FATHOM_OK) return status;
    plan->background = emitters_any_outside(plan->emitters);
    plan->camera_moves = motion_camera_moves(&plan->scene->camera);
    plan->moves = plan->world->moves || plan->camera_moves;
    if (plan->absorbs || plan->nested) plan_volumes(plan);
    plan->unshadowed = !world_casts_all_shadows(plan->world);
    plan->max_depth = plan->settings.max_depth;
    if (plan->watertight) plan_depths(plan);
    status = path_scout_lights(context, plan, &watch->stop);
    const double began = clock_seconds();
    if (status == FATHOM_OK) status = caustics_create(context, plan, watch, &plan->caustics);
    plan->photon_seconds = clock_seconds() - began;
    return status;
}

/* ---- the reference ---- */

static fathom_status plan_reference(fathom_context *context, render_plan *plan) {
    const fathom_settings *s = &plan->settings;
    if (plan->parts.hits || plan->parts.layers || plan->parts.matte_count)
        return fail_field(context, FATHOM_BAD_USAGE, "aovs",
                          "the reference integrator makes none but samples");
    const reference_settings settings = {.width = s->width,
                                         .height = s->height,
                                         .depth = s->max_depth,
                                         .seed = s->seed,
                                         .filter = &plan->filter,
                                         .sharp = !s->motion_blur,
                                         .terminator_fix = s->terminator_fix};
    return reference_open(plan->scene, &settings, &plan->reference);
}

/* ---- the classic integrator ---- */

static fathom_status plan_bsdfs(fathom_context *context, render_plan *plan) {
    const fathom_scene *scene = plan->scene;
    const size_t count = scene->materials.count;
    plan->bsdfs = malloc((count + 1) * sizeof *plan->bsdfs);
    if (!plan->bsdfs) return fail_memory(context, (count + 1) * sizeof *plan->bsdfs);
    for (size_t i = 0; i < count; ++i)
        bsdf_prepare(&scene->materials.items[i].classic, scene->ambient, &plan->bsdfs[i]);
    return FATHOM_OK;
}

static bool plan_lights(render_plan *plan) {
    const fathom_scene *scene = plan->scene;
    plan->light_group_of = calloc(scene->lights.count + 1, 1);
    if (!(plan->features & MATERIAL_LIT)) return plan->light_group_of;
    for (size_t i = 0; i < scene->lights.count; ++i) {
        const fathom_light *light = &scene->lights.items[i];
        if (!parts_light(light)) continue;
        if (plan->groups.count && plan->light_group_of)
            plan->light_group_of[plan->light_count] = plan->groups.of[FATHOM_SOURCE_LIGHT][i];
        light_prepare(light, plan->world->origin, &plan->lights[plan->light_count++]);
    }
    return plan->light_group_of;
}

static fathom_status plan_classic(fathom_context *context, render_plan *plan) {
    if (motion_camera_moves(&plan->scene->camera))
        return fail_field(context, FATHOM_BAD_USAGE, "integrator",
                          "the classic integrator knows no motion, and the camera moves while the shutter is "
                          "open; use path, or a shutter that opens and closes at one time");
    plan->background = parts_background(plan->scene);
    plan->crosses = (plan->features & MATERIAL_REFRACT) != 0;
    plan->max_depth = parts_bounces(plan->scene, &plan->settings) ? plan->settings.max_depth : 0;
    fathom_status status = FATHOM_OK;
    if (!plan_lights(plan)) status = fail_memory(context, plan->scene->lights.count);
    if (status == FATHOM_OK) status = plan_bsdfs(context, plan);
    return status == FATHOM_OK ? plan_surroundings(context, plan) : status;
}

/* ---- all ---- */

static const integrator *integrator_of(fathom_integrator which) {
    switch (which) {
    case FATHOM_INTEGRATOR_CLASSIC: return &integrator_classic;
    case FATHOM_INTEGRATOR_PATH: return &integrator_path;
    case FATHOM_INTEGRATOR_REFERENCE: return &integrator_reference;
    }
    return NULL;
}

static fathom_status plan_integrator(fathom_context *context, render_plan *plan, plan_watch *watch) {
    switch (plan->settings.integrator) {
    case FATHOM_INTEGRATOR_CLASSIC: return plan_classic(context, plan);
    case FATHOM_INTEGRATOR_PATH: return plan_paths(context, plan, watch);
    case FATHOM_INTEGRATOR_REFERENCE: return plan_reference(context, plan);
    }
    return FATHOM_BAD_USAGE;
}

static void choose_kernels(render_plan *plan) {
    plan->camera_kernels = camera_kernels_best();
    plan->sample_kernels = sample_kernels_best();
    plan->surface_kernels = surface_kernels_best();
    plan->material_kernels = material_kernels_best();
    plan->shader_kernels = shader_kernels_best();
    plan->light_kernels = light_kernels_best();
    plan->kernels = integrate_kernels_best();
    plan->path_kernels = path_kernels_best();
}

/* Half a pixel at the image's centre: the averaging over a pixel's samples filters the other half. */
static void set_cone(render_plan *plan) {
    const shade_camera *c = &plan->camera;
    const double distance = fabs(dot_f64(c->corner, c->view)), half = 0.5 * length_f64(c->down);
    plan->pixel_spread = c->parallel ? 0 : (float)(half / distance);
    plan->pixel_width = c->parallel ? (float)half : 0;
}

/* Rounding camera rays to float where they start moves them at the scene by 2^-24 of the distance. Up to a
 * 256th of a pixel this is left as it is. For a pinhole this limit depends on the pixel's angle alone, so
 * that most scenes need no bounds. */
static fathom_status plan_approach(render_plan *plan) {
    const double limit = 0x1p-24 * 128; /* half a pixel has the size pixel_width + pixel_spread * distance */
    const double spread = (double)plan->pixel_spread, width = (double)plan->pixel_width;
    if (spread > limit) return FATHOM_OK;
    const fathom_status status = trace_approach_find(plan->world, &plan->approach);
    const vec3_f64 eye = plan->camera.exact_eye;
    const double distance = length_f64(sub_f64(plan->approach.center, eye));
    plan->far = status == FATHOM_OK && trace_approach_is_far(&plan->approach, eye) &&
                limit * distance > width + spread * distance;
    return status;
}

static fathom_status plan_mattes(fathom_context *context, render_plan *plan) {
    for (int k = 0; k < MATTE_KINDS; ++k) {
        if (plan->parts.mattes[k] < 0) continue;
        plan->matte_ids[k] = matte_ids(plan->scene, (matte_kind)k);
        if (!plan->matte_ids[k]) return fail_memory(context, plan->scene->objects.count);
    }
    return FATHOM_OK;
}

fathom_status plan_create(fathom_context *context, const world *w, const trace_tracer *tracer,
                          const fathom_settings *settings, texture_cache *textures, plan_watch *watch,
                          render_plan **out) {
    plan_watch unwatched = {.photons = 0};
    *out = NULL;
    const fathom_scene *scene = w->scene;
    render_plan *plan = calloc(1, sizeof *plan);
    shade_light *lights = malloc((scene->lights.count + 1) * sizeof *lights);
    if (!plan || !lights) {
        free(plan);
        free(lights);
        texture_cache_close(textures);
        return fail_memory(context, sizeof *plan);
    }
    plan->scene = scene;
    plan->world = w;
    plan->tracer = tracer;
    plan->integrator = integrator_of(settings->integrator);
    choose_kernels(plan);
    plan->settings = *settings;
    plan->lights = lights;
    plan->features = parts_features(scene);
    plan->parts = film_parts_of(settings, &scene->light_groups);
    plan->parts.octave = fireflies_octave(scene);
    const fathom_camera camera = motion_camera_shown(&scene->camera, settings->motion_blur);
    camera_prepare(&camera, settings->width, settings->height, w->origin, &plan->camera);
    plan->sampler =
        (sampler){settings->pattern, (uint32_t)(sqrt((double)settings->spp) + 0.5), settings->seed};
    filter_prepare(settings, &plan->filter);
    plan->t_near = (float)settings->epsilon;
    plan->lifts = settings->terminator_fix && parts_smooth(w);
    set_cone(plan);
    fathom_status status = texturing_create(context, w, settings->texture_memory, textures, &plan->texturing);
    if (status == FATHOM_OK && plan->parts.groups >= 0) status = light_groups_create(scene, &plan->groups);
    if (status == FATHOM_OK) status = plan_mattes(context, plan);
    if (status == FATHOM_OK) status = plan_approach(plan);
    if (status == FATHOM_OK) status = plan_integrator(context, plan, watch ? watch : &unwatched);
    if (status == FATHOM_OK)
        *out = plan;
    else
        plan_destroy(plan);
    return status;
}

void plan_destroy(render_plan *plan) {
    if (!plan) return;
    watertight_destroy(plan->watertight);
    free(plan->light_depths);
    free(plan->light_surfaces);
    free(plan->lights);
    free(plan->light_group_of);
    light_groups_destroy(&plan->groups);
    for (int k = 0; k < MATTE_KINDS; ++k) free(plan->matte_ids[k]);
    free(plan->bsdfs);
    free(plan->shaders);
    emitters_destroy(plan->emitters);
    caustics_destroy(plan->caustics);
    reference_close(plan->reference);
    texturing_destroy(plan->texturing);
    free(plan);
}
