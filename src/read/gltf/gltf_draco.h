/* The Draco helper's output: a draco_head; three indices for each face; for each attribute a draco_attribute,
 * followed by `components` floats for each point. */
#pragma once

#include <stdint.h>

#define DRACO_MAGIC 0x4f435244u /* "DRCO" */
#define DRACO_SECONDS 60        /* CPU seconds for one mesh */
#define DRACO_MEMORY (UINT64_C(8) << 30)
#define DRACO_COMPONENTS_MAX 4

typedef struct draco_head {
    uint32_t magic, points, faces, attributes;
} draco_head;

typedef struct draco_attribute {
    uint32_t id, components;
    uint32_t normalized; /* integers were divided by the maximum of their type */
} draco_attribute;
