/* Lights that lie in surfaces. A shadow ray's interval is open: the surface that holds the light casts
 * nothing, what is just in front of it does. Each trial is a room whose walls are lit by a light in a shape
 * of any size, tilt and place, as it is and in groups that turn and stretch. */
#include "math/affine.h"
#include "random.h"
#include "render.h"

typedef enum holder { SPHERE, BOX, QUAD, PAIR, RIDGE, PLANE, HOLDERS } holder;

enum { SIDE = 48 };

typedef struct trial {
    random_state r;
    holder holder;
    bool grouped;
    double room;       /* half its side; the shape's size is 1 */
    affine_f64 place;  /* of the shape */
    vec3_f64 light, n; /* in the world; n: of the surface, there */
    fathom_id black;   /* a material that reflects nothing */
    fathom_id group, object;
} trial;

static vec3_f64 across(random_state *r, vec3_f64 n) {
    return normalize_f64(cross_f64(n, random_direction(r)));
}

static void add_room(stage *s, double half) {
    const fathom_id white = stage_lambert(s, 0.8f);
    for (int k = 0; k < 6; ++k) {
        double center[3] = {0, 0, 0}, u[3] = {0, 0, 0}, v[3] = {0, 0, 0};
        center[k / 2] = k % 2 ? half : -half, u[(k / 2 + 1) % 3] = half, v[(k / 2 + 2) % 3] = half;
        stage_quad(s, center, u, v, white);
    }
}

/* Moves the corners to where float has them. */
static void add_mesh(stage *s, trial *t, vec3_f64 *p, uint32_t corners, const uint32_t *index,
                     uint32_t triangles) {
    float rows[8][3];
    for (uint32_t k = 0; k < corners; ++k) store_f32(rows[k], narrow(p[k])), p[k] = widen(load_f32(rows[k]));
    fathom_mesh mesh = default_mesh();
    mesh.positions = rows[0], mesh.vertex_count = corners, mesh.indices = index,
    mesh.triangle_count = triangles;
    mesh.material = t->black;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, t->group, &mesh, &t->object));
}

/* A closed mesh with the light anywhere in the middle of a side. */
static vec3_f64 add_box(stage *s, trial *t, vec3_f64 at, vec3_f64 u, vec3_f64 v, vec3_f64 *n) {
    static const uint32_t index[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                       2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    vec3_f64 p[8], down = cross_f64(v, u);
    for (int k = 0; k < 8; ++k)
        p[k] = madd_f64(madd_f64(madd_f64(at, k & 1 ? 1 : -1, u), k & 2 ? 1 : -1, v), k & 4 ? 0 : 1, down);
    add_mesh(s, t, p, 8, index, 12);
    vec3_f64 a = sub_f64(p[5], p[4]), b = sub_f64(p[7], p[4]);
    double x = random_in(&t->r, 0.1, 0.5);
    *n = normalize_f64(cross_f64(a, b));
    return madd_f64(madd_f64(p[4], x, a), random_in(&t->r, 0.2, 0.4), b);
}

/* A sphere with the light anywhere on it; a few units of double's last place off it, since a light inside a
 * sphere is refused. */
static vec3_f64 add_sphere(stage *s, trial *t, vec3_f64 at, vec3_f64 *n) {
    fathom_sphere sphere = default_sphere();
    store_f64(sphere.center, at);
    sphere.radius = 1, sphere.material = t->black;
    assert_ok(s->context, fathom_scene_add_sphere(s->scene, t->group, &sphere, &t->object));
    *n = random_direction(&t->r);
    return madd_f64(at, 1 + 0x1p-46, *n);
}

static vec3_f64 add_quad(stage *s, trial *t, vec3_f64 at, vec3_f64 u, vec3_f64 v) {
    fathom_quad quad;
    double a[3], b[3], c[3];
    store_f64(c, at), store_f64(a, u), store_f64(b, v);
    fathom_quad_from_axes(c, a, b, &quad);
    quad.material = t->black;
    assert_ok(s->context, fathom_scene_add_quad(s->scene, t->group, &quad, &t->object));
    return madd_f64(madd_f64(at, random_in(&t->r, -1, 1), u), random_in(&t->r, -1, 1), v);
}

/* Two triangles with the light on their common side: flat, or a roof. */
static vec3_f64 add_pair(stage *s, trial *t, vec3_f64 at, vec3_f64 u, vec3_f64 v, vec3_f64 up) {
    static const uint32_t index[6] = {0, 1, 2, 0, 2, 3};
    vec3_f64 p[4] = {sub_f64(at, u), madd_f64(at, 1, v), add_f64(at, u), sub_f64(at, v)};
    p[1] = sub_f64(p[1], up), p[3] = sub_f64(p[3], up);
    add_mesh(s, t, p, 4, index, 2);
    return madd_f64(p[0], random_unit(&t->r), sub_f64(p[2], p[0]));
}

static void add_plane(stage *s, trial *t, vec3_f64 at, vec3_f64 n) {
    fathom_plane plane = default_plane();
    store_f64(plane.point, at), store_f64(plane.normal, n);
    plane.material = t->black;
    assert_ok(s->context, fathom_scene_add_plane(s->scene, t->group, &plane, &t->object));
}

static void add_holder(stage *s, trial *t) {
    vec3_f64 n = random_direction(&t->r), u = across(&t->r, n), v = cross_f64(n, u), none = {0, 0, 0};
    vec3_f64 at = scale_f64(random_in(&t->r, 0, 4), random_direction(&t->r)), light = at;
    v = scale_f64(random_log(&t->r, 0.1, 1), v);
    switch (t->holder) {
    case SPHERE: light = add_sphere(s, t, at, &n); break;
    case BOX: light = add_box(s, t, at, u, v, &n); break;
    case QUAD: light = add_quad(s, t, at, u, v); break;
    case PAIR: light = add_pair(s, t, at, u, v, none); break;
    case RIDGE: light = add_pair(s, t, at, u, v, scale_f64(random_in(&t->r, 0.1, 1), n)); break;
    case PLANE:
        add_plane(s, t, at, n);
        light = madd_f64(madd_f64(at, random_in(&t->r, -1, 1), u), random_in(&t->r, -1, 1), v);
        break;
    case HOLDERS: break;
    }
    affine_f64 back;
    affine_invert(&t->place, &back);
    t->light = affine_point(&t->place, light);
    t->n = normalize_f64(affine_transposed_vector(&back, n));
}

static affine_f64 any_place(random_state *r, double room) {
    affine_f64 turn = affine_rotation_axis(random_direction(r), random_in(r, 0, 2 * M_PI));
    affine_f64 other = affine_rotation_axis(random_direction(r), random_in(r, 0, 2 * M_PI));
    vec3_f64 by = {random_log(r, 0.3, 3), random_log(r, 0.3, 3), -random_log(r, 0.3, 3)};
    affine_f64 stretch = affine_scaling(by),
               move = affine_translation(scale_f64(room * 0.3, random_direction(r)));
    affine_f64 map = affine_compose(&stretch, &turn);
    map = affine_compose(&other, &map);
    return affine_compose(&move, &map);
}

static stage open_trial(trial *t) {
    stage s = stage_open(SIDE, SIDE);
    t->room = random_log(&t->r, 24, 2000);
    t->place = t->grouped ? any_place(&t->r, t->room) : affine_identity();
    t->group = FATHOM_ROOT, t->black = stage_emitter(&s, 0);
    if (t->grouped) {
        fathom_instance instance = default_instance();
        assert_ok(s.context, fathom_scene_add_group(s.scene, NULL, &t->group));
        instance.group = t->group;
        for (int i = 0; i < 12; ++i) instance.transform[i] = t->place.m[i / 4][i % 4];
        assert_ok(s.context, fathom_scene_add_instance(s.scene, &instance, NULL));
    }
    add_room(&s, t->room);
    add_holder(&s, t);
    stage_point_light(&s, t->light.x, t->light.y, t->light.z, (float)(t->room * t->room));
    vec3_f64 eye = scale_f64(random_in(&t->r, 0.5, 0.9) * t->room, random_direction(&t->r));
    double e[3], target[3];
    store_f64(e, eye), store_f64(target, scale_f64(random_in(&t->r, -1, 1), eye));
    stage_camera(&s, e, target, (double[3]){0.1, 0.2, 1}, 2.2);
    s.settings.aovs = FATHOM_AOV_P | FATHOM_AOV_ID;
    return s;
}

typedef struct counts {
    size_t lit, dark, wrongly_dark, wrongly_lit;
} counts;

/* On which side of the surface that holds the light the pixel's point is: 0 where it is neither on the walls
 * nor clearly on a side. */
static int side_of(const trial *t, const fathom_film *film, size_t i, uint32_t walls, double clearly) {
    vec3_f64 p = {(double)fathom_film_channel(film, "P.X")[i], (double)fathom_film_channel(film, "P.Y")[i],
                  (double)fathom_film_channel(film, "P.Z")[i]};
    if (fathom_film_channel_id(film, "id.object")[i] >= walls) return 0;
    vec3_f64 to = normalize_f64(sub_f64(p, t->light));
    double cosine = dot_f64(to, t->n);
    return cosine > clearly ? 1 : (cosine < -clearly ? -1 : 0);
}

static const char *const tracers[] = {"embree",  "embree:user", "embree:default", "bvh:f32",
                                      "bvh:f64", "linear:f32",  "linear:f64"};

/* The walls see the light from wherever nothing but the surface that holds it is in the way. A sphere hides
 * it from below; near the tangent plane it is a matter of the sphere's roundness. */
static void count_seen(const trial *t, stage *s, counts *c) {
    for (size_t k = 0; k < sizeof tracers / sizeof *tracers; ++k) {
        s->settings.tracer = tracers[k];
        fathom_film *film = stage_render(s);
        for (size_t i = 0; i < SIDE * SIDE; ++i) {
            const bool lit = fathom_film_channel(film, "R")[i] > 0;
            int side = side_of(t, film, i, 6, t->holder <= BOX ? 0.05 : 0);
            if (t->holder > BOX && side) side = 1;
            c->lit += lit && side > 0, c->wrongly_dark += !lit && side > 0;
            c->dark += !lit && side < 0, c->wrongly_lit += lit && side < 0;
        }
    }
}

UNIT_TEST(a_surface_that_holds_the_light_casts_nothing) {
    for (int k = 0; k < HOLDERS * 2; ++k) {
        counts c = {0};
        for (uint64_t round = 0; round < 12; ++round) {
            trial t = {.r = {(uint64_t)k * 1000 + round}, .holder = (holder)(k / 2), .grouped = k % 2};
            stage s = open_trial(&t);
            count_seen(&t, &s, &c);
        }
        if (c.wrongly_dark || c.wrongly_lit)
            fail_msg("shape %d, grouped %d: %zu of %zu are dark, %zu of %zu are lit", k / 2, k % 2,
                     c.wrongly_dark, c.lit, c.wrongly_lit, c.dark);
        assert_true(c.lit > 50000);
        if (k / 2 <= BOX) assert_true(c.dark > 1000);
    }
}

/* A screen parallel to the surface, at twice the distance that light_surfaces.c promises: 2^-17 of the room
 * and of where the light lies. Its edge is ten thousand times farther from the light. */
UNIT_TEST(what_is_just_in_front_of_the_light_casts) {
    for (int k = 0; k < 2; ++k) {
        counts c = {0};
        for (uint64_t round = 0; round < 12; ++round) {
            trial t = {.r = {round}, .holder = k ? PAIR : QUAD};
            stage s = open_trial(&t);
            double gap = 0x1p-17 * (4 * t.room + length_f64(t.light)), at[3], u[3], v[3];
            vec3_f64 x = across(&t.r, t.n), y = cross_f64(t.n, x);
            store_f64(at, madd_f64(t.light, gap, t.n));
            store_f64(u, scale_f64(1e4 * gap, x)), store_f64(v, scale_f64(1e4 * gap, y));
            stage_quad(&s, at, u, v, t.black);
            for (size_t j = 0; j < sizeof tracers / sizeof *tracers; ++j) {
                s.settings.tracer = tracers[j];
                fathom_film *film = stage_render(&s);
                for (size_t i = 0; i < SIDE * SIDE; ++i) {
                    const bool lit = fathom_film_channel(film, "R")[i] > 0;
                    int side = side_of(&t, film, i, 6, 0.01);
                    c.lit += lit && side < 0, c.wrongly_dark += !lit && side < 0;
                    c.dark += !lit && side > 0, c.wrongly_lit += lit && side > 0;
                }
            }
        }
        if (c.wrongly_dark || c.wrongly_lit)
            fail_msg("%zu of %zu are dark, %zu of %zu are lit", c.wrongly_dark, c.lit, c.wrongly_lit, c.dark);
        assert_true(c.lit > 1000 && c.dark > 1000);
    }
}

int main(void) { return unit_main(NULL, NULL); }
