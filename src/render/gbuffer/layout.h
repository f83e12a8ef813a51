// The registry of G-buffer layouts. Each file in src/shared/gbuffer is one layout and compiles as C++ here and as GLSL
// in shaders.
#pragma once

#include <volk.h>

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/gbuffer.h"

namespace latelight::render {

// One texel of a target, as a shader reads it: normalized and float formats in f, integers in u.
struct TargetValue {
  shared::vec4 f{0};
  shared::uvec4 u{0};
};

struct LayoutTarget {
  const char* name;
  VkFormat format;       // VK_FORMAT_UNDEFINED: NORMAL32, which depends on the encoding
  const char* channels;  // description of each channel
};

// Bytes per pixel and sample: the layout's own targets, depth, and the light accumulation target.
struct LayoutBytes {
  uint32_t targets, depth, light;
  uint32_t total() const { return targets + depth + light; }
};

struct Layout {
  std::string file;  // in src/shared/gbuffer, without extension
  std::string name;  // as users write it
  const char* description;
  std::vector<LayoutTarget> targets;
  const char* fixedNormal;    // its fixed normal encoding; null if it uses the chosen one
  const char* fixedPosition;  // how it stores positions; null if they are reconstructed from depth
  int sunTarget;              // target whose alpha is the sun's shadow (shadow/sun_occlusion.h); -1: none
  bool keepsMotion;           // stores Surface::motion
  // Formats of the original design of the layout. Frames here use kDepthFormat and kLightFormat with every layout.
  VkFormat originalDepth, originalLight;
  // The layout's pack and unpack functions in C++, with one value per target, in order. Null if there are no targets.
  std::vector<TargetValue> (*pack)(const shared::Surface&, const shared::GbufferContext&);
  shared::Surface (*unpack)(std::span<const TargetValue>, const shared::GbufferContext&);

  // If there are no targets, lighting evaluates surfaces from the visibility buffer, which requires the raster compute.
  bool hasTargets() const { return !targets.empty(); }
  VkFormat format(size_t target, uint32_t normalEncoding) const;
  LayoutBytes bytesPerPixel(uint32_t normalEncoding) const;
  LayoutBytes originalBytesPerPixel(uint32_t normalEncoding) const;
};

inline constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;
inline constexpr VkFormat kLightFormat = VK_FORMAT_R16G16B16A16_SFLOAT;

std::span<const Layout> layouts();
const Layout& findLayout(std::string_view name);  // throws Error(Usage) with the list of layouts

struct NormalEncoding {
  std::string name;  // "octahedral"
  uint32_t index;    // kNormal_*, on which shaders switch
  uint32_t channels;
  bool hemisphere;  // represents only normals towards the viewer; always in view space
  const char* description;
};
std::span<const NormalEncoding> normalEncodings();
const NormalEncoding& findNormalEncoding(std::string_view name);

}  // namespace latelight::render
