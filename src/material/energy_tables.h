/* Tables of albedos over alphas, indices and cosines: the coordinates of their rows. A table is computed
 * on first use and kept. */
#pragma once

#include "math/limit.h"

#include <math.h>
#include <pthread.h>
#include <stdbool.h>

/* Alphas, and cosines by the nodes of curves, are at (j / steps)^4. */
static inline float energy_fourth(int j, int steps) {
    const float x = (float)j / (float)steps;
    return x * x * (x * x);
}
static inline float energy_cosine(int node, int steps) { return most(energy_fourth(node, steps), 1e-6f); }

static inline float energy_sine(float cosine) { return sqrtf((1 - cosine) * (1 + cosine)); }

/* Indices are where (n - 1) / (n + 1) is (k / steps)^2. */
static inline float energy_index(int k, int steps) {
    const float x = (float)k / (float)steps, ratio = most(x * x, 1e-4f);
    return ratio < 0.999f ? (1 + ratio) / (1 - ratio) : 2e3f;
}

/* The row at or below x, which is in [0, steps], but not the last; part: the fraction of the way to the next
 * one. */
static inline int energy_row(float x, int steps, float *part) {
    const int j = x < (float)(steps - 1) ? (int)x : steps - 1;
    *part = x - (float)j;
    return j;
}
static inline int energy_alpha_row(float alpha, int steps, float *part) {
    return energy_row(sqrtf(sqrtf(least(alpha, 1))) * (float)steps, steps, part);
}
static inline int energy_index_row(float eta, int steps, float *part) {
    const float dense = most(eta, 1 / eta);
    return energy_row(sqrtf((dense - 1) / (dense + 1)) * (float)steps, steps, part);
}

/* Returns the table. On first use, fill() computes it from its rows, and other threads wait. */
static inline void *energy_table_once(bool *made, pthread_mutex_t *lock,
                                      void (*fill)(const int *rows, void *table), const int *rows,
                                      void *table) {
    if (__atomic_load_n(made, __ATOMIC_ACQUIRE)) return table;
    pthread_mutex_lock(lock);
    if (!*made) {
        fill(rows, table);
        __atomic_store_n(made, true, __ATOMIC_RELEASE);
    }
    pthread_mutex_unlock(lock);
    return table;
}
