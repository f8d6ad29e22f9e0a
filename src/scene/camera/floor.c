/* The sweep of a photographer's studio: a floor that a model stands on, and that bends up into a wall behind
 * it, so that no edge shows. It is wide and high enough to fill the image, and low enough to leave the light
 * of the studio's panels (light/studio.h) on the model. */
#include "scene/camera/camera.h"

#include <math.h>

/* In radii of the model's bounds: how far behind its middle the bend begins, and the bend's radius. */
static const double bend_begins = 2.5, bend_radius = 3;
/* How far it reaches beyond what the image shows. */
static const double spare = 1.1;
/* Below the model's lowest point, in its radii: a model that is flat below does not lie in the floor itself.
 */
static const double gap = 0x1p-10;

/* The reflectance of a photographer's grey card. */
static const float grey = 0.18f;

enum { BEND_STEPS = 48, ROWS = BEND_STEPS + 3 };

typedef struct sweep {
    vec3_f64 foot;                /* the point of the floor below the model's middle */
    vec3_f64 across, up, towards; /* towards the viewer; level */
    double radius, front, height, half_width;
} sweep;

/* A row of the sweep as seen from the side. */
typedef struct row {
    double towards, up, normal_towards, normal_up;
} row;

static void rows_of(const sweep *s, row out[ROWS]) {
    const double begin = -bend_begins * s->radius, bend = bend_radius * s->radius;
    out[0] = (row){s->front, 0, 0, 1};
    for (int i = 0; i <= BEND_STEPS; ++i) {
        const double angle = 1.57079632679489662 * i / BEND_STEPS, c = cos(angle), sn = sin(angle);
        out[i + 1] = (row){begin - bend * sn, bend * (1 - c), sn, c};
    }
    out[ROWS - 1] = (row){begin - bend, s->height, 1, 0};
}

static fathom_status add_mesh(fathom_scene *scene, const sweep *s, fathom_id material) {
    row rows[ROWS];
    void *arrays[3];
    fathom_status status = scene_allocate_items(scene, (size_t)2 * ROWS, 3 * sizeof(float), &arrays[0]);
    if (status == FATHOM_OK)
        status = scene_allocate_items(scene, (size_t)2 * ROWS, 3 * sizeof(float), &arrays[1]);
    if (status == FATHOM_OK)
        status = scene_allocate_items(scene, (size_t)2 * (ROWS - 1), 3 * sizeof(uint32_t), &arrays[2]);
    if (status != FATHOM_OK) return status;
    float *positions = arrays[0], *normals = arrays[1];
    uint32_t *indices = arrays[2];
    rows_of(s, rows);
    for (size_t i = 0; i < ROWS; ++i) {
        const vec3_f64 at = madd_f64(scale_f64(rows[i].towards, s->towards), rows[i].up, s->up),
                       normal =
                           madd_f64(scale_f64(rows[i].normal_towards, s->towards), rows[i].normal_up, s->up);
        for (size_t side = 0; side < 2; ++side) {
            const size_t v = 3 * (2 * i + side);
            store_f32(positions + v, narrow(madd_f64(at, side ? s->half_width : -s->half_width, s->across)));
            store_f32(normals + v, narrow(normal));
        }
    }
    for (uint32_t i = 0; i + 1 < ROWS; ++i) {
        const uint32_t v = 2 * i, corners[6] = {v, v + 1, v + 3, v, v + 3, v + 2};
        for (size_t k = 0; k < 6; ++k) indices[6 * i + k] = corners[k];
    }
    fathom_mesh mesh;
    fathom_id object;
    fathom_mesh_default(&mesh);
    mesh.positions = positions, mesh.vertex_count = 2 * ROWS;
    mesh.normals = normals, mesh.normal_count = 2 * ROWS;
    mesh.indices = indices, mesh.triangle_count = 2 * (ROWS - 1);
    mesh.material = material;
    store_f64(mesh.origin, s->foot);
    status = fathom_scene_add_mesh_shared(scene, FATHOM_ROOT, &mesh, &object);
    return status == FATHOM_OK ? fathom_scene_name_object(scene, object, "studio floor") : status;
}

static fathom_status add_grey(fathom_scene *scene, fathom_id *out) {
    fathom_material material;
    fathom_material_default(&material);
    material.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    for (int c = 0; c < 3; ++c) material.base_color[c] = grey;
    material.roughness = 1, material.specular_factor = 0;
    return fathom_scene_add_material(scene, NULL, &material, out);
}

/* As far as rays of the image's upper corners and its upper middle reach on the wall; the lower ones meet the
 * floor in front of it. */
static void fit_to_view(const fathom_scene *scene, sweep *s) {
    const fathom_camera *camera = &scene->camera;
    const image_size size = scene_image_size(scene);
    const vec3_f64 x = load_f64(camera->x), y = load_f64(camera->y), z = load_f64(camera->z),
                   eye = sub_f64(load_f64(camera->origin), s->foot);
    const double ahead = dot_f64(eye, s->towards), depth = ahead + (bend_begins + bend_radius) * s->radius,
                 half = camera->h / (2 * camera->d), aspect = (double)size.width / size.height;
    s->front = ahead + s->radius;
    s->height = spare * bend_radius * s->radius, s->half_width = (bend_begins + bend_radius) * s->radius;
    for (int i = -1; i <= 1; ++i) {
        const vec3_f64 d = sub_f64(madd_f64(scale_f64(i * half * aspect, x), half, y), z);
        const double t = depth / -dot_f64(d, s->towards);
        s->height = fmax(s->height, spare * (dot_f64(eye, s->up) + t * dot_f64(d, s->up)));
        s->half_width =
            fmax(s->half_width, spare * fabs(dot_f64(eye, s->across) + t * dot_f64(d, s->across)));
    }
}

fathom_status scene_add_floor(fathom_scene *scene) {
    const bool classic = scene->settings.integrator == FATHOM_INTEGRATOR_CLASSIC;
    if (classic || !scene->in_studio || !scene->made.camera) return FATHOM_OK;
    const vec3_f64 up = scene->studio_up, back = load_f64(scene->camera.z);
    sweep s = {.up = up, .towards = normalize_f64(madd_f64(back, -dot_f64(back, up), up))};
    s.across = cross_f64(up, s.towards);
    bool empty;
    fathom_id material;
    fathom_status status = scene_stand_all(scene, up, &empty, &s.foot, &s.radius);
    if (status != FATHOM_OK || empty || !(s.radius > 0)) return status;
    s.foot = madd_f64(s.foot, -gap * s.radius, up);
    fit_to_view(scene, &s);
    status = add_grey(scene, &material);
    return status == FATHOM_OK ? add_mesh(scene, &s, material) : status;
}
