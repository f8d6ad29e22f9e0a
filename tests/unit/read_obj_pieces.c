/* OBJ files of several pieces of text, each read by itself: every corner has the numbers that its own quad
 * was written with, whatever was before the piece begins. */
#include "mesh_file.h"

#include "scene/mesh/mesh_array.h"

enum { QUADS = 9000, LOST = 97 };

/* Corner c of a quad, in order around it. */
static const int corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};

static bool has_uvs(int quad) { return quad % 4 & 1; }
static bool has_normals(int quad) { return quad % 4 & 2; }
static bool is_lost(int quad) { return quad % LOST == 5; }

/* The last quad before this one that names a material and a smoothing group. */
static int leader_of(int quad) { return quad / 50 * 50; }
static int group_of(int quad) { return leader_of(quad) % 7 ? leader_of(quad) : 0; }

static size_t write_quad(char *out, size_t room, int quad) {
    size_t used = 0;
#define PUT(...) used += (size_t)snprintf(out + used, room - used, __VA_ARGS__)
    for (int c = 0; c < 4; ++c) {
        const char *y = is_lost(quad) && c == 2 ? "nan" : corners[c][1] ? "1" : "0";
        PUT("v %d %s 0 %d %d %d\n", quad + corners[c][0], y, c == 0, c == 1, c == 2);
        if (has_uvs(quad)) PUT("vt %d %d\n", quad, c);
        if (has_normals(quad)) PUT("vn %d %d 1\n", quad, c);
    }
    if (quad == leader_of(quad)) PUT("usemtl m%d\ns %d\n", quad % 3, group_of(quad));
    PUT("f");
    for (int c = 0; c < 4; ++c) {
        PUT(" %d", c - 4);
        if (has_uvs(quad)) PUT("/%d", c - 4);
        if (has_normals(quad)) PUT("%s%d", has_uvs(quad) ? "/" : "//", c - 4);
    }
    PUT("\n");
    return used;
}

static const float *row_of(const fathom_mesh *m, mesh_kind kind, size_t corner) {
    const mesh_array a = mesh_array_of(m, kind);
    return mesh_row(a.values, a.stride, (a.indices ? a.indices : m->indices)[corner]);
}

static void check_corner(const fathom_mesh *m, size_t corner, int quad) {
    const vec3_f64 p = mesh_point(m, m->indices[corner]);
    int c = 0;
    while (c < 4 && (p.x != quad + corners[c][0] || p.y != corners[c][1])) ++c;
    if (c == 4) fail_msg("(%g, %g) is no corner of quad %d", p.x, p.y, quad);
    const float *color = row_of(m, MESH_COLORS, corner);
    assert_true(color[0] == (c == 0) && color[1] == (c == 1) && color[2] == (c == 2));
    assert_true(!m->uvs == !has_uvs(quad));
    assert_true(!m->normals == !(has_normals(quad) || group_of(quad)));
    if (m->uvs) {
        const float *uv = row_of(m, MESH_UVS, corner);
        if (uv[0] != (float)quad || uv[1] != (float)c) fail_msg("uv of quad %d", quad);
    }
    if (has_normals(quad)) {
        const float *n = row_of(m, MESH_NORMALS, corner);
        if (n[0] != (float)quad || n[1] != (float)c || n[2] != 1) fail_msg("normal of quad %d", quad);
    } else if (m->normals) { /* of a smoothing group; all quads face the same way */
        const float *n = row_of(m, MESH_NORMALS, corner);
        if (n[0] != 0 || n[1] != 0 || n[2] != 1) fail_msg("smooth normal of quad %d", quad);
    }
}

UNIT_TEST(pieces_count_on_from_those_before) {
    const size_t room = (size_t)QUADS * 256;
    char *text = unit_memory(room);
    size_t used = 0;
    unsigned char found[QUADS] = {0};
    used += (size_t)sprintf(text, "mtllib a.mtl\n");
    for (int quad = 0; quad < QUADS; ++quad) used += write_quad(text + used, room - used, quad);
    assert_true(used > 3 * ((size_t)1 << 18)); /* pieces have 2^18 bytes */
    put_text("a.mtl", "newmtl m0\nnewmtl m1\nKd 0 0 0\nnewmtl m2\nKd 0.5 0 0\n");
    const read_mesh_options options = {.material = FATHOM_NONE};
    fathom_scene *scene = mesh_read(read_obj, mesh_write("a.obj", text, used), options);
    for (size_t i = 0; i < scene->meshes.count; ++i) {
        const fathom_mesh *m = &scene->meshes.items[i];
        const char *material = scene->materials.items[m->material].name;
        for (size_t t = 0; t < m->triangle_count; ++t) {
            double least = INFINITY;
            for (size_t k = 0; k < 3; ++k) least = fmin(least, mesh_point(m, m->indices[3 * t + k]).x);
            ++found[(int)least];
            assert_int_equal(material[1] - '0', leader_of((int)least) % 3);
            for (size_t k = 0; k < 3; ++k) check_corner(m, 3 * t + k, (int)least);
        }
    }
    for (int quad = 0; quad < QUADS; ++quad) {
        if (found[quad] != (is_lost(quad) ? 0 : 2)) fail_msg("quad %d has %u triangles", quad, found[quad]);
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
