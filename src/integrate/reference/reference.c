/* The path loop of the reference, and its camera. */
#include "integrate/reference/reference.h"

#include "base/threads.h"
#include "integrate/reference/reference_inner.h"

#include "scene/motion/motion.h"

#include <stdlib.h>

/* ---- paths ---- */

/* Volumes that a path is in. */
enum { NESTED = 8 };

typedef struct path {
    vec3_f64 origin, direction, weight;
    double end;                        /* how far the camera sees along the path */
    const fathom_material *in[NESTED]; /* the volumes that the path is in, */
    unsigned nested;                   /* and their number */
    unsigned channel;                  /* the one channel that the path carries, 1 to 3; 0: all */
    bool overlap;                      /* volumes without priorities overlap */
    bool unlit;                        /* no light samples were taken of what the path meets next */
    bool beam;    /* mirrored or refracted by a facet, so that it keeps to the facet's side */
    bool in_view; /* the camera sees what the path meets next */
} path;

/* The index of m among the path's volumes, or p->nested if it is not one of them. */
static unsigned place_in(const path *p, const fathom_material *m) {
    unsigned i = 0;
    while (i < p->nested && p->in[i] != m) ++i;
    return i;
}

/* The volume of the highest priority, excluding `out`, which the path is leaving; NULL: none. */
static const fathom_material *medium_of(const path *p, const fathom_material *out) {
    const fathom_material *top = NULL;
    const unsigned leaves = place_in(p, out);
    for (unsigned i = 0; i < p->nested; ++i) {
        const fathom_material *m = p->in[i];
        if (i != leaves && (!top || m->priority > top->priority)) top = m;
    }
    return top;
}

static void enter(path *p, const fathom_material *m) {
    p->overlap |= p->nested == NESTED;
    if (!p->overlap) p->in[p->nested++] = m;
}

static void cross(path *p, const reference_surface *s) {
    if (!s->behind) return enter(p, s->material);
    const unsigned i = place_in(p, s->material);
    if (i < p->nested) p->in[i] = p->in[--p->nested];
}

/* KHR_materials_dispersion: the indices of red and blue differ from that of green by the same amount, and
 * blue's by no more than green's differs from 1. */
static double index_of(const fathom_material *m, unsigned channel) {
    const double ior = m ? (double)m->ior : 1,
                 spread = 0.025 * (ior - 1) * (m ? fmin((double)m->dispersion, 40) : 0);
    return channel ? fmax(ior + spread * (channel - 2.0), fmin(ior, 1.0001)) : ior;
}

/* False: the surface bounds a volume inside one of a higher priority, so the path ignores it. Otherwise sets
 * the surface's indices. */
static bool meets(path *p, reference_surface *s, reference_random *random) {
    const fathom_material *m = s->material;
    if (!reference_refracts(m)) return true;
    const fathom_material *other = medium_of(p, s->behind ? m : NULL);
    p->overlap |= other && !(other->priority && m->priority);
    if (other && other->priority >= m->priority) return false;
    if (!p->channel && (m->dispersion > 0 || (other && other->dispersion > 0))) {
        const double u = 3 * reference_uniform(random);
        p->channel = 1 + (unsigned)u;
        p->weight = times(p->weight, vec_f64(u < 1 ? 3 : 0, u >= 1 && u < 2 ? 3 : 0, u >= 2 ? 3 : 0));
    }
    s->ratio = index_of(m, 0) / index_of(other, 0);
    s->turn = index_of(m, p->channel) / index_of(other, p->channel);
    if (s->behind) s->ratio = 1 / s->ratio, s->turn = 1 / s->turn;
    return true;
}

/* The camera looks through the backs of one-sided surfaces. */
static bool is_seen(const path *p, const reference_surface *s) {
    return !(p->in_view && s->behind && material_is_one_sided(s->material));
}

/* The volume on the side of the surface that the direction leads to; NULL: none. */
static const fathom_material *medium_towards(const path *p, const reference_surface *s, vec3_f64 direction) {
    const bool crosses = reference_refracts(s->material) && reference_crosses(s, direction);
    if (!crosses) return medium_of(p, NULL);
    return s->behind ? medium_of(p, s->material) : s->material;
}

/* What a clear thin wall lets pass; black for other surfaces. */
static vec3_f64 passed_by(const reference_surface *s) {
    if (!reference_is_pane(s->material)) return gray(0);
    const reference_scatter all = reference_scatter_of(s);
    const reference_beam *last = &all.beam[all.beams ? all.beams - 1 : 0];
    const bool straight = all.beams && dot_f64(last->direction, s->to_viewer) < -1 + 1e-12;
    return straight ? last->weight : gray(0);
}

/* The light of one lamp, chosen uniformly, that this surface scatters to the viewer. */
static vec3_f64 light_at(const reference_scene *r, const path *p, const reference_surface *s,
                         reference_random *random) {
    const size_t count = scene_replaces_lights(r->scene) ? 0 : r->scene->lights.count;
    if (!count) return gray(0);
    const fathom_light *light = &r->scene->lights.items[(size_t)(reference_uniform(random) * (double)count)];
    const reference_arrival a = reference_arrive(light, s->point, random);
    vec3_f64 sum = scale_f64(a.power * (double)count, reference_evaluate(s, a.direction));
    reference_surface blocker;
    vec3_f64 from = reference_leave(s, a.direction);
    double left = a.distance;
    while (largest(sum) > 0 && reference_closest(r, from, a.direction, left, true, random, &blocker)) {
        sum = times(sum, passed_by(&blocker));
        left -= blocker.t, from = reference_leave(&blocker, a.direction);
    }
    if (!(largest(sum) > 0)) return gray(0);
    const fathom_material *medium = medium_towards(p, s, a.direction);
    if (medium) sum = times(sum, reference_absorbed(medium, a.distance));
    return times(sum, color_of(light->intensity));
}

/* Chooses one beam, or another direction. False: the path ends. *straight: it passes a clear thin wall. */
static bool scatter(path *p, const reference_scene *r, const reference_surface *s, reference_random *random,
                    bool *straight) {
    const reference_scatter all = reference_scatter_of(s);
    const double others = all.front + all.back + all.facets + all.coat;
    double sum = others;
    for (unsigned i = 0; i < all.beams; ++i) sum += largest(all.beam[i].weight);
    double pick = reference_uniform(random) * sum;
    *straight = false;
    for (unsigned i = 0; i < all.beams; ++i) {
        const double gain = largest(all.beam[i].weight);
        if (pick < gain) {
            *straight = i + 1 == all.beams && largest(passed_by(s)) > 0;
            p->unlit |= !*straight;
            p->beam = true;
            p->direction = all.beam[i].direction;
            p->weight = scale_f64(sum / gain, times(p->weight, all.beam[i].weight));
            return true;
        }
        pick -= gain;
    }
    p->unlit = p->beam = false;
    const double density = reference_choose(r, s, &all, random, &p->direction) * others / sum;
    if (!(density > 0)) return false;
    p->weight = scale_f64(1 / density, times(p->weight, reference_evaluate(s, p->direction)));
    return largest(p->weight) > 0;
}

/* Leaves the surface, and possibly enters or leaves a volume. */
static void advance(path *p, const reference_surface *s) {
    reference_surface facet = *s;
    facet.lifted &= !p->beam;
    p->origin = reference_leave(&facet, p->direction);
    if (reference_refracts(s->material) && reference_crosses(&facet, p->direction)) cross(p, s);
}

static vec3_f64 outside(const reference_scene *r, const path *p) {
    const vec3_f64 sky = reference_sky_light(r, p->direction);
    return p->unlit && !p->in_view ? add_f64(sky, reference_suns(r, p->direction)) : sky;
}

/* The light of the lamps that the path passes on its next `length`. */
static vec3_f64 lamps(const reference_scene *r, const path *p, double length) {
    vec3_f64 sum = {0, 0, 0};
    const size_t count = p->unlit && !p->in_view ? r->scene->lights.count : 0;
    for (size_t i = 0; i < count && !scene_replaces_lights(r->scene); ++i) {
        double distance;
        const vec3_f64 light =
            reference_lamp_seen(&r->scene->lights.items[i], p->origin, p->direction, &distance);
        const fathom_material *medium = medium_of(p, NULL);
        if (!(distance < length)) continue;
        sum = add_f64(sum, medium ? times(light, reference_absorbed(medium, distance)) : light);
    }
    return sum;
}

/* From the 17th surface on, Russian roulette may end paths. */
static bool survives(path *p, unsigned bounce, reference_random *random) {
    const double chance = largest(p->weight);
    if (bounce < 16 || chance >= 1) return true;
    p->weight = scale_f64(1 / chance, p->weight);
    return reference_uniform(random) < chance;
}

static bool radiance(const reference_scene *r, path p, reference_random random, vec3_f64 *out) {
    vec3_f64 sum = {0, 0, 0};
    for (unsigned bounce = 0; !p.overlap;) {
        reference_surface s = {.t = p.in_view ? p.end : (double)INFINITY};
        const bool hit = reference_closest(r, p.origin, p.direction, s.t, false, &random, &s);
        const double length = hit ? s.t : (double)INFINITY;
        sum = add_f64(sum, times(p.weight, lamps(r, &p, length)));
        const fathom_material *medium = medium_of(&p, NULL);
        if (medium) p.weight = times(p.weight, reference_absorbed(medium, length));
        if (!hit) {
            sum = add_f64(sum, times(p.weight, outside(r, &p)));
            break;
        }
        if (is_seen(&p, &s) && meets(&p, &s, &random)) {
            sum = add_f64(sum, times(p.weight, reference_emission(s.material)));
            bool straight = bounce == r->settings.depth;
            if (straight) {
                p.weight = times(p.weight, passed_by(&s)), p.direction = neg_f64(s.to_viewer);
                if (!(largest(p.weight) > 0)) break;
            } else {
                sum = add_f64(sum, times(p.weight, light_at(r, &p, &s, &random)));
                if (!scatter(&p, r, &s, &random, &straight)) break;
            }
            if (!straight && !survives(&p, bounce++, &random)) break;
            p.in_view = false;
        } else {
            p.unlit = true, p.end -= length;
        }
        advance(&p, &s);
    }
    *out = sum;
    return !p.overlap;
}

/* ---- images ---- */

/* True if the point is outside the polygon of blades: farther from the centre, towards its side, than the
 * side is. */
static bool beyond_blades(const fathom_camera *camera, double angle, double radius) {
    const double step = 2 * M_PI / camera->blades, turned = (angle - camera->blade_rotation) / step;
    const double aside = (turned - floor(turned) - 0.5) * step;
    return radius * cos(aside) > camera->lens_radius * cos(step / 2);
}

/* The path starts at the near plane and ends at the far one. */
static void clip(const fathom_camera *camera, path *out) {
    const double slope = -dot_f64(out->direction, load_f64(camera->z)), near = camera->near_clip / slope;
    out->origin = madd_f64(out->origin, near, out->direction);
    out->end = camera->far_clip > 0 ? camera->far_clip / slope - near : (double)INFINITY;
}

/* The ray through the point (x, y) of the image, in pixels from the upper left corner. A lens moves the ray's
 * origin and changes its direction so that it intersects the plane of focus at the same point. */
static void lens_ray(const reference_scene *r, const fathom_camera *camera, double x, double y,
                     reference_random *random, path *out) {
    const double width = r->settings.width, height = r->settings.height;
    const double w = camera->w > 0 ? camera->w : camera->h * width / height;
    const vec3_f64 right = load_f64(camera->x), up = load_f64(camera->y);
    vec3_f64 d = madd_f64(scale_f64((x / width - 0.5) * w, right), (0.5 - y / height) * camera->h, up);
    out->origin = load_f64(camera->origin);
    if (camera->orthographic) {
        out->origin = add_f64(out->origin, d);
        out->direction = normalize_f64(neg_f64(load_f64(camera->z)));
        return;
    }
    d = madd_f64(d, -camera->d, load_f64(camera->z));
    if (camera->lens_radius > 0) {
        double angle, radius;
        do {
            angle = 2 * M_PI * reference_uniform(random);
            radius = camera->lens_radius * sqrt(reference_uniform(random));
        } while (camera->blades && beyond_blades(camera, angle, radius));
        const vec3_f64 off = madd_f64(scale_f64(radius * cos(angle), right), radius * sin(angle), up);
        out->origin = add_f64(out->origin, off);
        d = madd_f64(d, -camera->d / camera->focus_distance, off);
    }
    out->direction = normalize_f64(d);
}

static void camera_ray(const reference_scene *r, double x, double y, reference_random *random, path *out) {
    const fathom_camera camera = motion_camera(&r->scene->camera, random->time);
    lens_ray(r, &camera, x, y, random, out);
    clip(&camera, out);
}

/* The path starts in the volumes that a ray from its origin leaves without having entered them. */
static void look_around(const reference_scene *r, double time, path *p) {
    path seen = {.nested = 0};
    reference_surface s;
    reference_random random = {0, 0, time};
    vec3_f64 at = p->origin;
    const vec3_f64 up = vec_f64(0.48, 0.8, -0.36);
    while (reference_closest(r, at, up, (double)INFINITY, false, &random, &s)) {
        at = reference_leave(&s, up);
        if (!reference_refracts(s.material)) continue;
        if (s.behind && place_in(&seen, s.material) == seen.nested)
            enter(p, s.material);
        else
            cross(&seen, &s);
        p->overlap |= seen.overlap;
        if (p->overlap) return;
    }
}

typedef struct render {
    reference_scene *scene;
    reference_estimate *out;
} render;

bool reference_sample(reference_scene *r, uint32_t x, uint32_t y, uint32_t index, vec3_f64 *out) {
    const uint64_t pixel = reference_mix(reference_mix(r->settings.seed) + ((uint64_t)y << 32 | x));
    const double *shutter = r->scene->camera.shutter;
    reference_random random = {reference_mix(pixel + index), 0, shutter[0]};
    const pixel_filter *filter = r->settings.filter;
    double u = reference_uniform(&random), v = reference_uniform(&random);
    if (filter) u = filter_place(filter, u), v = filter_place(filter, v);
    path p = {.weight = {1, 1, 1}, .unlit = true, .in_view = true};
    if (shutter[1] > shutter[0])
        random.time += (r->settings.sharp ? 0.5 : reference_uniform(&random)) * (shutter[1] - shutter[0]);
    camera_ray(r, x + u, y + v, &random, &p);
    if (r->refracts) look_around(r, random.time, &p);
    const reference_random own = {reference_mix(random.key), 0, random.time};
    if (radiance(r, p, own, out)) return true;
    r->overlap = true;
    return false;
}

static void render_pixel(render *k, size_t index) {
    const reference_settings *o = &k->scene->settings;
    const uint32_t x = (uint32_t)index % o->width, y = (uint32_t)index / o->width;
    vec3_f64 sum = {0, 0, 0}, squares = {0, 0, 0};
    for (uint32_t i = 0; i < o->samples; ++i) {
        vec3_f64 rgb;
        reference_sample(k->scene, x, y, i, &rgb);
        sum = add_f64(sum, rgb), squares = add_f64(squares, times(rgb, rgb));
    }
    const vec3_f64 mean = scale_f64(1.0 / o->samples, sum);
    const vec3_f64 spread = madd_f64(scale_f64(1.0 / o->samples, squares), -1, times(mean, mean));
    const vec3_f64 error2 = scale_f64(1 / (o->samples - 1.0), spread);
    store_f64(k->out[index].mean, mean);
    store_f64(k->out[index].error,
              vec_f64(sqrt(fmax(error2.x, 0)), sqrt(fmax(error2.y, 0)), sqrt(fmax(error2.z, 0))));
}

static void render_pixels(void *user, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) render_pixel(user, i);
}

/* ---- scenes ---- */

static fathom_status lacking(const fathom_scene *scene, const char *array, size_t index, const char *what) {
    return fail_item(scene->context, FATHOM_BAD_INPUT, array, index,
                     "the reference integrator does not implement %s; render with another one", what);
}

static fathom_status check_scene(const reference_scene *r) {
    const fathom_scene *scene = r->scene;
    if (scene->has_maps) return lacking(scene, "textures", 0, "textures");
    for (size_t i = 0; i < scene->meshes.count; ++i)
        if (scene->meshes.items[i].colors) return lacking(scene, "meshes", i, "vertex colours");
    for (size_t i = 0; i < r->primitives.count; ++i) {
        const reference_primitive *p = &r->primitives.items[i];
        const fathom_id material = r->places.items[p->place].material;
        const fathom_material *m = &scene->materials.items[material].value;
        const bool directed = p->kind == SCENE_SPHERE || p->kind == SCENE_QUAD;
        const char *lacks = reference_lacks(m);
        if (!lacks && m->anisotropy > 0 && !directed) lacks = "anisotropy but of spheres and quads";
        if (lacks) return lacking(scene, "materials", material, lacks);
    }
    return FATHOM_OK;
}

/* The indices of air and of the volumes that may surround those of material `at`, each once. */
static unsigned indices_around(const reference_scene *r, size_t at, double *out) {
    const fathom_material *m = &r->scene->materials.items[at].value;
    unsigned count = 1;
    out[0] = 1;
    for (size_t i = 0; i < r->scene->materials.count && m->priority; ++i) {
        const fathom_material *other = &r->scene->materials.items[i].value;
        bool is_new = i != at && reference_refracts(other) && other->priority;
        for (unsigned k = 0; k < count; ++k) is_new &= out[k] != (double)other->ior;
        if (is_new) out[count++] = (double)other->ior;
    }
    return count;
}

static fathom_status make_albedos(reference_scene *r) {
    const size_t count = r->scene->materials.count;
    double *around = calloc(count + 1, sizeof *around);
    bool made = (r->albedos = calloc(count + 1, sizeof *r->albedos)) != NULL && around;
    for (size_t i = 0; i < count && made; ++i) {
        const unsigned indices = indices_around(r, i, around);
        made = reference_albedos_make(&r->scene->materials.items[i].value, around, indices, &r->albedos[i]);
    }
    free(around);
    return made ? FATHOM_OK : fail_memory(r->scene->context, sizeof(reference_albedos));
}

fathom_status reference_open(const fathom_scene *scene, const reference_settings *settings,
                             reference_scene **out) {
    reference_scene *r = calloc(1, sizeof *r);
    *out = NULL;
    if (!r) return fail_memory(scene->context, sizeof *r);
    r->scene = scene, r->settings = *settings;
    fathom_status status = reference_gather(r);
    if (status == FATHOM_OK) status = check_scene(r);
    if (status == FATHOM_OK) status = make_albedos(r);
    if (status == FATHOM_OK) status = reference_skies_open(r);
    for (size_t i = 0; i < scene->materials.count; ++i)
        r->refracts |= reference_refracts(&scene->materials.items[i].value);
    if (status == FATHOM_OK)
        *out = r;
    else
        reference_close(r);
    return status;
}

void reference_close(reference_scene *r) {
    if (!r) return;
    for (size_t i = 0; r->albedos && i < r->scene->materials.count; ++i) free(r->albedos[i]);
    free(r->albedos);
    reference_skies_close(r);
    array_free(&r->places);
    array_free(&r->links);
    array_free(&r->primitives);
    array_free(&r->planes);
    array_free(&r->lamps);
    free(r->tree.nodes);
    free(r->items);
    free(r);
}

fathom_status reference_check(const reference_scene *r) {
    return r && r->overlap ? lacking(r->scene, "shapes", 0, "volumes of two materials that overlap")
                           : FATHOM_OK;
}

fathom_status reference_render(const fathom_scene *scene, const reference_settings *settings,
                               reference_estimate *out) {
    reference_scene *r;
    fathom_status status = reference_open(scene, settings, &r);
    if (status != FATHOM_OK) return status;
    render k = {.scene = r, .out = out};
    const size_t pixels = (size_t)settings->width * settings->height;
    loop_parallel(settings->threads ? settings->threads : 1, pixels, 1, render_pixels, &k);
    status = reference_check(r);
    reference_close(r);
    return status;
}
