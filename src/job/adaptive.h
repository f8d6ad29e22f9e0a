/* Sampling to an error: the pixels of a wave get samples until the wave's estimated error is small enough.
 *
 * The way of the data:
 *
 *     pass: squares of high priority ── batches of 64 squares, a sample of each ──▶ integrator ──▶ sums
 *       ▲                                                                                          │
 *       └──────── error of each square, and of the wave: by the half that judges ──────────────────┘
 *
 * No bias. The samples of a pixel are of two halves, A and B, of two groups each (film/squares.h), all with
 * scrambles of their own. A wave has two runs. Run 0 decides by the samples of A, and the samples of B that
 * it takes along are in the image. Run 1 decides by B, and A is in the image. The pixel is the plain mean of
 * run 0's mean of B and run 1's mean of A. Proof that its expectation is the true value: let N be the number
 * of samples of a pixel in run 0. It is a function of the samples of A in the wave, which are independent of
 * all samples of B. So E[mean of B's first N] = Σ P(N = n) E[mean of B's first n]; each point of a scrambled
 * sequence is uniform, so each of these expectations is the true value, whatever n, and the probabilities add
 * up to 1. The same holds for run 1, and a mean of two unbiased means is unbiased. It does not matter how
 * good the decisions are, nor how they depend on each other within a wave: priorities, min_spp, the most
 * samples and the spread below all are functions of the judge's samples alone. Rays, too, are counted of the
 * judge alone.
 *
 * Both runs take the same samples where they agree: what one has the other copies. A square that the other
 * run has already doubled twice is sampled once more, since sums in between are not kept.
 *
 * Limits. (1) Mean alpha, normal and albedo are of all samples that were taken, also by the half that
 * decides; they are biased as a mean that decides about itself is. (2) The estimated error of the image takes
 * the two halves for independent. Each one's mean is unbiased given the other half, but both ends together
 * depend on both halves, so the covariance of the two means need not be 0 where a single pixel decides for
 * its wave. (3) When a time decides, it is the clock that ends the passes (timed.c). The clock sees the
 * samples of all pixels, because slow paths take longer. A pixel has about one part in the number of pixels
 * in it.
 *
 * Decisions for a wave depend on the samples of its own pixels alone. These are all pixels of its square that
 * lie in the image, whatever the crop. So threads, tiles and crops change no pixel. Each pass doubles the
 * samples of some squares of 4 × 4 pixels. The Sobol sequence of each group is therefore always at a power of
 * two, where it is stratified.
 *
 * Priority. Doubling the samples of a square costs as many rays r as it took so far. It removes a part of the
 * squared error e² that is about the same for all squares. So a ray gains e² / r: the square's priority. An
 * image has the least squared error for its rays when all priorities are equal (Lagrange). A square goes on
 * while its priority is above that of a whole wave that reaches the target after ADAPTIVE_USUAL_RAYS rays a
 * pixel. If the wave's error is still above the target, the squares of highest priority go on until it is
 * not. Rays are counted, not timed. Glass and mirrors, where errors are, take several times the rays of a
 * plain surface.
 *
 * Small bright things. Where every sample of the judge has missed a thing smaller than a pixel, nothing is
 * estimated, and few samples are taken: where one of them does hit the thing, the pixel is far too bright,
 * and where none does, too dark. No mean is wrong, but such an image is noisy. A finding in one square of
 * a wave is therefore looked for in all: no square has more than ADAPTIVE_SPREAD times the samples of
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
 * Variance. The two groups of the judge have independent means p and q of one variance v. The mean of all
 * four groups has the variance v / 4, and (p - q)² the expectation 2v: (p - q)² / 8 is unbiased. Each pixel
 * has one degree of freedom in that, and a square sixteen. The error that is told of a wave is that of its
 * image, by all four groups (pixel_sums_error()). The decisions do not know it: they aim at ADAPTIVE_AIM of
 * the target, so that it is seldom above. */
#ifndef JOB_ADAPTIVE_H
#define JOB_ADAPTIVE_H

#include "integrate/integrator.h"
#include "job/unit.h"

#define ADAPTIVE_MIN_SPP 4
#define ADAPTIVE_AIM 0.8

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

#define ADAPTIVE_RUNS 2u

/* Run r decides by groups r and r + 2; groups 1 - r and 3 - r are for the image. */
typedef struct adaptive_run {
    double rgb[SAMPLE_GROUPS][3][WAVE_SLOTS]; /* slot: square * 16 + place in the square */
    uint32_t done[WAVE_SQUARES];              /* samples that the error is of: 0 or a power of two */
    uint32_t taken[WAVE_SQUARES];             /* in the sums: more than done where a pass was cut short */
    uint64_t rays[2][WAVE_SQUARES];           /* of either half: the camera's, mirrored and refracted */
    double square_error[WAVE_SQUARES]; /* sum of squared errors of its pixels; infinite while unknown */
    double error;                      /* of the wave; infinite below 4 samples a pixel */
    double priority; /* the most of any square that may have more samples; infinite below the least samples */
} adaptive_run;

typedef struct adaptive_wave {
    wave_region region; /* clipped to the image, not to the crop */
    sampler sampler;
    const film_kernels *kernels;
    adaptive_run runs[ADAPTIVE_RUNS];
    film_parts parts;
    double (*layers)[WAVE_SLOTS];     /* of adaptive_layers(); NULL: there are none */
    matte_list (*mattes)[WAVE_SLOTS]; /* NULL likewise; of all samples that were taken, as the next */
    hit_sums *hits;                   /* NULL: no AOV wants them */
    uint32_t seen[WAVE_SQUARES];      /* samples of which the first hits are there: the most of both runs */
} adaptive_wave;

/* The part of a wave that the film shows. */
typedef struct adaptive_view {
    pixel_sums sums;                /* without hits of its own */
    uint32_t samples[WAVE_SQUARES]; /* that are in the image */
} adaptive_view;

/* Release with adaptive_view_destroy(). NULL: out of memory. */
adaptive_view *adaptive_view_create(const render_plan *plan);
void adaptive_view_destroy(adaptive_view *view);

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
/* The bytes that a wave holds besides its struct. */
size_t adaptive_bytes(film_parts parts);
static inline size_t adaptive_layer_count(film_parts parts) {
    return (size_t)ADAPTIVE_RUNS * SAMPLE_GROUPS * 3 * film_part_sums(parts);
}
/* The layers' sums of a group of a run: three each. */
static inline double (*adaptive_layers(const adaptive_wave *a, uint32_t run, uint32_t group))[WAVE_SLOTS] {
    return a->layers + (run * SAMPLE_GROUPS + group) * 3 * film_part_sums(a->parts);
}

adaptive_goal adaptive_goal_of(double target);

/* No samples yet. (left, top): the corner of the wave's square. */
void adaptive_begin(const render_plan *plan, uint32_t left, uint32_t top, adaptive_wave *a);
/* One pass of a run: the first sample of each pixel, or twice the samples of every square that needs them.
 * limit: NULL without a deadline. */
adaptive_result adaptive_pass(integration *work, const adaptive_goal *goal, adaptive_limit *limit,
                              adaptive_wave *a, uint32_t run);
/* Errors and priorities of the runs, from those of their squares. */
void adaptive_rate(const fathom_settings *settings, adaptive_wave *a);
/* The wave's image, as far as the film shows its pixels. It refers to the wave and to `view`. */
unit_result adaptive_unit(const adaptive_wave *a, const fathom_film *film, adaptive_view *view);

#endif
