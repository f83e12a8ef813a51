// Makes texture states uniform for lavapipe, which compiles a shader again for every combination of texture properties
// that it specializes for: samplers, formats, and whether widths and heights are powers of two. A scene of a hundred
// materials has nearly as many combinations as materials, unless its textures are made uniform where that does not
// change the picture.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "scene/scene.h"
#include "vk/device.h"

namespace latelight::render {

// Returns true if these textures have several kinds of sizes, the device specializes shaders for them, and their total
// size is not too large. Textures with a power-of-two side then get an odd base (vk::ImageDesc::oddBase), whose size is
// the one that counts.
bool unifiesTextureSizes(const vk::Device& device, const std::vector<scene::Texture>& textures);

// Returns true if a texture of that size should get an odd base: a side is a power of two, and the device supports
// images of the base's size.
bool getsOddBase(const vk::Device& device, uint32_t width, uint32_t height);

// Samplers of a material's slots. An empty slot accepts any sampler, because no material with these samplers has a
// texture there.
using SlotSamplers = std::array<std::optional<scene::Sampler>, shared::kTextureCount>;

// Returns the samplers of each material's slots, in few combinations: a slot without a texture uses the sampler that a
// material with more textures has there.
std::vector<SlotSamplers> slotSamplers(const std::vector<scene::Material>& materials);

}  // namespace latelight::render
