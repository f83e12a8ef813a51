#include "scene/camera_selector.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"

namespace latelight::scene {

std::optional<size_t> findCamera(std::span<const Camera> cameras, std::string_view selector) {
  const auto indexIn = [&](std::string_view text) {
    const auto index = parseNumber<size_t>(text);
    return index && *index < cameras.size() ? index : std::nullopt;
  };
  if (selector.starts_with('#'))
    if (const auto index = indexIn(selector.substr(1))) return index;
  const auto named = std::ranges::find(cameras, selector, &Camera::name);
  if (named != cameras.end()) return static_cast<size_t>(named - cameras.begin());
  return indexIn(selector);
}

std::string cameraSelector(std::span<const Camera> cameras, size_t index) {
  const std::string& name = cameras[index].name;
  return !name.empty() && findCamera(cameras, name) == index ? name : fmt::format("#{}", index);
}

}  // namespace latelight::scene
