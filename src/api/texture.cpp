// The public API's textures, and the textures that a material samples.
#include <cstring>
#include <new>

#include "api/scene.h"
#include "base/error.h"
#include "base/log.h"
#include "base/memory.h"
#include "scene/edit.h"
#include "scene/textures/texture.h"

namespace latelight {

namespace {

void checkTexture(const TextureData& data) {
  const std::string name = printable(data.name);
  if (data.width == 0 || data.height == 0) badUsage("the texture \"{}\" has no pixels", name);
  if (data.width > scene::kMaxTextureSide || data.height > scene::kMaxTextureSide)
    badUsage("the texture \"{}\" is {}x{} pixels; width and height are limited to {}", name, data.width, data.height,
             scene::kMaxTextureSide);
  if (data.rgba.size() != size_t{4} * data.width * data.height)
    badUsage("the texture \"{}\" is {}x{} pixels of 4 bytes, and {} bytes are given", name, data.width, data.height,
             data.rgba.size());
}

// Claims the memory of a texture for a scene, and returns it unless the scene gets the texture.
class TextureClaim {
 public:
  TextureClaim(const TextureData& data, scene::Scene& scene) : scene_(scene) {
    checkTexture(data);
    bytes_ = scene::mipChainBytes({data.width, data.height});
    scene.memory.grow(bytes_, "its textures");
  }
  ~TextureClaim() { scene_.memory.shrink(bytes_); }
  TextureClaim(const TextureClaim&) = delete;
  TextureClaim& operator=(const TextureClaim&) = delete;
  void keep() { bytes_ = 0; }

 private:
  scene::Scene& scene_;
  uint64_t bytes_ = 0;
};

// Creates the texture with its mip levels. Its memory must have been claimed.
scene::Texture internalTexture(const TextureData& data) {
  const scene::ImageSize size{data.width, data.height};
  scene::Texture texture = scene::makeTexture(size, data.srgb, data.name);
  std::memcpy(texture.pixels.get(), data.rgba.data(), data.rgba.size());
  scene::buildMips(texture);
  return texture;
}

size_t indexOf(TextureSlot slot) {
  const auto index = static_cast<size_t>(slot);
  if (index >= shared::kTextureCount) badUsage("a material has no texture slot {}", index);
  return index;
}

scene::Wrap internalWrap(Wrap wrap) {
  const auto index = static_cast<size_t>(wrap);
  if (index > static_cast<size_t>(Wrap::Clamp)) badUsage("a texture has no wrap mode {}", index);
  return static_cast<scene::Wrap>(wrap);
}

scene::TextureSlot internalSlot(const TextureUse& use, uint32_t texture) {
  scene::Sampler sampler{.wrapU = internalWrap(use.wrapU), .wrapV = internalWrap(use.wrapV)};
  if (!use.smooth) {
    sampler.magnify = sampler.minify = scene::Filter::Nearest;
    sampler.mip = scene::MipFilter::None;
  }
  return {static_cast<int>(texture), sampler};
}

}  // namespace

std::vector<Handle<Texture>> Scene::textures() const try {
  return filled().handles(filled().scene.textures, &Impl::texture);
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

Texture Scene::texture(Handle<Texture> texture) const try {
  const scene::Texture& from = filled().scene.textures[filled().index(texture)];
  return {from.name, from.width, from.height, from.srgb};
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

TextureData Scene::textureData(Handle<Texture> texture) const try {
  const scene::Texture& from = filled().scene.textures[filled().index(texture)];
  TextureData data{from.name, from.width, from.height, from.srgb, {}};
  data.rgba.resize(size_t{4} * from.width * from.height);
  std::memcpy(data.rgba.data(), from.pixels.get(), data.rgba.size());
  return data;
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

Handle<Texture> Scene::addTexture(const TextureData& data) try {
  TextureClaim claim(data, filled().scene);
  const uint32_t index = scene::addTexture(filled().scene, internalTexture(data));
  claim.keep();
  return filled().texture(index);
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

void Scene::setTextureData(Handle<Texture> texture, const TextureData& data) try {
  const uint32_t index = filled().index(texture);
  TextureClaim claim(data, filled().scene);
  scene::Texture made = internalTexture(data);
  if (made.name.empty()) made.name = filled().scene.textures[index].name;
  scene::setTexture(filled().scene, index, std::move(made));
  claim.keep();
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

void Scene::removeTexture(Handle<Texture> texture) try {
  scene::removeTexture(filled().scene, filled().index(texture));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

std::optional<TextureUse> Scene::textureOf(Handle<Material> material, TextureSlot slot) const try {
  const scene::Material& from = filled().scene.materials[filled().index(material)];
  const scene::TextureSlot& bound = from.slots[indexOf(slot)];
  if (bound.texture < 0) return std::nullopt;
  return TextureUse{filled().texture(static_cast<uint32_t>(bound.texture)), static_cast<Wrap>(bound.sampler.wrapU),
                    static_cast<Wrap>(bound.sampler.wrapV), bound.sampler.magnify == scene::Filter::Linear,
                    from.data.transforms[indexOf(slot)].uvSet};
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

void Scene::setTexture(Handle<Material> material, TextureSlot slot, const std::optional<TextureUse>& use) try {
  const uint32_t index = filled().index(material);
  const size_t place = indexOf(slot);
  scene::Material edited = filled().scene.materials[index];
  edited.slots[place] = {};
  edited.data.textures &= ~(1u << place);
  if (use) {
    if (use->uvSet > 1) badUsage("a mesh has the texture coordinate sets 0 and 1, not {}", use->uvSet);
    edited.slots[place] = internalSlot(*use, filled().index(use->texture));
    edited.data.textures |= 1u << place;
    edited.data.transforms[place].uvSet = use->uvSet;
  }
  scene::setMaterial(filled().scene, index, edited);
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

}  // namespace latelight
