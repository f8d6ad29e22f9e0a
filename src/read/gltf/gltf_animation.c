/* Animations, posed at a time. Samplers are evaluated as in appendix C of the specification: before the first
 * key and after the last one, the value is that of this key. */
#include "read/gltf/gltf_data.h"
#include "read/gltf/gltf_pose.h"
#include "scene/motion/motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const gltf_part_names[GLTF_PARTS] = {"translation", "rotation", "scale"};

typedef enum interpolation { STEP, LINEAR, CUBICSPLINE } interpolation;

/* `per_key` numbers for each key: a vector element, or one scalar for each weight. */
typedef struct sampler {
    gltf_value at; /* for messages; the caller owns its parent */
    interpolation way;
    gltf_elements times, values;
    size_t per_key;
    bool scalars; /* each number is a separate element */
    bool turns;   /* quaternions */
} sampler;

/* ---- values ---- */

static double time_of(const sampler *s, size_t key) { return (double)*gltf_element(&s->times, key); }

/* part, of cubic splines: 0 the in-tangent, 1 the value, 2 the out-tangent. */
static double number_of(const sampler *s, size_t key, size_t part, size_t c) {
    const size_t item = s->way == CUBICSPLINE ? key * 3 + part : key;
    const size_t element = s->scalars ? item * s->per_key + c : item;
    return (double)gltf_element(&s->values, element)[s->scalars ? 0 : c];
}

/* The spline between a key and the next one, which are `seconds` apart, at u in [0,1). */
static double hermite(const sampler *s, size_t key, double u, double seconds, size_t c) {
    const double u2 = u * u, u3 = u2 * u;
    return (2 * u3 - 3 * u2 + 1) * number_of(s, key, 1, c) +
           seconds * (u3 - 2 * u2 + u) * number_of(s, key, 2, c) +
           (3 * u2 - 2 * u3) * number_of(s, key + 1, 1, c) +
           seconds * (u3 - u2) * number_of(s, key + 1, 0, c);
}

/* The last key that is not after t. Times of keys are floats: that of frame 1 of 24 a second may have been
 * rounded up, and counts from the frame on. */
static size_t find_key(const sampler *s, double t) {
    const double rounded = (float)t;
    size_t low = 0, high = s->times.count;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        *(time_of(s, middle) <= rounded ? &low : &high) = middle;
    }
    return low;
}

static void evaluate(const sampler *s, double t, double *out) {
    const size_t key = find_key(s, t), last = s->times.count - 1u;
    const double from = time_of(s, key);
    if (s->way == STEP || key == last || t <= from) {
        for (size_t c = 0; c < s->per_key; ++c) out[c] = number_of(s, key, 1, c);
        return;
    }
    const double seconds = time_of(s, key + 1) - from, u = (t - from) / seconds;
    if (s->turns && s->way == LINEAR) {
        double a[4], b[4];
        for (size_t c = 0; c < 4; ++c) a[c] = number_of(s, key, 1, c), b[c] = number_of(s, key + 1, 1, c);
        motion_slerp(a, b, u, out);
        return;
    }
    for (size_t c = 0; c < s->per_key; ++c) {
        const double a = number_of(s, key, 1, c), b = number_of(s, s->way == LINEAR ? key + 1 : key, 1, c);
        out[c] = s->way == LINEAR ? a + u * (b - a) : hermite(s, key, u, seconds, c);
    }
}

/* ---- samplers ---- */

/* Exporters that round times write keys at the same time. As in other programs, the first of them ends what
 * is before, and the last one counts from then on. */
static void check_times(gltf *g, const sampler *s) {
    for (uint32_t k = 1; k < s->times.count; ++k) {
        if (!(time_of(s, k) >= time_of(s, k - 1)))
            gltf_fail(g, &s->at, "input", "has %g s after %g s, at key %u; expected times that rise",
                      time_of(s, k), time_of(s, k - 1), k);
        else if (time_of(s, k) == time_of(s, k - 1))
            gltf_note(g, &s->at, "input",
                      "a key has the time of the one before it; from then on the last counts");
    }
}

/* Checks the number of values: as many as the keys need; for weights, a multiple of the number of keys. */
static void check_values(gltf *g, sampler *s) {
    const uint64_t items = s->times.count * (uint64_t)(s->way == CUBICSPLINE ? 3 : 1);
    if (s->scalars) s->per_key = (size_t)(s->values.count / items);
    if (s->per_key && s->values.count == items * (s->scalars ? s->per_key : 1)) return;
    gltf_fail(g, &s->at, "output", "has %u entries; expected %llu%s for %u keys%s", s->values.count,
              (unsigned long long)items, s->scalars ? ", or that times the number of morph targets," : "",
              s->times.count, s->way == CUBICSPLINE ? " of a cubic spline, three for each" : "");
}

/* The caller has set per_key, scalars and turns. */
static void read_sampler(gltf *g, const gltf_value *samplers, uint32_t index, sampler *s) {
    gltf_item(g, samplers, index, &s->at);
    s->way = (interpolation)gltf_word(g, &s->at, "interpolation", "STEP|LINEAR|CUBICSPLINE",
                                      "LINEAR, STEP or CUBICSPLINE", LINEAR);
    const bool times = gltf_array_read(g, &s->at, "input", 1, GLTF_TAKES_FLOAT, &s->times),
               values = gltf_array_read(g, &s->at, "output", (unsigned)s->per_key, GLTF_TAKES_QUANTIZED,
                                        &s->values);
    if (!times || !values || !s->times.count)
        gltf_fail(g, &s->at, NULL, "is incomplete; expected input and output, indices into accessors");
    if (gltf_fine(g)) check_times(g, s);
    if (gltf_fine(g)) check_values(g, s);
}

static sampler sampler_for(int part) {
    const bool scalars = part == GLTF_PARTS, turns = part == GLTF_ROTATION;
    return (sampler){.per_key = scalars ? 1 : turns ? 4 : 3, .scalars = scalars, .turns = turns};
}

bool gltf_sampler_value(gltf *g, const gltf_value *samplers, uint32_t index, unsigned components, double time,
                        double out[4]) {
    sampler s = {.per_key = components};
    read_sampler(g, samplers, index, &s);
    if (gltf_fine(g)) evaluate(&s, time, out);
    return gltf_fine(g);
}

/* ---- channels ---- */

static gltf_pose *pose_for(gltf *g, gltf_moment *m, uint32_t node) {
    if (!m->pose_of) m->pose_of = calloc(gltf_count(&g->nodes) + 1, sizeof *m->pose_of);
    if (!m->pose_of) return NULL;
    if (!m->pose_of[node]) {
        if (!array_push(&m->poses, (gltf_pose){.weights = NULL})) return NULL;
        m->pose_of[node] = (uint32_t)m->poses.count;
    }
    return &m->poses.items[m->pose_of[node] - 1];
}

static void pose_weights(gltf *g, const sampler *s, double t, gltf_pose *pose) {
    const size_t bytes = s->per_key * sizeof(double);
    if (gltf_charge(g, &s->at, NULL, bytes) != FATHOM_OK) return;
    free(pose->weights);
    pose->weights = malloc(bytes);
    pose->weight_count = pose->weights ? s->per_key : 0;
    if (pose->weights)
        evaluate(s, t, pose->weights);
    else
        gltf_fail_memory(g, bytes);
}

static void pose_part(gltf *g, const sampler *s, double t, int part, gltf_pose *pose) {
    evaluate(s, t, pose->parts[part]);
    pose->given[part] = true;
    if (part == GLTF_ROTATION && !gltf_is_rotation(pose->parts[part]))
        gltf_fail(g, &s->at, "output", "is a rotation of zero at %g s; expected unit quaternions", t);
}

/* The animated property of a channel. node GLTF_ABSENT: an extension names the target. */
typedef struct channel_target {
    gltf_value at;
    uint32_t node;
    const char *path;
    const char *pointer; /* NULL: none */
    int part;            /* GLTF_PARTS: weights; -1: none of a node */
} channel_target;

static int part_of(const char *path) {
    if (strcmp(path, "weights") == 0) return GLTF_PARTS;
    for (int i = 0; i < GLTF_PARTS; ++i) {
        if (strcmp(path, gltf_part_names[i]) == 0) return i;
    }
    return -1;
}

/* KHR_animation_pointer: "/nodes/3/rotation" is equivalent to node 3 with the path "rotation". */
static void read_pointer(gltf *g, channel_target *t) {
    static const char nodes[] = "/nodes/";
    gltf_value holder, at;
    gltf_extension(g, &t->at, "KHR_animation_pointer", &holder, &at);
    gltf_text(g, &at, "pointer", &t->pointer);
    if (!gltf_fine(g) || !t->pointer || strncmp(t->pointer, nodes, strlen(nodes)) != 0) return;
    char *end;
    const unsigned long index = strtoul(t->pointer + strlen(nodes), &end, 10);
    if (*end != '/' || index >= gltf_count(&g->nodes)) return;
    t->part = part_of(end + 1);
    if (t->part >= 0) t->node = (uint32_t)index;
}

static channel_target read_target(gltf *g, const gltf_value *channel) {
    channel_target t = {.node = GLTF_ABSENT, .path = ""};
    gltf_object(g, channel, "target", &t.at);
    gltf_text(g, &t.at, "path", &t.path);
    gltf_index(g, &t.at, "node", &g->nodes, &t.node);
    t.part = part_of(t.path);
    if (strcmp(t.path, "pointer") == 0) read_pointer(g, &t);
    return t;
}

/* A STEP sampler cannot be blurred: the node keeps its pose of the middle of the shutter time. */
static double time_to_pose(gltf *g, const gltf_moment *m, const sampler *s, uint32_t node) {
    const double open = g->moments.items[0].time, shutter = gltf_shutter(g);
    const size_t keys = find_key(s, open + shutter) - find_key(s, open);
    if (keys > g->keys_inside) g->keys_inside = keys;
    if (s->way != STEP) return m->time;
    if (keys)
        gltf_note_node(g, node,
                       "a node jumps while the shutter is open, by STEP, and is not blurred; " GLTF_HELD);
    return open + shutter / 2;
}

/* By the specification, no channel moves a node that has a matrix: nothing says which part of the matrix it
 * would replace. */
static bool is_fixed(gltf *g, const channel_target *to) {
    const gltf_value node = {.json = json_array_get(g->nodes.json, to->node)};
    if (to->part == GLTF_PARTS || !gltf_has_matrix(&node)) return false;
    gltf_note_node(
        g, to->node,
        "a node has a matrix and an animation that moves it; the matrix counts, and the animation is "
        "left out: export it with translation, rotation and scale");
    return true;
}

static void note_times(gltf *g, const sampler *s) {
    double *played = g->scene->played;
    played[0] = fmin(played[0], time_of(s, 0));
    played[1] = fmax(played[1], time_of(s, s->times.count - 1));
}

static void pose_channel(gltf *g, gltf_moment *m, const gltf_value *samplers, const gltf_value *channel) {
    const channel_target to = read_target(g, channel);
    uint32_t index = GLTF_ABSENT;
    gltf_index(g, channel, "sampler", samplers, &index);
    if (index == GLTF_ABSENT) gltf_fail(g, channel, "sampler", "is missing; expected an index into samplers");
    if (!gltf_fine(g)) return;
    if (to.part < 0 && to.pointer && m == g->moments.items)
        gltf_pointer_pose(g, &to.at, to.pointer, samplers, index);
    else if (to.part < 0 && !to.pointer)
        gltf_note(g, &to.at, "path", "the animation of \"%.40s\" is ignored", to.path);
    if (to.part < 0 || to.node == GLTF_ABSENT || is_fixed(g, &to)) return;
    sampler s = sampler_for(to.part);
    read_sampler(g, samplers, index, &s);
    gltf_pose *pose = gltf_fine(g) ? pose_for(g, m, to.node) : NULL;
    if (!pose) {
        gltf_fail_memory(g, sizeof *pose);
        return;
    }
    note_times(g, &s);
    const double time = time_to_pose(g, m, &s, to.node);
    if (to.part == GLTF_PARTS)
        pose_weights(g, &s, time, pose);
    else
        pose_part(g, &s, time, to.part, pose);
}

static void pose_animation(gltf *g, gltf_moment *m, uint32_t index) {
    gltf_value animation, channels, samplers;
    gltf_item(g, &g->animations, index, &animation);
    gltf_array(g, &animation, "channels", &channels);
    gltf_array(g, &animation, "samplers", &samplers);
    for (size_t i = 0; i < gltf_count(&channels) && gltf_fine(g); ++i) {
        gltf_value channel;
        gltf_item(g, &channels, i, &channel);
        pose_channel(g, m, &samplers, &channel);
    }
}

void gltf_animation_pose(gltf *g, gltf_moment *m) {
    g->quiet = g->posed;
    for (size_t i = 0; i < g->playing.count && gltf_fine(g); ++i) pose_animation(g, m, g->playing.items[i]);
    g->quiet = false, g->posed = true;
}

/* ---- choice of animations ---- */

/* The properties that animations move. */
typedef struct moved_things {
    unsigned char *nodes; /* for each node a bit for each part */
    json_t *pointers;     /* an object whose keys are pointers */
} moved_things;

/* The animation moves what one before it moves. */
static void leave_out(gltf *g, const gltf_value *channel) {
    char list[GLTF_LIST];
    where_spot spot;
    gltf_print_names(&g->animations, list);
    if (!g->scene->asked->animations)
        gltf_note(
            g, channel, NULL,
            "an animation that moves what an earlier one moves is left out; give --animation NAME|N for "
            "each to apply: %s",
            list);
    else
        g->status = fail_at(g->context, FATHOM_BAD_USAGE, gltf_place(g, channel, NULL, &spot),
                            "moves what another of the chosen animations moves; expected animations of "
                            "different things out of %s",
                            list);
}

/* True if the animation moves one of these properties, which is then told. add: adds those that it moves. */
static bool moves_any(gltf *g, uint32_t index, const moved_things *moved, bool add) {
    gltf_value animation, channels, channel;
    bool any = false;
    gltf_item(g, &g->animations, index, &animation);
    gltf_array(g, &animation, "channels", &channels);
    for (size_t i = 0; i < gltf_count(&channels) && gltf_fine(g) && !any; ++i) {
        gltf_item(g, &channels, i, &channel);
        g->quiet = true; /* the animations that are played are read again */
        const channel_target to = read_target(g, &channel);
        g->quiet = false;
        if (!gltf_fine(g)) break;
        if (to.part >= 0 && to.node != GLTF_ABSENT) {
            any = !add && moved->nodes[to.node] >> to.part & 1;
            if (add) moved->nodes[to.node] |= (unsigned char)(1 << to.part);
        } else if (to.pointer) {
            any = !add && json_object_get(moved->pointers, to.pointer);
            if (add && json_object_set(moved->pointers, to.pointer, json_true()) != 0)
                gltf_fail_memory(g, strlen(to.pointer));
        }
    }
    if (any) leave_out(g, &channel);
    return any;
}

static void play(gltf *g, uint32_t index, const moved_things *moved) {
    if (!gltf_fine(g) || moves_any(g, index, moved, false)) return;
    moves_any(g, index, moved, true);
    if (!array_push(&g->playing, index)) gltf_fail_memory(g, sizeof index);
}

/* Plays the chosen animations, which must not move a property that another one moves. Without a choice,
 * leaves those out. So of a walk and a run only the first is played. But all animations of a file from
 * Blender are played, because it writes one for each object. */
static void play_together(gltf *g, const char *const *chosen) {
    const size_t nodes = gltf_count(&g->nodes);
    const moved_things moved = {calloc(nodes + 1, 1), json_object()};
    if (!moved.nodes || !moved.pointers) gltf_fail_memory(g, nodes);
    for (uint32_t i = 0; !chosen && i < gltf_count(&g->animations) && gltf_fine(g); ++i) play(g, i, &moved);
    for (; chosen && *chosen && gltf_fine(g); ++chosen)
        play(g, gltf_choose(g, &g->animations, "animation", *chosen), &moved);
    free(moved.nodes);
    json_decref(moved.pointers);
}

void gltf_animation_choose(gltf *g) {
    const fathom_read_options *asked = g->scene->asked;
    const size_t count = gltf_count(&g->animations);
    char list[GLTF_LIST];
    if (!count) return;
    g->scene->has_animations = true;
    if (asked && (asked->animations || asked->choose_time || asked->shutter > 0)) {
        play_together(g, asked->animations);
        return;
    }
    gltf_print_names(&g->animations, list);
    notes_add(&g->notes, count, "", "animations are not played; --time SECONDS poses them: %s", list);
}
