/* glTF features in combination: sparse and normalized arrays, morph targets and splines of them, instances in
 * mirrored and moving nodes. Expectations are the formulas of the specification. */
#include "gltf_build.h"

#include "scene/motion/motion.h"

#define TRIANGLE 0, 0, 0, 1, 0, 0, 0, 1, 0
#define PUT_SHORTS(b, type, count, more, ...)                                                                \
    put_typed(b, 5122, type, count, (const int16_t[]){__VA_ARGS__}, sizeof((const int16_t[]){__VA_ARGS__}),  \
              more)
#define PUT_SIGNED(b, type, count, more, ...)                                                                \
    put_typed(b, 5120, type, count, (const int8_t[]){__VA_ARGS__}, sizeof((const int8_t[]){__VA_ARGS__}),    \
              more)

/* A sparse accessor: `indices` and `values` are accessors made before, whose views it takes. base: its view;
 * -1: zeros. */
static int put_sparse(build *b, int component, const char *type, unsigned count, int base, unsigned replaced,
                      int indices, int index_type, int values, const char *more) {
    char view[32] = "";
    if (base >= 0) snprintf(view, sizeof view, "'bufferView':%d,", base);
    const int view_number = b->count;
    /* A view for the number of the accessor, which build_write() needs. */
    (void)put_typed(b, 5121, "SCALAR", 1, "", 1, "");
    char *last = strrchr(b->accessors, '{');
    snprintf(last, 512,
             "{%s'componentType':%d,'type':'%s','count':%u%s,'sparse':{'count':%u,'indices':{'bufferView':%d,"
             "'componentType':%d},'values':{'bufferView':%d}}}",
             view, component, type, count, more, replaced, indices, index_type, values);
    return view_number;
}

/* max(c / 127, -1) and max(c / 32767, -1), for what is replaced as for what is not. */
UNIT_TEST(sparse_values_are_normalized_as_others) {
    static const char scaled[] = ",'normalized':true";
    build b = {.size = 0};
    const int points = PUT_SHORTS(&b, "VEC3", 3, scaled, 0, 0, 0, 32767, 0, 0, 0, -32768, 0),
              which = PUT_BYTES(&b, "SCALAR", 2, 0, 2),
              moved = PUT_SHORTS(&b, "VEC3", 2, scaled, -32768, 16384, 0, 0, 0, 32767),
              normals = PUT_SIGNED(&b, "VEC3", 2, scaled, 0, 0, 127, -128, 64, 0),
              sparse = put_sparse(&b, 5122, "VEC3", 3, points, 2, which, 5121, moved, scaled),
              sparse_normals = put_sparse(&b, 5120, "VEC3", 3, -1, 2, which, 5121, normals, scaled);
    build_write(&b,
                "'meshes':[{'primitives':[{'attributes':{'POSITION':%d,'NORMAL':%d}}]}],'nodes':[{'mesh':0}]",
                sparse, sparse_normals);
    fathom_scene *scene = read_file();
    const fathom_mesh *m = &scene->meshes.items[0];
    assert_vec(corner(scene, 0, 0, 0), -1, (double)(16384 / 32767.0f), 0, 0);
    assert_vec(corner(scene, 0, 0, 1), 1, 0, 0, 0);
    assert_vec(corner(scene, 0, 0, 2), 0, 0, 1, 0);
    assert_vec(widen(load_f32(mesh_row(m->normals, m->normal_stride, 0))), 0, 0, 1, 0);
    assert_vec(widen(load_f32(mesh_row(m->normals, m->normal_stride, 1))), 0, 0, 0, 0);
    assert_vec(widen(load_f32(mesh_row(m->normals, m->normal_stride, 2))), -1, (double)(64 / 127.0f), 0, 0);
}

/* Colours and uvs in bytes, sparse over nothing; KHR_mesh_quantization has uvs that are not normalized. */
UNIT_TEST(sparse_looks_are_read) {
    build b = {.size = 0};
    const int points = PUT_FLOATS(&b, "VEC3", 3, TRIANGLE),
              which = put_typed(&b, 5123, "SCALAR", 1, (const uint16_t[]){1}, 2, ""),
              color = PUT_BYTES(&b, "VEC4", 1, 255, 0, 51, 102), uv = PUT_BYTES(&b, "VEC2", 1, 3, 255),
              colors = put_sparse(&b, 5121, "VEC4", 3, -1, 1, which, 5123, color, ",'normalized':true"),
              uvs = put_sparse(&b, 5121, "VEC2", 3, -1, 1, which, 5123, uv, ""),
              uvs_1 = put_sparse(&b, 5121, "VEC2", 3, -1, 1, which, 5123, uv, ",'normalized':true");
    build_write(&b,
                "'meshes':[{'primitives':[{'attributes':{'POSITION':%d,'COLOR_0':%d,'TEXCOORD_0':%d,"
                "'TEXCOORD_1':%d},'material':0}]}],'materials':[{'alphaMode':'BLEND'}],'nodes':[{'mesh':0}]",
                points, colors, uvs, uvs_1);
    fathom_scene *scene = read_file();
    const fathom_mesh *m = &scene->meshes.items[0];
    assert_int_equal(m->color_channels, 4);
    for (size_t i = 0; i < 3; ++i) {
        const float on = i == 1, *c = mesh_row(m->colors, m->color_stride, i),
                    *uv0 = mesh_row(m->uvs, m->uv_stride, i), *uv1 = mesh_row(m->uvs_1, m->uv_1_stride, i);
        assert_true(c[0] == on && c[1] == 0 && c[2] == on * (51 / 255.0f) && c[3] == on * (102 / 255.0f));
        assert_true(uv0[0] == 3 * on && uv0[1] == 255 * on);
        assert_true(uv1[0] == on * (3 / 255.0f) && uv1[1] == on);
    }
}

/* Of each key the in-tangents of all weights, then their values, then their out-tangents (specification,
 * 3.11). Targets are sparse, as exporters write them. */
UNIT_TEST(splines_of_weights_move_sparse_targets) {
    build b = {.size = 0};
    const int points = PUT_FLOATS(&b, "VEC3", 3, TRIANGLE), which = PUT_BYTES(&b, "SCALAR", 1, 2),
              up = PUT_FLOATS(&b, "VEC3", 1, 0, 0, 8), aside = PUT_FLOATS(&b, "VEC3", 1, -4, 0, 0),
              first = put_sparse(&b, 5126, "VEC3", 3, -1, 1, which, 5121, up, ""),
              second = put_sparse(&b, 5126, "VEC3", 3, -1, 1, which, 5121, aside, ""),
              times = PUT_FLOATS(&b, "SCALAR", 2, 1, 3),
              weights = PUT_FLOATS(&b, "SCALAR", 12, 9, 9, 0, 1, 1, 0.5f, 0.25f, -1, 1, 0.5f, 9, 9);
    build_write(
        &b,
        "'meshes':[{'primitives':[{'attributes':{'POSITION':%d},'targets':[{'POSITION':%d},{'POSITION':"
        "%d}]}]}],'nodes':[{'mesh':0}],'animations':[{'samplers':[{'input':%d,'output':%d,"
        "'interpolation':'CUBICSPLINE'}],'channels':[{'sampler':0,'target':{'node':0,'path':'weights'}"
        "}]}]",
        points, first, second, times, weights);
    /* In the middle of 2 seconds: (a + b) / 2 + 2 (out - in) / 8. */
    const double w[2] = {0.5 + 0.25 * (1 - 0.25), 0.75 + 0.25 * (0.5 + 1)};
    fathom_scene *scene = read_at(2);
    assert_vec(corner(scene, 0, 0, 2), -4 * w[1], 1, 8 * w[0], 0);
    assert_vec(corner(scene, 0, 0, 1), 1, 0, 0, 0);
    scene = read_at(3);
    assert_vec(corner(scene, 0, 0, 2), -2, 1, 8, 0);
}

/* A weight of 0 when the shutter opens: the stored vertices, interleaved with others, are the first key. */
UNIT_TEST(moving_targets_may_begin_at_rest) {
    build b = {.size = 0};
    static const float mixed[] = {0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1};
    const int both = put_typed(&b, 5126, "VEC3", 3, mixed, sizeof mixed, ""),
              target = PUT_FLOATS(&b, "VEC3", 3, 0, 0, 2, 0, 0, 2, 0, 0, 2),
              times = PUT_FLOATS(&b, "SCALAR", 2, 0, 1), weights = PUT_FLOATS(&b, "SCALAR", 2, 0, 1);
    char *view = strstr(b.views, "'byteLength':72");
    assert_non_null(view);
    memmove(view + 31, view + 15, strlen(view + 15) + 1);
    memcpy(view, "'byteLength':72,'byteStride':24", 31);
    (void)put_typed(&b, 5126, "VEC3", 3, mixed, 4, ",'unused':0");
    char *last = strrchr(b.accessors, '{');
    snprintf(last, 256, "{'bufferView':%d,'byteOffset':12,'componentType':5126,'type':'VEC3','count':3}",
             both);
    build_write(
        &b,
        "'meshes':[{'primitives':[{'attributes':{'POSITION':%d,'NORMAL':%d},'targets':[{'POSITION':%d}]"
        "}]}],'nodes':[{'mesh':0}],'animations':[{'samplers':[{'input':%d,'output':%d}],'channels':["
        "{'sampler':0,'target':{'node':0,'path':'weights'}}]}]",
        both, b.count - 1, target, times, weights);
    fathom_read_options asked = default_read_options();
    asked.choose_time = true, asked.time = 0, asked.shutter = 1;
    fathom_scene *scene = read_as(&asked);
    const fathom_mesh *m = &scene->meshes.items[0];
    assert_int_equal(m->key_count, 2);
    for (size_t k = 0; k < 2; ++k) {
        for (size_t i = 0; i < 3; ++i) {
            const float *p = m->key_positions + 9 * k + 3 * i, *n = m->key_normals + 9 * k + 3 * i;
            assert_true(p[0] == (i == 1) && p[1] == (i == 2) && p[2] == 2 * (float)k);
            assert_true(n[0] == 0 && n[1] == 0 && n[2] == 1);
        }
    }
}

/* A quaternion of a spline is normalized before use; here (0, 0, sqrt(1/2), sqrt(1/2)) / 2 from normalized
 * shorts. */
UNIT_TEST(splines_of_rotations_are_normalized) {
    build b = {.size = 0};
    const int points = PUT_FLOATS(&b, "VEC3", 3, TRIANGLE), times = PUT_FLOATS(&b, "SCALAR", 2, 0, 1),
              turns = PUT_SHORTS(&b, "VEC4", 6, ",'normalized':true", 0, 0, 0, 0, 0, 0, 0, 32767, 0, 0, 0, 0,
                                 0, 0, 0, 0, 0, 0, 32767, 0, 0, 0, 0, 0);
    build_write(
        &b,
        "'meshes':[{'primitives':[{'attributes':{'POSITION':%d}}]}],'nodes':[{'mesh':0}],'animations':["
        "{'samplers':[{'input':%d,'output':%d,'interpolation':'CUBICSPLINE'}],'channels':[{'sampler':0,"
        "'target':{'node':0,'path':'rotation'}}]}]",
        points, times, turns);
    fathom_scene *scene = read_at(0.5);
    /* A quarter turn about z; a handful of roundings on numbers up to 1. */
    assert_vec(placed_corner(scene, 0, 0, 1), 0, 1, 0, 8 * 0x1p-53);
    assert_vec(placed_corner(scene, 0, 0, 2), -1, 0, 0, 8 * 0x1p-53);
}

/* Instances of a node: its transform, mirrored here, after translation, rotation and scale of each; with its
 * motion. Rotations are normalized bytes. */
UNIT_TEST(instances_follow_mirrored_and_moving_nodes) {
    build b = {.size = 0};
    const int points = PUT_FLOATS(&b, "VEC3", 3, TRIANGLE),
              places = PUT_FLOATS(&b, "VEC3", 2, 0, 0, 5, 1, 2, 3),
              turns = PUT_SIGNED(&b, "VEC4", 2, ",'normalized':true", 0, 0, 0, 127, 0, 0, 127, 0),
              sizes = PUT_FLOATS(&b, "VEC3", 2, 1, 1, 1, 2, 4, 1), times = PUT_FLOATS(&b, "SCALAR", 2, 0, 1),
              slide = PUT_FLOATS(&b, "VEC3", 2, 0, 0, 0, 0, 16, 0);
    build_write(
        &b,
        "'meshes':[{'primitives':[{'attributes':{'POSITION':%d}}]}],'nodes':[{'children':[1],'scale':"
        "[-1,1,1]},{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':%d,"
        "'ROTATION':%d,'SCALE':%d}}}}],'scenes':[{'nodes':[0]}],'animations':[{'samplers':[{'input':%d,"
        "'output':%d}],'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}]}]",
        points, places, turns, sizes, times, slide);
    fathom_read_options asked = default_read_options();
    asked.choose_time = true, asked.time = 0, asked.shutter = 0.5;
    fathom_scene *scene = read_as(&asked);
    assert_int_equal(scene->instances.count, 2);
    for (int k = 0; k < 3; ++k) {
        const affine_f64 one = motion_place(&scene->instances.items[0], 0.25 * k),
                         two = motion_place(&scene->instances.items[1], 0.25 * k);
        /* The half turn takes (1, 1, 0), scaled to (2, 4, 0), to (-2, -4, 0). Between keys, a turn is taken
         * apart and put together, in tens of roundings on numbers up to 16. */
        assert_vec(affine_point(&one, (vec3_f64){1, 1, 0}), -1, 1 + 4 * k, 5, 64 * 16 * 0x1p-53);
        assert_vec(affine_point(&two, (vec3_f64){1, 1, 0}), 1, -2 + 4 * k, 3, 64 * 16 * 0x1p-53);
    }
}

/* Twelve vertices, of which each primitive uses three: what is left of every array belongs to the vertex that
 * it was written for, whose number is in all its values. */
UNIT_TEST(shared_arrays_are_cut_alike) {
    build b = {.size = 0};
    float points[12][3], normals[12][3], tangents[12][4], uvs[12][2], uvs_1[12][2];
    uint8_t colors[12][4];
    for (int i = 0; i < 12; ++i) {
        const float n = (float)i;
        memcpy(points[i], (float[3]){n, n * n, 1}, sizeof points[i]);
        memcpy(normals[i], (float[3]){n, 0, 1}, sizeof normals[i]);
        memcpy(tangents[i], (float[4]){0, n, 1, i % 2 ? 1 : -1}, sizeof tangents[i]);
        memcpy(uvs[i], (float[2]){n, 1}, sizeof uvs[i]), memcpy(uvs_1[i], (float[2]){1, n}, sizeof uvs_1[i]);
        memcpy(colors[i], (uint8_t[4]){(uint8_t)i, 0, 0, (uint8_t)(255 - i)}, sizeof colors[i]);
    }
    const int position = put_typed(&b, 5126, "VEC3", 12, points, sizeof points, ""),
              normal = put_typed(&b, 5126, "VEC3", 12, normals, sizeof normals, ""),
              tangent = put_typed(&b, 5126, "VEC4", 12, tangents, sizeof tangents, ""),
              uv = put_typed(&b, 5126, "VEC2", 12, uvs, sizeof uvs, ""),
              uv_1 = put_typed(&b, 5126, "VEC2", 12, uvs_1, sizeof uvs_1, ""),
              color = put_typed(&b, 5121, "VEC4", 12, colors, sizeof colors, ",'normalized':true"),
              first = PUT_BYTES(&b, "SCALAR", 3, 11, 4, 7), second = PUT_BYTES(&b, "SCALAR", 3, 2, 5, 3);
#define SHARED                                                                                               \
    "{'attributes':{'POSITION':%d,'NORMAL':%d,'TANGENT':%d,'TEXCOORD_0':%d,'TEXCOORD_1':%d,'COLOR_0':%d},"   \
    "'indices':%d,'material':0}"
    build_write(&b,
                "'meshes':[{'primitives':[" SHARED "," SHARED
                "]}],'materials':[{'alphaMode':'BLEND'}],'nodes':[{'mesh':0}]",
                position, normal, tangent, uv, uv_1, color, first, position, normal, tangent, uv, uv_1, color,
                second);
    fathom_scene *scene = read_file();
    static const uint32_t used[2][3] = {{11, 4, 7}, {2, 5, 3}};
    assert_int_equal(scene->meshes.count, 2);
    for (size_t m = 0; m < 2; ++m) {
        const fathom_mesh *mesh = &scene->meshes.items[m];
        assert_int_equal(mesh->vertex_count, 3);
        for (size_t k = 0; k < 3; ++k) {
            const size_t i = mesh->indices[k];
            const float n = (float)used[m][k], *p = mesh_row(mesh->positions, mesh->position_stride, i),
                        *t = mesh_row(mesh->tangents, mesh->tangent_stride, i),
                        *c = mesh_row(mesh->colors, mesh->color_stride, i);
            assert_true(p[0] == n && p[1] == n * n && t[1] == n && t[3] == (used[m][k] % 2 ? 1 : -1));
            assert_true(mesh_row(mesh->normals, mesh->normal_stride, i)[0] == n);
            assert_true(mesh_row(mesh->uvs, mesh->uv_stride, i)[0] == n);
            assert_true(mesh_row(mesh->uvs_1, mesh->uv_1_stride, i)[1] == n);
            assert_true(c[0] == n / 255 && c[3] == (255 - n) / 255);
        }
    }
}

/* Strips, fans, loops and strips of lines by indices that skip vertices. */
UNIT_TEST(odd_modes_take_indices) {
    static const struct {
        int mode;
        uint32_t triangles, corners[9]; /* by the specification, 3.7.2.1 */
    } cases[] = {{4, 1, {4, 1, 3}}, {5, 3, {4, 1, 3, 1, 0, 3, 3, 0, 2}}, {6, 3, {1, 3, 4, 3, 0, 4, 0, 2, 4}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        build b = {.size = 0};
        const int points = PUT_FLOATS(&b, "VEC3", 5, 0, 0, 0, 1, 0, 0, 2, 1, 0, 3, 3, 0, 4, 7, 1),
                  order = put_typed(&b, 5123, "SCALAR", 5, (const uint16_t[]){4, 1, 3, 0, 2}, 10, "");
        build_write(
            &b,
            "'meshes':[{'primitives':[{'attributes':{'POSITION':%d},'indices':%d,'mode':%d}]}],'nodes':"
            "[{'mesh':0}]",
            points, order, cases[i].mode);
        fathom_scene *scene = read_file();
        assert_int_equal(scene->meshes.items[0].triangle_count, cases[i].triangles);
        for (uint32_t k = 0; k < 3 * cases[i].triangles; ++k)
            assert_near(corner(scene, 0, k / 3, (int)(k % 3)).x, cases[i].corners[k], 0);
    }
}

/* What only shading reads is 0 where it is no number, and the rest of it is what the file says; of morph
 * targets, too. */
UNIT_TEST(numbers_that_are_none_are_zero) {
    const float nan = NAN;
    build b = {.size = 0};
    const int points = PUT_FLOATS(&b, "VEC3", 3, TRIANGLE),
              normals = PUT_FLOATS(&b, "VEC3", 3, 0, 0, 1, nan, nan, nan, 0, 0, 1),
              tangents = PUT_FLOATS(&b, "VEC4", 3, 1, 0, 0, 1, 1, nan, 0, -1, 1, 0, 0, 1),
              uvs = PUT_FLOATS(&b, "VEC2", 3, 1, 2, 3, INFINITY, 5, 6),
              colors = PUT_FLOATS(&b, "VEC3", 3, 0.5f, 0.5f, 0.5f, 0.25f, nan, 1, 0.5f, 0.5f, 0.5f),
              bent = PUT_FLOATS(&b, "VEC3", 3, nan, 0, 0, 0, 2, 0, 0, 0, 0);
    build_write(
        &b,
        "'meshes':[{'weights':[0.5],'primitives':[{'attributes':{'POSITION':%d,'NORMAL':%d,'TANGENT':%d,"
        "'TEXCOORD_0':%d,'COLOR_0':%d},'targets':[{'NORMAL':%d}]}]}],'nodes':[{'mesh':0}]",
        points, normals, tangents, uvs, colors, bent);
    fathom_scene *scene = read_file();
    const fathom_mesh *m = &scene->meshes.items[0];
    const float *t = mesh_row(m->tangents, m->tangent_stride, 1), *uv = mesh_row(m->uvs, m->uv_stride, 1),
                *c = mesh_row(m->colors, m->color_stride, 1);
    assert_vec(widen(load_f32(mesh_row(m->normals, m->normal_stride, 0))), 0, 0, 1, 0);
    assert_vec(widen(load_f32(mesh_row(m->normals, m->normal_stride, 1))), 0, 1, 0, 0);
    assert_true(t[0] == 1 && t[1] == 0 && t[2] == 0 && t[3] == -1);
    assert_true(uv[0] == 3 && uv[1] == 0);
    assert_true(c[0] == 0.25f && c[1] == 0 && c[2] == 1);
    assert_int_equal(warning_count, 4); /* one for each name */
}

int main(void) { return unit_main(open_folder, remove_folder); }
