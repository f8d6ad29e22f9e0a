#include "cli/render/left_out.h"

#include <stdio.h>
#include <string.h>

bool left_out_image_module(left_out_list *list) {
    return left_out_tell(list, "image helper", "PNG in the built-in sRGB view is written without it");
}

void left_out_print(const fathom_left_out *items, uint32_t count, const char *title) {
    for (uint32_t i = 0; i < count; ++i)
        printf("%-*s%s: %s\n", (int)strlen(title), i ? "" : title, items[i].what, items[i].why);
}

json_t *left_out_json(const fathom_left_out *items, uint32_t count) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < count; ++i) {
        json_array_append_new(array, json_pack("{s:s, s:s}", "what", items[i].what, "why", items[i].why));
    }
    return array;
}
