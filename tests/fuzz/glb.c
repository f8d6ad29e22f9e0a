/* Binary glTF. */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_put_file(0, "a.glb", data, size);
    fuzz_scene("a.glb", size, 256);
    return 0;
}
