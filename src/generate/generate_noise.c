#include "generate/generate_noise.h"
#include "math/mix.h"

/* 32 well-mixed bits of a lattice point. */
static uint32_t noise_hash(uint32_t seed, uint32_t x, uint32_t y, uint32_t z) {
    uint32_t h = seed ^ x * 0x8da6b343u ^ y * 0xd8163841u ^ z * 0xcb1ab31fu;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return h ^ h >> 16;
}

static int32_t floor_int(double x) {
    int32_t i = (int32_t)x;
    return i - (x < (double)i);
}

/* The twelve edges of a cube; four are repeated to make sixteen. */
static const double edges_3d[16][3] = {
    {1, 1, 0}, {-1, 1, 0}, {1, -1, 0}, {-1, -1, 0}, {1, 0, 1}, {-1, 0, 1}, {1, 0, -1}, {-1, 0, -1},
    {0, 1, 1}, {0, -1, 1}, {0, 1, -1}, {0, -1, -1}, {1, 1, 0}, {-1, 1, 0}, {0, -1, 1}, {0, -1, -1},
};

/* Eight directions of length sqrt(2); each is repeated to make sixteen. */
#define ROOT_2 1.4142135623730951
static const double edges_2d[16][3] = {
    {1, 1}, {-1, 1}, {1, -1}, {-1, -1}, {ROOT_2, 0}, {-ROOT_2, 0}, {0, ROOT_2}, {0, -ROOT_2},
    {1, 1}, {-1, 1}, {1, -1}, {-1, -1}, {ROOT_2, 0}, {-ROOT_2, 0}, {0, ROOT_2}, {0, -ROOT_2},
};

/* The value of a lattice cell's corner at the point. Corners are interpolated along one axis after another,
 * which gives the value of an edge, a face and the cell. */
typedef struct noise_part {
    double value;
    double ramp[3];  /* the interpolated gradients of the corners */
    double slope[3]; /* derivative of the interpolation, along the axes done so far */
} noise_part;

/* The position of the point in its cell. */
typedef struct noise_place {
    uint32_t seed, cell[3];
    double offset[3], fade[3], slope[3];
    int axes;
} noise_place;

/* The number of axes is constant in each caller, so after inlining loops over axes unroll. This is twice as
 * fast. */
#define INLINE static inline __attribute__((always_inline))

INLINE noise_place noise_locate(uint32_t seed, const double *point, int axes) {
    noise_place at = {.seed = seed, .axes = axes};
    for (int a = 0; a < axes; ++a) {
        int32_t i = floor_int(point[a]);
        double t = point[a] - (double)i;
        at.cell[a] = (uint32_t)i, at.offset[a] = t;
        at.fade[a] = t * t * t * (t * (t * 6 - 15) + 10);
        at.slope[a] = 30 * t * t * (t * (t - 2) + 1);
    }
    return at;
}

INLINE noise_part noise_merge(const noise_place *at, int axis, noise_part low, noise_part high) {
    double t = at->fade[axis], step = high.value - low.value;
    noise_part out = {.value = low.value + t * step};
    for (int a = 0; a < at->axes; ++a) out.ramp[a] = low.ramp[a] + t * (high.ramp[a] - low.ramp[a]);
    for (int a = 0; a < axis; ++a) out.slope[a] = low.slope[a] + t * (high.slope[a] - low.slope[a]);
    out.slope[axis] = at->slope[axis] * step;
    return out;
}

INLINE noise_part noise_corner(const noise_place *at, uint32_t x, uint32_t y, uint32_t z) {
    const uint32_t side[3] = {x, y, z};
    uint32_t pick = noise_hash(at->seed, at->cell[0] + x, at->cell[1] + y, at->cell[2] + z) >> 28;
    const double *edge = at->axes == 2 ? edges_2d[pick] : edges_3d[pick];
    noise_part out = {.value = 0};
    for (int a = 0; a < at->axes; ++a) {
        out.ramp[a] = edge[a];
        out.value += edge[a] * (at->offset[a] - (double)side[a]);
    }
    return out;
}

INLINE noise_part noise_edge(const noise_place *at, uint32_t y, uint32_t z) {
    return noise_merge(at, 0, noise_corner(at, 0, y, z), noise_corner(at, 1, y, z));
}

INLINE noise_part noise_face(const noise_place *at, uint32_t z) {
    return noise_merge(at, 1, noise_edge(at, 0, z), noise_edge(at, 1, z));
}

noise_value noise_3d(uint32_t seed, vec3_f64 p) {
    noise_place at = noise_locate(seed, (const double[3]){p.x, p.y, p.z}, 3);
    noise_part n = noise_merge(&at, 2, noise_face(&at, 0), noise_face(&at, 1));
    return (noise_value){n.value, {n.ramp[0] + n.slope[0], n.ramp[1] + n.slope[1], n.ramp[2] + n.slope[2]}};
}

noise_value noise_2d(uint32_t seed, double x, double y) {
    noise_place at = noise_locate(seed, (const double[2]){x, y}, 2);
    noise_part n = noise_face(&at, 0);
    return (noise_value){n.value, {n.ramp[0] + n.slope[0], n.ramp[1] + n.slope[1], 0}};
}

/* Maps to the next octave: a scale by 2, a rotation with rational entries, and a translation that moves the
 * origin off the lattice. */
static vec3_f64 octave_point(vec3_f64 p) {
    const double s = 2.0 / 3;
    return (vec3_f64){s * (2 * p.x - p.y + 2 * p.z) + 0.37, s * (2 * p.x + 2 * p.y - p.z) + 0.71,
                      s * (2 * p.y + 2 * p.z - p.x) + 0.13};
}

/* Transforms gradients back, by the transpose of that map. */
static vec3_f64 octave_gradient(vec3_f64 g) {
    const double s = 2.0 / 3;
    return (vec3_f64){s * (2 * g.x + 2 * g.y - g.z), s * (2 * g.y - g.x + 2 * g.z),
                      s * (2 * g.x - g.y + 2 * g.z)};
}

noise_value noise_fbm(uint32_t seed, vec3_f64 p, unsigned octaves, double gain) {
    vec3_f64 points[NOISE_MAX_OCTAVES];
    for (unsigned k = 0; k < octaves; ++k, p = octave_point(p)) points[k] = p;
    noise_value sum = {0};
    for (unsigned k = octaves; k-- > 0;) {
        noise_value here = noise_3d(seed + k, points[k]);
        here.value += gain * sum.value;
        here.gradient = madd_f64(here.gradient, gain, octave_gradient(sum.gradient));
        sum = here;
    }
    return sum;
}

/* The lattice of each octave is rotated by the angle of the 3-4-5 triangle, relative to the previous
 * octave. */
double noise_eroded(uint32_t seed, double x, double y, unsigned octaves, double gain) {
    double sum = 0, amplitude = 1, steep_x = 0, steep_y = 0;
    for (unsigned k = 0; k < octaves; ++k, amplitude *= gain) {
        noise_value n = noise_2d(seed + k, x, y);
        sum += amplitude * n.value / (1 + 0.7 * (steep_x * steep_x + steep_y * steep_y));
        steep_x += n.gradient.x, steep_y += n.gradient.y;
        double turned = 1.6 * x - 1.2 * y + 0.37;
        y = 1.2 * x + 1.6 * y + 0.71, x = turned;
        turned = 0.8 * steep_x - 0.6 * steep_y;
        steep_y = 0.6 * steep_x + 0.8 * steep_y, steep_x = turned;
    }
    return sum;
}

unsigned noise_octaves(double frequency, double shortest) {
    unsigned octaves = 1;
    while (octaves < NOISE_MAX_OCTAVES && 1 > 2 * frequency * shortest) {
        frequency *= 2;
        ++octaves;
    }
    return octaves;
}

noise_random noise_random_from(uint64_t seed, uint64_t stream) {
    return (noise_random){
        mix_bits(mix_bits(seed + 0x9e3779b97f4a7c15u) ^ (stream + 1) * 0xd1342543de82ef95u)};
}

double random_unit(noise_random *random) {
    random->state += 0x9e3779b97f4a7c15u;
    return (double)(mix_bits(random->state) >> 11) * 0x1p-53;
}

double random_between(noise_random *random, double low, double high) {
    return low + (high - low) * random_unit(random);
}

/* A uniform point of the unit ball, or of its disc in the plane y = 0, with a squared length above `least`.
 * Uses rejection sampling, without sine or cosine. */
static vec3_f64 random_inside(noise_random *random, bool flat, double least) {
    for (;;) {
        vec3_f64 p = {0};
        p.x = random_between(random, -1, 1);
        if (!flat) p.y = random_between(random, -1, 1);
        p.z = random_between(random, -1, 1);
        const double square = dot_f64(p, p);
        if (square <= 1 && square > least) return p;
    }
}

static vec3_f64 unit(vec3_f64 p) { return scale_f64(1 / sqrt(dot_f64(p, p)), p); }

vec3_f64 random_direction(noise_random *random) { return unit(random_inside(random, false, 1e-4)); }
vec3_f64 random_turn(noise_random *random) { return unit(random_inside(random, true, 1e-4)); }
vec3_f64 random_in_ball(noise_random *random) { return random_inside(random, false, -1); }
