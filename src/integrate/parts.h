/* Which parts of the renderer a scene needs, and descriptions of those that it does not. */
#pragma once

#include "film/film.h"
#include "scene/world/world.h"

#include <fathom/render.h>

/* MATERIAL_ bits of the materials in use. */
unsigned parts_features(const fathom_scene *scene);

/* True if only the background can be seen: every surface passes all light, and adds none. */
bool parts_all_transparent(const fathom_scene *scene, fathom_integrator integrator);

/* Longest text of a warning, with its end. */
#define PARTS_TEXT 256

/* True if the integrator follows light paths, and some materials reflect more light than they receive,
 * which the classic model allows. `text` then says how many there are, and which is the worst. */
bool parts_brighten(const fathom_scene *scene, fathom_integrator integrator, char text[PARTS_TEXT]);

bool parts_light(const fathom_light *light);      /* it is not black */
bool parts_background(const fathom_scene *scene); /* it is not black */
bool parts_ambient(const fathom_scene *scene);    /* the ambient light is not black */
bool parts_smooth(const world *w);                /* a mesh has shading normals */
bool parts_bounces(const fathom_scene *scene, const fathom_settings *settings);

/* The parts that a render does not use, and why. repair: whether trace/watertight is in use. False if out of
 * memory. */
bool left_out_find(const world *w, const fathom_settings *settings, bool repair, left_out_list *out);
