/* A demonstration scene at the origin, and moved by the Earth's radius in double coordinates. The renderer
 * shifts coordinates to an origin near the view before they become float, so the images are the same. Another
 * image shows the moved scene without this shift: float positions are half a metre apart. */
#include "job/render.h"
#include "trace/spec.h"
#include "verify/light/shading_studio.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 240
#define HEIGHT 180

/* ---- the scene ---- */

typedef struct demo {
    studio s;
    vec3_f64 shift;
    double field; /* field of view */
} demo;

static vec3_f64 at(const demo *d, double x, double y, double z) {
    return add_f64(d->shift, (vec3_f64){x, y, z});
}

/* A ball of triangles with normals. */
enum { ROWS = 8, AROUND = 16, VERTICES = (ROWS + 1) * AROUND, TRIANGLES = 2 * (ROWS - 1) * AROUND };

static void fill_ball(float *p, uint32_t *t) {
    for (uint32_t i = 0; i < VERTICES; ++i, p += 3) {
        double theta = 3.14159265358979 * (i / AROUND) / ROWS, phi = 6.28318530717959 * (i % AROUND) / AROUND;
        p[0] = (float)(sin(theta) * cos(phi));
        p[1] = (float)cos(theta);
        p[2] = (float)(-sin(theta) * sin(phi));
    }
    for (uint32_t i = 0; i < ROWS * AROUND; ++i) {
        uint32_t a = i, b = i / AROUND * AROUND + (i + 1) % AROUND, c = a + AROUND, d = b + AROUND;
        /* At the poles one of each two triangles has no area; it is left out. */
        if (i >= AROUND) t[0] = a, t[1] = c, t[2] = b, t += 3;
        if (i < (ROWS - 1) * AROUND) t[0] = b, t[1] = c, t[2] = d, t += 3;
    }
}

static void add_ball(demo *d, fathom_material shiny) {
    float positions[3 * VERTICES];
    uint32_t indices[3 * TRIANGLES];
    fill_ball(positions, indices);
    fathom_mesh mesh;
    fathom_mesh_default(&mesh);
    mesh.positions = mesh.normals = positions, mesh.vertex_count = mesh.normal_count = VERTICES;
    mesh.indices = indices, mesh.triangle_count = TRIANGLES;
    build_mesh(&d->s.b, mesh, build_material(&d->s.b, shiny));
}

static void place(demo *d, fathom_id group, vec3_f64 center, double a, double b, double c) {
    const double map[12] = {a, 0, 0.1, center.x, 0, b, 0, center.y, -0.1, 0, c, center.z};
    build_place(&d->s.b, group, FATHOM_ROOT, map);
}

static void add_meshes(demo *d, fathom_material shiny) {
    const fathom_id group = d->s.b.group = build_group(&d->s.b);
    add_ball(d, shiny);
    d->s.b.group = FATHOM_ROOT;
    place(d, group, at(d, 2.1, 0.5, 1.6), 0.5, 0.5, 0.5);
    place(d, group, at(d, -0.9, 0.35, 2.2), 0.6, 0.35, 0.3);
}

static void add_shapes(demo *d) {
    studio *s = &d->s;
    fathom_material matte = studio_lambert(0.6, 0.55, 0.45), shiny = studio_lambert(0.1, 0.3, 0.5),
                    mirror = studio_lambert(0.03, 0.03, 0.03), glass = studio_glass(1.5f);
    for (int c = 0; c < 3; ++c) shiny.k_s[c] = 0.4f, mirror.k_r[c] = 0.85f, glass.k_r[c] = 1;
    shiny.specular = FATHOM_SPECULAR_BLINN, shiny.shininess = 80;
    glass.fresnel = true;
    paint_plane(&s->b, at(d, 0, 0, 0), (vec3_f64){0, 1, 0}, matte);
    paint_sphere(&s->b, at(d, -1.6, 0.9, 0), 0.9, mirror);
    paint_sphere(&s->b, at(d, 0.6, 0.7, 0.8), 0.7, glass);
    paint_sphere(&s->b, at(d, 1.4, 0.5, -1.2), 0.5, matte);
    paint_quad(&s->b, at(d, 0.3, 1.3, -3), (vec3_f64){2.6, 0, 0.4}, (vec3_f64){0, 1.3, 0}, mirror);
    paint_quad(&s->b, at(d, 0.7, 0.25, 2.6), (vec3_f64){0.25, 0, -0.1}, (vec3_f64){0, 0.25, 0.05}, shiny);
    add_meshes(d, shiny);
}

static void add_lights(demo *d) {
    studio_point_light(&d->s, at(d, -3, 5, 3), 22, 20, 17);
    fathom_light light;
    fathom_light_default(&light);
    light.type = FATHOM_LIGHT_SPOT;
    store_f64(light.position, at(d, 4, 5, 2));
    store_f64(light.direction, (vec3_f64){-3.5, -5, -1.5});
    light.inner_angle = 0.3f, light.outer_angle = 0.5f;
    light.intensity[0] = light.intensity[1] = light.intensity[2] = 20;
    build_light(&d->s.b, &light);
    build_directional_light(&d->s.b, vec_f64(0.3, -1, -0.6), vec_f64(0.25, 0.25, 0.25), 0);
}

static void set_view(demo *d) {
    studio *s = &d->s;
    static const float ambient[3] = {0.12f, 0.12f, 0.12f};
    static const double up[3] = {0, 1, 0};
    double eye[3], target[3];
    store_f64(eye, at(d, 0.8, 2.3, 7)), store_f64(target, at(d, 0.1, 0.8, 0));
    fathom_camera camera;
    fathom_camera_look_at(eye, target, up, d->field, &camera);
    build_camera(&s->b, &camera);
    build_background(&s->b, vec_f64(0.35, 0.45, 0.6));
    if (s->b.status == FATHOM_OK) s->b.status = fathom_scene_set_ambient(s->b.scene, ambient);
    s->settings.width = WIDTH, s->settings.height = HEIGHT;
    s->settings.max_depth = 8, s->settings.min_weight = 1.0f / 65536;
}

/* Moves the scene along (0.48, 0.6, 0.64), which is unit and parallel to no axis. */
static void open_demo(fathom_context *context, const shading_options *options, double distance, demo *d) {
    *d = (demo){.s = {.b = {.context = context}, .options = options},
                .shift = scale_f64(distance, (vec3_f64){0.48, 0.6, 0.64}),
                .field = 0.68};
    studio_begin(&d->s, WIDTH);
    /* To test this check: a different view at the origin. */
    if (distance == 0) d->field = studio_twisted(&d->s, d->field);
    add_shapes(d);
    add_lights(d);
    set_view(d);
}

/* ---- images of it ---- */

/* How the scene is rendered. */
typedef struct way {
    const char *spec;
    double distance;
    uint32_t spp;
    bool counted_from_zero; /* world coordinates are relative to the scene's own origin */
} way;

static fathom_status render_way(fathom_context *context, const shading_options *options, const way *w,
                                fathom_film **out) {
    static const vec3_f64 zero = {0, 0, 0};
    demo d;
    *out = NULL;
    open_demo(context, options, w->distance, &d);
    d.s.settings.spp = w->spp;
    d.s.settings.tracer = w->spec;
    const render_request request = {
        .progress = options->progress, .user = options->user, .origin = w->counted_from_zero ? &zero : NULL};
    if (d.s.b.status == FATHOM_OK)
        d.s.b.status = render_film(context, d.s.b.scene, &d.s.settings, &request, NULL, out);
    if (d.s.b.status != FATHOM_OK) {
        fathom_film_destroy(*out); /* after an interruption: a partial image */
        *out = NULL;
    }
    return studio_end(&d.s);
}

typedef struct difference {
    double most, mean;
    uint32_t beyond; /* pixels that differ by more than 1e-3 */
    uint32_t broken; /* channels that are not finite */
} difference;

static difference compare(const fathom_film *a, const fathom_film *b) {
    static const char *const names[3] = {"R", "G", "B"};
    difference out = {.most = 0};
    for (uint32_t i = 0; i < WIDTH * HEIGHT; ++i) {
        double most = 0;
        for (int c = 0; c < 3; ++c) {
            double x = (double)fathom_film_channel(a, names[c])[i],
                   y = (double)fathom_film_channel(b, names[c])[i];
            if (!isfinite(x) || !isfinite(y)) ++out.broken;
            most = fmax(most, fabs(x - y));
            out.mean += fabs(x - y) / (3.0 * WIDTH * HEIGHT);
        }
        out.most = fmax(out.most, most);
        out.beyond += most > 1e-3 ? 1 : 0;
    }
    return out;
}

/* Image k of the ways below. */
static void describe(unsigned k, const way *w, const difference *d, shading_image *out) {
    static const char *const titles[] = {"At the origin", "At the Earth's radius",
                                         "At the Earth's radius, float coordinates"};
    /* The tracer; the distance. */
    static const char *const captions[] = {
        "A scene of 10 m at the origin of coordinates, by %1$s.",
        ("The same scene, lights and camera moved by %2$g m along no axis, by %1$s: positions are "
         "double, and counted from near the view before they become float."),
        "Moved as far, by %1$s, but in float coordinates, half a metre apart there."};
    snprintf(out->title, sizeof out->title, "%s", titles[k]);
    snprintf(out->caption, sizeof out->caption, captions[k], w->spec, w->distance);
    size_t used = strlen(out->caption);
    if (!k) return;
    snprintf(out->caption + used, sizeof out->caption - used,
             " From the first image any pixel differs by at most %.2g, by %.2g in the mean, and %u of %d by "
             "more than 1e-3.",
             d->most, d->mean, d->beyond, WIDTH * HEIGHT);
}

static fathom_status keep(fathom_context *context, unsigned k, const way *w, const fathom_film *film,
                          const difference *d, shading_images *images) {
    shading_image image = {.difference = d->most};
    describe(k, w, d, &image);
    fathom_status status = film_encode_png(context, film, &image.png, &image.png_bytes);
    if (status == FATHOM_OK && !array_push(images, image)) status = fail_memory(context, sizeof image);
    if (status != FATHOM_OK) free(image.png);
    return status;
}

/* ---- all images ---- */

/* Pixels at edges may show either side if coordinates round differently. Of the samples in such pixels, one
 * in 10^4 is that close to an edge (6e-7 m, for pixels of 2 cm), so the bound allows for none. */
static fathom_status add_row(fathom_context *context, const shading_options *options, shading_rows *rows,
                             double distance, const difference *d) {
    studio s = {.b = {.context = context}, .options = options, .rows = rows, .broken = d->broken};
    studio_judge(&s, 0, d->most, 0, 1e-3);
    studio_row(&s, 0, "earth", distance, "largest change of a pixel when a scene is moved by %g m", distance);
    return s.b.status;
}

/* Renders w's image and compares it with the first one. */
static fathom_status render_compared(fathom_context *context, const shading_options *options, const way *w,
                                     fathom_film **first, fathom_film **film, difference *out) {
    fathom_status status = render_way(context, options, w, film);
    if (status != FATHOM_OK) return status;
    if (!*first) *first = *film;
    *out = compare(*first, *film);
    return FATHOM_OK;
}

static void release(fathom_film *film, const fathom_film *first) {
    if (film != first) fathom_film_destroy(film);
}

/* Slow tracers get fewer rays. */
static bool is_slow(const trace_spec *spec) { return spec->kind != TRACE_EMBREE; }
static bool is_hopeless(const trace_spec *spec) {
    return spec->kind == TRACE_LINEAR && spec->precision == TRACE_F128;
}

fathom_status shading_earth(fathom_context *context, const shading_options *options, shading_rows *rows) {
    static const double distances[] = {0, 6.371e6, 1e3, 1e5, 1e8};
    trace_spec spec;
    fathom_status status = trace_spec_parse(context, options->spec, &spec);
    if (status != FATHOM_OK || is_hopeless(&spec)) return status;
    size_t count = is_slow(&spec) ? 2 : sizeof distances / sizeof *distances;
    fathom_film *first = NULL;
    for (size_t k = 0; k < count && status == FATHOM_OK; ++k) {
        const way w = {.spec = options->spec, .distance = distances[k], .spp = is_slow(&spec) ? 1 : 4};
        fathom_film *film;
        difference d;
        status = render_compared(context, options, &w, &first, &film, &d);
        if (status == FATHOM_OK && k) status = add_row(context, options, rows, w.distance, &d);
        release(film, first);
    }
    fathom_film_destroy(first);
    return status;
}

fathom_status shading_earth_images(fathom_context *context, const shading_options *options,
                                   shading_images *images) {
    static const way ways[] = {{.spec = "embree", .spp = 4},
                               {.spec = "embree", .spp = 4, .distance = 6.371e6},
                               {.spec = "embree", .spp = 4, .distance = 6.371e6, .counted_from_zero = true}};
    fathom_film *first = NULL;
    fathom_status status = FATHOM_OK;
    for (unsigned k = 0; k < sizeof ways / sizeof *ways && status == FATHOM_OK; ++k) {
        fathom_film *film;
        difference d;
        status = render_compared(context, options, &ways[k], &first, &film, &d);
        if (status == FATHOM_OK) status = keep(context, k, &ways[k], film, &d, images);
        release(film, first);
    }
    fathom_film_destroy(first);
    return status;
}
