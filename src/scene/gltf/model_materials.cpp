// Reads the materials, textures and samplers of validated glTF JSON.
#include "scene/gltf/model_materials.h"

#include "scene/gltf/extensions.h"
#include "scene/gltf/json.h"

namespace latelight::scene::gltf::file {
namespace {

using nlohmann::json;

void read(const json& object, const char* key, float& value) {
  value = object.value(key, value);
}

template <int N>
void read(const json& object, const char* key, glm::vec<N, float>& value) {
  value = vectorIn(object, key, value);
}

void read(const json& object, const char* key, TextureInfo& info) {
  const json* source = findProperty(object, key);
  if (!source) return;
  info.texture = (*source)["index"].get<int>();
  info.texCoord = source->value("texCoord", info.texCoord);
  const json* transform = findExtension(*source, "KHR_texture_transform");
  if (!transform) return;
  info.texCoord = transform->value("texCoord", info.texCoord);
  read(*transform, "offset", info.transform.offset);
  read(*transform, "rotation", info.transform.rotation);
  read(*transform, "scale", info.transform.scale);
}

// Reads a number of a texture reference, such as "scale" of "normalTexture".
void read(const json& object, const char* texture, const char* key, float& value) {
  if (const json* source = findProperty(object, texture)) read(*source, key, value);
}

MetallicRoughness readMetallicRoughness(const json& source) {
  MetallicRoughness out;
  read(source, "baseColorFactor", out.baseColorFactor);
  read(source, "metallicFactor", out.metallicFactor);
  read(source, "roughnessFactor", out.roughnessFactor);
  read(source, "baseColorTexture", out.baseColorTexture);
  read(source, "metallicRoughnessTexture", out.metallicRoughnessTexture);
  return out;
}

SpecularGlossiness readSpecularGlossiness(const json& source) {
  SpecularGlossiness out;
  read(source, "diffuseFactor", out.diffuseFactor);
  read(source, "specularFactor", out.specularFactor);
  read(source, "glossinessFactor", out.glossinessFactor);
  read(source, "diffuseTexture", out.diffuseTexture);
  read(source, "specularGlossinessTexture", out.specularGlossinessTexture);
  return out;
}

Specular readSpecular(const json& source) {
  Specular out;
  read(source, "specularFactor", out.specularFactor);
  read(source, "specularColorFactor", out.specularColorFactor);
  read(source, "specularTexture", out.specularTexture);
  read(source, "specularColorTexture", out.specularColorTexture);
  return out;
}

Clearcoat readClearcoat(const json& source) {
  Clearcoat out;
  read(source, "clearcoatFactor", out.clearcoatFactor);
  read(source, "clearcoatRoughnessFactor", out.clearcoatRoughnessFactor);
  read(source, "clearcoatTexture", out.clearcoatTexture);
  read(source, "clearcoatRoughnessTexture", out.clearcoatRoughnessTexture);
  read(source, "clearcoatNormalTexture", out.clearcoatNormalTexture);
  read(source, "clearcoatNormalTexture", "scale", out.clearcoatNormalScale);
  return out;
}

Sheen readSheen(const json& source) {
  Sheen out;
  read(source, "sheenColorFactor", out.sheenColorFactor);
  read(source, "sheenRoughnessFactor", out.sheenRoughnessFactor);
  read(source, "sheenColorTexture", out.sheenColorTexture);
  read(source, "sheenRoughnessTexture", out.sheenRoughnessTexture);
  return out;
}

Anisotropy readAnisotropy(const json& source) {
  Anisotropy out;
  read(source, "anisotropyStrength", out.anisotropyStrength);
  read(source, "anisotropyRotation", out.anisotropyRotation);
  read(source, "anisotropyTexture", out.anisotropyTexture);
  return out;
}

Iridescence readIridescence(const json& source) {
  Iridescence out;
  read(source, "iridescenceFactor", out.iridescenceFactor);
  read(source, "iridescenceIor", out.iridescenceIor);
  read(source, "iridescenceThicknessMinimum", out.iridescenceThicknessMinimum);
  read(source, "iridescenceThicknessMaximum", out.iridescenceThicknessMaximum);
  read(source, "iridescenceTexture", out.iridescenceTexture);
  read(source, "iridescenceThicknessTexture", out.iridescenceThicknessTexture);
  return out;
}

Transmission readTransmission(const json& source) {
  Transmission out;
  read(source, "transmissionFactor", out.transmissionFactor);
  read(source, "transmissionTexture", out.transmissionTexture);
  return out;
}

Volume readVolume(const json& source) {
  Volume out;
  read(source, "thicknessFactor", out.thicknessFactor);
  read(source, "attenuationDistance", out.attenuationDistance);
  read(source, "attenuationColor", out.attenuationColor);
  read(source, "thicknessTexture", out.thicknessTexture);
  return out;
}

DiffuseTransmission readDiffuseTransmission(const json& source) {
  DiffuseTransmission out;
  read(source, "diffuseTransmissionFactor", out.diffuseTransmissionFactor);
  read(source, "diffuseTransmissionColorFactor", out.diffuseTransmissionColorFactor);
  read(source, "diffuseTransmissionTexture", out.diffuseTransmissionTexture);
  read(source, "diffuseTransmissionColorTexture", out.diffuseTransmissionColorTexture);
  return out;
}

void readExtensions(const json& source, Material& out) {
  const auto find = [&](const char* name) { return findExtension(source, name); };
  out.unlit = find("KHR_materials_unlit") != nullptr;
  if (const json* e = find("KHR_materials_emissive_strength")) read(*e, "emissiveStrength", out.emissiveStrength);
  if (const json* e = find("KHR_materials_ior")) read(*e, "ior", out.ior);
  if (const json* e = find("KHR_materials_dispersion")) read(*e, "dispersion", out.dispersion);
  if (const json* e = find("KHR_materials_pbrSpecularGlossiness")) out.specularGlossiness = readSpecularGlossiness(*e);
  if (const json* e = find("KHR_materials_specular")) out.specular = readSpecular(*e);
  if (const json* e = find("KHR_materials_clearcoat")) out.clearcoat = readClearcoat(*e);
  if (const json* e = find("KHR_materials_sheen")) out.sheen = readSheen(*e);
  if (const json* e = find("KHR_materials_anisotropy")) out.anisotropy = readAnisotropy(*e);
  if (const json* e = find("KHR_materials_iridescence")) out.iridescence = readIridescence(*e);
  if (const json* e = find("KHR_materials_transmission")) out.transmission = readTransmission(*e);
  if (const json* e = find("KHR_materials_volume")) out.volume = readVolume(*e);
  if (const json* e = find("KHR_materials_diffuse_transmission")) out.diffuseTransmission = readDiffuseTransmission(*e);
}

}  // namespace

Sampler readSampler(const json& source, size_t) {
  Sampler sampler;
  sampler.magFilter = source.value("magFilter", sampler.magFilter);
  sampler.minFilter = source.value("minFilter", sampler.minFilter);
  sampler.wrapS = source.value("wrapS", sampler.wrapS);
  sampler.wrapT = source.value("wrapT", sampler.wrapT);
  return sampler;
}

Texture readTexture(const json& source, size_t) {
  Texture texture{.sampler = source.value("sampler", -1), .image = source.value("source", -1)};
  for (const char* name : {"EXT_texture_avif", "KHR_texture_basisu", "EXT_texture_webp"}) {  // the last one wins
    if (name == std::string_view("EXT_texture_avif") && !kReadsAvif) continue;
    if (const json* other = findExtension(source, name)) texture.image = other->value("source", texture.image);
  }
  return texture;
}

Material readMaterial(const json& source, size_t) {
  Material material;
  material.name = source.value("name", material.name);
  material.alphaMode = source.value("alphaMode", material.alphaMode);
  material.doubleSided = source.value("doubleSided", material.doubleSided);
  read(source, "alphaCutoff", material.alphaCutoff);
  read(source, "emissiveFactor", material.emissiveFactor);
  read(source, "normalTexture", material.normalTexture);
  read(source, "normalTexture", "scale", material.normalScale);
  read(source, "occlusionTexture", material.occlusionTexture);
  read(source, "occlusionTexture", "strength", material.occlusionStrength);
  read(source, "emissiveTexture", material.emissiveTexture);
  if (const json* pbr = findProperty(source, "pbrMetallicRoughness"))
    material.metallicRoughness = readMetallicRoughness(*pbr);
  readExtensions(source, material);
  return material;
}

}  // namespace latelight::scene::gltf::file
