/* An image helper that can read no image, so that textures with two images take the other one. The linker
 * hands the library's questions to it (--wrap): a process for each execution would be slow. */
#include "image/helper/helper.h"

#include <stdio.h>

fathom_status __wrap_helper_ask(helper_exchange *e);

fathom_status __wrap_helper_ask(helper_exchange *e) {
    snprintf(e->reply.text, sizeof e->reply.text, "no image can be read");
    e->process = 1;
    return FATHOM_BAD_INPUT;
}
