/* Surveys of scenes: contents, the memory that rendering takes, and problems. */
#ifndef FATHOM_SURVEY_H
#define FATHOM_SURVEY_H

#include <fathom/render.h>

#ifdef __cplusplus
extern "C" {
#endif

/* "" when it has none, or scene is NULL. Valid until it is set anew. */
FATHOM_API const char *fathom_scene_name(const fathom_scene *scene);
/* The number of lights, including those that fathom_scene_complete() added, without environments. */
FATHOM_API uint32_t fathom_scene_lights(const fathom_scene *scene);
/* FATHOM_BAD_USAGE when there is no light of this index. */
FATHOM_API fathom_status fathom_scene_light_sized(const fathom_scene *scene, uint32_t index,
                                                  fathom_light *out, size_t size);
static inline fathom_status fathom_scene_light(const fathom_scene *scene, uint32_t index, fathom_light *out) {
    return fathom_scene_light_sized(scene, index, out, sizeof *out);
}

/* A camera that the scene's file has to choose from. */
typedef struct fathom_camera_choice {
    const char *node, *name; /* of the node that holds it, and its own; NULL: none */
    bool orthographic;
    bool taken;
} fathom_camera_choice;

/* Made by the library, which may add members at the end. Arrays and texts belong to the survey. */
typedef struct fathom_survey {
    uint64_t triangles, placed_triangles; /* stored; counted once for each instance they appear in */
    uint64_t degenerate_triangles;        /* without area: ignored */
    /* Without the root group, and without material 0 if no shape has it. */
    uint64_t meshes, spheres, quads, planes, instances, groups, materials;
    const uint64_t *lights;    /* number of each fathom_light_type that the scene's integrator uses */
    bool has_bounds;           /* something other than planes is there */
    double lower[3], upper[3]; /* bounds of what is placed in the world */
    const fathom_camera *camera;
    const fathom_camera_choice *cameras;
    uint32_t camera_count;
    /* Estimated bytes of memory: the program, meshes, Embree's structure, the extra memory to build it,
     * and the film with the scene's own settings. */
    uint64_t program_bytes, mesh_bytes, bvh_bytes, building_bytes, film_bytes;
    const char *const *features; /* features in use: "smooth normals", "Phong" */
    uint32_t feature_count;
    const fathom_left_out *left_out; /* by a render with the scene's own settings */
    uint32_t left_out_count;
    const char *const *problems; /* can be rendered, but are probably mistakes */
    uint32_t problem_count;
    uint64_t points, clouds; /* of points; clouds are not among the meshes above */
    /* Triangles and shapes of emissive materials, once for each instance that shows them. A point counts as
     * a shape. */
    uint64_t emissive_triangles, emissive_shapes;
    /* Estimated bytes of memory, too: of textures, if a render looks up all of them, and of environments. */
    uint64_t texture_bytes, environment_bytes;
} fathom_survey;

/* Prepares the scene as a render with Embree does, without building or rendering. FATHOM_BAD_INPUT: it cannot
 * be rendered, and the message says why; FATHOM_OUT_OF_RESOURCES. Release with fathom_survey_destroy(). */
FATHOM_API fathom_status fathom_scene_survey(const fathom_scene *scene, const fathom_survey **out);
FATHOM_API void fathom_survey_destroy(const fathom_survey *survey);

#ifdef __cplusplus
}
#endif
#endif
