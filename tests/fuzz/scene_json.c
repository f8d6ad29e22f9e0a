/* Scene JSON. It may ask for any number of generated triangles in a few bytes: here for a few alone, which
 * count as so many bytes of input. */
#include "fuzz.h"

#include "read/read.h"

#define TRIANGLES_MOST 200

__typeof__(fathom_scene_generate) __real_fathom_scene_generate, __wrap_fathom_scene_generate;

fathom_status __wrap_fathom_scene_generate(fathom_scene *scene, fathom_id group,
                                           const fathom_generate_options *options) {
    fathom_generate_options few = *options;
    /* Sponges and forests store more than a few triangles, however few are asked for. */
    if (few.triangles > TRIANGLES_MOST) few.triangles = TRIANGLES_MOST;
    if (few.kind == FATHOM_GENERATE_SPONGE || few.kind == FATHOM_GENERATE_FOREST)
        few.kind = FATHOM_GENERATE_TERRAIN;
    fuzz_add_size(TRIANGLES_MOST);
    return __real_fathom_scene_generate(scene, group, &few);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_put_file(0, "a.json", data, size);
    fuzz_scene("a.json", size, 256);
    return 0;
}
