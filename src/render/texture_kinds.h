// lavapipe compiles a shader anew, 0.1 s each, for every combination of what it takes for granted of the textures that
// a draw binds: their samplers and formats, and whether widths and heights are powers of two. A scene of a hundred
// materials has nearly as many of these as materials, unless its textures are made alike where that changes nothing in
// the picture.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "scene/scene.h"
#include "vk/device.h"

namespace latelight::render {

// Whether sizes of these textures are of several kinds, on a device to which that matters, and all of them together are
// not too large for it. Then those with a power of two get an odd base (vk::ImageDesc::oddBase), whose size is the one
// that counts.
bool makesSizesAlike(const vk::Device& device, const std::vector<scene::Texture>& textures);

// Whether a texture of that size is one to give an odd base; not where this would be larger than the device allows.
bool getsOddBase(const vk::Device& device, uint32_t width, uint32_t height);

// Of a material. Nothing: any will do, since no material with these samplers has a texture there.
using SlotSamplers = std::array<std::optional<scene::Sampler>, shared::kTextureCount>;

// The samplers of each material's slots, in few combinations: a slot without a texture takes any, so it takes what a
// material with more textures has there.
std::vector<SlotSamplers> slotSamplers(const std::vector<scene::Material>& materials);

}  // namespace latelight::render
