/* A demonstration scene at the origin, and moved by the Earth's radius in double coordinates. The renderer
 * shifts coordinates to an origin near the view before they become float, so the images are the same. */
#include "trace/spec.h"
#include "verify/light/shading_studio.h"

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

static void place(demo *d, fathom_id group, vec3_f64 center, double a, double b, double c) {
    const affine_f64 map = {{{a, 0, 0.1, center.x}, {0, b, 0, center.y}, {-0.1, 0, c, center.z}}};
    build_place(&d->s.b, group, FATHOM_ROOT, &map);
}

/* A ball of triangles with normals, placed twice. */
static void add_meshes(demo *d, fathom_material shiny) {
    builder *b = &d->s.b;
    const fathom_id group = build_group(b);
    fathom_generate_options ball;
    fathom_generate_options_default(&ball);
    ball.triangles = 224, ball.material = build_material(b, shiny);
    if (b->status == FATHOM_OK) b->status = fathom_scene_generate(b->scene, group, &ball);
    place(d, group, at(d, 2.1, 0.5, 1.6), 0.5, 0.5, 0.5);
    place(d, group, at(d, -0.9, 0.35, 2.2), 0.6, 0.35, 0.3);
}

static void add_shapes(demo *d) {
    studio *s = &d->s;
    fathom_material matte = build_lambert(vec_f64(0.6, 0.55, 0.45)),
                    shiny = build_lambert(vec_f64(0.1, 0.3, 0.5)),
                    mirror = build_lambert(vec_f64(0.03, 0.03, 0.03)), glass = studio_glass(1.5f);
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
    build_point_light(&d->s.b, at(d, -3, 5, 3), vec_f64(22, 20, 17), 0);
    fathom_light light =
        build_light_of(FATHOM_LIGHT_SPOT, at(d, 4, 5, 2), vec_f64(-3.5, -5, -1.5), vec_f64(20, 20, 20));
    light.inner_angle = 0.3f, light.outer_angle = 0.5f;
    build_light(&d->s.b, &light);
    build_directional_light(&d->s.b, vec_f64(0.3, -1, -0.6), vec_f64(0.25, 0.25, 0.25), 0);
}

static void set_view(demo *d) {
    studio *s = &d->s;
    static const float ambient[3] = {0.12f, 0.12f, 0.12f};
    build_camera(&s->b, build_view(at(d, 0.8, 2.3, 7), at(d, 0.1, 0.8, 0), d->field));
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

static fathom_status render_moved(fathom_context *context, const shading_options *options, double distance,
                                  uint32_t spp, fathom_film **out) {
    demo d;
    *out = NULL;
    open_demo(context, options, distance, &d);
    d.s.settings.spp = spp;
    if (d.s.b.status == FATHOM_OK)
        d.s.b.status =
            fathom_render(context, d.s.b.scene, &d.s.settings, options->progress, options->user, NULL, out);
    if (d.s.b.status != FATHOM_OK) {
        fathom_film_destroy(*out); /* after an interruption: a partial image */
        *out = NULL;
    }
    return studio_end(&d.s);
}

/* The largest difference of a channel. *broken: channels that are not finite. */
static double compare(const fathom_film *a, const fathom_film *b, uint64_t *broken) {
    static const char *const names[3] = {"R", "G", "B"};
    double most = 0;
    *broken = 0;
    for (int c = 0; c < 3; ++c) {
        const float *x = fathom_film_channel(a, names[c]), *y = fathom_film_channel(b, names[c]);
        for (uint32_t i = 0; i < WIDTH * HEIGHT; ++i) {
            if (!isfinite(x[i]) || !isfinite(y[i])) ++*broken;
            most = fmax(most, fabs((double)x[i] - (double)y[i]));
        }
    }
    return most;
}

/* Pixels at edges may show either side if coordinates round differently. Of the samples in such pixels, one
 * in 10^4 is that close to an edge (6e-7 m, for pixels of 2 cm), so the bound allows for none. */
static fathom_status add_row(fathom_context *context, const shading_options *options, shading_rows *rows,
                             double distance, const fathom_film *first, const fathom_film *moved) {
    studio s = {.b = {.context = context}, .options = options, .rows = rows};
    studio_judge(&s, 0, compare(first, moved, &s.broken), 0, 1e-3);
    studio_row(&s, 0, "earth", distance, "largest change of a pixel when a scene is moved by %g m", distance);
    return s.b.status;
}

/* Slow tracers get fewer rays. */
static bool is_slow(const trace_spec *spec) { return spec->kind != TRACE_EMBREE; }
static bool is_hopeless(const trace_spec *spec) {
    return spec->kind == TRACE_LINEAR && spec->precision == TRACE_F128;
}

fathom_status shading_earth(fathom_context *context, const shading_options *options, shading_rows *rows) {
    static const double distances[] = {6.371e6, 1e3, 1e5, 1e8};
    trace_spec spec;
    fathom_status status = trace_spec_parse(context, options->spec, &spec);
    if (status != FATHOM_OK || is_hopeless(&spec)) return status;
    const size_t count = is_slow(&spec) ? 1 : sizeof distances / sizeof *distances;
    const uint32_t spp = is_slow(&spec) ? 1 : 4;
    fathom_film *first, *moved;
    status = render_moved(context, options, 0, spp, &first);
    for (size_t k = 0; k < count && status == FATHOM_OK; ++k) {
        status = render_moved(context, options, distances[k], spp, &moved);
        if (status == FATHOM_OK) status = add_row(context, options, rows, distances[k], first, moved);
        fathom_film_destroy(moved);
    }
    fathom_film_destroy(first);
    return status;
}
