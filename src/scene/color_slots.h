// The texture slots of materials that hold colors.
#pragma once

#include <cstdint>

#include "shared/types.h"

namespace latelight::scene {

// Returns true if texels of the slot are in sRGB (glTF 2.0, section 3.9, and its material extensions). Those of all
// other slots are linear.
inline bool isColorSlot(uint32_t slot) {
  constexpr uint32_t kColors = 1u << shared::kTextureBaseColor | 1u << shared::kTextureEmissive |
                               1u << shared::kTextureSpecularColor | 1u << shared::kTextureSheenColor |
                               1u << shared::kTextureDiffuseTransmissionColor;
  return (kColors >> slot & 1u) != 0;
}

}  // namespace latelight::scene
