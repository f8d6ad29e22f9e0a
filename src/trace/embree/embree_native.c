/* Embree's own triangles on the world's buffers, and the choice of where to use them. */
#include "trace/embree/embree.h"
#include "trace/search.h"

#include <math.h>
#include <string.h>

/* ---- where Embree's triangles are used ---- */

/* Embree's triangle test multiplies three lengths in float: two sides and a distance from the ray's origin.
 * The products have full precision between 2^-102 and 2^127. For a mesh of size c with sides down to c 2^-12
 * (16 million triangles over a ball), seen from up to 2^18 c, this holds from c = 2^-24 to 2^36. Our own
 * intersectors switch to wider numbers if necessary. Quads are triangles here. Spheres need products of two
 * lengths, or four if the direction is as long. */
static bool in_native_range(const world_geometry *geometry) {
    return geometry->largest == 0 || (geometry->largest >= 0x1p-24f && geometry->largest <= 0x1p36f);
}

/* A run of quads may mix small and large ones. With sides down to 2^-34, seen from equally small distances,
 * the products stay in the same range. A quad that is only a point is never hit. */
static bool quads_in_native_range(const world_quad *quads, uint32_t count) {
    for (uint32_t k = 0; k < count; ++k) {
        const vec3_f32 *v = quads[k].corner;
        float size = fmaxf(largest_f32(sub_f32(v[1], v[0])), largest_f32(sub_f32(v[3], v[0])));
        size = fmaxf(size, fmaxf(largest_f32(sub_f32(v[2], v[1])), largest_f32(sub_f32(v[3], v[2]))));
        if (size > 0 && size < 0x1p-34f) return false;
    }
    return true;
}

bool embree_is_halved(const trace_spec *spec, const world *w, const world_geometry *geometry) {
    return geometry->kind == WORLD_QUADS && spec->shapes == TRACE_SHAPES_TRIANGLES &&
           spec->flags == TRACE_SCENE_ROBUST && in_native_range(geometry) &&
           geometry->count <= UINT32_MAX / 4 &&
           quads_in_native_range(&w->quads.items[geometry->first], geometry->count);
}

/* Meshes with some flat triangles are native too: copy_indices() hides these from Embree. */
bool embree_is_native(const trace_spec *spec, const world *w, const world_geometry *geometry) {
    switch (geometry->kind) {
    case WORLD_SPHERES: return false;
    case WORLD_QUADS: return embree_is_halved(spec, w, geometry);
    case WORLD_MESH: break;
    }
    return spec->shapes == TRACE_SHAPES_TRIANGLES && in_native_range(geometry);
}

/* ---- geometries ---- */

/* Embree's robust mode may hit triangles without area, because rounding gives them a normal. Embree skips
 * triangles with an invalid vertex index, so flat ones get such an index. */
static bool copy_indices(RTCGeometry geometry, const fathom_mesh *mesh) {
    uint32_t *to = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                           3 * sizeof *to, mesh->triangle_count);
    if (!to) return false;
    memcpy(to, mesh->indices, 3 * sizeof *to * (size_t)mesh->triangle_count);
    for (uint32_t i = 0; i < mesh->triangle_count; ++i) {
        vec3_f32 v[3];
        search_corners(mesh, i, v);
        if (!triangle_has_area_f32(v[0], v[1], v[2])) to[3 * (size_t)i] = UINT32_MAX;
    }
    return true;
}

static RTCGeometry moving_geometry(RTCDevice device, const fathom_mesh *mesh, const world_vertex_motion *m) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!geometry) return NULL;
    const size_t row = 3 * sizeof(float);
    rtcSetGeometryTimeStepCount(geometry, m->steps);
    for (uint32_t k = 0; k < m->steps; ++k)
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, k, RTC_FORMAT_FLOAT3, m->positions,
                                   k * row * mesh->vertex_count, row, mesh->vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->indices, 0,
                               3 * sizeof(uint32_t), mesh->triangle_count);
    return geometry;
}

static RTCGeometry mesh_geometry(RTCDevice device, const fathom_mesh *mesh, bool flat) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!geometry) return NULL;
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh->positions, 0,
                               mesh->position_stride, mesh->vertex_count);
    if (flat) {
        if (copy_indices(geometry, mesh)) return geometry;
        rtcReleaseGeometry(geometry);
        return NULL;
    }
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->indices, 0,
                               3 * sizeof(uint32_t), mesh->triangle_count);
    return geometry;
}

/* Sets the triangle of three corners of a quad. Its indices are invalid if it has no area or the quad can
 * never be hit. */
static void set_half(const world_quad *quad, bool met, const uint32_t corner[3], uint32_t first,
                     uint32_t out[3]) {
    const vec3_f32 *v = quad->corner;
    bool area = met && triangle_has_area_f32(v[corner[0]], v[corner[1]], v[corner[2]]);
    for (int i = 0; i < 3; ++i) out[i] = area ? first + corner[i] : UINT32_MAX;
}

static bool usable(const world_quad *quad) {
    const vec3_f32 *v = quad->corner;
    return reach_usable(v[0]) && reach_usable(v[1]) && reach_usable(v[2]) && reach_usable(v[3]);
}

/* Quads as the triangles (0,1,3) and (2,3,1), in the same tree as the meshes. Embree keeps one tree per kind
 * of geometry, and every ray traverses all of them: a single QUAD or user box next to a mesh costs each ray a
 * second traversal. */
static RTCGeometry half_geometry(RTCDevice device, const world_quad *quads, uint32_t count) {
    static const uint32_t halves[2][3] = {{0, 1, 3}, {2, 3, 1}};
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!geometry) return NULL;
    float *vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                              3 * sizeof *vertices, 4 * (size_t)count);
    uint32_t *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                3 * sizeof *indices, 2 * (size_t)count);
    if (!vertices || !indices) {
        rtcReleaseGeometry(geometry);
        return NULL;
    }
    memcpy(vertices, quads, count * sizeof *quads);
    for (uint32_t k = 0; k < count; ++k) {
        bool met = usable(&quads[k]);
        for (uint32_t half = 0; half < 2; ++half)
            set_half(&quads[k], met, halves[half], 4 * k, &indices[6 * (size_t)k + 3 * half]);
    }
    return geometry;
}

_Static_assert(sizeof(world_quad) == 12 * sizeof(float), "four corners, tightly packed");

RTCGeometry embree_native_geometry(RTCDevice device, const world *w, const world_geometry *geometry) {
    if (geometry->kind == WORLD_QUADS)
        return half_geometry(device, &w->quads.items[geometry->first], geometry->count);
    if (geometry->moving)
        return moving_geometry(device, &w->meshes.items[geometry->first],
                               &w->vertex_motions.items[geometry->moving - 1]);
    return mesh_geometry(device, &w->meshes.items[geometry->first], geometry->flat > 0);
}
