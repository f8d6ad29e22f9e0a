/* The least that a path tracer computes at a vertex next to the tracer's calls: vertices [MILLIONS].
 *
 * A wave of 1024 hits on 70,000 triangles, in the order of scattered rays: load the corners, make the point
 * and the normal, take a direction by the cosine and a point on one light, write the shadow ray and the next
 * ray. All in float, and without roulette, sums, materials, offsets that are bounds, or a careful sampler: no
 * renderer is as fast. Two designs. "passes": each step goes over the whole wave, and its results wait in
 * memory for the next one. "fused": a block of sixteen takes all steps while it is in the first-level cache.
 * Prints nanoseconds of processor time a vertex, the least of 15 rounds. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { LANES = 16, BLOCKS = 64, TRIANGLES = 70000, ROUNDS = 15 };

typedef float row[LANES];
typedef struct rays {
    row o[3], d[3], t_near, t_far;
} rays;
typedef struct queue {
    rays rays;
    uint32_t triangle[LANES], slot[LANES];
    row weight[3];
} queue;
typedef struct vertex {
    row p[3], n[3], u[4], l[3], distance, gain[3], next[3];
} vertex;
typedef struct shadow {
    rays rays;
    row gain[3];
    uint32_t slot[LANES];
} shadow;

static float (*corners)[3];
static uint32_t (*indices)[3];

static uint32_t state = 1;
static uint32_t any(void) {
    state ^= state << 13, state ^= state >> 17;
    return state ^= state << 5;
}
static float uniform(void) { return (float)(any() >> 8) * 0x1p-24f; }

static void locate(const queue *q, vertex *restrict v) {
    row c[3][3];
    for (int i = 0; i < LANES; ++i) {
        for (int k = 0; k < 3; ++k)
            for (int a = 0; a < 3; ++a) c[k][a][i] = corners[indices[q->triangle[i]][k]][a];
    }
    for (int i = 0; i < LANES; ++i) {
        float e[3], f[3], n[3], up = 0, away = 0, square = 0;
        for (int a = 0; a < 3; ++a) e[a] = c[1][a][i] - c[0][a][i], f[a] = c[2][a][i] - c[0][a][i];
        for (int a = 0; a < 3; ++a) n[a] = e[(a + 1) % 3] * f[(a + 2) % 3] - e[(a + 2) % 3] * f[(a + 1) % 3];
        for (int a = 0; a < 3; ++a) {
            square += n[a] * n[a], up += n[a] * q->rays.d[a][i];
            away += n[a] * (c[0][a][i] - q->rays.o[a][i]);
        }
        const float unit = (up < 0 ? 1 : -1) / sqrtf(square), t = away / up;
        for (int a = 0; a < 3; ++a) {
            v->n[a][i] = n[a] * unit;
            v->p[a][i] = q->rays.o[a][i] + t * q->rays.d[a][i];
        }
    }
}

static void draw(const queue *q, uint32_t depth, vertex *restrict v) {
    for (int k = 0; k < 4; ++k) {
        for (int i = 0; i < LANES; ++i) {
            uint32_t h = q->slot[i] * 0x9e3779b9u + depth * 4 + (uint32_t)k;
            h = (h ^ h >> 16) * 0x7feb352du, h = (h ^ h >> 15) * 0x846ca68bu;
            v->u[k][i] = (float)(int32_t)((h ^ h >> 16) >> 8) * 0x1p-24f;
        }
    }
}

static void light(const queue *q, vertex *restrict v) {
    for (int i = 0; i < LANES; ++i) {
        const float at[3] = {v->u[0][i] - 0.5f, 0.99f, v->u[1][i] - 0.5f};
        float to[3], square = 0, cosine = 0;
        for (int a = 0; a < 3; ++a) to[a] = at[a] - v->p[a][i], square += to[a] * to[a];
        const float length = sqrtf(square), inverse = 1 / length;
        for (int a = 0; a < 3; ++a) to[a] *= inverse, cosine += to[a] * v->n[a][i];
        const float other = to[1], g = cosine > 0 && other > 0 ? cosine * other * inverse * inverse : 0;
        for (int a = 0; a < 3; ++a) v->l[a][i] = to[a], v->gain[a][i] = q->weight[a][i] * g;
        v->distance[i] = length * 0.9999f;
    }
}

/* A disc to a hemisphere; sine and cosine by short series, enough for a look. */
static void scatter(vertex *restrict v) {
    for (int i = 0; i < LANES; ++i) {
        const float r = sqrtf(v->u[2][i]), z = sqrtf(1 - v->u[2][i]), x = 3.1415927f * (v->u[3][i] - 0.5f);
        const float q = x * x, s = x * (1 - q * (1 / 6.0f - q * (1 / 120.0f - q * (1 / 5040.0f))));
        const float half = s * s < 1 ? s * s : 1, cosine = 1 - 2 * half, sine = 2 * s * sqrtf(1 - half);
        const float nx = v->n[0][i], ny = v->n[1][i], nz = v->n[2][i], sign = copysignf(1, nz);
        const float a = -1 / (sign + nz), b = nx * ny * a, tx = r * cosine, ty = r * sine;
        v->next[0][i] = (1 + sign * nx * nx * a) * tx + b * ty + nx * z;
        v->next[1][i] = sign * b * tx + (sign + ny * ny * a) * ty + ny * z;
        v->next[2][i] = -sign * nx * tx - ny * ty + nz * z;
    }
}

static void send(const queue *q, const vertex *v, shadow *restrict s, queue *restrict next) {
    for (int a = 0; a < 3; ++a) {
        for (int i = 0; i < LANES; ++i) {
            const float start = v->p[a][i] + 1e-4f * v->n[a][i];
            s->rays.o[a][i] = next->rays.o[a][i] = start;
            s->rays.d[a][i] = v->l[a][i], next->rays.d[a][i] = v->next[a][i];
            s->gain[a][i] = v->gain[a][i], next->weight[a][i] = q->weight[a][i] * 0.73f;
        }
    }
    for (int i = 0; i < LANES; ++i) {
        s->rays.t_near[i] = next->rays.t_near[i] = 0;
        s->rays.t_far[i] = v->distance[i], next->rays.t_far[i] = INFINITY;
        s->slot[i] = next->slot[i] = q->slot[i];
    }
}

static void passes(const queue *q, vertex *v, shadow *s, queue *next, uint32_t depth) {
    for (int b = 0; b < BLOCKS; ++b) locate(&q[b], &v[b]);
    for (int b = 0; b < BLOCKS; ++b) draw(&q[b], depth, &v[b]);
    for (int b = 0; b < BLOCKS; ++b) light(&q[b], &v[b]);
    for (int b = 0; b < BLOCKS; ++b) scatter(&v[b]);
    for (int b = 0; b < BLOCKS; ++b) send(&q[b], &v[b], &s[b], &next[b]);
}

static void fused(const queue *q, vertex *v, shadow *s, queue *next, uint32_t depth) {
    for (int b = 0; b < BLOCKS; ++b) {
        locate(&q[b], v), draw(&q[b], depth, v), light(&q[b], v), scatter(v);
        send(&q[b], v, &s[b], &next[b]);
    }
}

static void *room(size_t bytes) {
    void *p = aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (!p) exit(4);
    memset(p, 0, bytes);
    return p;
}

static void fill(queue *q) {
    for (int i = 0; i < BLOCKS * LANES; ++i) {
        queue *b = &q[i / LANES];
        const int k = i % LANES;
        for (int a = 0; a < 3; ++a) {
            b->rays.o[a][k] = uniform() - 0.5f, b->rays.d[a][k] = uniform() - 0.5f;
            b->weight[a][k] = 0.5f;
        }
        b->triangle[k] = any() % TRIANGLES, b->slot[k] = (uint32_t)i;
    }
}

static double seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int main(int argc, char **argv) {
    const double millions = argc > 1 ? atof(argv[1]) : 2;
    const uint32_t waves = (uint32_t)(millions * 1e6 / (BLOCKS * LANES)) + 1;
    queue *q = room(BLOCKS * sizeof *q), *next = room(BLOCKS * sizeof *next);
    vertex *v = room(BLOCKS * sizeof *v);
    shadow *s = room(BLOCKS * sizeof *s);
    corners = room(TRIANGLES / 2 * sizeof *corners), indices = room(TRIANGLES * sizeof *indices);
    for (int i = 0; i < TRIANGLES / 2; ++i)
        for (int a = 0; a < 3; ++a) corners[i][a] = uniform() - 0.5f;
    for (int i = 0; i < TRIANGLES; ++i)
        for (int k = 0; k < 3; ++k) indices[i][k] = (uint32_t)(i / 2 + k * 7) % (TRIANGLES / 2);
    fill(q);
    double least[2] = {INFINITY, INFINITY}, check = 0;
    for (int round = 0; round < 2 * ROUNDS; ++round) {
        const double began = seconds();
        for (uint32_t w = 0; w < waves; ++w) (round % 2 ? fused : passes)(q, v, s, next, w);
        const double took = (seconds() - began) / waves / (BLOCKS * LANES) * 1e9;
        if (took < least[round % 2]) least[round % 2] = took;
        check += (double)next[round].rays.d[0][0];
    }
    printf("passes %.1f ns a vertex, fused %.1f ns (sum %g)\n", least[0], least[1], check);
    return 0;
}
