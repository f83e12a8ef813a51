// Ground-truth ambient occlusion (GTAO; Jimenez, Wu, Pesce and Jarabo 2016, Practical Realtime Strategies for Accurate
// Indirect Occlusion, Activision): the fraction of the sky that the depth buffer occludes at each pixel
// (docs/post/ambient-occlusion.md). It is computed between the geometry pass and lighting, which multiplies Surface::ao
// by the result.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// FrameConfig::ambientOcclusion (--ao), numbered as in AmbientOcclusion.
inline constexpr uint32_t kAoNone = 0, kAoGtao = 1;

inline constexpr VkFormat kAoFormat = VK_FORMAT_R32_SFLOAT;

// The default radius, as a fraction of the radius of the sphere around the scene's bounds.
inline constexpr float kAoRadiusShare = 0.05f;

// Returns the visible fraction of each pixel's hemisphere, which is 1 in pixels without a surface; null if the setup
// has no ambient occlusion.
graph::ImageId addAmbientOcclusion(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
