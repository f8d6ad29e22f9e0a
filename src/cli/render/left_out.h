/* What a render does without, for people and for programs. */
#ifndef CLI_LEFT_OUT_H
#define CLI_LEFT_OUT_H

#include "integrate/parts.h"

#include <fathom/render.h>
#include <jansson.h>

/* Adds that the image helper is not started. False when out of memory. */
bool left_out_image_module(left_out_list *list);
/* A line each, the first behind `title`, the others below it. */
void left_out_print(const fathom_left_out *items, uint32_t count, const char *title);
/* [{"what": …, "why": …}, …] */
json_t *left_out_json(const fathom_left_out *items, uint32_t count);

#endif
