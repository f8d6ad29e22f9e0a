/* Sampling to an error: the pixels of a wave get more samples until the estimated error of the wave is small
 * enough.
 *
 * Data flow:
 *
 *     pass: squares of high priority ── batches of 64 squares, a sample of each ──▶ integrator ──▶ sums
 *       ▲                                                                                          │
 *       └───────── error of each square, and of the wave: from the deciding half ──────────────────┘
 *
 * No bias. The samples of a pixel form two halves, A and B, of two groups each (film/squares.h); every group
 * has its own scramble. A wave has two runs. Run 0 decides by the samples of A, and its samples of B go into
 * the image. Run 1 decides by B, and its samples of A go into the image. The pixel is the plain mean of run
 * 0's mean of B and run 1's mean of A. Proof that the expectation of the pixel is the true value: let N be
 * the number of samples of a pixel in run 0. N is a function of the samples of A in the wave, which are
 * independent of all samples of B. So E[mean of B's first N] = Σ P(N = n) E[mean of B's first n]. Each point
 * of a scrambled sequence is uniform, so each of these expectations is the true value for every n, and the
 * probabilities add up to 1. The same holds for run 1, and a mean of two unbiased means is unbiased. The
 * quality of the decisions does not matter, nor how they depend on each other within a wave: priorities,
 * min_spp, the maximum number of samples and the spread (see below) are all functions of the deciding half's
 * samples alone. Rays are also counted of the deciding half alone.
 *
 * Both runs take the same samples where their decisions agree: a run copies what the other run already has.
 * If the other run has already doubled a square twice, the square is sampled again, because intermediate sums
 * are not kept.
 *
 * Limits. (1) Mean alpha, normal and albedo use all samples that were taken, including those of the deciding
 * half. So they are biased: their samples influence their own number. (2) The estimated error of the image
 * assumes that the two halves are independent. The mean of each half is unbiased given the other half. But
 * the two stopping points together depend on both halves, so the covariance of the two means need not be 0 if
 * a single pixel decides for its wave. (3) With a time limit, the clock ends the passes (timed.c). The clock
 * depends on the samples of all pixels, because slow paths take longer. Of n pixels, each contributes about
 * 1/n of this time.
 *
 * Decisions for a wave depend on the samples of its own pixels alone. These are all pixels of its 32 × 32
 * square that lie in the image, whatever the crop. So threads, tiles and crops change no pixel. Each pass
 * doubles the samples of some squares of 4 × 4 pixels. So the Sobol sequence of each group always stops at a
 * power of two, where it is stratified.
 *
 * Priority. Doubling the samples of a square costs as many rays r as the square took so far. It removes about
 * the same fraction of the squared error e² in every square. So the gain per ray is e² / r: the square's
 * priority. An image has the minimum squared error for its rays when all priorities are equal (Lagrange). A
 * square continues while its priority is above the priority of a whole wave that reaches its aim (see
 * Variance) after ADAPTIVE_USUAL_RAYS rays a pixel. If no such square is left and the wave's error is still
 * above the aim, the squares of highest priority continue. Cost is counted in rays, not measured in seconds.
 * Glass and mirrors, where errors are large, take several times the rays of a plain surface.
 *
 * Small bright objects. If every sample of the deciding half missed an object smaller than a pixel, the
 * estimated error is too small and the pixel gets few samples. If one of the image's samples hits the object,
 * the pixel is far too bright; if none does, it is too dark. No mean is biased, but such an image is noisy.
 * Therefore many samples in one square raise the samples of the whole wave: no square has more than
 * ADAPTIVE_SPREAD times the samples of another.
 *
 * Error. e² of a wave is the mean over its pixels, and over R, G and B, of
 *
 *     variance of the pixel's mean / n(I)²,   n(I) = √max(I, 0.01) for I < 1, else I
 *
 * where I is the mean of R, G and B: linear radiance, weighted as in the noise threshold of Cycles
 * (kernel/film/adaptive_sampling.h), after Dammertz, Hanika, Keller and Lensch, "A Hierarchical Automatic
 * Stopping Condition for Monte Carlo Global Illumination" (2010). √I is nearly what a display shows, and
 * d√I = dI / 2√I: a target of 0.01 is 0.005 of full scale, or 1.3 of 255 levels. Cycles has a floor of 1e-8.
 * Below one hundredth of white, that floor would let black pixels decide. Our floor of 0.01 is where the sRGB
 * curve becomes straight.
 *
 * Variance. The two groups of the deciding half have independent means p and q with the same variance v. The
 * mean of all four groups has the variance v / 4, and (p - q)² has the expectation 2v, so (p - q)² / 8 is
 * unbiased. This estimate has one degree of freedom per pixel, and sixteen per square. The reported error of
 * a wave is the error of its image, from all four groups (pixel_sums_error()). The decisions do not know the
 * reported error: they aim at ADAPTIVE_AIM times the target, so that it is seldom above the target. */
#pragma once

#include "integrate/integrator.h"
#include "job/unit.h"

#define ADAPTIVE_MIN_SPP 4
#define ADAPTIVE_AIM 0.8

/* Larger values: easy waves end further below the target than hard ones. Smaller values: all waves end near
 * the target (bench/README.md, Rendering to an error). */
#define ADAPTIVE_USUAL_RAYS 32.0

/* Measured on a field of stars from 0.1 to 2 pixels wide, and on the scene of the README (bench/README.md,
 * Rendering to an error). Without a limit, true errors of the stars are up to 5 times the estimates; with 4,
 * they are below the estimates on average. The other scene needs the same time for the same error. */
#define ADAPTIVE_SPREAD 4u

/* Squares within this factor of the highest priority are doubled together with the best one. Doubling halves
 * the squared error and doubles the rays, so otherwise these squares would have the highest priority one or
 * two passes later. */
#define ADAPTIVE_NEAR_BEST 0.5

/* A wave has enough samples when its error, or the priority of every square, is small enough. */
typedef struct adaptive_goal {
    double error;    /* maximum error of the wave */
    double priority; /* maximum priority of a square: its squared error, summed over its pixels, divided by
                        its rays. Squares with the maximum number of samples may exceed it */
} adaptive_goal;

#define ADAPTIVE_RUNS 2u

/* Run r decides by groups r and r + 2. The image uses groups 1 - r and 3 - r. */
typedef struct adaptive_run {
    double rgb[SAMPLE_GROUPS][3][WAVE_SLOTS]; /* slot: square * 16 + place in the square */
    uint32_t done[WAVE_SQUARES];              /* samples in the error estimate: 0 or a power of two */
    uint32_t taken[WAVE_SQUARES];      /* samples in the sums: more than `done` if a pass was cut short */
    uint64_t rays[2][WAVE_SQUARES];    /* of each half: camera rays, mirrored and refracted rays */
    double square_error[WAVE_SQUARES]; /* sum of the squared errors of its pixels; infinite while unknown */
    double error;                      /* of the wave; infinite below 4 samples a pixel */
    double priority; /* maximum of the squares that may get more samples; infinite below the minimum */
} adaptive_run;

typedef struct adaptive_wave {
    wave_region region; /* clipped to the image, not to the crop */
    sampler sampler;
    const film_kernels *kernels;
    adaptive_run runs[ADAPTIVE_RUNS];
    film_parts parts;
    double (*layers)[WAVE_SLOTS];     /* see adaptive_layers(); NULL if there are no layers */
    matte_list (*mattes)[WAVE_SLOTS]; /* of all samples taken, as are `hits`; NULL if there are no mattes */
    hit_sums *hits;                   /* NULL: no AOV needs them */
    uint32_t seen[WAVE_SQUARES]; /* samples with their first hits in `hits` and `mattes`: the maximum of both
                                    runs */
} adaptive_wave;

/* The part of a wave that the film shows. */
typedef struct adaptive_view {
    pixel_sums sums;                /* hits and mattes are the wave's */
    uint32_t samples[WAVE_SQUARES]; /* samples of a pixel in the image */
} adaptive_view;

/* Release with adaptive_view_destroy(). NULL: out of memory. */
adaptive_view *adaptive_view_create(const render_plan *plan);
void adaptive_view_destroy(adaptive_view *view);

/* When to stop by the clock. */
typedef struct adaptive_limit {
    double deadline;      /* a time of clock_seconds() */
    double batch_seconds; /* duration of the last batch */
} adaptive_limit;

typedef enum adaptive_result {
    ADAPTIVE_PASSED,   /* a pass is done; there may be more to do */
    ADAPTIVE_FINISHED, /* nothing was left to do: the target or the maximum number of samples is reached */
    ADAPTIVE_CUT,      /* the deadline came: all samples taken so far are in the sums */
    ADAPTIVE_STOPPED   /* run() of the integrator returned false: stopped, or out of memory */
} adaptive_result;

bool adaptive_create(const render_plan *plan, adaptive_wave *out);
void adaptive_destroy(adaptive_wave *a);
/* Bytes that a wave allocates in addition to its struct. */
size_t adaptive_bytes(film_parts parts);
static inline size_t adaptive_layer_count(film_parts parts) {
    return (size_t)ADAPTIVE_RUNS * SAMPLE_GROUPS * 3 * film_part_sums(parts);
}
/* The sums of the layers of one group of a run: three channels each. */
static inline double (*adaptive_layers(const adaptive_wave *a, uint32_t run, uint32_t group))[WAVE_SLOTS] {
    return a->layers + (run * SAMPLE_GROUPS + group) * 3 * film_part_sums(a->parts);
}

adaptive_goal adaptive_goal_of(double target);

/* Sets the wave to no samples. (left, top): the corner of the wave's square. */
void adaptive_begin(const render_plan *plan, uint32_t left, uint32_t top, adaptive_wave *a);
/* One pass of a run: takes the first sample of each pixel, or doubles the samples of every square that needs
 * it. limit: NULL without a deadline. */
adaptive_result adaptive_pass(integration *work, const adaptive_goal *goal, adaptive_limit *limit,
                              adaptive_wave *a, uint32_t run);
/* Computes the errors and priorities of the runs from those of their squares. */
void adaptive_rate(const fathom_settings *settings, adaptive_wave *a);
/* The wave's image, clipped to the film. The result points into the wave and `view`. */
unit_result adaptive_unit(const adaptive_wave *a, const fathom_film *film, adaptive_view *view);
