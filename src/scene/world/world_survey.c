/* What tracers are told about primitives: how many have no area, how many lie beyond all reach, how large
 * they are. */
#include "scene/world/world_build.h"

static float larger(float a, float b) { return a > b ? a : b; }

/* Takes one primitive into the counts; reach: of its largest coordinate. */
static void survey_one(world *w, world_geometry *geometry, float reach, bool flat) {
    bool within = reach < (float)WORLD_REACH;
    w->beyond_reach += !within;
    geometry->flat += flat;
    if (within) geometry->largest = larger(geometry->largest, reach);
}

static void survey_sphere(world *w, world_geometry *geometry, const world_sphere *s) {
    survey_one(w, geometry, world_reach_of(s->center) + fabsf(s->radius), !(s->radius > 0));
}

static void survey_quad(world *w, world_geometry *geometry, const world_quad *quad) {
    float reach = 0;
    for (int i = 0; i < 4; ++i) {
        float corner = world_reach_of(quad->corner[i]);
        reach = corner <= reach ? reach : corner; /* NaN too */
        if (!(reach < INFINITY)) break;
    }
    vec3_f64 a = widen(quad->corner[0]), b = widen(quad->corner[1]), c = widen(quad->corner[2]),
             d = widen(quad->corner[3]);
    vec3_f64 m = cross_f64(sub_f64(b, a), sub_f64(d, a)), n = cross_f64(sub_f64(d, c), sub_f64(b, c));
    bool area = (m.x != 0 || m.y != 0 || m.z != 0) && (n.x != 0 || n.y != 0 || n.z != 0);
    survey_one(w, geometry, reach, !area);
}

static void survey_mesh(world *w, world_geometry *geometry) {
    const mesh_facts *facts = &w->mesh_facts.items[geometry->first];
    geometry->largest = facts->largest, geometry->flat = facts->flat;
    w->degenerate_triangles += facts->flat;
    w->beyond_reach += facts->beyond;
}

static void survey_geometry(world *w, world_geometry *geometry) {
    geometry->flat = 0, geometry->largest = 0;
    switch (geometry->kind) {
    case WORLD_SPHERES:
        for (uint32_t i = 0; i < geometry->count; ++i)
            survey_sphere(w, geometry, &w->spheres.items[geometry->first + i]);
        break;
    case WORLD_QUADS:
        for (uint32_t i = 0; i < geometry->count; ++i)
            survey_quad(w, geometry, &w->quads.items[geometry->first + i]);
        break;
    case WORLD_MESH: survey_mesh(w, geometry); break;
    }
}

void world_count(world *w) {
    w->degenerate_triangles = w->beyond_reach = 0;
    for (size_t i = 0; i < w->geometries.count; ++i) survey_geometry(w, &w->geometries.items[i]);
}

fathom_status world_survey(world *w) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < w->meshes.count && status == FATHOM_OK; ++i) {
        status = mesh_look_at_triangles(w->scene->context, "indices", &w->meshes.items[i],
                                        &w->mesh_facts.items[i]);
    }
    if (status == FATHOM_OK) world_count(w);
    return status;
}
