#include "image/compare/flip.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The paper's constants: exponents of the colour and feature differences. Colour differences up to 0.4 of the
 * maximum are mapped linearly to the first 0.95 of [0,1]. */
#define COLOUR_POWER 0.7
#define FEATURE_POWER 0.5
#define KNEE_AT 0.4
#define KNEE_VALUE 0.95
/* Width, in degrees, of the edges to which the eye is most sensitive. */
#define FEATURE_WIDTH 0.082

/* ---- colours ---- */

/* XYZ divided by that of white. The coefficients are fractions from the chromaticities of sRGB's primaries
 * and of D65; each row sums to one. */
static void relative_xyz(const double c[3], double out[3]) {
    out[0] = (10135552 * c[0] + 8788810 * c[1] + 4435075 * c[2]) / 23359437;
    out[1] = (2613072 * c[0] + 8788810 * c[1] + 887015 * c[2]) / 12288897;
    out[2] = (1425312 * c[0] + 8788810 * c[1] + 70074185 * c[2]) / 80288307;
}

/* The inverse, rounded. */
static const double rgb_of_xyz[3][3] = {
    {3.080341988280461, -1.5373989694887855, -0.5429430187916751},
    {-0.9211783961651236, 1.875929983695176, 0.04524841246994758},
    {0.05288129287554325, -0.20401120612390997, 1.1511299132483668},
};

/* 116 Y - 16, 500 (X - Y), 200 (Y - Z): L*a*b* without its cube roots. */
static void opponent_of(const double xyz[3], double out[3]) {
    out[0] = 116 * xyz[1] - 16;
    out[1] = 500 * (xyz[0] - xyz[1]);
    out[2] = 200 * (xyz[1] - xyz[2]);
}

void flip_opponent(const double rgb[3], double out[3]) {
    double xyz[3];
    relative_xyz(rgb, xyz);
    opponent_of(xyz, out);
}

void flip_opponent_rgb(const double opponent[3], double out[3]) {
    double y = (opponent[0] + 16) / 116, x = y + opponent[1] / 500, z = y - opponent[2] / 200;
    for (int i = 0; i < 3; ++i) out[i] = rgb_of_xyz[i][0] * x + rgb_of_xyz[i][1] * y + rgb_of_xyz[i][2] * z;
}

/* CIE 15: linear below (6/29)³, where the cube root is too steep. */
static double lightness(double t) {
    const double delta = 6.0 / 29;
    return t > delta * delta * delta ? cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
}

void flip_hunt(const double rgb[3], double out[3]) {
    double xyz[3];
    relative_xyz(rgb, xyz);
    for (int i = 0; i < 3; ++i) xyz[i] = lightness(xyz[i]);
    opponent_of(xyz, out);
    out[1] *= 0.01 * out[0];
    out[2] *= 0.01 * out[0];
}

double flip_hyab(const double a[3], const double b[3]) {
    return fabs(a[0] - b[0]) + hypot(a[1] - b[1], a[2] - b[2]);
}

/* ---- separable filters; pixels outside repeat the border ---- */

#define RADIUS_MOST 80 /* at FLIP_PPD_MOST a filter reaches 68 pixels */

typedef struct kernel {
    int radius;
    double weights[2 * RADIUS_MOST + 1]; /* the centre is at [radius] */
} kernel;

typedef struct image_size {
    size_t width, height;
} image_size;

/* Normalises: positive weights sum to one, negative ones to minus one. */
static void balance(kernel *k) {
    double above = 0, below = 0;
    for (int i = 0; i <= 2 * k->radius; ++i) {
        above += fmax(k->weights[i], 0);
        below -= fmin(k->weights[i], 0);
    }
    for (int i = 0; i <= 2 * k->radius; ++i) k->weights[i] /= k->weights[i] < 0 ? below : above;
}

/* exp(-x² / (2 sigma²)), with x in pixels up to the radius; or its first derivative, which detects edges; or
 * its second derivative, which detects points and lines. */
static kernel kernel_make(double sigma, int radius, int derivative) {
    kernel k = {.radius = radius};
    for (int x = -radius; x <= radius; ++x) {
        const double factor[] = {1, -x, x * x / (sigma * sigma) - 1};
        k.weights[x + radius] = factor[derivative] * exp(-x * x / (2 * sigma * sigma));
    }
    balance(&k);
    return k;
}

/* Extends the row on both sides by its first and last value. */
static void extend_row(const double *row, size_t width, size_t radius, double *line) {
    for (size_t i = 0; i < radius; ++i) line[i] = row[0], line[radius + width + i] = row[width - 1];
    memcpy(line + radius, row, width * sizeof *row);
}

static void add_row(const double *restrict from, double weight, size_t width, double *restrict to) {
    for (size_t x = 0; x < width; ++x) to[x] += weight * from[x];
}

/* `line` has room for a row plus two radii; `out` must differ from the other arrays. */
static void filter_rows(const double *in, image_size size, const kernel *k, double *line, double *out) {
    memset(out, 0, size.width * size.height * sizeof *out);
    for (size_t y = 0; y < size.height; ++y) {
        extend_row(in + y * size.width, size.width, (size_t)k->radius, line);
        for (int i = 0; i <= 2 * k->radius; ++i)
            add_row(line + i, k->weights[i], size.width, out + y * size.width);
    }
}

static void filter_columns(const double *in, image_size size, const kernel *k, double *out) {
    memset(out, 0, size.width * size.height * sizeof *out);
    for (size_t y = 0; y < size.height; ++y) {
        for (int i = -k->radius; i <= k->radius; ++i) {
            ptrdiff_t row = (ptrdiff_t)y + i, last = (ptrdiff_t)size.height - 1;
            row = row < 0 ? 0 : row > last ? last : row;
            add_row(in + (size_t)row * size.width, k->weights[i + k->radius], size.width,
                    out + y * size.width);
        }
    }
}

/* ---- the eye ---- */

struct flip_view {
    image_size size;
    double *hunt[3];      /* colours after the contrast sensitivity filter */
    double *edge, *point; /* strength of edges and points */
    unsigned char *broken;
    double *memory;
};

/* Contrast sensitivity as a sum of two Gaussians of the angle x, Σ a √(π/b) exp(-π² x² / b), for lightness,
 * red against green, blue against yellow. */
static const struct {
    double a, b;
} sensitivity[3][2] = {{{1, 0.0047}, {0, 1e-5}}, {{1, 0.0053}, {0, 1e-5}}, {{34.1, 0.04}, {13.5, 0.025}}};
#define WIDEST 0.04 /* largest b; the radius of all filters is three of its standard deviations */

static double deviation_of(double b, double ppd) { return sqrt(b / (2 * M_PI * M_PI)) * ppd; }

/* A Gaussian's contribution to the sum of weights, before normalisation. */
static double share_of(double a, double b, double ppd, int radius) {
    double sum = 0, sigma = deviation_of(b, ppd);
    for (int x = -radius; x <= radius; ++x) sum += exp(-x * x / (2 * sigma * sigma));
    return a * sqrt(M_PI / b) * sum * sum;
}

typedef struct workroom {
    double *in, *across, *one, *line;
} workroom;

static void blur(const flip_view *v, int channel, double ppd, const workroom *room, double *out) {
    size_t count = v->size.width * v->size.height;
    int radius = (int)ceil(3 * deviation_of(WIDEST, ppd));
    double shares[2], total = 0;
    for (int i = 0; i < 2; ++i) {
        shares[i] = share_of(sensitivity[channel][i].a, sensitivity[channel][i].b, ppd, radius);
        total += shares[i];
    }
    for (size_t p = 0; p < count; ++p) out[p] = 0;
    for (int i = 0; i < 2; ++i) {
        if (!(shares[i] > 0)) continue;
        kernel k = kernel_make(deviation_of(sensitivity[channel][i].b, ppd), radius, 0);
        filter_rows(room->in, v->size, &k, room->line, room->across);
        filter_columns(room->across, v->size, &k, room->one);
        for (size_t p = 0; p < count; ++p) out[p] += shares[i] / total * room->one[p];
    }
}

/* ---- edges and points ---- */

/* √(gx² + gy²) of the filter along x and along y; each result is smoothed in the other direction. */
static void detect(const flip_view *v, const kernel *k, const kernel *smooth, const workroom *room,
                   double *out) {
    size_t count = v->size.width * v->size.height;
    filter_rows(room->in, v->size, k, room->line, room->across);
    filter_columns(room->across, v->size, smooth, out);
    filter_rows(room->in, v->size, smooth, room->line, room->across);
    filter_columns(room->across, v->size, k, room->one);
    for (size_t p = 0; p < count; ++p) out[p] = hypot(out[p], room->one[p]);
}

static void find_features(flip_view *v, double ppd, const workroom *room) {
    double sigma = 0.5 * FEATURE_WIDTH * ppd;
    int radius = (int)ceil(3 * sigma);
    kernel smooth = kernel_make(sigma, radius, 0), edge = kernel_make(sigma, radius, 1),
           point = kernel_make(sigma, radius, 2);
    detect(v, &edge, &smooth, room, v->edge);
    detect(v, &point, &smooth, room, v->point);
}

/* ---- views ---- */

static double shown(float value) { return value > 0 ? fmin((double)value, 1) : 0; }

/* One channel of the image's opponent colours. */
static void take_channel(const metric_image *img, int channel, double *out) {
    for (size_t p = 0; p < (size_t)img->width * img->height; ++p) {
        double rgb[3] = {shown(img->rgb[0][p]), shown(img->rgb[1][p]), shown(img->rgb[2][p])}, opponent[3];
        flip_opponent(rgb, opponent);
        out[p] = opponent[channel];
    }
}

/* Clamps filtered colours to the range of a screen, and converts them to Hunt-adjusted L*a*b*. */
static void see_colours(flip_view *v) {
    for (size_t p = 0; p < v->size.width * v->size.height; ++p) {
        double opponent[3] = {v->hunt[0][p], v->hunt[1][p], v->hunt[2][p]}, rgb[3], hunt[3];
        flip_opponent_rgb(opponent, rgb);
        for (int c = 0; c < 3; ++c) rgb[c] = fmin(1, fmax(0, rgb[c]));
        flip_hunt(rgb, hunt);
        for (int c = 0; c < 3; ++c) v->hunt[c][p] = hunt[c];
    }
}

static void mark_broken(flip_view *v, const metric_image *img) {
    for (size_t p = 0; p < v->size.width * v->size.height; ++p) {
        bool finite = true;
        for (int c = 0; c < 3; ++c) finite &= isfinite(img->rgb[c][p]) != 0;
        v->broken[p] = !finite;
    }
}

static void fill(flip_view *v, const metric_image *img, double ppd, const workroom *room) {
    mark_broken(v, img);
    for (int c = 0; c < 3; ++c) {
        take_channel(img, c, room->in);
        blur(v, c, ppd, room, v->hunt[c]);
    }
    see_colours(v);
    take_channel(img, 0, room->in);
    for (size_t p = 0; p < v->size.width * v->size.height; ++p) room->in[p] = (room->in[p] + 16) / 116;
    find_features(v, ppd, room);
}

flip_view *flip_view_create(const metric_image *img, double ppd) {
    size_t count = (size_t)img->width * img->height;
    flip_view *v = calloc(1, sizeof *v);
    double *room = malloc((3 * count + img->width + 2 * RADIUS_MOST) * sizeof *room);
    if (v) {
        v->size = (image_size){img->width, img->height};
        v->memory = malloc(5 * count * sizeof *v->memory);
        v->broken = malloc(count);
    }
    if (!v || !room || !v->memory || !v->broken) {
        free(room);
        flip_view_destroy(v);
        return NULL;
    }
    for (size_t c = 0; c < 3; ++c) v->hunt[c] = v->memory + c * count;
    v->edge = v->memory + 3 * count, v->point = v->memory + 4 * count;
    const workroom work = {room, room + count, room + 2 * count, room + 3 * count};
    fill(v, img, ppd, &work);
    free(room);
    return v;
}

void flip_view_destroy(flip_view *view) {
    if (!view) return;
    free(view->memory);
    free(view->broken);
    free(view);
}

/* ---- differences ---- */

/* The maximum difference of two colours is that of green and blue. */
static double largest_colour(void) {
    double green[3], blue[3];
    flip_hunt((const double[3]){0, 1, 0}, green);
    flip_hunt((const double[3]){0, 0, 1}, blue);
    return pow(flip_hyab(green, blue), COLOUR_POWER);
}

static double colour_difference(const flip_view *a, const flip_view *b, size_t p, double largest) {
    double one[3], other[3];
    for (int c = 0; c < 3; ++c) one[c] = a->hunt[c][p], other[c] = b->hunt[c][p];
    double d = pow(flip_hyab(one, other), COLOUR_POWER), knee = KNEE_AT * largest;
    if (d < knee) return KNEE_VALUE / knee * d;
    return KNEE_VALUE + (d - knee) / (largest - knee) * (1 - KNEE_VALUE);
}

static double feature_difference(const flip_view *a, const flip_view *b, size_t p) {
    double edge = fabs(a->edge[p] - b->edge[p]), point = fabs(a->point[p] - b->point[p]);
    return pow(fmax(edge, point) / M_SQRT2, FEATURE_POWER);
}

/* A feature difference increases the effect of a colour difference. */
static double difference(const flip_view *a, const flip_view *b, size_t p, double largest) {
    if (a->broken[p] | b->broken[p]) return 1;
    return pow(colour_difference(a, b, p, largest), 1 - feature_difference(a, b, p));
}

double flip_mean(const flip_view *a, const flip_view *b, float *map) {
    double sum = 0, largest = largest_colour();
    size_t count = a->size.width * a->size.height;
    for (size_t p = 0; p < count; ++p) {
        double d = difference(a, b, p, largest);
        sum += d;
        if (map) map[p] = (float)d;
    }
    return sum / (double)count;
}
