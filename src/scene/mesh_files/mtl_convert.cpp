// Converts MTL's materials to the metallic-roughness model.
//
// MTL's Phong model (illum 2) becomes a dielectric: Kd is its base color. The exponent Ns of the highlight becomes the
// roughness whose GGX lobe is about as wide: alpha^2 = 2 / (Ns + 2) (Walter et al., "Microfacet Models for Refraction
// through Rough Surfaces", 2007, section 5.2, for Phong and Beckmann), and roughness^2 = alpha. Ks is the strength of a
// highlight rather than a reflectance, because Phong's lobe is not normalized; a Ks of 0.5 becomes glTF's reflectance
// at normal incidence, 0.04, as Blender writes and reads it. The keys Pr, Pm, Ps, Pc, Pcr, aniso and anisor replace
// these.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/log.h"
#include "scene/mesh_files/mtl.h"

namespace latelight::scene::mesh_files {
namespace {

using Make = ImageRequest::Make;

constexpr float kNeutralSpecular = 0.5f;  // the Ks of a reflectance of 0.04

class Converter {
 public:
  Converter(const MtlMaterial& source, const LoadOptions& options, Images& images)
      : source_(source), options_(options), images_(images) {
    if (!options.textures) return;
    for (auto& [key, map] : source_.maps) map.image.file = images.locate(map.image.file, source.folder);
  }

  Material run() {
    setFactors();
    setCoats();
    if (options_.textures) addTextures();
    return std::move(out_);
  }

 private:
  void setFactors() {
    shared::Material& data = out_.data;
    // A map without Kd shows the map; neither one shows the default's gray.
    const vec3 diffuse = source_.diffuse.value_or(vec3(source_.maps.contains("kd") ? 1 : 0.8f));
    data.baseColor = vec4(glm::min(diffuse, vec3(1)), source_.alpha);
    if (source_.alpha < 1) data.flags |= shared::kMaterialBlended;
    if (source_.illumination == 0) data.flags |= shared::kMaterialUnlit;
    data.metallic = source_.metallic.value_or(source_.maps.contains("pm") ? 1 : 0);
    data.roughness = source_.roughness.value_or(source_.maps.contains("pr") ? 1 : roughnessOfPhong());
    if (source_.specular && source_.illumination >= 2) data.specularColor = *source_.specular / kNeutralSpecular;
    if (source_.illumination == 1 && !source_.roughness && !source_.metallic) data.specularColor = vec3(0);
    data.emissive = source_.emissive.value_or(vec3(source_.maps.contains("ke") ? 1 : 0));
  }

  float roughnessOfPhong() const {
    if (source_.illumination == 1) return 1;
    return source_.exponent ? std::pow(2 / (*source_.exponent + 2), 0.25f) : 0.5f;
  }

  void setCoats() {
    shared::MaterialLayers& l = out_.data.layers;
    l.clearcoat = source_.clearcoat;
    l.clearcoatRoughness = source_.clearcoatRoughness;
    l.sheenColor = vec3(source_.sheen);
    if (source_.sheen > 0) l.sheenRoughness = 0.3f;  // MTL has none
    l.anisotropy = source_.anisotropy;
    l.anisotropyRotation = source_.anisotropyRotation * 2 * std::numbers::pi_v<float>;
  }

  // --- textures -----------------------------------------------------------------------------------------------------

  // Returns the map under one of the keys, if its image exists.
  const MtlMap* find(std::initializer_list<std::string_view> keys) const {
    for (const std::string_view key : keys)
      if (const auto map = source_.maps.find(key); map != source_.maps.end())
        return images_.isReadable(map->second.image.file) ? &map->second : nullptr;
    return nullptr;
  }

  bool isRequested(uint32_t slot) const {
    const bool alphaDecides = slot == shared::kTextureBaseColor && (out_.data.flags & shared::kMaterialBlended) != 0;
    return alphaDecides || (options_.textureSlots >> slot & 1u) != 0;
  }

  void fill(uint32_t slot, const MtlMap& map, const ImageRequest& request) {
    if (!isRequested(slot)) return;
    out_.slots[slot].texture = images_.request(request);
    if (map.clamp) out_.slots[slot].sampler.wrapU = out_.slots[slot].sampler.wrapV = Wrap::Clamp;
    out_.data.textures |= 1u << slot;
    // MTL's v points up: 1 - ((1 - v) s + o) = v s + (1 - s - o).
    const auto &s = map.scale, &o = map.offset;
    out_.data.transforms[slot] = {vec3(s[0], 0, o[0]), vec3(0, s[1], 1 - s[1] - o[1]), 0};
  }

  // A texture that is combined from two maps has one transform and one sampler: those of the map that `fill()` gets.
  void warnIfDifferent(const MtlMap& used, const MtlMap& other, const char* usedKey, const char* otherKey) const {
    if (used.scale == other.scale && used.offset == other.offset && used.clamp == other.clamp) return;
    warn("the material {} has {} and {} with different -s, -o or -clamp: those of {} are used for both", source_.name,
         usedKey, otherKey, usedKey);
  }

  // -mm of a color map that only scales it multiplies the factor.
  void addColor(uint32_t slot, const MtlMap& map, float& red, float& green, float& blue) {
    for (float* channel : {&red, &green, &blue}) *channel *= map.image.gain;
    fill(slot, map, {.first = {.file = map.image.file}, .srgb = true});
  }

  void addBaseColor() {
    vec4& factor = out_.data.baseColor;
    const MtlMap *color = find({"kd"}), *alpha = find({"d"});
    if (alpha) {
      out_.data.flags |= shared::kMaterialBlended;
      ImageRequest request;
      request.make = Make::ColorWithAlpha;
      request.second = alpha->image;
      request.srgb = true;
      if (color) {
        request.first.file = color->image.file;
        warnIfDifferent(*color, *alpha, "map_Kd", "map_d");
      }
      fill(shared::kTextureBaseColor, color ? *color : *alpha, request);
    } else if (color) {
      addColor(shared::kTextureBaseColor, *color, factor.r, factor.g, factor.b);
    }
  }

  void addRoughnessMetallic() {
    const MtlMap *roughness = find({"pr"}), *metallic = find({"pm"});
    if (!roughness && !metallic) return;
    ImageRequest request;
    request.make = Make::RoughnessMetallic;
    if (roughness) request.first = roughness->image;
    if (metallic) request.second = metallic->image;
    if (roughness && metallic) warnIfDifferent(*roughness, *metallic, "map_Pr", "map_Pm");
    fill(shared::kTextureMetallicRoughness, roughness ? *roughness : *metallic, request);
  }

  void addNormal() {
    if (const MtlMap* map = find({"norm"})) {
      out_.data.normalScale = map->bump;
      fill(shared::kTextureNormal, *map, {.first = {.file = map->image.file}});
    } else if (const MtlMap* bump = find({"bump"})) {
      fill(shared::kTextureNormal, *bump, {.make = Make::NormalsFromHeights, .first = bump->image, .bump = bump->bump});
    }
  }

  void addTextures() {
    addBaseColor();
    addRoughnessMetallic();
    addNormal();
    vec3& emissive = out_.data.emissive;
    if (const MtlMap* map = find({"ke"})) addColor(shared::kTextureEmissive, *map, emissive.r, emissive.g, emissive.b);
    if (const MtlMap* map = find({"ks"}); map && source_.illumination >= 2) {
      vec3& specular = out_.data.specularColor;
      addColor(shared::kTextureSpecularColor, *map, specular.r, specular.g, specular.b);
    }
    if (const MtlMap* map = find({"ps"})) {
      vec3& sheen = out_.data.layers.sheenColor;
      if (sheen == vec3(0)) sheen = vec3(1);
      addColor(shared::kTextureSheenColor, *map, sheen.r, sheen.g, sheen.b);
    }
    if (const MtlMap* map = find({"pc"})) addScalar(shared::kTextureClearcoat, *map, out_.data.layers.clearcoat);
    if (const MtlMap* map = find({"pcr"}))
      addScalar(shared::kTextureClearcoatRoughness, *map, out_.data.layers.clearcoatRoughness);
  }

  void addScalar(uint32_t slot, const MtlMap& map, float& factor) {
    if (factor == 0) factor = 1;
    fill(slot, map, {.make = Make::ScalarInRed, .first = map.image});
  }

  MtlMaterial source_;  // with the names of images relative to the OBJ file's folder
  const LoadOptions& options_;
  Images& images_;
  Material out_ = plainMaterial(source_.name, vec3(0.8f), 0, 0.5f);
};

}  // namespace

Material convert(const MtlMaterial& source, const LoadOptions& options, Images& images) {
  return Converter(source, options, images).run();
}

}  // namespace latelight::scene::mesh_files
