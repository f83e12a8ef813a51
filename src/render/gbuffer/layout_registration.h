// Turns GBUFFER_TARGETS into the layout's entry in the registry. A generated source (cmake/registry.cmake) includes it
// once per layout, after the layout's own header and with LATELIGHT_LAYOUT defined as its name.
#include "render/base/registry.h"
#include "render/gbuffer/layout.h"

namespace latelight::render {
namespace {

#ifndef GBUFFER_NO_TARGETS
namespace layout_shared = shared::LATELIGHT_LAYOUT;
using layout_shared::GbufferTexel;
using vec4 = shared::vec4;
using uvec2 = shared::uvec2;
using uvec4 = shared::uvec4;

[[maybe_unused]] void store(TargetValue& to, const vec4& from) {
  to.f = from;
}
[[maybe_unused]] void store(TargetValue& to, shared::uint from) {
  to.u = uvec4(from, 0, 0, 1);
}
[[maybe_unused]] void store(TargetValue& to, const uvec2& from) {
  to.u = uvec4(from, 0, 0);
}
[[maybe_unused]] void store(TargetValue& to, const uvec4& from) {
  to.u = from;
}
[[maybe_unused]] void load(vec4& to, const TargetValue& from) {
  to = from.f;
}
[[maybe_unused]] void load(shared::uint& to, const TargetValue& from) {
  to = from.u.x;
}
[[maybe_unused]] void load(uvec2& to, const TargetValue& from) {
  to = uvec2(from.u);
}
[[maybe_unused]] void load(uvec4& to, const TargetValue& from) {
  to = from.u;
}

std::vector<TargetValue> packTarget(const shared::Surface& s, const shared::GbufferContext& context) {
  GbufferTexel texel = layout_shared::packGbuffer(s, context);
  std::vector<TargetValue> values;
#define STORE(index, name, format, type, channels) store(values.emplace_back(), texel.name);
  GBUFFER_TARGETS(STORE)
#undef STORE
  return values;
}

shared::Surface unpackTarget(std::span<const TargetValue> values, const shared::GbufferContext& context) {
  GbufferTexel texel;
#define LOAD(index, name, format, type, channels) load(texel.name, values[index]);
  GBUFFER_TARGETS(LOAD)
#undef LOAD
  return layout_shared::unpackGbuffer(texel, context);
}
#else
constexpr std::nullptr_t packTarget = nullptr, unpackTarget = nullptr;
#endif

[[maybe_unused]] constexpr VkFormat VK_FORMAT_NORMAL32 = VK_FORMAT_UNDEFINED;

}  // namespace

#ifndef GBUFFER_FIXED_NORMAL
#define GBUFFER_FIXED_NORMAL nullptr
#endif
#ifndef GBUFFER_FIXED_POSITION
#define GBUFFER_FIXED_POSITION nullptr
#endif
#ifndef GBUFFER_SUN_TARGET
#define GBUFFER_SUN_TARGET -1
#endif
#ifdef GBUFFER_KEEPS_MOTION
constexpr bool kKeepsMotion = true;
#else
constexpr bool kKeepsMotion = false;
#endif
#define FORMAT_(name) VK_FORMAT_##name
#define FORMAT(name) FORMAT_(name)
#ifdef GBUFFER_DEPTH_FORMAT
constexpr VkFormat kOriginalDepth = FORMAT(GBUFFER_DEPTH_FORMAT);
#else
constexpr VkFormat kOriginalDepth = kDepthFormat;
#endif
#ifdef GBUFFER_LIGHT_FORMAT
constexpr VkFormat kOriginalLight = FORMAT(GBUFFER_LIGHT_FORMAT);
#else
constexpr VkFormat kOriginalLight = kLightFormat;
#endif

#define LAYOUT_MAKER_(name) makeLayout_##name
#define LAYOUT_MAKER(name) LAYOUT_MAKER_(name)
#define LAYOUT_FILE_(name) #name
#define LAYOUT_FILE(name) LAYOUT_FILE_(name)
Layout LAYOUT_MAKER(LATELIGHT_LAYOUT)() {
#define TARGET(index, name, format, type, channels) LayoutTarget{#name, VK_FORMAT_##format, channels},
  const char* file = LAYOUT_FILE(LATELIGHT_LAYOUT);
  return {.file = file,
          .name = registryName(file),
          .description = GBUFFER_DESCRIPTION,
          .targets = {GBUFFER_TARGETS(TARGET)},
          .fixedNormal = GBUFFER_FIXED_NORMAL,
          .fixedPosition = GBUFFER_FIXED_POSITION,
          .sunTarget = GBUFFER_SUN_TARGET,
          .keepsMotion = kKeepsMotion,
          .originalDepth = kOriginalDepth,
          .originalLight = kOriginalLight,
          .pack = packTarget,
          .unpack = unpackTarget};
#undef TARGET
}

}  // namespace latelight::render
