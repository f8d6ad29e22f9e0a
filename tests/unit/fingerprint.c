/* A scene's fingerprint: another one for every value that pixels depend on, the same for all others. */
#include "owned.h"
#include "scene/scene.h"

#include <stdio.h>
#include <stdlib.h>

static fathom_context *context;
static fathom_scene *scene;

static const float positions[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 2, 2, 2};
static const uint32_t triangles[6] = {0, 1, 2, 2, 1, 3}, others[6] = {0, 1, 2, 2, 1, 0};

/* One of everything. */
static int set_up(void **state) {
    (void)state;
    fathom_material material = default_material();
    fathom_light light = default_light();
    fathom_sphere sphere = default_sphere();
    fathom_quad quad = default_quad();
    fathom_plane plane = default_plane();
    fathom_mesh mesh = default_mesh();
    fathom_instance instance = default_instance();
    mesh.positions = positions, mesh.vertex_count = 4, mesh.indices = triangles, mesh.triangle_count = 2;
    mesh.normals = positions + 3, mesh.normal_count = 4, mesh.normal_indices = triangles;
    mesh.uvs = positions, mesh.uv_count = 4;
    context = new_context();
    scene = new_scene(context);
    assert_ok(context, fathom_scene_add_material(scene, "m", &material, NULL));
    assert_ok(context, fathom_scene_add_light(scene, &light, NULL));
    const fathom_id group = new_group(scene, "g");
    assert_ok(context, fathom_scene_add_sphere(scene, group, &sphere, NULL));
    assert_ok(context, fathom_scene_add_quad(scene, group, &quad, NULL));
    assert_ok(context, fathom_scene_add_plane(scene, FATHOM_ROOT, &plane, NULL));
    assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
    instance.group = group;
    assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
    return 0;
}

static uint64_t fingerprint(void) {
    uint64_t number;
    assert_ok(context, scene_fingerprint(scene, &number));
    return number;
}

/* Whether the fingerprint sees another value there; the value is put back. */
#define SEES(field, value)                                                                                   \
    do {                                                                                                     \
        const uint64_t before = fingerprint();                                                               \
        const __typeof__(field) old = (field);                                                               \
        (field) = (value);                                                                                   \
        assert_true(fingerprint() != before);                                                                \
        (field) = old;                                                                                       \
        assert_true(fingerprint() == before);                                                                \
    } while (0)

UNIT_TEST(surroundings) {
    fathom_camera *c = &scene->camera;
    for (int i = 0; i < 3; ++i) {
        SEES(c->origin[i], 0.25);
        SEES(c->x[i], 0.25);
        SEES(c->y[i], 0.25);
        SEES(c->z[i], 0.25);
        SEES(scene->background[i], 0.25f);
        SEES(scene->ambient[i], 0.25f);
    }
    SEES(c->d, 9);
    SEES(c->h, 9);
    SEES(c->w, 9);
}

UNIT_TEST(materials_and_lights) {
    fathom_material *m = &scene->materials.items[1].value;
    fathom_light *l = &scene->lights.items[0];
    for (int i = 0; i < 3; ++i) {
        SEES(m->k_a[i], 0.25f);
        SEES(m->k_d[i], 0.25f);
        SEES(m->k_s[i], 0.25f);
        SEES(m->k_r[i], 0.25f);
        SEES(m->k_t[i], 0.25f);
        SEES(m->k_e[i], 0.25f);
        SEES(l->position[i], 0.25);
        SEES(l->direction[i], 0.25);
        SEES(l->intensity[i], 0.25f);
    }
    SEES(m->shininess, 9);
    SEES(m->ior, 9);
    SEES(m->specular, FATHOM_SPECULAR_PHONG);
    SEES(m->specular, FATHOM_SPECULAR_BLINN);
    SEES(m->fresnel, true);
    SEES(m->lit_from_behind, true);
    SEES(l->type, FATHOM_LIGHT_SPOT);
    SEES(l->inner_angle, 0.25f);
    SEES(l->outer_angle, 0.25f);
    SEES(l->radius, 0.25f);
    SEES(l->angular_radius, 0.25f);
}

UNIT_TEST(shapes) {
    fathom_sphere *s = &scene->spheres.items[0];
    fathom_quad *q = &scene->quads.items[0];
    fathom_plane *p = &scene->planes.items[0];
    fathom_instance *n = &scene->instances.items[0];
    for (int i = 0; i < 3; ++i) {
        SEES(s->center[i], 0.25);
        for (int k = 0; k < 4; ++k) SEES(q->corners[k][i], 0.25);
        SEES(p->point[i], 0.25);
        SEES(p->normal[i], 0.25);
    }
    SEES(s->radius, 9);
    SEES(s->material, 1);
    SEES(s->flags, FATHOM_CASTS_NO_SHADOW);
    SEES(q->material, 1);
    SEES(q->flags, FATHOM_CASTS_NO_SHADOW);
    SEES(p->material, 1);
    SEES(p->flags, FATHOM_CASTS_NO_SHADOW);
    for (int i = 0; i < 12; ++i) SEES(n->transform[i], 9);
    SEES(n->material, 1);
    SEES(n->parent, 1);
    SEES(n->group, 0);
    for (size_t i = 0; i < scene->objects.count; ++i) {
        scene_object *o = &scene->objects.items[i];
        SEES(o->group, 1 - o->group);
        SEES(o->index, 7);
        SEES(o->kind, o->kind == SCENE_QUAD ? SCENE_PLANE : SCENE_QUAD);
    }
}

UNIT_TEST(meshes) {
    fathom_mesh *m = &scene->meshes.items[0];
    for (int i = 0; i < 3; ++i) SEES(m->origin[i], 0.25);
    SEES(m->vertex_count, 3);
    SEES(m->triangle_count, 1);
    SEES(m->normal_count, 3);
    SEES(m->material, 1);
    SEES(m->flags, FATHOM_CASTS_NO_SHADOW);
    SEES(m->positions, positions + 3);
    SEES(m->indices, others);
    SEES(m->normals, positions);
    SEES(m->normals, NULL);
    SEES(m->normal_indices, others);
    SEES(m->normal_indices, NULL);
}

/* Arrays so long that threads share them, with room between the vertices: each vertex counts, what is between
 * them does not, and neither does how many threads there are. */
UNIT_TEST(every_vertex_of_many) {
    enum { VERTICES = 300000, FLOATS = 5 };
    float *long_one = unit_memory((size_t)VERTICES * FLOATS * sizeof *long_one);
    fathom_mesh *m = &scene->meshes.items[0];
    const fathom_mesh short_one = *m;
    m->positions = long_one, m->vertex_count = VERTICES, m->position_stride = FLOATS * sizeof(float);
    fathom_context_set_threads(context, 1);
    const uint64_t alone = fingerprint();
    fathom_context_set_threads(context, 4);
    assert_true(fingerprint() == alone);
    for (uint32_t v = 0; v < VERTICES; v += 77777) {
        for (int k = 0; k < 3; ++k) SEES(long_one[v * FLOATS + (uint32_t)k], 1);
        long_one[v * FLOATS + 3] = long_one[v * FLOATS + 4] = 5;
    }
    SEES(long_one[(VERTICES - 1) * FLOATS + 2], 1);
    assert_true(fingerprint() == alone);
    *m = short_one;
}

static void write_config(const char *path, const char *text) {
    FILE *to = fopen(path, "w");
    assert_non_null(to);
    fputs(text, to);
    fclose(to);
}

/* A named colour space is one of the config in $OCIO; what is in it counts, not where it is. */
UNIT_TEST(the_config_of_named_color_spaces) {
    static const unsigned char bytes[] = "P6 1 1 255\n   ";
    fathom_texture t = default_texture();
    t.bytes = bytes, t.byte_count = sizeof bytes - 1;
    assert_ok(context, fathom_scene_add_texture(scene, &t, NULL));
    uint64_t of[2][4];
    for (int named = 0; named < 2; ++named) {
        scene->textures.items[0].color_space = named ? FATHOM_COLOR_NAMED : FATHOM_COLOR_SRGB;
        scene->textures.items[0].color_space_name = "acescg";
        unsetenv("OCIO");
        of[named][0] = fingerprint();
        setenv("OCIO", "fingerprint-a.ocio", 1);
        write_config("fingerprint-a.ocio", "one"), of[named][1] = fingerprint();
        write_config("fingerprint-a.ocio", "two"), of[named][2] = fingerprint();
        setenv("OCIO", "fingerprint-b.ocio", 1);
        write_config("fingerprint-b.ocio", "two"), of[named][3] = fingerprint();
    }
    unsetenv("OCIO");
    remove("fingerprint-a.ocio"), remove("fingerprint-b.ocio");
    for (int k = 1; k < 4; ++k) assert_true(of[0][k] == of[0][0] && of[1][k] != of[1][0]);
    assert_true(of[1][1] != of[1][2] && of[1][2] == of[1][3]);
}

/* The ids of Cryptomatte depend on them. */
UNIT_TEST(names_of_parts) {
    SEES(scene->materials.items[1].name, "n");
    SEES(scene->groups.items[1], "h");
    SEES(scene->objects.items[0].name, "ball");
}

/* No pixel depends on them. */
UNIT_TEST(the_scene_s_name_and_texture_coordinates) {
    const uint64_t before = fingerprint();
    assert_ok(context, fathom_scene_set_name(scene, "another"));
    scene->meshes.items[0].uvs = positions + 4;
    scene->settings.spp = 25;
    assert_true(fingerprint() == before);
}

int main(void) { return unit_main_each(set_up, NULL); }
