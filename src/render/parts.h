/* Which parts of the renderer a scene needs, and in words which it does without. */
#ifndef RENDER_PARTS_H
#define RENDER_PARTS_H

#include "scene/world/world.h"

#include <fathom/render.h>

/* MATERIAL_ bits of the materials in use. */
unsigned parts_features(const fathom_scene *scene);

/* Whether nothing but the background can be seen: every surface passes all light, and adds none. */
bool parts_all_transparent(const fathom_scene *scene);

/* What spots are held against: a ball around all points from which shadow rays may start. */
typedef struct parts_extent {
    bool known;      /* false: there is no spot, or no end to the scene */
    vec3_f64 center; /* the scene's coordinates */
    double radius;
} parts_extent;

parts_extent parts_extent_of(const world *w, const fathom_settings *settings);

typedef enum light_use { LIGHT_USED, LIGHT_BLACK, LIGHT_ASIDE } light_use;

/* LIGHT_ASIDE: a spot whose cone holds no point of the scene. */
light_use parts_light(const parts_extent *extent, const world *w, const fathom_light *light);

/* FATHOM_PART_ bits of what pixels depend on. LIGHTS and UNLIT are never among them, nor is REPAIR, which
 * depends on the tracer too. */
unsigned parts_needed(const world *w, const fathom_settings *settings);

typedef ARRAY(fathom_left_out) left_out_list;

/* One line more. Both: false when out of memory. */
bool left_out_tell(left_out_list *list, const char *what, const char *why);
/* What a render of these parts does without. */
bool left_out_find(const world *w, const fathom_settings *settings, unsigned parts, left_out_list *out);

#endif
