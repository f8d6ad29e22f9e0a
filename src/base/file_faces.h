/* Six files with the faces of a cube, named by one path with "<FACE>" in it. */
#pragma once

#include "base/status.h"

#define FILE_FACE "<FACE>"
enum { FILE_FACES = 6 };

/* The files of a path: the path itself, or the faces towards +x, -x, +y, -y, +z and -z. */
typedef struct file_faces {
    char *paths[FILE_FACES];
    unsigned count; /* 1 or FILE_FACES; after a failure 0 */
} file_faces;

/* "<FACE>" becomes px nx py ny pz nz, else posx negx posy negy posz negz, else right left top bottom front
 * back: the first of these whose first file exists. FATHOM_BAD_INPUT when none does, or another face is
 * missing. A path without "<FACE>" need not exist. Release with file_faces_close(). */
fathom_status file_faces_open(fathom_context *context, const char *path, file_faces *out);
void file_faces_close(file_faces *files);

/* `pattern` with px, nx, py, ny, pz or nz in place of each "<FACE>". Release with free(). NULL: no memory. */
char *file_face_name(const char *pattern, unsigned face);
