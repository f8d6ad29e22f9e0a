/* What a scene holds and what rendering it will take. */
#ifndef CLI_INFO_FACTS_H
#define CLI_INFO_FACTS_H

#include "integrate/parts.h"

#define INFO_FEATURES_MAX 24

typedef struct info_facts {
    uint64_t spheres, quads, planes, meshes;
    uint64_t triangles;        /* stored */
    uint64_t placed_triangles; /* counted once for each instance they appear in */
    uint64_t degenerate_triangles, beyond_reach;
    uint64_t materials, groups, instances;
    uint64_t point_lights, directional_lights, spot_lights;
    scene_bounds bounds; /* of the world; planes have none */
    /* Memory at its highest: building adds to the tree what is given back when it stands. */
    uint64_t program_bytes, geometry_bytes, bvh_bytes, build_bytes, film_bytes, total_bytes;
    const char *features[INFO_FEATURES_MAX];
    size_t feature_count;
    left_out_list left_out; /* of a render with the scene's own settings */
} info_facts;

/* Release with info_release(), whatever it returns. */
fathom_status info_gather(const fathom_scene *scene, info_facts *out);
void info_release(info_facts *facts);

#endif
