/* The volumes around each path of a wave: closed surfaces that the path has entered and not left. If volumes
 * overlap, the one of the highest priority fills the space (Schmidt & Budge, "Simple Nested Dielectrics in
 * Ray Traced Images", 2002); among equals, and without priorities, the one that was entered last. */
#pragma once

#include "film/squares.h"
#include "material/shader.h"

typedef struct media media;

/* shaders: by material; they must outlive the result. Release with free(). NULL if out of memory. */
media *media_create(const shader *shaders);
/* The path starts in these volumes, the innermost last; at most 8. */
void media_begin(media *m, uint32_t slot, const uint32_t *materials, uint32_t count);
/* The path crosses a surface of this material. */
void media_cross(media *m, uint32_t slot, uint32_t material, bool entering);
/* The path hits a surface of a material that has a priority. False: the surface is hidden, because another
 * volume fills the space on both of its sides. around: the index of the volume that fills the space outside
 * the surface. */
bool media_meet(const media *m, uint32_t slot, uint32_t material, bool entering, float *around);
/* The volume that fills the space outside of a surface of this material that the path hits; NULL: none. */
const shader *media_around(const media *m, uint32_t slot, uint32_t material, bool entering);
/* left: the transmittance over a distance, which may be INFINITY, through the volume: exp(-sigma length)
 * (Beer and Lambert). */
void media_left(const media *m, uint32_t slot, float length, float left[3]);
/* The same on the other side of a surface that the path hits. */
void media_left_behind(const media *m, uint32_t slot, uint32_t material, bool entering, float length,
                       float left[3]);
