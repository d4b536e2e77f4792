// Pictures as files. The one part of the library that needs OpenImageIO.
#pragma once

#include <filesystem>

#include "facetsort/base/status.h"
#include "facetsort/blend/image.h"

namespace facetsort {

// By extension: .exr keeps linear, premultiplied float32 RGBA to the bit; .png is sRGB-encoded, 8 bits a channel,
// straight alpha (what the format asks for), values outside 0..1 clamped. Written under a temporary name and renamed.
// Refuses other extensions (unsupported_format) and pictures without pixels (bad_argument).
Status write_image(const std::filesystem::path& path, const Image& image);

}  // namespace facetsort
