/* The tables of settings and of material parameters (parameters.c). To add one, add a row there and a member
 * to the struct. */
#pragma once

#include "base/parameter.h"

extern const parameter_table settings_table, classic_table, metallic_table;
/* The parameters of a model. */
parameter_table material_table(fathom_model model);

/* Writes the settings on which pixels depend, as "max depth=8; epsilon=auto; ", and zeros to the end. For
 * image headers and checkpoints. */
enum { SETTINGS_TEXT = 1024 };
void settings_print(const fathom_settings *settings, char out[SETTINGS_TEXT]);
