/* Sampling to an error: the pixels of a wave get samples until the wave's estimated error is small enough.
 *
 * The way of the data:
 *
 *     pass: squares of high priority ── batches of 64 squares, a sample of each ──▶ integrator ──▶ sums
 *       ▲                                                                                          │
 *       └──────── error of each square, and of the wave: from the four quarters of each pixel ─────┘
 *
 * Decisions for a wave depend on the samples of its own pixels alone. These are all pixels of its square that
 * lie in the image, whatever the crop. So threads, tiles and crops change no pixel. Each pass doubles the
 * samples of some squares of 4 × 4 pixels. The Sobol sequence of each pixel is therefore always at a power of
 * two, where it is stratified. All samples of a pixel have the same weight.
 *
 * Priority. Doubling the samples of a square costs as many rays r as it took so far. It removes a part of the
 * squared error e² that is about the same for all squares. So a ray gains e² / r: the square's priority. An
 * image has the least squared error for its rays when all priorities are equal (Lagrange). A square goes on
 * while its priority is above that of a whole wave that reaches the target after ADAPTIVE_USUAL_RAYS rays a
 * pixel. If the wave's error is still above the target, the squares of highest priority go on until it is
 * not. Rays are counted, not timed. Glass and mirrors, where errors are, take several times the rays of a
 * plain surface.
 *
 * Small bright things. Where every sample has missed a thing smaller than a pixel, nothing is estimated.
 * Among pixels of as many samples, those that hit such things make up for it: their estimates are too large
 * by as much. Samples that follow the estimates alone would lose that, because they go where a thing was hit
 * and leave the others unseen. So no square of a wave has more than ADAPTIVE_SPREAD times the samples of
 * another.
 *
 * Error. e² of a wave is the mean over its pixels, and over R, G and B, of
 *
 *     variance of the pixel's mean / n(I)²,   n(I) = √max(I, 0.01) for I < 1, else I
 *
 * where I is the mean of R, G and B: linear radiance, weighted as Cycles weights it for its noise threshold
 * (kernel/film/adaptive_sampling.h), after Dammertz, Hanika, Keller and Lensch, "A Hierarchical Automatic
 * Stopping Condition for Monte Carlo Global Illumination" (2010). √I is nearly what a display shows, and
 * d√I = dI / 2√I: a target of 0.01 is 0.005 of full scale, or 1.3 of 255 levels. Cycles' floor is 1e-8; below
 * one hundredth of white it would let black pixels decide. Our floor is where the sRGB curve becomes
 * straight.
 *
 * Variance. Samples of a low-discrepancy sequence are not independent, so the variance among them is too
 * large. Dammertz et al. take the difference of the means of two halves instead. One such difference is often
 * zero by chance where an edge crosses a pixel. Here each run of a quarter of the samples, stratified by
 * itself, gives a mean q. The variance of the mean m of all is taken as Σ (q - m)² / (4 · 3). Its expectation
 * is (Var q - Var m) / 3. That is Var m where quarters are independent (Var q = 4 Var m), and more where
 * stratification helps: 7/3 Var m along edges (Var ~ n^-3/2). So the estimate covers the true error unless
 * doubling the samples fails to halve the variance. */
#ifndef JOB_ADAPTIVE_H
#define JOB_ADAPTIVE_H

#include "integrate/integrator.h"
#include "job/unit.h"

#define ADAPTIVE_MIN_SPP 4

/* With more, easy waves end further below the target than hard ones; with fewer, all end near it
 * (bench/README.md, Rendering to an error). */
#define ADAPTIVE_USUAL_RAYS 32.0

/* Measured on a field of stars from 0.1 to 2 pixels wide, and on the scene of the README (bench/README.md,
 * Rendering to an error): without a limit true errors are up to 5 times the estimates of stars, with 4 they
 * are below them on the mean; the scene takes as long for its error. */
#define ADAPTIVE_SPREAD 4u

/* Squares within this factor of the highest priority go on with it. Doubling halves the squared error and
 * doubles the rays, so otherwise these would have the highest priority one or two passes later. */
#define ADAPTIVE_NEAR_BEST 0.5

/* When a wave has enough samples. */
typedef struct adaptive_goal {
    double error;    /* of the wave, at most */
    double priority; /* squared error of a square, summed over its pixels, over its rays: at most, but for
                     squares that have all the samples a pixel may have */
} adaptive_goal;

typedef struct adaptive_wave {
    wave_region region;                /* clipped to the image, not to the crop */
    pixel_sums sums;                   /* slot: square * 16 + place in the square */
    double parts[3][3][WAVE_SLOTS];    /* [k][channel]: sums of the first k + 1 quarters */
    uint32_t done[WAVE_SQUARES];       /* samples that error and parts are of: 0 or a power of two */
    uint32_t taken[WAVE_SQUARES];      /* samples in the sums: more than done where a pass was cut short */
    uint64_t rays[WAVE_SQUARES];       /* for these: the camera's, mirrored and refracted */
    double square_error[WAVE_SQUARES]; /* sum of squared errors of its pixels; infinite while unknown */
    double error;                      /* of the wave; infinite below 4 samples a pixel */
    double priority; /* the most of any square that may have more samples; infinite below the least samples */
} adaptive_wave;

/* When to stop by the clock. */
typedef struct adaptive_limit {
    double deadline;      /* of clock_seconds() */
    double batch_seconds; /* what the last batch took */
} adaptive_limit;

typedef enum adaptive_result {
    ADAPTIVE_PASSED,   /* there may be more to do */
    ADAPTIVE_FINISHED, /* nothing was left to do: the target or the most samples are reached */
    ADAPTIVE_CUT,      /* the deadline: what was sampled is in the sums */
    ADAPTIVE_STOPPED   /* as an integrator's run(): stopped, or out of memory */
} adaptive_result;

bool adaptive_create(const render_plan *plan, adaptive_wave *out);
void adaptive_destroy(adaptive_wave *a);

adaptive_goal adaptive_goal_of(double target);

/* No samples yet. (left, top): the corner of the wave's square. */
void adaptive_begin(const render_plan *plan, uint32_t left, uint32_t top, adaptive_wave *a);
/* One pass: the first sample of each pixel, or twice the samples of every square that needs them. limit: NULL
 * without a deadline. */
adaptive_result adaptive_pass(integration *work, const adaptive_goal *goal, adaptive_limit *limit,
                              adaptive_wave *a);
/* Error and priority of the wave, from those of its squares. */
void adaptive_rate(const fathom_settings *settings, adaptive_wave *a);
/* The wave's samples, as far as the film shows its pixels. */
unit_result adaptive_unit(const adaptive_wave *a, const fathom_film *film);

#endif
