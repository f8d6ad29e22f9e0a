/* Scenes from files, and generated meshes. */
#ifndef FATHOM_READ_H
#define FATHOM_READ_H

#include <fathom/render.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Reads scene JSON, .glb, .gltf, .obj or .ply, by the extension. Adds a camera and lights if the file has
 * none, and checks the scene. The settings are those of scene JSON, else the defaults; a model that is
 * read for the integrator classic gets 16 samples per pixel. The image takes the aspect ratio of the
 * file's camera (glTF's aspectRatio, w and h of scene JSON) unless the file gives a size; its longer side
 * is then 1280 pixels. FATHOM_BAD_INPUT names the file with its line, field or byte offset. */
FATHOM_API fathom_status fathom_scene_read(fathom_context *context, const char *path, fathom_scene **out);

/* The same, but skips data that rendering does not need: texture coordinates that no material
 * uses. They are neither checked nor kept. */
FATHOM_API fathom_status fathom_scene_read_to_render(fathom_context *context, const char *path,
                                                     fathom_scene **out);

/* Which axis of a file without a camera points upwards in the image. */
typedef enum fathom_up { FATHOM_UP_Y, FATHOM_UP_Z } fathom_up;

/* The automatic camera and the floor of a scene that was read without a camera. Give all frames of an
 * animation the same framing: otherwise the model would seem to grow and shrink as it moves. */
typedef struct fathom_framing {
    size_t size;
    bool made; /* false: the scene has a camera of its own, or nothing that can be seen; all else is 0 then */
    fathom_up up;
    double eye[3];
    double slopes[2];  /* half the width and half the height of the view at distance 1 */
    double reach[4];   /* extent of the model to the right, left, top and bottom: for each, the maximum of
                          x + s z over its points. x points to that side in the image, z towards the eye, and s
                          is the slope of that axis */
    double foot[3];    /* the point of the floor below the middle of the model */
    double radius;     /* of the model's bounds; 0: there is no floor */
    double axes[3][3]; /* of the camera: right, up, and back from the model */
} fathom_framing;

typedef struct fathom_read_options {
    size_t size;
    bool without_uvs; /* as fathom_scene_read_to_render(); default false */
    /* The camera to take of a glTF file: the name of the node that holds it, else the camera's own, else a
     * number, counted from 0 in the order of the hierarchy. FATHOM_BAD_USAGE, with a list of what there is,
     * when there is none such. NULL (default): the first perspective camera, else the first. */
    const char *camera;
    fathom_up
        up; /* of the automatic camera; its lights follow it. Default y. Files with a camera: a warning */
    /* The size of the image that will be rendered, which the automatic camera fits. Both 0 (default): the
     * size in the settings of the scene that is read. */
    uint32_t width, height;
    /* With choose_integrator the scene is read for this integrator, whatever its file says: settings that the
     * file does not give follow it, and so do automatic lights. If the file's spp or target error is meant
     * for another integrator and the pattern cannot take it, the pattern is sobol. Default: the file's, else
     * path tracing. */
    bool choose_integrator;
    fathom_integrator integrator;
    /* The time, in seconds, of the image. glTF files have the pose of their animations at this time;
     * without choose_time, that of their nodes, or that at time 0 if `animations` is given. The shutter of
     * scene JSON opens at this time, for as long as the file says; without choose_time it opens when the
     * file says. FATHOM_BAD_USAGE if no file of the scene has an animation and nothing has motion. */
    bool choose_time;
    double time;
    /* The animations to pose together, NULL after the last: of each its name, else its number, counted from
     * 0. FATHOM_BAD_USAGE, with a list of what there is, when there is none such, or when two of them move
     * the same. NULL (default): all, except those that move a part of a node that an earlier one moves. */
    const char *const *animations;
    /* A variant of glTF's KHR_materials_variants, by name or number likewise. NULL (default): no variant. */
    const char *variant;
    /* Metres per unit of a model's lengths: the model is scaled to metres. 0 (default): not scaled.
     * FATHOM_BAD_USAGE for scene JSON, which scales its models itself. */
    double unit;
    /* How long the shutter is open, in seconds, from `time` on: animations and the motion of scene JSON
     * are blurred. It replaces the shutter of scene JSON. FATHOM_BAD_USAGE if nothing is animated or has
     * motion. 0 (default): no motion blur, except that a shutter of scene JSON blurs its motion, and
     * animations if choose_time is true. */
    double shutter;
    /* A model that the automatic camera sees gets a floor to stand on, which touches its lowest point. In the
     * built-in studio it is an object named "studio floor", a grey sheet that bends up into a wall behind, as
     * far as the image shows. In `environment` it is a round grey "plate" whose edge fades. A camera below it
     * sees none. Default false. */
    bool floor;
    /* An image of the sky that lights the scene in place of the file's background and environments, and of
     * the built-in studio: see FATHOM_LIGHT_ENVIRONMENT. Its top points up. NULL (default): none. */
    const char *environment;
    double environment_rotation; /* radians, about the axis that is up; default 0 */
    /* Position of the automatic camera and the floor, made for the same view, width and height. NULL
     * (default), or a framing with made == false: chosen so that the whole scene is visible. */
    const fathom_framing *framing;
    /* With choose_integrator: the caller sets spp itself, so the spp and the target error of a file for
     * another integrator are ignored. Default false. */
    bool own_spp;
    /* A `shutter` of 0 also replaces that of scene JSON: everything stands still at `time`. Default false. */
    bool choose_shutter;
    /* The scene of a glTF file to take, by name or number as `animations`. NULL (default): the file's choice,
     * else the first. */
    const char *scene;
    /* Adds no lights to a scene that has none: neither the built-in studio nor a key and a fill light.
     * Default false. */
    bool no_studio;
    /* From where the automatic camera looks, in radians; the studio and the floor turn with it. azimuth: from
     * the front (z, or -y with FATHOM_UP_Z) to the right; elevation: above the floor, [-π/2, π/2]. Files with
     * a camera: a warning. Default: slightly right and above, about 0.42 and 0.31. */
    bool choose_azimuth, choose_elevation;
    double azimuth, elevation;
} fathom_read_options;

FATHOM_DEFAULT(fathom_read_options)
/* fathom_scene_read() with options, which are read now; the scene keeps none of their text. */
FATHOM_API fathom_status fathom_scene_read_with(fathom_context *context, const char *path,
                                                const fathom_read_options *options, fathom_scene **out);

/* Gives the framing of a scene that was read. FATHOM_BAD_USAGE: `out` has no size. */
FATHOM_API fathom_status fathom_scene_framing(const fathom_scene *scene, fathom_framing *out);
/* Gives the times in seconds, 0 among them, between which something moves: by the animations that were played
 * and by motion of scene JSON. All frames should have the framing of all these times. False: nothing moves,
 * or the file has a camera of its own. */
FATHOM_API bool fathom_scene_framed_times(const fathom_scene *scene, double out[2]);
/* Extends *framing so that it also shows what *other shows. Both must come from scenes that were read for the
 * same view, width and height. If either has made == false, the call does nothing. */
FATHOM_API void fathom_framing_unite(fathom_framing *framing, const fathom_framing *other);

/* FATHOM_BAD_INPUT when a file that the scene was mapped from has been truncated or changed since it was
 * read, by its size and its time stamp: do not trust any result from the scene then.
 * fathom_scene_read() and fathom_render() make this check themselves, the latter every second. If you trace
 * rays with fathom/trace.h, make it yourself. */
FATHOM_API fathom_status fathom_scene_check_files(const fathom_scene *scene);

typedef enum fathom_generator {
    FATHOM_GENERATE_SPHERE,  /* a displaced sphere, closed, smooth normals */
    FATHOM_GENERATE_TERRAIN, /* a fractal height field over a square */
    FATHOM_GENERATE_SPONGE,  /* a Menger sponge of instanced cells */
    FATHOM_GENERATE_FOREST   /* a terrain with instanced trees */
} fathom_generator;

typedef struct fathom_generate_options {
    size_t size;
    fathom_generator kind;
    /* Number of triangles, instances included; default 1e6. The result has the nearest number that the
     * kind allows. Sphere and terrain store all of them: [1, 4e9]. Sponge and forest: [1, 1e11]. */
    uint64_t triangles;
    uint64_t seed;
    fathom_id material; /* 0 (default) or FATHOM_NONE: material 0; a forest gets materials of its own */
} fathom_generate_options;

FATHOM_DEFAULT(fathom_generate_options)
/* Adds the generated geometry to a group, about 2 units across around the origin, y up. Same options, same
 * mesh, on any thread count and machine.
 * FATHOM_BAD_USAGE when an option is out of range; FATHOM_OUT_OF_RESOURCES, before anything is made, when a
 * mesh would not fit the memory that is free. */
FATHOM_API fathom_status fathom_scene_generate(fathom_scene *scene, fathom_id group,
                                               const fathom_generate_options *options);
/* Writes the scene. The format follows the extension. .json: all of it; images that are not in the folder
 * of `path` or below are copied next to it, and numbers out of the file's ranges become the nearest. .glb:
 * meshes, instances as nodes, materials, images, lights and the camera, as far as glTF has them. Classic
 * materials become their nearest metallic-roughness ones. .obj (with an .mtl, and images, next to it) and
 * .ply (binary): meshes with instances placed; positions become float there. Quads become two triangles in
 * all but .json, and spheres up to 16,128 with smooth normals: fewer from 249 spheres on. It does not write
 * what fathom_scene_complete() added, because reading adds it again. For each kind of other content that the
 * format cannot hold, one warning has the count. Files appear whole or not at all. FATHOM_BAD_USAGE: unknown
 * extension; no shapes but planes, unless .json; or more than the format can count (4 GiB of .glb, 2^32
 * vertices); FATHOM_OUT_OF_RESOURCES: cannot be written. */
FATHOM_API fathom_status fathom_scene_write(const fathom_scene *scene, const char *path);

#ifdef __cplusplus
}
#endif
#endif
