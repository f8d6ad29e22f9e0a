/* Choices that a file offers by name or number: scenes, animations, variants of materials. */
#include "read/gltf/gltf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *name_of(const gltf_value *array, size_t i) {
    return gltf_name(json_array_get(array->json, i));
}

void gltf_print_names(const gltf_value *array, char out[GLTF_LIST]) {
    const size_t count = gltf_count(array), room = GLTF_LIST - 32; /* 32: "and N more" */
    size_t used = 0, i = 0;
    *out = '\0';
    for (; i < count; ++i) {
        char one[64];
        const char *name = name_of(array, i), *quote = name ? "\"" : "";
        const int length = snprintf(one, sizeof one, "%s%zu%s%s%.32s%s", i ? ", " : "", i, name ? " " : "",
                                    quote, name ? name : "", quote);
        if (used + (size_t)length >= room) break;
        memcpy(out + used, one, (size_t)length + 1);
        used += (size_t)length;
    }
    if (i < count) snprintf(out + used, GLTF_LIST - used, " and %zu more", count - i);
}

uint32_t gltf_choose(gltf *g, const gltf_value *array, const char *what, const char *wanted) {
    const size_t count = gltf_count(array), digits = strspn(wanted, "0123456789");
    size_t found = 0, first = 0;
    char list[GLTF_LIST];
    for (size_t i = 0; i < count; ++i) {
        const char *name = name_of(array, i);
        if (name && strcmp(name, wanted) == 0 && !found++) first = i;
    }
    if (found == 1) return (uint32_t)first;
    const unsigned long number = digits && digits < 10 && !wanted[digits] ? strtoul(wanted, NULL, 10) : count;
    if (!found && number < count) return (uint32_t)number;
    gltf_print_names(array, list);
    if (found)
        g->status = fail_file(g->context, FATHOM_BAD_USAGE, g->path,
                              "%zu %ss are called \"%.60s\"; expected the number of one of %s", found, what,
                              wanted, list);
    else
        g->status = fail_file(g->context, FATHOM_BAD_USAGE, g->path,
                              "there is no %s \"%.60s\"; expected one of %s", what, wanted, list);
    return GLTF_ABSENT;
}
