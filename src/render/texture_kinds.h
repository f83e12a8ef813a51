// lavapipe recompiles a shader, 0.1 s each, for every combination of texture properties that it specializes for:
// samplers, formats, and whether widths and heights are powers of two. A scene of a hundred materials has nearly as
// many combinations as materials, unless its textures are made uniform where that changes nothing in the picture.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "scene/scene.h"
#include "vk/device.h"

namespace latelight::render {

// Whether these textures have several kinds of sizes, on a device where that matters, and their total size is not too
// large. Then those with a power of two get an odd base (vk::ImageDesc::oddBase), whose size is the one that counts.
bool makesSizesAlike(const vk::Device& device, const std::vector<scene::Texture>& textures);

// Whether a texture of that size should get an odd base; not where that would be larger than the device allows.
bool getsOddBase(const vk::Device& device, uint32_t width, uint32_t height);

// Samplers of a material's slots. Empty: any will do, since no material with these samplers has a texture there.
using SlotSamplers = std::array<std::optional<scene::Sampler>, shared::kTextureCount>;

// The samplers of each material's slots, in few combinations: a slot without a texture takes the sampler that a
// material with more textures has there.
std::vector<SlotSamplers> slotSamplers(const std::vector<scene::Material>& materials);

}  // namespace latelight::render
