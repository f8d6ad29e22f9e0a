/* A fractal height field: eroded noise, higher and with a larger amplitude where a low-frequency noise is
 * high, and warped by a third noise. */
#include "generate/generate.h"

typedef struct terrain_job {
    terrain t;
    unsigned octaves;
    generate_mesh mesh;
} terrain_job;

static double height(const terrain_job *job, double x, double z) {
    const terrain *t = &job->t;
    x *= t->frequency, z *= t->frequency;
    noise_value warp = noise_2d(t->seed ^ 0x51ed27u, 0.8 * x, 0.8 * z);
    noise_value slow = noise_2d(t->seed ^ 0xa02bdbu, 0.45 * x + 0.3, 0.45 * z + 0.6);
    x += 0.15 * warp.gradient.y, z -= 0.15 * warp.gradient.x;
    double eroded = noise_eroded(t->seed, x, z, job->octaves, t->roughness);
    double h = 0.35 * slow.value + (0.75 + 0.5 * slow.value) * eroded;
    /* Valleys are wide and flat: all heights are above -1/2.5, and the slope is continuous at 0. */
    return t->relief * (h < 0 ? h / (1 - 2.5 * h) : h);
}

static float *vertex_at(const terrain_job *job, uint32_t row, uint32_t column) {
    return job->mesh.positions + ((size_t)row * (job->t.cells + 1) + column) * 3;
}

static void make_heights(void *user, size_t begin, size_t end) {
    const terrain_job *job = user;
    uint32_t n = job->t.cells;
    for (uint32_t row = (uint32_t)begin; row < end; ++row) {
        float *uv = job->mesh.uvs + (size_t)row * (n + 1) * 2;
        for (uint32_t column = 0; column <= n; ++column) {
            double u = column / (double)n, v = row / (double)n;
            vec3_f64 p = {2 * u - 1, 0, 2 * v - 1};
            p.y = height(job, p.x, p.z);
            store_f32(vertex_at(job, row, column), narrow(p));
            uv[2 * column] = (float)u, uv[2 * column + 1] = (float)(1 - v);
        }
    }
}

/* Two triangles per cell; diagonals alternate, so that the grid has no preferred direction. */
static void make_cells(const terrain_job *job, uint32_t row) {
    uint32_t n = job->t.cells, width = n + 1, *triangle = job->mesh.indices + (size_t)row * n * 6;
    for (uint32_t column = 0; column < n; ++column, triangle += 6) {
        uint32_t a = row * width + column, b = a + width, c = b + 1, d = a + 1;
        uint32_t first = (row + column) & 1 ? b : a;
        triangle[0] = a, triangle[1] = b;
        triangle[2] = first == a ? c : d;
        triangle[3] = first, triangle[4] = c, triangle[5] = d;
    }
}

/* Normals of the heights on the grid, by central differences; one-sided at the rim. */
static void make_normals(void *user, size_t begin, size_t end) {
    const terrain_job *job = user;
    uint32_t n = job->t.cells;
    for (uint32_t row = (uint32_t)begin; row < end; ++row) {
        uint32_t r0 = row ? row - 1 : 0, r1 = row < n ? row + 1 : n;
        float *normal = job->mesh.normals + (size_t)row * (n + 1) * 3;
        for (uint32_t column = 0; column <= n; ++column, normal += 3) {
            uint32_t c0 = column ? column - 1 : 0, c1 = column < n ? column + 1 : n;
            vec3_f64 dx =
                sub_f64(widen(load_f32(vertex_at(job, row, c1))), widen(load_f32(vertex_at(job, row, c0))));
            vec3_f64 dz = sub_f64(widen(load_f32(vertex_at(job, r1, column))),
                                  widen(load_f32(vertex_at(job, r0, column))));
            store_f32(normal, narrow(normalize_f64(cross_f64(dz, dx))));
        }
        if (row < n) make_cells(job, row);
    }
}

fathom_status generate_height_field(fathom_scene *scene, const terrain *t, generate_mesh *out) {
    terrain_job job = {.t = *t};
    uint32_t n = t->cells, vertices = (n + 1) * (n + 1);
    /* The shortest wave spans at least four cells of the grid. */
    job.octaves = noise_octaves(t->frequency, 8.0 / n);
    fathom_status status =
        generate_allocate(scene, vertices, 2 * n * n, GENERATE_NORMALS | GENERATE_UVS, &job.mesh);
    if (status != FATHOM_OK) return status;
    generate_rows(scene, (size_t)n + 1, n, make_heights, &job);
    generate_rows(scene, (size_t)n + 1, n, make_normals, &job);
    *out = job.mesh;
    return FATHOM_OK;
}

double height_field_at(const generate_mesh *field, uint32_t cells, double x, double z) {
    double u = (x + 1) / 2 * cells, v = (z + 1) / 2 * cells;
    uint32_t column = u > 0 ? (uint32_t)u : 0, row = v > 0 ? (uint32_t)v : 0;
    if (column >= cells) column = cells - 1;
    if (row >= cells) row = cells - 1;
    u -= column, v -= row;
    const float *a = field->positions + ((size_t)row * (cells + 1) + column) * 3 + 1;
    const float *b = a + ((size_t)cells + 1) * 3;
    double ha = (double)a[0], hd = (double)a[3], hb = (double)b[0], hc = (double)b[3];
    if ((row + column) & 1) { /* diagonal from b to d */
        return u + v <= 1 ? ha + u * (hd - ha) + v * (hb - ha)
                          : hc + (1 - u) * (hb - hc) + (1 - v) * (hd - hc);
    }
    return u >= v ? ha + u * (hd - ha) + v * (hc - hd) : ha + v * (hb - ha) + u * (hc - hb);
}

fathom_status generate_terrain(fathom_scene *scene, fathom_id group, const fathom_generate_options *options) {
    terrain t = {.seed = (uint32_t)noise_random_from(options->seed, 1).state,
                 .cells = generate_nearest_square(options->triangles, 2),
                 .relief = 0.36,
                 .frequency = 1.8,
                 .roughness = 0.52};
    generate_mesh mesh;
    fathom_status status = generate_height_field(scene, &t, &mesh);
    return status == FATHOM_OK ? generate_finish(scene, group, &mesh, options->material) : status;
}
