// Ambient occlusion: what of the sky the depth buffer hides from each pixel (docs/post/ambient-occlusion.md). Computed
// between geometry and lighting, which multiplies Surface::ao by it.
#pragma once

#include "render/frame.h"

namespace latelight::render {

// --ao, as FrameSetup::ambientOcclusion has it, as AmbientOcclusion numbers it.
inline constexpr uint32_t kAoNone = 0, kAoGtao = 1;

inline constexpr VkFormat kAoFormat = VK_FORMAT_R32_SFLOAT;

// Without a radius from the user: this share of the radius of the sphere around the scene's bounds.
inline constexpr float kAoRadiusShare = 0.05f;

// The visible share of each pixel's hemisphere, 1 where nothing is drawn; no image where the setup has no ambient
// occlusion.
graph::ImageId addAmbientOcclusion(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
