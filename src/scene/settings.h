/* The tables of settings and of material parameters. Adding one is a line there and a member in the struct.
 */
#ifndef SCENE_SETTINGS_H
#define SCENE_SETTINGS_H

#include "base/parameter.h"

extern const parameter_table settings_table, classic_table, metallic_table;
/* The parameters of a model. */
parameter_table material_table(fathom_model model);

/* The settings that pixels depend on, "max depth=8; epsilon=auto; ", and zeros to the end: for headers and
 * checkpoints. */
enum { SETTINGS_TEXT = 1024 };
void settings_print(const fathom_settings *settings, char out[SETTINGS_TEXT]);

#endif
