#include "render/gpu_scene/opacity.h"

#include <algorithm>
#include <utility>

#include "base/parallel.h"

namespace latelight::render {

namespace {

bool hasTranslucentVertices(const scene::Mesh& mesh) {
  return std::ranges::any_of(mesh.extras, [](const shared::VertexExtra& extra) { return !(extra.color.a >= 1); });
}

}  // namespace

Opacity::Opacity(const scene::Scene& scene) : scene_(scene) {
  std::vector<uint32_t> all(scene.meshes.size());
  for (uint32_t i = 0; i < all.size(); ++i) all[i] = i;
  update(all);
}

std::vector<uint32_t> Opacity::update(std::span<const uint32_t> meshes) {
  meshes_.resize(scene_.meshes.size());
  parallelFor(meshes.size(), 1, [&](size_t begin, size_t end) {
    for (const uint32_t mesh : meshes.subspan(begin, end - begin))
      meshes_[mesh] = hasTranslucentVertices(scene_.meshes[mesh]);
  });
  const std::vector<bool> before = std::exchange(materials_, materialsOfMeshes());
  std::vector<uint32_t> changed;
  const auto at = [](const std::vector<bool>& list, size_t i) { return i < list.size() && list[i]; };
  for (uint32_t i = 0; i < scene_.materials.size(); ++i)
    if (at(before, i) != at(materials_, i)) changed.push_back(i);
  return changed;
}

std::vector<bool> Opacity::materialsOfMeshes() const {
  if (std::ranges::count(meshes_, 1) == 0) return {};
  std::vector<bool> materials(scene_.materials.size());
  for (const scene::Instance& instance : scene_.instances)
    if (!instance.removed && meshes_[instance.mesh]) materials[instance.material] = true;
  return materials;
}

std::vector<uint32_t> Opacity::updateTextures(std::span<const uint32_t> textures) {
  for (const uint32_t texture : textures) textures_.erase(static_cast<int>(texture));
  std::vector<uint32_t> followers;
  for (uint32_t i = 0; i < scene_.materials.size() && !textures.empty(); ++i) {
    const scene::Material& material = scene_.materials[i];
    const int texture = material.slots[shared::kTextureBaseColor].texture;
    if ((material.data.flags & shared::kMaterialBlended) && texture >= 0 &&
        std::ranges::binary_search(textures, static_cast<uint32_t>(texture)))
      followers.push_back(i);
  }
  return followers;
}

bool Opacity::isOpaque(uint32_t material, const shared::Material& data) const {
  if (!(data.baseColor.a >= 1) || (material < materials_.size() && materials_[material])) return false;
  const bool hasTexture = (data.textures & 1u << shared::kTextureBaseColor) != 0;
  return !hasTexture || hasOpaqueTexels(scene_.materials[material].slots[shared::kTextureBaseColor].texture);
}

// Tests all mip levels. Each texture is tested once, until it is replaced.
bool Opacity::hasOpaqueTexels(int index) const {
  if (index < 0 || static_cast<size_t>(index) >= scene_.textures.size()) return false;
  const auto [known, isNew] = textures_.try_emplace(index, false);
  if (!isNew) return known->second;
  const scene::Texture& texture = scene_.textures[static_cast<size_t>(index)];
  const std::span pixels(texture.pixels.get(), texture.pixels ? texture.bytes() : 0);
  bool opaque = !pixels.empty();
  for (size_t i = 3; opaque && i < pixels.size(); i += 4) opaque = pixels[i] == std::byte{255};
  return known->second = opaque;
}

}  // namespace latelight::render
