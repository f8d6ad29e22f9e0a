#include "verify/builder.h"

#include "base/status.h"

#include <stdlib.h>
#include <string.h>

void build_open(fathom_context *context, builder *out) {
    *out = (builder){.context = context, .group = FATHOM_ROOT};
    out->status = fathom_scene_create(context, &out->scene);
}

void build_finish(builder *b) {
    if (b->status == FATHOM_OK) b->status = fathom_scene_complete(b->scene);
    if (b->status == FATHOM_OK) b->status = fathom_scene_check(b->scene);
}

void build_rgb(float out[3], vec3_f64 rgb) {
    out[0] = (float)rgb.x, out[1] = (float)rgb.y, out[2] = (float)rgb.z;
}

fathom_material build_lambert(vec3_f64 k_d) {
    fathom_material m;
    fathom_material_default(&m);
    build_rgb(m.k_d, k_d);
    return m;
}

fathom_material build_black(void) { return build_lambert((vec3_f64){0, 0, 0}); }

fathom_material build_emitter(vec3_f64 k_e) {
    fathom_material m = build_black();
    build_rgb(m.k_e, k_e);
    return m;
}

fathom_id build_material(builder *b, fathom_material m) {
    fathom_id id = 0;
    if (b->status == FATHOM_OK) b->status = fathom_scene_add_material(b->scene, NULL, &m, &id);
    return id;
}

void build_sphere(builder *b, vec3_f64 center, double radius, fathom_id material) {
    fathom_sphere sphere = {.radius = radius, .material = material, .flags = b->flags};
    store_f64(sphere.center, center);
    if (b->status == FATHOM_OK) b->status = fathom_scene_add_sphere(b->scene, b->group, &sphere, NULL);
}

/* Always in the root group: planes cannot be in instances. */
void build_plane(builder *b, vec3_f64 point, vec3_f64 normal, fathom_id material) {
    fathom_plane plane = {.material = material, .flags = b->flags};
    store_f64(plane.point, point), store_f64(plane.normal, normal);
    if (b->status == FATHOM_OK) b->status = fathom_scene_add_plane(b->scene, FATHOM_ROOT, &plane, NULL);
}

void build_quad(builder *b, vec3_f64 center, vec3_f64 u, vec3_f64 v, fathom_id material) {
    fathom_quad quad;
    fathom_quad_from_axes((double[3]){center.x, center.y, center.z}, (double[3]){u.x, u.y, u.z},
                          (double[3]){v.x, v.y, v.z}, &quad);
    quad.material = material, quad.flags = b->flags;
    if (b->status == FATHOM_OK) b->status = fathom_scene_add_quad(b->scene, b->group, &quad, NULL);
}

void build_mesh(builder *b, fathom_mesh mesh, fathom_id material) {
    mesh.material = material, mesh.flags = b->flags;
    if (b->status == FATHOM_OK) b->status = fathom_scene_add_mesh(b->scene, b->group, &mesh, NULL);
}

void build_triangles(builder *b, vec3_f64 origin, const vec3_f64 *positions, uint32_t vertices,
                     const uint32_t *indices, uint32_t triangles, fathom_id material) {
    float *floats = malloc(3 * (size_t)vertices * sizeof *floats);
    if (!floats && b->status == FATHOM_OK) b->status = fail_memory(b->context, 12 * (size_t)vertices);
    for (size_t i = 0; floats && i < vertices; ++i) build_rgb(floats + 3 * i, positions[i]);
    fathom_mesh mesh;
    fathom_mesh_default(&mesh);
    mesh.positions = floats, mesh.vertex_count = vertices;
    mesh.indices = indices, mesh.triangle_count = triangles;
    store_f64(mesh.origin, origin);
    build_mesh(b, mesh, material);
    free(floats);
}

void paint_sphere(builder *b, vec3_f64 center, double radius, fathom_material m) {
    build_sphere(b, center, radius, build_material(b, m));
}

void paint_plane(builder *b, vec3_f64 point, vec3_f64 normal, fathom_material m) {
    build_plane(b, point, normal, build_material(b, m));
}

void paint_quad(builder *b, vec3_f64 center, vec3_f64 u, vec3_f64 v, fathom_material m) {
    build_quad(b, center, u, v, build_material(b, m));
}

fathom_id build_group(builder *b) {
    fathom_id group = FATHOM_ROOT;
    if (b->status == FATHOM_OK) b->status = fathom_scene_add_group(b->scene, NULL, &group);
    return group;
}

void build_instance(builder *b, const fathom_instance *instance) {
    if (b->status == FATHOM_OK) b->status = fathom_scene_add_instance(b->scene, instance, NULL);
}

void build_place(builder *b, fathom_id group, fathom_id parent, const affine_f64 *map) {
    fathom_instance instance;
    fathom_instance_default(&instance);
    instance.group = group, instance.parent = parent;
    memcpy(instance.transform, map, sizeof instance.transform);
    build_instance(b, &instance);
}

fathom_light build_light_of(fathom_light_type type, vec3_f64 at, vec3_f64 direction, vec3_f64 intensity) {
    fathom_light light;
    fathom_light_default(&light);
    light.type = type;
    store_f64(light.position, at), store_f64(light.direction, direction);
    build_rgb(light.intensity, intensity);
    return light;
}

void build_light(builder *b, const fathom_light *light) {
    if (b->status == FATHOM_OK) b->status = fathom_scene_add_light(b->scene, light, NULL);
}

void build_point_light(builder *b, vec3_f64 at, vec3_f64 intensity, double radius) {
    fathom_light light = build_light_of(FATHOM_LIGHT_POINT, at, (vec3_f64){0, 0, -1}, intensity);
    light.radius = (float)radius;
    build_light(b, &light);
}

void build_directional_light(builder *b, vec3_f64 direction, vec3_f64 intensity, double radius) {
    fathom_light light = build_light_of(FATHOM_LIGHT_DIRECTIONAL, (vec3_f64){0, 0, 0}, direction, intensity);
    light.angular_radius = (float)radius;
    build_light(b, &light);
}

void build_background(builder *b, vec3_f64 rgb) {
    float color[3];
    build_rgb(color, rgb);
    if (b->status == FATHOM_OK) b->status = fathom_scene_set_background(b->scene, color);
}

fathom_camera build_view(vec3_f64 eye, vec3_f64 target, double fovy) {
    const double from[3] = {eye.x, eye.y, eye.z}, to[3] = {target.x, target.y, target.z}, up[3] = {0, 1, 0};
    fathom_camera camera;
    fathom_camera_look_at(from, to, up, fovy, &camera);
    return camera;
}

void build_camera(builder *b, fathom_camera camera) {
    if (b->status == FATHOM_OK) b->status = fathom_scene_set_camera(b->scene, &camera);
}
