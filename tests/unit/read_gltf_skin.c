/* Skins of glTF: what follows the joints beside positions, joints that flatten, what is refused. */
#include "gltf_build.h"

/* A triangle whose corners follow joint 0, which stands, joint 1, and half of each. `bones`: the nodes 1 and
 * 2 that are the joints; `more`: attributes besides. */
typedef struct figure {
    build b;
    int positions, normals, tangents, joints, weights;
} figure;

#define SLANTED 0.6f, 0.8f, 0
#define ALONG 0.8f, -0.6f, 0

static figure new_figure(void) {
    figure f = {.b = {.size = 0}};
    f.positions = PUT_FLOATS(&f.b, "VEC3", 3, 0, 0, 0, 1, 0, 0, 0, 1, 0.5f);
    f.normals = PUT_FLOATS(&f.b, "VEC3", 3, SLANTED, SLANTED, SLANTED);
    f.tangents = PUT_FLOATS(&f.b, "VEC4", 3, ALONG, -1, ALONG, -1, ALONG, 1);
    f.joints = PUT_BYTES(&f.b, "VEC4", 3, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0);
    f.weights = PUT_FLOATS(&f.b, "VEC4", 3, 1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0);
    return f;
}

static void write_figure(const figure *f, const char *bones, const char *more, const char *skin) {
    build_write(
        &f->b,
        "'meshes':[{'primitives':[{'attributes':{'POSITION':%d,'NORMAL':%d,'TANGENT':%d,'JOINTS_0':%d,"
        "'WEIGHTS_0':%d%s},'material':0}]}],'materials':[{'pbrMetallicRoughness':{},'extensions':{"
        "'KHR_materials_anisotropy':{'anisotropyStrength':0.5}}}],'skins':[{%s}],'nodes':[{'mesh':0,'skin':0}"
        ",%s]",
        f->positions, f->normals, f->tangents, f->joints, f->weights, more, skin, bones);
}

#define JOINTS "'joints':[1,2]"

static vec3_f64 row_of(const float *values, size_t stride, uint32_t i) {
    return widen(load_f32(mesh_row(values, stride, i)));
}

/* Joint 1 is twice as wide along x, which turns to y. Tangents go with the surface, and normals stay
 * perpendicular to it. */
UNIT_TEST(tangents_lie_in_the_surface_and_normals_stand_on_it) {
    const figure made = new_figure();
    write_figure(&made, "{},{'rotation':[0,0,0.70710678118,0.70710678118],'scale':[2,1,1]}", "", JOINTS);
    fathom_scene *scene = read_file();
    const fathom_mesh *mesh = &scene->meshes.items[0];
    assert_non_null(mesh->tangents);
    /* (0.6, 0.8) is divided by (2, 1), (0.8, -0.6) multiplied, and x becomes y, y becomes -x. */
    const double n = hypot(0.3, 0.8), t = hypot(1.6, 0.6);
    static const float signs[] = {-1, -1, 1};
    assert_vec(row_of(mesh->normals, mesh->normal_stride, 0), 0.6, 0.8, 0, 1e-7);
    assert_vec(row_of(mesh->normals, mesh->normal_stride, 1), -0.8 / n, 0.3 / n, 0, 1e-7);
    assert_vec(row_of(mesh->tangents, mesh->tangent_stride, 0), 0.8, -0.6, 0, 1e-7);
    assert_vec(row_of(mesh->tangents, mesh->tangent_stride, 1), 0.6 / t, 1.6 / t, 0, 1e-7);
    for (uint32_t i = 0; i < 3; ++i) {
        assert_true(((const float *)mesh_row(mesh->tangents, mesh->tangent_stride, i))[3] == signs[i]);
        const double off = dot_f64(row_of(mesh->normals, mesh->normal_stride, i),
                                   row_of(mesh->tangents, mesh->tangent_stride, i));
        assert_near(off, 0, 2e-7);
    }
}

/* Where the corners are, the joints say, and the winding the node. Blender has the mesh below the armature,
 * and writes vertices that the armature has mirrored: then only the node mirrors. Normals and tangents stay
 * on their side of the surface, as in a mirroring instance. */
UNIT_TEST(joints_mirror_the_surface_and_nodes_the_winding) {
    static const struct {
        const char *children;
        bool node, joints;
    } cases[] = {{"0,1,2", true, true}, {"1,2", false, true}, {"0", true, false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const figure made = new_figure();
        write_figure(&made, unit_text("{},{},{'scale':[1,1,-2],'children':[%s]}", cases[i].children), "",
                     JOINTS);
        fathom_scene *scene = read_file();
        const fathom_mesh *mesh = &scene->meshes.items[0];
        affine_f64 map;
        affine_load(&map, scene->instances.items[0].transform);
        assert_vec(placed_corner(scene, 0, 0, 2), 0, 1, cases[i].joints ? -1 : 0.5, 0);
        assert_near(map.m[0][0], cases[i].node ? -1 : 1, 0);
        assert_vec(affine_vector(&map, row_of(mesh->normals, mesh->normal_stride, 0)), 0.6, 0.8, 0, 1e-7);
        assert_vec(affine_vector(&map, row_of(mesh->tangents, mesh->tangent_stride, 0)), 0.8, -0.6, 0, 1e-7);
        const double w = (double)((const float *)mesh_row(mesh->tangents, mesh->tangent_stride, 0))[3];
        assert_near(map.m[0][0] * w, cases[i].joints ? 1 : -1, 0);
    }
}

/* Animations scale a joint to nothing to hide a part. What is left keeps its normals. */
UNIT_TEST(joints_that_flatten_hide_their_part) {
    static const char *const scales[] = {"[0,0,0]", "[1,0,0]", "[1,1,0]"};
    for (size_t i = 0; i < sizeof scales / sizeof *scales; ++i) {
        const figure made = new_figure();
        write_figure(&made, unit_text("{},{'scale':%s}", scales[i]), "", JOINTS);
        fathom_scene *scene = read_file();
        const fathom_mesh *mesh = &scene->meshes.items[0];
        assert_vec(corner(scene, 0, 0, 1), i ? 1 : 0, 0, 0, 0);
        assert_vec(row_of(mesh->normals, mesh->normal_stride, 0), 0.6, 0.8, 0, 1e-7);
        assert_vec(row_of(mesh->tangents, mesh->tangent_stride, 0), 0.8, -0.6, 0, 1e-7);
    }
}

/* A scale of zero along one axis leaves a flat surface, which no transform of an instance can. Along two,
 * nothing is left. */
UNIT_TEST(nodes_that_flatten_leave_a_surface) {
    for (int kept = 0; kept < 2; ++kept) {
        build b = {.size = 0};
        const int p = PUT_FLOATS(&b, "VEC3", 3, 0, 0, 3, 1, 0, 4, 0, 1, 5),
                  n = PUT_FLOATS(&b, "VEC3", 3, 0, 0.6f, 0.8f, 0, 0.6f, 0.8f, 0, 0.6f, 0.8f);
        build_write(
            &b,
            "'meshes':[{'primitives':[{'attributes':{'POSITION':%d,'NORMAL':%d}}]}],'nodes':[{'mesh':0},"
            "{'mesh':0,'translation':[0,0,7],'scale':[2,%d,0]},{'mesh':0,'translation':[1,0,7],'scale':["
            "2,%d,0]}]",
            p, n, kept, kept);
        fathom_scene *scene = read_file();
        assert_int_equal(scene->instances.count, kept ? 3 : 1);
        assert_int_equal(warning_count, kept ? 0 : 1);
        assert_int_equal(scene->meshes.count, kept ? 3 : 1); /* each has its place in its vertices */
        if (kept) {
            assert_vec(placed_corner(scene, 1, 1, 1), 2, 0, 7, 0);
            assert_vec(placed_corner(scene, 2, 2, 1), 3, 0, 7, 0);
            assert_vec(row_of(scene->meshes.items[1].normals, scene->meshes.items[1].normal_stride, 0), 0, 0,
                       1, 0);
        }
    }
}

/* Exporters fill unused places with any number. */
UNIT_TEST(joints_of_no_weight_may_be_any_number) {
    figure made = new_figure();
    made.joints = PUT_BYTES(&made.b, "VEC4", 3, 9, 0, 9, 9, 1, 9, 9, 9, 0, 1, 9, 9);
    made.weights = PUT_FLOATS(&made.b, "VEC4", 3, 0, 1, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0);
    const int joints = PUT_BYTES(&made.b, "VEC4", 3, 255, 9, 9, 9, 255, 9, 9, 9, 255, 0, 9, 9),
              weights = PUT_FLOATS(&made.b, "VEC4", 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0);
    write_figure(&made, "{},{'translation':[4,0,0]}",
                 unit_text(",'JOINTS_1':%d,'WEIGHTS_1':%d", joints, weights), JOINTS);
    fathom_scene *scene = read_file();
    assert_vec(placed_corner(scene, 0, 0, 1), 5, 0, 0, 1e-6);
    /* Half of joint 1, and three halves of joint 0, of two. */
    assert_vec(placed_corner(scene, 0, 0, 2), 4 * 0.25, 1, 0.5, 1e-6);
    assert_int_equal(warning_count, 0);
}

UNIT_TEST(vertices_blur_with_their_joints_alone) {
    figure made = new_figure();
    const int times = PUT_FLOATS(&made.b, "SCALAR", 2, 0, 2),
              places = PUT_FLOATS(&made.b, "VEC3", 2, 0, 0, 0, 4, 0, 0);
    write_figure(
        &made,
        unit_text(
            "{},{}],'animations':[{'samplers':[{'input':%d,'output':%d}],'channels':[{'sampler':0,'target':{"
            "'node':2,'path':'translation'}}]}",
            times, places),
        "", JOINTS);
    fathom_read_options asked = default_read_options();
    asked.choose_time = true, asked.time = 0.5, asked.shutter = 1;
    fathom_scene *scene = read_as(&asked);
    const fathom_mesh *mesh = &scene->meshes.items[0];
    assert_true(mesh->key_count > 1);
    for (uint32_t k = 0; k < mesh->key_count; ++k) {
        const float *p = mesh->key_positions + 9 * k;
        const double x = 2 * mesh->key_times[k];
        assert_vec(widen(load_f32(p)), 0, 0, 0, 0);
        assert_vec(widen(load_f32(p + 3)), 1 + x, 0, 0, 1e-6);
        assert_vec(widen(load_f32(p + 6)), x / 2, 1, 0.5, 1e-6);
    }
    assert_near(mesh->key_times[0], 0.5, 0);
    assert_near(mesh->key_times[mesh->key_count - 1], 1.5, 0);
}

UNIT_TEST(joints_beyond_eight_sets_are_told) {
    const figure made = new_figure();
    char more[512] = "";
    for (int n = 1; n < 9; ++n)
        snprintf(more + strlen(more), 64, ",'JOINTS_%d':%d,'WEIGHTS_%d':%d", n, made.joints, n, made.weights);
    write_figure(&made, "{},{'translation':[4,0,0]}", more, JOINTS);
    fathom_scene *scene = read_file();
    assert_vec(placed_corner(scene, 0, 0, 1), 5, 0, 0, 1e-6);
    expect_warning("joints beyond the first 32 of a vertex are left out");
}

UNIT_TEST(wrong_skins_are_refused) {
    const figure good = new_figure();
    figure all = good;
    const int one = PUT_FLOATS(&all.b, "MAT4", 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1),
              wrong = PUT_FLOATS(&all.b, "MAT4", 2, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0,
                                 0.5f, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1),
              few = PUT_BYTES(&all.b, "VEC4", 2, 0, 0, 0, 0, 1, 0, 0, 0),
              lost = PUT_BYTES(&all.b, "VEC4", 3, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 0),
              none = PUT_FLOATS(&all.b, "VEC4", 3, 1, 0, 0, 0, 0, 0, 0, 0, 0.5f, 0.5f, 0, 0),
              light = PUT_FLOATS(&all.b, "VEC4", 2, 1, 0, 0, 0, 1, 0, 0, 0);
    const char *few_bind = unit_text(JOINTS ",'inverseBindMatrices':%d", one);
    const char *wrong_bind = unit_text(JOINTS ",'inverseBindMatrices':%d", wrong);
    const struct {
        const char *skin;
        int joints, weights;
        const char *text;
    } cases[] = {
        {"'joints':[]", all.joints, all.weights, "skins[0].joints: is empty; expected at least one node"},
        {few_bind, all.joints, all.weights,
         "skins[0].inverseBindMatrices: has 1 entries; expected one for each of 2 joints"},
        {wrong_bind, all.joints, all.weights, "skins[0].inverseBindMatrices: "},
        {JOINTS, lost, none, "JOINTS_0: entry 1 names joint 2; the skin has 2"},
        {JOINTS, few, all.weights, "JOINTS_0: has 2 entries; expected as many as POSITION has, 3"},
        {JOINTS, all.joints, light, "WEIGHTS_0: has 2 entries; expected as many as POSITION has, 3"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        fathom_scene *scene;
        fathom_read_options asked = default_read_options();
        figure made = all;
        made.joints = cases[i].joints, made.weights = cases[i].weights;
        write_figure(&made, "{},{}", "", cases[i].skin);
        assert_fails(context, read_asked(&asked, &scene), FATHOM_BAD_INPUT, cases[i].text);
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
