#include <fathom/render.h>

void fathom_write_options_default(fathom_write_options *options) {
    if (options) *options = (fathom_write_options){.exposure = 0};
}
