#include "render/gpu_scene/occlusion_pairs.h"

#include <cstring>
#include <numeric>

#include "base/parallel.h"

namespace latelight::render {

namespace {

constexpr int kNone = OcclusionPairs::kNone;

// How the materials sample a texture.
struct TextureUse {
  uint32_t slots = 0;  // bit i: in slot i
  int other = kNone;   // the texture in the other slot of a pair
  bool severalOthers = false;

  void add(uint32_t slot, int texture) {
    severalOthers = severalOthers || (slots != 0 && other != texture);
    other = texture;
    slots |= 1u << slot;
  }
};

uint32_t otherSlot(uint32_t slot) {
  return slot == shared::kTextureOcclusion ? shared::kTextureMetallicRoughness : shared::kTextureOcclusion;
}

std::vector<TextureUse> textureUses(const scene::Scene& scene) {
  std::vector<TextureUse> uses(scene.textures.size());
  for (const scene::Material& material : scene.materials) {
    if (material.removed) continue;
    for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot)
      if (const int texture = material.slots[slot].texture; texture >= 0)
        uses[static_cast<size_t>(texture)].add(slot, material.slots[otherSlot(slot)].texture);
  }
  return uses;
}

bool isOnlyIn(const TextureUse& use, uint32_t slot) {
  return use.slots == 1u << slot && !use.severalOthers && use.other != kNone;
}

bool hasTexelsOf(const scene::Texture& a, const scene::Texture& b) {
  return a.width == b.width && a.height == b.height && a.levels == b.levels && !a.srgb && !b.srgb;
}

}  // namespace

OcclusionPairs noOcclusionPairs(const scene::Scene& scene) {
  OcclusionPairs pairs{std::vector<int>(scene.textures.size(), kNone), std::vector<int>(scene.textures.size())};
  std::iota(pairs.imageOf.begin(), pairs.imageOf.end(), 0);
  return pairs;
}

OcclusionPairs occlusionPairs(const scene::Scene& scene) {
  OcclusionPairs pairs = noOcclusionPairs(scene);
  const std::vector<TextureUse> uses = textureUses(scene);
  for (size_t i = 0; i < uses.size(); ++i) {
    if (!isOnlyIn(uses[i], shared::kTextureMetallicRoughness)) continue;
    const auto other = static_cast<size_t>(uses[i].other);
    if (!isOnlyIn(uses[other], shared::kTextureOcclusion) || !hasTexelsOf(scene.textures[i], scene.textures[other]))
      continue;
    pairs.occlusionOf[i] = uses[i].other;
    pairs.imageOf[other] = static_cast<int>(i);
  }
  return pairs;
}

std::unique_ptr<std::byte[]> withOcclusion(const scene::Texture& metallicRoughness, const scene::Texture& occlusion) {
  constexpr size_t kTexelBytes = 4, kGrain = 1 << 18;
  const size_t texels = metallicRoughness.bytes() / kTexelBytes;
  auto pixels = std::make_unique_for_overwrite<std::byte[]>(texels * kTexelBytes);
  parallelFor(texels, kGrain, [&](size_t begin, size_t end) {
    const std::byte* red = occlusion.pixels.get();
    std::memcpy(&pixels[begin * kTexelBytes],
                &metallicRoughness.pixels[static_cast<std::ptrdiff_t>(begin * kTexelBytes)],
                (end - begin) * kTexelBytes);
    for (size_t i = begin; i < end; ++i) pixels[i * kTexelBytes] = red[i * kTexelBytes];
  });
  return pixels;
}

}  // namespace latelight::render
