/* Nested groups become one level of instances: each path from the root to a group is one placement. */
#include "math/frame.h"
#include "scene/world/world_build.h"

#include <stdlib.h>

/* ---- placements ---- */

/* A part of a group with an origin: its main part at the group's origin, or a mesh with an origin of its
 * own. */
typedef struct group_part {
    uint32_t world_group;
    vec3_f64 origin;
} group_part;

/* An instance on the path from the root to a placement. */
typedef struct placement_link {
    fathom_id instance;
    uint32_t outer; /* the link of the instance around it, FATHOM_NONE: the root */
} placement_link;

typedef struct placer {
    world *w;
    const scene_graph *graph;
    vec3_f64 *origins;    /* by group */
    bool *in_root;        /* by group: its main part is among the root's geometries, and needs no instance */
    uint32_t *first_part; /* by group, FATHOM_NONE: not made yet */
    uint32_t *part_count; /* by group */
    double *placements;   /* by group: number of paths from the root */
    ARRAY(group_part) parts;
    scene_bounds *bounds;        /* by group */
    bool moves;                  /* something does */
    ARRAY(placement_link) links; /* only then */
    ARRAY(double) times;         /* of the keys of the current placement */
} placer;

static fathom_status no_memory(const placer *p) {
    return fail_memory(p->w->scene->context, sizeof(world_instance));
}

static bool add_group(world *w, size_t first_geometry) {
    world_group group = {(uint32_t)first_geometry, (uint32_t)(w->geometries.count - first_geometry)};
    return array_push(&w->groups, group);
}

static bool add_part(placer *p, size_t first_geometry, vec3_f64 origin) {
    group_part part = {(uint32_t)p->w->groups.count, origin};
    return add_group(p->w, first_geometry) && array_push(&p->parts, part);
}

/* Makes the group's geometries, only once even if the group is placed several times. */
static fathom_status make_parts(placer *p, uint32_t group) {
    if (p->first_part[group] != FATHOM_NONE) return FATHOM_OK;
    world *w = p->w;
    p->first_part[group] = (uint32_t)p->parts.count;
    size_t first = w->geometries.count;
    if (!p->in_root[group]) {
        if (!world_add_geometries(w, p->graph, group, p->origins[group])) return no_memory(p);
        if (w->geometries.count > first && !add_part(p, first, p->origins[group])) return no_memory(p);
    }
    for (uint32_t i = p->graph->objects.first[group]; i < p->graph->objects.first[group + 1]; ++i) {
        fathom_id id = p->graph->objects.items[i];
        scene_object object = w->scene->objects.items[id];
        if (object.kind != SCENE_MESH || p->graph->absent[id]) continue;
        vec3_f64 own = load_f64(w->scene->meshes.items[object.index].origin), shared = p->origins[group];
        if (own.x == shared.x && own.y == shared.y && own.z == shared.z) continue;
        first = w->geometries.count;
        if (!world_add_lone_mesh(w, id) || !add_part(p, first, own)) return no_memory(p);
    }
    p->part_count[group] = (uint32_t)p->parts.count - p->first_part[group];
    return FATHOM_OK;
}

static fathom_status bad_frame(const placer *p, fathom_id id) {
    if (id == FATHOM_NONE)
        return fail(p->w->scene->context, FATHOM_BAD_INPUT,
                    "a mesh lies farther from the camera than float reaches; expected less than 3e38");
    return scene_fail_instance(
        p->w->scene, id, "its frame, with those around it, flattens space or leaves the range of float");
}

static bool add_plane(placer *p, const fathom_plane *plane, fathom_id object, const affine_f64 *to_world,
                      const affine_f64 *to_group, fathom_id material) {
    vec3_f64 point = sub_f64(affine_point(to_world, load_f64(plane->point)), p->w->origin);
    vec3_f64 normal =
        normalize_f64(affine_transposed_vector(to_group, normalize_f64(load_f64(plane->normal))));
    frame_f64 frame = frame_from(point, normal, (vec3_f64){0, 0, 0});
    world_plane out = {.offset = (float)dot_f64(normal, point),
                       .point = narrow(scale_f64(dot_f64(normal, point), normal)),
                       .u = narrow(frame.x),
                       .v = narrow(frame.y),
                       .object = object,
                       .material = material != FATHOM_NONE ? material : plane->material,
                       .flags = plane->flags};
    world_plane_set_normal(&out, normal);
    out.passes = world_material_passes(p->w, out.material);
    return array_push(&p->w->planes, out);
}

/* True if the group's coordinates already are the world's, so that its geometries join the root's
 * unchanged. */
static bool is_in_place(const placer *p, uint32_t group, const affine_f64 *to_world) {
    vec3_f64 a = p->origins[group], b = p->w->origin;
    return affine_is_identity(to_world) && a.x == b.x && a.y == b.y && a.z == b.z;
}

typedef struct placement {
    uint32_t group;
    affine_f64 to_world; /* to the scene's world, before the origin is subtracted, when the shutter opens */
    fathom_id material, id;
    uint32_t link; /* the innermost instance, if something moves */
    bool moves;
} placement;

static placement child_placement(const placer *p, const placement *parent, fathom_id id) {
    const fathom_instance *instance = &p->w->scene->instances.items[id];
    const double *shutter = p->w->scene->camera.shutter;
    const affine_f64 map = motion_place(instance, shutter[0]);
    placement child = {instance->group,
                       affine_compose(&parent->to_world, &map),
                       parent->material != FATHOM_NONE ? parent->material : instance->material,
                       id,
                       FATHOM_NONE,
                       parent->moves || motion_is_moving(instance, shutter)};
    return child;
}

/* Placements still to visit; the next one is the last. Groups nest to any depth, so visits are not
 * recursive. */
typedef ARRAY(placement) placement_stack;

/* Pushes the instances in the group of `at` in reverse order, so that the first is visited first. */
static fathom_status push_children(placer *p, placement_stack *stack, const placement *at) {
    uint32_t first = p->graph->instances.first[at->group];
    for (uint32_t i = p->graph->instances.first[at->group + 1]; i-- > first;) {
        placement child = child_placement(p, at, p->graph->instances.items[i]);
        if (p->moves) {
            child.link = (uint32_t)p->links.count;
            if (!array_push(&p->links, ((placement_link){child.id, at->link}))) return no_memory(p);
        }
        if (!array_push(stack, child)) return no_memory(p);
    }
    return FATHOM_OK;
}

typedef fathom_status (*visit_fn)(placer *p, const placement *at, bool *descend);

/* Visits the root, then everything in it: each placement before those inside it. */
static fathom_status visit_all(placer *p, visit_fn visit) {
    placement_stack stack = {.items = NULL};
    placement at = {FATHOM_ROOT, affine_identity(), FATHOM_NONE, FATHOM_NONE, FATHOM_NONE, false};
    p->links.count = 0;
    fathom_status status = array_push(&stack, at) ? FATHOM_OK : no_memory(p);
    while (stack.count && status == FATHOM_OK) {
        at = stack.items[--stack.count];
        bool descend = true;
        status = visit(p, &at, &descend);
        if (status == FATHOM_OK && descend) status = push_children(p, &stack, &at);
    }
    array_free(&stack);
    return status;
}

/* ---- groups that are placed once and need no instance ---- */

static fathom_status join_in_place(placer *p, uint32_t group) {
    if (!world_add_geometries(p->w, p->graph, group, p->w->origin)) return no_memory(p);
    p->in_root[group] = true;
    return FATHOM_OK;
}

/* Only meshes are carried. Planes do not matter: place_planes() transforms them. */
static bool can_carry(const placer *p, uint32_t group, const affine_f64 *to_world) {
    const fathom_scene *scene = p->w->scene;
    for (uint32_t i = p->graph->objects.first[group]; i < p->graph->objects.first[group + 1]; ++i) {
        const fathom_id id = p->graph->objects.items[i];
        const scene_object object = scene->objects.items[id];
        if (object.kind == SCENE_PLANE || p->graph->absent[id]) continue;
        if (object.kind != SCENE_MESH || !world_can_carry(scene, object.index, to_world)) return false;
    }
    return true;
}

static fathom_status carry_all(placer *p, uint32_t group, const affine_f64 *to_world, bool *fits) {
    for (uint32_t i = p->graph->objects.first[group]; i < p->graph->objects.first[group + 1] && *fits; ++i) {
        const fathom_id id = p->graph->objects.items[i];
        const scene_object object = p->w->scene->objects.items[id];
        if (object.kind == SCENE_PLANE || p->graph->absent[id]) continue;
        fathom_mesh mesh;
        mesh_facts facts;
        const fathom_status status = world_carry_mesh(p->w, object.index, to_world, &mesh, &facts, fits);
        if (status != FATHOM_OK) return status;
        if (!world_add_mesh(p->w, id, &mesh, &facts)) return no_memory(p);
    }
    return FATHOM_OK;
}

static void take_back(world *w, size_t geometries, size_t meshes, size_t arrays, uint64_t bytes) {
    while (w->still_vertices.count > arrays) free(w->still_vertices.items[--w->still_vertices.count]);
    w->geometries.count = geometries;
    w->meshes.count = w->mesh_facts.count = w->mesh_objects.count = meshes;
    w->carried_bytes = bytes;
}

static fathom_status join_carried(placer *p, uint32_t group, const affine_f64 *to_world) {
    world *w = p->w;
    const size_t geometries = w->geometries.count, meshes = w->meshes.count, arrays = w->still_vertices.count;
    const uint64_t bytes = w->carried_bytes;
    bool fits = true;
    const fathom_status status = carry_all(p, group, to_world, &fits);
    if (status != FATHOM_OK) return status;
    if (fits)
        p->first_part[group] = 0, p->part_count[group] = 0; /* make_parts() has nothing left to do */
    else
        take_back(w, geometries, meshes, arrays, bytes);
    return FATHOM_OK;
}

/* The root's geometries come first, with those of the groups that join it, because they must be
 * contiguous. */
static fathom_status join_root(placer *p, const placement *at, bool *descend) {
    *descend = !at->moves && (at->group == FATHOM_ROOT || p->placements[at->group] == 1);
    if (!*descend) return FATHOM_OK;
    const affine_f64 move = affine_translation(neg_f64(p->w->origin)),
                     to_world = affine_compose(&move, &at->to_world);
    const size_t first = p->w->geometries.count;
    fathom_status status = FATHOM_OK;
    if (at->group == FATHOM_ROOT || is_in_place(p, at->group, &at->to_world))
        status = join_in_place(p, at->group);
    else if (can_carry(p, at->group, &to_world))
        status = join_carried(p, at->group, &to_world);
    for (size_t g = first; g < p->w->geometries.count && at->group != FATHOM_ROOT; ++g)
        p->w->geometries.items[g].instance = at->id, p->w->geometries.items[g].material = at->material;
    return status;
}

/* ---- moving placements ---- */

typedef struct moving {
    const placer *p;
    const placement *at;
    vec3_f64 origin; /* of the part */
} moving;

static affine_f64 place_when(const void *user, double time) {
    const moving *m = user;
    const placer *p = m->p;
    affine_f64 map = affine_translation(m->origin);
    for (uint32_t l = m->at->link; l != FATHOM_NONE; l = p->links.items[l].outer) {
        const affine_f64 outer =
            motion_place(&p->w->scene->instances.items[p->links.items[l].instance], time);
        map = affine_compose(&outer, &map);
    }
    const affine_f64 move = affine_translation(neg_f64(p->w->origin));
    return affine_compose(&move, &map);
}

/* Collects the times of all keys on the path from the root. */
static bool find_times(placer *p, const placement *at) {
    p->times.count = 0;
    for (uint32_t l = at->link; l != FATHOM_NONE; l = p->links.items[l].outer) {
        const fathom_instance *instance = &p->w->scene->instances.items[p->links.items[l].instance];
        for (uint32_t k = 0; k < instance->key_count; ++k)
            if (!array_push(&p->times, instance->key_times[k])) return false;
    }
    return true;
}

/* The innermost instance on the way from the root that has keys. */
static fathom_id find_mover(const placer *p, const placement *at) {
    for (uint32_t l = at->link; l != FATHOM_NONE; l = p->links.items[l].outer) {
        const fathom_id id = p->links.items[l].instance;
        if (p->w->scene->instances.items[id].key_count > 1) return id;
    }
    return at->id;
}

static fathom_status place_planes(placer *p, const placement *at) {
    const fathom_scene *scene = p->w->scene;
    for (uint32_t i = p->graph->objects.first[at->group]; i < p->graph->objects.first[at->group + 1]; ++i) {
        const fathom_id id = p->graph->objects.items[i];
        const scene_object object = scene->objects.items[id];
        affine_f64 to_group;
        if (object.kind != SCENE_PLANE || p->graph->absent[id]) continue;
        if (at->moves)
            return scene_fail_instance(scene, find_mover(p, at),
                                       "it moves a plane; infinite planes cannot move: use a large quad");
        if (!affine_invert(&at->to_world, &to_group)) return bad_frame(p, at->id);
        if (!add_plane(p, &scene->planes.items[object.index], id, &at->to_world, &to_group, at->material))
            return no_memory(p);
    }
    return FATHOM_OK;
}

/* origin: of the part, as in the next function. */
static fathom_status set_moving(placer *p, const placement *at, vec3_f64 origin, world_instance *instance) {
    const moving m = {p, at, origin};
    scene_bounds inside = p->bounds[at->group];
    inside.lower = sub_f64(inside.lower, origin), inside.upper = sub_f64(inside.upper, origin);
    return world_add_motion(p->w, place_when, &m, &inside, p->times.items, p->times.count, find_mover(p, at),
                            instance);
}

static fathom_status set_still(placer *p, const placement *at, vec3_f64 origin, world_instance *instance) {
    const affine_f64 shift = affine_translation(origin), moved = affine_compose(&at->to_world, &shift),
                     move = affine_translation(neg_f64(p->w->origin)),
                     to_world = affine_compose(&move, &moved);
    return world_instance_set(instance, &to_world) ? FATHOM_OK : bad_frame(p, at->id);
}

static fathom_status place(placer *p, const placement *at, bool *descend) {
    *descend = true;
    fathom_status status = make_parts(p, at->group);
    if (status == FATHOM_OK) status = place_planes(p, at);
    if (status == FATHOM_OK && at->moves && !find_times(p, at)) status = no_memory(p);
    for (uint32_t i = 0; i < p->part_count[at->group] && status == FATHOM_OK; ++i) {
        const group_part part = p->parts.items[p->first_part[at->group] + i];
        world_instance instance = {.group = part.world_group, .material = at->material, .id = at->id};
        status = (at->moves ? set_moving : set_still)(p, at, part.origin, &instance);
        if (status == FATHOM_OK && !array_push(&p->w->instances, instance)) status = no_memory(p);
    }
    return status;
}

static fathom_status count_placements(placer *p) {
    const double total = graph_count_placements(p->w->scene, p->graph, p->placements);
    /* Embree's geometry ids have 32 bits, and the root's own geometries need some of them. */
    if (total < 0x1p31) return FATHOM_OK;
    return fail(p->w->scene->context, FATHOM_OUT_OF_RESOURCES,
                "nested instances place %.3g groups, at most 2^31 can be held; nest fewer", total);
}

static fathom_status place_all(placer *p, const vec3_f64 *origin) {
    fathom_status status = count_placements(p);
    if (status == FATHOM_OK) status = world_choose_origins(p->w->scene, p->graph, p->origins, &p->bounds);
    if (status != FATHOM_OK) return status;
    for (size_t i = 0; i < p->w->scene->instances.count && !p->moves; ++i)
        p->moves = motion_is_moving(&p->w->scene->instances.items[i], p->w->scene->camera.shutter);
    if (origin) p->origins[FATHOM_ROOT] = *origin;
    p->w->origin = p->origins[FATHOM_ROOT];
    /* The root's own geometries and those that join them are one run, group 0. */
    status = visit_all(p, join_root);
    if (status != FATHOM_OK) return status;
    if (!add_group(p->w, 0)) return no_memory(p);
    return visit_all(p, place);
}

fathom_status world_place(world *w, const scene_graph *graph, const vec3_f64 *origin) {
    size_t groups = w->scene->groups.count;
    placer p = {.w = w, .graph = graph};
    p.origins = calloc(groups, sizeof *p.origins);
    p.in_root = calloc(groups, sizeof *p.in_root);
    p.first_part = malloc(groups * sizeof *p.first_part);
    p.part_count = calloc(groups, sizeof *p.part_count);
    p.placements = calloc(groups, sizeof *p.placements);
    fathom_status status;
    if (p.origins && p.in_root && p.first_part && p.part_count && p.placements) {
        for (size_t g = 0; g < groups; ++g) p.first_part[g] = FATHOM_NONE;
        status = place_all(&p, origin);
    } else {
        status = no_memory(&p);
    }
    free(p.origins);
    free(p.in_root);
    free(p.first_part);
    free(p.part_count);
    free(p.placements);
    array_free(&p.parts);
    array_free(&p.links);
    array_free(&p.times);
    free(p.bounds);
    return status;
}
