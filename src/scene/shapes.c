/* Adding shapes. All errors of a single shape are found here. */
#include "base/sized.h"
#include "scene/mesh/mesh_array.h"
#include "scene/motion/motion.h"
#include "scene/scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

SIZED_DEFAULT(fathom_sphere, {.radius = 1})
SIZED_DEFAULT(fathom_plane, {.normal = {0, 0, 1}})
SIZED_DEFAULT(fathom_mesh, {.color_channels = 3})

const char *scene_numbered(const scene_object *object, char out[SCENE_NUMBERED]) {
    static const char *const kinds[] = {
        [SCENE_SPHERE] = "sphere", [SCENE_QUAD] = "quad", [SCENE_PLANE] = "plane", [SCENE_MESH] = "mesh"};
    snprintf(out, SCENE_NUMBERED, "%s %u", kinds[object->kind], object->index);
    return out;
}

void fathom_quad_default_sized(fathom_quad *quad, size_t size) {
    fathom_quad_from_axes_sized((double[3]){0, 0, 0}, (double[3]){0.5, 0, 0}, (double[3]){0, 0.5, 0}, quad,
                                size);
}

void fathom_quad_from_axes_sized(const double center[3], const double u[3], const double v[3],
                                 fathom_quad *out, size_t size) {
    if (!center || !u || !v) return;
    fathom_quad quad = {.material = 0};
    const double signs[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (int i = 0; i < 4; ++i) {
        for (int k = 0; k < 3; ++k) quad.corners[i][k] = center[k] + signs[i][0] * u[k] + signs[i][1] * v[k];
    }
    sized_give(out, size, &quad, sizeof quad);
}

/* Checks the group, the material and the flags, and registers the object: kind, index, group. */
static fathom_status book(fathom_scene *scene, scene_kind kind, size_t index, fathom_id group,
                          fathom_id material, unsigned flags, fathom_id *out) {
    if (group >= scene->groups.count)
        return fail(scene->context, FATHOM_BAD_INPUT, "there is no group %u", group);
    if (material >= scene->materials.count) {
        return fail(scene->context, FATHOM_BAD_INPUT, "there is no material %u", material);
    }
    if (flags & ~(unsigned)FATHOM_CASTS_NO_SHADOW)
        return fail_field(scene->context, FATHOM_BAD_USAGE, "flags",
                          "expected 0 or FATHOM_CASTS_NO_SHADOW, found %u", flags);
    if (scene->objects.count >= FATHOM_NONE - 2) {
        return fail(scene->context, FATHOM_OUT_OF_RESOURCES, "too many objects: at most 2^32 - 3 fit");
    }
    scene_object object = {.kind = kind, .index = (uint32_t)index, .group = group};
    if (!array_push(&scene->objects, object)) return fail_memory(scene->context, sizeof object);
    if (out) *out = (fathom_id)(scene->objects.count - 1);
    return FATHOM_OK;
}

fathom_status fathom_scene_name_object(fathom_scene *scene, fathom_id object, const char *name) {
    if (!scene) return FATHOM_BAD_USAGE;
    if (!name) return fail_null(scene->context, "name");
    if (object >= scene->objects.count)
        return fail(scene->context, FATHOM_BAD_USAGE, "there is no object %u", object);
    fathom_status status = scene_own_text(scene, &name);
    if (status == FATHOM_OK) scene->objects.items[object].name = name;
    return status;
}

static fathom_status check_sphere(fathom_context *context, const fathom_sphere *sphere) {
    if (!finite_f64(load_f64(sphere->center)))
        return fail_field(context, FATHOM_BAD_INPUT, "center", "expected three finite numbers");
    if (sphere->radius > 0 && isfinite(sphere->radius)) return FATHOM_OK;
    return fail_field(context, FATHOM_BAD_INPUT, "radius", "expected a number > 0, found %g", sphere->radius);
}

/* Corners come from decimal text or float, so each coordinate has an error of up to 2^-24 of the largest one.
 * The distance of the fourth corner from the plane of the others sums four such errors, and the quad's shape
 * can double this. */
static double planarity_slack(const fathom_quad *quad) {
    double big = 0;
    for (int i = 0; i < 4; ++i) {
        for (int k = 0; k < 3; ++k) big = fmax(big, fabs(quad->corners[i][k]));
    }
    return 8 * 0x1p-24 * big;
}

static fathom_status check_quad(fathom_context *context, const fathom_quad *quad) {
    vec3_f64 c[4];
    for (int i = 0; i < 4; ++i) {
        c[i] = load_f64(quad->corners[i]);
        if (!finite_f64(c[i]))
            return fail_item(context, FATHOM_BAD_INPUT, "corners", (size_t)i,
                             "expected three finite numbers");
    }
    vec3_f64 normal = cross_f64(sub_f64(c[2], c[0]), sub_f64(c[3], c[1]));
    if (!(length_f64(normal) > 0)) return fail(context, FATHOM_BAD_INPUT, "quad: it has no area");
    normal = normalize_f64(normal);
    for (int i = 0; i < 4; ++i) {
        vec3_f64 next = sub_f64(c[(i + 1) % 4], c[i]), last = sub_f64(c[(i + 3) % 4], c[i]);
        if (!(dot_f64(cross_f64(next, last), normal) > 0)) {
            return fail_item(context, FATHOM_BAD_INPUT, "corners", (size_t)i,
                             "the quad is not convex there; expected four corners in order around it, or "
                             "use triangles");
        }
        if (fabs(dot_f64(next, normal)) > planarity_slack(quad)) {
            return fail(context, FATHOM_BAD_INPUT,
                        "quad: its corners do not lie in one plane (off by %g); use two triangles",
                        fabs(dot_f64(next, normal)));
        }
    }
    return FATHOM_OK;
}

static fathom_status check_plane(fathom_context *context, const fathom_plane *plane) {
    if (!finite_f64(load_f64(plane->point)))
        return fail_field(context, FATHOM_BAD_INPUT, "point", "expected three finite numbers");
    vec3_f64 normal = load_f64(plane->normal);
    if (finite_f64(normal) && length_f64(normal) != 0) return FATHOM_OK;
    return fail_field(context, FATHOM_BAD_INPUT, "normal", "expected a finite vector that is not zero");
}

/* Defines fathom_scene_add_SHAPE_sized(), which checks the caller's shape and appends it to `list`. */
#define ADD_SHAPE(shape, list, kind)                                                                         \
    fathom_status fathom_scene_add_##shape##_sized(                                                          \
        fathom_scene *scene, fathom_id group, const fathom_##shape *from, size_t size, fathom_id *out) {     \
        if (!scene) return FATHOM_BAD_USAGE;                                                                 \
        fathom_##shape item;                                                                                 \
        fathom_##shape##_default(&item);                                                                     \
        fathom_status status = sized_read(scene->context, #shape, from, size, &item, sizeof item);           \
        if (status == FATHOM_OK) status = check_##shape(scene->context, &item);                              \
        if (status != FATHOM_OK) return status;                                                              \
        if (!array_room(&scene->list, 1)) return fail_memory(scene->context, sizeof item);                   \
        status = book(scene, kind, scene->list.count, group, item.material, item.flags, out);                \
        if (status == FATHOM_OK) array_push(&scene->list, item);                                             \
        return status;                                                                                       \
    }

ADD_SHAPE(sphere, spheres, SCENE_SPHERE)
ADD_SHAPE(quad, quads, SCENE_QUAD)
ADD_SHAPE(plane, planes, SCENE_PLANE)

/* ---- meshes ---- */

/* Checks an array other than the positions. */
static fathom_status check_array(fathom_context *context, const fathom_mesh *m, mesh_kind kind) {
    const mesh_array a = mesh_array_of(m, kind);
    if (!a.values) return FATHOM_OK;
    if (!a.indices && a.count < m->vertex_count)
        return fail_field(context, FATHOM_BAD_INPUT, a.name,
                          "expected one for each of the %u vertices, or %s; found %u", m->vertex_count,
                          a.index_name, a.count);
    fathom_status status = mesh_check_finite(context, a.name, a.values, a.stride, a.width, a.count);
    if (status != FATHOM_OK || !a.indices) return status;
    return mesh_check_indices(context, a.index_name, a.indices, (size_t)m->triangle_count * 3, a.count);
}

/* The strides of the colours must be valid. */
static fathom_status check_colors(fathom_context *context, const fathom_mesh *m) {
    for (uint32_t i = 0; m->colors && i < m->vertex_count; ++i) {
        const float *color = mesh_row(m->colors, m->color_stride, i);
        for (unsigned c = 0; c < m->color_channels; ++c) {
            if (color[c] < 0)
                return fail_item(context, FATHOM_BAD_INPUT, "colors", i, "expected numbers >= 0, found %g",
                                 (double)color[c]);
        }
    }
    return FATHOM_OK;
}

fathom_status mesh_check_vertex_keys(fathom_context *context, const fathom_mesh *m, mesh_facts *facts) {
    fathom_status status = motion_check_keys(context, m->key_times, m->key_count);
    if (status == FATHOM_OK && !m->key_positions) status = fail_null(context, "key_positions");
    if (status == FATHOM_OK && m->normals && !m->key_normals)
        status = fail_field(context, FATHOM_BAD_INPUT, "key_normals",
                            "the mesh has normals, and its vertices move; expected its normals at each key");
    for (size_t k = 0; k < m->key_count && status == FATHOM_OK; ++k) {
        mesh_facts at;
        status = mesh_look_at_vertices(context, "key_positions", m->key_positions + 3 * k * m->vertex_count,
                                       3 * sizeof(float), m->vertex_count, &at);
        for (int c = 0; c < 3 && status == FATHOM_OK; ++c) {
            facts->lower[c] = fminf(facts->lower[c], at.lower[c]);
            facts->upper[c] = fmaxf(facts->upper[c], at.upper[c]);
            facts->largest = fmaxf(facts->largest, fmaxf(fabsf(at.lower[c]), fabsf(at.upper[c])));
        }
        if (status == FATHOM_OK && m->normals)
            status = mesh_check_finite(context, "key_normals", m->key_normals + 3 * k * m->normal_count,
                                       3 * sizeof(float), 3, m->normal_count);
    }
    return status;
}

/* A mesh has triangles, or it is a cloud of points. */
static fathom_status check_kind(fathom_context *context, const fathom_mesh *m) {
    if (m->point_radius == 0)
        return m->indices && m->triangle_count
                   ? FATHOM_OK
                   : fail_field(context, FATHOM_BAD_INPUT, "indices", "the mesh has no triangles");
    if (!(m->point_radius > 0) || !isfinite(m->point_radius))
        return fail_field(context, FATHOM_BAD_INPUT, "point_radius", "expected a number >= 0, found %g",
                          (double)m->point_radius);
    const struct {
        const char *name;
        bool there;
    } others[] = {{"indices", m->indices || m->triangle_count},
                  {"normals", m->normals},
                  {"uvs", m->uvs || m->uvs_1},
                  {"tangents", m->tangents},
                  {"key_count", m->key_count}};
    for (size_t i = 0; i < sizeof others / sizeof *others; ++i) {
        if (others[i].there)
            return fail_field(context, FATHOM_BAD_INPUT, others[i].name,
                              "a mesh with a point_radius is a cloud of points, which has positions and "
                              "colors alone; expected none");
    }
    return FATHOM_OK;
}

static fathom_status check_mesh(fathom_context *context, const fathom_mesh *m, mesh_facts *facts) {
    if (!m->positions || !m->vertex_count)
        return fail_field(context, FATHOM_BAD_INPUT, "positions", "the mesh has no vertices");
    const fathom_status kind = check_kind(context, m);
    if (kind != FATHOM_OK) return kind;
    if (!finite_f64(load_f64(m->origin)))
        return fail_field(context, FATHOM_BAD_INPUT, "origin", "expected three finite numbers");
    if (m->colors && (m->color_channels < 3 || m->color_channels > 4))
        return fail_field(context, FATHOM_BAD_INPUT, "color_channels", "expected 3 or 4, found %u",
                          m->color_channels);
    fathom_status status =
        mesh_look_at_vertices(context, "positions", m->positions, m->position_stride, m->vertex_count, facts);
    if (status == FATHOM_OK) status = mesh_look_at_triangles(context, "indices", m, facts);
    for (int k = MESH_NORMALS; k < MESH_ARRAYS && status == FATHOM_OK; ++k)
        status = check_array(context, m, (mesh_kind)k);
    if (status == FATHOM_OK) status = check_colors(context, m);
    return status == FATHOM_OK && m->key_count ? mesh_check_vertex_keys(context, m, facts) : status;
}

static void default_strides(fathom_mesh *mesh) {
    /* Bounds and estimates read vertices without a time: those of the first key. */
    if (mesh->positions && mesh->key_count && mesh->key_positions)
        mesh->positions = mesh->key_positions, mesh->position_stride = 3 * sizeof(float);
    if (!mesh->colors) mesh->color_channels = 3;
    if (!mesh->normals) mesh->normal_indices = NULL;
    if (!mesh->uvs) mesh->uv_indices = NULL;
    mesh_array_pack(mesh);
}

/* The mesh's strides must be set. */
static fathom_status add_mesh(fathom_scene *scene, fathom_id group, const fathom_mesh *mesh,
                              const mesh_facts *facts, fathom_id *out) {
    if (!array_room(&scene->meshes, 1) || !array_room(&scene->mesh_facts, 1))
        return fail_memory(scene->context, sizeof *mesh);
    fathom_status status =
        book(scene, SCENE_MESH, scene->meshes.count, group, mesh->material, mesh->flags, out);
    if (status != FATHOM_OK) return status;
    mesh_facts own = *facts;
    memcpy(own.core_lower, own.lower, sizeof own.lower);
    memcpy(own.core_upper, own.upper, sizeof own.upper);
    own.strays = 0;
    if (mesh->point_radius > 0 && !mesh->key_count)
        own.strays = mesh_find_strays(mesh->positions, mesh->position_stride, mesh->vertex_count,
                                      own.core_lower, own.core_upper);
    array_push(&scene->meshes, *mesh);
    array_push(&scene->mesh_facts, own);
    return FATHOM_OK;
}

fathom_status scene_add_mesh_checked(fathom_scene *scene, fathom_id group, const fathom_mesh *mesh,
                                     const mesh_facts *facts, fathom_id *out) {
    fathom_mesh stored = *mesh;
    default_strides(&stored);
    return add_mesh(scene, group, &stored, facts, out);
}

/* Reads the caller's mesh, sets its strides and checks it. */
static fathom_status read_mesh(const fathom_scene *scene, const fathom_mesh *mesh, size_t size,
                               fathom_mesh *out, mesh_facts *facts) {
    fathom_status status = SIZED_ITEM(scene->context, fathom_mesh, mesh, size, out);
    default_strides(out);
    return status == FATHOM_OK ? check_mesh(scene->context, out, facts) : status;
}

fathom_status fathom_scene_add_mesh_shared_sized(fathom_scene *scene, fathom_id group,
                                                 const fathom_mesh *mesh, size_t size, fathom_id *out) {
    if (!scene) return FATHOM_BAD_USAGE;
    fathom_mesh stored;
    mesh_facts facts;
    fathom_status status = read_mesh(scene, mesh, size, &stored, &facts);
    return status == FATHOM_OK ? add_mesh(scene, group, &stored, &facts, out) : status;
}

/* Copies `count` items that are `stride` bytes apart; of the last one only its `size` bytes. NULL if there
 * are none, or if *status is or becomes a failure. */
static const void *copied(fathom_scene *scene, const void *from, size_t stride, size_t size, size_t count,
                          fathom_status *status) {
    void *to = NULL;
    if (!from || !count || *status != FATHOM_OK) return NULL;
    *status = scene_allocate_items(scene, count, stride, &to);
    if (to) memcpy(to, from, stride * (count - 1) + size);
    return to;
}

static fathom_status copy_arrays(fathom_scene *scene, fathom_mesh *m) {
    const size_t word = sizeof(uint32_t), vector = 3 * sizeof(float), corners = (size_t)m->triangle_count * 3;
    const uint32_t **indices[] = {&m->indices, &m->normal_indices, &m->uv_indices};
    fathom_status status = FATHOM_OK;
    for (int k = 0; k < MESH_ARRAYS; ++k) {
        const mesh_array a = mesh_array_of(m, (mesh_kind)k);
        mesh_array_set(m, (mesh_kind)k,
                       copied(scene, a.values, a.stride, a.width * sizeof(float), a.count, &status),
                       a.stride);
    }
    for (size_t i = 0; i < 3; ++i) *indices[i] = copied(scene, *indices[i], word, word, corners, &status);
    if (!m->key_count) return status;
    m->key_positions =
        copied(scene, m->key_positions, vector, vector, m->key_count * (size_t)m->vertex_count, &status);
    m->key_normals =
        copied(scene, m->key_normals, vector, vector, m->key_count * (size_t)m->normal_count, &status);
    return status == FATHOM_OK ? motion_copy_keys(scene, m->key_count, 0, &m->key_times, NULL) : status;
}

fathom_status fathom_scene_add_mesh_sized(fathom_scene *scene, fathom_id group, const fathom_mesh *mesh,
                                          size_t size, fathom_id *out) {
    if (!scene) return FATHOM_BAD_USAGE;
    fathom_mesh copy;
    mesh_facts facts;
    fathom_status status = read_mesh(scene, mesh, size, &copy, &facts);
    if (status != FATHOM_OK) return status;
    if (!scene_keeps_uvs(scene)) copy.uvs = NULL, copy.uv_indices = NULL, copy.uv_count = 0;
    status = copy_arrays(scene, &copy);
    return status == FATHOM_OK ? add_mesh(scene, group, &copy, &facts, out) : status;
}
