/* The rays of a render by depth and kind. */
#ifndef BENCH_SECONDARY_RAYS_H
#define BENCH_SECONDARY_RAYS_H

#include "integrate/plan.h"
#include "measure/record.h"

/* Of camera rays and eight bounces; what is deeper is left out. */
#define SECONDARY_DEPTHS 9

typedef enum secondary_kind {
    SECONDARY_CAMERA, /* depth 0 alone */
    SECONDARY_MIRRORED,
    SECONDARY_REFRACTED,
    SECONDARY_SHADOW, /* from the hits of the depth's rays */
    SECONDARY_KINDS
} secondary_kind;

const char *secondary_name(secondary_kind kind);

/* Each call as the render makes it, but for one that holds both kinds, which becomes two. */
typedef struct secondary_rays {
    record of[SECONDARY_DEPTHS][SECONDARY_KINDS];
} secondary_rays;

/* The first samples of waves from all over the image, until each depth and kind has `enough` or the image
 * ends. The plan's tracer is the real one. Release with secondary_free(). */
fathom_status secondary_record(fathom_context *context, const render_plan *plan, uint64_t enough,
                               secondary_rays *out);
void secondary_free(secondary_rays *rays);

/* The rays of each call in the order of their directions' octants, within these of their origins along a
 * Morton curve. False when out of memory. */
bool secondary_sorted(const record *from, record *out);

#endif
