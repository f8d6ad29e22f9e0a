/* Classic materials that reflect and transmit more light than they receive: the model does not limit the
 * sum. */
#include "integrate/parts.h"

#include <stdio.h>
#include <stdlib.h>

/* The albedo of a highlight of k_s 1, for light along the normal: 1 / pi times the integral of max(0,
 * v·r)^n or max(0, n·h)^n times the cosine. */
static double lobe_of(const fathom_material *m) {
    const double n = (double)m->shininess;
    switch (m->specular) {
    case FATHOM_SPECULAR_NONE: return 0;
    case FATHOM_SPECULAR_PHONG: return 2 / (n + 2);
    case FATHOM_SPECULAR_BLINN: return 8 * (exp2(-n / 2) + n) / ((n + 2) * (n + 4));
    }
    return 0;
}

/* Mirror and glass; with Fresnel's law, whose reflectance is least along the normal and 1 at grazing. */
static double smooth_of(const fathom_material *m, int channel) {
    const double mirror = (double)m->k_r[channel], glass = (double)m->k_t[channel], ior = (double)m->ior;
    if (!m->fresnel) return mirror + glass;
    const double root = (ior - 1) / (ior + 1), least = root * root;
    return fmax(mirror, least * mirror + (1 - least) * glass);
}

/* The ratio of leaving to arriving light, in the channel where it is largest. Numbers that an image
 * changes are not known here, and count as 0. */
static double albedo_of(const fathom_material *m) {
    const bool colored = m->maps[FATHOM_MAP_COLOR].texture != FATHOM_NONE,
               shining = m->maps[FATHOM_MAP_SPECULAR_COLOR].texture != FATHOM_NONE ||
                         m->maps[FATHOM_MAP_SHININESS].texture != FATHOM_NONE;
    double largest = 0;
    for (int c = 0; c < 3; ++c) {
        const double diffuse = colored ? 0 : (double)m->k_d[c] * (m->lit_from_behind ? 2 : 1),
                     highlight = shining ? 0 : (double)m->k_s[c] * lobe_of(m);
        largest = fmax(largest, diffuse + highlight + smooth_of(m, c));
    }
    return largest;
}

/* One byte for each material. NULL: out of memory. */
static bool *materials_used(const fathom_scene *scene) {
    bool *used = calloc(scene->materials.count + 1, sizeof *used);
    for (size_t i = 0; used && i < scene->objects.count; ++i)
        used[scene_object_material(scene, (fathom_id)i)] = true;
    for (size_t i = 0; used && i < scene->instances.count; ++i) {
        const fathom_id material = scene->instances.items[i].material;
        if (material != FATHOM_NONE) used[material] = true;
    }
    return used;
}

/* Above the rounding errors of sums that are meant to be 1. */
#define BRIGHTENING (1 + 1e-5)

bool parts_brighten(const fathom_scene *scene, fathom_integrator integrator, char text[PARTS_TEXT]) {
    if (integrator == FATHOM_INTEGRATOR_CLASSIC) return false;
    bool *used = materials_used(scene);
    size_t worst = 0, count = 0;
    double most = 0;
    for (size_t i = 0; used && i < scene->materials.count; ++i) {
        const fathom_material *m = &scene->materials.items[i].value;
        const double albedo = used[i] && m->model == FATHOM_MODEL_CLASSIC ? albedo_of(m) : 0;
        count += albedo > BRIGHTENING;
        if (albedo > most) most = albedo, worst = i;
    }
    free(used);
    if (!count) return false;
    const char *name = scene->materials.items[worst].name;
    snprintf(text, PARTS_TEXT,
             "materials that reflect more light than they receive, so paths get brighter at each hit: %zu; "
             "\"%.60s\" reflects %.3g %% more; lower kd (0.5 if not given), ks, kr or kt",
             count, name ? name : "default", (most - 1) * 100);
    return true;
}
