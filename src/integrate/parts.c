#include "integrate/parts.h"

#include "material/material.h"
#include "math/rgb.h"
#include "scene/mesh/absent.h"
#include "scene/scene.h"

#include <stdio.h>

/* A map of opacity lets light pass straight through. */
static unsigned features_of(const fathom_scene *scene, fathom_id material) {
    const scene_named_material *m = &scene->materials.items[material];
    const bool holes = m->value.maps[FATHOM_MAP_OPACITY].texture != FATHOM_NONE;
    fathom_material between;
    if (!material_has_maps(&m->value)) return material_features(&m->classic);
    mapped_between_classic(&m->value, &between);
    return material_features(&between) | (holes ? MATERIAL_REFRACT : 0u);
}

unsigned parts_features(const fathom_scene *scene) {
    const bool own = absent_by_own_material(scene);
    unsigned features = scene_has_opacities(scene) ? MATERIAL_REFRACT : 0;
    for (size_t i = 0; i < scene->objects.count; ++i) {
        if (own && absent_object(scene, (fathom_id)i)) continue;
        features |= features_of(scene, scene_object_material(scene, (fathom_id)i));
    }
    for (size_t i = 0; i < scene->instances.count; ++i) {
        fathom_id material = scene->instances.items[i].material;
        if (material != FATHOM_NONE) features |= features_of(scene, material);
    }
    return features;
}

/* Features of a transmitting material that only path tracing renders: absorption in a volume, and layers. */
static bool path_takes_light(const fathom_material *m) {
    const float *left = m->attenuation_color, *sheen = m->sheen_color;
    const bool absorbs =
        m->thickness > 0 && m->attenuation_distance > 0 && (left[0] < 1 || left[1] < 1 || left[2] < 1);
    return absorbs || m->clearcoat > 0 || rgb_any(sheen);
}

/* True if the material transmits all light, in any direction. Fresnel's equations take a fraction of it at
 * every surface that refracts. */
static bool is_transparent(const fathom_scene *scene, fathom_id material, bool paths) {
    const fathom_material *m = &scene->materials.items[material].classic;
    if (material_has_maps(&scene->materials.items[material].value)) return false;
    if (paths && path_takes_light(&scene->materials.items[material].value)) return false;
    if (material_features(m) != MATERIAL_REFRACT || (m->fresnel && m->ior != 1)) return false;
    for (int c = 0; c < 3; ++c) {
        if (!(m->k_t[c] >= 1) || m->k_a[c] * scene->ambient[c] > 0) return false;
    }
    return true;
}

bool parts_all_transparent(const fathom_scene *scene, fathom_integrator integrator) {
    const bool paths = integrator != FATHOM_INTEGRATOR_CLASSIC;
    for (size_t i = 0; i < scene->objects.count; ++i) {
        if (!is_transparent(scene, scene_object_material(scene, (fathom_id)i), paths)) return false;
    }
    for (size_t i = 0; i < scene->instances.count; ++i) {
        fathom_id material = scene->instances.items[i].material;
        if (material != FATHOM_NONE && !is_transparent(scene, material, paths)) return false;
    }
    return scene->objects.count > 0;
}

bool parts_smooth(const world *w) {
    for (size_t i = 0; i < w->geometries.count; ++i) {
        if (w->geometries.items[i].smooth) return true;
    }
    return false;
}

bool parts_light(const fathom_light *light) { return rgb_any(light->intensity); }

bool parts_ambient(const fathom_scene *scene) { return rgb_any(scene->ambient); }

bool parts_background(const fathom_scene *scene) {
    const float *rgb = scene->background;
    return rgb[0] != 0 || rgb[1] != 0 || rgb[2] != 0;
}

bool parts_bounces(const fathom_scene *scene, const fathom_settings *settings) {
    return settings->max_depth && parts_features(scene) & (MATERIAL_MIRROR | MATERIAL_REFRACT);
}

/* ---- in words ---- */

/* Adds a line. False if out of memory. */
static bool left_out_tell(left_out_list *list, const char *what, const char *why) {
    fathom_left_out item;
    snprintf(item.what, sizeof item.what, "%s", what);
    snprintf(item.why, sizeof item.why, "%s", why);
    return array_push(list, item);
}

typedef struct wording {
    bool needed;
    const char *what, *why;
} wording;

static bool tell_unneeded(const wording *words, size_t count, left_out_list *list) {
    for (size_t i = 0; i < count; ++i) {
        if (!words[i].needed && !left_out_tell(list, words[i].what, words[i].why)) return false;
    }
    return true;
}

static bool any_triangles(const world *w) {
    for (size_t i = 0; i < w->geometries.count; ++i) {
        if (w->geometries.items[i].kind == WORLD_MESH) return true;
    }
    return false;
}

static bool tell_shapes(const world *w, left_out_list *list) {
    const wording words[] = {{any_triangles(w), "triangle geometry", "there is no mesh"},
                             {w->spheres.count, "sphere geometry", "there is no sphere"},
                             {w->quads.count, "quad geometry", "there is no quad"},
                             {w->planes.count, "planes", "there is none"},
                             {w->instances.count, "instances",
                              w->scene->instances.count ? "their shapes are moved to the world's own frame"
                                                        : "all shapes lie in the world's own frame"},
                             {parts_smooth(w), "shading normals", "no mesh has any"},
                             {w->scene->has_maps, "textures", "no material takes an image"}};
    return tell_unneeded(words, sizeof words / sizeof *words, list);
}

static bool tell_stages(const world *w, const fathom_settings *s, bool repair, left_out_list *list) {
    const film_parts parts = film_parts_of(s, &w->scene->light_groups);
    const wording words[] = {
        {parts.hits, "buffers of AOVs", "no AOV of first hits is asked for"},
        {parts.layers, "layers of light", "no AOV asks for a part of the light"},
        {repair, "watertight repair", "there is no closed mesh that the tracer could leak"},
        {s->target_error > 0 || s->max_time > 0 || s->aovs & FATHOM_AOV_ERROR, "error estimates",
         "every pixel gets as many samples"}};
    return tell_unneeded(words, sizeof words / sizeof *words, list);
}

static bool tell_classic(const world *w, const fathom_settings *s, left_out_list *list) {
    const wording words[] = {{parts_background(w->scene), "background", "it is black"},
                             {parts_bounces(w->scene, s), "mirrored and refracted rays",
                              s->max_depth ? "no material mirrors or refracts" : "the depth limit is 0"},
                             {!(s->max_loss > 0 || s->max_relative_loss > 0), "faint shadow rays",
                              "what they could add is less than the loss that is allowed"}};
    return tell_unneeded(words, sizeof words / sizeof *words, list);
}

/* Parts that only the path integrator can skip: lens samples and absorption. */
static bool tell_paths(const world *w, left_out_list *list) {
    bool absorbs = false;
    for (size_t i = 0; i < w->scene->materials.count; ++i) {
        fathom_material between;
        mapped_between(&w->scene->materials.items[i].value, &between);
        absorbs |= material_absorbs(&between);
    }
    const wording words[] = {{w->scene->camera.lens_radius > 0, "samples on the lens", "it is a pinhole"},
                             {absorbs, "absorption along rays", "no material absorbs light"}};
    return tell_unneeded(words, sizeof words / sizeof *words, list);
}

static bool tell_lights(const fathom_scene *scene, left_out_list *list) {
    if (!scene->lights.count) return left_out_tell(list, "lights and their shadow rays", "there is no light");
    if (!(parts_features(scene) & MATERIAL_LIT))
        return left_out_tell(list, "lights and their shadow rays", "no material reflects their light");
    for (size_t i = 0; i < scene->lights.count; ++i) {
        char what[sizeof((fathom_left_out *)NULL)->what];
        snprintf(what, sizeof what, "lights[%zu]", i);
        if (!parts_light(&scene->lights.items[i]) && !left_out_tell(list, what, "it is black")) return false;
    }
    return left_out_tell(list, "unlit shadow rays", "where the surface faces away or lies outside the cone");
}

static bool tell_absent(const world *w, left_out_list *list) {
    size_t count = 0;
    for (size_t i = 0; i < w->scene->objects.count; ++i) count += w->absent[i];
    if (!count) return true;
    char what[sizeof((fathom_left_out *)NULL)->what];
    snprintf(what, sizeof what, "%zu shape%s", count, count == 1 ? "" : "s");
    return left_out_tell(list, what, "all light passes straight through, and there is no shadow");
}

bool left_out_find(const world *w, const fathom_settings *s, bool repair, left_out_list *out) {
    if (!tell_absent(w, out) || !tell_shapes(w, out) || !tell_stages(w, s, repair, out)) return false;
    if (s->integrator != FATHOM_INTEGRATOR_CLASSIC) return tell_paths(w, out);
    return tell_classic(w, s, out) && tell_lights(w->scene, out);
}
