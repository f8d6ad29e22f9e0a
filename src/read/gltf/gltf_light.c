/* Lights: KHR_lights_punctual.
 *
 * The format gives the intensity I of points and spots in candela (lm/sr) and the illuminance of directional
 * lights in lux (lm/m^2). A surface of base colour b at distance d then has the luminance
 * L = (b / pi) (I / d^2) |n·l|; the model computes C = k_d (k_l / d^2) |n·l| with k_d = b. Both agree with
 * k_l = colour I / pi, and likewise for directional lights. So a pixel holds the luminance in cd/m^2 for
 * lengths in metres. Highlights are normalised like b / pi (see gltf_material.c).
 *
 * Only lamps of Blender are rescaled. Since version 3.4 it writes 683 lm for each watt, so a lamp of 1000 W
 * becomes 54,351 cd, but it writes the radiance of emission unchanged. Its importer converts back to watts,
 * and so does this reader: otherwise emission would be 683 times too dark compared with lamps. Files for
 * viewers that ignore units, and files of earlier versions, have values of about 1 to 100.
 *
 * `range` is ignored: light falls off by 1 / d^2 without limit. A spot's falloff between its cones is
 * Fathom's own. Lights point along their node's -z axis; the node's scale only affects the position. */
#include "base/text.h"
#include "read/gltf/gltf_pose.h"
#include "read/gltf/gltf_tree.h"

#include <math.h>
#include <string.h>

/* False, with a note, if the type is unknown. */
static bool read_type(gltf *g, const gltf_value *at, fathom_light_type *out) {
    static const fathom_light_type types[] = {FATHOM_LIGHT_POINT, FATHOM_LIGHT_DIRECTIONAL,
                                              FATHOM_LIGHT_SPOT};
    const char *type = "";
    gltf_text(g, at, "type", &type);
    const int found = words_find("point|directional|spot", type, strlen(type));
    if (found >= 0) *out = types[found];
    if (found >= 0) return true;
    gltf_note(g, at, "type", "a light of the type \"%.40s\" is left out; expected point, directional or spot",
              type);
    return false;
}

/* False: the light emits nothing. */
static bool read_cone(gltf *g, const gltf_value *at, fathom_light *out) {
    gltf_value spot;
    double inner = 0, outer = M_PI / 4;
    /* One float ulp above pi/2, because exporters write this number for a right angle. */
    const double right_angle = 1.57079637050628662;
    gltf_object(g, at, "spot", &spot);
    gltf_number(g, &spot, "innerConeAngle", 0, right_angle, &inner);
    gltf_number(g, &spot, "outerConeAngle", 0, right_angle, &outer);
    out->inner_angle = (float)inner;
    out->outer_angle = (float)outer;
    if (!(out->outer_angle > 0)) {
        gltf_note(g, &spot, NULL, "outerConeAngle: expected more than 0; the light is left out");
        return false;
    }
    if (!(out->inner_angle < out->outer_angle)) {
        gltf_note(g, &spot, NULL,
                  "innerConeAngle: expected less than outerConeAngle; the spot has a sharp edge");
        out->inner_angle = nextafterf(out->outer_angle, 0);
    }
    return true;
}

/* The factor by which Blender since 3.4 multiplied intensities. The user may have turned this off; the file
 * does not say. */
static double lumens_a_watt(gltf *g, const gltf_value *at) {
    if (gltf_blender(g) < 3004) return 1;
    gltf_note(g, at, "intensity",
              "is divided by 683 lm/W, because Blender writes emission in watts, but lights in lumens");
    return 683;
}

static bool read_light(gltf *g, const gltf_value *at, fathom_light *out) {
    double color[3] = {1, 1, 1}, intensity = 1;
    fathom_light_default(out);
    if (!read_type(g, at, &out->type)) return false;
    gltf_text(g, at, "name", &out->name);
    gltf_numbers(g, at, "color", 3, 0, INFINITY, color);
    gltf_number(g, at, "intensity", 0, INFINITY, &intensity);
    if (out->type == FATHOM_LIGHT_SPOT && !read_cone(g, at, out)) return false;
    intensity /= lumens_a_watt(g, at);
    for (int i = 0; i < 3; ++i) out->intensity[i] = (float)(color[i] * intensity / M_PI);
    if (json_object_get(at->json, "range"))
        gltf_note(g, at, "range", "the range of lights is ignored; they fall off for ever");
    return gltf_fine(g);
}

void gltf_light_place(gltf *g, const gltf_value *node, const gltf_way *way) {
    const affine_f64 middle = gltf_way_middle(way), *to_world = &middle;
    gltf_value extensions, punctual, at;
    uint32_t index = GLTF_ABSENT;
    fathom_light light;
    gltf_extension(g, node, "KHR_lights_punctual", &extensions, &punctual);
    gltf_index(g, &punctual, "light", &g->lights, &index);
    if (index == GLTF_ABSENT) return;
    gltf_item(g, &g->lights, index, &at);
    if (!read_light(g, &at, &light)) return;
    if (gltf_way_moves(way))
        gltf_note_node(g, (uint32_t)node->at.index,
                       "a light moves while the shutter is open, and is not blurred; " GLTF_HELD);
    const vec3_f64 along = affine_vector(to_world, (vec3_f64){0, 0, -1});
    if (light.type != FATHOM_LIGHT_POINT && !(length_f64(along) > 0)) {
        gltf_note(g, node, NULL, "a light is scaled to nothing, and left out");
        return;
    }
    if (!light.name) light.name = gltf_name(node->json);
    store_f64(light.position, scale_f64(gltf_unit(g), affine_point(to_world, (vec3_f64){0, 0, 0})));
    store_f64(light.direction, normalize_f64(along));
    gltf_within(g, node, NULL, fathom_scene_add_light(g->scene, &light, NULL));
}
