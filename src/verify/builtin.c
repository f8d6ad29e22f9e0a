#include "verify/builtin.h"

#include "scene/scene.h"
#include "verify/extremes/case.h"

#include <stdio.h>
#include <string.h>

static vec3_f64 scattered_center(unsigned i) { return case_scattered_point(i, 0, 2); }

static void add_spheres(judged_scene *c) {
    for (unsigned i = 0; i < 24; ++i)
        build_sphere(&c->b, scattered_center(i), 0.5 * pow(10, case_scattered(i, 3, -3, 0.3)), 0);
}

static void add_quads(judged_scene *c) {
    for (unsigned i = 0; i < 24; ++i) {
        double angle = case_scattered(i, 3, 0, 6.28), size = case_scattered(i, 4, 0.1, 1);
        build_quad(&c->b, scattered_center(i), vec_f64(size * cos(angle), size * sin(angle), 0),
                   vec_f64(-0.3 * sin(angle), 0.3 * cos(angle), size), 0);
    }
}

static void add_ball(judged_scene *c) { case_ball_of(c, vec_f64(0, 0, 0), 1, 19, 40); }

static void add_planes(judged_scene *c) {
    build_plane(&c->b, vec_f64(-0.7, 0, 0), vec_f64(0, 1, 0), 0);
    build_plane(&c->b, vec_f64(0, -1.4, 0), vec_f64(0.6, 0.8, 0), 0);
    build_plane(&c->b, vec_f64(0, 0, -0.7 * 3), vec_f64(0.3, -0.2, 2), 0);
}

/* A box on multiples of 1/16 with sides that are powers of two: intersections with rays along an axis are
 * exact. */
static void add_box(judged_scene *c, vec3_f64 low, vec3_f64 size) {
    static const uint32_t sides[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                       2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    vec3_f64 corner[8];
    for (unsigned k = 0; k < 8; ++k)
        corner[k] =
            vec_f64(low.x + (k & 1 ? size.x : 0), low.y + (k & 2 ? size.y : 0), low.z + (k & 4 ? size.z : 0));
    build_triangles(&c->b, vec_f64(0, 0, 0), corner, 8, sides, 12, 0);
}

static void add_boxes(judged_scene *c) {
    add_box(c, vec_f64(-1, -1, -1), vec_f64(2, 2, 2));
    add_box(c, vec_f64(1, -1, -1), vec_f64(0.5, 1, 2)); /* touches the first */
    add_box(c, vec_f64(-3, 0, -0.5), vec_f64(1, 4, 1));
    add_box(c, vec_f64(-0.25, 1.5, 0), vec_f64(0.5, 0.5, 0.5));
}

/* Similar, with quads and planes. */
static void add_squares(judged_scene *c) {
    build_quad(&c->b, vec_f64(0, 0, 0), vec_f64(1, 0, 0), vec_f64(0, 1, 0), 0);
    build_quad(&c->b, vec_f64(2, 0, 0.5), vec_f64(0, 1, 0), vec_f64(0, 0, 0.5), 0);
    build_quad(&c->b, vec_f64(0, 1.5, 1), vec_f64(0, 0, 0.25), vec_f64(2, 0, 0), 0);
    build_plane(&c->b, vec_f64(0, -1.5, 0), vec_f64(0, 1, 0), 0);
    build_plane(&c->b, vec_f64(3, 0, 0), vec_f64(-1, 0, 0), 0);
}

/* More than 2^16 vertices and 2^18 triangles. */
static void add_fine(judged_scene *c) { case_ball_of(c, vec_f64(0, 0, 0), 1, 366, 366); }

/* Shapes that cast no shadow, around and between shapes that do. */
static void add_masks(judged_scene *c) {
    c->b.flags = FATHOM_CASTS_NO_SHADOW;
    case_ball_of(c, vec_f64(0, 0, 0), 1.4, 9, 16);
    add_box(c, vec_f64(2, -1, -1), vec_f64(1, 2, 2));
    c->b.flags = 0;
    case_ball_of(c, vec_f64(0, 0, 0), 1, 9, 16);
    add_box(c, vec_f64(4, -1, -1), vec_f64(1, 2, 2));
}

static void add_masked_shapes(judged_scene *c) {
    static const affine_f64 mirrored = {{{-0.8, 0.1, 0, 6}, {0, 0.7, 0, 0.3}, {0.2, 0, 1.1, 0}}};
    const fathom_id group = build_group(&c->b);
    for (unsigned i = 0; i < 2; ++i) {
        c->b.flags = i ? 0 : FATHOM_CASTS_NO_SHADOW;
        for (unsigned k = i; k < 8; k += 2) {
            c->b.group = group;
            build_sphere(&c->b, scattered_center(k), 0.4, 0);
            c->b.group = FATHOM_ROOT;
            build_sphere(&c->b, scattered_center(k + 20), 0.3, 0);
            c->b.group = k % 4 < 2 ? group : FATHOM_ROOT;
            build_quad(&c->b, scattered_center(k + 40), vec_f64(0.5, 0.1, 0), vec_f64(0, 0.2, 0.6), 0);
        }
        c->b.group = i ? group : FATHOM_ROOT;
        case_ball_of(c, vec_f64(0.3, 0, 2.5 * i), 0.7, 9, 16);
        build_plane(&c->b, vec_f64(0, -3.0 - i, 0), vec_f64(0, 1, 0), 0);
        build_plane(&c->b, vec_f64(0, 0, -5.0 + i), vec_f64(0.1, 0, 1), 0);
    }
    c->b.flags = 0;
    build_place(&c->b, group, FATHOM_ROOT, &mirrored);
}

/* All bounded shapes, rotated, scaled, sheared and mirrored. */
static void add_instances(judged_scene *c) {
    static const affine_f64 maps[5] = {{{{0.5, 0, 0, 3}, {0, 1.5, 0, 0}, {0, 0, 0.2, 0.5}}},
                                       {{{-1, 0, 0, -3}, {0, 1, 0, 0.3}, {0, 0, 1, 0}}},
                                       {{{0.6, -0.8, 0, 0}, {0.8, 0.6, 0.1, 4}, {0, 0.2, 0.7, 0}}},
                                       {{{1, 0.3, 0, 0}, {0, 1, 0, -4}, {0.1, 0, -1.1, 0.4}}},
                                       {{{100, 0, 0, 20}, {0, 0, -100, 30}, {0, 100, 0, 400}}}};
    const fathom_id group = c->b.group = build_group(&c->b);
    add_spheres(c);
    add_quads(c);
    add_ball(c);
    for (unsigned i = 0; i < 5; ++i) build_place(&c->b, group, FATHOM_ROOT, &maps[i]);
}

static const struct {
    const char *name;
    void (*add)(judged_scene *c);
} scenes[] = {{"spheres", add_spheres}, {"quads", add_quads},         {"triangles", add_ball},
              {"planes", add_planes},   {"instances", add_instances}, {"boxes", add_boxes},
              {"squares", add_squares}, {"masks", add_masks},         {"masked-shapes", add_masked_shapes},
              {"fine", add_fine}};

const char *builtin_name(unsigned index) {
    return index < sizeof scenes / sizeof *scenes ? scenes[index].name : NULL;
}

static fathom_status create(fathom_context *context, unsigned index, fathom_scene **out) {
    judged_scene c;
    memset(&c, 0, sizeof c);
    build_open(context, &c.b);
    if (c.b.status == FATHOM_OK) scenes[index].add(&c);
    build_point_light(&c.b, vec_f64(3, 6, 4), vec_f64(1, 1, 1), 0);
    build_finish(&c.b);
    fathom_status status = c.b.status;
    *out = status == FATHOM_OK ? c.b.scene : NULL;
    if (*out) c.b.scene = NULL;
    judged_close(&c);
    return status;
}

fathom_status builtin_create(fathom_context *context, const char *name, fathom_scene **out) {
    char known[256] = "";
    for (unsigned i = 0; builtin_name(i); ++i) {
        if (strcmp(name, builtin_name(i)) == 0) return create(context, i, out);
        const size_t length = strlen(known);
        snprintf(known + length, sizeof known - length, "%s%s", i ? ", " : "", builtin_name(i));
    }
    return fail_file(context, FATHOM_BAD_INPUT, name, "expected a file, or a built-in scene: %s", known);
}
