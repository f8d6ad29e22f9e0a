#include "verify/builtin.h"

#include "scene/scene.h"
#include "verify/extremes/case.h"

#include <string.h>

static vec3_f64 scattered_center(unsigned i) {
    return vec_f64(case_scattered(i, 0, -2, 2), case_scattered(i, 1, -2, 2), case_scattered(i, 2, -2, 2));
}

static void add_spheres(extremes_case *c, fathom_id group) {
    for (unsigned i = 0; i < 24; ++i)
        case_sphere(c, group, scattered_center(i), 0.5 * pow(10, case_scattered(i, 3, -3, 0.3)));
}

static void add_quads(extremes_case *c, fathom_id group) {
    for (unsigned i = 0; i < 24; ++i) {
        double angle = case_scattered(i, 3, 0, 6.28), size = case_scattered(i, 4, 0.1, 1);
        case_quad(c, group, scattered_center(i), vec_f64(size * cos(angle), size * sin(angle), 0),
                  vec_f64(-0.3 * sin(angle), 0.3 * cos(angle), size));
    }
}

static void add_ball(extremes_case *c, fathom_id group) {
    case_ball_of(c, group, vec_f64(0, 0, 0), 1, 19, 40);
}

static void add_planes(extremes_case *c, fathom_id group) {
    (void)group; /* planes cannot be placed but in the world */
    case_plane(c, vec_f64(-0.7, 0, 0), vec_f64(0, 1, 0));
    case_plane(c, vec_f64(0, -1.4, 0), vec_f64(0.6, 0.8, 0));
    case_plane(c, vec_f64(0, 0, -0.7 * 3), vec_f64(0.3, -0.2, 2));
}

/* Everything that has bounds, turned, squeezed, sheared and mirrored. */
static void add_instances(extremes_case *c, fathom_id parent) {
    static const affine_f64 maps[5] = {{{{0.5, 0, 0, 3}, {0, 1.5, 0, 0}, {0, 0, 0.2, 0.5}}},
                                       {{{-1, 0, 0, -3}, {0, 1, 0, 0.3}, {0, 0, 1, 0}}},
                                       {{{0.6, -0.8, 0, 0}, {0.8, 0.6, 0.1, 4}, {0, 0.2, 0.7, 0}}},
                                       {{{1, 0.3, 0, 0}, {0, 1, 0, -4}, {0.1, 0, -1.1, 0.4}}},
                                       {{{100, 0, 0, 20}, {0, 0, -100, 30}, {0, 100, 0, 400}}}};
    fathom_id group = case_group(c);
    add_spheres(c, group);
    add_quads(c, group);
    add_ball(c, group);
    for (unsigned i = 0; i < 5; ++i) case_instance(c, group, parent, &maps[i]);
}

static const struct {
    const char *name;
    void (*add)(extremes_case *c, fathom_id group);
} scenes[] = {{"spheres", add_spheres},
              {"quads", add_quads},
              {"triangles", add_ball},
              {"planes", add_planes},
              {"instances", add_instances}};

const char *builtin_name(unsigned index) {
    return index < sizeof scenes / sizeof *scenes ? scenes[index].name : NULL;
}

fathom_status builtin_create(fathom_context *context, unsigned index, fathom_scene **out) {
    extremes_case c = {.context = context};
    c.status = fathom_scene_create(context, &c.scene);
    if (c.status == FATHOM_OK) scenes[index].add(&c, FATHOM_ROOT);
    if (c.status == FATHOM_OK) c.status = fathom_scene_complete(c.scene);
    if (c.status == FATHOM_OK) c.status = fathom_scene_check(c.scene);
    fathom_status status = c.status;
    *out = status == FATHOM_OK ? c.scene : NULL;
    if (*out) c.scene = NULL;
    case_close(&c);
    return status;
}
