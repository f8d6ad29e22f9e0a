/* default_material() and so on: the public structs as their fathom_…_default() fills them in. */
#pragma once

#include <fathom/fathom.h>

#define DEFAULT(name)                                                                                        \
    static inline fathom_##name default_##name(void) {                                                       \
        fathom_##name value;                                                                                 \
        fathom_##name##_default(&value);                                                                     \
        return value;                                                                                        \
    }
DEFAULT(camera)
DEFAULT(checkpoint)
DEFAULT(generate_options)
DEFAULT(instance)
DEFAULT(light)
DEFAULT(material)
DEFAULT(mesh)
DEFAULT(part)
DEFAULT(plane)
DEFAULT(quad)
DEFAULT(read_options)
DEFAULT(session_options)
DEFAULT(settings)
DEFAULT(sphere)
DEFAULT(texture)
DEFAULT(write_options)
#undef DEFAULT
