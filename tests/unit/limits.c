/* Groups in groups, 10^4 deep, and a stack of 1 MB: the scene, its world and the tracers know no recursion
 * over it. */
#include "render.h"

#include <pthread.h>

#define DEPTH 10000

/* Each group holds the next, moved by 1 along x; the innermost holds a sphere. */
static fathom_id nest(stage *s, unsigned depth) {
    fathom_id inner = FATHOM_NONE;
    for (unsigned i = 0; i < depth; ++i) {
        const fathom_id group = new_group(s->scene, NULL);
        if (i == 0) {
            fathom_sphere sphere = default_sphere();
            sphere.radius = 0.5, sphere.material = stage_emitter(s, 1);
            assert_ok(s->context, fathom_scene_add_sphere(s->scene, group, &sphere, NULL));
        } else {
            fathom_instance instance = default_instance();
            instance.parent = group, instance.group = inner;
            instance.transform[3] = 1;
            assert_ok(s->context, fathom_scene_add_instance(s->scene, &instance, NULL));
        }
        inner = group;
    }
    return inner;
}

static void place(stage *s, fathom_id group) {
    fathom_instance instance = default_instance();
    instance.parent = FATHOM_ROOT, instance.group = group;
    assert_ok(s->context, fathom_scene_add_instance(s->scene, &instance, NULL));
}

static void *nested_renders(void *unused) {
    (void)unused;
    static const char *const tracers[] = {"embree", "linear", "bvh"};
    for (size_t i = 0; i < 3; ++i) {
        stage s = stage_open(3, 3);
        place(&s, nest(&s, DEPTH));
        stage_camera(&s, (double[3]){DEPTH - 1, 0, 5}, (double[3]){DEPTH - 1, 0, 0}, (double[3]){0, 1, 0},
                     0.7);
        s.settings.tracer = tracers[i];
        fathom_film *film = stage_render(&s);
        /* The sphere, of radius 0.5, fills the middle pixel, which is 1.2 wide, but for its corners. */
        assert_true(fathom_film_channel(film, "G")[4] > 0.3f);
        assert_near(fathom_film_channel(film, "G")[0], 0, 0);
    }
    return NULL;
}

UNIT_TEST(nesting_on_a_small_stack) {
    pthread_t thread;
    pthread_attr_t attributes;
    assert_int_equal(pthread_attr_init(&attributes), 0);
    assert_int_equal(pthread_attr_setstacksize(&attributes, (size_t)1 << 20), 0);
    assert_int_equal(pthread_create(&thread, &attributes, nested_renders, NULL), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    pthread_attr_destroy(&attributes);
}

/* A cycle of such length is told as one, by names cut short. */
UNIT_TEST(long_cycle) {
    stage s = stage_open(3, 3);
    fathom_id outer = nest(&s, DEPTH);
    fathom_instance instance = default_instance();
    instance.parent = 1, instance.group = outer;
    assert_ok(s.context, fathom_scene_add_instance(s.scene, &instance, NULL));
    place(&s, outer);
    assert_fails(s.context, fathom_scene_check(s.scene), FATHOM_BAD_INPUT, "cycle");
}

int main(void) { return unit_main(NULL, NULL); }
