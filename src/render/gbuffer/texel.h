// Decoding of G-buffer texels on the host.
#pragma once

#include <volk.h>

#include <cstddef>

#include "render/gbuffer/layout.h"

namespace latelight::render {

// Returns one texel as a shader reads it: normalized and float formats in f (sRGB decoded), integers in u.
TargetValue decodeTexel(VkFormat format, const std::byte* texel);

}  // namespace latelight::render
