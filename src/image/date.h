/* The date in image files. */
#ifndef IMAGE_DATE_H
#define IMAGE_DATE_H

#include "base/status.h"

typedef struct image_date {
    char text[24]; /* "2026:11:22 16:45:33" */
} image_date;

/* Whether $SOURCE_DATE_EPOCH is set, so that equal renders are to be equal files: nothing in them may tell
 * when or how fast they were made (reproducible-builds.org/specs/source-date-epoch). */
bool date_is_given(void);

/* What $SOURCE_DATE_EPOCH says, seconds since 1970 in UTC; an empty text when it is not set. FATHOM_BAD_USAGE
 * when it is no such number. */
fathom_status date_read(fathom_context *context, image_date *out);

#endif
