/* From a scene to an image. */
#ifndef FATHOM_RENDER_H
#define FATHOM_RENDER_H

#include <fathom/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum fathom_integrator {
    FATHOM_INTEGRATOR_CLASSIC,  /* recursive ray tracing: light from points and directions, mirrors, glass */
    FATHOM_INTEGRATOR_PATH,     /* path tracing: global illumination */
    FATHOM_INTEGRATOR_REFERENCE /* a second, simple path tracer in double: slow, for checks */
} fathom_integrator;

typedef enum fathom_pattern {
    FATHOM_PATTERN_GRID,       /* n × n, regular; spp is a square number */
    FATHOM_PATTERN_STRATIFIED, /* n × n, jittered in each cell; spp is a square number */
    FATHOM_PATTERN_SOBOL       /* Owen-scrambled Sobol (0,2)-sequence; any spp */
} fathom_pattern;

/* Pixel filters, by importance sampling: the filter decides where samples lie, and all have equal weight. */
typedef enum fathom_filter {
    FATHOM_FILTER_BOX,
    FATHOM_FILTER_GAUSSIAN,       /* standard deviation: a quarter of the width; lowered to 0 at its edges */
    FATHOM_FILTER_BLACKMAN_HARRIS /* the window of four terms */
} fathom_filter;

/* Treatment of fireflies: samples far brighter than all others of their pixel. */
typedef enum fathom_fireflies {
    FATHOM_FIREFLIES_KEEP,
    FATHOM_FIREFLIES_REWEIGHT /* keeps them, and also the data that fathom_film_reweight() needs */
} fathom_fireflies;

/* Extra outputs, a bit each. */
enum {
    FATHOM_AOV_ALPHA = 1u << 0,  /* A: covered part of the pixel; R G B are then premultiplied, without the
                                    background behind (mirrors and glass still show it) */
    FATHOM_AOV_Z = 1u << 1,      /* Z: depth along the view axis, of the sample nearest the pixel's centre */
    FATHOM_AOV_N = 1u << 2,      /* N.X N.Y N.Z: shading normal, world, averaged. Under path tracing it
                                    follows smooth mirrors and glass as albedo does, for denoisers */
    FATHOM_AOV_P = 1u << 3,      /* P.X P.Y P.Z: world position, of the sample nearest the centre */
    FATHOM_AOV_ALBEDO = 1u << 4, /* albedo.R albedo.G albedo.B: k_d + k_s, averaged. Under path tracing: of
                                    the first surface that is not a smooth mirror or clear glass, multiplied
                                    by the tints of those before it */
    FATHOM_AOV_ID = 1u << 5, /* id.object id.primitive id.instance: as in fathom_hit, of the sample nearest
                                the centre; FATHOM_NONE for none */
    FATHOM_AOV_SAMPLES = 1u << 6, /* samples: how many samples the pixel has, as an id channel. In files
                                     id.object, id.primitive, id.instance and samples end in ".V", because
                                     Blender recognises only single letters as channels */
    /* error.R error.G error.B: standard error of R, G and B. It is estimated from four groups of samples
     * with independent scrambles, and from those of the 12 x 12 pixels around. The interval of the pixel's
     * value ± 1.96 standard errors is meant to contain the true value in 95 % of pixels. The error is
     * infinite below 4 samples. If all samples of a square of 4 x 4 pixels are equal, the error is a
     * bound: what the brightest emission of the scene could add unseen (rule of three), divided by 1.96.
     * error.doubt, [0, 1]: do not trust the error if this is above 0.98. Then the pixel's samples differ
     * far more than the error says (a rare bright path), or the pixels around are too different to
     * estimate it; 1 marks the bound above. Needs the pattern Sobol, and one of path tracing, target_error
     * and max_time. Without target_error and max_time, this AOV changes the image: without it all samples
     * of a pixel have one scramble, which is less noisy */
    FATHOM_AOV_ERROR = 1u << 7,
    /* The light of a pixel in three parts, R G B each: emission.R… reached the camera without scattering,
     * from surfaces, the background and environments; direct.R… was scattered once, and indirect.R… more
     * than once. Mirrors and glass scatter. A surface that a path passes because of its opacity, and a
     * clear thin wall that it passes straight, do not. Each sample's R, G and B are the sum of the three.
     * The classic integrator counts ambient light as emission of the surface that reflects it. */
    FATHOM_AOV_DIRECT = 1u << 8,
    FATHOM_AOV_INDIRECT = 1u << 9,
    FATHOM_AOV_EMISSION = 1u << 10,
    /* light_NAME.R…: the image with the light of one group alone (fathom_scene_set_light_group()). "rest" has
     * the light of no group and comes first; the groups follow in the order in which the scene names them.
     * They add up to R, G and B. */
    FATHOM_AOV_LIGHT_GROUPS = 1u << 11,
    /* Cryptomatte, of objects and of materials: CryptoObject00.R to CryptoObject02.A, CryptoMaterial00.R…:
     * six pairs of id and coverage. The file's header has the names of the ids. Surfaces that a path
     * passes because of their opacity do not count; glass and mirrors do. A pixel counts the first 16
     * objects or materials that its samples hit. */
    FATHOM_AOV_CRYPTO_OBJECT = 1u << 12,
    FATHOM_AOV_CRYPTO_MATERIAL = 1u << 13,
    /* forward.u forward.v backward.u backward.v: how far the surface of the sample nearest the pixel's centre
     * moves in the image, in pixels, u to the right and v upwards, from the middle of the shutter's time to
     * its end and to its beginning: by its own motion, its vertices' and the camera's. Seen in perspective,
     * the background is infinitely far. 0 where the point is behind the camera at one of the three times. */
    FATHOM_AOV_MOTION = 1u << 14,
    FATHOM_AOVS = (1u << 15) - 1
};

typedef struct fathom_settings {
    size_t size;
    uint32_t width, height;       /* pixels, [1, 65536]; default 1280 × 720 */
    fathom_integrator integrator; /* default path */
    uint32_t spp; /* samples per pixel, [1, 65536]; default 1024. With target_error, which is on by default,
                     or max_time: the maximum of any pixel, a power of two and at least 4 */
    fathom_pattern pattern; /* default Sobol */
    fathom_filter filter;   /* of pixels; default box */
    double filter_width;    /* in pixels, [0.01, 16]; 0 (default): 1, or 3 and 4 for the filters after box */
    uint64_t seed;          /* of the random numbers: all but the grid's positions in a pixel; default 0 */
    uint32_t crop[4];       /* x0 y0 x1 y1, half open, row 0 at the top; all 0 (default): the whole image */
    /* Adaptive sampling: pixels get samples until the estimated error of each tile of 32 × 32 pixels is at
     * most this, or until they have `spp`. They get more where a few samples lower the error much. The
     * error is a root mean square over the tile's pixels and channels. Its terms are the standard error of
     * the linear radiance divided by √max(I, 0.01) for I < 1, else by I. I is the pixel's mean of R, G and
     * B. This is the unit of Cycles' noise threshold. 0.01 is 1.3 of 255 display levels. Needs the pattern
     * Sobol. The choice depends only on the values of samples, not on time or threads. 0: off; default
     * 0.02 */
    double target_error;
    /* Seconds from the call of fathom_render() to its return, building included: the samples go where they
     * lower the error of the image most, until the time is up or target_error is reached. FATHOM_BAD_USAGE
     * when it is too short for one sample of each pixel. Needs the pattern Sobol. 0 (default): off */
    double max_time;
    uint32_t min_spp;   /* minimum samples per pixel with target_error or max_time: a power of two, at least 4
                           and at most spp; 0 (default): 4 */
    uint32_t max_depth; /* bounces, [0, 1024]; default 16. Classic counts mirrored and refracted ones */
    float min_weight; /* classic: a path ends when its weight can change no channel by more; default 1/65536.
                         Path tracing ends paths by Russian roulette, from the fourth vertex on */
    /* Skips shadow rays whose light would hardly be visible. Each channel of a pixel loses at most
     * max_loss + max_relative_loss times its value, summed over all samples, paths and lights of the pixel.
     * [0, 1] each; 0 (default): none is skipped, and the image is exact. fathom_settings_set_loss() sets
     * losses that are invisible in a file. */
    float max_loss, max_relative_loss;
    double epsilon;          /* fixed ray epsilon; 0 (default): automatic, from error bounds */
    bool terminator_fix;     /* light reaches what normals of smooth meshes face (Hanika); default true */
    bool photons;            /* path: photons bring what smooth mirrors and glass throw onto other surfaces;
                                no expected value depends on it; default true */
    unsigned aovs;           /* FATHOM_AOV_ bits; default 0 */
    const char *tracer;      /* the tracer: "embree" (also NULL, the default), "reference", "bvh:f64",
                                "embree:user:high", or a library FILE.so (see plugin.h). The caller keeps the
                                text; fathom_scene_set_settings() copies it */
    unsigned block_width;    /* rays in one call of the tracer: 1, 4, 8 or 16 (default) */
    unsigned tile_size;      /* pixels, a multiple of 32; default 32. No pixel depends on it */
    uint64_t memory_limit;   /* bytes that the process may have in memory; 0 (default): what is free. If only
                                Embree's compact structures fit, they are used; if not even these fit,
                                FATHOM_OUT_OF_RESOURCES before anything is built */
    uint64_t texture_memory; /* bytes of texture tiles in memory; the others are in a temporary file; default
                                1e9 */
    fathom_fireflies fireflies; /* default keep */
    bool motion_blur; /* default true; false: all samples are at the middle of the shutter time; motion
                         vectors still cover all of it */
} fathom_settings;

typedef enum fathom_loss {
    FATHOM_LOSS_NONE,
    FATHOM_LOSS_8BIT, /* in .png and .tif through the built-in sRGB view, at most one level is lost */
    FATHOM_LOSS_HALF  /* in .exr with colours as half, at most one unit in the last place */
} fathom_loss;

FATHOM_DEFAULT(fathom_settings)
/* Chooses an integrator, and what suits it. Path: the pattern Sobol, 16 bounces, and samples to an error of
 * 0.02 or until a pixel has 1024. Classic: the grid, 8 bounces and one sample. The default is path's. */
FATHOM_API fathom_status fathom_settings_set_integrator(fathom_settings *settings,
                                                        fathom_integrator integrator);
/* Sets max_loss and max_relative_loss to a loss that such a file hardly shows. exposure: the exposure that
 * the file will be written with. */
FATHOM_API fathom_status fathom_settings_set_loss(fathom_settings *settings, fathom_loss loss,
                                                  float exposure);
/* FATHOM_BAD_INPUT names what is out of range, or does not fit together. Rendering checks the same. */
FATHOM_API fathom_status fathom_settings_check(fathom_context *context, const fathom_settings *settings);
/* The settings the scene's file asked for, else (and if scene is NULL) the defaults. A text in them is the
 * scene's, and is good until they are set anew. */
FATHOM_API void fathom_scene_settings_sized(const fathom_scene *scene, fathom_settings *out, size_t size);
static inline void fathom_scene_settings(const fathom_scene *scene, fathom_settings *out) {
    fathom_scene_settings_sized(scene, out, sizeof *out);
}
FATHOM_API fathom_status fathom_scene_set_settings(fathom_scene *scene, const fathom_settings *settings);

typedef enum fathom_phase {
    FATHOM_PHASE_READ,
    FATHOM_PHASE_BUILD,
    FATHOM_PHASE_RENDER,
    FATHOM_PHASE_WRITE,
    FATHOM_PHASE_PHOTONS /* between building and rendering: photons find caustics */
} fathom_phase;

typedef struct fathom_progress {
    fathom_phase phase;
    double fraction; /* of this phase, [0,1] */
    uint64_t rays;   /* traced so far */
    double seconds;  /* since this phase began */
    double error; /* with target_error: the largest estimate of the tiles that are finished; 0: of none yet */
} fathom_progress;

/* Called about ten times a second from the calling thread. Return false to stop: the render then returns
 * FATHOM_INTERRUPTED with the film as far as it got. Pixels that have no samples yet show a coarse preview,
 * with 0 in the channel "samples" (FATHOM_AOV_SAMPLES); in a render to a time every pixel has its first
 * sample before any has more. */
typedef bool (*fathom_progress_fn)(void *user, const fathom_progress *progress);

typedef struct fathom_stats {
    size_t size;
    uint64_t triangles, primitives,
        instances; /* triangles stored; spheres + points + quads + planes + triangles; placed instances */
    uint64_t placed_triangles; /* counted once for each instance they appear in */
    uint64_t camera_rays, shadow_rays, reflection_rays, refraction_rays;
    uint64_t repaired_rays; /* of these: missed a vertex of a closed mesh at first, and were traced again */
    uint64_t unlit_shadow_rays; /* not cast, and not in shadow_rays: the light is behind the surface, the
                                   point is outside the light's cone, or the surface reflects none of it */
    uint64_t faint_shadow_rays; /* not cast either: their light was within max_loss and max_relative_loss */
    uint64_t samples;           /* of all pixels of the film together */
    double finished;            /* share of the render that is done, [0,1]; with max_time, of the time */
    double error_estimate;      /* with target_error or max_time: the largest of any tile (see target_error);
                                   infinite when time ended before it was known. Otherwise 0 */
    double build_seconds, render_seconds;
    uint64_t mesh_bytes, bvh_bytes, film_bytes; /* arrays of the scene's meshes, and points as spheres; the
                                                   tracer's structures; pixels, and the map of caustics */
    uint64_t bvh_peak_bytes;                    /* the most that the tracer held while it was built */
    uint64_t foreseen_bytes;       /* predicted peak of the process, before building; 0: unknown */
    uint64_t degenerate_triangles; /* rendered around */
    uint32_t checkpoints; /* saved by this call; below: the seconds that saving took, next to rendering */
    double checkpoint_seconds;
    double resumed_seconds;     /* rendering time of the calls that this one continues. Rays and seconds above
                                   are of this call alone; samples and errors are of the whole film */
    uint64_t resumed_samples;   /* in pixels that those earlier calls had finished */
    uint64_t scene_fingerprint; /* differs between scenes that may render differently; ignores file names */
    unsigned threads;
    char tracer[64];       /* "Embree 3.13.5, AVX-512" */
    uint64_t image_bytes;  /* of environments, and the most that texels of textures took */
    double photon_seconds; /* finding caustics before rendering; not in build_seconds */
} fathom_stats;

typedef struct fathom_film fathom_film;

/* Renders. FATHOM_BAD_USAGE when there is no tracer of these words (the message lists those there are), or
 * when it cannot hold the scene's shapes. On FATHOM_OK and FATHOM_INTERRUPTED *out is a film, to be released
 * with fathom_film_destroy(); otherwise *out is NULL. progress, user and stats may be NULL. Messages and
 * warnings go to `context`, which need not be the one that the scene was made with. session.h renders in the
 * background, and saves on the way. */
FATHOM_API fathom_status fathom_render(fathom_context *context, const fathom_scene *scene,
                                       const fathom_settings *settings, fathom_progress_fn progress,
                                       void *user, fathom_stats *stats, fathom_film **out);
FATHOM_API void fathom_film_destroy(fathom_film *film);

/* Size of the cropped image; width or height may be NULL. */
FATHOM_API void fathom_film_size(const fathom_film *film, uint32_t *width, uint32_t *height);
/* One channel by its name ("R", "G", "B", "Z", "N.X", …): width × height values, top row first. NULL when the
 * film has no such channel, or one of the other type. Valid as long as the film. Colours are finite: what one
 * light or surface adds to a sample is at most 2^100. */
FATHOM_API const float *fathom_film_channel(const fathom_film *film, const char *name);
FATHOM_API const uint32_t *fathom_film_channel_id(const fathom_film *film, const char *name);

/* A second film with R, G and B, and A if the first has it. Samples that are rare in their pixel and its
 * neighbours count less (Zirr, Hanika and Dachsbacher, "Reweighting firefly samples for improved
 * finite-sample Monte Carlo estimates", 2018; src/film/fireflies.c has the rule). Where such samples carry
 * the light, as in caustics, the second film is too dark. fathom:fireflies in its header says what was
 * changed. *out is NULL when the film was rendered without FATHOM_FIREFLIES_REWEIGHT; release it with
 * fathom_film_destroy(). */
FATHOM_API fathom_status fathom_film_reweight(fathom_context *context, const fathom_film *film,
                                              fathom_film **out);

/* A part of the renderer that a render skipped, and why: "shading normals", "no mesh has any". */
typedef struct fathom_left_out {
    char what[48], why[96];
} fathom_left_out;

/* Returns the number of items in *out. *out is valid as long as the film, and NULL if there are none. `out`
 * itself may be NULL. */
FATHOM_API uint32_t fathom_film_left_out(const fathom_film *film, const fathom_left_out **out);

/* How bright the film is where it shows something other than the bare background. */
typedef struct fathom_brightness {
    size_t size;
    uint64_t pixels;  /* that show something other than the background; all pixels if image and background are
                         black and there is no alpha */
    uint64_t black;   /* of these: without any light */
    uint64_t clipped; /* of these: brighter than white (1) at the given exposure */
    float exposure; /* stops, a multiple of 0.1: at most 1 % of the lit pixels are brighter than white; 0 when
                       all are black */
    bool in_studio; /* the built-in studio lights the scene, so no author chose the brightness */
} fathom_brightness;

/* exposure: as in fathom_write_options. film may be NULL: all is 0 then. FATHOM_BAD_USAGE: `out` has no size.
 */
FATHOM_API fathom_status fathom_film_brightness(const fathom_film *film, float exposure,
                                                fathom_brightness *out);

/* True when the film was merged from parts that name its exposure (fathom_part): *stops is that exposure.
 * Otherwise *stops keeps its value. */
FATHOM_API bool fathom_film_exposure(const fathom_film *film, float *stops);

#ifdef __cplusplus
}
#endif
#endif
