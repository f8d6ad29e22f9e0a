/* Opens image files: KTX 2.0 by this program's own reader, everything else by OpenImageIO's. */
#pragma once

#include "image/helper/module.h"

#include <OpenImageIO/imageio.h>

#include <memory>
#include <string>

/* NULL, with the reason, if OpenImageIO cannot read the file. Throws `failure` for a KTX 2.0 file that cannot
 * be read. */
std::unique_ptr<OIIO::ImageInput> image_input_open(const std::string &name, const OIIO::ImageSpec &config,
                                                   std::string *why);

inline OIIO::TypeDesc image_type_of(image_texel texel) {
    switch (texel) {
    case IMAGE_TEXEL_U8: return OIIO::TypeDesc::UINT8;
    case IMAGE_TEXEL_U16: return OIIO::TypeDesc::UINT16;
    case IMAGE_TEXEL_HALF: return OIIO::TypeDesc::HALF;
    case IMAGE_TEXEL_FLOAT: break;
    }
    return OIIO::TypeDesc::FLOAT;
}

/* An image_transfer, of files that say it. */
#define IMAGE_INPUT_TRANSFER "fathom:transfer"
