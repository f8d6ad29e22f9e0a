#include "render/plan.h"

#include <stdlib.h>

/* Materials of the objects there are, and of instances that override theirs. */
static unsigned features_in_use(const fathom_scene *scene) {
    unsigned features = 0;
    for (size_t i = 0; i < scene->objects.count; ++i) {
        fathom_id material = scene_object_material(scene, (fathom_id)i);
        features |= material_features(&scene->materials.items[material].value);
    }
    for (size_t i = 0; i < scene->instances.count; ++i) {
        fathom_id material = scene->instances.items[i].material;
        if (material != FATHOM_NONE) features |= material_features(&scene->materials.items[material].value);
    }
    return features;
}

/* Samples of a pixel, on average, of images to a usual error. */
#define ADAPTIVE_USUAL_SPP 32u

static bool lights_up(const float rgb[3]) { return rgb[0] > 0 || rgb[1] > 0 || rgb[2] > 0; }

uint64_t plan_expected_rays(const fathom_scene *scene, const fathom_settings *s) {
    uint64_t pixels = s->crop[2] ? (uint64_t)(s->crop[2] - s->crop[0]) * (s->crop[3] - s->crop[1])
                                 : (uint64_t)s->width * s->height;
    unsigned bends = features_in_use(scene) & (MATERIAL_MIRROR | MATERIAL_REFRACT) ? 2 : 1;
    uint64_t spp = s->spp;
    if ((s->target_error > 0 || s->max_time > 0) && spp > ADAPTIVE_USUAL_SPP) spp = ADAPTIVE_USUAL_SPP;
    return pixels * spp * (1 + scene->lights.count) * bends;
}

/* Directional light comes from outside of all. */
static fathom_status plan_watertight(fathom_context *context, render_plan *plan) {
    fathom_status status = watertight_create(context, plan->tracer, &plan->watertight);
    if (status != FATHOM_OK || !plan->watertight) return status;
    plan->light_depths = calloc(plan->light_count + 1, 1);
    if (!plan->light_depths) return fail_memory(context, plan->light_count + 1);
    plan->eye_depth = watertight_depth(plan->watertight, plan->camera.eye);
    for (uint32_t i = 0; i < plan->light_count; ++i) {
        if (plan->lights[i].type != FATHOM_LIGHT_DIRECTIONAL)
            plan->light_depths[i] = watertight_depth(plan->watertight, plan->lights[i].position);
    }
    return FATHOM_OK;
}

fathom_status plan_create(fathom_context *context, const world *w, const trace_tracer *tracer,
                          const fathom_settings *settings, render_plan **out) {
    *out = NULL;
    const fathom_scene *scene = w->scene;
    render_plan *plan = calloc(1, sizeof *plan);
    shade_light *lights = malloc((scene->lights.count + 1) * sizeof *lights);
    if (!plan || !lights) {
        free(plan);
        free(lights);
        return fail_memory(context, sizeof *plan);
    }
    plan->scene = scene;
    plan->world = w;
    plan->tracer = tracer;
    plan->kernels = shade_kernels_best();
    plan->settings = *settings;
    plan->lights = lights;
    plan->features = features_in_use(scene);
    camera_prepare(&scene->camera, settings->width, settings->height, w->origin, &plan->camera);
    for (size_t i = 0; i < scene->lights.count && plan->features & MATERIAL_LIT; ++i) {
        const fathom_light *light = &scene->lights.items[i];
        if (lights_up(light->intensity)) light_prepare(light, w->origin, &lights[plan->light_count++]);
    }
    plan->constant_term = lights_up(scene->ambient) || plan->features & MATERIAL_EMIT;
    plan->max_depth = plan->features & (MATERIAL_MIRROR | MATERIAL_REFRACT) ? settings->max_depth : 0;
    plan->grid = (uint32_t)(sqrt((double)settings->spp) + 0.5);
    plan->t_near = (float)settings->epsilon;
    plan->first_hits = (settings->aovs & ~(unsigned)FATHOM_AOV_SAMPLES) != 0;
    fathom_status status = plan_watertight(context, plan);
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
    free(plan->lights);
    free(plan);
}
