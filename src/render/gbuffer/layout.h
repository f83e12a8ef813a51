// The registry of G-buffer layouts: one per file in src/shared/gbuffer, compiled as C++ here and as GLSL in shaders.
#pragma once

#include <volk.h>

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/gbuffer.h"

namespace latelight::render {

// One texel of a target, as a shader reads it: normalised and float formats in f, integers in u.
struct TargetValue {
  shared::vec4 f{0};
  shared::uvec4 u{0};
};

struct LayoutTarget {
  const char* name;
  VkFormat format;       // VK_FORMAT_UNDEFINED: NORMAL32, which follows the encoding
  const char* channels;  // what is in each channel, in words
};

// Bytes a pixel, one sample of it: the layout's own targets, depth, and the light accumulation target.
struct LayoutBytes {
  uint32_t targets, depth, light;
  uint32_t total() const { return targets + depth + light; }
};

struct Layout {
  std::string file;  // in src/shared/gbuffer, without ending
  std::string name;  // as users write it
  const char* description;
  std::vector<LayoutTarget> targets;
  const char* fixedNormal;    // its fixed normal encoding; null where it follows the chosen one
  const char* fixedPosition;  // how it stores positions; null where they are reconstructed from depth
  int sunTarget;              // whose alpha is the sun's shadow (shadow/sun_occlusion.h); -1: none
  bool keepsMotion;           // stores Surface::motion
  // Formats in the design that the layout follows; frames here use kDepthFormat and kLightFormat with every layout.
  VkFormat originalDepth, originalLight;
  // The layout's pack and unpack in C++; one value per target, in order. Null without targets.
  std::vector<TargetValue> (*pack)(const shared::Surface&, const shared::GbufferContext&);
  shared::Surface (*unpack)(std::span<const TargetValue>, const shared::GbufferContext&);

  // Without, lighting finds surfaces by itself, in what is visible: that takes the raster compute.
  bool hasTargets() const { return !targets.empty(); }
  VkFormat format(size_t target, uint32_t normalEncoding) const;
  LayoutBytes bytesPerPixel(uint32_t normalEncoding) const;
  LayoutBytes originalBytesPerPixel(uint32_t normalEncoding) const;
};

inline constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;
inline constexpr VkFormat kLightFormat = VK_FORMAT_R16G16B16A16_SFLOAT;

std::span<const Layout> layouts();
const Layout& findLayout(std::string_view name);  // throws Error(Usage) that lists them

struct NormalEncoding {
  std::string name;  // "octahedral"
  uint32_t index;    // kNormal_*: what shaders switch on
  uint32_t channels;
  bool hemisphere;  // only normals towards the viewer come back: always in view space
  const char* description;
};
std::span<const NormalEncoding> normalEncodings();
const NormalEncoding& findNormalEncoding(std::string_view name);

}  // namespace latelight::render
