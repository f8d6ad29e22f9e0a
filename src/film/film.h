/* The film: planar channels of the cropped image, top row first. */
#ifndef FILM_FILM_H
#define FILM_FILM_H

#include "base/array.h"
#include "film/fireflies.h"
#include "film/mattes.h"
#include "scene/scene.h"

#include <fathom/image.h>

#include <pthread.h>

/* The stages that a render left out. */
typedef ARRAY(fathom_left_out) left_out_list;

#define FILM_CHANNELS (40 + 3 * (LIGHT_GROUPS + FIREFLY_CASCADES) + MATTE_KINDS * 2 * MATTE_RANKS)

/* Light by how often it was scattered. */
typedef enum light_kind { LIGHT_EMISSION, LIGHT_DIRECT, LIGHT_INDIRECT, LIGHT_KINDS } light_kind;

/* The sums for AOVs besides radiance. */
typedef struct film_parts {
    bool hits;                 /* the first hits of samples */
    uint32_t layers;           /* parts of the light that integrators tell apart, of three channels each */
    uint32_t cascades;         /* further ones, by the brightness of samples: none, or FIREFLY_CASCADES */
    int8_t kinds[LIGHT_KINDS]; /* the layer of each; -1: it is not asked for */
    int8_t groups;             /* the layer of the first light group, likewise */
    uint32_t matte_count;
    int8_t mattes[MATTE_KINDS]; /* the place of each among those that are asked for, likewise */
} film_parts;

film_parts film_parts_of(const fathom_settings *settings, const light_group_names *groups);
/* All that is summed by three channels. */
static inline uint32_t film_part_sums(film_parts parts) { return parts.layers + parts.cascades; }

typedef struct film_channel {
    const char *name, *name_in_file; /* NULL: of the film alone, and in no file */
    bool is_id, color;
    void *data; /* float or uint32_t, width * height */
} film_channel;

/* The error of the whole image. */
typedef struct film_error {
    double error;    /* as fathom_settings has target_error, of the pixels whose samples are not all alike */
    double doubtful; /* share of these of which error.doubt is above FILM_DOUBTFUL */
    double unseen;   /* the most that a pixel whose samples are all alike may lack, at 95 % */
} film_error;

struct fathom_film {
    uint32_t width, height, x, y, full_width, full_height;
    film_channel channels[FILM_CHANNELS];
    uint32_t channel_count;
    float *pixels;  /* of all channels */
    uint64_t bytes; /* that these take */
    /* The same memory by meaning; NULL when not asked for. */
    float *rgb[3], *alpha, *z, *n[3], *p[3], *albedo[3], *error[3], *doubt, *motion[4];
    uint32_t *object, *primitive, *instance, *samples;
    float *layers; /* of film_parts: three channels each, one after the other, and then the cascades' */
    film_parts parts;
    light_group_names light_groups;
    char (*group_channels)[3][LIGHT_GROUP_NAME + 8]; /* names */
    float *mattes;                                   /* of film_parts: 2 * MATTE_RANKS channels each */
    char *manifests[MATTE_KINDS];                    /* NULL: not asked for */
    /* For the header of image files. */
    fathom_settings settings;
    fathom_camera camera;
    fathom_stats stats;
    bool interrupted;
    float background[3], brightest[3]; /* the second: emission, of any surface or the surroundings */
    bool in_studio;                    /* the light is the built-in studio's */
    char *scene_name;
    char fireflies[FIREFLY_TEXT];  /* what was done about them; "": nothing was asked for */
    left_out_list left_out;        /* of the render that filled it */
    struct error_sums *error_rows; /* room for film_settle_errors(); NULL without error channels */
    film_error whole;              /* once it is settled */
    bool settled;
    pthread_mutex_t lock; /* of the pixels, while it is rendered */
};

fathom_status film_create(fathom_context *context, const fathom_scene *scene, const fathom_settings *settings,
                          fathom_film **out);

/* An empty film of the same image: the other one needs no pixels. */
fathom_status film_create_like(fathom_context *context, const fathom_film *film, fathom_film **out);

/* Its pixels as they are now, without statistics: from any thread. The pixels of a film are written under its
 * lock, as long as others may copy it. */
fathom_status film_copy(fathom_context *context, const fathom_film *film, fathom_film **out);

/* As fathom_film_write() would write PNG with the default options, to memory: no folder is needed. On
 * FATHOM_OK release it with free(). */
fathom_status film_encode_png(fathom_context *context, const fathom_film *film, unsigned char **bytes,
                              size_t *size);

typedef struct film_outputs {
    const char *const *paths;
    size_t count;
    const fathom_write_options *options;
} film_outputs;

/* Seconds that writing the film to these files will take: a part of it is written for that, and thrown away;
 * the more, the more seconds are allowed for it. A file that cannot be written takes no time:
 * fathom_film_write() will say why. */
double film_write_seconds(fathom_context *context, const fathom_film *film, const film_outputs *outputs,
                          double allowed);

#define FILM_DOUBTFUL 0.98f
/* The normal distribution's quantile for 95 %. */
#define FILM_ERROR_T 1.9599639845400542
/* Until errors are settled, error.doubt of a pixel is the sum over channels of the products that estimate its
 * squared variance, over this and over the sum of its squared variances: at most 3/4 where groups are equal.
 */
#define FILM_ERROR_PRODUCTS 2.0

/* Once all pixels are in: turns the errors of pixels, each by its own groups of samples, into those that the
 * film promises (film_error.c). */
void film_settle_errors(fathom_film *film);
/* Bytes of error_rows. */
size_t film_error_rows(const fathom_film *film);

/* False: the film has no error channels, or their errors are not settled, or not finite. */
bool film_error_of(const fathom_film *film, film_error *out);
/* One over the squared unit of target_error, for a pixel of this mean of R, G and B. */
double film_error_weight(double grey);

/* Channels of a film with these settings, a float or uint32_t a pixel each. */
uint32_t film_channels(const fathom_settings *settings, const light_group_names *groups);
#endif
