/* Rays of one's own: what a hit says, against closed forms, on both tracers and at any place and size. */
#include "stage.h"

#include <float.h>
#include <pthread.h>
#include <sys/wait.h>
#include <unistd.h>

static const char *const kinds[] = {"embree", "reference"};

UNIT_OWNS(user_tracer, fathom_tracer, fathom_tracer_destroy)

static fathom_tracer *stage_tracer(stage *s, const char *kind) {
    fathom_tracer *tracer = NULL;
    assert_ok(s->context, fathom_tracer_create(s->context, s->scene, kind, &tracer));
    return own_user_tracer(tracer);
}

static fathom_hit shoot(stage *s, const fathom_tracer *tracer, fathom_ray ray) {
    fathom_hit hit;
    bool any;
    assert_ok(s->context, fathom_tracer_closest(tracer, &ray, 1, &hit));
    assert_ok(s->context, fathom_tracer_any(tracer, &ray, 1, &any));
    assert_int_equal(any, hit.t < HUGE_VAL);
    return hit;
}

static void vectors_near(const double *a, double x, double y, double z, double tolerance) {
    assert_near(a[0], x, tolerance);
    assert_near(a[1], y, tolerance);
    assert_near(a[2], z, tolerance);
}

static void normals_near(const float *a, double x, double y, double z) {
    /* Computed in double, stored as float. */
    assert_near(a[0], x, 0x1p-23);
    assert_near(a[1], y, 0x1p-23);
    assert_near(a[2], z, 0x1p-23);
}

/* ---- rays that start on a surface ---- */

/* A cube, a grid, a quad, a sphere and a plane in the root, and all but the plane again in two instances. */
static void add_surfaces(stage *s) {
    static const float p[] = {1, 1, 1, 2, 1, 1, 1, 2, 1, 2, 2, 1, 1, 1, 2, 2, 1, 2, 1, 2, 2, 2, 2, 2};
    static const uint32_t t[] = {0, 1, 2, 3, 2, 1, 4, 6, 5, 7, 5, 6, 0, 4, 1, 5, 1, 4,
                                 2, 3, 6, 7, 6, 3, 0, 2, 4, 6, 4, 2, 1, 5, 3, 7, 3, 5};
    const double center[3] = {-1, -1, 0.5}, u[3] = {0.7, 0.1, 0.2}, v[3] = {-0.1, 0.6, 0.3};
    const double maps[2][12] = {{0.6, -0.8, 0, 4, 0.8, 0.6, 0, 0, 0, 0, 1, 0},
                                {-2, 0, 0, -4, 0, 0.5, 0, 3, 0.1, 0, 1, 1}};
    fathom_mesh mesh = default_mesh();
    mesh.positions = p, mesh.vertex_count = 8, mesh.indices = t, mesh.triangle_count = 12;
    const fathom_id group = new_group(s->scene, "surfaces");
    const fathom_id places[2] = {FATHOM_ROOT, group};
    for (size_t i = 0; i < 2; ++i) {
        assert_ok(s->context, fathom_scene_add_mesh(s->scene, places[i], &mesh, NULL));
        add_quad(s, places[i], center, u, v, 0);
        add_sphere(s, places[i], 1.5, -1.5, 0, 0.75, 0);
        add_instance(s, group, maps[i]);
    }
    add_grid(s, 4, -3);
    add_plane(s, -5, 0);
}

/* From a hit's own position, in all directions and along the surface. */
static void shoot_from(stage *s, const fathom_tracer *tracer, const fathom_hit *hit) {
    static const double starts[] = {0, 1e-6, 1e-310, 1e-40, 0x1p-126, -1e-6, -1};
    static const double ends[] = {HUGE_VAL, 1, 1e-40};
    const float *n = hit->geometric_normal;
    for (size_t i = 0; i < sizeof starts / sizeof *starts * 3 * 4; ++i) {
        double d[3] = {between(-1, 1), between(-1, 1), between(-1, 1)};
        if (i % 4 == 0) d[0] = (double)n[0], d[1] = (double)n[1], d[2] = (double)n[2];
        if (i % 4 == 1) d[0] = -(double)n[0], d[1] = -(double)n[1], d[2] = -(double)n[2];
        fathom_ray ray = {.t_min = starts[i / 12], .t_max = ends[i / 4 % 3]};
        memcpy(ray.origin, hit->position, sizeof ray.origin);
        memcpy(ray.direction, d, sizeof d);
        fathom_hit next = shoot(s, tracer, ray);
        assert_true(next.t == HUGE_VAL || (next.t > ray.t_min && next.t < ray.t_max));
    }
}

static void shoot_from_all(const char *kind) {
    stage s = stage_open();
    add_surfaces(&s);
    fathom_tracer *tracer = stage_tracer(&s, kind);
    for (int i = 0; i < 400; ++i) {
        fathom_ray ray = {{between(-5, 5), between(-5, 5), between(-5, 5)}, {0, 0, 0}, 0, HUGE_VAL};
        for (int k = 0; k < 3; ++k) ray.direction[k] = between(-2, 2) - ray.origin[k];
        fathom_hit hit = shoot(&s, tracer, ray);
        if (hit.t < HUGE_VAL) shoot_from(&s, tracer, &hit);
    }
}

/* In a child with a time limit. First, because a child wants no threads in its parent. */
UNIT_TEST(rays_from_a_surface_end_and_meet_what_is_inside) {
    for (int k = 0; k < 2; ++k) {
        fflush(NULL);
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            alarm(60);
            shoot_from_all(kinds[k]);
            _exit(0);
        }
        int status = -1;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    }
}

/* Any place that float would lose, any length of the direction. The remaining error is double's rounding
 * of the place, and float's of the radius: 0.3 is no float. */
UNIT_TEST(a_sphere_anywhere) {
    const double places[] = {0, 1000, 1e7}, lengths[] = {1, 1e-200, 1e200};
    for (int k = 0; k < 18; ++k) {
        double at = places[k % 3], length = lengths[k / 3 % 3];
        stage s = stage_open();
        add_sphere(&s, FATHOM_ROOT, at, 2 * at, -at, 0.25, FATHOM_CASTS_NO_SHADOW);
        fathom_tracer *tracer = stage_tracer(&s, kinds[k / 9]);
        fathom_ray ray = {{at + 4, 2 * at, -at}, {-length, 0, 0}, 0, HUGE_VAL};
        fathom_hit hit = shoot(&s, tracer, ray);
        double rounding = 0x1p-52 * (2 * at + 4);
        assert_near(hit.t * length, 3.75, rounding);
        vectors_near(hit.position, at + 0.25, 2 * at, -at, rounding);
        normals_near(hit.geometric_normal, 1, 0, 0);
        assert_true(hit.object == 0 && hit.primitive == 0 && hit.instance == FATHOM_NONE &&
                    hit.material == 0);
        assert_true(hit.u == 0 && hit.v == 0.5f);
    }
}

/* A triangle with normals and uvs in a group that is stretched and mirrored: the shading normal follows the
 * inverse transpose, so it stays across the surface. */
UNIT_TEST(a_mesh_instanced) {
    static const float p[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0}, uv[] = {0, 0, 1, 0, 0, 1};
    static const float n[] = {1, 0, 1, 1, 0, 1, 1, 0, 1};
    static const uint32_t t[] = {0, 1, 2};
    for (int k = 0; k < 2; ++k) {
        stage s = stage_open();
        fathom_material value = default_material();
        const fathom_id material = new_material(s.scene, "a", &value);
        const fathom_id instance_material = new_material(s.scene, "b", &value);
        const fathom_id group = new_group(s.scene, "g");
        fathom_mesh mesh = default_mesh();
        mesh.positions = p, mesh.vertex_count = 3, mesh.indices = t, mesh.triangle_count = 1;
        mesh.normals = n, mesh.normal_count = 3, mesh.uvs = uv, mesh.uv_count = 3, mesh.material = material;
        fathom_id object, first, second;
        assert_ok(s.context, fathom_scene_add_mesh_shared(s.scene, group, &mesh, &object));
        fathom_instance instance = default_instance();
        instance.group = group;
        const double m[12] = {-2, 0, 0, 10, 0, 4, 0, 0, 0, 0, 1, 0};
        memcpy(instance.transform, m, sizeof m);
        assert_ok(s.context, fathom_scene_add_instance(s.scene, &instance, &first));
        instance.transform[3] = 20, instance.material = instance_material;
        assert_ok(s.context, fathom_scene_add_instance(s.scene, &instance, &second));
        fathom_tracer *tracer = stage_tracer(&s, kinds[k]);
        fathom_ray ray = {{9.5, 2, 8}, {0, 0, -1}, 0, HUGE_VAL};
        fathom_hit hit = shoot(&s, tracer, ray);
        vectors_near(hit.position, 9.5, 2, 0, 8 * 0x1p-52 * 10);
        normals_near(hit.geometric_normal, 0, 0, 1);
        double length = sqrt(0.25 + 1);
        normals_near(hit.shading_normal, -0.5 / length, 0, 1 / length);
        assert_near(hit.u, 0.25, 0x1p-24);
        assert_near(hit.v, 0.5, 0x1p-24);
        assert_true(hit.object == object && hit.primitive == 0);
        assert_true(hit.instance == first && hit.material == material);
        ray.origin[0] = 19.5;
        hit = shoot(&s, tracer, ray);
        assert_true(hit.instance == second && hit.material == instance_material);
    }
}

/* As renders do, whatever the lengths of the normals. */
UNIT_TEST(normals_at_corners_count_as_unit) {
    static const float p[] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, n[] = {0, 0, 8, 1, 0, 1, 0, 0.25f, 0.25f};
    static const uint32_t t[] = {0, 1, 2};
    stage s = stage_open();
    fathom_mesh mesh = default_mesh();
    mesh.positions = p, mesh.vertex_count = 3, mesh.indices = t, mesh.triangle_count = 1;
    mesh.normals = n, mesh.normal_count = 3;
    assert_ok(s.context, fathom_scene_add_mesh(s.scene, FATHOM_ROOT, &mesh, NULL));
    fathom_tracer *tracer = stage_tracer(&s, kinds[0]);
    const fathom_hit hit = shoot(&s, tracer, (fathom_ray){{0.25, 0.5, 8}, {0, 0, -1}, 0, HUGE_VAL});
    const double x = 0.25 * sqrt(0.5), y = 0.5 * sqrt(0.5), z = 0.25 + x + y,
                 length = sqrt(x * x + y * y + z * z);
    normals_near(hit.shading_normal, x / length, y / length, z / length);
}

UNIT_TEST(a_quad_and_a_plane) {
    for (int k = 0; k < 2; ++k) {
        stage s = stage_open();
        const double center[3] = {0.5, 0.5, 1}, u[3] = {0.5, 0, 0}, v[3] = {0, 0.5, 0};
        add_quad(&s, FATHOM_ROOT, center, u, v, 0);
        add_plane(&s, -1, 0);
        fathom_tracer *tracer = stage_tracer(&s, kinds[k]);
        fathom_ray ray = {{0.75, 0.875, 3}, {0, 0, -2}, 0, HUGE_VAL};
        fathom_hit hit = shoot(&s, tracer, ray);
        assert_true(hit.t == 1 && hit.object == 0 && hit.u == 0.75f && hit.v == 0.875f);
        vectors_near(hit.position, 0.75, 0.875, 1, 0);
        ray.t_min = 1; /* the interval is open: on to the plane */
        hit = shoot(&s, tracer, ray);
        assert_true(hit.t == 2 && hit.object == 1);
        vectors_near(hit.position, 0.75, 0.875, -1, 0);
        normals_near(hit.geometric_normal, 0, 0, 1);
        ray.t_max = 2;
        assert_true(shoot(&s, tracer, ray).t == HUGE_VAL);
        /* Behind the origin counts when t_min says so. */
        fathom_ray back = {{0.75, 0.875, -3}, {0, 0, -1}, -3, 0};
        assert_true(shoot(&s, tracer, back).t == -2);
        back.t_min = -2;
        assert_true(shoot(&s, tracer, back).t == HUGE_VAL);
    }
}

/* A ray continued from its own hit, with t_min 0, never finds the same surface again nearer than double's
 * rounding of the hit point: about 2^-50, not float's 2^-24. */
UNIT_TEST(continuing_from_a_hit) {
    stage s = stage_open();
    add_everything(&s);
    fathom_tracer *tracer = stage_tracer(&s, "embree");
    for (int i = 0; i < 2000; ++i) {
        fathom_ray ray = {{between(-4, 4), between(-4, 4), between(-4, 4)},
                          {between(-1, 1), between(-1, 1), between(-1, 1)},
                          0,
                          HUGE_VAL};
        fathom_hit hit = shoot(&s, tracer, ray);
        if (!(hit.t < HUGE_VAL)) continue;
        fathom_ray on = ray;
        on.t_min = hit.t;
        fathom_hit next = shoot(&s, tracer, on);
        assert_true(next.t > hit.t);
        bool same = next.t < HUGE_VAL && next.object == hit.object && next.primitive == hit.primitive &&
                    next.instance == hit.instance;
        if (same) assert_true(next.t > hit.t * (1 + 1e-6)); /* a sphere's other side */
    }
}

/* The origin, the direction and the result are rounded to double, each by at most √3 2^-53 of the distance.
 * The sphere is hit at up to 64 degrees from its normal and the plane at up to 73, so t is off by at most 3.4
 * times the line: 3.4 (1 + 2 √3) < 16. */
UNIT_TEST(rays_from_far_away_hit_what_they_are_aimed_at) {
    for (int k = 0; k < 2; ++k) {
        stage s = stage_open();
        add_sphere(&s, FATHOM_ROOT, 0, 0, 0, 1, 0);
        add_plane(&s, -2, 0);
        fathom_tracer *tracer = stage_tracer(&s, kinds[k]);
        for (int i = 0; i < 2000; ++i) {
            const double far = pow(10, between(1, 12)), z = between(0.3, 1), phi = between(0, 6.28);
            const double d[3] = {sqrt(1 - z * z) * cos(phi), sqrt(1 - z * z) * sin(phi), -z};
            double p[3] = {between(-0.5, 0.5), between(-0.5, 0.5), between(-0.5, 0.5)};
            if (i % 2) p[0] = between(12, 15), p[2] = -2;
            const double b = p[0] * d[0] + p[1] * d[1] + p[2] * d[2],
                         c = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] - 1,
                         t = i % 2 ? 0 : -b - sqrt(b * b - c);
            fathom_ray ray = {.t_max = HUGE_VAL};
            for (int j = 0; j < 3; ++j) ray.direction[j] = d[j], ray.origin[j] = p[j] - far * d[j];
            const fathom_hit hit = shoot(&s, tracer, ray);
            assert_int_equal(hit.object, i % 2);
            assert_near(hit.t, far + t, 16 * 0x1p-53 * far);
            /* The same from the point itself, with a t_min as far back. */
            memcpy(ray.origin, p, sizeof p);
            ray.t_min = -far * between(1, 1e20);
            assert_near(shoot(&s, tracer, ray).t, t, 16 * 0x1p-53 * 16);
        }
    }
}

/* Ids in images are those of hits: object, primitive within it, instance. Away from edges, which the float of
 * a position can cross. */
UNIT_TEST(ids_in_images_are_those_of_hits) {
    stage s = stage_open();
    add_surfaces(&s);
    fathom_settings settings = default_settings();
    fathom_settings_set_integrator(&settings, FATHOM_INTEGRATOR_CLASSIC);
    settings.width = 64, settings.height = 48, settings.aovs = FATHOM_AOV_ID | FATHOM_AOV_P;
    const double eye[3] = {1, -9, 7}, target[3] = {0, 0, 0}, up[3] = {0, 0, 1};
    fathom_camera camera;
    fathom_camera_look_at(eye, target, up, 0.9, &camera);
    assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
    fathom_tracer *tracer = stage_tracer(&s, "reference");
    for (int k = 0; k < 2; ++k) {
        fathom_film *film;
        settings.tracer = kinds[k];
        assert_ok(s.context, fathom_render(s.context, s.scene, &settings, NULL, NULL, NULL, &film));
        const float *p[3] = {fathom_film_channel(film, "P.X"), fathom_film_channel(film, "P.Y"),
                             fathom_film_channel(film, "P.Z")};
        const uint32_t *object = fathom_film_channel_id(film, "id.object");
        const uint32_t *primitive = fathom_film_channel_id(film, "id.primitive");
        const uint32_t *instance = fathom_film_channel_id(film, "id.instance");
        size_t compared[16] = {0};
        for (size_t i = 0; i < 64 * 48; ++i) {
            if (object[i] == FATHOM_NONE) continue;
            fathom_ray ray = {.t_max = 1.001};
            for (int c = 0; c < 3; ++c) ray.origin[c] = eye[c], ray.direction[c] = (double)p[c][i] - eye[c];
            fathom_hit hit = shoot(&s, tracer, ray);
            bool inside = hit.u > 1e-3f && hit.v > 1e-3f && fabsf(hit.u + hit.v - 1) > 1e-3f;
            if (!inside || !(fabs(hit.t - 1) < 1e-5)) continue;
            assert_int_equal(object[i], hit.object);
            assert_int_equal(primitive[i], hit.primitive);
            assert_int_equal(instance[i], hit.instance);
            ++compared[hit.object];
        }
        for (size_t i = 0; i < 8; ++i) assert_true(compared[i] > 5);
        fathom_film_destroy(film);
    }
}

/* A ray from distance 3 towards the unit sphere at the origin: t = 2. */
static const fathom_ray good = {{0, 0, 3}, {0, 0, -1}, 0, HUGE_VAL};

static const fathom_tracer *unit_sphere(stage *s, const char *kind) {
    *s = stage_open();
    add_sphere(s, FATHOM_ROOT, 0, 0, 0, 1, 0);
    return stage_tracer(s, kind);
}

/* The ray is the 18th of 20, in the second block. Those before it have hits. */
static void refuses_number(stage *s, const fathom_tracer *tracer, size_t field, double value,
                           const char *message) {
    fathom_ray rays[20];
    fathom_hit hits[20];
    bool any[20] = {false};
    for (int i = 0; i < 20; ++i) rays[i] = good, hits[i].t = 0;
    memcpy((char *)&rays[17] + field * sizeof(double), &value, sizeof(double));
    assert_fails(s->context, fathom_tracer_closest(tracer, rays, 20, hits), FATHOM_BAD_USAGE, message);
    assert_fails(s->context, fathom_tracer_any(tracer, rays, 20, any), FATHOM_BAD_USAGE, message);
    for (int i = 0; i < 17; ++i) assert_true(hits[i].t == 2 && any[i]);
}

UNIT_TEST(wrong_rays_are_refused) {
    static const double bad[] = {(double)NAN, HUGE_VAL, -HUGE_VAL};
    for (int k = 0; k < 2; ++k) {
        stage s;
        const fathom_tracer *tracer = unit_sphere(&s, kinds[k]);
        for (size_t i = 0; i < 9; ++i) {
            refuses_number(&s, tracer, i % 3, bad[i / 3], "rays[17]: origin");
            refuses_number(&s, tracer, 3 + i % 3, bad[i / 3], "rays[17]: direction");
            refuses_number(&s, tracer, 6, bad[i / 3], "rays[17]: t_min");
        }
        refuses_number(&s, tracer, 5, 0, "rays[17]: direction: is zero");
        refuses_number(&s, tracer, 5, -0.0, "rays[17]: direction: is zero");
        refuses_number(&s, tracer, 7, (double)NAN, "rays[17]: t_max");
        for (int e = 60; e <= 1020; e += 60)
            refuses_number(&s, tracer, 2, ldexp(1, e), "rays[17]: origin: lies more");
        assert_ok(s.context, fathom_tracer_closest(tracer, &good, 0, NULL));
    }
}

UNIT_TEST(empty_intervals_hold_no_hit) {
    const double ends[5][2] = {{1, 1}, {2, 2}, {3, 1}, {0, -HUGE_VAL}, {0, 0}};
    for (int k = 0; k < 10; ++k) {
        stage s;
        const fathom_tracer *tracer = unit_sphere(&s, kinds[k / 5]);
        fathom_ray ray = good;
        ray.t_min = ends[k % 5][0], ray.t_max = ends[k % 5][1];
        assert_true(shoot(&s, tracer, ray).t == HUGE_VAL);
    }
}

/* Directions may be denormal in double. The tolerance is the rounding of a few operations in double: 8 units.
 * A t beyond the range of double cannot be told: the ray misses. */
UNIT_TEST(directions_and_distances_have_any_size) {
    for (int k = 0; k < 2; ++k) {
        stage s;
        const fathom_tracer *tracer = unit_sphere(&s, kinds[k]);
        fathom_ray ray = good;
        for (int e = -1010; e <= 1020; e += 10) {
            ray.direction[2] = -ldexp(1, e);
            assert_near(shoot(&s, tracer, ray).t / ldexp(2, -e), 1, 8 * 0x1p-53);
        }
        ray.direction[2] = -DBL_TRUE_MIN;
        assert_true(shoot(&s, tracer, ray).t == HUGE_VAL);
        ray = good;
        for (int e = 5; e < 50; e += 5) {
            ray.origin[2] = ldexp(1, e);
            assert_near(shoot(&s, tracer, ray).t / (ldexp(1, e) - 1), 1, 8 * 0x1p-53);
        }
    }
}

/* A component that float or double cannot represent acts as 0. */
UNIT_TEST(denormal_parts_act_as_zero) {
    const double parts[] = {1e-40, -1e-40, 1e-46, DBL_TRUE_MIN, -DBL_TRUE_MIN};
    for (int k = 0; k < 2; ++k) {
        stage s;
        const fathom_tracer *tracer = unit_sphere(&s, kinds[k]);
        for (unsigned i = 0; i < 20; ++i) {
            fathom_ray ray = good;
            (i < 10 ? ray.origin : ray.direction)[i / 5 % 2] = parts[i % 5];
            assert_near(shoot(&s, tracer, ray).t, 2, 16 * 0x1p-53);
        }
    }
}

/* Many threads, one tracer. */
typedef struct job {
    const fathom_tracer *tracer;
    const fathom_ray *rays;
    fathom_hit hits[1000];
    fathom_status status;
} job;

static void *run(void *user) {
    job *j = user;
    j->status = fathom_tracer_closest(j->tracer, j->rays, 1000, j->hits);
    return NULL;
}

UNIT_TEST(threads_share_a_tracer) {
    stage s = stage_open();
    add_everything(&s);
    fathom_tracer *tracer = stage_tracer(&s, "embree");
    static fathom_ray rays[1000];
    for (int i = 0; i < 1000; ++i) {
        rays[i] = (fathom_ray){{between(-4, 4), between(-4, 4), between(-4, 4)},
                               {between(-1, 1), between(-1, 1), between(-1, 1)},
                               0,
                               HUGE_VAL};
    }
    static job jobs[4];
    pthread_t threads[4];
    for (int i = 0; i < 4; ++i) {
        jobs[i].tracer = tracer, jobs[i].rays = rays;
        assert_int_equal(pthread_create(&threads[i], NULL, run, &jobs[i]), 0);
    }
    for (int i = 0; i < 4; ++i) pthread_join(threads[i], NULL);
    for (int i = 0; i < 4; ++i) {
        assert_int_equal(jobs[i].status, FATHOM_OK);
        for (int k = 0; k < 1000; ++k) {
            assert_true(jobs[i].hits[k].t == jobs[0].hits[k].t);
            if (jobs[0].hits[k].t < HUGE_VAL)
                assert_int_equal(jobs[i].hits[k].object, jobs[0].hits[k].object);
        }
    }
}

int main(void) { return unit_main(NULL, NULL); }
