/* Where fathom_image.so is. */
#ifndef IMAGE_MODULE_FIND_H
#define IMAGE_MODULE_FIND_H

#include <fathom/base.h>
#include <stdbool.h>

/* Why there is no module; text: "" while there is no reason against it. */
typedef struct module_trouble {
    fathom_status status;
    char text[1024];
} module_trouble;

void module_trouble_say(module_trouble *why, fathom_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* To be called before a load begins, since it waits for one that is under way: notes where this code's own
 * file is. */
void module_find_begin(void);
/* The path of the module, in `path` of PATH_MAX; false with a reason when there is none. */
bool module_find(char *path, module_trouble *why);

#endif
