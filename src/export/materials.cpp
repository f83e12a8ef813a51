// Converts materials back to glTF's properties. Only values that differ from glTF's defaults are written, so a plain
// material needs no extension. Images are PNG files of the largest mip level.
#include "export/materials.h"

#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <unordered_map>
#include <unordered_set>

#include "base/hash.h"
#include "output/png.h"
#include "scene/color_slots.h"
#include "shared/color.h"

namespace latelight::exports {
namespace {

using namespace scene;
namespace sh = shared;

constexpr const char* kSpecular = "KHR_materials_specular";
constexpr const char* kClearcoat = "KHR_materials_clearcoat";
constexpr const char* kSheen = "KHR_materials_sheen";
constexpr const char* kAnisotropy = "KHR_materials_anisotropy";
constexpr const char* kIridescence = "KHR_materials_iridescence";
constexpr const char* kTransmission = "KHR_materials_transmission";
constexpr const char* kVolume = "KHR_materials_volume";
constexpr const char* kDiffuse = "KHR_materials_diffuse_transmission";

// The place of each texture in a material: its extension, or null, and its key. In the order of the slots.
struct Place {
  const char* extension;
  const char* key;
};
constexpr Place kPlaces[] = {{nullptr, "baseColorTexture"},
                             {nullptr, "metallicRoughnessTexture"},
                             {nullptr, "normalTexture"},
                             {nullptr, "occlusionTexture"},
                             {nullptr, "emissiveTexture"},
                             {kSpecular, "specularTexture"},
                             {kSpecular, "specularColorTexture"},
                             {kClearcoat, "clearcoatTexture"},
                             {kClearcoat, "clearcoatRoughnessTexture"},
                             {kClearcoat, "clearcoatNormalTexture"},
                             {kSheen, "sheenColorTexture"},
                             {kSheen, "sheenRoughnessTexture"},
                             {kAnisotropy, "anisotropyTexture"},
                             {kIridescence, "iridescenceTexture"},
                             {kIridescence, "iridescenceThicknessTexture"},
                             {kTransmission, "transmissionTexture"},
                             {kVolume, "thicknessTexture"},
                             {kDiffuse, "diffuseTransmissionTexture"},
                             {kDiffuse, "diffuseTransmissionColorTexture"}};
static_assert(std::size(kPlaces) == sh::kTextureCount);

// Returns the parameters of a transform that is a scale, a rotation and an offset, as all transforms of files are.
TransformParts partsOf(const sh::TextureTransform& t) {
  TransformParts parts{.offset = {t.row0.z, t.row1.z}};
  if (t.row0.y == 0 && t.row1.x == 0) {
    parts.scale = {t.row0.x, t.row1.y};
    return parts;
  }
  // A scale of 0 along X leaves only the second column, which is the rotated Y axis.
  const bool isFlat = t.row0.x == 0 && t.row1.x == 0;
  const double angle =
      isFlat ? std::atan2(double{t.row0.y}, double{t.row1.y}) : std::atan2(-double{t.row1.x}, double{t.row0.x});
  parts.rotation = float(angle);
  parts.scale.x = float(std::hypot(t.row0.x, t.row1.x));
  parts.scale.y = float(std::sin(angle) * double{t.row0.y} + std::cos(angle) * double{t.row1.y});
  return parts;
}

class MaterialWriter {
 public:
  MaterialWriter(const Scene& scene, Document& document) : scene_(scene), document_(document) {}

  Json write(uint32_t index) {
    const Material& material = scene_.materials[index];
    material_ = &material;
    const auto animated = scene_.rig.materials.find(index);
    parts_ = animated == scene_.rig.materials.end() ? nullptr : &animated->second;
    out_ = Json::object();
    if (!material.name.empty()) out_["name"] = material.name;
    writeSurface();
    writeAlpha();
    writeReflectance();
    writeCoats();
    writeTransmission();
    for (uint32_t slot = 0; slot < sh::kTextureCount; ++slot) writeTexture(slot);
    return std::move(out_);
  }

 private:
  const sh::Material& data() const { return material_->data; }

  void set(Json& object, const char* key, float value, float otherwise) {
    if (value != otherwise) object[key] = shortest(value);
  }
  void set(const char* extension, const char* key, float value, float otherwise) {
    if (value != otherwise) document_.extension(out_, extension)[key] = shortest(value);
  }
  void set(const char* extension, const char* key, const vec3& value, const vec3& otherwise) {
    if (value != otherwise) document_.extension(out_, extension)[key] = arrayOf(value);
  }

  void writeSurface() {
    Json& pbr = out_["pbrMetallicRoughness"] = Json::object();
    if (data().baseColor != vec4(1)) pbr["baseColorFactor"] = arrayOf(glm::clamp(data().baseColor, 0.0f, 1.0f));
    set(pbr, "metallicFactor", data().metallic, 1);
    set(pbr, "roughnessFactor", data().roughness, 1);
    if (parts_) {
      if (parts_->emissive != vec3(0)) out_["emissiveFactor"] = arrayOf(parts_->emissive);
      set("KHR_materials_emissive_strength", "emissiveStrength", parts_->emissiveStrength, 1);
      return;
    }
    if (data().emissive == vec3(0)) return;
    // The strength is a power of two, so that the product is exactly the radiance.
    const float largest = std::max({data().emissive.x, data().emissive.y, data().emissive.z});
    const float strength = largest > 1 ? std::exp2(std::ceil(std::log2(largest))) : 1;
    out_["emissiveFactor"] = arrayOf(data().emissive / strength);
    set("KHR_materials_emissive_strength", "emissiveStrength", strength, 1);
  }

  void writeAlpha() {
    const uint32_t flags = data().flags;
    if (flags & sh::kMaterialMasked) {
      out_["alphaMode"] = "MASK";
      set(out_, "alphaCutoff", data().alphaCutoff, 0.5f);
    } else if (flags & sh::kMaterialBlended) {
      out_["alphaMode"] = "BLEND";
    }
    if (flags & sh::kMaterialDoubleSided) out_["doubleSided"] = true;
    if (flags & sh::kMaterialUnlit) document_.extension(out_, "KHR_materials_unlit") = Json::object();
  }

  void writeReflectance() {
    if (data().f0 != f0OfIor(1.5f)) {
      const double root = std::sqrt(double{data().f0});
      const float ior = data().f0 >= 1 ? 0 : float((1 + root) / (1 - root));
      document_.extension(out_, "KHR_materials_ior")["ior"] = shortest(ior);
    }
    set(kSpecular, "specularFactor", data().specular, 1);
    set(kSpecular, "specularColorFactor", data().specularColor, vec3(1));
  }

  void writeCoats() {
    const sh::MaterialLayers& l = data().layers;
    set(kClearcoat, "clearcoatFactor", l.clearcoat, 0);
    set(kClearcoat, "clearcoatRoughnessFactor", l.clearcoatRoughness, 0);
    set(kSheen, "sheenColorFactor", l.sheenColor, vec3(0));
    set(kSheen, "sheenRoughnessFactor", l.sheenRoughness, 0);
    set(kAnisotropy, "anisotropyStrength", l.anisotropy, 0);
    set(kAnisotropy, "anisotropyRotation", l.anisotropyRotation, 0);
    set(kIridescence, "iridescenceFactor", l.iridescence, 0);
    set(kIridescence, "iridescenceIor", l.iridescenceIor, 1.3f);
    set(kIridescence, "iridescenceThicknessMinimum", l.iridescenceThinnest, 100);
    set(kIridescence, "iridescenceThicknessMaximum", l.iridescenceThickest, 400);
  }

  void writeTransmission() {
    const sh::MaterialLayers& l = data().layers;
    set(kTransmission, "transmissionFactor", l.transmission, 0);
    set(kVolume, "thicknessFactor", l.thickness, 0);
    set(kVolume, "attenuationDistance", l.attenuationDistance, 0);
    set(kVolume, "attenuationColor", l.attenuationColor, vec3(1));
    set("KHR_materials_dispersion", "dispersion", l.dispersion, 0);
    set(kDiffuse, "diffuseTransmissionFactor", l.diffuseTransmission, 0);
    set(kDiffuse, "diffuseTransmissionColorFactor", l.diffuseTransmissionColor, vec3(1));
  }

  // --- textures -----------------------------------------------------------------------------------------------------

  void writeTexture(uint32_t slot) {
    const TextureSlot& source = material_->slots[slot];
    if (source.texture < 0 || !(data().textures & 1u << slot)) return;
    Json info{{"index", textureOf(source, isColorSlot(slot))}};
    if (slot == sh::kTextureNormal) set(info, "scale", data().normalScale, 1);
    if (slot == sh::kTextureClearcoatNormal) set(info, "scale", data().layers.clearcoatNormalScale, 1);
    if (slot == sh::kTextureOcclusion) set(info, "strength", data().occlusionStrength, 1);
    const sh::TextureTransform& transform = data().transforms[slot];
    if (transform.uvSet != 0) info["texCoord"] = transform.uvSet;
    writeTransform(parts_ ? parts_->transforms[slot] : partsOf(transform), info);
    const Place& place = kPlaces[slot];
    const bool isPbr = slot == sh::kTextureBaseColor || slot == sh::kTextureMetallicRoughness;
    Json& owner = place.extension ? document_.extension(out_, place.extension)
                  : isPbr         ? out_["pbrMetallicRoughness"]
                                  : out_;
    owner[place.key] = std::move(info);
  }

  void writeTransform(const TransformParts& parts, Json& info) {
    if (parts.offset == vec2(0) && parts.rotation == 0 && parts.scale == vec2(1)) return;
    Json& extension = document_.extension(info, "KHR_texture_transform");
    if (parts.offset != vec2(0)) extension["offset"] = arrayOf(parts.offset);
    set(extension, "rotation", parts.rotation, 0);
    if (parts.scale != vec2(1)) extension["scale"] = arrayOf(parts.scale);
  }

  size_t textureOf(const TextureSlot& slot, bool srgb) {
    const Sampler& s = slot.sampler;
    const auto key = std::tuple(slot.texture, srgb, s.wrapU, s.wrapV, s.magnify, s.minify, s.mip);
    const auto [known, isNew] = textures_.try_emplace(key, 0);
    if (isNew)
      known->second =
          document_.add("textures", {{"sampler", samplerOf(s)}, {"source", imageOf(size_t(slot.texture), srgb)}});
    return known->second;
  }

  size_t samplerOf(const Sampler& s) {
    constexpr std::array kWrap = {10497, 33648, 33071};  // repeat, mirror, clamp
    constexpr int kMinify[2][3] = {{9728, 9984, 9986}, {9729, 9985, 9987}};
    const auto minify = kMinify[s.minify == Filter::Linear][static_cast<size_t>(s.mip)];
    const auto key = std::tuple(s.wrapU, s.wrapV, s.magnify, s.minify, s.mip);
    const auto [known, isNew] = samplers_.try_emplace(key, 0);
    if (isNew)
      known->second = document_.add("samplers", {{"magFilter", s.magnify == Filter::Linear ? 9729 : 9728},
                                                 {"minFilter", minify},
                                                 {"wrapS", kWrap[static_cast<size_t>(s.wrapU)]},
                                                 {"wrapT", kWrap[static_cast<size_t>(s.wrapV)]}});
    return known->second;
  }

  // Textures that were decoded from one file as color and as data share an image. A texture that is used as color and
  // as data has two.
  size_t imageOf(size_t index, bool srgb) {
    const Texture& texture = scene_.textures[index];
    const int conversion = int{srgb} - int{texture.srgb};
    const auto [known, isNew] = images_.try_emplace({texture.pixels.get(), conversion}, 0);
    if (!isNew) return known->second;
    const std::vector<std::byte> png = encodeTexture(texture, srgb);
    Json image{{"bufferView", document_.addView(png)}, {"mimeType", "image/png"}};
    if (!texture.name.empty()) image["name"] = texture.name;
    return known->second = document_.add("images", std::move(image));
  }

  const Scene& scene_;
  Document& document_;
  const Material* material_ = nullptr;
  const MaterialParts* parts_ = nullptr;  // the source values of a material that animations change, or null
  Json out_;
  std::map<std::tuple<int, bool, Wrap, Wrap, Filter, Filter, MipFilter>, size_t> textures_;
  std::map<std::tuple<Wrap, Wrap, Filter, Filter, MipFilter>, size_t> samplers_;
  std::map<std::pair<const std::byte*, int>, size_t> images_;
};

}  // namespace

bool hasAlpha(const Texture& texture) {
  const size_t texels = size_t{texture.width} * texture.height;
  const std::byte* rgba = texture.pixels.get();
  for (size_t i = 0; i < texels; ++i)
    if (rgba[4 * i + 3] != std::byte{255}) return true;
  return false;
}

std::vector<std::byte> encodeTexture(const Texture& texture, bool srgb) {
  std::array<std::byte, 256> converted;
  for (size_t i = 0; i < converted.size(); ++i) {
    const float value = float(i) / 255;
    const float other = srgb == texture.srgb ? value : srgb ? sh::srgbFromLinear(value) : sh::linearFromSrgb(value);
    converted[i] = static_cast<std::byte>(std::lround(other * 255));
  }
  const size_t channels = hasAlpha(texture) ? 4 : 3;
  const std::byte* rgba = texture.pixels.get();
  std::vector<std::byte> texels(channels * texture.width * texture.height);
  for (size_t i = 0; i < texels.size(); ++i) {
    const std::byte value = rgba[i / channels * 4 + i % channels];
    texels[i] = i % channels == 3 ? value : converted[static_cast<size_t>(value)];
  }
  return output::encodePng(texture.width, texture.height, static_cast<uint32_t>(channels), 8, texels.data(),
                           srgb ? output::PngLight::Srgb : output::PngLight::Data);
}

namespace {

// Chooses the names of materials in the file, so that loading it computes the same ids (scene/ids.h). They are the
// scene's names, unless an edit has added or removed materials of equal names, or materials without a name.
class MaterialNames {
 public:
  explicit MaterialNames(const Scene& scene) : scene_(scene) {}

  // Must be called for each material that is written, in the order of the file.
  std::string nameOf(size_t index) {
    const Material& material = scene_.materials[index];
    const std::string loaded = material.name.empty() ? fmt::format("material{}", count_) : material.name;
    ++count_;
    for (unsigned attempt = 1;; ++attempt) {
      const uint32_t id = hash32(attempt == 1 ? loaded : fmt::format("{}~{}", loaded, attempt));
      if (id == material.data.id) break;
      if (ids_.contains(id)) continue;
      return renamed(index);
    }
    ids_.insert(material.data.id);
    return material.name;
  }

 private:
  // Returns a name whose hash is the material's id.
  std::string renamed(size_t index) {
    const Material& material = scene_.materials[index];
    const uint32_t id = material.data.id;
    ids_.insert(id);
    const std::string name = material.name.empty() ? fmt::format("material{}", index) : material.name;
    if (hash32(name) == id) return name;
    // Numbers are mostly in the order of the materials, so the search begins after the last one. Those of loaded
    // materials follow a tilde.
    size_t& last = numbers_.try_emplace(name, 1).first->second;
    const size_t count = scene_.materials.size() + 1;
    for (size_t i = 0; i < count; ++i) {
      const size_t number = 2 + (last - 1 + i) % count;
      for (const char* mark : {"#", "~"})
        if (std::string numbered = fmt::format("{}{}{}", name, mark, number); hash32(numbered) == id) {
          last = number;
          return numbered;
        }
    }
    return material.name;
  }

  const Scene& scene_;
  size_t count_ = 0;
  std::unordered_set<uint32_t> ids_;                 // of the materials before
  std::unordered_map<std::string, size_t> numbers_;  // the last ones by name
};

}  // namespace

std::vector<int> addMaterials(const Scene& scene, Document& document) {
  MaterialWriter writer(scene, document);
  MaterialNames names(scene);
  std::vector<int> indices(scene.materials.size(), -1);
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    if (scene.materials[i].removed) continue;
    Json material = writer.write(static_cast<uint32_t>(i));
    if (const std::string name = names.nameOf(i); !name.empty()) material["name"] = name;
    indices[i] = static_cast<int>(document.add("materials", std::move(material)));
  }
  return indices;
}

}  // namespace latelight::exports
