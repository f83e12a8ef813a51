// Converts glTF materials, including their extensions and variants, to scene materials and texture requests.
#include "scene/gltf/material.h"

#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/log.h"
#include "scene/gltf/extensions.h"

namespace latelight::scene::gltf {
namespace {

using tinygltf::Value;

constexpr float kDielectricF0 = 0.04f;  // for the default index of refraction, 1.5

// The properties that all kinds of texture references share.
struct Reference {
  int texture = -1;
  int uvSet = 0;
  const Value* transform = nullptr;
};

const Value* transformOf(const tinygltf::ExtensionMap& extensions) {
  return extension(extensions, "KHR_texture_transform");
}

template <typename Info>  // tinygltf's three kinds of texture info
Reference referenceTo(const Info& info) {
  return {info.index, info.texCoord, transformOf(info.extensions)};
}

// Texture references of extensions are plain JSON.
Reference referenceTo(const Value& info) {
  if (!info.IsObject()) return {};
  const Value& extensions = info.Get("extensions");
  const Value* transform = extensions.IsObject() && extensions.Has("KHR_texture_transform")
                               ? &extensions.Get("KHR_texture_transform")
                               : nullptr;
  return {indexOr(info, "index", -1), indexOr(info, "texCoord", 0), transform};
}

double elementOr(const Value& object, const char* key, size_t i, double otherwise) {
  const Value& array = object.Get(key);
  if (!array.IsArray() || i >= array.ArrayLen()) return otherwise;
  const Value& element = array.Get(int(i));
  return element.IsNumber() ? element.GetNumberAsDouble() : otherwise;
}

TransformParts partsOf(const Reference& reference) {
  if (!reference.transform) return {};
  const Value& t = *reference.transform;
  return {.offset = vec2(elementOr(t, "offset", 0, 0), elementOr(t, "offset", 1, 0)),
          .rotation = float(numberOr(t, "rotation", 0)),
          .scale = vec2(elementOr(t, "scale", 0, 1), elementOr(t, "scale", 1, 1))};
}

void setTransform(shared::TextureTransform& out, const Reference& reference) {
  setRows(out, partsOf(reference));
  const int uvSet = reference.transform ? indexOr(*reference.transform, "texCoord", reference.uvSet) : reference.uvSet;
  if (uvSet > 1) warn("a texture uses TEXCOORD_{}; two UV sets are supported, and TEXCOORD_1 is used instead", uvSet);
  out.uvSet = uint32_t(std::min(uvSet, 1));
}

// Returns true if two references sample their textures at the same coordinates.
bool samePlace(const Reference& a, const Reference& b) {
  shared::TextureTransform first, second;
  setTransform(first, a);
  setTransform(second, b);
  return first.row0 == second.row0 && first.row1 == second.row1 && first.uvSet == second.uvSet;
}

Wrap wrapOf(int gl) {
  if (gl == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Wrap::Clamp;
  if (gl == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return Wrap::Mirror;
  return Wrap::Repeat;
}

Sampler samplerOf(const tinygltf::Model& model, int index) {
  Sampler sampler;
  if (index < 0) return sampler;
  const tinygltf::Sampler& source = model.samplers[size_t(index)];
  sampler.wrapU = wrapOf(source.wrapS);
  sampler.wrapV = wrapOf(source.wrapT);
  if (source.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST) sampler.magnify = Filter::Nearest;
  auto minify = [&](Filter filter, MipFilter mip) { sampler.minify = filter, sampler.mip = mip; };
  switch (source.minFilter) {
    case TINYGLTF_TEXTURE_FILTER_NEAREST:
      minify(Filter::Nearest, MipFilter::None);
      break;
    case TINYGLTF_TEXTURE_FILTER_LINEAR:
      minify(Filter::Linear, MipFilter::None);
      break;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_NEAREST:
      minify(Filter::Nearest, MipFilter::Nearest);
      break;
    case TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_NEAREST:
      minify(Filter::Linear, MipFilter::Nearest);
      break;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_LINEAR:
      minify(Filter::Nearest, MipFilter::Linear);
      break;
    default:
      break;
  }
  return sampler;
}

int imageOf(const tinygltf::Texture& texture) {
  for (const std::string_view name : {"EXT_texture_webp", "KHR_texture_basisu", "EXT_texture_avif"}) {
    if (name == "EXT_texture_avif" && !kReadsAvif) continue;
    const Value* other = extension(texture.extensions, name.data());
    if (const int image = other ? indexOr(*other, "source", -1) : -1; image >= 0) return image;
  }
  return texture.source;
}

class MaterialReader {
 public:
  MaterialReader(const Document& document, uint32_t slots, TextureTable& textures)
      : document_(document), slots_(slots), textures_(textures) {}

  Material read(const tinygltf::Material& source) {
    source_ = &source;
    out_ = defaultMaterial();
    parts_ = {};
    out_.name = source.name;
    readSurface();
    readAlpha();
    readExtensions();
    // The specular-glossiness extension is a different model, which replaces metallic-roughness and its extensions.
    if (const Value* e = extension(source.extensions, "KHR_materials_pbrSpecularGlossiness"))
      readSpecularGlossiness(*e);
    else
      readMetallicRoughness();
    return std::move(out_);
  }
  const MaterialParts& parts() const { return parts_; }  // parts of the last material read

 private:
  void slot(uint32_t slot, const Reference& reference, bool srgb) {
    const int image = imageAt(reference);
    if (image >= 0) fill(slot, reference, {.image = image, .srgb = srgb});
  }

  // Returns the reference's image, or -1 if it has none or an unreadable one.
  int imageAt(const Reference& reference) const {
    if (reference.texture < 0) return -1;
    const int image = imageOf(document_.model.textures[size_t(reference.texture)]);
    if (image < 0) warn("textures[{}] has no readable image, and is ignored", reference.texture);
    return image;
  }

  bool isWanted(uint32_t slot) const {
    const bool alphaDecides = (out_.data.flags & (shared::kMaterialMasked | shared::kMaterialBlended)) != 0;
    return (slots_ >> slot & 1u) != 0 || (slot == shared::kTextureBaseColor && alphaDecides);
  }

  void fill(uint32_t slot, const Reference& reference, const TextureRequest& request) {
    if (!isWanted(slot)) return;
    const tinygltf::Texture& texture = document_.model.textures[size_t(reference.texture)];
    out_.slots[slot] = {textures_.request(request), samplerOf(document_.model, texture.sampler)};
    out_.data.textures |= 1u << slot;
    setTransform(out_.data.transforms[slot], reference);
    parts_.transforms[slot] = partsOf(reference);
  }

  void readSurface() {
    shared::Material& data = out_.data;
    for (int i = 0; i < 3; ++i) parts_.emissive[i] = data.emissive[i] = float(source_->emissiveFactor[size_t(i)]);
    data.normalScale = float(source_->normalTexture.scale);
    data.occlusionStrength = std::clamp(float(source_->occlusionTexture.strength), 0.0f, 1.0f);
    slot(shared::kTextureNormal, referenceTo(source_->normalTexture), false);
    slot(shared::kTextureOcclusion, referenceTo(source_->occlusionTexture), false);
    slot(shared::kTextureEmissive, referenceTo(source_->emissiveTexture), true);
    if (source_->doubleSided) data.flags |= shared::kMaterialDoubleSided;
  }

  void readMetallicRoughness() {
    shared::Material& data = out_.data;
    const tinygltf::PbrMetallicRoughness& pbr = source_->pbrMetallicRoughness;
    for (int i = 0; i < 4; ++i) data.baseColor[i] = float(pbr.baseColorFactor[size_t(i)]);
    data.metallic = std::clamp(float(pbr.metallicFactor), 0.0f, 1.0f);
    data.roughness = std::clamp(float(pbr.roughnessFactor), 0.0f, 1.0f);
    slot(shared::kTextureBaseColor, referenceTo(pbr.baseColorTexture), true);
    slot(shared::kTextureMetallicRoughness, referenceTo(pbr.metallicRoughnessTexture), false);
    if (const Value* e = extension(source_->extensions, "KHR_materials_ior"))
      data.f0 = f0OfIor(float(numberOr(*e, "ior", 1.5)));
    if (const Value* e = extension(source_->extensions, "KHR_materials_specular")) {
      data.specular = float(numberOr(*e, "specularFactor", 1));
      for (int i = 0; i < 3; ++i) data.specularColor[i] = float(elementOr(*e, "specularColorFactor", size_t(i), 1));
      slot(shared::kTextureSpecular, referenceTo(e->Get("specularTexture")), false);
      slot(shared::kTextureSpecularColor, referenceTo(e->Get("specularColorTexture")), true);
    }
  }

  // Maps specular-glossiness to a dielectric: base color is c_diff attenuated by the specular color, F0 comes from an
  // index of refraction of 0 with that specular color, and roughness is 1 - glossiness.
  void readSpecularGlossiness(const Value& e) {
    shared::Material& data = out_.data;
    std::array<float, 3> specular;
    for (size_t i = 0; i < 3; ++i)
      specular[i] = data.specularColor[int(i)] = float(elementOr(e, "specularFactor", i, 1));
    const auto glossiness = float(numberOr(e, "glossinessFactor", 1));
    for (int i = 0; i < 4; ++i) data.baseColor[i] = float(elementOr(e, "diffuseFactor", size_t(i), 1));
    data.metallic = 0;
    data.roughness = std::clamp(1 - glossiness, 0.0f, 1.0f);
    data.f0 = f0OfIor(0);
    const Reference diffuse = referenceTo(e.Get("diffuseTexture"));
    const Reference both = referenceTo(e.Get("specularGlossinessTexture"));
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
         {.make = TextureRequest::Make::Roughness, .specular = specularImage, .factor = {glossiness, 0, 0}});
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
      data.alphaCutoff = float(source_->alphaCutoff);
    } else if (source_->alphaMode == "BLEND") {
      data.flags |= shared::kMaterialBlended;
    } else if (source_->alphaMode != "OPAQUE") {
      badInput("a material has the unknown alphaMode \"{}\"", source_->alphaMode);
    }
  }

  void readExtensions() {
    shared::Material& data = out_.data;
    if (extension(source_->extensions, "KHR_materials_unlit")) data.flags |= shared::kMaterialUnlit;
    if (const Value* e = extension(source_->extensions, "KHR_materials_emissive_strength"))
      data.emissive *= parts_.emissiveStrength = float(numberOr(*e, "emissiveStrength", 1));
    readCoats();
    readReflection();
    readTransmission();
  }

  const Value* layer(const char* name) const { return extension(source_->extensions, name); }

  static void colorInto(vec3& color, const Value& object, const char* key) {
    for (int i = 0; i < 3; ++i) color[i] = float(elementOr(object, key, size_t(i), color[i]));
  }

  void readCoats() {
    shared::MaterialLayers& l = out_.data.layers;
    if (const Value* e = layer("KHR_materials_clearcoat")) {
      l.clearcoat = float(numberOr(*e, "clearcoatFactor", 0));
      l.clearcoatRoughness = float(numberOr(*e, "clearcoatRoughnessFactor", 0));
      const Value& normal = e->Get("clearcoatNormalTexture");
      if (normal.IsObject()) l.clearcoatNormalScale = float(numberOr(normal, "scale", 1));
      slot(shared::kTextureClearcoat, referenceTo(e->Get("clearcoatTexture")), false);
      slot(shared::kTextureClearcoatRoughness, referenceTo(e->Get("clearcoatRoughnessTexture")), false);
      slot(shared::kTextureClearcoatNormal, referenceTo(normal), false);
    }
    if (const Value* e = layer("KHR_materials_sheen")) {
      colorInto(l.sheenColor, *e, "sheenColorFactor");
      l.sheenRoughness = float(numberOr(*e, "sheenRoughnessFactor", 0));
      slot(shared::kTextureSheenColor, referenceTo(e->Get("sheenColorTexture")), true);
      slot(shared::kTextureSheenRoughness, referenceTo(e->Get("sheenRoughnessTexture")), false);
    }
  }

  void readReflection() {
    shared::MaterialLayers& l = out_.data.layers;
    if (const Value* e = layer("KHR_materials_anisotropy")) {
      l.anisotropy = float(numberOr(*e, "anisotropyStrength", 0));
      l.anisotropyRotation = float(numberOr(*e, "anisotropyRotation", 0));
      slot(shared::kTextureAnisotropy, referenceTo(e->Get("anisotropyTexture")), false);
    }
    if (const Value* e = layer("KHR_materials_iridescence")) {
      l.iridescence = float(numberOr(*e, "iridescenceFactor", 0));
      l.iridescenceIor = float(numberOr(*e, "iridescenceIor", l.iridescenceIor));
      l.iridescenceThinnest = float(numberOr(*e, "iridescenceThicknessMinimum", l.iridescenceThinnest));
      l.iridescenceThickest = float(numberOr(*e, "iridescenceThicknessMaximum", l.iridescenceThickest));
      slot(shared::kTextureIridescence, referenceTo(e->Get("iridescenceTexture")), false);
      slot(shared::kTextureIridescenceThickness, referenceTo(e->Get("iridescenceThicknessTexture")), false);
    }
  }

  void readTransmission() {
    shared::MaterialLayers& l = out_.data.layers;
    if (const Value* e = layer("KHR_materials_transmission")) {
      l.transmission = float(numberOr(*e, "transmissionFactor", 0));
      slot(shared::kTextureTransmission, referenceTo(e->Get("transmissionTexture")), false);
    }
    if (const Value* e = layer("KHR_materials_volume")) {
      l.thickness = float(numberOr(*e, "thicknessFactor", 0));
      l.attenuationDistance = float(numberOr(*e, "attenuationDistance", 0));
      colorInto(l.attenuationColor, *e, "attenuationColor");
      slot(shared::kTextureThickness, referenceTo(e->Get("thicknessTexture")), false);
    }
    if (const Value* e = layer("KHR_materials_dispersion")) l.dispersion = float(numberOr(*e, "dispersion", 0));
    if (const Value* e = layer("KHR_materials_diffuse_transmission")) {
      l.diffuseTransmission = float(numberOr(*e, "diffuseTransmissionFactor", 0));
      colorInto(l.diffuseTransmissionColor, *e, "diffuseTransmissionColorFactor");
      slot(shared::kTextureDiffuseTransmission, referenceTo(e->Get("diffuseTransmissionTexture")), false);
      slot(shared::kTextureDiffuseTransmissionColor, referenceTo(e->Get("diffuseTransmissionColorTexture")), true);
    }
  }

  const Document& document_;
  const uint32_t slots_;
  TextureTable& textures_;
  const tinygltf::Material* source_ = nullptr;
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

int readVariants(const Document& document, const std::string& wanted, Scene& scene) {
  if (const Value* object = extension(document.model.extensions, "KHR_materials_variants")) {
    const Value& variants = object->Get("variants");
    for (size_t i = 0; variants.IsArray() && i < variants.ArrayLen(); ++i) {
      const Value& name = variants.Get(int(i)).Get("name");
      scene.variants.push_back(name.IsString() ? name.Get<std::string>() : "");
    }
  }
  if (wanted.empty()) return -1;
  auto found = std::find(scene.variants.begin(), scene.variants.end(), wanted);
  if (found != scene.variants.end()) return int(found - scene.variants.begin());
  if (scene.variants.empty()) badUsage("there is no variant \"{}\": the file has no material variants", wanted);
  badUsage("there is no variant \"{}\": the file has {}", wanted, fmt::join(scene.variants, ", "));
}

int materialOf(const tinygltf::Primitive& primitive, int variant) {
  const Value* object = extension(primitive.extensions, "KHR_materials_variants");
  if (variant < 0 || !object) return primitive.material;
  const Value& mappings = object->Get("mappings");
  for (size_t i = 0; mappings.IsArray() && i < mappings.ArrayLen(); ++i) {
    const Value& mapping = mappings.Get(int(i));
    const Value& variants = mapping.Get("variants");
    for (size_t v = 0; variants.IsArray() && v < variants.ArrayLen(); ++v)
      if (variants.Get(int(v)).IsInt() && variants.Get(int(v)).Get<int>() == variant)
        return indexOr(mapping, "material", primitive.material);
  }
  return primitive.material;
}

}  // namespace latelight::scene::gltf
