/* Quads and spheres as meshes, for formats that hold nothing else. A quad is two triangles, exactly. A sphere
 * is approximated: its vertices and their normals are exact, and rows of latitude share them. */
#include "write/write.h"

#include <stdlib.h>
#include <string.h>

/* The poles are on the z axis, and the columns go around it, as texture coordinates of spheres do. There are
 * twice as many columns as rows. */
typedef struct globe {
    uint32_t rows, vertex_count, uv_count, triangle_count;
    float *normals, *uvs;           /* of the unit sphere */
    uint32_t *indices, *uv_indices; /* of vertices; of uvs, which differ on both sides of column 0 */
} globe;

/* With 64 rows, triangles are nowhere further below the sphere's surface than 0.0006 of its radius: at the
 * equator 1 - cos(pi / 128) = 0.0003 in the middle of a side, and twice that in the middle of a cell. Many
 * spheres get fewer rows, so that all have at most so many triangles together, as long as 8 rows allow it. */
#define MOST_ROWS 64u
#define LEAST_ROWS 8u
#define MOST_TRIANGLES 4000000u

static uint32_t triangles_of(uint32_t rows) { return 4 * rows * (rows - 1); }

static uint32_t choose_rows(size_t spheres) {
    uint32_t rows = MOST_ROWS;
    while (rows > LEAST_ROWS && spheres > MOST_TRIANGLES / triangles_of(rows)) rows /= 2;
    return rows;
}

/* Vertex 0 is the pole at +z, and the last one that at -z. */
static uint32_t vertex_at(const globe *g, uint32_t row, uint32_t column) {
    if (row == 0) return 0;
    if (row == g->rows) return g->vertex_count - 1;
    return 1 + (row - 1) * 2 * g->rows + column % (2 * g->rows);
}

static void fill_vertices(const globe *g) {
    for (uint32_t row = 0; row <= g->rows; ++row) {
        const double theta = M_PI * row / g->rows;
        for (uint32_t column = 0; column <= 2 * g->rows; ++column) {
            const double phi = M_PI * column / g->rows;
            float *normal = &g->normals[3 * vertex_at(g, row, column)],
                  *uv = &g->uvs[2 * (row * (2 * g->rows + 1) + column)];
            const bool pole = row == 0 || row == g->rows;
            /* A corner at a pole belongs to a triangle whose other corners are in this column and the next.
             */
            uv[0] = (float)((column + (pole ? 0.5 : 0)) / (2.0 * g->rows)),
            uv[1] = (float)row / (float)g->rows;
            if (column == 2 * g->rows) continue;
            normal[0] = pole ? 0 : (float)(sin(theta) * cos(phi));
            normal[1] = pole ? 0 : (float)(sin(theta) * sin(phi));
            normal[2] = pole ? (row ? -1 : 1) : (float)cos(theta);
        }
    }
}

static void add_triangle(globe *g, const uint32_t corners[3][2]) {
    for (unsigned k = 0; k < 3; ++k) {
        g->indices[3 * g->triangle_count + k] = vertex_at(g, corners[k][0], corners[k][1]);
        g->uv_indices[3 * g->triangle_count + k] = corners[k][0] * (2 * g->rows + 1) + corners[k][1];
    }
    ++g->triangle_count;
}

/* The corner at a pole is in the column of its triangle. */
static void fill_triangles(globe *g) {
    for (uint32_t row = 0; row < g->rows; ++row) {
        const bool first = row == 0, last = row + 1 == g->rows;
        for (uint32_t column = 0; column < 2 * g->rows; ++column) {
            const uint32_t next = column + 1,
                           lower[3][2] = {{row, column}, {row + 1, column}, {row + 1, next}},
                           upper[3][2] = {{row, column}, {row + 1, last ? column : next}, {row, next}};
            if (!last) add_triangle(g, lower);
            if (!first) add_triangle(g, upper);
        }
    }
}

static fathom_status make_globe(fathom_scene *view, uint32_t rows, globe *g) {
    *g = (globe){
        .rows = rows, .vertex_count = 2 * rows * (rows - 1) + 2, .uv_count = (rows + 1) * (2 * rows + 1)};
    void *normals, *uvs, *indices, *uv_indices;
    const size_t corners = 3 * (size_t)triangles_of(rows);
    fathom_status status = scene_allocate_items(view, g->vertex_count, 3 * sizeof(float), &normals);
    if (status == FATHOM_OK) status = scene_allocate_items(view, g->uv_count, 2 * sizeof(float), &uvs);
    if (status == FATHOM_OK) status = scene_allocate_items(view, corners, sizeof(uint32_t), &indices);
    if (status == FATHOM_OK) status = scene_allocate_items(view, corners, sizeof(uint32_t), &uv_indices);
    if (status != FATHOM_OK) return status;
    g->normals = normals, g->uvs = uvs, g->indices = indices, g->uv_indices = uv_indices;
    fill_vertices(g);
    fill_triangles(g);
    return FATHOM_OK;
}

static fathom_status make_sphere(fathom_scene *view, const globe *g, const fathom_sphere *sphere,
                                 fathom_mesh *mesh) {
    void *positions;
    fathom_status status = scene_allocate_items(view, g->vertex_count, 3 * sizeof(float), &positions);
    if (status != FATHOM_OK) return status;
    float *to = positions;
    for (size_t i = 0; i < 3 * (size_t)g->vertex_count; ++i)
        to[i] = (float)(sphere->radius * (double)g->normals[i]);
    mesh->positions = to, mesh->vertex_count = g->vertex_count;
    mesh->indices = g->indices, mesh->triangle_count = g->triangle_count;
    mesh->normals = g->normals, mesh->normal_count = g->vertex_count;
    if (view->uses_uvs) mesh->uvs = g->uvs, mesh->uv_count = g->uv_count, mesh->uv_indices = g->uv_indices;
    memcpy(mesh->origin, sphere->center, sizeof mesh->origin);
    mesh->material = sphere->material, mesh->flags = sphere->flags;
    return FATHOM_OK;
}

/* The halves of a quad, and its texture coordinates: as surface/attributes.c has them. */
static fathom_status make_quad(fathom_scene *view, const fathom_quad *quad, fathom_mesh *mesh) {
    static const uint32_t halves[6] = {0, 1, 3, 2, 3, 1};
    static const float uvs[8] = {0, 1, 1, 1, 1, 0, 0, 0};
    void *positions;
    fathom_status status = scene_allocate_items(view, 4, 3 * sizeof(float), &positions);
    if (status != FATHOM_OK) return status;
    float *to = positions;
    for (unsigned k = 0; k < 12; ++k) to[k] = (float)(quad->corners[k / 3][k % 3] - quad->corners[0][k % 3]);
    mesh->positions = to, mesh->vertex_count = 4;
    mesh->indices = halves, mesh->triangle_count = 2;
    if (view->uses_uvs) mesh->uvs = uvs, mesh->uv_count = 4;
    memcpy(mesh->origin, quad->corners[0], sizeof mesh->origin);
    mesh->material = quad->material, mesh->flags = quad->flags;
    return FATHOM_OK;
}

static fathom_status add_shape(fathom_scene *view, const globe *g, const scene_object *object) {
    fathom_mesh mesh;
    fathom_mesh_default(&mesh);
    fathom_status status = object->kind == SCENE_QUAD
                               ? make_quad(view, &view->quads.items[object->index], &mesh)
                               : make_sphere(view, g, &view->spheres.items[object->index], &mesh);
    fathom_id added;
    if (status == FATHOM_OK) status = fathom_scene_add_mesh_shared(view, object->group, &mesh, &added);
    if (status == FATHOM_OK) view->objects.items[added].name = object->name;
    return status;
}

static bool becomes_mesh(scene_kind kind) { return kind == SCENE_SPHERE || kind == SCENE_QUAD; }

/* Copies the arrays that grow. */
static bool copy_arrays(const fathom_scene *scene, fathom_scene *view) {
    const size_t meshes = scene->meshes.count;
    if (!array_room(&view->meshes, meshes + 1) || !array_room(&view->mesh_facts, meshes + 1) ||
        !array_room(&view->objects, scene->objects.count + 1))
        return false;
    if (meshes) {
        memcpy(view->meshes.items, scene->meshes.items, meshes * sizeof *view->meshes.items);
        memcpy(view->mesh_facts.items, scene->mesh_facts.items, meshes * sizeof *view->mesh_facts.items);
    }
    view->meshes.count = view->mesh_facts.count = meshes;
    for (size_t i = 0; i < scene->objects.count; ++i) {
        if (!becomes_mesh(scene->objects.items[i].kind)) array_push(&view->objects, scene->objects.items[i]);
    }
    return true;
}

fathom_status write_shapes_as_meshes(const fathom_scene *scene, fathom_scene *view) {
    *view = *scene;
    memset(&view->objects, 0, sizeof view->objects), memset(&view->meshes, 0, sizeof view->meshes);
    memset(&view->mesh_facts, 0, sizeof view->mesh_facts), memset(&view->blobs, 0, sizeof view->blobs);
    if (!copy_arrays(scene, view))
        return fail_memory(scene->context, scene->meshes.count * sizeof *scene->meshes.items);
    globe g = {0};
    fathom_status status = FATHOM_OK;
    if (scene->spheres.count) status = make_globe(view, choose_rows(scene->spheres.count), &g);
    for (size_t i = 0; i < scene->objects.count && status == FATHOM_OK; ++i) {
        if (becomes_mesh(scene->objects.items[i].kind))
            status = add_shape(view, &g, &scene->objects.items[i]);
    }
    return status;
}

void write_shapes_free(fathom_scene *view) {
    for (size_t i = 0; i < view->blobs.count; ++i) view->blobs.items[i].release(view->blobs.items[i].data);
    array_free(&view->blobs), array_free(&view->objects);
    array_free(&view->meshes), array_free(&view->mesh_facts);
}
