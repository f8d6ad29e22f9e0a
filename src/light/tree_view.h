/* A view of the lights from a region of surfaces: factors of their weights, and perhaps a list of parts of
 * the light tree. A part is a child of a node, which is a light or a node. Together the parts hold all
 * lights.
 *
 * Within the list's box, a traversal starts from the list instead of a cut. The weights of bright and varying
 * parts, called near, are computed for each point. All others, called far, have the same weights at all
 * points of the region. */
#pragma once

#include "light/tree.h"

/* At most eight times this many parts are near. */
#define TREE_LISTED 4

struct tree_view {
    tree_factors factors;
    float lower[3], upper[3];       /* the list's box */
    uint32_t near_count, far_count; /* near_count: nodes; 0: there is no list */
    tree_node *near;                /* near parts; their power includes their factors */
    double *far;                    /* by far part: sum of weights up to and including it */
    uint32_t *child;                /* by far part: as in tree_node */
    uint32_t *slot; /* of near and far parts; FATHOM_NONE: an empty place of the last near node */
};

/* Sets the list, for points that represent the region: each a position and a unit normal (0: as in
 * tree_kernels). view: has factors, and is zero otherwise; gets no list if that would cost noise. False: out
 * of memory. Release with tree_view_destroy(). */
bool tree_view_list(const tree *t, const float (*points)[6], size_t count, tree_view *view);
void tree_view_destroy(tree_view *view);

static inline bool tree_view_holds(const tree_view *view, vec3_f32 p) {
    const float *lower = view->lower, *upper = view->upper;
    return view->near_count && p.x >= lower[0] && p.x <= upper[0] && p.y >= lower[1] && p.y <= upper[1] &&
           p.z >= lower[2] && p.z <= upper[2];
}
static inline double tree_view_far(const tree_view *view) {
    return view->far_count ? view->far[view->far_count - 1] : 0;
}
