/* Tangents made from texture coordinates, by closed form. */
#include "surface/tangents.h"
#include "unit_scene.h"

UNIT_OWNS(tangents, surface_tangents, surface_tangents_free)

static const float even[3] = {1 / 3.f, 1 / 3.f, 1 / 3.f};

static surface_tangents *make(const fathom_mesh *mesh, unsigned set) {
    surface_tangents *t;
    assert_ok(context, surface_tangents_make(context, mesh, set, &t));
    return own_tangents(t);
}

static void expect_along(const surface_tangents *t, const fathom_mesh *mesh, uint32_t triangle,
                         const float weight[3], double x, double y, double z, double tolerance) {
    vec3_f32 at;
    assert_true(surface_tangents_at(t, mesh, triangle, weight, &at));
    const double length = sqrt((double)dot_f32(at, at));
    assert_near((double)at.x / length, x, tolerance);
    assert_near((double)at.y / length, y, tolerance);
    assert_near((double)at.z / length, z, tolerance);
}

/* The lengths of rows that the scene would fill in. */
static void set_strides(fathom_mesh *m) {
    m->position_stride = m->normal_stride = 3 * sizeof(float);
    m->uv_stride = m->uv_1_stride = 2 * sizeof(float);
}

/* A square of four triangles around its middle, in z = 0. */
static const float square[15] = {0, 0, 0, -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
static const float up[15] = {0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 2};
static const uint32_t fan[12] = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1};

static fathom_mesh flat(const float *uvs) {
    fathom_mesh m = default_mesh();
    m.positions = square, m.normals = up, m.uvs = uvs;
    m.vertex_count = m.normal_count = m.uv_count = 5;
    m.indices = fan, m.triangle_count = 4;
    set_strides(&m);
    return m;
}

/* Rounding: a few operations on numbers of size 1. */
static const double rounding = 16 * 0x1p-24;

UNIT_TEST(an_even_image_has_one_tangent) {
    /* The image is turned by `turn`, scaled, and mirrored in half of the cases. */
    for (int i = 0; i < 14; ++i) {
        const double turn = i / 2, side = i % 2 ? -1 : 1;
        float uvs[10];
        for (int k = 0; k < 5; ++k) {
            const double x = (double)square[3 * k], y = (double)square[3 * k + 1];
            uvs[2 * k] = (float)(3 * (x * cos(turn) + y * sin(turn)) + 0.5);
            uvs[2 * k + 1] = (float)(side * 0.2 * (y * cos(turn) - x * sin(turn)));
        }
        const fathom_mesh mesh = flat(uvs);
        surface_tangents *t = make(&mesh, 0);
        for (uint32_t k = 0; k < 4; ++k)
            expect_along(t, &mesh, k, even, cos(turn), sin(turn), 0, 64 * rounding);
    }
}

/* Where u runs to the right on one half and to the left on the other, each half has its own tangents, at
 * shared vertices, too. */
UNIT_TEST(mirrored_halves_keep_apart) {
    float uvs[10];
    for (int k = 0; k < 5; ++k)
        uvs[2 * k] = fabsf(square[3 * k] + square[3 * k + 1]), uvs[2 * k + 1] = square[3 * k];
    const fathom_mesh mesh = flat(uvs);
    surface_tangents *t = make(&mesh, 0);
    /* u grows by x + y on triangles 1 and 2 as halves of the square above the diagonal from vertex 4 to 2.
     * With v = x, the direction of u at constant v is along y. */
    const float at_middle[3] = {1, 0, 0};
    for (uint32_t k = 0; k < 4; ++k) {
        const double way = k == 1 || k == 2 ? 1 : -1;
        expect_along(t, &mesh, k, even, 0, way, 0, rounding);
        expect_along(t, &mesh, k, at_middle, 0, way, 0, rounding);
    }
}

/* Two islands of the image, turned against each other, that meet at vertices of the mesh. */
UNIT_TEST(islands_keep_apart) {
    float uvs[20];
    uint32_t at[12];
    for (int k = 0; k < 5; ++k) {
        uvs[2 * k] = square[3 * k], uvs[2 * k + 1] = square[3 * k + 1];
        uvs[10 + 2 * k] = square[3 * k + 1], uvs[11 + 2 * k] = -square[3 * k];
    }
    for (uint32_t k = 0; k < 12; ++k) at[k] = fan[k] + (k < 6 ? 0 : 5);
    fathom_mesh mesh = flat(uvs);
    mesh.uv_indices = at, mesh.uv_count = 10;
    surface_tangents *t = make(&mesh, 0);
    const float at_middle[3] = {1, 0, 0};
    for (uint32_t k = 0; k < 4; ++k) expect_along(t, &mesh, k, at_middle, k < 2, k >= 2, 0, rounding);
}

/* A vertex's tangent weighs triangles by their angles there, however large they are. */
UNIT_TEST(angles_weigh) {
    /* Around vertex 0, with the normal z: a triangle of 90 degrees with u along x, and a much larger one of
     * 45 degrees. */
    static const float points[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, -50, 50, 0, -1, -1, 0};
    static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
    static const float uvs[10] = {0, 0, 1, 0, 0, 1, -50, -30, 0, 0};
    fathom_mesh mesh = flat(uvs);
    mesh.positions = points, mesh.indices = corners, mesh.triangle_count = 2;
    surface_tangents *t = make(&mesh, 0);
    /* On triangle 1, p = u U + v V. Vertex 2 says that V = (0, 1), and vertex 3 that -50 U - 30 V = (-50,
     * 50). So U = (1, -1.6). */
    const double length = hypot(1, 1.6), x = M_PI / 2 + M_PI / 4 / length, y = M_PI / 4 * -1.6 / length;
    expect_along(t, &mesh, 0, (float[3]){1, 0, 0}, x / hypot(x, y), y / hypot(x, y), 0, 4 * rounding);
    expect_along(t, &mesh, 1, (float[3]){1, 0, 0}, x / hypot(x, y), y / hypot(x, y), 0, 4 * rounding);
}

enum { AROUND = 48, DOWN = 24, CORNERS = (AROUND + 1) * (DOWN + 1) };

/* A sphere of latitudes and longitudes: tangents run along the latitudes. By indices of its own for each of
 * positions, normals and uvs it is the same, with the seam at one position. */
UNIT_TEST(a_globe_has_tangents_along_its_latitudes) {
    static float points[3 * CORNERS], uvs[2 * CORNERS];
    static uint32_t at[6 * AROUND * DOWN], seamless[6 * AROUND * DOWN];
    uint32_t n = 0;
    for (uint32_t j = 0; j <= DOWN; ++j) {
        for (uint32_t i = 0; i <= AROUND; ++i) {
            const uint32_t k = j * (AROUND + 1) + i;
            const double theta = M_PI * (0.1 + 0.8 * j / DOWN), phi = 2 * M_PI * (i % AROUND) / AROUND;
            points[3 * k] = (float)(sin(theta) * cos(phi));
            points[3 * k + 1] = (float)(sin(theta) * sin(phi));
            points[3 * k + 2] = (float)cos(theta);
            uvs[2 * k] = (float)i / AROUND, uvs[2 * k + 1] = (float)j / DOWN;
            if (i == AROUND || j == DOWN) continue;
            const uint32_t quad[6] = {k, k + AROUND + 1, k + AROUND + 2, k, k + AROUND + 2, k + 1};
            for (int c = 0; c < 6; ++c) {
                at[n] = quad[c];
                seamless[n++] = quad[c] % (AROUND + 1) == AROUND ? quad[c] - AROUND : quad[c];
            }
        }
    }
    fathom_mesh mesh = default_mesh();
    mesh.positions = mesh.normals = points, mesh.uvs = uvs;
    mesh.vertex_count = mesh.normal_count = mesh.uv_count = CORNERS;
    mesh.indices = at, mesh.triangle_count = n / 3;
    set_strides(&mesh);
    for (int own = 0; own < 2; ++own) {
        if (own) mesh.indices = mesh.normal_indices = seamless, mesh.uv_indices = at;
        surface_tangents *t = make(&mesh, 0);
        for (uint32_t triangle = 0; triangle < mesh.triangle_count; ++triangle) {
            for (int c = 0; c < 3; ++c) {
                const uint32_t k = at[3 * triangle + (uint32_t)c], i = k % (AROUND + 1);
                const double phi = 2 * M_PI * i / AROUND;
                float weight[3] = {0};
                weight[c] = 1;
                /* Inside, triangles lie symmetrically about the meridian. On the seam and on the first and
                 * last row only some of them are there, each turned by at most half a step. */
                const bool inside = i > 0 && i < AROUND && k > AROUND && k < CORNERS - AROUND - 1;
                expect_along(t, &mesh, triangle, weight, -sin(phi), cos(phi), 0,
                             inside ? 0.01 : 2 * M_PI / AROUND);
            }
        }
    }
}

UNIT_TEST(what_has_no_direction_has_no_tangent) {
    static const float same[10] = {0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f};
    static const float one[10] = {0, 0, 0, 0, 1, 0, 1, 1, 0, 0}; /* triangle 3 has no area in the image */
    fathom_mesh mesh = flat(same);
    vec3_f32 out;
    surface_tangents *t = make(&mesh, 0);
    for (uint32_t k = 0; k < 4; ++k) assert_false(surface_tangents_at(t, &mesh, k, even, &out));
    mesh = flat(one);
    t = make(&mesh, 0);
    assert_false(surface_tangents_at(t, &mesh, 3, even, &out));
    assert_true(surface_tangents_at(t, &mesh, 1, even, &out));
    /* Without normals, or without the set that is asked for, none are made. */
    assert_null(make(&mesh, 1));
    mesh.normals = NULL, mesh.normal_count = 0;
    assert_null(make(&mesh, 0));
}

/* The second set's own image, which lies across the first. */
UNIT_TEST(each_set_has_its_own) {
    float uvs[10], uvs_1[10];
    for (int k = 0; k < 5; ++k) {
        uvs[2 * k] = square[3 * k], uvs[2 * k + 1] = square[3 * k + 1];
        uvs_1[2 * k] = -square[3 * k + 1], uvs_1[2 * k + 1] = square[3 * k];
    }
    fathom_mesh mesh = flat(uvs);
    mesh.uvs_1 = uvs_1;
    surface_tangents *first = make(&mesh, 0), *second = make(&mesh, 1);
    expect_along(first, &mesh, 2, even, 1, 0, 0, rounding);
    expect_along(second, &mesh, 2, even, 0, -1, 0, rounding);
}

int main(void) { return unit_main_each(open_scene, NULL); }
