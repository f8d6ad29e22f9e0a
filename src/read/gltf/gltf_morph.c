/* Morph targets: base + sum of weight times target, for positions, normals and the directions of tangents. */
#include "base/threads.h"
#include "read/gltf/gltf.h"

#include <stdlib.h>
#include <string.h>

typedef struct morph {
    const gltf_elements *base, *target;
    unsigned components; /* of the base; those beyond the third stay */
    float weight;
    float *to;
} morph;

static const float *element(const gltf_elements *e, size_t i) {
    return (const float *)(const void *)((const char *)e->values + e->stride * i);
}

static void copy_base(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    const morph *m = user;
    for (size_t i = begin; i < end; ++i)
        memcpy(m->to + i * m->components, element(m->base, i), m->components * sizeof(float));
}

static void add_target(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    const morph *m = user;
    for (size_t i = begin; i < end; ++i) {
        const float *delta = element(m->target, i);
        for (unsigned c = 0; c < 3; ++c) m->to[i * m->components + c] += m->weight * delta[c];
    }
}

/* The displacements of target k; *present is false where it has none of this attribute. */
static fathom_status read_target(gltf *g, const gltf_value *targets, size_t k, const char *key,
                                 uint32_t count, bool *present, gltf_elements *out) {
    gltf_value target;
    fathom_status status = gltf_item(g, targets, k, &target);
    if (status == FATHOM_OK)
        status = gltf_array_read(g, &target, key, 3,
                                 GLTF_TAKES_FLOAT | GLTF_TAKES_SIGNED | GLTF_TAKES_UNSIGNED, present, out);
    if (status != FATHOM_OK || !*present || out->count == count) return status;
    return gltf_fail(g, &target, key, "has %u entries; expected as many as the mesh has, %u", out->count,
                     count);
}

fathom_status gltf_morph(gltf *g, const gltf_value *primitive, const gltf_shape *shape, const char *key,
                         unsigned components, gltf_elements *floats, float *to) {
    gltf_value targets;
    const unsigned threads = fathom_context_threads(g->context);
    morph m = {.base = &(gltf_elements){.values = floats->values, .stride = floats->stride},
               .components = components};
    fathom_status status = gltf_array(g, primitive, "targets", &targets);
    for (size_t k = 0; k < gltf_count(&targets) && k < shape->weight_count && status == FATHOM_OK; ++k) {
        gltf_elements delta;
        bool present = false;
        m.weight = (float)shape->weights[k];
        if (m.weight == 0) continue;
        status = read_target(g, &targets, k, key, floats->count, &present, &delta);
        if (status != FATHOM_OK || !present) continue;
        if (!m.to) {
            void *memory = to;
            if (!to)
                status = gltf_allocate(g, primitive, NULL,
                                       (uint64_t)floats->count * components * sizeof(float), &memory);
            if (status != FATHOM_OK) return status;
            m.to = memory;
            loop_parallel(threads, floats->count, 1u << 14, copy_base, &m);
        }
        m.target = &delta;
        loop_parallel(threads, floats->count, 1u << 14, add_target, &m);
    }
    if (m.to) floats->values = m.to, floats->stride = components * sizeof(float);
    return status;
}

/* ---- weights ---- */

static fathom_status read_weights(gltf *g, const gltf_value *at, double **out, size_t *count) {
    gltf_value list;
    fathom_status status = gltf_array(g, at, "weights", &list);
    *count = gltf_count(&list);
    if (status != FATHOM_OK || !*count) return status;
    *out = malloc(*count * sizeof **out);
    if (!*out) return fail_memory(g->context, *count * sizeof **out);
    return gltf_numbers(g, at, "weights", *count, -1e30, 1e30, *out);
}

fathom_status gltf_weights_read(gltf *g, const gltf_pose *pose, const gltf_value *node,
                                const gltf_value *mesh, gltf_shape *out) {
    const bool posed = pose && pose->weights;
    const gltf_value *from = node && json_object_get(node->json, "weights") ? node : mesh;
    if (!posed) return read_weights(g, from, &out->weights, &out->weight_count);
    out->weights = malloc(pose->weight_count * sizeof *out->weights);
    if (!out->weights) return fail_memory(g->context, pose->weight_count * sizeof *out->weights);
    memcpy(out->weights, pose->weights, pose->weight_count * sizeof *out->weights);
    out->weight_count = pose->weight_count;
    return FATHOM_OK;
}
