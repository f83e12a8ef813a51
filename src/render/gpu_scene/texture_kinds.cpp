#include "render/gpu_scene/texture_kinds.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <numeric>

namespace latelight::render {

namespace {

bool hasPowerOfTwo(uint32_t width, uint32_t height) {
  return std::has_single_bit(width) || std::has_single_bit(height);
}

// Merges the samplers of two materials into one set, if they do not conflict.
bool unite(SlotSamplers& all, const SlotSamplers& more) {
  for (size_t i = 0; i < all.size(); ++i)
    if (all[i] && more[i] && *all[i] != *more[i]) return false;
  for (size_t i = 0; i < all.size(); ++i)
    if (more[i]) all[i] = more[i];
  return true;
}

}  // namespace

bool unifiesTextureSizes(const vk::Device& device, const std::vector<scene::Texture>& textures) {
  const auto odd = [](const scene::Texture& t) {
    return !std::has_single_bit(t.width) || !std::has_single_bit(t.height);
  };
  // An odd base is four times as large as its texture. It is never written to, so it uses address space but no memory.
  // Drivers limit address space, too, and with large textures shader compilation is not the bottleneck.
  constexpr uint64_t kMaxTexels = uint64_t{32} << 20;
  uint64_t texels = 0;
  for (const scene::Texture& t : textures) texels += uint64_t{t.width} * t.height;
  return device.isCpu() && texels <= kMaxTexels && std::ranges::any_of(textures, odd);
}

bool getsOddBase(const vk::Device& device, uint32_t width, uint32_t height) {
  return hasPowerOfTwo(width, height) && 2 * std::max(width, height) < device.properties().limits.maxImageDimension2D;
}

std::vector<SlotSamplers> slotSamplers(const std::vector<scene::Material>& materials) {
  std::vector<SlotSamplers> own(materials.size()), combinations;
  for (size_t i = 0; i < materials.size(); ++i)
    for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot)
      if (const scene::TextureSlot& bound = materials[i].slots[slot]; bound.texture >= 0) own[i][slot] = bound.sampler;
  // Materials with the most textures come first, because the others fit into their combinations.
  const auto textures = [&](size_t i) { return std::ranges::count_if(own[i], [](const auto& s) { return bool(s); }); };
  std::vector<size_t> order(materials.size()), chosen(materials.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::stable_sort(order, std::greater(), textures);
  for (size_t i : order) {
    const auto found = std::ranges::find_if(combinations, [&](SlotSamplers& c) { return unite(c, own[i]); });
    chosen[i] = static_cast<size_t>(found - combinations.begin());
    if (found == combinations.end()) combinations.push_back(own[i]);
  }
  for (size_t i = 0; i < materials.size(); ++i) own[i] = combinations[chosen[i]];
  return own;
}

}  // namespace latelight::render
