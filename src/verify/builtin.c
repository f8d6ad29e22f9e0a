#include "verify/builtin.h"
#include "scene/scene.h"

#include <stdlib.h>
#include <string.h>

/* Irregular numbers in [low, high), the same everywhere. */
static double scattered(unsigned i, unsigned k, double low, double high) {
    double x = (double)(i + 1) * 0.6180339887498949 + (double)(k + 1) * 0.7548776662466927;
    x += (double)(i * i % 97) * 0.1327;
    return low + (high - low) * (x - floor(x));
}

static fathom_status add_spheres(fathom_scene *scene, fathom_id group) {
    fathom_status status = FATHOM_OK;
    for (unsigned i = 0; i < 24 && status == FATHOM_OK; ++i) {
        fathom_sphere sphere;
        fathom_sphere_default(&sphere);
        for (unsigned k = 0; k < 3; ++k) sphere.center[k] = scattered(i, k, -2, 2);
        sphere.radius = 0.5 * pow(10, scattered(i, 3, -3, 0.3));
        status = fathom_scene_add_sphere(scene, group, &sphere, NULL);
    }
    return status;
}

static fathom_status add_quads(fathom_scene *scene, fathom_id group) {
    fathom_status status = FATHOM_OK;
    for (unsigned i = 0; i < 24 && status == FATHOM_OK; ++i) {
        fathom_quad quad;
        fathom_quad_default(&quad);
        double angle = scattered(i, 3, 0, 6.28), size = scattered(i, 4, 0.1, 1);
        double center[3], u[3] = {size * cos(angle), size * sin(angle), 0};
        double v[3] = {-0.3 * sin(angle), 0.3 * cos(angle), size};
        for (unsigned k = 0; k < 3; ++k) center[k] = scattered(i, k, -2, 2);
        fathom_quad_from_axes(center, u, v, &quad);
        status = fathom_scene_add_quad(scene, group, &quad, NULL);
    }
    return status;
}

/* A closed, bumpy sphere: `rings` rings of 2 rings vertices between two poles. */
typedef struct ball {
    unsigned rings, around, vertices;
    float *positions;
    uint32_t *indices;
    uint32_t triangles;
} ball;

static void place_vertices(ball *b) {
    float *v = b->positions;
    for (unsigned j = 1; j <= b->rings; ++j) {
        for (unsigned i = 0; i < b->around; ++i) {
            double theta = 3.141592653589793 * j / (b->rings + 1), phi = 6.283185307179586 * i / b->around;
            double r = 1 + 0.05 * sin(9 * theta) * cos(7 * phi);
            *v++ = (float)(r * sin(theta) * cos(phi));
            *v++ = (float)(r * cos(theta));
            *v++ = (float)(r * sin(theta) * sin(phi));
        }
    }
    v[0] = v[2] = v[3] = v[5] = 0, v[1] = 1, v[4] = -1;
}

static void add_triangle(ball *b, uint32_t x, uint32_t y, uint32_t z) {
    uint32_t *t = &b->indices[3 * (size_t)b->triangles++];
    t[0] = x, t[1] = y, t[2] = z;
}

static void connect(ball *b) {
    uint32_t top = b->vertices - 2, bottom = b->vertices - 1, last = b->around * (b->rings - 1);
    for (unsigned i = 0; i < b->around; ++i) {
        uint32_t next = (i + 1) % b->around;
        add_triangle(b, top, next, i);
        add_triangle(b, bottom, last + i, last + next);
        for (unsigned j = 0; j + 1 < b->rings; ++j) {
            uint32_t a = j * b->around, c = a + b->around;
            add_triangle(b, a + i, a + next, c + i);
            add_triangle(b, a + next, c + next, c + i);
        }
    }
}

static fathom_status add_ball(fathom_scene *scene, fathom_id group) {
    ball b = {.rings = 19, .around = 40};
    b.vertices = b.rings * b.around + 2;
    b.positions = calloc(b.vertices, 3 * sizeof *b.positions);
    b.indices = calloc((size_t)2 * b.rings * b.around, 3 * sizeof *b.indices);
    fathom_status status;
    if (!b.positions || !b.indices) {
        status = fail_memory(scene->context, b.vertices * sizeof *b.positions);
    } else {
        place_vertices(&b);
        connect(&b);
        fathom_mesh mesh;
        fathom_mesh_default(&mesh);
        mesh.positions = b.positions, mesh.vertex_count = b.vertices;
        mesh.indices = b.indices, mesh.triangle_count = b.triangles;
        status = fathom_scene_add_mesh(scene, group, &mesh, NULL);
    }
    free(b.positions);
    free(b.indices);
    return status;
}

static fathom_status add_planes(fathom_scene *scene, fathom_id group) {
    static const double normals[3][3] = {{0, 1, 0}, {0.6, 0.8, 0}, {0.3, -0.2, 2}};
    (void)group; /* planes cannot be placed but in the world */
    fathom_status status = FATHOM_OK;
    for (unsigned i = 0; i < 3 && status == FATHOM_OK; ++i) {
        fathom_plane plane;
        fathom_plane_default(&plane);
        memcpy(plane.normal, normals[i], sizeof plane.normal);
        plane.point[i] = -0.7 * (i + 1);
        status = fathom_scene_add_plane(scene, FATHOM_ROOT, &plane, NULL);
    }
    return status;
}

/* All that has bounds, turned, squeezed, sheared and mirrored. */
static fathom_status add_instances(fathom_scene *scene, fathom_id parent) {
    static const double maps[5][12] = {{0.5, 0, 0, 3, 0, 1.5, 0, 0, 0, 0, 0.2, 0.5},
                                       {-1, 0, 0, -3, 0, 1, 0, 0.3, 0, 0, 1, 0},
                                       {0.6, -0.8, 0, 0, 0.8, 0.6, 0.1, 4, 0, 0.2, 0.7, 0},
                                       {1, 0.3, 0, 0, 0, 1, 0, -4, 0.1, 0, -1.1, 0.4},
                                       {100, 0, 0, 20, 0, 0, -100, 30, 0, 100, 0, 400}};
    fathom_id group;
    fathom_status status = fathom_scene_add_group(scene, "shapes", &group);
    if (status == FATHOM_OK) status = add_spheres(scene, group);
    if (status == FATHOM_OK) status = add_quads(scene, group);
    if (status == FATHOM_OK) status = add_ball(scene, group);
    for (unsigned i = 0; i < 5 && status == FATHOM_OK; ++i) {
        fathom_instance instance;
        fathom_instance_default(&instance);
        instance.group = group, instance.parent = parent;
        memcpy(instance.transform, maps[i], sizeof instance.transform);
        status = fathom_scene_add_instance(scene, &instance, NULL);
    }
    return status;
}

static const struct {
    const char *name;
    fathom_status (*add)(fathom_scene *scene, fathom_id group);
} scenes[] = {{"spheres", add_spheres},
              {"quads", add_quads},
              {"triangles", add_ball},
              {"planes", add_planes},
              {"instances", add_instances}};

const char *builtin_name(unsigned index) {
    return index < sizeof scenes / sizeof *scenes ? scenes[index].name : NULL;
}

fathom_status builtin_create(fathom_context *context, unsigned index, fathom_scene **out) {
    fathom_status status = fathom_scene_create(context, out);
    if (status != FATHOM_OK) return status;
    status = scenes[index].add(*out, FATHOM_ROOT);
    if (status == FATHOM_OK) status = fathom_scene_complete(*out);
    if (status == FATHOM_OK) status = fathom_scene_check(*out);
    if (status == FATHOM_OK) return status;
    fathom_scene_destroy(*out);
    *out = NULL;
    return status;
}
