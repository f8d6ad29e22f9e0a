/* Nodes of glTF that deform one mesh: which of them share a posed mesh, and how much memory poses may take.
 */
#include "gltf_build.h"

enum { VERTICES = 600, NODES = 40 };

typedef struct text {
    char items[4096];
} text;

__attribute__((format(printf, 2, 3))) static void add(text *t, const char *format, ...) {
    const size_t length = strlen(t->items);
    va_list args;
    va_start(args, format);
    const int n = vsnprintf(t->items + length, sizeof t->items - length, format, args);
    va_end(args);
    assert_true(n > 0 && (size_t)n < sizeof t->items - length);
}

static int put_vertices(build *b, float height) {
    float points[VERTICES][3];
    for (int i = 0; i < VERTICES; ++i)
        points[i][0] = (float)i, points[i][1] = (float)(i % 3 == 1), points[i][2] = height;
    return put_typed(b, 5126, "VEC3", VERTICES, points, sizeof points, "");
}

/* Nodes with one mesh, each with a weight that follows a spline of its own, of `kinds` different ones. */
static void write_crowd(int kinds) {
    build b = {.size = 0};
    text nodes = {""}, samplers = {""}, channels = {""};
    const int points = put_vertices(&b, 0), target = put_vertices(&b, 1),
              times = PUT_FLOATS(&b, "SCALAR", 2, 0, 1);
    for (int i = 0; i < kinds; ++i) {
        const int curve = PUT_FLOATS(&b, "SCALAR", 6, 0, 0, 9, -5, (float)(i + 1), 0);
        add(&samplers, "%s{'input':%d,'output':%d,'interpolation':'CUBICSPLINE'}", i ? "," : "", times,
            curve);
    }
    for (int i = 0; i < NODES; ++i) {
        add(&nodes, "%s{'mesh':0,'translation':[0,%d,0]}", i ? "," : "", i);
        add(&channels, "%s{'sampler':%d,'target':{'node':%d,'path':'weights'}}", i ? "," : "", i % kinds, i);
    }
    build_write(&b,
                "'meshes':[{'primitives':[{'attributes':{'POSITION':%d},'targets':[{'POSITION':%d}]}]}],"
                "'nodes':[%s],'animations':[{'samplers':[%s],'channels':[%s]}]",
                points, target, nodes.items, samplers.items, channels.items);
}

static fathom_status read_open(double shutter, fathom_scene **out) {
    fathom_read_options asked = default_read_options();
    asked.choose_time = true, asked.shutter = shutter;
    return read_asked(&asked, out);
}

/* The first vertex of the mesh that node i shows, at key k, of which the target moves z. */
static float height_of(const fathom_scene *scene, int i, uint32_t k) {
    const fathom_instance *it = &scene->instances.items[i];
    for (size_t m = 0; m < scene->meshes.count; ++m) {
        const fathom_mesh *mesh = &scene->meshes.items[m];
        if (scene->objects.items[m].group == it->group) return mesh->key_positions[k * 3 * VERTICES + 2];
    }
    fail();
    return 0;
}

/* Each node has the weight of the still scene at each key, whether nodes share a mesh or not. */
static void assert_crowd(int kinds) {
    fathom_scene *scene;
    write_crowd(kinds);
    assert_ok(context, read_open(1, &scene));
    assert_int_equal(scene->instances.count, NODES);
    assert_int_equal(scene->meshes.count, kinds);
    const fathom_mesh *first = &scene->meshes.items[0];
    assert_true(first->key_count > 16); /* so that each mesh has its own poses beyond 128 times the file */
    for (int i = 0; i < NODES; ++i) {
        for (uint32_t k = 0; k < first->key_count; ++k) {
            const double u = first->key_times[k], end = i % kinds + 1;
            const double weight = (u * u * u - 2 * u * u + u) * 9 + (3 * u * u - 2 * u * u * u) * end +
                                  (u * u * u - u * u) * -5;
            /* Sums of terms up to 40 in double, rounded to float once: half of 2^-24 of 64. */
            assert_near((double)height_of(scene, i, k), weight, 0x1p-18);
        }
    }
}

UNIT_TEST(nodes_that_deform_a_mesh_alike_share_it) {
    assert_crowd(1);
    assert_crowd(7);
}

UNIT_TEST(nodes_that_deform_a_mesh_differently_are_posed_each) { assert_crowd(NODES); }

/* The mesh's weights, the node's and the animation's are alike if their numbers are. */
UNIT_TEST(equal_weights_are_alike_wherever_they_stand) {
    build b = {.size = 0};
    const int points = PUT_FLOATS(&b, "VEC3", 3, 0, 0, 0, 1, 0, 0, 0, 1, 0),
              target = PUT_FLOATS(&b, "VEC3", 3, 0, 0, 8, 0, 0, 0, 0, 0, 0),
              times = PUT_FLOATS(&b, "SCALAR", 2, 0, 1), rests = PUT_FLOATS(&b, "SCALAR", 2, 0.5f, 0.5f);
    build_write(
        &b,
        "'meshes':[{'weights':[0.5],'primitives':[{'attributes':{'POSITION':%d},'targets':[{'POSITION':%d}]}]"
        "}],'nodes':[{'mesh':0},{'mesh':0,'weights':[0.5]},{'mesh':0},{'mesh':0,'weights':[0.25]},{'mesh':0}]"
        ","
        "'animations':[{'samplers':[{'input':%d,'output':%d}],'channels':[{'sampler':0,'target':{'node':2,"
        "'path':'weights'}}]}]",
        points, target, times, rests);
    fathom_scene *scene;
    assert_ok(context, read_open(1, &scene));
    assert_int_equal(scene->meshes.count, 2);
    for (size_t i = 0; i < 5; ++i) {
        assert_int_equal(scene->instances.items[i].group == scene->instances.items[0].group, i != 3);
    }
    assert_vec(corner(scene, 0, 0, 0), 0, 0, 4, 0);
    assert_vec(corner(scene, 1, 0, 0), 0, 0, 2, 0);
}

/* A target without weight as the shutter opens, and another that never has any. */
UNIT_TEST(targets_are_told_of_if_they_count_at_any_moment) {
    build b = {.size = 0};
    const int points = PUT_FLOATS(&b, "VEC3", 3, 0, 0, 0, 1, 0, 0, 0, 1, 0),
              times = PUT_FLOATS(&b, "SCALAR", 2, 0, 1), grows = PUT_FLOATS(&b, "SCALAR", 4, 0, 0, 1, 0);
    build_write(&b,
                "'meshes':[{'primitives':[{'attributes':{'POSITION':%d},'targets':[{'COLOR_0':%d},{'TEXCOORD_"
                "0':%d}]}]"
                "}],'nodes':[{'mesh':0}],'animations':[{'samplers':[{'input':%d,'output':%d}],'channels':[{'"
                "sampler':0"
                ",'target':{'node':0,'path':'weights'}}]}]",
                points, points, points, times, grows);
    for (int open = 0; open < 2; ++open) {
        fathom_scene *scene;
        assert_ok(context, read_open(open, &scene));
        assert_int_equal(warning_count, open);
        if (open) expect_warning("morph targets of COLOR_0 are ignored (1 such)");
    }
}

/* A million vertices without data, in 65 poses: 780 MB by a file of 2 kB. */
UNIT_TEST(poses_without_end_are_refused) {
    build b = {.size = 0};
    float times[40], values[40];
    for (int k = 0; k < 40; ++k) times[k] = (float)k / 39, values[k] = (float)(k % 2);
    const int input = put_typed(&b, 5126, "SCALAR", 40, times, sizeof times, ""),
              output = put_typed(&b, 5126, "SCALAR", 40, values, sizeof values, "");
    strcat(b.accessors, ",{'componentType':5126,'type':'VEC3','count':1000000}");
    build_write(
        &b,
        "'meshes':[{'primitives':[{'attributes':{'POSITION':2},'targets':[{'POSITION':2}]}]}],'nodes':"
        "[{'mesh':0}],'animations':[{'samplers':[{'input':%d,'output':%d}],'channels':[{'sampler':0,"
        "'target':{'node':0,'path':'weights'}}]}]",
        input, output);
    fathom_scene *scene;
    assert_fails(context, read_open(1, &scene), FATHOM_BAD_INPUT,
                 "meshes[0].primitives[0]: raises the poses of the file's nodes to ");
}

int main(void) { return unit_main(open_folder, remove_folder); }
