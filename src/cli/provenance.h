/* Provenance of a result, for headers of images and for --stats. */
#pragma once

#include <jansson.h>

/* Stores the command line. The strings must stay valid. */
void provenance_note(int argc, char **argv);

/* The command for image headers, which are passed on with the image: quoted for a shell, without the folders
 * of files. "" if $SOURCE_DATE_EPOCH is set, so that equal images give equal files. --stats has the exact
 * arguments. */
const char *provenance_command(void);
/* The unchanged arguments, for the user's own files. */
json_t *provenance_arguments(void);
