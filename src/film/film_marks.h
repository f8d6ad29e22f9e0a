/* Entries of an image's header: the position of its pixels in the world, and how the image was made. */
#pragma once

#include "film/film.h"
#include "image/image.h"

#define FILM_MARKS (7 + 4 * MATTE_KINDS)

typedef struct film_marks {
    image_attribute items[FILM_MARKS];
    size_t count;
    /* The entries point to these. */
    double to_camera[16], to_ndc[16], seconds;
    char matte_keys[MATTE_KINDS][4][40];
    char finished[32], exposure[32], description[64];
} film_marks;

/* options: NULL for files without a view. The entries point into `out` and the film. */
void film_marks_of(const fathom_film *film, const fathom_write_options *options, film_marks *out);
