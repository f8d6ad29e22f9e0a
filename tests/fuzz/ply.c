/* PLY, text and binary. */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_put_file(0, "a.ply", data, size);
    /* An edge takes two bytes and becomes a rod of 792, with its colours. */
    fuzz_scene("a.ply", size, 448);
    return 0;
}
