/* glTF as JSON. */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_put_file(0, "a.gltf", data, size);
    fuzz_scene("a.gltf", size, 256);
    return 0;
}
