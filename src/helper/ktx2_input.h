/* Opens image files: KTX 2.0 by this program's own reader, everything else by OpenImageIO's. */
#pragma once

#include <OpenImageIO/imageio.h>

#include <memory>
#include <string>

/* NULL if OpenImageIO cannot read the file: the reason is OIIO::geterror()'s. Throws `failure` for a KTX 2.0
 * file that cannot be read. */
std::unique_ptr<OIIO::ImageInput> image_input_open(const std::string &name, const OIIO::ImageSpec &config);

/* An image_transfer, of files that say it. */
#define IMAGE_INPUT_TRANSFER "fathom:transfer"
