#include "job/lacks.h"

#include "integrate/parts.h"

#include <stdio.h>
#include <stdlib.h>

typedef struct teller {
    void (*tell)(void *user, const char *text);
    void *user;
} teller;

/* Reports the text and the number, unless the number is 0. */
static void count(const teller *t, const char *text, unsigned long long number) {
    char line[PARTS_TEXT];
    if (!number) return;
    snprintf(line, sizeof line, "%.200s: %llu", text, number);
    t->tell(t->user, line);
}

static size_t count_one_sided(const fathom_scene *scene) {
    size_t found = 0;
    for (size_t i = 0; i < scene->materials.count; ++i)
        found += material_is_one_sided(&scene->materials.items[i].value);
    return found;
}

/* Groups that no group holds. 0 when out of memory. */
static size_t count_unplaced(const fathom_scene *scene) {
    bool *placed = calloc(scene->groups.count, sizeof *placed);
    size_t found = 0;
    for (size_t i = 0; placed && i < scene->instances.count; ++i)
        placed[scene->instances.items[i].group] = true;
    for (size_t g = FATHOM_ROOT + 1; placed && g < scene->groups.count; ++g) found += !placed[g];
    free(placed);
    return found;
}

/* Only `path` renders these. */
static void find_classic(const teller *t, const fathom_scene *scene) {
    count(t, "environments are ignored: only the integrator `path` renders them", scene->environments.count);
    count(t, "one-sided materials whose back is shown, because only path tracing looks through it",
          count_one_sided(scene));
}

void lacks_find(const world *w, fathom_integrator integrator, void (*tell)(void *user, const char *text),
                void *user) {
    const fathom_scene *scene = w->scene;
    const teller t = {tell, user};
    char text[PARTS_TEXT];
    count(&t, "triangles without area that are left out", w->degenerate_triangles);
    snprintf(text, sizeof text, "shapes and triangles beyond %g from the origin, which Embree leaves out",
             WORLD_REACH);
    count(&t, text, w->beyond_reach);
    count(&t, "groups that no instance places, and no image shows", count_unplaced(scene));
    if (parts_all_transparent(scene, integrator))
        tell(user, "all surfaces are fully transparent: nothing but the background can be seen");
    if (integrator == FATHOM_INTEGRATOR_CLASSIC)
        find_classic(&t, scene);
    else if (parts_ambient(scene) && !scene->made.ambient)
        tell(user,
             "ambient light is ignored: only the integrator `classic` has it; use a background instead");
    if (parts_brighten(scene, integrator, text)) tell(user, text);
}
