/* Embree's own shapes over the world's numbers. */
#include "reference/reference.h"
#include "trace/embree.h"
#include "trace/search.h"

#include <string.h>

/* In doubt Embree's robust mode meets triangles without area: rounding gives them a normal. It leaves out
 * those that name no vertex, so in a mesh that has some, flat ones are told as such. */
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

static RTCGeometry mesh_geometry(RTCDevice device, const fathom_mesh *mesh, bool flat) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!geometry) return NULL;
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh->positions, 0,
                               mesh->position_stride ? mesh->position_stride : 3 * sizeof(float),
                               mesh->vertex_count);
    if (flat) {
        if (copy_indices(geometry, mesh)) return geometry;
        rtcReleaseGeometry(geometry);
        return NULL;
    }
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->indices, 0,
                               3 * sizeof(uint32_t), mesh->triangle_count);
    return geometry;
}

/* Embree splits a QUAD into v0 v1 v3 and v2 v3 v1, as the world's are. Vertices are copied: Embree reads past
 * the end of shared ones. */
static RTCGeometry quad_geometry(RTCDevice device, const world_quad *quads, uint32_t count) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
    if (!geometry) return NULL;
    float *vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                              3 * sizeof(float), 4 * (size_t)count);
    uint32_t *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4,
                                                4 * sizeof(uint32_t), count);
    if (!vertices || !indices) {
        rtcReleaseGeometry(geometry);
        return NULL;
    }
    memcpy(vertices, quads, count * sizeof *quads);
    for (uint32_t i = 0; i < 4 * count; ++i) indices[i] = i;
    return geometry;
}
_Static_assert(sizeof(world_quad) == 12 * sizeof(float), "four corners, tightly packed");

/* Embree has no more than float for them: what a split sphere has besides is left out. */
static RTCGeometry sphere_geometry(RTCDevice device, const world_sphere *spheres, uint32_t count) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    if (!geometry) return NULL;
    float *vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4,
                                              4 * sizeof(float), count);
    if (!vertices) {
        rtcReleaseGeometry(geometry);
        return NULL;
    }
    for (uint32_t i = 0; i < count; ++i) {
        store_f32(vertices + 4 * (size_t)i, spheres[i].center);
        vertices[4 * (size_t)i + 3] = spheres[i].radius;
    }
    return geometry;
}

RTCGeometry embree_native_geometry(RTCDevice device, const world *w, const world_geometry *geometry) {
    switch (geometry->kind) {
    case WORLD_SPHERES: return sphere_geometry(device, &w->spheres.items[geometry->first], geometry->count);
    case WORLD_QUADS: return quad_geometry(device, &w->quads.items[geometry->first], geometry->count);
    case WORLD_MESH: break;
    }
    return mesh_geometry(device, &w->meshes.items[geometry->first], geometry->flat > 0);
}
