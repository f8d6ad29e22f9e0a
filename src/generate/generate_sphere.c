/* A displaced sphere: a subdivided icosahedron, displaced by noise.
 *
 * The twenty faces are paired into ten diamonds, each a grid of n × n cells of two triangles. Corners of a
 * diamond are A B C D, (i,j) = (0,0) (n,0) (0,n) (n,n), and the fold between its two faces runs from B to C.
 * Diamonds 2k touch the north pole (A), diamonds 2k+1 the south pole (D), k = 0..4 going east. A diamond owns
 * its vertices with i >= 1 and j < n. Together with the two poles, each vertex has one owner: 10 n² + 2
 * vertices. */
#include "generate/generate.h"

#define DIAMONDS 10u

typedef struct sphere_job {
    uint32_t n, seed;
    unsigned octaves;
    vec3_f64 corners[DIAMONDS][4];
    generate_mesh mesh;
} sphere_job;

/* The index of vertex (i,j) of a diamond; another diamond may own it. */
static uint32_t vertex_index(uint32_t n, uint32_t diamond, uint32_t i, uint32_t j) {
    uint32_t north = !(diamond & 1), next = (diamond + 2) % DIAMONDS;
    if (north && i == 0) {
        if (j == 0) return DIAMONDS * n * n;
        diamond = next, i = j, j = 0; /* A–C is A–B of the next northern diamond */
    } else if (north && j == n) {
        diamond = diamond + 1, j = 0; /* C–D is A–B of the southern diamond below */
    } else if (!north && j == n) {
        if (i == n) return DIAMONDS * n * n + 1;
        diamond = next, j = i, i = n; /* C–D is B–D of the next southern diamond */
    } else if (!north && i == 0) {
        diamond = (diamond + 1) % DIAMONDS, i = n; /* A–C is B–D of the northern diamond to the east */
    }
    return (diamond * n + i - 1) * n + j;
}

/* The icosahedron with a vertex at each pole of y: two rings of five vertices at heights ±1/sqrt(5), the
 * lower one rotated by 36 degrees. Positions come from the closed forms of cos 36° and cos 72°. */
static void make_corners(sphere_job *job) {
    double root = sqrt(5.0), c36 = (1 + root) / 4, c72 = (root - 1) / 4;
    double s36 = sqrt((5 - root) / 8), s72 = sqrt((5 + root) / 8), height = 1 / root, radius = 2 / root;
    const double turn[10][2] = {{1, 0},  {c36, s36},   {c72, s72},   {-c72, s72}, {-c36, s36},
                                {-1, 0}, {-c36, -s36}, {-c72, -s72}, {c72, -s72}, {c36, -s36}};
    vec3_f64 upper[6], lower[6];
    for (int k = 0; k < 6; ++k) {
        const double *u = turn[2 * k % 10], *l = turn[(2 * k + 1) % 10];
        upper[k] = (vec3_f64){radius * u[0], height, -radius * u[1]};
        lower[k] = (vec3_f64){radius * l[0], -height, -radius * l[1]};
    }
    for (int k = 0; k < 5; ++k) {
        vec3_f64 *north = job->corners[2 * k], *south = job->corners[2 * k + 1];
        north[0] = (vec3_f64){0, 1, 0}, north[1] = upper[k], north[2] = upper[k + 1], north[3] = lower[k];
        south[0] = upper[k + 1], south[1] = lower[k], south[2] = lower[k + 1],
        south[3] = (vec3_f64){0, -1, 0};
    }
}

/* Adjusts barycentric weights so that triangles on the sphere have similar areas: the largest has 1.2 times
 * the area of the smallest, instead of 2.0. */
static double spread(double t) { return t * (1 + 0.275 * (1 - t * t)); }

static vec3_f64 sphere_point(const sphere_job *job, uint32_t diamond, uint32_t i, uint32_t j) {
    const vec3_f64 *c = job->corners[diamond];
    double n = job->n, b, d;
    vec3_f64 apex;
    if (i + j <= job->n) {
        apex = scale_f64(spread((n - i - j) / n), c[0]);
        b = i / n, d = j / n;
    } else {
        apex = scale_f64(spread((i + (double)j - n) / n), c[3]);
        b = (n - j) / n, d = (n - i) / n;
    }
    return normalize_f64(madd_f64(madd_f64(apex, spread(b), c[1]), spread(d), c[2]));
}

/* Lambert's azimuthal equal-area projection from the top: bijective without a seam, except for the lowest
 * point, which maps to the border of the disc. */
static void store_uv(float *uv, vec3_f64 u) {
    double s = u.y > -1 ? 0.25 * sqrt(2 / (1 + u.y)) : 0;
    uv[0] = (float)(0.5 + s * u.x);
    uv[1] = (float)(u.y > -1 ? 0.5 - s * u.z : 0);
}

/* The surface is |p| = r(p/|p|); its normal is the gradient of |p| - r: r u minus the tangential component of
 * r's gradient. */
static void make_vertex(const sphere_job *job, uint32_t index, vec3_f64 u) {
    const double frequency = 1.6, base = 0.9, amplitude = 0.16;
    noise_value h = noise_fbm(job->seed, scale_f64(frequency, u), job->octaves, 0.44);
    double r = base + amplitude * h.value;
    vec3_f64 g = scale_f64(amplitude * frequency, h.gradient);
    vec3_f64 normal = sub_f64(scale_f64(r + dot_f64(g, u), u), g);
    store_f32(job->mesh.positions + (size_t)index * 3, narrow(scale_f64(r, u)));
    store_f32(job->mesh.normals + (size_t)index * 3, narrow(normalize_f64(normal)));
    store_uv(job->mesh.uvs + (size_t)index * 2, u);
}

static void make_row(void *user, size_t begin, size_t end) {
    const sphere_job *job = user;
    uint32_t n = job->n;
    for (size_t row = begin; row < end; ++row) {
        uint32_t d = (uint32_t)(row / n), i = (uint32_t)(row % n);
        uint32_t *triangle = job->mesh.indices + row * n * 6;
        for (uint32_t j = 0; j < n; ++j, triangle += 6) {
            make_vertex(job, (uint32_t)(row * n + j), sphere_point(job, d, i + 1, j));
            triangle[0] = vertex_index(n, d, i, j);
            triangle[1] = triangle[3] = vertex_index(n, d, i + 1, j);
            triangle[2] = triangle[5] = vertex_index(n, d, i, j + 1);
            triangle[4] = vertex_index(n, d, i + 1, j + 1);
        }
    }
}

fathom_status generate_sphere(fathom_scene *scene, fathom_id group, const fathom_generate_options *options) {
    uint32_t n = generate_nearest_square(options->triangles, 2 * DIAMONDS), faces = DIAMONDS * n * n;
    sphere_job job = {.n = n, .seed = (uint32_t)noise_random_from(options->seed, 0).state};
    /* An edge of the icosahedron is about 1.1 long; the shortest wave spans at least four edges of the
     * mesh. */
    job.octaves = noise_octaves(1.6, 4 * 1.1 / n);
    fathom_status status =
        generate_allocate(scene, faces + 2, 2 * faces, GENERATE_NORMALS | GENERATE_UVS, &job.mesh);
    if (status != FATHOM_OK) return status;
    make_corners(&job);
    make_vertex(&job, faces, (vec3_f64){0, 1, 0});
    make_vertex(&job, faces + 1, (vec3_f64){0, -1, 0});
    generate_rows(scene, (size_t)DIAMONDS * n, n, make_row, &job);
    return generate_finish(scene, group, &job.mesh, options->material);
}
