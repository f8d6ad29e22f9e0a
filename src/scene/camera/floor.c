/* The sheet on which a model stands. In the built-in studio it is a photographer's sweep: a floor that curves
 * up into a wall behind the model, so that no edge is visible. It is wide and high enough to fill the image,
 * and low enough not to block the light of the studio's panels (light/studio.h). In an environment image it
 * is a round plate, whose edge fades into the image. */
#include "scene/camera/camera.h"

#include <math.h>

/* In radii of the model's bounds: the distance behind its centre at which the sweep starts to curve, and the
 * radius of that curve. */
static const double bend_begins = 2.5, bend_radius = 3;
/* The factor by which the sweep extends beyond the visible part. */
static const double spare = 1.1;
/* In the same radii: the distances at which the plate starts to fade and at which it ends. */
static const double fade_begins = 1, fade_ends = 2.2;
/* The distance of the floor below the model's lowest point, in radii, so that a flat bottom does not coincide
 * with the floor. */
static const double gap = 0x1p-10;
/* The distance, in radii, up to which the sheet has world coordinates, as the model usually has. Rounding to
 * float then moves it by less than 2^-17 radii. Rays reach it without a transformation, and tracers that know
 * no instances can trace it. */
static const double near_world = 63;

/* The reflectance of a photographer's grey card. */
static const float grey = 0.18f;

enum { BEND_STEPS = 48, SWEEP_ROWS = BEND_STEPS + 3, PLATE_ROWS = 64 };

typedef struct stand {
    vec3_f64 foot;                /* the point of the floor below the model's middle */
    vec3_f64 origin;              /* of the sheet's coordinates: that of the world, or the foot */
    vec3_f64 across, up, towards; /* `towards` points to the viewer and is level */
    double radius;                /* of the model's bounds */
    fathom_id material;
} stand;

/* ---- sheets ---- */

/* The vertices of a mesh in rows and columns, in arrays that the scene owns. */
typedef struct sheet {
    uint32_t rows, columns;
    float *positions, *normals;
    float *colors; /* RGBA; NULL: none */
    uint32_t *indices;
} sheet;

static fathom_status make_sheet(fathom_scene *scene, uint32_t rows, uint32_t columns, bool colored,
                                sheet *out) {
    const size_t vertices = (size_t)rows * columns, triangles = 2 * (size_t)(rows - 1) * (columns - 1);
    void *positions, *normals, *indices, *colors = NULL;
    fathom_status status = scene_allocate_items(scene, vertices, 3 * sizeof(float), &positions);
    if (status == FATHOM_OK) status = scene_allocate_items(scene, vertices, 3 * sizeof(float), &normals);
    if (status == FATHOM_OK) status = scene_allocate_items(scene, triangles, 3 * sizeof(uint32_t), &indices);
    if (status == FATHOM_OK && colored)
        status = scene_allocate_items(scene, vertices, 4 * sizeof(float), &colors);
    if (status == FATHOM_OK) *out = (sheet){rows, columns, positions, normals, colors, indices};
    return status;
}

/* Sets a vertex. `at`: its coordinates along across, up and towards, relative to the foot. `normal`: along up
 * and towards. */
static void set_vertex(const sheet *to, const stand *s, uint32_t v, const double at[3],
                       const double normal[2]) {
    const vec3_f64 p = madd_f64(madd_f64(scale_f64(at[2], s->towards), at[1], s->up), at[0], s->across),
                   n = madd_f64(scale_f64(normal[1], s->towards), normal[0], s->up);
    store_f32(to->positions + 3 * v, narrow(add_f64(sub_f64(s->foot, s->origin), p)));
    store_f32(to->normals + 3 * v, narrow(n));
}

static void set_indices(const sheet *to) {
    uint32_t *next = to->indices;
    for (uint32_t row = 0; row + 1 < to->rows; ++row) {
        for (uint32_t column = 0; column + 1 < to->columns; ++column) {
            const uint32_t v = row * to->columns + column, below = v + to->columns,
                           corners[6] = {v, v + 1, below + 1, v, below + 1, below};
            for (int k = 0; k < 6; ++k) *next++ = corners[k];
        }
    }
}

static fathom_status add_sheet(fathom_scene *scene, const stand *s, const sheet *from, const char *name) {
    fathom_mesh mesh;
    fathom_id object;
    set_indices(from);
    fathom_mesh_default(&mesh);
    mesh.positions = from->positions, mesh.vertex_count = from->rows * from->columns;
    mesh.normals = from->normals, mesh.normal_count = mesh.vertex_count;
    mesh.colors = from->colors, mesh.color_channels = 4;
    mesh.indices = from->indices, mesh.triangle_count = 2 * (from->rows - 1) * (from->columns - 1);
    mesh.material = s->material;
    store_f64(mesh.origin, s->origin);
    fathom_status status = fathom_scene_add_mesh_shared(scene, FATHOM_ROOT, &mesh, &object);
    return status == FATHOM_OK ? fathom_scene_name_object(scene, object, name) : status;
}

/* ---- the plate ---- */

/* 1 in the middle, 0 beyond the edge, with a slope of 0 at both ends of the fade. */
static float opacity_at(double distance) {
    const double part = fmin(fmax((fade_ends - distance) / (fade_ends - fade_begins), 0), 1);
    return (float)(part * part * (3 - 2 * part));
}

static fathom_status add_plate(fathom_scene *scene, const stand *s) {
    static const double up[2] = {1, 0};
    sheet plate;
    fathom_status status = make_sheet(scene, PLATE_ROWS, PLATE_ROWS, true, &plate);
    if (status != FATHOM_OK) return status;
    for (uint32_t v = 0; v < PLATE_ROWS * PLATE_ROWS; ++v) {
        const double step = 2 * fade_ends / (PLATE_ROWS - 1), x = v % PLATE_ROWS * step - fade_ends,
                     y = fade_ends - v / PLATE_ROWS * step;
        set_vertex(&plate, s, v, (double[3]){x * s->radius, 0, y * s->radius}, up);
        for (uint32_t c = 0; c < 3; ++c) plate.colors[4 * v + c] = 1;
        plate.colors[4 * v + 3] = opacity_at(hypot(x, y));
    }
    return add_sheet(scene, s, &plate, "plate");
}

/* ---- the sweep ---- */

/* The extent of the sweep: in front of the centre, above the foot and to each side. */
typedef struct reach {
    double front, height, half_width;
} reach;

/* A row of the sweep in side view. */
typedef struct row {
    double towards, up, normal_towards, normal_up;
} row;

static void rows_of(const stand *s, const reach *to, row out[SWEEP_ROWS]) {
    const double begin = -bend_begins * s->radius, bend = bend_radius * s->radius;
    out[0] = (row){to->front, 0, 0, 1};
    for (int i = 0; i <= BEND_STEPS; ++i) {
        const double angle = 1.57079632679489662 * i / BEND_STEPS, c = cos(angle), sn = sin(angle);
        out[i + 1] = (row){begin - bend * sn, bend * (1 - c), sn, c};
    }
    out[SWEEP_ROWS - 1] = (row){begin - bend, to->height, 1, 0};
}

/* The sweep extends to where the rays of the image's upper corners and upper middle hit the wall. The lower
 * rays hit the floor in front of it. */
static reach reach_of_view(const fathom_scene *scene, const stand *s) {
    const fathom_camera *camera = &scene->camera;
    const image_size size = scene_image_size(scene);
    const vec3_f64 x = load_f64(camera->x), y = load_f64(camera->y), z = load_f64(camera->z),
                   eye = sub_f64(load_f64(camera->origin), s->foot);
    const double ahead = dot_f64(eye, s->towards), depth = ahead + (bend_begins + bend_radius) * s->radius,
                 half = camera->h / (2 * camera->d), aspect = (double)size.width / size.height;
    reach out = {ahead + s->radius, spare * bend_radius * s->radius, (bend_begins + bend_radius) * s->radius};
    for (int i = -1; i <= 1; ++i) {
        const vec3_f64 d = sub_f64(madd_f64(scale_f64(i * half * aspect, x), half, y), z);
        const double t = depth / -dot_f64(d, s->towards);
        out.height = fmax(out.height, spare * (dot_f64(eye, s->up) + t * dot_f64(d, s->up)));
        out.half_width =
            fmax(out.half_width, spare * fabs(dot_f64(eye, s->across) + t * dot_f64(d, s->across)));
    }
    return out;
}

static fathom_status add_sweep(fathom_scene *scene, const stand *s) {
    const reach to = reach_of_view(scene, s);
    row rows[SWEEP_ROWS];
    sheet sweep;
    fathom_status status = make_sheet(scene, SWEEP_ROWS, 2, false, &sweep);
    if (status != FATHOM_OK) return status;
    rows_of(s, &to, rows);
    for (uint32_t v = 0; v < SWEEP_ROWS * 2; ++v) {
        const row *r = &rows[v / 2];
        const double at[3] = {v % 2 ? to.half_width : -to.half_width, r->up, r->towards};
        set_vertex(&sweep, s, v, at, (double[2]){r->normal_up, r->normal_towards});
    }
    return add_sheet(scene, s, &sweep, "studio floor");
}

/* ---- both ---- */

static fathom_status add_grey(fathom_scene *scene, fathom_id *out) {
    fathom_material material;
    fathom_material_default(&material);
    material.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    for (int c = 0; c < 3; ++c) material.base_color[c] = grey;
    material.roughness = 1, material.specular_factor = 0;
    return fathom_scene_add_material(scene, NULL, &material, out);
}

fathom_status scene_add_floor(fathom_scene *scene) {
    const bool classic = scene->settings.integrator == FATHOM_INTEGRATOR_CLASSIC;
    if (classic || !scene->made.camera || !(scene->in_studio || scene->asked->environment)) return FATHOM_OK;
    const vec3_f64 up = scene_way_up(scene), back = load_f64(scene->camera.z);
    stand s = {.up = up, .towards = normalize_f64(madd_f64(back, -dot_f64(back, up), up))};
    s.across = cross_f64(up, s.towards);
    fathom_framing found = {.radius = 0};
    bool empty = false;
    fathom_status status = FATHOM_OK;
    if (scene_framing_asked(scene) && scene->asked->framing->radius > 0)
        found = *scene->asked->framing;
    else
        status = scene_stand_all(scene, up, &empty, &found);
    if (status != FATHOM_OK || empty || !(found.radius > 0)) return status;
    s.radius = found.radius;
    s.foot = madd_f64(load_f64(found.foot), -gap * s.radius, up);
    if (dot_f64(sub_f64(load_f64(scene->camera.origin), s.foot), up) <= 0) return FATHOM_OK;
    store_f64(scene->framing.foot, load_f64(found.foot));
    scene->framing.radius = s.radius;
    s.origin = length_f64(s.foot) <= near_world * s.radius ? (vec3_f64){0, 0, 0} : s.foot;
    status = add_grey(scene, &s.material);
    if (status != FATHOM_OK) return status;
    return scene->in_studio ? add_sweep(scene, &s) : add_plate(scene, &s);
}
