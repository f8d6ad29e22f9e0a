/* Provenance of a result, for headers of images and for --stats. */
#ifndef CLI_PROVENANCE_H
#define CLI_PROVENANCE_H

#include <jansson.h>

/* The command line; the strings stay the caller's. */
void provenance_note(int argc, char **argv);

/* For headers, which travel with the image: quoted for a shell, without the folders of files, and "" when
 * $SOURCE_DATE_EPOCH asks for equal files of equal images. --stats has the exact arguments. */
const char *provenance_command(void);
/* For files of the user's own: all arguments as they were. */
json_t *provenance_arguments(void);

#endif
