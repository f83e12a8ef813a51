// Ambient occlusion: the share of the sky that the depth buffer hides from each pixel (docs/post/ambient-occlusion.md).
// Computed between geometry and lighting, which multiplies Surface::ao by it.
#pragma once

#include "render/frame.h"

namespace latelight::render {

// FrameSetup::ambientOcclusion (--ao), numbered as in AmbientOcclusion.
inline constexpr uint32_t kAoNone = 0, kAoGtao = 1;

inline constexpr VkFormat kAoFormat = VK_FORMAT_R32_SFLOAT;

// The default radius: this share of the radius of the sphere around the scene's bounds.
inline constexpr float kAoRadiusShare = 0.05f;

// The visible share of each pixel's hemisphere, 1 where nothing is drawn; no image where the setup has no ambient
// occlusion.
graph::ImageId addAmbientOcclusion(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
