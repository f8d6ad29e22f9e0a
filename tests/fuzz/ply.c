/* PLY, text and binary. */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_put_file(0, "a.ply", data, size);
    fuzz_scene("a.ply", size, 320);
    return 0;
}
