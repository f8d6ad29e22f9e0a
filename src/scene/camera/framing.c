/* A view is bounded by four planes through the eye. Their normals depend only on the view's axes and slopes,
 * so the position of the eye depends only on the extent of the scene along four directions. Let x, y, z be
 * coordinates along the view's axes. An eye at e sees a point p within the slope s across if
 *
 *     p.x + s p.z <= e.x + s e.z   and   -p.x + s p.z <= -e.x + s e.z,
 *
 * and likewise for up. Let A and B be the maxima of the left sides over all points. Then e.z >= (A + B) / 2s,
 * and with equality e.x = (A - B) / 2. The direction that needs the larger e.z is the tighter one. In the
 * other direction the scene needs a smaller slope s, the one with (A + B) / 2s = e.z, and e.x = (A - B) / 2
 * for that slope centres the scene. */
#include "scene/camera/camera.h"

#include "scene/camera/extent.h"
#include "scene/graph.h"
#include "scene/motion/motion.h"

#include <stdlib.h>

enum { SIDES = EXTENT_SIDES, TIMES_MOST = 128, EVEN_TIMES = 17 };

/* The maximum number of vertices read in one pass, at about 4 ns each, and of groups entered. Beyond these,
 * boxes are used. */
#define VERTICES_MOST ((uint64_t)1 << 24)
#define PLACES_MOST 65536u

/* The four directions in the coordinates of a group. The extent of a point p there is normal[i] · p +
 * offset[i]. */
typedef struct directions {
    vec3_f64 normal[SIDES];
    double offset[SIDES];
} directions;

typedef struct step {
    uint32_t group;
    bool moves; /* the group, or one around it, moves */
    directions along;
} step;

typedef struct walk {
    const fathom_scene *scene;
    const scene_graph *graph;
    const scene_bounds *of_group;
    ARRAY(step) stack;
    double times[TIMES_MOST]; /* at which everything must be in view; the first is the shutter's opening */
    uint32_t time_count, time;
    uint64_t vertices; /* that may still be read */
    uint32_t places;   /* groups that may still be entered */
    double reach[SIDES];
    unsigned threads;
    extent_boxes *boxes; /* one for each mesh, or for each of its keys */
    size_t *first_boxes; /* index of the first one of each mesh */
} walk;

/* ---- times ---- */

/* Adds the times of keys while the shutter is open, each once. */
static void add_keys(const double shutter[2], const double *keys, uint32_t count, walk *w) {
    for (uint32_t k = 0; k < count; ++k) {
        bool known = !(keys[k] > shutter[0] && keys[k] < shutter[1]);
        for (uint32_t i = 0; i < w->time_count && !known; ++i) known = w->times[i] == keys[k];
        if (!known && w->time_count < TIMES_MOST) w->times[w->time_count++] = keys[k];
    }
}

/* If nothing moves: only the time when the shutter opens. Otherwise also uniform times while it is open,
 * because objects may rotate between two keys, and the times of keys, as many as fit. */
static void choose_times(walk *w) {
    const fathom_scene *scene = w->scene;
    const double *shutter = scene->camera.shutter;
    w->times[0] = shutter[0], w->time_count = 1;
    bool moves = false;
    for (size_t i = 0; i < scene->instances.count; ++i) {
        const fathom_instance *instance = &scene->instances.items[i];
        if (!motion_is_moving(instance, shutter)) continue;
        moves = true;
        add_keys(shutter, instance->key_times, instance->key_count, w);
    }
    for (size_t i = 0; i < scene->meshes.count && shutter[1] > shutter[0]; ++i) {
        const fathom_mesh *mesh = &scene->meshes.items[i];
        moves |= mesh->key_count > 1;
        add_keys(shutter, mesh->key_times, mesh->key_count, w);
    }
    if (w->time_count > TIMES_MOST - EVEN_TIMES) w->time_count = TIMES_MOST - EVEN_TIMES;
    for (int i = 1; i < EVEN_TIMES && moves; ++i)
        w->times[w->time_count++] = shutter[0] + (shutter[1] - shutter[0]) * i / (EVEN_TIMES - 1);
}

/* ---- shapes ---- */

static directions through(const directions *d, const affine_f64 *map) {
    const vec3_f64 moved = {map->m[0][3], map->m[1][3], map->m[2][3]};
    directions out;
    for (int i = 0; i < SIDES; ++i) {
        out.normal[i] = affine_transposed_vector(map, d->normal[i]);
        out.offset[i] = d->offset[i] + dot_f64(d->normal[i], moved);
    }
    return out;
}

static void add_ball(walk *w, const directions *d, vec3_f64 center, double radius) {
    for (int i = 0; i < SIDES; ++i) {
        double reach = dot_f64(d->normal[i], center) + d->offset[i] + radius * length_f64(d->normal[i]);
        w->reach[i] = fmax(w->reach[i], reach);
    }
}

static void add_point(walk *w, const directions *d, vec3_f64 p) { add_ball(w, d, p, 0); }

static void add_box(walk *w, const directions *d, const scene_bounds *box) {
    for (int i = 0; i < 8 && !bounds_is_empty(box); ++i) add_point(w, d, bounds_corner(box, i));
}

/* Raises `most` to the extent of the mesh at a key. False when out of memory. */
static bool reach_of_key(walk *w, const extent_sides *sides, uint32_t index, uint32_t key,
                         double most[SIDES]) {
    fathom_mesh mesh = w->scene->meshes.items[index];
    extent_boxes *boxes = &w->boxes[w->first_boxes[index] + key];
    if (mesh.key_count) {
        mesh.positions = mesh.key_positions + 3 * (size_t)mesh.vertex_count * key;
        mesh.position_stride = 3 * sizeof(float);
    }
    if (!boxes->items && !extent_make_boxes(w->threads, &mesh, boxes)) return false;
    extent_of_mesh(sides, &mesh, boxes, most);
    return true;
}

/* Between two keys, the extent of a vertex is the weighted mean of its extents at both. So the weighted mean
 * of the two maxima is an upper bound, and exact if the same vertex has both. */
static bool reach_between(walk *w, const extent_sides *sides, uint32_t index, uint32_t key, double u) {
    double a[SIDES], b[SIDES];
    for (int i = 0; i < SIDES; ++i) a[i] = b[i] = -INFINITY;
    if (!reach_of_key(w, sides, index, key, a) || !reach_of_key(w, sides, index, key + 1, b)) return false;
    for (int i = 0; i < SIDES; ++i) w->reach[i] = fmax(w->reach[i], (1 - u) * a[i] + u * b[i]);
    return true;
}

/* A mesh whose box does not exceed the extent found so far needs no boxes of runs. */
static bool add_mesh(walk *w, const directions *d, uint32_t index) {
    const fathom_mesh *mesh = &w->scene->meshes.items[index];
    const mesh_facts *facts = &w->scene->mesh_facts.items[index];
    extent_sides sides;
    extent_box all;
    for (int i = 0; i < SIDES; ++i) {
        sides.x[i] = d->normal[i].x, sides.y[i] = d->normal[i].y, sides.z[i] = d->normal[i].z;
        sides.origin[i] = dot_f64(d->normal[i], load_f64(mesh->origin));
        sides.offset[i] = d->offset[i] + (double)mesh->point_radius * length_f64(d->normal[i]);
    }
    for (int k = 0; k < 3; ++k) all.lower[k] = facts->lower[k], all.upper[k] = facts->upper[k];
    if (!extent_box_beyond(&sides, &all, w->reach)) return true;
    double u = 0;
    const uint32_t key =
        mesh->key_count ? motion_key(mesh->key_times, mesh->key_count, w->times[w->time], &u) : 0;
    return u > 0 ? reach_between(w, &sides, index, key, u) : reach_of_key(w, &sides, index, key, w->reach);
}

static bool add_object(walk *w, const directions *d, fathom_id id) {
    const scene_object object = w->scene->objects.items[id];
    if (w->graph->absent[id]) return true;
    switch (object.kind) {
    case SCENE_SPHERE: {
        const fathom_sphere *sphere = &w->scene->spheres.items[object.index];
        add_ball(w, d, load_f64(sphere->center), sphere->radius);
        break;
    }
    case SCENE_QUAD:
        for (int i = 0; i < 4; ++i) add_point(w, d, load_f64(w->scene->quads.items[object.index].corners[i]));
        break;
    case SCENE_MESH: {
        const fathom_mesh *mesh = &w->scene->meshes.items[object.index];
        if (mesh->vertex_count <= w->vertices && !w->scene->mesh_facts.items[object.index].strays) {
            w->vertices -= mesh->vertex_count;
            return add_mesh(w, d, object.index);
        }
        scene_bounds box = scene_framed_bounds(w->scene, id);
        add_box(w, d, &box);
        break;
    }
    case SCENE_PLANE: break;
    }
    return true;
}

/* ---- groups ---- */

static bool add_instance(walk *w, const directions *d, bool moves, const fathom_instance *instance) {
    const affine_f64 map = motion_place(instance, w->times[w->time]);
    const step inner = {instance->group, moves || motion_is_moving(instance, w->scene->camera.shutter),
                        through(d, &map)};
    if (!w->places) {
        if (!w->time || inner.moves) add_box(w, &inner.along, &w->of_group[instance->group]);
        return true;
    }
    --w->places;
    return array_push(&w->stack, inner);
}

static bool has_keys(const fathom_scene *scene, fathom_id id) {
    const scene_object object = scene->objects.items[id];
    return object.kind == SCENE_MESH && scene->meshes.items[object.index].key_count > 1;
}

/* After the first time, only moving objects are visited again. */
static bool add_group(walk *w, const step *at) {
    const uint32_t *objects = w->graph->objects.first + at->group,
                   *instances = w->graph->instances.first + at->group;
    const uint64_t items = (uint64_t)(objects[1] - objects[0]) + (instances[1] - instances[0]);
    if (items > w->vertices) {
        if (!w->time || at->moves) add_box(w, &at->along, &w->of_group[at->group]);
        return true;
    }
    w->vertices -= items;
    for (uint32_t i = objects[0]; i < objects[1]; ++i) {
        if (w->time && !at->moves && !has_keys(w->scene, w->graph->objects.items[i])) continue;
        if (!add_object(w, &at->along, w->graph->objects.items[i])) return false;
    }
    for (uint32_t i = instances[0]; i < instances[1]; ++i) {
        if (!add_instance(w, &at->along, at->moves, &w->scene->instances.items[w->graph->instances.items[i]]))
            return false;
    }
    return true;
}

/* The direction of side i of a view with these slopes: right, left, up, down. */
static vec3_f64 side(const frame_f64 *axes, int i, const double slope[2]) {
    const vec3_f64 axis = i < 2 ? axes->x : axes->y;
    return madd_f64(i % 2 ? neg_f64(axis) : axis, slope[i / 2], axes->z);
}

/* Sets w->reach to the extent of the scene from `center` along the sides of a view with these slopes. False
 * when out of memory. */
static bool measure(walk *w, const frame_f64 *axes, vec3_f64 center, const double slope[2]) {
    step root = {.group = FATHOM_ROOT};
    for (int i = 0; i < SIDES; ++i) {
        root.along.normal[i] = side(axes, i, slope);
        root.along.offset[i] = -dot_f64(root.along.normal[i], center);
        w->reach[i] = -INFINITY;
    }
    bool fine = true;
    for (w->time = 0; fine && w->time < w->time_count; ++w->time) {
        w->vertices = VERTICES_MOST, w->places = PLACES_MOST, w->stack.count = 0;
        fine = array_push(&w->stack, root);
        while (fine && w->stack.count) {
            const step at = w->stack.items[--w->stack.count];
            fine = add_group(w, &at);
        }
    }
    return fine;
}

/* The slope s that centres the scene in the slack direction solves excess(s) = A + B - 2 s distance = 0,
 * where A and B depend on s. The excess is convex, not negative at 0 and not positive at the slope of the
 * whole view. Regula falsi keeps the root between the two ends. If one end stays, its value is halved
 * (Illinois method), which keeps convergence fast. */
typedef struct bracket {
    double low, above; /* a slope and its excess, >= 0 */
    double high, below;
    int moved; /* which end moved last: -1 low, 1 high */
} bracket;

static double middle(const bracket *b) {
    const double fall = b->above - b->below;
    return fall > 0 ? b->low + (b->high - b->low) * (b->above / fall) : b->high;
}

static void narrow_to(bracket *b, double slope, double excess) {
    if (excess > 0) {
        b->low = slope, b->above = excess;
        if (b->moved == -1) b->below *= 0.5;
        b->moved = -1;
    } else {
        b->high = slope, b->below = excess;
        if (b->moved == 1) b->above *= 0.5;
        b->moved = 1;
    }
}

/* The extent of the scene's box towards the eye, from the centre of the box. */
static double foremost(const frame_f64 *axes, const scene_bounds *box) {
    double most = 0;
    for (int i = 0; i < 8; ++i)
        most = fmax(most, dot_f64(sub_f64(bounds_corner(box, i), bounds_center(box)), axes->z));
    return most;
}

/* The allowed centring error, as a fraction of the view's slope at the foremost point. */
static const double off_centre = 1.0 / 512;

/* The minimum distance of the eye from the foremost corner of the scene's box, as a fraction of its radius.
 * If one point is outermost on all sides, the nearest eye position would be that point: a deep scene fills
 * the view cone up to its tip. A scene that is as wide as its image never needs the eye this near. */
#define CLEAR (1.0 / 32)

/* Most scenes need four or five. Each pass reads the box of every run of vertices. */
#define PASSES_MOST 16

typedef struct fit {
    double most[2];
    double distance, clear; /* of the eye from the centre of the box and from its foremost corner */
    bracket of[2];          /* across, up */
    double reach[SIDES];    /* at the view's slopes, relative to the origin */
} fit;

static double excess(const walk *w, const fit *f, int i, double slope) {
    return w->reach[2 * i] + w->reach[2 * i + 1] - 2 * slope * f->distance;
}

/* Sets both ends of the brackets. The view's own slopes determine the distance of the eye. */
static bool begin_fit(walk *w, const frame_f64 *axes, const scene_bounds *box, fit *f) {
    if (!measure(w, axes, bounds_center(box), f->most)) return false;
    for (int i = 0; i < SIDES; ++i)
        f->reach[i] = w->reach[i] + dot_f64(side(axes, i, f->most), bounds_center(box));
    for (int i = 0; i < 2; ++i) f->distance = fmax(f->distance, excess(w, f, i, 0) / (2 * f->most[i]));
    f->distance = fmax(f->distance, foremost(axes, box) + bounds_radius(box) * CLEAR);
    if (!(f->distance > 0)) f->distance = 1; /* a single point */
    f->clear = f->distance - foremost(axes, box);
    for (int i = 0; i < 2; ++i)
        f->of[i] = (bracket){.high = f->most[i], .below = excess(w, f, i, f->most[i])};
    if (!measure(w, axes, bounds_center(box), (double[2]){0, 0})) return false;
    for (int i = 0; i < 2; ++i) f->of[i].above = excess(w, f, i, 0);
    return true;
}

static bool find_eye(walk *w, const frame_f64 *axes, fathom_framing *out) {
    const scene_bounds *box = &w->of_group[FATHOM_ROOT];
    const double *most = out->slopes;
    fit f = {.most = {most[0], most[1]}};
    if (!begin_fit(w, axes, box, &f)) return false;
    for (int i = 0; i < SIDES; ++i) out->reach[i] = f.reach[i];
    bool near = false;
    for (int pass = 2; pass < PASSES_MOST && !near; ++pass) {
        const double slope[2] = {middle(&f.of[0]), middle(&f.of[1])};
        if (!measure(w, axes, bounds_center(box), slope)) return false;
        near = true;
        for (int i = 0; i < 2; ++i) {
            const double left = excess(w, &f, i, slope[i]);
            near &= fabs(left) <= off_centre * 2 * f.clear * most[i];
            narrow_to(&f.of[i], slope[i], left);
        }
    }
    vec3_f64 eye = madd_f64(bounds_center(box), f.distance, axes->z);
    eye = madd_f64(eye, 0.5 * (w->reach[0] - w->reach[1]), axes->x);
    eye = madd_f64(eye, 0.5 * (w->reach[2] - w->reach[3]), axes->y);
    store_f64(out->eye, eye);
    return true;
}

static fathom_status fail_place(const fathom_scene *scene, const scene_bounds *box) {
    return fail(scene->context, FATHOM_BAD_INPUT,
                "camera: there is none, and no camera could show everything from (%g, %g, %g) to (%g, %g, "
                "%g); give one",
                box->lower.x, box->lower.y, box->lower.z, box->upper.x, box->upper.y, box->upper.z);
}

/* ---- everything ---- */

static bool prepare_boxes(walk *w) {
    const fathom_scene *scene = w->scene;
    size_t count = 0;
    w->first_boxes = malloc((scene->meshes.count + 1) * sizeof *w->first_boxes);
    if (!w->first_boxes) return false;
    for (size_t i = 0; i < scene->meshes.count; ++i) {
        w->first_boxes[i] = count;
        count += scene->meshes.items[i].key_count ? scene->meshes.items[i].key_count : 1;
    }
    w->first_boxes[scene->meshes.count] = count;
    w->boxes = calloc(count + 1, sizeof *w->boxes);
    return w->boxes;
}

static void release(walk *w) {
    array_free(&w->stack);
    for (size_t i = 0; w->boxes && i < w->first_boxes[w->scene->meshes.count]; ++i) free(w->boxes[i].items);
    free(w->boxes);
    free(w->first_boxes);
}

/* Calls `look` for the whole scene, unless nothing in it has bounds. */
static fathom_status look_at_all(const fathom_scene *scene, const frame_f64 *axes,
                                 bool (*look)(walk *w, const frame_f64 *axes, fathom_framing *out),
                                 bool *empty, fathom_framing *out) {
    scene_graph graph;
    scene_bounds *of_group;
    *empty = true;
    fathom_status status = graph_create(scene, &graph);
    if (status != FATHOM_OK) return status;
    status = graph_bounds(scene, &graph, scene_framed_bounds, NULL, NULL, &of_group);
    if (status == FATHOM_OK && !bounds_is_empty(&of_group[FATHOM_ROOT])) {
        *empty = false;
        walk w = {.scene = scene,
                  .graph = &graph,
                  .of_group = of_group,
                  .threads = fathom_context_threads(scene->context)};
        choose_times(&w);
        if (!prepare_boxes(&w) || !look(&w, axes, out))
            status = fail_memory(scene->context, sizeof *w.stack.items);
        else if (!finite_f64(load_f64(out->eye)))
            status = fail_place(scene, &of_group[FATHOM_ROOT]);
        release(&w);
    }
    free(of_group);
    graph_destroy(&graph);
    return status;
}

fathom_status scene_frame_all(const fathom_scene *scene, const frame_f64 *axes, bool *empty,
                              fathom_framing *out) {
    return look_at_all(scene, axes, find_eye, empty, out);
}

/* With slopes of 0, sides 2 and 3 are the directions of the axis y and against it. */
static bool find_foot(walk *w, const frame_f64 *axes, fathom_framing *out) {
    const scene_bounds *box = &w->of_group[FATHOM_ROOT];
    const vec3_f64 middle_of_box = bounds_center(box);
    if (!measure(w, axes, middle_of_box, (double[2]){0, 0})) return false;
    store_f64(out->foot, madd_f64(middle_of_box, -w->reach[3], axes->y));
    out->radius = bounds_radius(box);
    return true;
}

fathom_status scene_stand_all(const fathom_scene *scene, vec3_f64 up, bool *empty, fathom_framing *out) {
    return look_at_all(scene, &(frame_f64){.y = up}, find_foot, empty, out);
}
