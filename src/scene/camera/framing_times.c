#include "scene/camera/framing_times.h"

#include "scene/motion/motion.h"

enum { EVEN_TIMES = 17 };

/* Adds the times of keys while the shutter is open, each once. */
static void add_keys(const double shutter[2], const double *keys, uint32_t count, framing_times *times) {
    for (uint32_t k = 0; k < count; ++k) {
        bool known = !(keys[k] > shutter[0] && keys[k] < shutter[1]);
        for (uint32_t i = 0; i < times->count && !known; ++i) known = times->items[i] == keys[k];
        if (!known && times->count < FRAMING_TIMES_MOST) times->items[times->count++] = keys[k];
    }
}

void framing_choose_times(const fathom_scene *scene, framing_times *times) {
    const double *shutter = scene->camera.shutter;
    *times = (framing_times){{shutter[0]}, 1};
    bool moves = false;
    for (size_t i = 0; i < scene->instances.count; ++i) {
        const fathom_instance *instance = &scene->instances.items[i];
        if (!motion_is_moving(instance, shutter)) continue;
        moves = true;
        add_keys(shutter, instance->key_times, instance->key_count, times);
    }
    for (size_t i = 0; i < scene->meshes.count && shutter[1] > shutter[0]; ++i) {
        const fathom_mesh *mesh = &scene->meshes.items[i];
        moves |= mesh->key_count > 1;
        add_keys(shutter, mesh->key_times, mesh->key_count, times);
    }
    if (times->count > FRAMING_TIMES_MOST - EVEN_TIMES) times->count = FRAMING_TIMES_MOST - EVEN_TIMES;
    for (int i = 1; i < EVEN_TIMES && moves; ++i)
        times->items[times->count++] = shutter[0] + (shutter[1] - shutter[0]) * i / (EVEN_TIMES - 1);
}
