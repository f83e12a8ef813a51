// The public API's textures, and the textures that a material samples.
#include <cstring>

#include "api/scene.h"
#include "base/error.h"
#include "base/log.h"
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

// Creates the texture with its mip levels. Claims the scene's memory first.
scene::Texture internalTexture(const TextureData& data, scene::Scene& scene) {
  checkTexture(data);
  const scene::ImageSize size{data.width, data.height};
  scene.memory.grow(scene::mipChainBytes(size), "its textures");
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

std::vector<Handle<Texture>> Scene::textures() const {
  return filled().handles(filled().scene.textures, &Impl::texture);
}

Texture Scene::texture(Handle<Texture> texture) const {
  const scene::Texture& from = filled().scene.textures[filled().index(texture)];
  return {from.name, from.width, from.height, from.srgb};
}

TextureData Scene::textureData(Handle<Texture> texture) const {
  const scene::Texture& from = filled().scene.textures[filled().index(texture)];
  TextureData data{from.name, from.width, from.height, from.srgb, {}};
  data.rgba.resize(size_t{4} * from.width * from.height);
  std::memcpy(data.rgba.data(), from.pixels.get(), data.rgba.size());
  return data;
}

Handle<Texture> Scene::addTexture(const TextureData& data) {
  return filled().texture(scene::addTexture(filled().scene, internalTexture(data, filled().scene)));
}

void Scene::setTextureData(Handle<Texture> texture, const TextureData& data) {
  const uint32_t index = filled().index(texture);
  scene::Texture made = internalTexture(data, filled().scene);
  if (made.name.empty()) made.name = filled().scene.textures[index].name;
  scene::setTexture(filled().scene, index, std::move(made));
}

void Scene::removeTexture(Handle<Texture> texture) {
  scene::removeTexture(filled().scene, filled().index(texture));
}

std::optional<TextureUse> Scene::textureOf(Handle<Material> material, TextureSlot slot) const {
  const scene::Material& from = filled().scene.materials[filled().index(material)];
  const scene::TextureSlot& bound = from.slots[indexOf(slot)];
  if (bound.texture < 0) return std::nullopt;
  return TextureUse{filled().texture(static_cast<uint32_t>(bound.texture)), static_cast<Wrap>(bound.sampler.wrapU),
                    static_cast<Wrap>(bound.sampler.wrapV), bound.sampler.magnify == scene::Filter::Linear,
                    from.data.transforms[indexOf(slot)].uvSet};
}

void Scene::setTexture(Handle<Material> material, TextureSlot slot, const std::optional<TextureUse>& use) {
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
}

}  // namespace latelight
