/* fathom_scene_write(): chooses the format, and notes the data of the scene that it cannot hold. */
#include "write/write.h"

#include "base/text.h"
#include "scene/settings.h"

#include <stdlib.h>
#include <string.h>

/* ---- numbers that formats share ---- */

double write_blinn_exponent(const fathom_material *m) {
    switch (m->specular) {
    case FATHOM_SPECULAR_NONE: return 0;
    case FATHOM_SPECULAR_PHONG: return 4 * (double)m->shininess;
    case FATHOM_SPECULAR_BLINN: return (double)m->shininess;
    }
    return 0;
}

write_turn write_turn_of(const float m[6]) {
    const double a = (double)m[0], b = (double)m[1], c = (double)m[3], d = (double)m[4];
    write_turn t = {.scale = {a, d}};
    t.plain = a == 1 && d == 1 && b == 0 && c == 0 && m[2] == 0 && m[5] == 0;
    if (b == 0 && c == 0) return t;
    /* The columns are (cos, -sin) and (sin, cos), each times a scale. */
    t.radians = atan2(-c, a);
    t.scale[0] = hypot(a, c), t.scale[1] = b * sin(t.radians) + d * cos(t.radians);
    t.sheared = fabs(a * b + c * d) > 1e-5 * t.scale[0] * fabs(t.scale[1]);
    return t;
}

/* ---- what formats cannot hold ---- */

typedef enum format_id { GLB = 1, PLY = 2, OBJ = 4, JSON = 8 } format_id;
#define MODELS (GLB | PLY | OBJ)
#define MESHES (PLY | OBJ)
#define ALL (MODELS | JSON)

static size_t count_copies(const size_t *ways, const fathom_scene *scene) {
    size_t copies = 0;
    for (size_t i = 1; i < scene->groups.count; ++i) copies += ways[i] > 1 ? ways[i] : 0;
    return copies;
}

static size_t count_named(const fathom_scene *scene) {
    size_t count = 0;
    for (size_t i = 0; i < scene->objects.count; ++i) count += scene->objects.items[i].name != NULL;
    return count;
}

/* Does not count meshes of clear materials: the glTF reader makes them cast no shadow. */
static size_t count_shadowless(const fathom_scene *scene) {
    size_t count = 0;
    for (size_t i = 0; i < scene->meshes.count; ++i) {
        const fathom_mesh *mesh = &scene->meshes.items[i];
        count += mesh->flags & FATHOM_CASTS_NO_SHADOW &&
                 !material_is_clear(&scene->materials.items[mesh->material], scene->settings.integrator);
    }
    return count;
}

/* Models use integer colours as sRGB, and other maps as linear; alpha is the same in both. */
static bool has_own_space(const fathom_scene *scene, const fathom_map *map, int kind) {
    const fathom_color_space usual = material_map_is_color(kind) ? FATHOM_COLOR_AUTO : FATHOM_COLOR_LINEAR;
    const fathom_color_space space = scene->textures.items[map->texture].color_space;
    const bool color = usual == FATHOM_COLOR_AUTO && space == FATHOM_COLOR_SRGB;
    return space == FATHOM_COLOR_NAMED || (space != usual && !color && map->channel != 3);
}

static bool is_sheared(const fathom_scene *scene, const fathom_map *map, int kind) {
    (void)scene, (void)kind;
    return write_turn_of(map->transform).sheared;
}

static bool repeats(const fathom_scene *scene, const fathom_map *map) {
    const fathom_texture *texture = &scene->textures.items[map->texture];
    return texture->wrap_u == FATHOM_WRAP_REPEAT && texture->wrap_v == FATHOM_WRAP_REPEAT;
}

/* Counts images of materials; NULL: all. */
static size_t count_maps(const fathom_scene *scene,
                         bool (*counts)(const fathom_scene *scene, const fathom_map *map, int kind)) {
    size_t count = 0;
    for (size_t i = 0; i < scene->materials.count; ++i) {
        for (int k = 0; k < FATHOM_MAPS; ++k) {
            const fathom_map *map = &scene->materials.items[i].value.maps[k];
            count += map->texture != FATHOM_NONE && (!counts || counts(scene, map, k));
        }
    }
    return count;
}

static size_t count_filters(const fathom_scene *scene, fathom_texture_filter first) {
    size_t count = 0;
    for (size_t i = 0; i < scene->textures.count; ++i)
        count += scene->textures.items[i].filter >= first &&
                 scene->textures.items[i].filter != FATHOM_TEXTURE_TRILINEAR;
    return count;
}

/* Number of meshes whose positions a float does not hold. */
static size_t count_far(const fathom_scene *scene) {
    size_t count = 0;
    for (fathom_id i = 0; i < scene->objects.count; ++i) {
        const scene_object *o = &scene->objects.items[i];
        const scene_bounds box = scene_object_bounds(scene, i);
        if (o->kind != SCENE_MESH || !write_is_far(&box)) continue;
        const double *origin = scene->meshes.items[o->index].origin;
        count += origin[0] != 0 || origin[1] != 0 || origin[2] != 0;
    }
    return count;
}

static size_t count_arrays(const fathom_scene *scene, mesh_kind kind) {
    size_t count = 0;
    for (size_t i = 0; i < scene->meshes.count; ++i)
        count += mesh_array_of(&scene->meshes.items[i], kind).values != NULL;
    return count;
}

/* Normals need no note: renders normalise them before they mix them. */
static size_t count_long_tangents(const fathom_scene *scene) {
    size_t count = 0;
    for (size_t i = 0; i < scene->meshes.count; ++i)
        count += write_has_lengths(&scene->meshes.items[i], MESH_TANGENTS);
    return count;
}

/* The sets of texture coordinates that a material's images need, as bits. */
static unsigned sets_of(const fathom_scene *scene, fathom_id material) {
    unsigned sets = 0;
    for (int k = 0; material != FATHOM_NONE && k < FATHOM_MAPS; ++k) {
        const fathom_map *map = &scene->materials.items[material].value.maps[k];
        if (map->texture != FATHOM_NONE) sets |= 1u << map->uv_set;
    }
    return sets;
}

/* Number of meshes in a group without the texture coordinates that their own images need, or `given` ones. */
static size_t count_bare_of(const fathom_scene *scene, const scene_graph *graph, uint32_t group,
                            unsigned given) {
    size_t count = 0;
    for (uint32_t i = graph->objects.first[group]; i < graph->objects.first[group + 1]; ++i) {
        const scene_object object = scene->objects.items[graph->objects.items[i]];
        if (object.kind != SCENE_MESH) continue;
        const fathom_mesh *m = &scene->meshes.items[object.index];
        const unsigned has = (m->uvs ? 1 : 0) | (m->uvs_1 ? 2 : 0);
        count += ((given | sets_of(scene, m->material)) & ~has) && !(m->point_radius > 0);
    }
    return count;
}

/* The same of the scene. The materials of instances replace those of the meshes in them. */
static fathom_status count_bare(const fathom_scene *scene, const scene_graph *graph, size_t *out) {
    unsigned *given = calloc(scene->groups.count, sizeof *given);
    *out = 0;
    if (!given) return fail_memory(scene->context, scene->groups.count * sizeof *given);
    for (uint32_t k = 0; k < graph->order_count; ++k) {
        const uint32_t g = graph->order[k];
        for (uint32_t i = graph->instances.first[g]; i < graph->instances.first[g + 1]; ++i) {
            const fathom_instance *instance = &scene->instances.items[graph->instances.items[i]];
            given[instance->group] |= given[g] | sets_of(scene, instance->material);
        }
        *out += count_bare_of(scene, graph, g, given[g]);
    }
    free(given);
    return FATHOM_OK;
}

fathom_settings write_usual_settings(const fathom_scene *scene) {
    fathom_settings usual;
    fathom_settings_default(&usual);
    const fathom_integrator integrator = usual.integrator;
    fathom_settings_set_integrator(&usual, scene->settings.integrator);
    usual.integrator = integrator;
    return usual;
}

static size_t count_settings(const fathom_scene *scene) {
    const fathom_settings usual = write_usual_settings(scene);
    size_t count = 0;
    for (size_t i = 0; i < settings_table.count; ++i) {
        const fathom_parameter *p = &settings_table.rows[i];
        bool same = !(p->flags & FATHOM_PARAMETER_FILE) || p->offset <= offsetof(fathom_settings, height);
        for (unsigned k = 0; k < parameter_count(p) && !same; ++k)
            count += same = parameter_number(p, &usual, k) != parameter_number(p, &scene->settings, k);
    }
    return count;
}

/* Number of vertices whose colour is above 1; with `opacities`, of those whose opacity is not 1. */
static size_t count_colors(const fathom_scene *scene, bool opacities) {
    size_t count = 0;
    for (size_t i = 0; i < scene->meshes.count; ++i) {
        const fathom_mesh *m = &scene->meshes.items[i];
        if (!m->colors || (opacities && m->color_channels < 4)) continue;
        for (size_t k = 0; k < m->vertex_count; ++k) {
            const float *c = mesh_row(m->colors, m->color_stride, k);
            count += opacities ? c[3] != 1 : c[0] > 1 || c[1] > 1 || c[2] > 1;
        }
    }
    return count;
}

/* Number of point clouds whose radius a reader of the format would not choose. */
static fathom_status count_radii(const fathom_scene *scene, const scene_graph *graph, format_id format,
                                 size_t *out) {
    *out = 0;
    if (format == JSON) return FATHOM_OK;
    return write_count_radii(scene, graph,
                             format == GLB   ? WRITE_CLOUDS_EACH
                             : format == OBJ ? WRITE_CLOUDS_BY_MATERIAL
                                             : WRITE_CLOUDS_ALL,
                             out);
}

static fathom_status note_lost(const fathom_scene *scene, const scene_graph *graph, const size_t *ways,
                               format_id format, note_list *notes) {
    const size_t lost_points = write_ply_lost_points(scene, ways);
    size_t radii = 0, stretched = 0, bare = 0;
    scene_bounds world;
    fathom_status status =
        format == PLY && lost_points ? FATHOM_OK : count_radii(scene, graph, format, &radii);
    if (status == FATHOM_OK) status = scene_world_bounds(scene, &world);
    if (status == FATHOM_OK) status = count_bare(scene, graph, &bare);
    if (status == FATHOM_OK && format & MESHES) status = write_count_stretched(scene, graph, &stretched);
    const bool far = status == FATHOM_OK && write_is_far(&world);
    const fathom_map *image = format == PLY ? write_ply_image(scene, graph) : NULL;
    const size_t cameras = scene->cameras.count, taken = cameras && scene->camera_taken != FATHOM_NONE;
    const struct {
        unsigned lacking;
        size_t count;
        const char *text;
    } facts[] = {
        {MESHES, count_copies(ways, scene),
         "a place of a group that is placed several times has triangles of its own"},
        {ALL, cameras - taken, "a camera that was not chosen is left out"},
        {ALL, scene->has_animations, "animation is not kept; the file has the pose of this time"},
        {ALL, scene->has_variants, "variants of materials are not kept; the chosen one is"},
        {ALL, count_maps(scene, is_sheared), "the shear of an image on a surface is left out"},
        {MESHES, scene->has_camera && !scene->made.camera, "the camera is left out"},
        {MESHES, scene->made.lights ? 0 : scene->lights.count, "a light is left out"},
        {MODELS, scene->has_lights && !scene->lights.count && !scene->environments.count,
         "an empty list of lights is left out: a render adds its own"},
        {MODELS, scene->environments.count, "an environment of light is left out"},
        {MODELS, scene->has_background && !scene->made.background, "the background is left out"},
        {MODELS, scene->has_ambient && !scene->made.ambient, "the ambient light is left out"},
        {MODELS, scene_moving(scene), "motion is left out; the file has the pose at which the shutter opens"},
        {MODELS, scene->grouped_lights.count, "a light group is left out"},
        {PLY, count_named(scene), "the name of a shape is left out"},
        {MODELS, count_shadowless(scene), "a mesh that casts no shadow casts one"},
        {MODELS, count_settings(scene), "a setting of the image is left out"},
        {MODELS, count_maps(scene, has_own_space),
         "the color space of an image is left out: colours are read as sRGB, and numbers as linear"},
        {GLB | OBJ, bare,
         "a mesh with images has no texture coordinates; readers show their colour at (0, 0)"},
        {OBJ, count_filters(scene, FATHOM_TEXTURE_NEAREST), "the filter of an image is left out"},
        {GLB, count_filters(scene, FATHOM_TEXTURE_STOCHASTIC),
         "the filter stochastic of an image is trilinear"},
        {PLY, scene->materials.count - 1, "a material is left out"},
        {PLY, count_maps(scene, NULL) - (image ? 1 : 0), "an image on a surface is left out"},
        {PLY, image && !repeats(scene, image),
         "an image that is clamped or mirrored repeats outside of itself"},
        {OBJ, count_colors(scene, false), "the colour of a vertex is cut to 1"},
        {OBJ, count_colors(scene, true), "the opacity of a vertex is left out"},
        {OBJ, count_arrays(scene, MESH_UVS_1), "the second uv set of a mesh is left out"},
        {MESHES, count_arrays(scene, MESH_TANGENTS), "the tangents of a mesh are left out"},
        {MESHES, stretched,
         "a smooth mesh that is stretched is shaded a little differently between vertices"},
        {GLB, count_long_tangents(scene),
         "the tangents of a mesh become unit vectors, and lie a little differently between vertices"},
        {far ? PLY : MESHES, count_far(scene), "a mesh far from the origin loses digits of its positions"},
        {PLY, lost_points, "a point is left out: a PLY file of triangles has no place for points"},
        {MODELS, radii,
         "the radius of a cloud of points is left out; readers find one by how many points lie how far "
         "apart"},
    };
    for (size_t i = 0; i < sizeof facts / sizeof *facts; ++i) {
        if (facts[i].lacking & format && facts[i].count)
            notes_add(notes, facts[i].count, "", "%s", facts[i].text);
    }
    return status;
}

/* Model formats hold only triangles and points: quads are written as triangles, and spheres approximated. */
static fathom_status check_shapes(const fathom_scene *scene, const size_t *ways, const char *path,
                                  note_list *notes) {
    size_t placed[4] = {0};
    for (size_t i = 0; i < scene->objects.count; ++i)
        placed[scene->objects.items[i].kind] += ways[scene->objects.items[i].group] > 0;
    if (placed[SCENE_SPHERE])
        notes_add(notes, placed[SCENE_SPHERE], "", "a sphere becomes triangles with smooth normals");
    if (placed[SCENE_PLANE]) notes_add(notes, placed[SCENE_PLANE], "", "a plane has no end, and is left out");
    if (placed[SCENE_MESH] || placed[SCENE_QUAD] || placed[SCENE_SPHERE]) return FATHOM_OK;
    return fail_file(scene->context, FATHOM_BAD_USAGE, path, "the scene holds no shape to write%s",
                     placed[SCENE_PLANE] ? " but planes without end"
                     : scene->hides      ? ": everything is hidden, or scaled to nothing at this time"
                                         : "");
}

/* ---- the format ---- */

static const struct format {
    const char *extension;
    format_id id;
    fathom_status (*write)(const fathom_scene *scene, const scene_graph *graph, const char *path,
                           note_list *notes);
} formats[] = {
    {"glb", GLB, write_glb}, {"ply", PLY, write_ply}, {"obj", OBJ, write_obj}, {"json", JSON, write_json}};

/* `written`: the scene, or a view of it without quads and spheres, which has the same groups. `graph` is that
 * of `written`. */
static fathom_status write_as(const fathom_scene *scene, const fathom_scene *written,
                              const scene_graph *graph, const struct format *format, const char *path) {
    note_list *notes = calloc(1, sizeof *notes);
    size_t *ways = NULL;
    fathom_status status = notes ? FATHOM_OK : fail_memory(scene->context, sizeof *notes);
    if (status == FATHOM_OK) status = write_count_ways(written, graph, &ways);
    if (status == FATHOM_OK && format->id != JSON) status = check_shapes(scene, ways, path, notes);
    /* Where all is hidden and no camera is given, the file could not be read again. */
    if (status == FATHOM_OK && format->id == JSON && scene->hides) status = fathom_scene_check(scene);
    if (status == FATHOM_OK) status = note_lost(written, graph, ways, format->id, notes);
    if (status == FATHOM_OK) status = format->write(written, graph, path, notes);
    if (status == FATHOM_OK) notes_tell(notes, scene->context, path);
    free(ways);
    free(notes);
    return status;
}

/* Numbers have a decimal point in every locale. */
static fathom_status write_in_c(const fathom_scene *scene, const fathom_scene *written,
                                const struct format *format, const char *path) {
    scene_graph graph;
    fathom_status status = graph_create(written, &graph);
    if (status != FATHOM_OK) return status;
    const locale_t own = text_locale_begin();
    status = write_as(scene, written, &graph, format, path);
    text_locale_end(own);
    graph_destroy(&graph);
    return status;
}

fathom_status fathom_scene_write(const fathom_scene *scene, const char *path) {
    if (!scene) return FATHOM_BAD_USAGE;
    if (!path) return fail_null(scene->context, "path");
    char extension[16];
    file_extension(path, extension);
    const size_t count = sizeof formats / sizeof *formats;
    size_t format = 0;
    while (format < count && strcmp(formats[format].extension, extension) != 0) ++format;
    if (format == count) {
        return fail_file(scene->context, FATHOM_BAD_USAGE, path,
                         "scenes are written as .glb, .json, .obj or .ply, found extension \"%s\"",
                         extension);
    }
    if (formats[format].id == JSON || scene->spheres.count + scene->quads.count == 0)
        return write_in_c(scene, scene, &formats[format], path);
    fathom_scene view;
    fathom_status status = write_shapes_as_meshes(scene, &view);
    if (status == FATHOM_OK) status = write_in_c(scene, &view, &formats[format], path);
    write_shapes_free(&view);
    return status;
}
