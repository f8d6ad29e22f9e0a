/* OBJ, and after the first byte 0xff, which no text has, the MTL file that it may name. */
#include "fuzz.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const uint8_t *mark = size ? memchr(data, 0xff, size) : NULL;
    size_t first = mark ? (size_t)(mark - data) : size, rest = mark ? size - first - 1 : 0;
    fuzz_put_file(0, "a.obj", data, first);
    fuzz_put_file(1, mark ? "a.mtl" : NULL, mark ? mark + 1 : NULL, rest);
    /* A point takes two bytes and becomes a ball of 960, with its colours; its index is kept two times. */
    fuzz_scene("a.obj", size, 576);
    return 0;
}
