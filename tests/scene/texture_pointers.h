// The location of each slot's texture in a glTF material, as JSON pointers relative to the material.
#pragma once

#include <iterator>
#include <string>

#include "shared/types.h"

namespace latelight::scene::test {

inline const std::string kTexturePointers[] = {
    "/pbrMetallicRoughness/baseColorTexture",
    "/pbrMetallicRoughness/metallicRoughnessTexture",
    "/normalTexture",
    "/occlusionTexture",
    "/emissiveTexture",
    "/extensions/KHR_materials_specular/specularTexture",
    "/extensions/KHR_materials_specular/specularColorTexture",
    "/extensions/KHR_materials_clearcoat/clearcoatTexture",
    "/extensions/KHR_materials_clearcoat/clearcoatRoughnessTexture",
    "/extensions/KHR_materials_clearcoat/clearcoatNormalTexture",
    "/extensions/KHR_materials_sheen/sheenColorTexture",
    "/extensions/KHR_materials_sheen/sheenRoughnessTexture",
    "/extensions/KHR_materials_anisotropy/anisotropyTexture",
    "/extensions/KHR_materials_iridescence/iridescenceTexture",
    "/extensions/KHR_materials_iridescence/iridescenceThicknessTexture",
    "/extensions/KHR_materials_transmission/transmissionTexture",
    "/extensions/KHR_materials_volume/thicknessTexture",
    "/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionTexture",
    "/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorTexture"};
static_assert(std::size(kTexturePointers) == shared::kTextureCount);

}  // namespace latelight::scene::test
