/* Fathom: a renderer whose every hit can be checked. The whole public API, except plugin.h, which plug-ins
 * include alone. */
#ifndef FATHOM_FATHOM_H
#define FATHOM_FATHOM_H

#include <fathom/base.h>
#include <fathom/file.h>
#include <fathom/image.h>
#include <fathom/parameter.h>
#include <fathom/part.h>
#include <fathom/ranks.h>
#include <fathom/read.h>
#include <fathom/render.h>
#include <fathom/scene.h>
#include <fathom/session.h>
#include <fathom/survey.h>
#include <fathom/texture.h>
#include <fathom/trace.h>

#endif
