/* Shapes and rays that the public API must refuse, each with a message. */
#include "verify/extremes/case.h"

#include <fathom/trace.h>

#include <float.h>
#include <stdio.h>
#include <string.h>

static void count(extremes_row *row, bool right) {
    ++row->rays;
    ++row->counts[right ? VERDICT_AGREE : VERDICT_WRONG];
}

/* ---- shapes ---- */

static const double bad[] = {(double)NAN, (double)INFINITY, -(double)INFINITY};

static bool says_why(fathom_context *context, fathom_status status) {
    return status == FATHOM_BAD_INPUT && strlen(fathom_context_error(context)->text) > 8;
}

static void refuse_spheres(fathom_context *context, fathom_scene *scene, extremes_row *row) {
    for (unsigned i = 0; i < 9; ++i) {
        fathom_sphere sphere;
        fathom_sphere_default(&sphere);
        sphere.center[i % 3] = bad[i / 3];
        count(row, says_why(context, fathom_scene_add_sphere(scene, FATHOM_ROOT, &sphere, NULL)));
    }
    const double radii[] = {(double)NAN, (double)INFINITY, 0, -1};
    for (unsigned i = 0; i < 4; ++i) {
        fathom_sphere sphere;
        fathom_sphere_default(&sphere);
        sphere.radius = radii[i];
        count(row, says_why(context, fathom_scene_add_sphere(scene, FATHOM_ROOT, &sphere, NULL)));
    }
}

static void refuse_quads(fathom_context *context, fathom_scene *scene, extremes_row *row) {
    for (unsigned i = 0; i < 36; ++i) {
        fathom_quad quad;
        fathom_quad_default(&quad);
        quad.corners[i / 3 % 4][i % 3] = bad[i / 12];
        count(row, says_why(context, fathom_scene_add_quad(scene, FATHOM_ROOT, &quad, NULL)));
    }
    fathom_quad quad;
    memset(&quad, 0, sizeof quad);
    count(row, says_why(context, fathom_scene_add_quad(scene, FATHOM_ROOT, &quad, NULL)));
    for (unsigned i = 0; i < 4; ++i) quad.corners[i][0] = i;
    count(row, says_why(context, fathom_scene_add_quad(scene, FATHOM_ROOT, &quad, NULL)));
}

static void refuse_planes(fathom_context *context, fathom_scene *scene, extremes_row *row) {
    for (unsigned i = 0; i < 18; ++i) {
        fathom_plane plane;
        fathom_plane_default(&plane);
        (i < 9 ? plane.point : plane.normal)[i % 3] = bad[i / 3 % 3];
        count(row, says_why(context, fathom_scene_add_plane(scene, FATHOM_ROOT, &plane, NULL)));
    }
    fathom_plane plane;
    fathom_plane_default(&plane);
    plane.normal[2] = 0;
    count(row, says_why(context, fathom_scene_add_plane(scene, FATHOM_ROOT, &plane, NULL)));
}

static void refuse_meshes(fathom_context *context, fathom_scene *scene, extremes_row *row) {
    static const uint32_t whole[3] = {0, 1, 2}, beyond[3] = {0, 1, 3};
    for (unsigned i = 0; i < 28; ++i) {
        float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
        if (i < 27) positions[i % 9] = (float)bad[i / 9];
        fathom_mesh mesh;
        fathom_mesh_default(&mesh);
        mesh.positions = positions, mesh.vertex_count = 3;
        mesh.indices = i < 27 ? whole : beyond, mesh.triangle_count = 1;
        count(row, says_why(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL)));
    }
}

static void refuse_instances(fathom_context *context, fathom_scene *scene, extremes_row *row) {
    fathom_id group;
    if (fathom_scene_add_group(scene, NULL, &group) != FATHOM_OK) return;
    for (unsigned i = 0; i < 37; ++i) {
        fathom_instance instance;
        fathom_instance_default(&instance);
        instance.group = group;
        if (i < 36)
            instance.transform[i % 12] = bad[i / 12];
        else
            instance.transform[5] = 0;
        count(row, says_why(context, fathom_scene_add_instance(scene, &instance, NULL)));
    }
}

static const struct {
    const char *words;
    void (*refuse)(fathom_context *context, fathom_scene *scene, extremes_row *row);
} shapes[] = {
    {"refused: spheres that are none", refuse_spheres},  {"refused: quads that are none", refuse_quads},
    {"refused: planes that are none", refuse_planes},    {"refused: meshes that are none", refuse_meshes},
    {"refused: frames that are none", refuse_instances},
};

fathom_status refused_check(fathom_context *context, const char *tracer, double which, extremes_row *row) {
    (void)tracer;
    size_t k = (size_t)which - 1;
    fathom_scene *scene;
    fathom_status status = fathom_scene_create(context, &scene);
    if (status != FATHOM_OK) return status;
    snprintf(row->words, sizeof row->words, "%s", shapes[k].words);
    shapes[k].refuse(context, scene, row);
    fathom_scene_destroy(scene);
    return FATHOM_OK;
}

/* ---- rays ---- */

/* A ray from distance 3 towards the unit sphere at the origin: t = 2. */
static const fathom_ray good = {{0, 0, 3}, {0, 0, -1}, 0, HUGE_VAL};

typedef struct ray_check {
    const fathom_tracer *tracer;
    fathom_context *context;
    extremes_row *row;
} ray_check;

/* The call must name the bad ray and set the hits of the rays before it. */
static void expect_refusal(const ray_check *c, fathom_ray ray) {
    fathom_ray rays[20];
    fathom_hit hits[20];
    for (int i = 0; i < 20; ++i) rays[i] = good, hits[i].t = 0;
    rays[17] = ray;
    bool right = fathom_tracer_closest(c->tracer, rays, 20, hits) == FATHOM_BAD_USAGE;
    right =
        right && strcmp(fathom_context_error(c->context)->place->field, "rays[17]") == 0 && hits[0].t == 2;
    bool any[20];
    right = right && fathom_tracer_any(c->tracer, rays, 20, any) == FATHOM_BAD_USAGE;
    count(c->row, right);
}

/* t: infinite for a miss. The tolerance is the rounding of a few operations in double: 8 units. */
static void expect_t(const ray_check *c, fathom_ray ray, double t) {
    fathom_hit hit;
    bool any = false;
    bool right = fathom_tracer_closest(c->tracer, &ray, 1, &hit) == FATHOM_OK &&
                 fathom_tracer_any(c->tracer, &ray, 1, &any) == FATHOM_OK;
    bool near = isinf(t) ? isinf(hit.t) : fabs(hit.t - t) <= 8 * 0x1p-53 * fabs(t);
    count(c->row, right && near && any == isfinite(t));
}

static void refuse_bad_numbers(const ray_check *c) {
    for (unsigned i = 0; i < 18; ++i) {
        fathom_ray ray = good;
        (i < 9 ? ray.origin : ray.direction)[i % 3] = bad[i / 3 % 3];
        expect_refusal(c, ray);
    }
}

static void refuse_no_direction(const ray_check *c) {
    for (unsigned i = 0; i < 2; ++i) {
        fathom_ray ray = good;
        ray.direction[2] = i ? -0.0 : 0.0;
        expect_refusal(c, ray);
    }
}

static void refuse_bad_intervals(const ray_check *c) {
    fathom_ray ray = good;
    for (unsigned i = 0; i < 3; ++i) {
        ray.t_min = bad[i];
        expect_refusal(c, ray);
    }
    ray = good, ray.t_max = (double)NAN;
    expect_refusal(c, ray);
}

static void miss_empty_intervals(const ray_check *c) {
    const double ends[5][2] = {{1, 1}, {2, 2}, {3, 1}, {0, -HUGE_VAL}, {0, 0}};
    for (unsigned i = 0; i < 5; ++i) {
        fathom_ray ray = good;
        ray.t_min = ends[i][0], ray.t_max = ends[i][1];
        expect_t(c, ray, HUGE_VAL);
    }
}

/* Directions of any length, including denormal ones in double or in float. */
static void meet_any_length(const ray_check *c) {
    for (int e = -1070; e <= 1020; e += 10) {
        fathom_ray ray = good;
        ray.direction[2] = -ldexp(1, e);
        /* 2 / |d|, if double can represent it. */
        if (e > -1020) expect_t(c, ray, ldexp(2, -e));
    }
}

/* t itself exceeds the range of double, so it cannot be reported. */
static void miss_beyond_range(const ray_check *c) {
    fathom_ray ray = good;
    ray.direction[2] = -DBL_TRUE_MIN;
    expect_t(c, ray, HUGE_VAL);
}

/* A component that float or double cannot represent acts as 0. */
static void meet_denormal_parts(const ray_check *c) {
    const double parts[] = {1e-40, -1e-40, 1e-46, DBL_TRUE_MIN, -DBL_TRUE_MIN};
    for (unsigned i = 0; i < 20; ++i) {
        fathom_ray ray = good;
        (i < 10 ? ray.origin : ray.direction)[i / 5 % 2] = parts[i % 5];
        expect_t(c, ray, 2);
    }
}

static void miss_or_refuse_far_origins(const ray_check *c) {
    for (int e = 60; e <= 1020; e += 60) {
        fathom_ray ray = good;
        ray.origin[2] = ldexp(1, e);
        expect_refusal(c, ray);
    }
    fathom_ray ray = good;
    for (int e = 5; e < 50; e += 5) {
        ray.origin[2] = ldexp(1, e);
        expect_t(c, ray, ldexp(1, e) - 1);
    }
}

static const struct {
    const char *words;
    void (*check)(const ray_check *c);
} rays[] = {
    {"refused: rays with NaN or infinity", refuse_bad_numbers},
    {"refused: directions of zero", refuse_no_direction},
    {"refused: intervals with NaN", refuse_bad_intervals},
    {"missed: empty intervals", miss_empty_intervals},
    {"met: directions 1e-307 to 1e307 long", meet_any_length},
    {"missed: t beyond any double", miss_beyond_range},
    {"met: rays with denormal parts", meet_denormal_parts},
    {"refused: origins beyond 1e18", miss_or_refuse_far_origins},
};

fathom_status user_rays_check(fathom_context *context, const char *words, double which, extremes_row *row) {
    size_t k = (size_t)which - 1;
    snprintf(row->words, sizeof row->words, "%s", rays[k].words);
    fathom_scene *scene;
    fathom_status status = fathom_scene_create(context, &scene);
    if (status != FATHOM_OK) return status;
    fathom_sphere sphere;
    fathom_sphere_default(&sphere);
    fathom_tracer *tracer = NULL;
    status = fathom_scene_add_sphere(scene, FATHOM_ROOT, &sphere, NULL);
    if (status == FATHOM_OK) status = fathom_scene_complete(scene);
    if (status == FATHOM_OK) status = fathom_tracer_create(context, scene, words, &tracer);
    if (status == FATHOM_OK) {
        ray_check c = {tracer, context, row};
        rays[k].check(&c);
    }
    fathom_tracer_destroy(tracer);
    fathom_scene_destroy(scene);
    return status;
}
