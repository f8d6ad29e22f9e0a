/* The film: planar channels of the cropped image, top row first. */
#pragma once

#include "base/array.h"
#include "film/mattes.h"
#include "film/squares.h"
#include "scene/scene.h"

#include <fathom/image.h>

#include <pthread.h>

/* Fireflies: sums of samples by brightness, three channels each, and a second image in which rare bright
 * samples have a lower weight (fireflies.c). */
#define FIREFLY_CASCADES 12u

/* Size of the text in a file's header. */
#define FIREFLY_TEXT 256

/* Exponent of the scene's brightest light, modulo 3: lights of a power of two more change no comparison. */
uint32_t fireflies_octave(const fathom_scene *scene);
/* Adds the 16 samples at slots from `from` on to the sums of the cascades (three per cascade), at slots from
 * `slot` on. */
void fireflies_add(const wave_samples *samples, uint32_t from, uint32_t octave, double (*to)[WAVE_SLOTS],
                   uint32_t slot);

/* The stages that a render left out. */
typedef ARRAY(fathom_left_out) left_out_list;

#define FILM_CHANNELS (40 + 3 * (LIGHT_GROUPS + FIREFLY_CASCADES) + MATTE_KINDS * 2 * MATTE_RANKS)

/* Light by the number of scatterings. */
typedef enum light_kind { LIGHT_EMISSION, LIGHT_DIRECT, LIGHT_INDIRECT, LIGHT_KINDS } light_kind;

/* The sums for AOVs other than radiance. */
typedef struct film_parts {
    bool hits;                 /* first hits of samples are needed */
    uint32_t layers;           /* separate parts of the light, three channels each */
    uint32_t cascades;         /* further layers, by brightness of samples: 0 or FIREFLY_CASCADES */
    uint32_t octave;           /* of the cascades: fireflies_octave(); 0 from film_parts_of() */
    int8_t kinds[LIGHT_KINDS]; /* layer of each kind; -1: not requested */
    int8_t groups;             /* layer of the first light group; -1: not requested */
    uint32_t matte_count;
    int8_t mattes[MATTE_KINDS]; /* index of each among the requested mattes; -1: not requested */
} film_parts;

film_parts film_parts_of(const fathom_settings *settings, const light_group_names *groups);
/* Number of sums with three channels. */
static inline uint32_t film_part_sums(film_parts parts) { return parts.layers + parts.cascades; }

typedef struct film_channel {
    const char *name, *name_in_file; /* NULL: only in the film, not in files */
    bool is_id, color;
    void *data; /* float or uint32_t, width * height */
} film_channel;

/* The error of the whole image. */
typedef struct film_error {
    double error;    /* in the unit of target_error, over pixels whose samples are not all equal */
    double doubtful; /* fraction of these pixels with error.doubt above FILM_DOUBTFUL */
    double unseen;   /* upper bound (95 %) of the light missing in a pixel whose samples are all equal */
} film_error;

struct fathom_film {
    uint32_t width, height, x, y, full_width, full_height;
    film_channel channels[FILM_CHANNELS];
    uint32_t channel_count;
    float *pixels;  /* memory of all channels */
    uint64_t bytes; /* size of `pixels` */
    /* The channels in `pixels`, by meaning; NULL when not requested. */
    float *rgb[3], *alpha, *z, *n[3], *p[3], *albedo[3], *error[3], *doubt, *motion[4];
    uint32_t *object, *primitive, *instance, *samples;
    float *layers; /* see film_parts: three channels for each layer, then three for each cascade */
    film_parts parts;
    light_group_names light_groups;
    char (*group_channels)[3][LIGHT_GROUP_NAME + 8]; /* names */
    float *mattes;                                   /* see film_parts: 2 * MATTE_RANKS channels each */
    char *manifests[MATTE_KINDS];                    /* NULL: not requested */
    /* For the header of image files. */
    fathom_settings settings;
    fathom_camera camera;
    fathom_stats stats;
    bool interrupted;
    float background[3], brightest[3]; /* brightest: emission of any surface or of the surroundings; complete
                                          if the film has error channels */
    bool in_studio;                    /* lit by the built-in studio */
    bool exposed;                      /* `exposure` is the one that its parts name */
    float exposure;
    char *scene_name;
    char fireflies[FIREFLY_TEXT];  /* description of their treatment; "": none was requested */
    left_out_list left_out;        /* of the render that filled it */
    struct error_sums *error_rows; /* buffer for film_settle_errors(); NULL without error channels */
    film_error whole;              /* valid once `settled` is true */
    bool settled;
    pthread_mutex_t lock; /* guards the pixels during a render */
};

fathom_status film_create(fathom_context *context, const fathom_scene *scene, const fathom_settings *settings,
                          fathom_film **out);

/* An empty film of the same image. The pixels of `film` are not read. */
fathom_status film_create_like(fathom_context *context, const fathom_film *film, fathom_film **out);

/* Copies the current pixels, without statistics. Thread-safe: while others may copy a film, its pixels are
 * written under its lock. */
fathom_status film_copy(fathom_context *context, const fathom_film *film, fathom_film **out);

typedef struct film_outputs {
    const char *const *paths;
    size_t count;
    const fathom_write_options *options;
} film_outputs;

/* Estimates the seconds that writing the film to these files takes: writes a part of it, and discards the
 * result. Larger `allowed` seconds allow a larger part. A file that cannot be written counts as no time;
 * fathom_film_write() reports it. */
double film_write_seconds(fathom_context *context, const fathom_film *film, const film_outputs *outputs,
                          double allowed);

#define FILM_DOUBTFUL 0.98f
/* The two-sided 95 % quantile of the normal distribution. */
#define FILM_ERROR_T 1.9599639845400542
/* Until errors are settled, error.doubt of a pixel is the sum over channels of its estimated squared
 * variances (from products), divided by FILM_ERROR_PRODUCTS times the sum of its variances squared. If the
 * groups have equally many samples, it is at most 3/4. */
#define FILM_ERROR_PRODUCTS 2.0

/* Call once all pixels are stored. Turns the error of each pixel, estimated from its own groups of samples,
 * into the error that the film states (film_error.c). */
void film_settle_errors(fathom_film *film);
/* Size of error_rows in bytes. */
size_t film_error_rows(const fathom_film *film);

/* False: the film has no error channels, or its errors are not settled or not finite. */
bool film_error_of(const fathom_film *film, film_error *out);
/* 1 / (unit of target_error)², for a pixel with this mean of R, G and B. */
double film_error_weight(double grey);

/* Number of channels of a film with these settings; each is one float or uint32_t per pixel. */
uint32_t film_channels(const fathom_settings *settings, const light_group_names *groups);
