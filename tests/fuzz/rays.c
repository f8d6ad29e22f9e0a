/* Files of failing rays, as `fathom validate --replay` reads them. */
#include "fuzz.h"

#include "cli/validate/ray_line.h"

#include <stdlib.h>

static fathom_status read_all(const file_map *map) {
    const char *text = (const char *)map->bytes;
    ray_lines lines = {fuzz_context(), "a.rays", text, text + map->size, 0};
    ray_line line;
    for (;;) {
        unsigned before = lines.number;
        bool found;
        fathom_status status = ray_lines_next(&lines, &line, &found);
        if (status != FATHOM_OK || !found) return status;
        if (!line.scene[0] || !line.spec[0]) fuzz_wrong("a ray without scene or tracer");
        if (lines.number <= before) fuzz_wrong("line %u comes after line %u", lines.number, before);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    file_map map;
    if (!size) return 0;
    fuzz_put_file(0, "a.rays", data, size);
    fuzz_begin(size, 16);
    if (file_open(fuzz_context(), "a.rays", &map) != FATHOM_OK) abort();
    fuzz_judge(read_all(&map));
    file_close(&map);
    fuzz_end();
    return 0;
}
