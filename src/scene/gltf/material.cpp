// Converts glTF materials, including their extensions and variants, to scene materials and texture requests.
#include "scene/gltf/material.h"

#include <fmt/ranges.h>
#include <algorithm>

#include "base/error.h"
#include "base/log.h"

namespace latelight::scene::gltf {
namespace {

constexpr float kDielectricF0 = 0.04f;  // for the default index of refraction, 1.5

void setTransform(shared::TextureTransform& out, const file::TextureInfo& info) {
  setRows(out, info.transform);
  if (info.texCoord > 1)
    warn(
        "a texture uses TEXCOORD_{}; two UV sets are supported: TEXCOORD_1 is used instead, or TEXCOORD_0 in meshes "
        "without it",
        info.texCoord);
  out.uvSet = uint32_t(std::min(info.texCoord, 1));
}

// Returns true if two references sample their textures at the same coordinates.
bool samePlace(const file::TextureInfo& a, const file::TextureInfo& b) {
  shared::TextureTransform first, second;
  setTransform(first, a);
  setTransform(second, b);
  return first.row0 == second.row0 && first.row1 == second.row1 && first.uvSet == second.uvSet;
}

Wrap wrapOf(int gl) {
  if (gl == file::kClampToEdge) return Wrap::Clamp;
  if (gl == file::kMirroredRepeat) return Wrap::Mirror;
  return Wrap::Repeat;
}

Sampler samplerOf(const file::Model& model, int index) {
  Sampler sampler;
  if (index < 0) return sampler;
  const file::Sampler& source = model.samplers[size_t(index)];
  sampler.wrapU = wrapOf(source.wrapS);
  sampler.wrapV = wrapOf(source.wrapT);
  if (source.magFilter == file::kNearest) sampler.magnify = Filter::Nearest;
  auto minify = [&](Filter filter, MipFilter mip) { sampler.minify = filter, sampler.mip = mip; };
  switch (source.minFilter) {
    case file::kNearest:
      minify(Filter::Nearest, MipFilter::None);
      break;
    case file::kLinear:
      minify(Filter::Linear, MipFilter::None);
      break;
    case file::kNearestMipmapNearest:
      minify(Filter::Nearest, MipFilter::Nearest);
      break;
    case file::kLinearMipmapNearest:
      minify(Filter::Linear, MipFilter::Nearest);
      break;
    case file::kNearestMipmapLinear:
      minify(Filter::Nearest, MipFilter::Linear);
      break;
    default:
      break;
  }
  return sampler;
}

class MaterialReader {
 public:
  MaterialReader(const Document& document, uint32_t slots, TextureTable& textures)
      : document_(document), slots_(slots), textures_(textures) {}

  Material read(const file::Material& source) {
    source_ = &source;
    out_ = defaultMaterial();
    parts_ = {};
    out_.name = source.name;
    readSurface();
    readAlpha();
    readExtensions();
    // The specular-glossiness extension is a different model, which replaces metallic-roughness and its extensions.
    if (source.specularGlossiness)
      readSpecularGlossiness(*source.specularGlossiness);
    else
      readMetallicRoughness();
    return std::move(out_);
  }
  const MaterialParts& parts() const { return parts_; }  // parts of the last material read

 private:
  void slot(uint32_t slot, const file::TextureInfo& info, bool srgb) {
    const int image = imageAt(info);
    if (image >= 0) fill(slot, info, {.image = image, .srgb = srgb});
  }

  // Returns the texture's image, or -1 if there is none or an unreadable one.
  int imageAt(const file::TextureInfo& info) const {
    if (info.texture < 0) return -1;
    const int image = document_.model.textures[size_t(info.texture)].image;
    if (image < 0) warn("textures[{}] has no readable image, and is ignored", info.texture);
    return image;
  }

  bool isRequested(uint32_t slot) const {
    const bool alphaDecides = (out_.data.flags & (shared::kMaterialMasked | shared::kMaterialBlended)) != 0;
    return (slots_ >> slot & 1u) != 0 || (slot == shared::kTextureBaseColor && alphaDecides);
  }

  void fill(uint32_t slot, const file::TextureInfo& info, const TextureRequest& request) {
    if (!isRequested(slot)) return;
    const file::Texture& texture = document_.model.textures[size_t(info.texture)];
    out_.slots[slot] = {textures_.request(request), samplerOf(document_.model, texture.sampler)};
    out_.data.textures |= 1u << slot;
    setTransform(out_.data.transforms[slot], info);
    parts_.transforms[slot] = info.transform;
  }

  void readSurface() {
    shared::Material& data = out_.data;
    parts_.emissive = data.emissive = source_->emissiveFactor;
    data.normalScale = source_->normalScale;
    data.occlusionStrength = std::clamp(source_->occlusionStrength, 0.0f, 1.0f);
    slot(shared::kTextureNormal, source_->normalTexture, false);
    slot(shared::kTextureOcclusion, source_->occlusionTexture, false);
    slot(shared::kTextureEmissive, source_->emissiveTexture, true);
    if (source_->doubleSided) data.flags |= shared::kMaterialDoubleSided;
  }

  void readMetallicRoughness() {
    shared::Material& data = out_.data;
    const file::MetallicRoughness& pbr = source_->metallicRoughness;
    data.baseColor = pbr.baseColorFactor;
    data.metallic = pbr.metallicFactor;
    data.roughness = pbr.roughnessFactor;
    slot(shared::kTextureBaseColor, pbr.baseColorTexture, true);
    slot(shared::kTextureMetallicRoughness, pbr.metallicRoughnessTexture, false);
    data.f0 = f0OfIor(source_->ior);
    data.specular = source_->specular.specularFactor;
    data.specularColor = source_->specular.specularColorFactor;
    slot(shared::kTextureSpecular, source_->specular.specularTexture, false);
    slot(shared::kTextureSpecularColor, source_->specular.specularColorTexture, true);
  }

  // Maps specular-glossiness to a dielectric: base color is c_diff attenuated by the specular color, F0 comes from an
  // index of refraction of 0 with that specular color, and roughness is 1 - glossiness.
  void readSpecularGlossiness(const file::SpecularGlossiness& e) {
    shared::Material& data = out_.data;
    const std::array<float, 3> specular{e.specularFactor.x, e.specularFactor.y, e.specularFactor.z};
    data.specularColor = e.specularFactor;
    data.baseColor = e.diffuseFactor;
    data.metallic = 0;
    data.roughness = 1 - e.glossinessFactor;
    data.f0 = f0OfIor(0);
    const file::TextureInfo &diffuse = e.diffuseTexture, &both = e.specularGlossinessTexture;
    const int image = imageAt(diffuse), specularImage = imageAt(both);
    const float left = 1 - *std::ranges::max_element(specular);
    if (specularImage < 0) {
      for (int i = 0; i < 3; ++i) data.baseColor[i] *= std::max(left, 0.0f);
      if (image >= 0) fill(shared::kTextureBaseColor, diffuse, {.image = image, .srgb = true});
      return;
    }
    data.roughness = 1;
    fill(shared::kTextureSpecularColor, both, {.image = specularImage, .srgb = true});
    fill(shared::kTextureMetallicRoughness, both,
         {.make = TextureRequest::Make::Roughness, .specular = specularImage, .factor = {e.glossinessFactor, 0, 0}});
    if (image >= 0 && !samePlace(diffuse, both))
      warn(
          "a material of KHR_materials_pbrSpecularGlossiness has two textures with different transforms: the diffuse "
          "texture is dimmed as if they were equal");
    fill(shared::kTextureBaseColor, image < 0 ? both : diffuse,
         {.image = image,
          .srgb = true,
          .make = TextureRequest::Make::Diffuse,
          .specular = specularImage,
          .factor = specular});
  }

  void readAlpha() {
    shared::Material& data = out_.data;
    if (source_->alphaMode == "MASK") {
      data.flags |= shared::kMaterialMasked;
      data.alphaCutoff = source_->alphaCutoff;
    } else if (source_->alphaMode == "BLEND") {
      data.flags |= shared::kMaterialBlended;
    } else if (source_->alphaMode != "OPAQUE") {
      badInput("a material has the unknown alphaMode \"{}\"", source_->alphaMode);
    }
  }

  void readExtensions() {
    shared::Material& data = out_.data;
    if (source_->unlit) data.flags |= shared::kMaterialUnlit;
    data.emissive *= parts_.emissiveStrength = source_->emissiveStrength;
    readCoats();
    readReflection();
    readTransmission();
  }

  void readCoats() {
    shared::MaterialLayers& l = out_.data.layers;
    const file::Clearcoat& coat = source_->clearcoat;
    l.clearcoat = coat.clearcoatFactor;
    l.clearcoatRoughness = coat.clearcoatRoughnessFactor;
    l.clearcoatNormalScale = coat.clearcoatNormalScale;
    slot(shared::kTextureClearcoat, coat.clearcoatTexture, false);
    slot(shared::kTextureClearcoatRoughness, coat.clearcoatRoughnessTexture, false);
    slot(shared::kTextureClearcoatNormal, coat.clearcoatNormalTexture, false);
    const file::Sheen& sheen = source_->sheen;
    l.sheenColor = sheen.sheenColorFactor;
    l.sheenRoughness = sheen.sheenRoughnessFactor;
    slot(shared::kTextureSheenColor, sheen.sheenColorTexture, true);
    slot(shared::kTextureSheenRoughness, sheen.sheenRoughnessTexture, false);
  }

  void readReflection() {
    shared::MaterialLayers& l = out_.data.layers;
    const file::Anisotropy& anisotropy = source_->anisotropy;
    l.anisotropy = anisotropy.anisotropyStrength;
    l.anisotropyRotation = anisotropy.anisotropyRotation;
    slot(shared::kTextureAnisotropy, anisotropy.anisotropyTexture, false);
    const file::Iridescence& film = source_->iridescence;
    l.iridescence = film.iridescenceFactor;
    l.iridescenceIor = film.iridescenceIor;
    l.iridescenceThinnest = film.iridescenceThicknessMinimum;
    l.iridescenceThickest = film.iridescenceThicknessMaximum;
    slot(shared::kTextureIridescence, film.iridescenceTexture, false);
    slot(shared::kTextureIridescenceThickness, film.iridescenceThicknessTexture, false);
  }

  void readTransmission() {
    shared::MaterialLayers& l = out_.data.layers;
    l.transmission = source_->transmission.transmissionFactor;
    slot(shared::kTextureTransmission, source_->transmission.transmissionTexture, false);
    const file::Volume& volume = source_->volume;
    l.thickness = volume.thicknessFactor;
    l.attenuationDistance = volume.attenuationDistance;
    l.attenuationColor = volume.attenuationColor;
    slot(shared::kTextureThickness, volume.thicknessTexture, false);
    l.dispersion = source_->dispersion;
    const file::DiffuseTransmission& diffuse = source_->diffuseTransmission;
    l.diffuseTransmission = diffuse.diffuseTransmissionFactor;
    l.diffuseTransmissionColor = diffuse.diffuseTransmissionColorFactor;
    slot(shared::kTextureDiffuseTransmission, diffuse.diffuseTransmissionTexture, false);
    slot(shared::kTextureDiffuseTransmissionColor, diffuse.diffuseTransmissionColorTexture, true);
  }

  const Document& document_;
  const uint32_t slots_;
  TextureTable& textures_;
  const file::Material* source_ = nullptr;
  Material out_;
  MaterialParts parts_;
};

}  // namespace

int TextureTable::request(const TextureRequest& request) {
  auto [known, isNew] = known_.try_emplace(request, int(requests_.size()));
  if (isNew) requests_.push_back(request);
  return known->second;
}

Material defaultMaterial() {
  Material material;
  material.name = "default";
  material.data = {.baseColor = vec4(1),
                   .emissive = vec3(0),
                   .metallic = 1,
                   .roughness = 1,
                   .normalScale = 1,
                   .occlusionStrength = 1,
                   .alphaCutoff = 0.5f,
                   .specularColor = vec3(1),
                   .specular = 1,
                   .f0 = kDielectricF0,
                   .layers = noLayers()};
  for (shared::TextureTransform& transform : material.data.transforms) setTransform(transform, {});
  return material;
}

void readMaterials(const Document& document, uint32_t slots, TextureTable& textures, Scene& scene) {
  MaterialReader reader(document, slots, textures);
  for (uint32_t i = 0; i < document.model.materials.size(); ++i) {
    scene.materials.push_back(reader.read(document.model.materials[i]));
    if (const auto animated = scene.rig.materials.find(i); animated != scene.rig.materials.end())
      animated->second = reader.parts();
  }
}

int readVariants(const Document& document, const std::string& requested, Scene& scene) {
  scene.variants = document.model.variants;
  if (requested.empty()) return -1;
  auto found = std::find(scene.variants.begin(), scene.variants.end(), requested);
  if (found != scene.variants.end()) return int(found - scene.variants.begin());
  if (scene.variants.empty()) badUsage("there is no variant \"{}\": the file has no material variants", requested);
  badUsage("there is no variant \"{}\": the file has {}", requested, fmt::join(scene.variants, ", "));
}

int materialOf(const file::Primitive& primitive, int variant) {
  if (variant < 0) return primitive.material;
  for (const file::VariantMapping& mapping : primitive.variants)
    if (std::ranges::find(mapping.variants, variant) != mapping.variants.end()) return mapping.material;
  return primitive.material;
}

}  // namespace latelight::scene::gltf
