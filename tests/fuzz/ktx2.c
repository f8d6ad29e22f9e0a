/* KTX 2.0 files, as the image helper decodes them: all rows of images of up to 256 x 256 texels. */
#include "fuzz.h"

#include "helper/ktx2/ktx2.h"

enum { SIDE = 256 };

static void judge(fathom_status status, const image_message *why) {
    if (status != FATHOM_OK && status != FATHOM_BAD_INPUT) fuzz_wrong("status %d", (int)status);
    if (status != FATHOM_OK && !why->text[0]) fuzz_wrong("refused without a reason");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    image_message why = {""};
    ktx2_image k;
    ktx2_rows *rows = NULL;
    uint8_t row[SIDE * 4];
    unsigned any = 0;
    /* Eight bits of BasisLZ can be 134 codes of the same length, which take two bytes each. */
    fuzz_begin(size, 320);
    fathom_status status = ktx2_open(data, size, &k, &why);
    judge(status, &why);
    if (status == FATHOM_OK && k.width <= SIDE && k.height <= SIDE) {
        /* Zstandard's own memory. */
        fuzz_add_size(k.packing == KTX2_ZSTD ? 1024 : 0);
        status = ktx2_rows_open(&k, &rows, &why);
        judge(status, &why);
        for (uint32_t y = 0; status == FATHOM_OK && y < k.height; ++y) {
            status = ktx2_rows_next(rows, row, &why);
            judge(status, &why);
            for (uint32_t i = 0; status == FATHOM_OK && i < k.width * k.channels; ++i) any |= row[i];
        }
        ktx2_rows_close(rows);
    }
    if (any > 255) fuzz_wrong("a texel is beyond a byte");
    fuzz_end();
    return 0;
}
