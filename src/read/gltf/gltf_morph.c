/* Morph targets: base + sum of weight times target, for positions, normals and the xyz of tangents. */
#include "base/text.h"
#include "base/threads.h"
#include "read/gltf/gltf_data.h"
#include "read/gltf/gltf_mesh.h"
#include "read/gltf/gltf_pose.h"

#include <stdlib.h>
#include <string.h>

typedef struct morph {
    const gltf_elements *base, *target;
    unsigned components; /* of the base; those after the third are unchanged */
    float weight;
    float *to;
} morph;

static void copy_base(void *user, size_t begin, size_t end) {
    const morph *m = user;
    for (size_t i = begin; i < end; ++i)
        memcpy(m->to + i * m->components, gltf_element(m->base, i), m->components * sizeof(float));
}

static void add_target(void *user, size_t begin, size_t end) {
    const morph *m = user;
    for (size_t i = begin; i < end; ++i) {
        const float *delta = gltf_element(m->target, i);
        for (unsigned c = 0; c < 3; ++c) m->to[i * m->components + c] += m->weight * delta[c];
    }
}

/* Reads the displacements of target k; false if it has none for this attribute. */
static bool read_target(gltf *g, const gltf_value *targets, size_t k, const char *key, uint32_t count,
                        gltf_elements *out) {
    gltf_value target;
    gltf_item(g, targets, k, &target);
    if (!gltf_array_read(g, &target, key, 3, GLTF_TAKES_QUANTIZED, out)) return false;
    if (out->count != count)
        gltf_fail(g, &target, key, "has %u entries; expected as many as the mesh has, %u", out->count, count);
    return gltf_fine(g);
}

void gltf_morph(gltf *g, const gltf_value *primitive, const gltf_shape *shape, const char *key,
                unsigned components, gltf_elements *floats, float *to) {
    gltf_value targets;
    const unsigned threads = fathom_context_threads(g->context);
    const size_t bytes = components * sizeof(float);
    morph m = {.base = &(gltf_elements){.values = floats->values, .stride = floats->stride},
               .components = components};
    gltf_array(g, primitive, "targets", &targets);
    for (size_t k = 0; k < gltf_count(&targets) && k < shape->weight_count && gltf_fine(g); ++k) {
        gltf_elements delta;
        m.weight = (float)shape->weights[k];
        if (m.weight == 0 || !read_target(g, &targets, k, key, floats->count, &delta)) continue;
        if (!m.to) {
            void *memory = to;
            if (!to &&
                gltf_allocate(g, primitive, NULL, floats->count * (uint64_t)bytes, &memory) != FATHOM_OK)
                return;
            m.to = memory;
            loop_parallel(threads, floats->count, 1u << 14, copy_base, &m);
        }
        m.target = &delta;
        loop_parallel(threads, floats->count, 1u << 14, add_target, &m);
    }
    if (m.to) floats->values = m.to, floats->stride = bytes;
}

/* True if the target has a weight at any moment. */
static bool is_used(const gltf_shape *shapes, size_t moments, size_t target) {
    for (size_t m = 0; m < moments; ++m) {
        if (target < shapes[m].weight_count && shapes[m].weights[target] != 0) return true;
    }
    return false;
}

void gltf_morph_note(gltf *g, const gltf_value *primitive, const gltf_shape *shapes, size_t moments) {
    static const char followed[] = "POSITION|NORMAL|TANGENT";
    gltf_value targets, target;
    const char *key;
    json_t *value;
    gltf_array(g, primitive, "targets", &targets);
    for (size_t k = 0; k < gltf_count(&targets) && gltf_fine(g); ++k) {
        if (!is_used(shapes, moments, k)) continue;
        gltf_item(g, &targets, k, &target);
        json_object_foreach(target.json, key, value) {
            if (*key != '_' && words_find(followed, key, strlen(key)) < 0)
                gltf_note(g, &target, key, "morph targets of %.40s are ignored", key);
        }
    }
}

/* ---- weights ---- */

void gltf_weights_read(gltf *g, const gltf_pose *pose, const gltf_value *node, const gltf_value *mesh,
                       gltf_shape *out) {
    const bool posed = pose && pose->weights;
    const gltf_value *from = node && json_object_get(node->json, "weights") ? node : mesh;
    gltf_value list = {.json = NULL};
    if (!posed) gltf_array(g, from, "weights", &list);
    const size_t count = posed ? pose->weight_count : gltf_count(&list);
    if (!count || !gltf_fine(g)) return;
    out->weights = malloc(count * sizeof *out->weights);
    if (!out->weights) {
        gltf_fail_memory(g, count * sizeof *out->weights);
        return;
    }
    out->weight_count = count;
    if (posed)
        memcpy(out->weights, pose->weights, count * sizeof *out->weights);
    else
        gltf_numbers(g, from, "weights", count, -1e30, 1e30, out->weights);
}
